"""Types of numpy arrays, by what they hold."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""Real numbers."""

Indices: TypeAlias = NDArray[np.int64]
"""Whole numbers: indices, counts, states."""

Mask: TypeAlias = NDArray[np.bool_]
"""Truth values."""
