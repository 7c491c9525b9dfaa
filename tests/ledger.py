"""Runs that account for their energy, and the ledger found again from the columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rockslip import History, Result, Scene, simulate
from solver.history.columns import DISSIPATED_ENERGIES, STORED_ENERGIES


def completed(
    given: Scene, *, gain: float = 1e-9, ledger: float = 1e-9, folder: Path | None = None
) -> Result:
    """A run that goes to its end, gains no energy and accounts for all of it."""
    result = simulate(given, folder=folder)
    assert result.status == "completed", result.summary["reason"]
    assert result.summary["energy"]["largest_gain_fraction"] < gain
    assert result.summary["energy"]["ledger_error_fraction"] < ledger
    return result


def stored_energy(history: History) -> NDArray[np.float64]:
    """Sum of the stored energies, J."""
    return np.sum([history[f"energy.{name}_J"] for name in STORED_ENERGIES], axis=0)


def ledger_error(history: History) -> NDArray[np.float64]:
    """Total - total at the start - work of the ground + everything dissipated, J."""
    stored = stored_energy(history)
    lost = np.sum([history[f"energy.{name}_J"] for name in DISSIPATED_ENERGIES], axis=0)
    return np.asarray(stored - stored[0] - history["energy.input_J"] + lost)
