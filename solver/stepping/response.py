"""How bodies answer to forces at contact points: their compliance, and the motion they take.

A body takes part in interfaces with its points (it is carried) or with what it carries them on (it
carries). For all of them together it offers its free motion and its compliance, and takes forces:
an elastic body with its factorized tangent in the frame that turns with it, a rigid block or a
platform with its mass. The contact problem sees only rows and a small dense matrix.

A response holds nothing of an iteration. What a body is like at a displacement is its
configuration, and how it takes part in a set of points its coupling; each is a value that is passed
on to the next call. So is a motion, a correction of its unknowns as surface points are read from
it: of a meshed body in the frame that turns with it; of a rigid one all unknowns, on every rank.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from solver.bodies.dense_body import DenseBody
from solver.contact.body_points import SurfacePoints
from solver.contact.kinematics import ContactKinematics, Interpolation, in_frames
from solver.types import Array, Indices, Mask

Configuration = TypeVar("Configuration")
Coupling = TypeVar("Coupling")
Motion = TypeVar("Motion")

Kinematics = Sequence[ContactKinematics | None]
"""Kinematics of all interfaces; None for one that a step leaves out."""


@dataclass(frozen=True, slots=True)
class BodyRole:
    """One body's part in an interface.

    Attributes:
        interface: Number of the interface.
        first: Number of its first point among the points of all interfaces.
        count: Number of its points.
        carries: Whether the body carries the points, or has them.
        points: The body's own surface points.
        port: Number of the first of them among all ports of the body.
    """

    interface: int
    first: int
    count: int
    carries: bool
    points: SurfacePoints
    port: int

    @property
    def sign(self) -> float:
        """Sign with which the body's motion enters gap and slip."""
        return -1.0 if self.carries else 1.0

    @property
    def own(self) -> slice:
        """Numbers of the points of its interface among those of all."""
        return slice(self.first, self.first + self.count)

    def spots(self, kinematics: Kinematics) -> Interpolation | None:
        """Where the contact points are among the body's own; None where they are the same."""
        own = kinematics[self.interface]
        if own is None:
            return None
        return own.foot if self.carries else own.own_projection


class CandidateSet(NamedTuple):
    """Points that are in contact or near it, of all interfaces.

    Attributes:
        number: Their numbers among all points, rising.
        frames: Rows normal and tangents at each of them, (m, d, d).
        kinematics: Kinematics of all interfaces, for where carried points stand.
        pressed: Those that are in contact, as far as is known beforehand, (m,).
    """

    number: Indices
    frames: Array
    kinematics: Kinematics
    pressed: Mask

    def members(self, sides: Sequence[BodyRole]) -> list[tuple[int, Indices, Indices]]:
        """For each side that has any: its number, places of its points here, their own numbers."""
        result = []
        for k, side in enumerate(sides):
            inside = (self.number >= side.first) & (self.number < side.first + side.count)
            places = np.flatnonzero(inside)
            if len(places):
                result.append((k, places, self.number[places] - side.first))
        return result


class Response(Protocol[Configuration, Coupling, Motion]):
    """What a body offers to the contact problem."""

    @property
    def nbytes(self) -> float:
        """Memory that it takes, on all ranks together, bytes."""

    def at(self, u: Array, start: Array | None) -> Configuration:
        """The configuration at u, in a step at whose start the body had the rotation `start`."""

    def of_mass(self, u: Array) -> Configuration:
        """The configuration in which the mass alone answers; u: owned unknowns."""

    def close(self, now: Configuration, before: Configuration) -> bool:
        """Whether compliances are the same in both, as far as corrections need it."""

    def free(self, at: Configuration, residual: Array) -> Motion:
        """The free motion -K^-1 r, without any change of contact forces."""

    def read(
        self,
        at: Configuration,
        free: Motion,
        moved: Array,
        frames: Sequence[Array],
        kinematics: Kinematics,
    ) -> None:
        """Add what a free motion does to the augmented positions of all points to `moved`."""

    def couple(self, at: Configuration, near: CandidateSet, weight: float, W: Array) -> Coupling:
        """Add `weight` times the compliance among near points to W (m, d, m, d)."""

    def at_rest(self) -> Motion:
        """A motion of zero."""

    def respond(
        self,
        at: Configuration,
        coupling: Coupling,
        near: CandidateSet,
        force: Array,
        weight: float,
        motion: Motion,
    ) -> Array:
        """The correction of the owned unknowns by a motion and what forces at near points add.

        Forces, (m, d), N, count `weight` times.
        """

    def owned(self, at: Configuration, motion: Motion) -> Array:
        """A motion as a correction of the owned unknowns."""


