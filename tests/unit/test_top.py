"""Tops of blocks, and when a block has fallen off one, by outlines where boxes would be wrong."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from histories import history_of, summary_of

from geometry.block import Block
from geometry.top import top_of
from rockslip import History, Scene, parse_scene, simulate
from solver.results.endings import fallen
from solver.results.motion import BlockMotion, lost_carrier
from solver.types import Array

TEE = "{ polygon = [[-0.05, 0], [0.05, 0], [0.05, 0.7], [0.3, 0.7], [0.3, 0.8], [-0.3, 0.8],"
SHAPES = {
    "triangle": "shape = { polygon = [[-0.2, 0], [0.2, 0], [0, 0.8]] }",
    "tee": f"shape = {TEE} [-0.3, 0.7], [-0.05, 0.7]] }}",
    "feet": "width = 0.6\nheight = 0.1\nfeet = { inset = 0.15, size = 0.1, height = 0.7 }",
    "box": "width = 0.4\nheight = 0.8",
}
T = np.linspace(0, 1, 41)


def scene_of(up: str, low: str = "width = 0.4\nheight = 1.0", rest: str = "") -> Scene:
    """One block on another in the plane."""
    common = "thickness = 1.0\ndensity = 1000.0\nmodel = 'rigid'"
    tables = f"[[block]]\nname = 'low'\n{common}\n{low}\n[[block]]\nname = 'up'\non = 'low'\n"
    return parse_scene(f"{tables}{common}\n{up}\n{rest}[time]\nend = 1.0\nstep = 1e-3\n")


def shape_of(keys: str) -> Block:
    """The shape of a block with such keys."""
    return scene_of("width = 0.1\nheight = 0.1", keys).blocks[0].shape


@pytest.mark.parametrize(
    ("keys", "left", "right", "level"),
    [
        ("width = 0.4\nheight = 1.0", -0.2, 0.2, 1.0),
        ("shape = { polygon = [[-0.3, 0], [0.3, 0], [0.1, 0.8], [-0.2, 0.8]] }", -0.2, 0.1, 0.8),
        # Slopes of 45 degrees hold what lies on them, slopes of 76 do not.
        ("shape = { polygon = [[-0.3, 0], [0.3, 0], [0.1, 0.2], [-0.1, 0.2]] }", -0.3, 0.3, 0.0),
        (SHAPES["triangle"], 0.0, 0.0, 0.8),
        (SHAPES["tee"], -0.3, 0.3, 0.8),
        (SHAPES["feet"], -0.3, 0.3, 0.8),
        # A stair: the hull between both steps looks up by more than 45 degrees.
        (
            "shape = { polygon = [[0, 0], [0.6, 0], [0.6, 0.4], [0.3, 0.4], [0.3, 0.6], [0, 0.6]]}",
            -0.3, 0.3, 0.4,
        ),
        # A drum: facets up to 52.5 degrees from the uppermost, with corners at 56.25.
        ("shape = { regular = 48 }\nwidth = 0.6", -0.24944, 0.24944, 0.29936 + 0.16667),
    ],
)  # fmt: skip
def test_tops_in_the_plane(keys: str, left: float, right: float, level: float) -> None:
    top = top_of(shape_of(keys), 2)
    ends = dict(zip(top.normals[:, 0], top.reach, strict=True))
    assert (-ends[-1.0], ends[1.0]) == pytest.approx((left, right), abs=1e-4)
    assert top.level == pytest.approx(level, abs=1e-4)


def test_the_top_of_a_round_column_in_space_is_round() -> None:
    """48 facets of a circle of 0.5 m; a corner of the box around it is beside it."""
    keys = "shape = { cylinder = 1.0 }\nheight = 2.0\nmodel = 'rigid'\ndensity = 1.0"
    scene = parse_scene(f"dimension = 3\n[[block]]\n{keys}\n[time]\nend = 1.0\n")
    top = top_of(scene.blocks[0].shape, 3)
    np.testing.assert_allclose(top.reach, 0.5 * math.cos(math.pi / 48))
    places = np.array([[0.45, 0.45, 2.1], [0.34, 0.34, 2.1], [0.34, 0.34, 1.9]])
    assert top.is_off(places).tolist() == [True, False, True]


def falling(scene: Scene, x: Array, y: Array, angle: Array) -> History:
    """A history in which the middle of the upper block's bottom is at (x, y), m."""
    centre = np.array(scene.blocks[1].shape.centre_of_mass())
    c, s = np.cos(angle), np.sin(angle)
    place = {"centre_x_m": x + s * centre[1], "centre_y_m": y + c * centre[1], "angle_rad": angle}
    columns: dict[str, Any] = {f"up__{name}": value for name, value in place.items()}
    return history_of(scene, T, low__centre_y_m=0.5, **columns)


