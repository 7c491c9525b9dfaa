"""A level face of what is fully restrained as what carries others: a plane with ends."""

from __future__ import annotations

from solver.contact.body_points import FixedPoints
from solver.contact.facet_target import Face
from solver.contact.plane_target import Flat
from solver.contact.projection import ContactKinematics
from solver.types import Array, Indices


class HeldFace(Flat, Face):
    """A rectangular face whose nodes stand still: what `Face` finds on its facets, closed forms.

    It neither rises nor is stretched, so that places of points are those over a plane, and the work
    of forces is exact. What holds it takes them.
    """

    def __init__(
        self, points: FixedPoints, facets: Indices, frame: Array, cell: str, degree: int = 1
    ):
        """Take what `Face` does."""
        Face.__init__(self, points, facets, frame, cell, degree)
        along, beyond = points.reference @ self.frame[1:].T, self.margin * self.facet
        level = (points.reference[0] @ self.frame[0]) * self.frame[0]
        self._lay(self.frame, level, (along.min(axis=0) - beyond, along.max(axis=0) + beyond))

    def reaction(
        self, old: ContactKinematics, new: ContactKinematics, vectors: Array
    ) -> Array | None:
        """None: nobody asks for the forces on what does not move."""
        return None
