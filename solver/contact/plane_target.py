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
from solver.contact.kernels.plane import places
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


NOWHERE: Mask = np.empty(0, dtype=np.bool_)
"""Points beyond the end of what has none."""


class Flat:
    """A plane that does not turn, endless or with ends: places on it are closed forms.

    Attributes:
        frame: Rows normal and tangents, (d, d).
        origin: A point of it, m.
    """

    frame: Array
    origin: Array

    def _lay(self, frame: Array, origin: Array, ends: tuple[Array, Array] | None) -> None:
        """Take frame, origin, and least and greatest tangential positions; None: it is endless."""
        self.frame, self.origin, self.is_endless = frame, origin, ends is None
        d = len(origin)
        reach = np.array([[-np.inf] * d, [np.inf] * d])
        if ends is not None:
            reach[:, 1:] = ends
        self._lies: Array = np.concatenate([origin[None], np.zeros((1, d)), reach, frame])

    def lies(self, carrier: SurfaceState | None) -> Array:
        """Where it lies, as `places` takes it, once `carrier` has moved; None for the ground."""
        return self._lies

    def room(
        self, count: int, carrier: SurfaceState | None, *, tractions: bool = False
    ) -> tuple[ContactKinematics, Mask]:
        """Kinematics of `count` points to be filled in, and which of them are beyond an end.

        Of an endless plane that is no mask of points at all. Augmented positions of points with
        tractions are others than their places.
        """
        place = augmented = np.empty((count, len(self.origin)))
        if tractions:
            augmented = np.empty(place.shape)
        known = None if self.is_endless else np.empty(count, dtype=np.bool_)
        seen = ContactKinematics(place, augmented, self.frame, carrier, beyond_edge=known)
        return seen, NOWHERE if known is None else known

    def kinematics(self, position: Array, carrier: SurfaceState | None) -> ContactKinematics:
        """Gaps and tangential positions of points in space."""
        seen, beyond = self.room(len(position), carrier)
        places(position, self.lies(carrier), seen.place, beyond)
        return seen

    def vectors(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> Array:
        """Point forces (normal, tangential) as vectors in space, whose work is exact."""
        return in_space(force, self.frame)

    def work_defect(self, old: ContactKinematics, new: ContactKinematics, force: Array) -> float:
        """Zero: the work of the vectors is exact."""
        return 0.0

    def rotate_frame(self, rotation: Array) -> None:
        """Leave the frame as it is: it does not turn."""

    def beyond_edge(self, kinematics: ContactKinematics) -> Mask | None:
        """Points beyond an end; None where it has none."""
        return kinematics.beyond_edge


class Plane(Flat):
    """An endless plane: the ground's, or that of a rigid platform."""

    turns = False

    def __init__(self, frame: Array, origin: Array, platform: RigidPoints | None = None):
        """Take rows normal and tangents, (d, d), and a point of the plane, m.

        `platform` is one point of the platform that it belongs to; None for the ground.
        """
        self._lay(frame, origin, None)
        self.points = platform

    @classmethod
    def level(cls, dimension: int, platform: RigidPoints | None = None) -> Plane:
        """The horizontal plane at level 0."""
        return cls(level_frame(dimension), np.zeros(dimension), platform)

    def lies(self, carrier: SurfaceState | None) -> Array:
        """Where it lies, as `places` takes it, once its platform has moved; None for the ground."""
        if carrier is None:
            return self._lies
        lies = self._lies.copy()
        lies[1] = carrier.position[0]
        return lies

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
