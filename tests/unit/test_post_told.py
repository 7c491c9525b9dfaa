"""Numbers told of made-up histories, where signs, sides and order count: each known by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from histories import OSCILLATOR, history_of, scene_of, summary_of

from rockslip import Scene, parse_scene
from solver.results.endings import fallen, overturned_at
from solver.results.motion import (
    BlockMotion,
    angular_velocity,
    boxes,
    lean_over_alpha,
    lost_carrier,
    slenderness,
)
from solver.results.overlaps import overlaps

ALPHA = math.atan(0.4)
"""Slenderness of the block of these histories, rad."""

ON_LOW = "name = 'up'\non = 'low'"


def test_the_largest_force_on_the_foundation_may_be_negative() -> None:
    scene = scene_of("", rest=OSCILLATOR)
    t = np.linspace(0, 1, 5)
    shear = np.array([0.0, 2.0, -7.0, 3.0, 0.0])
    history = history_of(scene, t, block__centre_y_m=0.5, foundation__base_shear_N=shear)
    assert summary_of(scene, history)["platform"]["peak_base_shear_N"] == 7.0


def test_slenderness_of_a_block_turned_by_90_degrees_is_that_of_its_thin_side() -> None:
    """A quarter turn about +z, then a lean of 0.1 about +y: product of the quaternions."""
    scene = scene_of("", dimension=3)
    t = np.linspace(0, 1, 3)
    c, s = math.cos(0.05) * math.sqrt(0.5), math.sin(0.05) * math.sqrt(0.5)
    half = math.acos(c)
    vector = 2 * half / math.sin(half) * np.array([s, s, c])
    turns = {f"block__angle_{axis}_rad": part for axis, part in zip("xyz", vector, strict=True)}
    history = history_of(scene, t, block__centre_z_m=0.5, **turns)
    np.testing.assert_allclose(slenderness(history, scene.blocks[0]), math.atan(0.3))
    np.testing.assert_allclose(lean_over_alpha(history, scene.blocks[0]), 0.1 / math.atan(0.3))


def test_a_block_overturns_where_it_last_passes_its_point_of_balance() -> None:
    """Beyond it, back, beyond it again, and not yet beyond return when the history ends."""
    scene = scene_of("")
    t = np.linspace(0, 0.5, 6)
    angle = ALPHA * np.array([0.0, 1.2, 0.5, 0.9, 1.3, 1.5])
    history = history_of(scene, t, block__angle_rad=angle, block__centre_y_m=0.5)
    assert overturned_at(history, scene.blocks[0]) == pytest.approx(0.4)


def test_a_squat_block_has_overturned_where_it_lies_flat() -> None:
    """Twice its alpha of 56 degrees is never reached: it lies at 90."""
    tables = scene_of("").to_dict()
    tables["block"][0]["width"] = 1.5
    scene = parse_scene(tables)
    t = np.linspace(0, 0.4, 5)
    angle = np.radians([0.0, 50.0, 70.0, 88.0, 90.0])
    history = history_of(scene, t, block__angle_rad=angle, block__centre_y_m=0.75)
    assert overturned_at(history, scene.blocks[0]) == pytest.approx(0.4)


@pytest.mark.parametrize("lean", [20.0, -20.0])
def test_a_block_on_one_that_leans_has_not_fallen_while_it_is_over_its_top(lean: float) -> None:
    """0.6 m along the carrier's axis and 0.2 m down its top is over it; 0.45 m is below."""
    scene = scene_of("name = 'low'", ON_LOW)
    t, turn = np.linspace(0, 1, 3), math.radians(lean)
    axis = np.array([math.sin(turn), math.cos(turn)])
    downhill = math.copysign(1.0, lean) * np.array([math.cos(turn), -math.sin(turn)])
    for along, fell in ((0.6, False), (0.45, True)):
        x, y = np.array([0.0, 0.5]) + along * axis + 0.2 * downhill
        columns: dict[str, Any] = {"low__centre_y_m": 0.5, "low__angle_rad": turn}
        columns |= {"up__centre_x_m": x, "up__centre_y_m": y, "up__angle_rad": turn}
        assert BlockMotion(scene, history_of(scene, t, **columns), scene.blocks[1]).fell is fell


@pytest.mark.parametrize("tilt", [5.0, -5.0])
def test_the_scale_of_energy_is_counted_from_the_upright_block(tilt: float) -> None:
    """m g R (cos(alpha - |theta|) - cos alpha) of the release, and a part of m g H."""
    scene = scene_of(f"tilt_deg = {tilt}")
    half_diagonal, theta = math.hypot(0.2, 0.5), math.radians(abs(tilt))
    height = half_diagonal * math.cos(ALPHA - theta)
    history = history_of(
        scene,
        np.linspace(0, 1, 3),
        block__angle_rad=math.radians(tilt),
        block__centre_x_m=math.copysign(0.2 - half_diagonal * math.sin(ALPHA - theta), tilt),
        block__centre_y_m=height,
    )
    raised = half_diagonal * (math.cos(ALPHA - theta) - math.cos(ALPHA))
    weight = 100.0 * 9.81
    scale = summary_of(scene, history)["energy"]["scale_J"]
    assert scale == pytest.approx(weight * (raised + 1e-3 * 1.0), rel=1e-9)


