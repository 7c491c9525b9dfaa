"""The energy ledger of a history, found again from its columns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rockslip import History
from solver.history.columns import DISSIPATED_ENERGIES, STORED_ENERGIES


def stored_energy(history: History) -> NDArray[np.float64]:
    """Sum of the stored energies, J."""
    return np.sum([history[f"energy.{name}_J"] for name in STORED_ENERGIES], axis=0)


def ledger_error(history: History) -> NDArray[np.float64]:
    """Total - total at the start - work of the ground + everything dissipated, J."""
    stored = stored_energy(history)
    lost = np.sum([history[f"energy.{name}_J"] for name in DISSIPATED_ENERGIES], axis=0)
    return np.asarray(stored - stored[0] - history["energy.input_J"] + lost)
