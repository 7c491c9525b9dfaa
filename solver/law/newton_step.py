"""The equations of one Newton step of a local problem of many points, applied and not assembled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.law.newton import STICK, Local, left_over, unknowns, write_forces
from solver.types import Array, Indices, Mask


class StepEquations(NamedTuple):
    """The equations of a Newton step, A x = b, as `solver.law.newton.equations` has them.

    Attributes:
        local: The problem.
        r: Its lengths, (m, 2).
        trial: f - r y, at which they are linearised, (d m,), N.
        states: Of the points, (m,).
        rows: Rows of the unknowns x among all, (n,).
    """

    local: Local
    r: Array
    trial: Array
    states: Indices
    rows: Indices

    @classmethod
    def at(cls, local: Local, r: Array, trial: Array, states: Indices) -> StepEquations:
        """Equations for the forces of closed points."""
        return cls(local, r, trial, states, unknowns(local, states))

    def forces(self, x: Array, *, change: bool = False) -> Array:
        """All forces by the unknowns, or their change by one of these."""
        found, constants = np.empty_like(self.trial), 0.0 if change else 1.0
        write_forces(self.local, self.trial, self.states, self.rows, x, constants, found)
        return found

    def residual(self, x: Array) -> Array:
        """What x leaves of the right-hand side, b - A x."""
        return -left_over(*self, x, self.local.W @ self.forces(x), 1.0)

    def image(self, x: Array) -> Array:
        """A x."""
        return left_over(*self, x, self.local.W @ self.forces(x, change=True), 0.0)

    def diagonal(self) -> Array:
        """Diagonal of A, that of slipping points in space taken as 1."""
        value = self.scales() * self.local.W[self.rows, self.rows]
        value[~self.holds()] = 1.0
        return value

    def scales(self) -> Array:
        """The length r of each unknown, (n,), N/m."""
        point, way = np.divmod(self.rows, self.local.d)
        return np.asarray(self.r[point, np.minimum(way, 1)])

    def holds(self) -> Mask:
        """Unknowns whose equation is r W f = right: normal forces, and those of points that stick.

        Those of points that slip in space are not among them.
        """
        point, way = np.divmod(self.rows, self.local.d)
        return np.asarray((way == 0) | (self.states[point] == STICK))
