"""Steps chosen by their error, against fixed ones."""

from __future__ import annotations

import math

from mpi4py import MPI

import numpy as np
import pytest
from scipy.integrate import quad

from benchmarks import adaptive_steps as benchmark
from rockslip import Result, Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.errors import SceneError
from solver.results.rocking import peaks
from solver.stepping.local_error import LocalError

BETA = 3e-5
"""beta_R, s: what an impact shakes dies before the next one, so that there is a limit."""
RESTITUTION = 0.9378
"""Restitution of each impact in the limit of small steps: .9377 .9377 .9376 .9379 with a tenth of
the tolerance; fixed steps of 4e-5, 2e-5 and 1e-5 s give .9357 .9372 .9376 for the first."""
IMPACTS = (0.1916, 0.5434, 0.8673)
"""Times of the impacts with a tenth of the tolerance, s."""


def scene(*overrides: str) -> Scene:
    """The paper's block, damped, up to its third impact."""
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
        "damping": {"stiffness": BETA},
        "time": {"end": 0.95},
        "output": {"fields": "none"},
    }
    return parse_scene(tables, overrides=overrides)


def impacts(result: Result, key: str) -> list[float]:
    """Values of the block's impacts in the summary."""
    found = result.summary["blocks"]["block"]["impacts"]
    return [impact[key] for impact in found if impact[key] is not None]


@pytest.fixture(scope="module")
def run() -> Result:
    """A scene that says nothing about steps."""
    return simulate(scene())


@pytest.mark.slow
def test_impacts_lose_what_they_lose_in_the_limit_of_small_steps(run: Result) -> None:
    """Fixed steps of 1e-3 s, as many, give .91, and the third impact 5 % too early."""
    assert impacts(run, "restitution") == pytest.approx([RESTITUTION] * 3, abs=1e-3)
    assert impacts(run, "time_s") == pytest.approx(IMPACTS, rel=1e-3)
    assert run.summary["cost"]["steps"] < 1400


@pytest.mark.slow
@pytest.mark.parametrize("override", ["time.tolerance=4e-3", "time.largest=2.5e-3"])
def test_neither_the_tolerance_nor_the_first_step_decides(run: Result, override: str) -> None:
    """A fourth or four times of either: restitution and times stay."""
    other = simulate(scene(override))
    here = impacts(run, "restitution")
    assert impacts(other, "restitution") == pytest.approx(here, abs=1e-3)
    assert impacts(other, "time_s") == pytest.approx(impacts(run, "time_s"), rel=1e-3)


@pytest.mark.slow
def test_a_calibrated_block_rocks_as_a_rigid_one_with_the_restitution_of_the_tests() -> None:
    """Figure 7: with the damping that `--target restitution=0.936` finds, against Housner's ODE."""
    run = simulate(scene("damping.stiffness=4.05e-5", "time.end=1.5"))
    assert impacts(run, "restitution")[:4] == pytest.approx([0.936] * 4, abs=1e-3)
    housner = (0.1916, 0.5423, 0.8644, 1.1612, 1.4353)
    assert impacts(run, "time_s")[:5] == pytest.approx(housner, rel=1e-3)
    turns = peaks(run.history["time_s"], run.history["block.angle_rad"], math.atan(0.25))[1:4]
    found = [math.degrees(abs(angle)) for _, angle in turns]
    assert found == pytest.approx([2.586, 2.235, 1.936], rel=5e-3)


@pytest.mark.slow
def test_vibration_that_lasts_meets_the_next_impact_in_its_phase() -> None:
    """A soft block, whose damping leaves 0.6 of its vibration until the next impact.

    Fixed steps of 5e-5, 2.5e-5 and 1.25e-5 s give .9501 .9504 .9505; a bound on vibration that
    does not look at damping gave .9477 here.
    """
    soft = scene("block.young=5e9", "time.end=0.62")
    assert soft.vibration_left == pytest.approx(0.635, abs=0.01)
    assert impacts(simulate(soft), "restitution")[0] == pytest.approx(0.9505, abs=1e-3)


def test_a_landing_in_the_first_step_is_resolved() -> None:
    """A block starts with the speed of a fall from 10 cm. In the limit it keeps 0.60 of that.

    Fixed steps of 2e-5 s give .594; a first step as long as those that follow gave .645.
    """
    tables = benchmark.scene("dropped flat", BETA)
    tables["time"]["end"] = 0.15
    found = simulate(parse_scene(tables))
    assert benchmark.rebound(found.history) == pytest.approx(0.5975, abs=4e-3)


@pytest.mark.slow
def test_a_touch_at_the_very_end_of_a_step_is_resolved() -> None:
    """On an oscillator, where one such touch made the second impact 0.16 % too early."""
    tables = benchmark.scene("on an oscillator", 1e-4)
    found = benchmark.answer("on an oscillator", parse_scene(tables))
    assert found.times == pytest.approx([0.28584, 0.40612, 0.59286, 0.67439], rel=5e-4)
    assert np.degrees(found.peaks) == pytest.approx([-1.1461, 0.8193, -1.1048], rel=1e-3)


