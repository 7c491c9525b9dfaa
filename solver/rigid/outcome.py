"""What a number of steps of rigid blocks came to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Advance:
    """Rows of steps, and how they went."""

    rows: NDArray[np.float64]
    """One row a step that succeeded, in the order of the system's `columns`."""
    rejected: int
    """Solutions that failed and were tried again with smaller steps."""
    failure: str | None
    """When and why it stopped early, or None."""
