"""Bodies that roll and bodies that overturn, by closed forms, by heights, and by their words."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from histories import history_of, summary_of

from geometry.outline import FARTHEST, HIGHEST, LYING, Limits, Outline, limits_towards
from geometry.shapes import regular
from rockslip import Scene, parse_scene
from solver.results.rocking import no_return
from solver.types import Array

T = np.linspace(0, 1, 401)
NEVER = math.inf


def upright(low: float, high: float, height: float) -> list[tuple[float, float]]:
    """A trapezoid that stands on a side, symmetric, with these widths."""
    a, b = low / 2, high / 2
    return [(-a, 0.0), (a, 0.0), (b, height), (-b, height)]


@pytest.mark.parametrize(("width", "height"), [(0.25, 1.0), (1.0, 1.0), (2.0, 1.0)])
def test_a_rectangle_overturns_as_a_box_does(width: float, height: float) -> None:
    """Balance alpha; beyond return at 2 alpha, or at 89 degrees where it lies flat before."""
    alpha = math.atan2(width, height)
    found = Outline.of(upright(width, width, height), (0.0, height / 2)).limits()
    assert found.next_face == NEVER
    assert found.balance == pytest.approx(alpha, rel=1e-12)
    assert found.no_return == pytest.approx(float(no_return(alpha)), rel=1e-12)


@pytest.mark.parametrize("count", [3, 4, 5])
def test_regular_polygons_of_few_sides_overturn(count: int) -> None:
    """They balance on a corner half way to the next side, where they are as low as before."""
    flat = regular(count, 0.6, 1.0, 1.0)
    found = Outline.of(flat.corners, flat.centre).limits()
    turn = 2 * math.pi / count
    np.testing.assert_allclose(found, (NEVER, turn / 2, turn - LYING), rtol=1e-9)


@pytest.mark.parametrize("count", [6, 7, 8, 12, 48, 1000])
def test_regular_polygons_of_more_sides_roll(count: int) -> None:
    flat = regular(count, 0.6, 1.0, 1.0)
    found = Outline.of(flat.corners, flat.centre).limits()
    np.testing.assert_allclose(found, (math.pi / count, NEVER, NEVER), rtol=1e-9)


def test_a_cube_with_bevelled_edges_overturns() -> None:
    """It can rest on a bevel, but rises from 1 m to more than a hexagon does on the way there."""
    for bevel in (0.05, 0.2):
        near, far = 1 - bevel, 1.0
        corners = [(near, -far), (far, -near), (far, near), (near, far)]
        corners += [(-x, -y) for x, y in corners]
        found = Outline.of(corners, (0.0, 0.0)).limits()
        assert found.balance == pytest.approx(math.atan2(near, far))


def test_a_trapezoid_lies_down_on_its_slope_before_90_degrees() -> None:
    """Its slope leans by atan(0.2) from upright, outwards; it lies there without having fallen."""
    found = Outline.of(upright(1.0, 1.4, 1.0), (0.0, 0.3)).limits()
    assert found.balance == pytest.approx(math.atan2(0.5, 0.3))
    assert found.no_return == pytest.approx(math.pi / 2 - math.atan(0.2) - LYING)


def test_a_rocker_comes_back_from_far() -> None:
    """Half a cylinder on its back balances on its rim: R from its middle, 4 R/(3 pi) below."""
    turns = np.linspace(np.pi, 2 * np.pi, 62)
    places = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    found = Outline.of(places, (0.0, -4 / (3 * np.pi))).limits()
    assert found.balance == pytest.approx(math.pi / 2 + math.atan(4 / (3 * np.pi)))
    assert found.no_return > found.balance


def by_heights(corners: Array) -> Limits:
    """The same from nothing but the heights of the centre at many leans towards +x."""
    leans = np.linspace(0, 2 * np.pi, 200001)
    height = (corners @ np.stack([np.sin(leans), -np.cos(leans)])).max(axis=0)
    inner = np.arange(1, len(leans) - 1)
    rests = inner[(height[inner] < height[inner - 1]) & (height[inner] <= height[inner + 1])]
    last, balances = 0, []
    for rest in (*rests, len(leans) - 1):
        top = last + int(np.argmax(height[last : rest + 1]))
        balances.append(float(leans[top]))
        rise = height[top] / min(height[last], height[rest])
        if leans[rest] - leans[last] > FARTHEST + 1e-4 or rise > HIGHEST + 1e-6:
            down = np.flatnonzero(height[top:rest] <= height[0])
            back = leans[top + down[0]] if len(down) else NEVER
            lies = leans[rest] - LYING
            far = max(balances[-1], min(float(back), float(lies)))
            return Limits(balances[0] if last else NEVER, balances[-1], far)
        last = rest
    return Limits(balances[0], NEVER, NEVER)


@pytest.mark.parametrize("seed", range(40))
def test_limits_are_those_of_the_heights_of_the_centre(seed: int) -> None:
    """Convex polygons at random, long and round, that stand on a side below their centre."""
    random = np.random.default_rng(seed)
    turns = np.sort(random.uniform(0, 2 * np.pi, random.integers(4, 14)))
    places = np.stack([random.uniform(0.5, 1.0) * np.cos(turns), np.sin(turns)], axis=1)
    outline = Outline.of(places, random.uniform(-0.1, 0.1, 2) + places.mean(axis=0))
    rests = outline.rests()
    lean = rests[random.integers(len(rests))]
    turn = np.array([[np.cos(lean), np.sin(lean)], [-np.sin(lean), np.cos(lean)]])
    stands = Outline.of(outline.corners @ turn.T, (0.0, 0.0))
    found, expected = stands.limits(), by_heights(stands.corners)
    base = math.isinf(found.balance) and not math.isinf(expected.balance)
    if base:  # what comes next is the base again, from the other side: it has no other one
        other = Outline.of(stands.corners * [-1.0, 1.0], (0.0, 0.0))
        assert by_heights(other.corners).balance > 2 * np.pi - expected.balance - 0.1
        return
    np.testing.assert_allclose(found, expected, atol=1e-4)


def scene_of(shape: str, keys: str, dimension: int = 3) -> Scene:
    """A scene of one block."""
    return parse_scene(
        f"dimension = {dimension}\n[[block]]\nmodel = 'rigid'\nshape = {shape}\n{keys}\n"
        "density = 2000.0\n[time]\nend = 1.0\nstep = 0.01\n"
    )


DRUM = "{ regular = 48 }", "width = 0.6\nthickness = 0.9"
COLUMN = "{ cylinder = 0.6 }", "height = 1.2"


def test_a_drum_in_space_rolls_along_and_overturns_across() -> None:
    drum, column = scene_of(*DRUM).blocks[0].shape, scene_of(*COLUMN).blocks[0].shape
    across = math.atan2(0.9, 0.6 * math.cos(math.pi / 48))
    assert limits_towards(drum, (1.0, 0.0)).balance == NEVER
    assert limits_towards(drum, (0.0, 1.0)).balance == pytest.approx(across)
    # An upright cylinder leans on its rim, which has a facet along +x.
    assert limits_towards(column, (1.0, 0.0)) == pytest.approx(
        (NEVER, alpha := math.atan2(0.6 * math.cos(math.pi / 48), 1.2), 2 * alpha), rel=1e-9
    )


def told(scene: Scene, **columns: Any) -> dict[str, Any]:
    """The summary's entries of its block, which presses on the ground."""
    up = f"centre_{'xyz'[scene.dimension - 1]}_m"
    own = {up: 0.3, "normal_force_N": 100.0} | columns
    history = history_of(scene, T, **{f"block__{name}": value for name, value in own.items()})
    return summary_of(scene, history)


