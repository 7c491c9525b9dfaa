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
    """How the forces of an interface count, with their sign.

    Attributes:
        points: Point forces: w_c.
        old: Tractions at t_n, in the theta term of Nitsche's method, int (theta/gamma_h) T.DT[v]:
            alpha_f, or 0 to leave the term out.
        new: Those at t_{n+1}: 1 - alpha_f, or 0.
    """

    points: float
    old: float
    new: float

    @classmethod
    def of(cls, contact: float, traction: float, sign: float) -> ForceWeights:
        """Weights by w_c and 1 - alpha_f, which is 0 to leave the theta term out.

        The sign is 1, or -1 to subtract all forces.
        """
        old = sign * (1.0 - traction) if traction else 0.0
        return cls(sign * contact, old, sign * traction)