AnyResponse = Response[Any, Any, Any]
"""The response of a body, whatever its kind."""


class DenseConfiguration(NamedTuple):
    """Rows of the surface points of a rigid body at a displacement, side by side of its roles.

    Attributes:
        pose: All unknowns; None for a body whose rows are the same everywhere.
        rows: Derivatives of the positions of its own points, (points, d, unknowns).
        level: Those of points that it carries on an endless plane.
    """

    pose: Array | None
    rows: Sequence[Array]
    level: Sequence[Array]


class DenseResponse:
    """Response of a rigid block or of a platform: rows on few unknowns."""

    def __init__(self, body: DenseBody, tangent: Array, sides: Sequence[BodyRole]):
        """Take the body, the diagonal of its tangent or mass, and its parts in interfaces."""
        self.body, self.tangent, self.sides = body, tangent, sides
        self._standing = None if body.turns else self._configuration(np.zeros(body.unknowns))

    @property
    def nbytes(self) -> float:
        """0: a few numbers."""
        return 0.0

    def at(self, u: Array, start: Array | None) -> DenseConfiguration:
        """Rows of all surface points at a displacement; those of a step's start are not needed."""
        if self._standing is not None:
            return self._standing
        return self._configuration(self.body.replicate(u))

    def of_mass(self, u: Array) -> DenseConfiguration:
        """Rows of all surface points where the body is."""
        return self.at(u, None)

    def _configuration(self, pose: Array) -> DenseConfiguration:
        """Rows of all surface points for all unknowns."""
        rows = [self.body.rows(side.points.reference, pose) for side in self.sides]
        # What carries points on an endless plane moves all of them alike.
        level = [
            np.repeat(-rows_of_side[:1], side.count, axis=0)
            for side, rows_of_side in zip(self.sides, rows, strict=True)
        ]
        return DenseConfiguration(pose if self.body.turns else None, rows, level)

    def close(self, now: DenseConfiguration, before: DenseConfiguration) -> bool:
        """Whether the body has not moved, or has the same rows wherever it is."""
        if now.pose is None or before.pose is None:
            return True
        return bool((now.pose == before.pose).all())

    def free(self, at: DenseConfiguration, residual: Array) -> Array:
        """The free motion -K^-1 r."""
        return self.body.replicate(-residual / self.tangent[self.body.own])

    def at_rest(self) -> Array:
        """A motion of zero."""
        return np.zeros(self.body.unknowns)

    def _at(
        self,
        at: DenseConfiguration,
        number: int,
        kinematics: Kinematics,
        own: slice | Indices = slice(None),
    ) -> Array:
        """Rows of the points of a side's interface in what this body does to them."""
        side, rows = self.sides[number], at.rows[number]
        spots = side.spots(kinematics)
        if spots is None:
            return at.level[number][own] if side.carries else rows[own]
        weights, nodes = side.sign * spots.weights[own], spots.nodes[own]
        return np.einsum("mk,mkdu->mdu", weights, rows[nodes])

    def read(
        self,
        at: DenseConfiguration,
        free: Array,
        moved: Array,
        frames: Sequence[Array],
        kinematics: Kinematics,
    ) -> None:
        """Add what a free motion does to the positions of all points to `moved`."""
        for number, side in enumerate(self.sides):
            if kinematics[side.interface] is None:
                continue
            rows = self._at(at, number, kinematics)
            moved[side.own] += in_frames(rows @ free, frames[side.interface])

    def couple(self, at: DenseConfiguration, near: CandidateSet, weight: float, W: Array) -> Array:
        """Add the compliance among near points; returns their rows, (m, d, unknowns)."""
        J = np.zeros((*W.shape[:2], self.body.unknowns))
        for number, places, own in near.members(self.sides):
            J[places] += self._at(at, number, near.kinematics, own)
        J = near.frames @ J
        W += weight * np.tensordot(J / self.tangent, J, ([2], [2]))
        return J

    def respond(
        self,
        at: DenseConfiguration,
        coupling: Array,
        near: CandidateSet,
        force: Array,
        weight: float,
        motion: Array,
    ) -> Array:
        """The correction of the owned unknowns by a motion and by forces on the rows of points."""
        moved = weight * (force.ravel() @ coupling.reshape(force.size, -1)) / self.tangent
        return self.owned(at, motion + moved)

    def owned(self, at: DenseConfiguration, motion: Array) -> Array:
        """The part of a motion that this rank owns."""
        return motion[self.body.own]
