"""The rigid-body answer in the columns of a run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry.arrangement import initial_position
from rockslip import History, Scene, parse_scene
from solver.errors import SceneError
from solver.excitation.motion import read_ground
from solver.reference import answer
from solver.reference.initiation import demand, release_friction, rocking_friction

BLOCK = {
    "width": 0.25,
    "height": 1.0,
    "thickness": 0.75,
    "mass": 503.0,
    "young": 5e10,
    "poisson": 0.2,
}
WEIGHT = 503.0 * 9.81


def scene(
    *, block: dict[str, Any] | None = None, friction: float = 0.7, end: float = 1.0, **tables: Any
) -> Scene:
    content = {
        "block": [BLOCK | (block or {})],
        "contact": {"friction": friction},
        "time": {"end": end, "step": 1e-3},
    }
    return parse_scene(content | tables)


@pytest.mark.parametrize("tilt", [3.0, -3.0])
def test_free_rocking(tilt: float) -> None:
    """Places, forces, gaps and energy fit together at the release and all the way."""
    asked = scene(block={"tilt_deg": tilt, "offset": 0.1})
    history = answer.reference_history(asked)
    shape = asked.blocks[0].shape
    side = math.copysign(1.0, tilt)
    centre = initial_position(shape, (0.1,), math.radians(tilt))(np.array([[0.0, 0.5]]))[0]
    assert history["block.centre_x_m"][0] == pytest.approx(centre[0])
    assert history["block.centre_y_m"][0] == pytest.approx(centre[1])
    lifted, pivot = ("left", "right") if tilt > 0 else ("right", "left")
    assert history[f"block.gap_{lifted}_m"][0] == pytest.approx(0.25 * math.sin(math.radians(3)))
    assert history[f"block.gap_{pivot}_m"][0] == 0.0
    demand = history["block.friction_force_N"][0] / history["block.normal_force_N"][0]
    needed = release_friction(math.radians(3), shape.slenderness())
    assert demand == pytest.approx(-side * needed)
    # between impacts the centre moves as the forces say: second differences of its place
    before = slice(1, 180)
    for axis, force, still in (("x", "friction", 0.0), ("y", "normal", WEIGHT)):
        place = history[f"block.centre_{axis}_m"]
        moved = 503.0 * np.diff(place, 2)[:179] / 1e-6
        wanted = history[f"block.{force}_force_N"][before] - still
        np.testing.assert_allclose(moved, wanted, atol=0.5)
    total = history["energy.total_J"][:190]
    np.testing.assert_allclose(total, total[0], rtol=1e-10)
    assert np.all(history["energy.input_J"] == 0)
    assert np.all(np.isnan(history["energy.contact_J"]))


def test_tipping_ends_on_the_side() -> None:
    history = answer.reference_history(scene(block={"tilt_deg": 16.0}, end=3.0))
    assert history["block.angle_rad"][-1] == pytest.approx(math.pi / 2)
    assert history["block.normal_force_N"][-1] == pytest.approx(WEIGHT)
    assert history["block.centre_x_m"][-1] == pytest.approx(0.125 + 0.5)
    assert history["block.centre_y_m"][-1] == pytest.approx(0.125)


def test_uplift_under_a_sudden_push() -> None:
    """Friction over normal force at uplift is what Shenton says rocking needs."""
    motion = {"kind": "sine", "amplitude_g": 0.8, "period": 1.0, "start": 0.0}
    history = answer.reference_history(scene(motion=motion, end=0.3))
    row = int(np.argmax(np.abs(history["block.angle_rad"]) > 0))
    acceleration = history["base.acceleration_m_s2"][row] / 9.81
    demand = abs(history["block.friction_force_N"][row] / history["block.normal_force_N"][row])
    assert demand == pytest.approx(rocking_friction(acceleration, 4.0), rel=1e-3)
    # the work of the ground is what the block has gained before any impact
    gained = history["energy.total_J"][-1] - history["energy.total_J"][0]
    assert gained == pytest.approx(history["energy.input_J"][-1], rel=1e-4)
    assert gained > 0


def test_sliding_keeps_its_ledger() -> None:
    motion = {"kind": "sine", "amplitude_g": 0.2, "period": 0.5, "cycles": 4}
    history = answer.reference_history(scene(motion=motion, friction=0.1, end=3.0))
    assert np.max(np.abs(history["block.slip_m"])) > 1e-3
    force = history["block.friction_force_N"]
    assert np.max(np.abs(force)) == pytest.approx(0.1 * WEIGHT)
    change = history["energy.total_J"] - history["energy.total_J"][0]
    lost = history["energy.friction_J"]
    np.testing.assert_allclose(change, history["energy.input_J"] - lost, atol=2e-4 * lost[-1])


def test_only_what_closed_forms_do_not_have_is_unknown() -> None:
    push = {"kind": "sine", "amplitude_g": 0.4, "period": 1.0}
    platform = {"kind": "oscillator", "mass_ratio": 1.0, "period": 0.5}
    rocks = scene(block={"tilt_deg": 3.0}, end=0.1)
    slides = scene(motion=push, friction=0.1, end=0.1)
    for asked in (rocks, slides, scene(motion=push, friction=0.1, end=0.1, foundation=platform)):
        history = answer.reference_history(asked)
        assert [name for name in history.columns if np.isnan(history[name]).any()] == [
            "newton_iterations",
            "contact_points_closed",
            "energy.contact_damping_J",
            "energy.contact_J",
            "energy.numerical_J",
            "energy.ledger_error_J",
        ]


def test_which_answer() -> None:
    push = {"kind": "sine", "amplitude_g": 0.4, "period": 1.0}
    assert answer.expected_mode(scene()) == "rest"
    assert answer.expected_mode(scene(motion=push)) == "rock"
    assert answer.expected_mode(scene(motion=push, friction=0.2)) == "slide"
    assert answer.expected_mode(scene(motion=push, friction=0.26)) == "slide-rock"
    assert answer.expected_mode(scene(block={"tilt_deg": 3.0})) == "rock"
    assert answer.expected_mode(scene(block={"tilt_deg": 3.0}, friction=0.1)) == "slide-rock"
    assert answer.expected_mode(scene(block={"tilt_deg": -16.0})) == "overturned"
    assert answer.expected_mode(scene(gravity_tilt_deg=15.0)) == "rock"
    assert answer.reference_name(scene(motion=push, friction=0.2)) == answer.SLIDING
    assert answer.reference_name(scene(motion=push)) == answer.ROCKING
    assert answer.reference_name(scene(motion=push | {"vertical": push})) == answer.ROCKING
    heaved = scene(motion=push | {"vertical": push}, friction=0.2)
    assert answer.reference_name(heaved) == answer.SLIDING


@pytest.mark.parametrize(
    ("block", "friction", "name"),
    [
        ({}, 0.26, answer.ROCKING_ON_PLATFORM),
        ({}, 0.24, answer.ON_PLATFORM),
        ({"tilt_deg": 1.0}, 0.24, answer.ROCKING_ON_PLATFORM),
        ({"velocity": [0.1, 0.0]}, 0.26, answer.ON_PLATFORM),
    ],
)
def test_which_answer_on_a_platform(block: dict[str, Any], friction: float, name: str) -> None:
    """It rocks where it is tilted, or where friction holds it until it uplifts: mu > B/H."""
    asked = scene(block=block, friction=friction, foundation=PLATFORM)
    assert answer.reference_name(asked) == name


def test_it_stops_where_the_block_has_overturned() -> None:
    """As a run does, at the angle 2 alpha, with the same words."""
    stop = {
        "time": {"end": 3.0, "step": 1e-3, "stop": "overturned"},
        "output": {"history_every": 7},
    }
    history, reason = answer.reference_run(scene(block={"tilt_deg": 16.0}, **stop))
    assert reason.startswith("block overturned at t = ")
    assert float(reason.split()[-2]) == pytest.approx(history["time_s"][-1])
    assert history["block.angle_rad"][-1] == pytest.approx(2 * math.atan(0.25), abs=5e-3)


def test_the_file_has_every_so_many_steps_and_the_last(tmp_path: Path) -> None:
    asked = scene(block={"tilt_deg": 3.0}, output={"history_every": 300})
    answer.reference_history(asked, tmp_path / "history.csv")
    again = History.read(tmp_path / "history.csv")
    np.testing.assert_allclose(again["time_s"], [0.0, 0.3, 0.6, 0.9, 1.0])


PLATFORM = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
SQUAT = {"width": 1.0, "height": 0.3}
SHAKING = {"kind": "sine", "amplitude_g": 0.4, "period": 0.6, "cycles": 6}
ROLLERS = {
    "kind": "elastic",
    "support": "rollers",
    "width": 2.0,
    "height": 0.1,
    "young": 2e11,
    "poisson": 0.3,
    "mass_ratio": 2.0,
    "period": 0.5,
    "damping_ratio": 0.05,
}


@pytest.mark.parametrize("foundation", [PLATFORM, ROLLERS])
def test_block_on_a_platform(foundation: dict[str, Any]) -> None:
    """T2 of the design, whatever the platform is made of; the ledger closes."""
    asked = scene(block=SQUAT, friction=0.3, end=6.0, foundation=foundation, motion=SHAKING)
    assert answer.reference_name(asked) == answer.ON_PLATFORM
    history = answer.reference_history(asked)
    assert np.abs(history["platform.drift_m"]).max() == pytest.approx(0.10089, abs=6e-6)
    assert history["block.slip_m"][-1] == pytest.approx(0.1359, abs=6e-5)
    centre = history["block.slip_m"] + history["platform.drift_m"]
    np.testing.assert_allclose(history["block.centre_x_m"], centre)
    gained = history["energy.total_J"] - history["energy.total_J"][0] - history["energy.input_J"]
    lost = history["energy.friction_J"] + history["energy.damping_J"]
    np.testing.assert_allclose(gained, -lost, atol=2e-5 * lost[-1])
    slope = np.gradient(history["platform.drift_m"], history["time_s"])
    np.testing.assert_allclose(slope, history["platform.velocity_m_s"], atol=2e-3)


@pytest.mark.parametrize("initial", ["static", "unstressed"])
def test_sloped_platform_with_a_thrown_block(initial: str) -> None:
    """The incline works on the platform, too: still the ledger closes."""
    block = SQUAT | {"velocity": [0.5, 0.0]}
    time = {"end": 1.0, "step": 1e-3, "initial": initial}
    asked = scene(block=block, friction=0.3, gravity_tilt_deg=5.0, foundation=PLATFORM, time=time)
    history = answer.reference_history(asked)
    held = 503.0 * 1.5 * 9.81 * math.sin(math.radians(5.0)) / asked.platform().stiffness
    assert history["platform.drift_m"][0] == pytest.approx(held * (initial == "static"))
    change = history["energy.total_J"] - history["energy.total_J"][0]
    lost = history["energy.friction_J"] + history["energy.damping_J"]
    np.testing.assert_allclose(change, -lost, atol=1e-4 * lost[-1])
    assert history["energy.friction_J"][-1] > 10


def test_friction_laws_and_vertical_motion() -> None:
    """A law with cohesion holds what mu alone would not; heave changes the normal force."""
    push = {"kind": "rectangular", "amplitude_g": 0.24, "duration": 0.5}
    cohesion = 0.1 * WEIGHT / (0.25 * 0.75)
    law = {"static": 0.2, "cohesion": cohesion}
    held = scene(motion=push, contact={"friction": law})
    assert answer.expected_mode(held) == "rest"
    assert answer.expected_mode(scene(motion=push, friction=0.2)) == "slide"
    heave = {"vertical": {"kind": "rectangular", "amplitude_g": -0.5, "duration": 0.5}}
    lifted = scene(block=SQUAT, motion=push | heave, friction=0.3)
    history = answer.reference_history(lifted)
    assert history["base.vertical_acceleration_m_s2"][100] == pytest.approx(-4.905)
    assert history["block.normal_force_N"][100] == pytest.approx(WEIGHT / 2)
    assert history["block.slip_m"][-1] < -0.05


@pytest.mark.parametrize(
    ("tables", "line"),
    [
        ({"dimension": 3}, "dimension: got 3, allowed 2 where a rigid-body reference"),
        ({"gravity": 0}, "gravity: got 0, allowed gravity > 0 where"),
        ({"block": {"angular_velocity": 1.0}}, "block.angular_velocity: got 1.0, allowed 0 where"),
        ({"block": {"velocity": [0, 1]}}, "block.velocity: got [0.0, 1.0], allowed [0, 0], or"),
        ({"block": {"velocity": [1, 0], "tilt_deg": 1}}, "block.velocity: got [1.0, 0.0], allo"),
        ({"block": {"velocity": [1, 0]}}, "block.velocity: got [1.0, 0.0] of a block that may sl"),
        (
            {"foundation": PLATFORM, "block": {"velocity": [1, 0]}},
            "foundation.kind: got a block that would rock at ",
        ),
        (
            {"motion": {"vertical": {"kind": "rectangular", "amplitude_g": 1, "duration": 1}}},
            "motion.vertical: got 9.81 m/s2, allowed less than gravity",
        ),
    ],
)
def test_scenes_without_a_reference(tables: dict[str, Any], line: str) -> None:
    with pytest.raises(SceneError) as caught:
        answer.reference_history(scene(**tables))
    assert str(caught.value).startswith(line)
    assert "\n" not in str(caught.value)


def test_stacks_and_frames_have_no_reference() -> None:
    two = [BLOCK | {"name": "low"}, BLOCK | {"name": "top", "on": "low"}]
    content = {"block": two, "time": {"end": 1.0, "step": 1e-3}}
    with pytest.raises(SceneError, match=r"^block: got 2 blocks, allowed one block where"):
        answer.reference_history(parse_scene(content))
    frame = {
        "kind": "frame",
        "deck": {"width": 2.0, "height": 0.1},
        "column": {"width": 0.1},
        "storey": 1.0,
        "density": 7850.0,
        "young": 2e11,
        "poisson": 0.3,
    }
    with pytest.raises(SceneError, match=r'^foundation.kind: got "frame", allowed any other'):
        answer.reference_history(scene(foundation=frame))


@pytest.mark.parametrize("tilt", [0.0, 4.0, -4.0])
def test_friction_that_holds_a_block_carries_it_along_and_up_the_incline(tilt: float) -> None:
    """m a - m g sin b where an incline of angle b pulls to +x, until it is beyond mu m g cos b."""
    push = {"kind": "half_sine", "amplitude_g": 0.4, "duration": 0.5}
    asked = scene(
        block={"width": 1.0, "height": 0.5}, motion=push, gravity_tilt_deg=tilt, friction=0.2
    )
    assert answer.reference_name(asked) == answer.SLIDING
    history = answer.reference_history(asked)
    time, b = history["time_s"], math.radians(tilt)
    wanted = 503.0 * 9.81 * (0.4 * np.sin(2 * math.pi * time) - math.sin(b))
    most = 0.2 * WEIGHT * math.cos(b)
    until = int(np.argmax(np.abs(wanted) > most))
    assert until > 50
    np.testing.assert_allclose(history["block.friction_force_N"][:until], wanted[:until], atol=1e-6)
    assert history["block.friction_force_N"][until + 1] == pytest.approx(most)


@pytest.mark.parametrize("tilt", [0.0, 3.0, -3.0])
def test_demand_is_over_the_gravity_that_the_ground_leaves(tilt: float) -> None:
    """(0.3 + |sin b|)/(cos b - 0.5): ground that may go down with half of gravity."""
    push = {"kind": "half_sine", "amplitude_g": 0.3, "duration": 0.5}
    heave = push | {"amplitude_g": -0.5}
    asked = scene(motion=push | {"vertical": heave}, gravity_tilt_deg=tilt)
    b = math.radians(tilt)
    wanted = (0.3 + abs(math.sin(b))) / (math.cos(b) - 0.5)
    assert demand(asked, read_ground(asked)) == pytest.approx(wanted)
    lost = scene(motion=push | {"vertical": push | {"amplitude_g": 1.0}})
    assert demand(lost, read_ground(lost)) == math.inf
