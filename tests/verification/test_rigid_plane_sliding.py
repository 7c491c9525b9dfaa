"""Rigid blocks that slide: on a floor, an incline, a platform, with every law of friction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.reference.sliding import Resistance, sliding
from solver.rigid.plane.system import PlaneSystem

G = 9.81
MASS = 500.0

#: T2's platform: mass ratio 2, period .5 s, 5 % damping.
PLATFORM = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
#: T2's motion.
SINE = {"kind": "sine", "amplitude_g": 0.4, "period": 0.6, "cycles": 6}


def scene(friction: float | dict[str, Any], end: float, step: float, **tables: Any) -> Scene:
    """A block too squat to rock, with changes."""
    block = {"width": 1.0, "height": 0.2, "mass": MASS, "model": "rigid"}
    block |= tables.pop("block", {})
    contact, time = {"friction": friction}, {"end": end, "step": step}
    return parse_scene({"block": [block], "contact": contact, "time": time} | tables)


def run(*arguments: Any, gain: float = 1e-9, **tables: Any) -> Result:
    """The scene's run; it completed, gained no energy and its ledger closes."""
    result = simulate(scene(*arguments, **tables))
    assert result.status == "completed"
    assert result.summary["cost"]["rejected_steps"] == 0
    assert result.summary["energy"]["largest_gain_fraction"] < gain
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10
    return result


def test_the_acceleration_of_the_platform_does_not_alternate_while_it_sticks() -> None:
    """Without slip it is a linear oscillator: no part of the acceleration has the period 2 dt."""
    history = run(10.0, 6.0, 5e-4, foundation=PLATFORM, motion=SINE).history
    acceleration, friction = (
        history["platform.acceleration_m_s2"],
        history["block.friction_force_N"],
    )
    assert np.abs(history["block.slip_m"]).max() < 1e-12
    for values in (acceleration, friction):
        # Second differences of alternating signs, but for the kinks where the motion ends.
        bend = np.diff(values, 2)[5:]
        alternating = np.abs(bend[1:] - bend[:-1]) / np.abs(values).max()
        assert np.sort(alternating)[-20] < 1e-5


def test_static_start_on_an_inclined_platform() -> None:
    """The spring holds all that the platform carries from the start: nothing moves."""
    history = run(0.9, 1.0, 1e-3, foundation=PLATFORM, gravity_tilt_deg=20.0).history
    drift = history["platform.drift_m"]
    stiffness = 250.0 * (2 * math.pi / 0.5) ** 2
    assert drift[0] == pytest.approx(750.0 * G * math.sin(math.radians(20.0)) / stiffness)
    assert np.abs(drift - drift[0]).max() < 1e-12
    assert np.abs(history["block.slip_m"]).max() < 1e-12


@pytest.mark.parametrize(
    ("law", "holds"),
    [
        ({"static": 1.02, "dynamic": 0.5}, True),
        ({"static": 1.02, "dynamic": 0.5, "decay": 10.0}, True),
        ({"static": 0.5, "cohesion": 0.51}, True),
        ({"static": 0.5, "cohesion": 0.51, "cohesion_lost": True}, True),
        ({"static": 0.98, "dynamic": 0.5}, False),
        ({"static": 0.5, "cohesion": 0.49}, False),
        ({"static": 0.5, "cohesion": 0.49, "cohesion_lost": True}, False),
    ],
)
def test_laws_on_an_incline(law: dict[str, Any], holds: bool) -> None:
    """Numbers in units of tan b and of the weight along the slope over the base: stick or slip.

    A block that lets go slides with mu_d and, unless it is lost, the cohesion.
    """
    slope = math.radians(20.0)
    along = MASS * G * math.sin(slope)
    law = {
        key: value * math.tan(slope) if key in ("static", "dynamic") else value
        for key, value in law.items()
    }
    if "cohesion" in law:
        law["cohesion"] = law["cohesion"] * along  # the base has 1 m2
    history = run(law, 1.0, 1e-3, gravity_tilt_deg=20.0).history
    slip = float(history["block.slip_m"][-1])
    if holds:
        assert abs(slip) < 1e-12
        return
    kept = 0.0 if law.get("cohesion_lost") else law.get("cohesion", 0.0) / along
    share = law.get("dynamic", law["static"]) / math.tan(slope) + kept
    assert slip == pytest.approx(G * math.sin(slope) * (1 - share) / 2, rel=1e-9)


@pytest.mark.parametrize(("step", "tolerance"), [(1e-3, 2e-2), (2e-4, 4e-3)])
def test_stick_slip_neither_chatters_nor_fails(step: float, tolerance: float) -> None:
    """mu_s .6, mu_d .3 on the platform under slowly growing shaking, against its ODE.

    The jump comes within a step: first order. Each stick and each slip of the ODE, and no others.
    """
    law = {"static": 0.6, "dynamic": 0.3}
    given = scene(law, 8.0, step, foundation=PLATFORM)

    def acceleration(time: float) -> float:
        return G * (0.05 + 0.1 * time) * math.sin(2 * math.pi * time / 0.6)

    count = round(8.0 / step)
    ground = np.zeros((count + 1, 2))
    ground[:, 0] = [acceleration(step * k) for k in range(count + 1)]
    system = PlaneSystem.from_scene(given)
    outcome = system.advance(count, step, ground)
    assert outcome.failure is None and outcome.rejected == 0
    slip = outcome.rows[:, system.columns.index("block.slip_m")]
    reference = sliding(
        platform=given.platform(),
        mass=MASS,
        friction=Resistance(law=given.friction_of(given.blocks[0])),
        gravity=G,
        acceleration=acceleration,
        end=8.0,
        step=1e-3,
    )
    exact = np.interp(outcome.rows[:, 0], reference.time, reference.slip)
    assert np.abs(slip - exact).max() < tolerance * np.abs(exact).max()
    moving = np.abs(np.diff(slip)) > 1e-10
    moving_exactly = reference.slip_velocity != 0
    assert np.sum(moving[1:] != moving[:-1]) == np.sum(moving_exactly[1:] != moving_exactly[:-1])