def turned(angle: Array, axis: str) -> dict[str, Array]:
    """Columns of a block in space that leans about one of its axes, however far."""
    known = {"angle_rad": angle} if axis == "y" else {}
    return known | {f"angle_{axis}_rad": np.angle(np.exp(1j * angle))}


@pytest.mark.parametrize(
    ("shape", "axis", "lean", "mode"),
    [
        (DRUM, "y", 20.0, "roll"),
        (DRUM, "y", -20.0, "roll"),
        (DRUM, "y", math.radians(3.0), "rest"),
        (DRUM, "x", math.radians(90), "overturned"),
        (COLUMN, "y", math.radians(90), "overturned"),
        (COLUMN, "x", math.radians(70), "overturned"),
    ],
)
def test_words_for_round_bodies_in_space(
    shape: tuple[str, str], axis: str, lean: float, mode: str
) -> None:
    """A drum rolls three times round; neither the roll nor its end is a turn about the vertical."""
    summary = told(scene_of(*shape), **turned(lean * T, axis))
    block = summary["blocks"]["block"]
    assert block["mode"] == mode
    assert (block["overturned_at_s"] is None) == (mode != "overturned")
    assert [entry["block"] for entry in summary["collapse"]] == ["block"] * (mode == "overturned")
    assert block["peak_turn_rad"] < 1e-9


@pytest.mark.parametrize(("count", "mode"), [(3, "overturned"), (5, "overturned"), (6, "roll")])
def test_words_for_polygons(count: int, mode: str) -> None:
    scene = scene_of(f"{{ regular = {count} }}", "width = 0.6", 2)
    block = told(scene, angle_rad=2 * math.pi / count * T)["blocks"]["block"]
    assert block["mode"] == mode


def test_a_body_that_rolls_flies_only_where_its_lowest_corner_does() -> None:
    """Turned by 90 degrees its first side is high up; without a force for 0.1 s it still touches.

    Lifted by 0.1 m as well, it hops.
    """
    scene = scene_of("{ regular = 12 }", "width = 0.6", 2)
    inner, push = 0.3 * math.cos(math.pi / 12), np.where(abs(T - 0.7) < 0.05, 0.0, 100.0)
    angle = np.minimum(2 * T, 1) * math.pi / 2
    corners = {}
    for lifted, mode in ((0.0, "roll"), (0.1, "roll-hop")):
        height = np.where(push > 0, inner, inner + lifted)
        for name, x in (("left", -1), ("right", 1)):
            arm = x * 0.3 * math.sin(math.pi / 12), -inner
            corners[f"gap_{name}_m"] = height + arm[1] * np.cos(angle) - arm[0] * np.sin(angle)
        motion = {"angle_rad": angle, "centre_y_m": height, "normal_force_N": push}
        assert told(scene, **motion, **corners)["blocks"]["block"]["mode"] == mode
