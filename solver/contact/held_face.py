"""A level face of what is held altogether as what carries others: a plane with ends."""

from __future__ import annotations

import numpy as np

from solver.contact.body_points import FixedPoints, SurfaceState
from solver.contact.facet_target import Face
from solver.contact.kernels.plane import places_within
from solver.contact.projection import ContactKinematics, in_space
from solver.types import Array, Indices, Mask


class HeldFace(Face):
    """A rectangular face whose nodes stand still: what `Face` finds on its facets, closed forms.

    It neither rises nor is stretched, so that places of points are those over a plane, and the work
    of forces is exact. What holds it takes them.
    """

    def __init__(
        self, points: FixedPoints, facets: Indices, frame: Array, cell: str, degree: int = 1
    ):
        """Take what `Face` does."""
        super().__init__(points, facets, frame, cell, degree)
        along = points.reference @ self.frame[1:].T
        self._level = (points.reference[0] @ self.frame[0]) * self.frame[0]
        beyond = self.margin * self.facet
        self._ends = along.min(axis=0) - beyond, along.max(axis=0) + beyond

    def rotate_frame(self, rotation: Array) -> None:
        """Leave the frame as it is: the face does not turn."""

    def kinematics(self, position: Array, carrier: SurfaceState | None) -> ContactKinematics:
        """Gaps and tangential positions of points in space."""
        place, beyond = np.empty(position.shape), np.empty(len(position), dtype=np.bool_)
        places_within(position, self._level, self.frame, *self._ends, place, beyond)
        return ContactKinematics(place, place, self.frame, carrier, beyond_edge=beyond)

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces as vectors in space, whose work is exact."""
        return in_space(force, self.frame)

    def reaction(
        self, old: ContactKinematics, new: ContactKinematics, vectors: Array
    ) -> Array | None:
        """None: nobody asks for the forces on what does not move."""
        return None

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Zero: the work of the vectors is exact."""
        return 0.0

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """Points beyond an end of the face."""
        return kinematics.beyond_edge
