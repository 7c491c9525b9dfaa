"""A bed of springs and dashpots between contact points and what carries them (Winkler's bed).

Each point stands on a massless Kelvin-Voigt element: a spring of softness s in parallel with a
dashpot tau/s. With its compression p, the augmented position y and the softness s_N of Nitsche's
method, which is in series with it, a point obeys

    0 <= f  complementary to  y + p + s_N f >= 0,      s f = p + tau dp/dt

so that the bed pushes and never pulls; where the point is open, f = 0 and the bed relaxes. In a
step, f is the mean force (M44):

    s f = (p_n + p_{n+1})/2 + tau (p_{n+1} - p_n)/dt

The spring then gives back what it took, to the last digit, and the dashpot takes
tau (p_{n+1} - p_n)^2/(s dt). The local problem keeps its form: p_{n+1} = (what f = 0 leaves) + s' f
is an offset of the normal gap and a softness of the normal force.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.scene.contact import Bed
from solver.types import Array


class Yielding(NamedTuple):
    """Compression of the bed at the end of a step: p_{n+1} = offset + softness f.

    Attributes:
        offset: Compression that a step without force would leave, (points,), m; a dashpot that is
            slack overshoots, so that it may be negative.
        softness: (points,), m/N.
    """

    offset: Array
    softness: Array


class BedChange(NamedTuple):
    """Change of the bed of an interface in a step.

    Attributes:
        compression: p_{n+1}, (points,), m.
        damping: What the dashpots took, J.
    """

    compression: Array
    damping: float


class PointBeds:
    """The elements below the points of one interface.

    Attributes:
        softness: s of each point, (points,), m/N.
        retardation: tau, s: dashpot over spring.
    """

    def __init__(self, bed: Bed, area: Array):
        """Share the bed out.

        Args:
            bed: Of the block.
            area: What each point stands for, (points,), m2.
        """
        self.softness: Array = np.asarray(1.0 / (bed.stiffness * area), dtype=np.float64)
        self.retardation = bed.retardation

    def yielding(self, before: Array, step: float) -> Yielding:
        """Offset and softness of the compressions at the end of a step.

        Args:
            before: Compression p_n, (points,), m.
            step: dt, s; infinite in equilibrium, where the force is that of the spring.
        """
        viscous, mean = self.retardation / step, 0.0 if np.isinf(step) else 0.5
        whole = viscous + 1.0 - mean
        softness = np.asarray(self.softness / whole, dtype=np.float64)
        return Yielding(before * ((viscous - mean) / whole), softness)

    def after(self, before: Array, normal: Array, step: float) -> BedChange:
        """The bed after a step.

        What a point leaves behind relaxes, and the dashpot takes it; without a dashpot it is gone
        at once. A mean force that pushes may end in a compression below zero: it counts as none.

        Args:
            before: Compression p_n, (points,), m.
            normal: Normal point forces, (points,), N.
            step: As in `yielding`.
        """
        closed = normal > 0.0
        offset, softness = self.yielding(before, step)
        reached = offset + softness * normal
        left = np.exp(-step / self.retardation) if self.retardation > 0 else 0.0
        compression = np.where(closed, np.maximum(reached, 0.0), before * left)
        taken = np.where(closed, (self.retardation / step) * (reached - before) ** 2, 0.0)
        if self.retardation > 0:
            taken += np.where(closed, 0.0, 0.5 * (before**2 - compression**2))
        return BedChange(compression, float(np.sum(taken / self.softness)))

    def energy(self, compression: Array) -> float:
        """Energy of the springs, J."""
        return 0.5 * float(np.sum(compression**2 / self.softness))
