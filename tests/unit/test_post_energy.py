"""Energy measures, on histories whose answers are known by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from ledger import ledger_error, stored_energy

from rockslip import History
from solver.history.columns import columns
from solver.results import energy


def test_scale_adds_start_power_and_weight() -> None:
    """30 J above rest, power +2 -5 +1 J, 1e-3 of 1000 J."""
    work = np.array([0.0, 2.0, -3.0, -2.0])
    assert energy.scale(work, above_rest=30.0, weight_height=1000.0) == pytest.approx(39.0)


def test_scale_of_a_block_that_settles_below_upright() -> None:
    """A static start lies below the undeformed block: nothing is above rest then."""
    assert energy.scale(np.zeros(2), above_rest=-0.1, weight_height=1000.0) == pytest.approx(1.0)


def test_without_weight_and_motion_nothing_can_be_said() -> None:
    """No gravity, no motion: the scale is 0, and fractions of it are not known."""
    assert energy.scale(np.zeros(2), above_rest=0.0, weight_height=0.0) == 0.0
    assert math.isnan(energy.largest_gain_fraction(np.zeros(2), np.zeros(2), 0.0))
    assert math.isnan(energy.ledger_error_fraction(np.zeros(2), 0.0))


def test_gain_counts_only_what_the_ground_did_not_give() -> None:
    """A rise of 5 J with 4 J of work is a gain of 1 J; a loss is no gain."""
    total = np.array([10.0, 15.0, 2.0])
    work = np.array([0.0, 4.0, 4.0])
    assert energy.largest_gain_fraction(total, work, 10.0) == pytest.approx(0.1)
    falling = np.array([10.0, 9.0, 8.0])
    assert energy.largest_gain_fraction(falling, 0 * falling, 10.0) == 0.0


def test_ledger_of_a_history() -> None:
    """Total and ledger error are made of the single columns; the losses are those at the end."""
    history = History(columns(["block"]))
    values = dict.fromkeys(history.columns, 0.0)
    for k in range(3):
        values |= {
            "time_s": 0.1 * k,
            "energy.kinetic_J": 5.0 - 2 * k,
            "energy.strain_J": 1.0,
            "energy.gravity_J": 100.0,
            "energy.spring_J": 0.25,
            "energy.interface_J": 0.5 * k,
            "energy.input_J": 3.0 * k,
            "energy.friction_J": 1.0 * k,
            "energy.damping_J": 2.0 * k,
            "energy.contact_damping_J": 0.25 * k,
            "energy.contact_J": 0.25 * k,
            "energy.numerical_J": 1.0 * k + 1e-3 * k,
        }
        history.append([values[name] for name in history.columns])
    np.testing.assert_allclose(stored_energy(history), [106.25, 104.75, 103.25])
    error = ledger_error(history)
    np.testing.assert_allclose(error, [0, 1e-3, 2e-3], atol=1e-12)
    assert energy.ledger_error_fraction(error, 10.0) == pytest.approx(2e-4)
    assert energy.losses(history) == pytest.approx(
        {
            "friction_J": 2.0,
            "damping_J": 4.0,
            "contact_damping_J": 0.5,
            "contact_J": 0.5,
            "numerical_J": 2.002,
        }
    )
