"""Rigid blocks that slide: on a floor, an incline, a platform, with every law of friction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rockslip import Result, Scene, parse_scene, simulate
from solver.excitation.kinds import base_motion
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


@pytest.mark.parametrize("step", [2e-3, 5e-4, 1e-4])
@pytest.mark.parametrize(
    ("friction", "peak", "slip"), [(0.1, 0.07699, -0.1001), (0.3, 0.10089, 0.1359)]
)
def test_block_on_a_platform(friction: float, peak: float, slip: float, step: float) -> None:
    """T2: peak drift within 0.01 %, final slip within 0.1 % at every step."""
    history = run(friction, 6.0, step, foundation=PLATFORM, motion=SINE).history
    assert np.abs(history["platform.drift_m"]).max() == pytest.approx(peak, rel=1.5e-4)
    assert history["block.slip_m"][-1] == pytest.approx(slip, rel=1e-3)


def test_the_platform_follows_the_ode() -> None:
    """T2 with mu .1 and its many reversals, against the event-driven ODE at all times."""
    given = scene(0.1, 6.0, 5e-4, foundation=PLATFORM, motion=SINE)
    history = simulate(given).history
    motion = base_motion(given.motion, 6.0)
    assert motion is not None
    reference = sliding(
        platform=given.platform(),
        mass=MASS,
        friction=0.1,
        gravity=G,
        acceleration=motion.acceleration,
        end=6.0,
        step=5e-4,
    )
    for column, exact in (("platform.drift_m", reference.drift), ("block.slip_m", reference.slip)):
        assert np.abs(history[column] - exact).max() < 3e-4 * np.abs(exact).max()


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


@pytest.mark.parametrize(("step", "tolerance"), [(1e-3, 5e-5), (5e-4, 1e-5)])
def test_half_sine_pulse(step: float, tolerance: float) -> None:
    """T3: residual slip 0.0996332 m against the pulse."""
    pulse = {"kind": "half_sine", "amplitude_g": 0.5, "duration": 0.5}
    history = run(0.3, 1.5, step, motion=pulse).history
    assert history["block.slip_m"][-1] == pytest.approx(-0.0996332, rel=tolerance)


def test_an_incline_holds_just_below_its_limit() -> None:
    """At mu = 1.02 tan b: friction is m g sin b, no creep at all."""
    slope = math.radians(20.0)
    tall = {"height": 1.0}
    given = (1.02 * math.tan(slope), 5.0, 1e-3)
    history = run(*given, gravity_tilt_deg=20.0, block=tall).history
    slip = history["block.slip_m"]
    assert abs(slip[-1] - slip[1000]) < 1e-14
    assert history["block.friction_force_N"][-1] == pytest.approx(-MASS * G * math.sin(slope))
    assert history["block.normal_force_N"][-1] == pytest.approx(MASS * G * math.cos(slope))


def test_an_incline_lets_go_just_above_it() -> None:
    """At mu = 0.98 tan b: g (sin b - mu cos b) t^2/2."""
    slope = math.radians(20.0)
    friction = 0.98 * math.tan(slope)
    history = run(friction, 2.0, 1e-3, gravity_tilt_deg=20.0).history
    exact = G * (math.sin(slope) - friction * math.cos(slope)) * 2.0**2 / 2
    assert history["block.slip_m"][-1] == pytest.approx(exact, rel=1e-10)


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


@pytest.mark.parametrize("step", [1e-3, 3e-4])
def test_sliding_stop(step: float) -> None:
    """v^2/(2 mu g), the end of the slide inside a step."""
    history = run(0.3, 1.2, step, block={"velocity": [2.0, 0.0]}).history
    assert history["block.slip_m"][-1] == pytest.approx(4.0 / (0.6 * G), rel=1e-10)
    lost = history["energy.friction_J"][-1]
    assert lost == pytest.approx(MASS * 4.0 / 2, rel=1e-10)


def test_newmarks_sliding_block() -> None:
    """Rectangular pulse: V^2/(2 mu g) (1 - mu g/a); its end lies between two steps."""
    pulse = {"kind": "rectangular", "amplitude_g": 0.6, "duration": 0.30005}
    history = run(0.3, 2.0, 1e-4, gain=1e-5, motion=pulse).history
    speed = 0.6 * G * 0.30005
    exact = -(speed**2) / (0.6 * G) * (1 - 0.5)
    assert history["block.slip_m"][-1] == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("decay", [1.0, 20.0])
def test_friction_that_decays_with_velocity(decay: float) -> None:
    """A block thrown with 2 m/s, mu_s .6, mu_d .2, against its ODE."""
    law = {"static": 0.6, "dynamic": 0.2, "decay": decay}
    history = run(law, 1.5, 1e-3, block={"velocity": [2.0, 0.0]}).history

    def rate(time: float, state: Any) -> tuple[float, float]:
        return state[1], -G * (0.2 + 0.4 * math.exp(-decay * state[1]))

    def stop(time: float, state: Any) -> float:
        return float(state[1])

    stop.terminal = True  # type: ignore[attr-defined]
    exact = solve_ivp(rate, (0, 3), (0.0, 2.0), events=[stop], rtol=1e-11, atol=1e-13)
    assert history["block.slip_m"][-1] == pytest.approx(exact.y[0, -1], rel=2e-6)


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
