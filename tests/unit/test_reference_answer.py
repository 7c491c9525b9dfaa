"""The rigid-body answer in the columns of a run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry.arrangement import initial_position
from solver.post.history import History
from solver.reference import answer
from solver.reference.shenton import release_friction, rocking_friction
from solver.scene import Scene, parse_scene

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
    centre = initial_position(shape, 0.1, math.radians(tilt))(np.array([[0.0, 0.5]]))[0]
    assert history["block.centre_x_m"][0] == pytest.approx(centre[0])
    assert history["block.centre_y_m"][0] == pytest.approx(centre[1])
    lifted, pivot = ("left", "right") if tilt > 0 else ("right", "left")
    assert history[f"block.gap_{lifted}_m"][0] == pytest.approx(0.25 * math.sin(math.radians(3)))
    assert history[f"block.gap_{pivot}_m"][0] == 0.0
    demand = history["block.friction_force_N"][0] / history["block.normal_force_N"][0]
    needed = release_friction(math.radians(3), shape.slenderness)
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


def test_incline_slides_as_galileo_says() -> None:
    """Down s = g (sin b - mu cos b) t^2/2; the gravity that is lost is kinetic or friction."""
    tilt = math.radians(10)
    history = answer.reference_history(scene(gravity_tilt_deg=10.0, friction=0.1))
    rate = 9.81 * (math.sin(tilt) - 0.1 * math.cos(tilt))
    np.testing.assert_allclose(
        history["block.slip_m"], rate * history["time_s"] ** 2 / 2, atol=1e-9
    )
    change = history["energy.total_J"] - history["energy.total_J"][0]
    np.testing.assert_allclose(change, -history["energy.friction_J"], atol=1e-6)


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


def test_the_file_has_every_so_many_steps(tmp_path: Path) -> None:
    asked = scene(block={"tilt_deg": 3.0}, output={"history_every": 10})
    answer.reference_history(asked, tmp_path / "history.csv")
    again = History.read(tmp_path / "history.csv")
    np.testing.assert_allclose(again["time_s"], np.arange(101) * 0.01)
