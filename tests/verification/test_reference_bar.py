"""The closed form of the bouncing bar against leapfrog at Courant number 1, and its energy."""

import numpy as np
import pytest
from bar_impact import (
    ENERGY,
    PERIOD,
    contact_stress,
    displacement,
    velocity,
)

CELLS = 60
X = np.linspace(0.0, 1.0, CELLS + 1)


def leapfrog(steps):
    """The wave equation with dt = dx, where the scheme is exact; node 0 is kept from below."""
    old = (1 - X) / 2
    now = old.copy()  # one step after a release at rest: the mean of the neighbours
    now[1:-1] = (old[2:] + old[:-2]) / 2
    now[0] = old[1]
    yield old
    for _ in range(steps):
        yield now
        new = np.zeros_like(now)
        new[1:-1] = now[2:] + now[:-2] - old[1:-1]
        new[0] = max(0.0, 2 * now[1] - old[0])
        old, now = now, new


def test_displacement_against_leapfrog():
    for step, expected in enumerate(leapfrog(2 * 3 * CELLS)):
        found = displacement(step / CELLS + 1e-12, X)
        # The wave leaves the wall one step late in the projected scheme at most.
        np.testing.assert_allclose(found, expected, atol=1.01 / CELLS, err_msg=f"step {step}")


@pytest.mark.parametrize("time", [0.0, 0.77, 1.5, 2.25, 4.3])
def test_energy_velocity_and_stress_from_displacement(time):
    x = (np.arange(4000) + 0.5) / 4000
    small = 1e-6
    rate = (displacement(time + small, x) - displacement(max(time - small, 0.0), x)) / (
        time + small - max(time - small, 0.0)
    )
    smooth = np.abs(rate - velocity(time, x)) < 1e-9
    assert smooth.mean() > 0.999
    strain = (displacement(time, x + small) - displacement(time, x - small)) / (2 * small)
    energy = np.mean(velocity(time, x) ** 2 + strain**2) / 2
    assert energy == pytest.approx(ENERGY, rel=1e-3)
    at_wall = displacement(time, np.array([0.0, small]))
    assert at_wall[0] >= 0
    assert (at_wall[1] - at_wall[0]) / small == pytest.approx(contact_stress(time), abs=1e-9) or (
        time == 0.0
    )


def test_clamped_and_periodic():
    for time in np.linspace(0, PERIOD, 31):
        assert displacement(time, np.array([1.0]))[0] == pytest.approx(0.0, abs=1e-15)
        np.testing.assert_allclose(
            displacement(time + 1e-9, X), displacement(time + 1e-9 + 2 * PERIOD, X), atol=1e-12
        )


def test_contact_lasts_a_third_and_its_impulse_turns_the_bar():
    times = (np.arange(3000) + 0.5) / 1000
    stress = np.array([contact_stress(time) for time in times])
    assert set(stress) == {0.0, -0.5}
    assert np.mean(stress != 0) == pytest.approx(1 / 3)
    touching = np.array([displacement(time, np.zeros(1))[0] == 0 for time in times])
    np.testing.assert_array_equal(touching, stress != 0)
