"""Supports of a meshed body: held facets, and springs to the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Support:
    """Facets whose displacement is held, in some directions or in all."""

    facets: NDArray[np.int32]
    """Numbers of boundary facets."""
    directions: tuple[int, ...]
    """Held components of the displacement."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundSpring:
    """A horizontal spring and dashpot to the ground, spread evenly over some facets."""

    facets: NDArray[np.int32]
    """Numbers of boundary facets."""
    stiffness: float
    """k of the whole spring, N/m."""
    dashpot: float = 0.0
    """c of the whole dashpot, N s/m."""