def test_a_block_that_overturns_and_then_falls_stood_until_it_overturned() -> None:
    """The peaks while it stood are those before the first of the two."""
    scene = scene_of("name = 'low'", ON_LOW)
    t = np.linspace(0, 0.6, 7)
    angle = np.array([0.0, 0.3, 0.6, 0.8, 1.5, 1.5, 1.5])  # 2 alpha = 0.761
    place = np.array([0.0, 0.0, 0.1, 0.3, 0.8, 0.9, 1.0])
    height = np.array([1.5, 1.5, 1.5, 1.5, 1.4, 1.0, 0.8])
    columns: dict[str, Any] = {"low__centre_y_m": 0.5, "up__angle_rad": angle}
    columns |= {"up__centre_x_m": place, "up__centre_y_m": height, "up__slip_m": place}
    block = summary_of(scene, history_of(scene, t, **columns))["blocks"]["up"]
    assert block["overturned_at_s"] == pytest.approx(0.3)
    assert block["fell_at_s"] is not None and block["fell_at_s"] > 0.35
    assert block["peak_angle_while_standing_rad"] == pytest.approx(0.8)
    assert block["peak_angle_over_alpha_while_standing"] == pytest.approx(0.8 / ALPHA)
    assert block["peak_slip_while_standing_m"] == pytest.approx(0.3)
    assert block["peak_angle_rad"] == pytest.approx(1.5)
    assert block["peak_slip_m"] == pytest.approx(1.0)


def test_an_overlap_is_told_at_the_time_at_which_it_begins() -> None:
    """Blocks 0.4 m wide, far from each other at first; later 1 m/s: from 0.8 s on."""
    scene = scene_of("name = 'a'", "name = 'b'\noffset = 3.0", rest="[output]\nevery = 0.05\n")
    t = np.linspace(0, 1, 101)
    place = np.where(t < 0.2, 3.0, np.where(t < 0.35, 1.0, 0.8 - (t - 0.4)))
    columns: dict[str, Any] = {"a__centre_y_m": 0.5, "b__centre_y_m": 0.5, "b__centre_x_m": place}
    (found,) = overlaps(scene, history_of(scene, t, **columns))
    assert found["time_s"] == pytest.approx(0.85)
    assert found["depth_m"] == pytest.approx(0.2)


def test_a_rate_towards_a_direction_is_the_one_about_the_axis_ahead_of_it() -> None:
    """Leaning to (0.8, 0.6) is turning about (-0.6, 0.8); about z and (0.8, 0.6) nothing leans."""
    scene = scene_of("", dimension=3)
    for about, rate in (((-0.6, 0.8, 9.0), 1.0), ((0.8, 0.6, -5.0), 0.0), ((1.0, 0.0, 0.0), -0.6)):
        columns = {
            f"block__angular_velocity_{axis}_rad_s": part
            for axis, part in zip("xyz", about, strict=True)
        }
        history = history_of(scene, np.linspace(0, 1, 3), block__centre_z_m=0.5, **columns)
        found = angular_velocity(history, "block", np.array([0.8, 0.6]))
        np.testing.assert_allclose(found, rate, atol=1e-15)


@pytest.mark.parametrize(
    ("lean", "along", "lost"), [(59.0, 0.51, False), (61.0, 0.51, True), (59.0, 0.49, True)]
)
def test_a_carrier_is_lost_beyond_60_degrees_or_below_its_top(
    lean: float, along: float, lost: bool
) -> None:
    scene = scene_of("name = 'low'", ON_LOW)
    turn = math.radians(lean)
    x, y = along * np.array([math.sin(turn), math.cos(turn)])
    columns: dict[str, Any] = {"low__angle_rad": turn, "low__centre_y_m": 0.5}
    columns |= {"up__centre_x_m": x, "up__centre_y_m": 0.5 + y}
    history = history_of(scene, np.linspace(0, 1, 3), **columns)
    assert lost_carrier(history, scene.blocks[1], scene.blocks[0]).tolist() == [lost] * 3


def test_a_block_that_leans_to_minus_y_has_a_negative_angle() -> None:
    """A turn about +x takes +z to -y."""
    scene = scene_of("", dimension=3)
    t = np.linspace(0, 1, 3)
    history = history_of(scene, t, block__angle_x_rad=0.05, block__centre_z_m=0.5)
    motion = BlockMotion(scene, history, scene.blocks[0])
    np.testing.assert_allclose(motion.angle, -0.05)
    assert motion.shape.width == pytest.approx(0.3)


