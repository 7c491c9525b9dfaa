"""Steps chosen by their error, against fixed ones."""

from __future__ import annotations

from dataclasses import replace

from mpi4py import MPI

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.stepping.local_error import LocalError

#: Of the paper's block, with fixed steps of 1e-5 s and of 2e-5 s: .88196 and .88369 s.
THIRD_IMPACT = 0.882


def scene(*overrides: str) -> Scene:
    """The paper's block up to its third impact."""
    block = {
        "width": 0.25,
        "height": 1.0,
        "thickness": 0.75,
        "mass": 503.0,
        "young": 5.0e10,
        "poisson": 0.2,
        "tilt_deg": 3.0,
    }
    tables = {
        "block": [block],
        "contact": {"friction": 0.7},
        "time": {"end": 0.95, "step": 1e-3},
        "output": {"fields": "none"},
    }
    return parse_scene(tables, overrides=overrides)


@pytest.fixture(scope="module")
def run() -> Result:
    """With short steps around impacts."""
    return simulate(scene("time.adaptive=true", "time.tolerance=3e-7"))


@pytest.mark.slow
def test_the_third_impact_is_that_of_much_shorter_fixed_steps(run: Result) -> None:
    """Fixed steps of 1e-3 s, as many iterations, are wrong by .065 s; of 1e-4 s by .005 s."""
    impacts = [impact["time_s"] for impact in run.summary["blocks"]["block"]["impacts"]]
    assert impacts[0] == pytest.approx(0.19163, abs=1e-4)
    assert impacts[2] == pytest.approx(THIRD_IMPACT, abs=0.015)
    assert run.summary["cost"]["steps"] < 2200


def test_short_steps_stand_at_impacts_and_long_ones_between(run: Result) -> None:
    time, step = run.history["time_s"], run.history["step_s"]
    shortest = time[np.flatnonzero(step == step.min())]
    impacts = [impact["time_s"] for impact in run.summary["blocks"]["block"]["impacts"]]
    assert step.max() == 4e-3
    assert step.min() <= 1e-3 / 8
    assert all(np.abs(shortest - impact).min() < 0.01 for impact in impacts[:2])
    assert not ((shortest > 0.01) & (shortest < 0.18)).any()


def test_the_ledger_closes_over_steps_of_all_lengths(run: Result) -> None:
    assert run.status == "completed"
    assert run.summary["cost"]["rejected_steps"] > 10
    assert run.summary["energy"]["largest_gain_fraction"] < 1e-6
    assert run.summary["energy"]["ledger_error_fraction"] < 1e-10
    assert run.history["step_s"][1:] == pytest.approx(np.diff(run.history["time_s"]), rel=1e-9)


def test_the_estimate_is_the_error_of_the_trapezoidal_rule() -> None:
    """A block in the air that is pulled by a force growing with time: x = j t^3/6 exactly."""
    jerk, dt = 6.0, 1e-3
    assembly = build(scene("block.tilt_deg=0", "gravity=0"), comm=MPI.COMM_SELF)
    state, _ = initial_state(scene("block.tilt_deg=0", "gravity=0"), assembly)
    body, size = assembly.members[0].body, 0.5
    unit = np.zeros(body.size)
    unit[0::2] = 1.0
    estimate = LocalError(assembly.stepper.system, state, size)
    for step in (1, 2, 3):
        fast = unit * jerk / 2 * (step * dt) ** 2
        found = estimate.of(replace(state, v=fast, motions={}), dt)
        estimate.accept()
    moved = jerk / 6 * dt**3 * (3**3 - 2**3)
    trapezoid = dt * jerk / 4 * dt**2 * (3**2 + 2**2)
    assert found * size == pytest.approx(abs(trapezoid - moved), rel=1e-6)