@pytest.mark.slow
def test_an_elastic_impact_lasts() -> None:
    """From impact to impact a rigid block takes two quarters of a swing, an elastic 0.3 ms more.

    So the impacts of an elastic block come later than those of Housner's, whose impacts take no
    time, by about 0.3 ms for each impact, at any tolerance.
    """
    run = simulate(scene("time.tolerance=1e-4"))
    shape = scene().blocks[0].shape
    alpha, p = shape.slenderness(), math.sqrt(3 * 9.81 / (4 * shape.half_diagonal))

    def quarter(peak: float) -> float:
        """Time that a rigid block takes from a peak to its impact, s."""

        def slowness(x: float) -> float:  # theta = peak - x^2: no pole at the peak
            fall = math.cos(alpha - peak + x**2) - math.cos(alpha - peak)
            return 2 * x / (p * math.sqrt(2 * abs(fall)))

        return float(quad(slowness, 0, math.sqrt(peak))[0])

    found = peaks(run.history["time_s"], run.history["block.angle_rad"], alpha)[1:3]
    first, _, third = impacts(run, "time_s")
    swings = sum(2 * quarter(abs(angle)) for _, angle in found)
    assert (third - first - swings) / 2 == pytest.approx(3.0e-4, abs=3e-5)


def test_short_steps_stand_at_impacts_and_long_ones_between(run: Result) -> None:
    """After an impact the block bounces a few times, for less than 50 ms."""
    time, step = run.history["time_s"], run.history["step_s"]
    assert 4e-3 < step.max() <= 1e-2
    calm_since = 0.01
    for impact in impacts(run, "time_s"):
        assert step[np.abs(time - impact) < 1e-3].min() <= 2e-5
        assert step[(time > calm_since) & (time < impact - 0.01)].min() > 5e-4
        calm_since = impact + 0.05


def test_the_ledger_closes_over_steps_of_all_lengths(run: Result) -> None:
    assert run.status == "completed"
    assert run.summary["cost"]["rejected_steps"] > 10
    assert run.summary["energy"]["largest_gain_fraction"] < 1e-6
    assert run.summary["energy"]["ledger_error_fraction"] < 1e-10
    assert run.history["step_s"][1:] == pytest.approx(np.diff(run.history["time_s"]), rel=1e-9)


@pytest.mark.parametrize("shape", ["as a whole", "bending"])
def test_the_estimate_is_the_error_of_the_trapezoidal_rule(shape: str) -> None:
    """A block in the air whose points move by x = j t^3/6 exactly, all alike or as a parabola."""
    jerk, dt = 6.0, 1e-3
    assembly = build(scene("block.tilt_deg=0", "gravity=0"), comm=MPI.COMM_SELF)
    state, _ = initial_state(scene("block.tilt_deg=0", "gravity=0"), assembly)
    body, size = assembly.members[0].body, 0.5
    unit = np.zeros(body.size)
    along = body.nodes[:, 1] - 0.5
    unit[0::2] = 1.0 if shape == "as a whole" else along**2 - 1 / 12
    estimate = LocalError(assembly.stepper.system, size)
    past = estimate.start(state)
    for step in range(1, 5):
        fast, far = unit * jerk / 2 * (step * dt) ** 2, unit * jerk / 6 * (step * dt) ** 3
        found, past = estimate.of(past, state._replace(u=far, v=fast, motions={}), dt)
    moved = jerk / 6 * dt**3 * (4**3 - 3**3)
    trapezoid = dt * jerk / 4 * dt**2 * (4**2 + 3**2)
    error = abs(trapezoid - moved) / size
    if shape == "as a whole":
        assert found.rigid == pytest.approx(error, rel=1e-6)
        assert found.vibration < 1e-6 * error
    else:
        assert found.rigid < 1e-3 * error
        assert found.vibration == pytest.approx(error / math.sqrt(180), rel=1e-2)


def test_what_a_scene_says_of_time_is_filled_in() -> None:
    assert scene().time.adaptive and scene().time.step == scene().time.largest / 4
    assert not scene("time.step=1e-3").time.adaptive
    rigid = scene('block.model="rigid"')
    assert rigid.time.step == 2e-4 and not rigid.time.adaptive
    shaken = {"kind": "half_sine", "amplitude_g": 0.3, "duration": 0.02}
    assert (
        parse_scene(scene().to_dict() | {"time": {"end": 1.0}, "motion": shaken}).time.largest
        == 1e-3
    )
    stiff = scene("block.young=1e20", "block.mass=0.5", "block.cells=[2, 4]")
    assert stiff.time.largest < 1e-5, "refused with steps as long as those of softer blocks"
    with pytest.raises(SceneError, match="sound crosses"):
        scene("block.young=1e20", "block.mass=0.5", "time.step=1e-3")
