"""What a step starts from, and what it exchanges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solver.contact.interface import Memory

Array = NDArray[np.float64]


@dataclass(slots=True)
class State:
    """Everything a step starts from.

    Attributes:
        time: t_n, s.
        u: Displacement of the owned unknowns of all bodies, m.
        v: Velocity, m/s.
        p: Inertia force M a without that of the impulses, which are contact, loads and damping, N.
        contacts: Memory of each interface.
        kinetic: Kinetic energy, J.
        strain: Strain energy, J.
        spring: Energy of springs to the ground, J.
        exchanged: Interface energy lost since t_n by choosing other contact points, J.
    """

    time: float
    u: Array
    v: Array
    p: Array
    contacts: Sequence[Memory]
    kinetic: float = 0.0
    strain: float = 0.0
    spring: float = 0.0
    exchanged: float = 0.0


@dataclass(slots=True)
class Exchange:
    """Energy that a step took in or lost, J; each term from its own formula."""

    input: float = 0.0
    friction: float = 0.0
    damping: float = 0.0
    contact: float = 0.0
    numerical: float = 0.0
    iterations: int = 0