def corners_of(scene: Scene, x: Array, y: Array, angle: Array) -> Array:
    """Corners of the upper block there, (rows, corners, 2), m."""
    own = np.array(scene.blocks[1].shape.corners())
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack(
        [x[:, None] + c * own[:, 0] + s * own[:, 1], y[:, None] - s * own[:, 0] + c * own[:, 1]],
        axis=2,
    )


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("turn", [1.5, -1.0, 3.0])
def test_a_block_has_fallen_where_all_of_its_outline_is_off_the_top(name: str, turn: float) -> None:
    """It moves over the edge of a carrier of 0.4 x 1 m, turns and falls, at two speeds."""
    scene = scene_of(SHAPES[name])
    for speed in (1.5, 0.6):
        x, y, angle = speed * T, 1 - 1.2 * T**2, turn * T
        corners = corners_of(scene, x, y, angle)
        below = corners[..., 1].max(axis=1) <= 1
        beside = (corners[..., 0].min(axis=1) >= 0.2) & (corners[..., 1].min(axis=1) < 1)
        found = fallen(scene, falling(scene, x, y, angle), scene.blocks[1])
        assert found.any()
        sinks = np.diff(_middle(scene, x, y, angle), prepend=np.inf) < 0
        sinks[0] = False
        np.testing.assert_array_equal(found, (below | beside) & sinks)


def _middle(scene: Scene, x: Array, y: Array, angle: Array) -> Array:
    """Height of the middle of the box around the upper block, m."""
    return np.asarray(y + np.cos(angle) * scene.blocks[1].shape.height / 2)


def test_a_triangle_beside_its_carrier_has_fallen_though_the_box_around_it_is_not_beside() -> None:
    """It leans by 60 degrees: there is nothing of it where the upper corner of its box is."""
    scene = scene_of(SHAPES["triangle"])
    angle, rest = np.full_like(T, math.radians(-60)), np.ones_like(T)
    x, y = 0.95 * rest, 0.7 - 0.1 * T
    corners = corners_of(scene, x, y, angle)
    left = corners[..., 0].min()
    box = scene_of(SHAPES["box"])
    assert corners_of(box, x, y, angle)[..., 0].min() < 0.2 < left
    assert fallen(scene, falling(scene, x, y, angle), scene.blocks[1])[1:].all()
    assert not fallen(box, falling(box, x, y, angle), box.blocks[1]).any()


def test_what_lies_on_the_lower_step_of_a_stair_is_carried() -> None:
    """A cube of 0.1 m falls from the level of the stair's post to its step, and stays there."""
    stair = "[[-0.3, 0], [0.3, 0], [0.3, 0.4], [0, 0.4], [0, 0.6], [-0.3, 0.6]]"
    scene = scene_of("width = 0.1\nheight = 0.1\noffset = 0.15", f"shape = {{ polygon = {stair} }}")
    result = simulate(scene)
    history, up = result.history, scene.blocks[1]
    assert history["up.centre_y_m"][-1] == pytest.approx(0.45, abs=1e-3)
    assert not lost_carrier(history, up, scene.blocks[0]).any()
    assert not BlockMotion(scene, history, up).fell
    assert summary_of(scene, history)["blocks"]["up"]["fell_at_s"] is None
    # Its columns are those over the stair: 0.2 m below the plane of the post.
    assert history["up.gap_left_m"][-1] == pytest.approx(-0.2, abs=1e-3)
    assert history["up.normal_force_N"][-1] == pytest.approx(10 * 9.81, rel=1e-2)


def test_a_slab_stays_on_the_rollers_that_turn_below_it() -> None:
    """It goes twice as far as the rollers turn, by 97 degrees; its gaps stay those of rest."""
    roller = "model = 'rigid'\nshape = { regular = 48 }\nwidth = 0.2\nthickness = 1.0\n"
    scene = parse_scene(
        f"[[block]]\nname = 'left'\n{roller}density = 2000.0\noffset = -0.3\n"
        f"[[block]]\nname = 'right'\n{roller}density = 2000.0\noffset = 0.3\n"
        "[[block]]\nname = 'slab'\non = ['left', 'right']\nmodel = 'rigid'\nwidth = 1.6\n"
        "height = 0.1\nthickness = 1.0\ndensity = 2000.0\nvelocity = [0.6, 0.0]\n"
        "[contact]\nfriction = 0.6\n[time]\nend = 0.7\nstep = 2e-4\n"
    )
    result = simulate(scene)
    history, slab = result.history, scene.blocks[2]
    summary = summary_of(scene, history)
    blocks = summary["blocks"]
    assert blocks["left"]["peak_angle_rad"] > math.radians(90)
    assert [blocks[name]["mode"] for name in ("left", "right", "slab")] == ["roll", "roll", "rest"]
    assert summary["collapse"] == [] and blocks["slab"]["fell_at_s"] is None
    assert not any(lost_carrier(history, slab, scene.blocks[k]).any() for k in (0, 1))
    rolled = 2 * 0.1 * math.cos(math.pi / 48) * history["left.angle_rad"][-1]
    moved = history["slab.centre_x_m"][-1] - history["slab.slip_m"][-1]
    assert moved == pytest.approx(rolled, rel=5e-3)
    # The rollers' corners lift it by 0.2 mm each, at most.
    lifted = 2 * 0.1 * (1 - math.cos(math.pi / 48))
    for side in ("left", "right"):
        assert np.abs(history[f"slab.gap_{side}_m"]).max() < 1.5 * lifted
