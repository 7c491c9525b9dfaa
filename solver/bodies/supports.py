"""Supports of a meshed body: held facets, and springs to the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Support:
    """Facets whose displacement is held, in some directions or in all.

    Attributes:
        facets: Numbers of boundary facets.
        directions: Held components of the displacement.
    """

    facets: NDArray[np.int32]
    directions: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundSpring:
    """A horizontal spring and dashpot to the ground, spread evenly over some facets.

    Attributes:
        facets: Numbers of boundary facets.
        stiffness: k of the whole spring, N/m.
        dashpot: c of the whole dashpot, N s/m.
    """

    facets: NDArray[np.int32]
    stiffness: float
    dashpot: float = 0.0
