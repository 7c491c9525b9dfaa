"""Rigid blocks that slide: on a floor, an incline, a platform, with every law of friction."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ledger import completed as run
from rigid import SQUAT, G, scene, table
from scipy.integrate import solve_ivp

from rockslip import History
from solver.reference.sliding import Resistance, sliding

MASS = 500.0

#: T2's platform: mass ratio 2, period .5 s, 5 % damping.
PLATFORM = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
#: T2's motion.
SINE = {"kind": "sine", "amplitude_g": 0.4, "period": 0.6, "cycles": 6}


def slid(d: int, friction: Any, end: float, step: float, **tables: Any) -> History:
    """History of a block too squat to rock; every step had a solution."""
    found = run(scene(d, SQUAT, end=end, step=step, friction=friction, **tables), ledger=1e-10)
    assert found.summary["cost"]["rejected_steps"] == 0
    return found.history


def test_the_acceleration_of_the_platform_does_not_alternate_while_it_sticks() -> None:
    """Without slip it is a linear oscillator: no part of the acceleration has the period 2 dt."""
    history = slid(2, 10.0, 4.0, 5e-4, foundation=PLATFORM, motion=SINE)
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
    history = slid(2, 0.9, 1.0, 1e-3, foundation=PLATFORM, gravity_tilt_deg=20.0)
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
    history = slid(2, law, 1.0, 1e-3, gravity_tilt_deg=20.0)
    slip = float(history["block.slip_m"][-1])
    if holds:
        assert abs(slip) < 1e-12
        return
    kept = 0.0 if law.get("cohesion_lost") else law.get("cohesion", 0.0) / along
    share = law.get("dynamic", law["static"]) / math.tan(slope) + kept
    assert slip == pytest.approx(G * math.sin(slope) * (1 - share) / 2, rel=1e-9)


@pytest.mark.parametrize(("step", "tolerance"), [(1e-3, 2e-2), (5e-4, 1e-2)])
def test_stick_slip_neither_chatters_nor_fails(
    step: float, tolerance: float, tmp_path: Path
) -> None:
    """mu_s .6, mu_d .3 on the platform under slowly growing shaking, against its ODE.

    The jump comes within a step: first order. Each stick and each slip of the ODE, and no others.
    """

    def acceleration(time: float) -> float:
        return G * (0.05 + 0.1 * time) * math.sin(2 * math.pi * time / 0.6)

    times = np.linspace(0.0, 8.0, 1601).tolist()
    file = table(tmp_path, ((time, acceleration(time)) for time in times))
    motion = {"kind": "table", "file": file, "units": "m/s2"}
    law = {"static": 0.6, "dynamic": 0.3}
    given = scene(2, SQUAT, end=8.0, step=step, friction=law, foundation=PLATFORM, motion=motion)
    found = run(given)
    assert found.summary["cost"]["rejected_steps"] == 0
    slip = found.history["block.slip_m"]
    reference = sliding(
        platform=given.platform(),
        mass=MASS,
        friction=Resistance(law=given.friction_of(given.blocks[0])),
        gravity=G,
        acceleration=acceleration,
        end=8.0,
        step=1e-3,
    )
    exact = np.interp(found.history["time_s"], reference.time, reference.slip)
    assert np.abs(slip - exact).max() < tolerance * np.abs(exact).max()
    moving = np.abs(np.diff(slip)) > 1e-10
    moving_exactly = reference.slip_velocity != 0
    assert np.sum(moving[1:] != moving[:-1]) == np.sum(moving_exactly[1:] != moving_exactly[:-1])


def test_ground_that_moves_in_a_circle() -> None:
    """Against a particle on a disc of friction: the slip follows the ground, and never sticks."""
    along = {"kind": "sine", "amplitude_g": 0.4, "period": 0.6}
    late = 0.15  # a quarter of the period
    motion = along | {"second": along | {"start": late}}
    history = slid(3, 0.2, 1.2, 5e-4, motion=motion)

    def rate(t: float, y: Any) -> Any:
        ground = [np.sin(2 * np.pi * t / 0.6), np.sin(2 * np.pi * (t - late) / 0.6) * (t > late)]
        speed = math.hypot(y[2], y[3])
        bound, pull = 0.2 * G, -0.4 * G * np.array(ground)
        if speed > 1e-7:
            friction = -bound * y[2:] / speed
        else:
            friction = -pull * min(1.0, bound / max(np.linalg.norm(pull), 1e-9))
        return np.r_[y[2:], pull + friction]

    time = history["time_s"]
    exact = solve_ivp(rate, (0, 1.2), [0.0] * 4, t_eval=time, rtol=1e-8, max_step=1e-3).y[:2]
    error = np.stack([history["block.centre_x_m"], history["block.centre_y_m"]]) - exact
    assert np.linalg.norm(error, axis=0).max() < 1e-3 * np.linalg.norm(exact, axis=0).max()


def test_static_friction_breaks_once_and_for_all_corners(tmp_path: Path) -> None:
    """A ground that pulls harder and harder: stuck up to mu_s, then sliding on mu_d."""
    pull, end = 0.3 * G, 2.0
    file = table(tmp_path, [(0.0, 0.0), (end + 1.0, pull * (end + 1.0))])
    along = {"kind": "table", "file": file, "units": "m/s2"}
    motion = along | {"scale": 0.6, "second": along | {"scale": 0.8}}
    history = slid(3, {"static": 0.5, "dynamic": 0.2}, end, 5e-4, motion=motion)
    slip, start = np.hypot(history["block.slip_m"], history["block.slip_second_m"]), 0.5 * G / pull
    assert slip[round(start / 5e-4) - 2] < 1e-10
    rest = end - start
    assert slip[-1] == pytest.approx(pull * rest**3 / 6 + 0.3 * G * rest**2 / 2, rel=2e-3)
