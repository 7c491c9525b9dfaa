"""Motions of blocks, from made-up histories: stacks, platforms, three dimensions, falls."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from histories import OSCILLATOR, history_of, scene_of, summary_of

from rockslip import History, Scene, parse_scene
from solver.results.energy import gravity_above_upright, upright_centre
from solver.results.motion import BlockMotion, rotated, total_lean
from solver.results.report import report


def test_rotated_turns_by_the_right_hand() -> None:
    """A quarter turn about +y takes +z to +x: leaning to +x is a positive rotation about +y."""
    turns = np.array([[0, math.pi / 2, 0], [math.pi / 2, 0, 0], [0, 0, 0]])
    found = rotated(turns, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(found, [[1, 0, 0], [0, -1, 0], [0, 0, 1]], atol=1e-15)


def test_a_block_that_stays_on_a_rocking_one_is_at_rest() -> None:
    """The upper block turns with the lower one: no swing, no impact, the same largest angle."""
    scene = scene_of("name = 'low'", "name = 'up'\non = 'low'")
    t = np.linspace(0, 1, 401)
    angle = 0.05 * np.cos(2 * math.pi * t)
    lift = 0.4 * np.sin(np.abs(angle))
    history = history_of(
        scene,
        t,
        low__angle_rad=angle,
        low__gap_left_m=lift,
        low__centre_y_m=0.5,
        up__angle_rad=angle,
        up__centre_y_m=1.5,
    )
    blocks = summary_of(scene, history)["blocks"]
    assert blocks["low"]["mode"] == "rock"
    assert len(blocks["low"]["impacts"]) == 2
    assert blocks["up"]["mode"] == "rest"
    assert blocks["up"]["impacts"] == []
    assert blocks["up"]["peak_angle_rad"] == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("x", "y", "fell"), [(0.3, 1.5, False), (0.7, 1.35, False), (0.9, 0.5, True)]
)
def test_a_block_that_falls_off_another(x: float, y: float, fell: bool) -> None:
    """Below the plane of the top of what carried it, also where that leans by 0.2 rad."""
    scene = scene_of("name = 'low'", "name = 'up'\non = 'low'")
    t = np.linspace(0, 1, 3)
    history = history_of(
        scene, t, low__centre_y_m=0.5, low__angle_rad=0.2, up__centre_x_m=x, up__centre_y_m=y
    )
    assert BlockMotion(scene, history, scene.blocks[1]).fell is fell
    assert (summary_of(scene, history)["blocks"]["up"]["mode"] == "fell") is fell


def test_a_block_beside_the_overturned_one_that_carried_it_fell() -> None:
    """On the far side of the plane of the top, but lower than the centre of the carrier."""
    scene = scene_of("name = 'low'", "name = 'up'\non = 'low'")
    t = np.linspace(0, 1, 3)
    history = history_of(
        scene,
        t,
        low__centre_y_m=0.2,
        low__angle_rad=math.pi / 2,
        up__centre_x_m=2.0,
        up__centre_y_m=0.15,
    )
    assert BlockMotion(scene, history, scene.blocks[1]).fell


def test_a_block_below_level_zero_fell_off_its_plate() -> None:
    scene = scene_of("")
    t = np.linspace(0, 1, 3)
    assert BlockMotion(scene, history_of(scene, t, block__centre_y_m=-0.1), scene.blocks[0]).fell
    lying = history_of(scene, t, block__centre_y_m=0.2, block__angle_rad=math.pi / 2)
    assert summary_of(scene, lying)["blocks"]["block"]["mode"] == "overturned"


def test_energy_scale_of_a_stack_on_an_incline() -> None:
    """Each block at its height and place, against the sum written out."""
    scene = scene_of(
        "name = 'low'\noffset = 0.2", "name = 'up'\non = 'low'\noffset = -0.1", rest=""
    )
    tilted = parse_scene(scene.to_dict() | {"gravity_tilt_deg": 10.0})
    np.testing.assert_allclose(upright_centre(tilted, tilted.blocks[1]), [0.1, 1.5])
    t = np.linspace(0, 1, 2)
    history = history_of(
        tilted,
        t,
        low__centre_x_m=0.2,
        low__centre_y_m=0.52,
        up__centre_x_m=0.07,
        up__centre_y_m=1.55,
        energy__kinetic_J=4.0,
        # what a meshed foundation weighs is no part of it
        energy__gravity_J=-1e5,
        energy__total_J=-1e5 + 4.0,
    )
    weight, tilt = 100.0 * 9.81, math.radians(10)
    raised = weight * (0.07 * math.cos(tilt) + 0.03 * math.sin(tilt))
    np.testing.assert_allclose(gravity_above_upright(tilted, history), raised)
    scale = summary_of(tilted, history)["energy"]["scale_J"]
    assert scale == pytest.approx(4.0 + raised + 1e-3 * 2 * weight)


def test_platform_and_the_mass_that_it_feels() -> None:
    """A sticking block is felt with all its mass, one that slides with the part that rubs."""
    scene = scene_of("", rest=OSCILLATOR)
    t = np.linspace(0, 1, 2001)
    drift = -3.0 / 49 * np.sin(7 * t)
    ground, relative = 0.4 * np.cos(5 * t), 3.0 * np.sin(7 * t)
    together = ground + relative
    together = 0.5 * (together + np.append(together[:1], together[:-1]))  # forces are of steps
    moving = {
        "platform__drift_m": drift,
        "platform__acceleration_m_s2": relative,
        "base__acceleration_m_s2": ground,
    }
    for ratio in (1.0, 0.3):
        history = history_of(
            scene,
            t,
            block__centre_y_m=0.5,
            block__friction_force_N=ratio * 100 * together,
            **moving,
        )
        summary = summary_of(scene, history)
        assert summary["blocks"]["block"]["friction_mass_ratio"] == pytest.approx(ratio, rel=1e-4)
        # on an incline friction holds the block against gravity as well
        incline = parse_scene(scene.to_dict() | {"gravity_tilt_deg": 5.0})
        columns = history["block.friction_force_N"] - 100 * incline.gravity_vector[0]
        held = history_of(
            incline, t, block__centre_y_m=0.5, block__friction_force_N=columns, **moving
        )
        on_incline = summary_of(incline, held)["blocks"]["block"]["friction_mass_ratio"]
        assert on_incline == pytest.approx(ratio, rel=1e-4)
    stack = scene_of("name = 'block'", "name = 'up'\non = 'block'", rest=OSCILLATOR)
    stack = parse_scene(stack.to_dict() | {"gravity_tilt_deg": 5.0})
    held = 200 * (together - stack.gravity_vector[0])
    history = history_of(stack, t, block__centre_y_m=0.5, block__friction_force_N=held, **moving)
    known = summary_of(stack, history)["blocks"]
    assert known["block"]["friction_mass_ratio"] == pytest.approx(1.0, rel=1e-4)
    assert "friction_mass_ratio" not in known["up"]
    assert summary["platform"]["peak_drift_m"] == pytest.approx(np.max(np.abs(drift)))
    assert summary["platform"]["residual_drift_m"] == pytest.approx(drift[-1])
    assert f"peak drift {1e3 * np.max(np.abs(drift)):.4g} mm" in report(summary)


def rocking_in_space(azimuth: float) -> tuple[Scene, History]:
    """The block rocks from 0.06 rad to 0.05 to the other side, across an axis at the azimuth."""
    scene = scene_of("", dimension=3)
    t = np.linspace(0, 1.4, 1401)
    lean = np.where(t < 0.5, 0.06, 0.05) * np.cos(math.pi * t)
    # leaning towards the azimuth is a rotation about the horizontal axis ahead of it
    history = history_of(
        scene,
        t,
        block__angle_x_rad=-math.sin(azimuth) * lean,
        block__angle_y_rad=math.cos(azimuth) * lean,
        block__angle_rad=math.cos(azimuth) * lean,
        block__gap_1_m=0.4 * np.sin(np.maximum(lean, 0)),
        block__gap_3_m=0.4 * np.sin(np.maximum(-lean, 0)),
        block__slip_m=3e-3 * t,
        block__slip_second_m=-4e-3 * t,
        block__friction_force_N=3.0,
        block__friction_force_second_N=-4.0 * t,
        block__centre_z_m=0.5,
    )
    return scene, history


@pytest.mark.parametrize(
    ("azimuth", "width"), [(0.0, 0.4), (math.pi / 2, 0.3), (math.radians(210), 0.4964)]
)
def test_rocking_in_space(azimuth: float, width: float) -> None:
    """In the plane in which it leans most; the width is that of the base along it."""
    scene, history = rocking_in_space(azimuth)
    motion = BlockMotion(scene, history, scene.blocks[0])
    assert motion.shape.width == pytest.approx(width, abs=1e-4)
    assert motion.shape.mass == pytest.approx(100.0)
    np.testing.assert_allclose(np.abs(motion.angle), motion.lean, atol=1e-12)
    np.testing.assert_allclose(total_lean(history, "block"), motion.lean, atol=1e-15)
    # the plane's direction is towards +x, or +y
    assert motion.angle[0] == pytest.approx(-0.06 if math.cos(azimuth) < -0.5 else 0.06)
    block = summary_of(scene, history)["blocks"]["block"]
    assert block["mode"] == "slide-rock"
    assert block["peak_angle_rad"] == pytest.approx(0.06)
    assert [impact["time_s"] for impact in block["impacts"]] == pytest.approx([0.5], abs=1e-3)
    assert block["impacts"][0]["restitution"] == pytest.approx(5 / 6, rel=1e-4)
    assert block["peak_slip_m"] == pytest.approx(7e-3)
    assert block["residual_slip_m"] == pytest.approx(4.2e-3)
    assert block["residual_slip_second_m"] == pytest.approx(-5.6e-3)
    assert block["peak_friction_force_N"] == pytest.approx(math.hypot(3, 5.6))


def test_a_spinning_block_does_not_lean() -> None:
    """Turning about the vertical is neither rocking nor falling, however far."""
    scene = scene_of("", dimension=3)
    t = np.linspace(0, 1, 101)
    history = history_of(scene, t, block__angle_z_rad=20 * t, block__centre_z_m=0.5)
    block = summary_of(scene, history)["blocks"]["block"]
    assert block["mode"] == "turn"
    assert block["peak_angle_rad"] == pytest.approx(0.0, abs=1e-12)


def test_leaning_counts_in_the_frame_of_a_block_that_was_turned() -> None:
    """Turned by 90 degrees it leans to +x over its thin side."""
    scene = scene_of("", dimension=3)
    t = np.linspace(0, 1, 3)
    # a quarter turn about +z, then a lean of 0.1 about +y: product of the quaternions
    c, s = math.cos(0.05) * math.sqrt(0.5), math.sin(0.05) * math.sqrt(0.5)
    turn = 2 * math.acos(c)
    vector = turn / math.sin(turn / 2) * np.array([s, s, c])
    history = history_of(
        scene,
        t,
        block__angle_x_rad=vector[0],
        block__angle_y_rad=vector[1],
        block__angle_z_rad=vector[2],
        block__centre_z_m=0.5,
    )
    motion = BlockMotion(scene, history, scene.blocks[0])
    np.testing.assert_allclose(motion.angle, 0.1)
    assert motion.shape.width == pytest.approx(0.3)


def test_in_space_a_block_that_stays_on_a_leaning_one_is_at_rest() -> None:
    """Lean and mode are against what carries it, also where both are turned as well."""
    scene = scene_of("name = 'low'", "name = 'up'\non = 'low'", dimension=3)
    t = np.linspace(0, 1, 101)
    columns: dict[str, Any] = {"low__centre_z_m": 0.5, "up__centre_z_m": 1.5}
    for name in ("low", "up"):
        columns |= {f"{name}__angle_x_rad": 0.05 * np.cos(7 * t), f"{name}__angle_y_rad": 0.03 * t}
        columns |= {f"{name}__angle_z_rad": 0.3 * t, f"{name}__gap_1_m": 0.01}
    history = history_of(scene, t, **columns)
    blocks = summary_of(scene, history)["blocks"]
    assert blocks["low"]["mode"] == "turn-rock"
    assert blocks["up"]["mode"] == "rest"


def test_a_summary_in_space_is_json() -> None:
    scene, history = rocking_in_space(0.4)
    summary = summary_of(scene, history)
    assert json.loads(json.dumps(summary)) == summary
    assert "peak slip 7 mm" in report(summary)
