"""The closed forms of a block on a platform under samples, against the integrator of any motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene
from solver.excitation.sampled import SampledMotion
from solver.reference.answer import reference_history
from solver.reference.friction import Resistance, coulomb
from solver.reference.platform import PlatformReference, sliding_on_platform
from solver.reference.platform_sampled import sampled_sliding_on_platform
from solver.scene import FrictionSpec
from solver.scene.foundation import Platform

pytestmark = pytest.mark.serial


def shaking(step: float = 0.02, count: int = 150) -> SampledMotion:
    """Rough samples that begin and end with a jump, none of them at time 0."""
    time = 0.013 + step * np.arange(count)
    noise = np.random.default_rng(4).uniform(-1.0, 1.0, count)
    return SampledMotion(time=time, value=4.0 * np.cos(11.0 * time) + noise)


def answer(motion: SampledMotion, step: float = 5e-3, **changes: Any) -> PlatformReference:
    given: dict[str, Any] = {
        "platform": Platform.on_spring(500.0, period=0.5, stiffness=None, damping_ratio=0.05),
        "mass": 1000.0,
        "friction": coulomb(0.1),
        "gravity": 9.81,
        "end": 3.2,
    }
    given |= changes
    if given.pop("integrated", False):
        return sliding_on_platform(acceleration=motion.acceleration, step=step, **given)
    return sampled_sliding_on_platform(motion=motion, step=step, **given)


JUMP = Resistance(law=FrictionSpec(static=0.25, dynamic=0.12))
GLUE = Resistance(law=FrictionSpec(static=0.1, cohesion=1.0, cohesion_lost=True), cohesion=0.7)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"friction": JUMP, "along": -0.4},
        {"friction": GLUE},
        {"friction": coulomb(0.0), "velocity": 0.3},
        {"friction": coulomb(5.0), "velocity": -0.2},
        {"platform": Platform.on_spring(500.0, period=0.5, stiffness=None, damping_ratio=1.4)},
    ],
)
def test_it_agrees_with_the_integrator(changes: dict[str, Any]) -> None:
    """Every number, to what the integrator gives: it steps over the kinks of the samples."""
    one = answer(shaking(), **changes)
    other = answer(shaking(), **changes, integrated=True)
    for name in ("slip", "slip_velocity", "drift", "drift_velocity", "friction"):
        exact, found = getattr(other, name), getattr(one, name)
        # Friction jumps where the slip rate changes its sign, maybe just before an output time.
        good = np.abs(found - exact) < 1e-6 * max(np.abs(exact).max(), 1e-3)
        assert good.sum() >= len(good) - (2 if name == "friction" else 0), name
    assert np.abs(other.drift).max() > 0.01
    np.testing.assert_array_equal(one.time, other.time)


def test_it_does_not_depend_on_the_output_step() -> None:
    fine, coarse = answer(shaking(), step=1e-3), answer(shaking(), step=0.05)
    for name in ("slip", "slip_velocity", "drift", "drift_velocity", "drift_acceleration"):
        np.testing.assert_allclose(
            getattr(fine, name)[::50], getattr(coarse, name), rtol=0, atol=1e-11
        )


def test_momentum_and_energy_are_kept_to_round_off() -> None:
    """Impulse of the ground, spring and dashpot; work of the ground against what is lost."""
    motion = shaking()
    found = answer(motion, step=2e-4)
    m, k, c = Platform.on_spring(500.0, period=0.5, stiffness=None, damping_ratio=0.05)
    momentum = 1000.0 * (found.slip_velocity + found.drift_velocity) + m * found.drift_velocity
    ground = motion.velocities(found.time)
    spring = np.cumsum(np.concatenate([[0], (found.drift[1:] + found.drift[:-1]) / 2 * 2e-4]))
    np.testing.assert_allclose(
        momentum + (1000.0 + m) * ground + k * spring + c * found.drift, 0.0, atol=2e-2
    )
    assert np.abs(momentum).max() > 500.0


def test_a_law_with_decay_is_refused() -> None:
    law = Resistance(law=FrictionSpec(static=0.2, dynamic=0.1, decay=5.0))
    with pytest.raises(ValueError, match="depends on the speed"):
        answer(shaking(), friction=law)


def test_a_scene_with_samples_has_this_answer(tmp_path: Path) -> None:
    """The columns of the history, beside those by the integrator (a law that decays at once)."""
    motion = shaking(count=60)
    rows = zip(motion.time, motion.value, strict=True)
    (tmp_path / "table.csv").write_text("".join(f"{t},{a}\n" for t, a in rows))
    scene = parse_scene(
        {
            "block": [{"width": 1, "height": 0.5, "thickness": 1, "mass": 1e3, "model": "rigid"}],
            "foundation": {"kind": "oscillator", "mass_ratio": 2, "period": 0.5},
            "contact": {"friction": 0.1},
            "motion": {"kind": "table", "file": "table.csv", "units": "m/s2"},
            "time": {"end": 1.2, "step": 2e-3},
        },
        folder=tmp_path,
    )
    history = reference_history(scene)
    slow = FrictionSpec(static=0.1 * (1 + 1e-9), dynamic=0.1, decay=1e6)
    other = reference_history(replace(scene, contact=replace(scene.contact, friction=slow)))
    for name in history.columns:
        if not np.isnan(other[name]).all() and name != "block.friction_force_N":
            scale = max(np.abs(other[name]).max(), 1e-9)
            np.testing.assert_allclose(history[name], other[name], atol=1e-5 * scale, err_msg=name)
    assert np.abs(history["platform.drift_m"]).max() > 0.05