def test_the_axes_of_a_block_in_the_plane_turn_with_it_to_the_right() -> None:
    """Leaning to +x its upright axis points to (sin, cos), its base to (cos, -sin)."""
    scene = scene_of("")
    history = history_of(scene, np.linspace(0, 1, 2), block__angle_rad=0.3, block__centre_y_m=0.5)
    box = boxes(history, scene.blocks[0])
    c, s = math.cos(0.3), math.sin(0.3)
    np.testing.assert_allclose(box.frames[0][:, 0], [c, -s])
    np.testing.assert_allclose(box.frames[0][:, 1], [s, c])
    np.testing.assert_allclose(box.half, [0.2, 0.5])


def test_a_block_that_does_not_lean_is_as_slender_as_along_its_width() -> None:
    scene = scene_of("", dimension=3)
    history = history_of(scene, np.linspace(0, 1, 2), block__centre_z_m=0.5)
    np.testing.assert_allclose(slenderness(history, scene.blocks[0]), ALPHA)


def test_a_block_in_space_that_turns_over_is_followed_beyond_half_a_turn() -> None:
    scene = scene_of("", dimension=3)
    t = np.linspace(0, 1, 101)
    history = history_of(scene, t, block__angle_y_rad=4.0 * t, block__centre_z_m=0.5)
    np.testing.assert_allclose(BlockMotion(scene, history, scene.blocks[0]).angle, 4.0 * t)


def test_angles_of_the_summary_are_from_upright_whatever_carries_the_block() -> None:
    """It leans by -0.05 rad at most and 0.03 at the end, on a block that leans by 0.01."""
    scene = scene_of("name = 'low'", ON_LOW)
    lean = np.array([0.0, -0.05, 0.02, 0.03])
    columns: dict[str, Any] = {"low__angle_rad": 0.01, "low__centre_y_m": 0.5}
    columns |= {"up__angle_rad": lean, "up__centre_y_m": 1.5}
    block = summary_of(scene, history_of(scene, np.linspace(0, 1, 4), **columns))["blocks"]["up"]
    assert block["peak_angle_rad"] == block["peak_angle_while_standing_rad"] == 0.05
    assert block["peak_angle_over_alpha"] == pytest.approx(0.05 / ALPHA)
    assert block["residual_angle_rad"] == 0.03


def test_a_block_that_nothing_held_for_a_moment_fell_wherever_it_ends() -> None:
    """Beside the top at first, all of it above the plane of half the carrier in the end."""
    scene = scene_of("name = 'low'", ON_LOW)
    columns: dict[str, Any] = {"low__centre_y_m": 0.5}
    columns |= {"up__centre_x_m": np.array([0.3, 0.41, 0.42]), "up__angle_rad": 0.0}
    columns |= {"up__centre_y_m": np.array([1.5, 1.48, 1.45])}
    history = history_of(scene, np.linspace(0, 1, 3), **columns)
    assert not BlockMotion(scene, history, scene.blocks[1]).fell
    block = summary_of(scene, history)["blocks"]["up"]
    assert block["fell_at_s"] == 0.5
    assert block["mode"] == "fell"


def falls(scene: Scene, places: list[tuple[float, float]], **columns: Any) -> list[bool]:
    """In which rows the last block falls, its middle at these places, m."""
    x, y = np.array(places).T
    name = scene.blocks[-1].name
    columns |= {f"{name}__centre_x_m": x, f"{name}__centre_y_m": y}
    history = history_of(scene, 0.1 * np.arange(len(places)), **columns)
    return [bool(row) for row in fallen(scene, history, scene.blocks[-1])]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_block_falls_where_nothing_of_the_top_is_under_it_or_all_of_it_is_below(
    side: float,
) -> None:
    """Upright, 0.4 x 1 m, on a block of that size, whose top is at 1 m and ends at 0.2 m."""
    rows = [
        ((0.0, 1.50), False),
        ((0.25, 1.49), False),  # its edge is still over the top
        ((0.41, 1.48), True),
        ((0.41, 1.60), False),  # on its way up
        ((0.45, 1.59), False),  # beside the top, but all of it above
        ((0.25, 0.90), False),  # its middle is below the top, its edge over it
        ((0.25, 0.49), True),
        ((0.10, 0.48), True),
    ]
    places = [(side * x, y) for (x, y), _ in rows]
    assert falls(scene_of("name = 'low'", ON_LOW), places, low__centre_y_m=0.5) == [
        known for _, known in rows
    ]


def test_a_foundation_that_drifts_carries_its_ends_with_it() -> None:
    """2 m wide: a block 0.4 m wide is beside it 1.2 m from its middle, wherever that is."""
    plate = {"kind": "elastic", "support": "rollers", "width": 2.0, "height": 0.1, "young": 2e11}
    plate |= {"poisson": 0.3, "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
    scene = parse_scene(scene_of("").to_dict() | {"foundation": plate})
    places = [(1.0, 0.5), (1.0, 0.49), (1.0, 0.48), (1.3, 0.47), (1.3, 0.46)]
    drift = np.array([0.0, 0.0, -0.25, -0.25, 0.2])
    assert falls(scene, places, platform__drift_m=drift) == [False, False, True, True, False]
