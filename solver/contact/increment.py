"""An interface over a step, between whose ends its forces do their work."""

from __future__ import annotations

from typing import NamedTuple

from solver.contact.body_points import SurfaceState
from solver.contact.projection import ContactKinematics
from solver.types import Array

Observed = tuple[SurfaceState, ContactKinematics]
"""An interface at one instant: its points, and where they are over their carrier."""

Parts = tuple[Array | None, Array | None]
"""Owned unknowns of the body of the points and of its carrier, or forces on them; None for the
ground."""


class ContactIncrement(NamedTuple):
    """An interface over a step, or over an iteration of it.

    Attributes:
        before: The interface at t_n, in the frame of the step.
        after: At t_{n+1}.
        force: Point forces f at t_{n+1}, (points, d), N.
    """

    before: Observed
    after: Observed
    force: Array


class ForceWeights(NamedTuple):
    """How the forces of an interface count.

    Attributes:
        contact: w_c, of point forces.
        traction: 1 - alpha_f for the theta term of Nitsche's method, int (theta/gamma_h) T.DT[v],
            or 0 to leave it out.
        sign: 1, or -1 to subtract all of them.
    """

    contact: float
    traction: float
    sign: float

    @property
    def tractions(self) -> tuple[float, float]:
        """Weights of the tractions at t_n and t_{n+1}: alpha_f and 1 - alpha_f, with the sign."""
        old = self.sign * (1.0 - self.traction) if self.traction else 0.0
        return old, self.sign * self.traction
