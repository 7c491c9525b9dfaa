"""The Kelvin-Voigt element below a contact point: its energy, in steps and in equilibrium."""

from __future__ import annotations

import math

import numpy as np
import pytest

from solver.contact.bed import PointBeds
from solver.scene import Bed

STIFFNESS, MASS = 5e9, 2700.0
"""k (Pa/m) and the mass on it (kg/m2), over an area of 1 m2."""
OMEGA = math.sqrt(STIFFNESS / MASS)


def beds(ratio: float) -> PointBeds:
    """One point of 1 m2."""
    return PointBeds(Bed.damped(STIFFNESS, ratio, MASS), np.ones(1))


def test_spring_and_dashpot_take_the_work_of_the_force() -> None:
    """To round-off, for any force."""
    random = np.random.default_rng(1)
    bed, before, dt = beds(0.3), np.zeros(1), 0.1 / OMEGA
    for force in random.uniform(0.5, 1.0, 50) * STIFFNESS:
        after, damping = bed.after(before, np.array([force]), dt)
        stored = bed.energy(after) - bed.energy(before)
        work = force * float(after[0] - before[0])
        assert stored + damping == pytest.approx(work, rel=1e-9, abs=1e-9 * bed.energy(after))
        before = after


def test_in_equilibrium_the_spring_holds_the_force() -> None:
    bed = beds(0.3)
    after, damping = bed.after(np.ones(1), np.array([2.0 * STIFFNESS]), math.inf)
    assert after[0] == pytest.approx(2.0)
    assert damping == 0.0


@pytest.mark.parametrize("ratio", [0.0, 0.3])
def test_an_open_point_leaves_a_bed_that_relaxes(ratio: float) -> None:
    bed, dt = beds(ratio), 0.1 / OMEGA
    after, damping = bed.after(np.ones(1), np.zeros(1), dt)
    assert after[0] == pytest.approx(math.exp(-dt * OMEGA / (2 * ratio)) if ratio else 0.0)
    lost = bed.energy(np.ones(1)) - bed.energy(after)
    assert damping == pytest.approx(lost if ratio else 0.0)
    assert bed.yielding(np.ones(1), dt).offset[0] <= after[0]
