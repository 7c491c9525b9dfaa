"""The Kelvin-Voigt element below a contact point, alone and under a mass that falls on it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rebounds import rebound_of_a_mass

from solver.contact.bed import PointBeds
from solver.scene import Bed

STIFFNESS, MASS = 5e9, 2700.0
"""k (Pa/m) and the mass on it (kg/m2), over an area of 1 m2."""
OMEGA = math.sqrt(STIFFNESS / MASS)


def beds(ratio: float) -> PointBeds:
    """One point of 1 m2."""
    return PointBeds(Bed.damped(STIFFNESS, ratio, MASS), np.ones(1))


def landed(ratio: float, dt: float) -> tuple[float, float, float]:
    """A mass that falls on the bed with 1 m/s: rebound, and the energies lost and taken, J.

    It moves by the trapezoidal rule under the mean force, as rigid bodies do in a step.
    """
    bed, before, y, v, taken = beds(ratio), np.zeros(1), 0.3 * dt, -1.0, 0.0
    for _ in range(int(8 / (OMEGA * dt))):
        give = bed.yielding(before, dt)
        free = y + dt * v + float(give.offset[0])
        force = max(0.0, -free / (dt**2 / (2 * MASS) + float(give.softness[0])))
        y += dt * v + dt**2 * force / (2 * MASS)
        v += dt * force / MASS
        before, damping = bed.after(before, np.array([force]), dt)
        taken += damping
        assert before[0] >= 0.0
    return v, MASS / 2 * (1 - v**2), taken


@pytest.mark.parametrize("ratio", [0.0, 0.02, 0.1, 0.5, 0.9])
def test_a_mass_rebounds_as_a_damped_oscillator_that_is_not_pulled(ratio: float) -> None:
    """A thousand steps a radian; the error is of first order where the dashpot is hit."""
    rebound, lost, taken = landed(ratio, 1e-3 / OMEGA)
    assert rebound == pytest.approx(rebound_of_a_mass(ratio), abs=1e-3)
    assert taken == pytest.approx(lost, abs=2e-3 * MASS / 2)


def test_the_spring_alone_gives_back_what_it_took() -> None:
    """At any step that resolves the landing at all, but for the closing within a step."""
    errors = [1 - landed(0.0, part / OMEGA)[0] for part in (0.2, 0.1, 0.05)]
    assert errors[0] < 0.01
    assert errors[2] < errors[0] / 8
    assert min(errors) > -1e-12


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
