"""What carries contact points: the protocol, and an endless plane; meshed faces have own files.

For points in space a carrier gives the gap g along the normal of the step's frame and the
tangential position s, in the coordinates of its own material, so that the stick memory travels with
it. The increments of both between two instants are products of its rows with increments of
position, exactly: that is what makes the work of contact forces a difference of states.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from geometry.foundation import level_frame
from solver.contact.body_points import FacePoints, RigidPoints, SurfaceState
from solver.contact.projection import ContactKinematics, in_space, spread
from solver.types import Array, Mask


class Carrier(Protocol):
    """What carries contact points."""

    turns: bool
    """Whether its frame turns with its body."""

    @property
    def frame(self) -> Array:
        """Rows normal and tangents, (d, d); or one frame for each contact point, (m, d, d)."""

    @property
    def points(self) -> FacePoints | None:
        """The carrier's own points, on which forces act; None for the ground."""

    def kinematics(self, position: Array, carrier: SurfaceState | None) -> ContactKinematics:
        """Gaps and tangential positions of points in space."""

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces (normal, tangential) as vectors in space, whose work is exact."""

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Work of these vectors less that of the forces on (g, s), where it is not exact, J."""

    def reaction(
        self, old: ContactKinematics, new: ContactKinematics, vectors: Array
    ) -> Array | None:
        """Forces on the carrier's own points."""

    def carried(self, kinematics: ContactKinematics, values: Array) -> Array:
        """What vectors of the carrier's points are at the contact points, or at all, (1, d)."""

    def rotate_frame(self, rotation: Array) -> None:
        """Let the frame of the coming step be that of the turned body."""

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """Points beyond the edge of the carrier; None where it has none."""


class Plane:
    """An endless plane that does not turn: the ground's, or that of a rigid platform.

    Attributes:
        frame: Rows normal and tangents, (d, d).
        origin: A point of it, m.
        points: One point of the platform that it belongs to; None for the ground.
    """

    turns = False

    def __init__(self, frame: Array, origin: Array, platform: RigidPoints | None = None):
        """Take rows normal and tangents, (d, d), a point of the plane, m, and one of a platform."""
        self.frame, self.origin, self.points = frame, origin, platform

    @classmethod
    def level(cls, dimension: int, platform: RigidPoints | None = None) -> Plane:
        """The horizontal plane at level 0."""
        return cls(level_frame(dimension), np.zeros(dimension), platform)

    def kinematics(self, position: Array, carrier: SurfaceState | None) -> ContactKinematics:
        """Gaps and tangential positions of points in space."""
        origin = self.origin if carrier is None else self.origin + carrier.position[0]
        place = (position - origin) @ self.frame.T
        return ContactKinematics(place, place, self.frame, carrier)

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces (normal, tangential) as vectors in space, whose work is exact."""
        return in_space(force, self.frame)

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Zero: the work of the vectors is exact."""
        return 0.0

    def rotate_frame(self, rotation: Array) -> None:
        """Leave the frame as it is: it does not turn."""

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """None: it has no edge."""
        return None

    def reaction(
        self, old: ContactKinematics, new: ContactKinematics, vectors: Array
    ) -> Array | None:
        """Forces on the carrier's own points; None for the ground."""
        return None if self.points is None else -vectors.sum(axis=0)[None, :]

    def carried(self, kinematics: ContactKinematics, values: Array) -> Array:
        """What vectors of the carrier's points are at all contact points alike, (1, d)."""
        return values[:1]


class FacetCarrier:
    """A carrier that is part of a mesh, whose nodes take what presses on it."""

    turns = True
    points: FacePoints
    """Its nodes."""

    def reaction(
        self, old: ContactKinematics, new: ContactKinematics, vectors: Array
    ) -> Array | None:
        """Forces on the nodes: half at the places before, half at those after."""
        if not vectors.any():
            return None
        assert old.foot is not None and new.foot is not None
        return spread(old.foot, new.foot, -vectors, self.points.count)

    def carried(self, kinematics: ContactKinematics, values: Array) -> Array:
        """What vectors of the nodes are at the contact points."""
        assert kinematics.foot is not None
        return kinematics.foot.carried(values)
