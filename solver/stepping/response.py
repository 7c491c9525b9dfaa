"""Responses of bodies to forces at contact points: compliance, and motion.

A body enters interfaces with its points (it is carried) or with what it carries them on (it
carries). For all of them together it offers its free motion and its compliance, and takes forces:
an elastic body with its factorized tangent in the frame that turns with it, a rigid block or a
platform with its mass. The contact problem sees only rows and a small dense matrix.

A response holds nothing of an iteration. What a body is like at a displacement is its
configuration, and its part in a set of points its coupling; each is a value that is passed
on to the next call. So is a motion, a correction of its unknowns as surface points are read from
it: of the owned nodes of a meshed body in the frame that turns with it, (n d,), m; of a rigid one
all unknowns, on every rank.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.bodies.rigid_body import DenseBody
from solver.contact.body_points import RigidPoints, SurfacePoints
from solver.contact.kinematics import ContactKinematics, Interpolation, in_frames
from solver.kernels import meshed
from solver.parallel import global_sum
from solver.stepping.compliance import Compliance, InterfaceDofs
from solver.types import Array, Indices

TURNED = 1e-5
"""Change of the entries of a rotation below which the compliance of a body is not made anew: it is
part of the correction of an iteration, not of the residual, and neglects strains as large."""

Configuration = TypeVar("Configuration")
Coupling = TypeVar("Coupling")

Kinematics = Sequence[ContactKinematics]
"""Kinematics of all interfaces, and of the places of links."""


@dataclass(frozen=True, slots=True)
class BodyRole:
    """One body's part in an interface, or among the places of links behind all of these.

    Attributes:
        interface: Number of the interface.
        first: Number of its first point among the points of all interfaces.
        count: Number of its points.
        carries: True if the body carries the points, or has them.
        points: The body's own surface points, or its places.
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
        """Interpolation from the body's own points to the contact points; None: the same points."""
        own = kinematics[self.interface]
        return own.projection if self.carries else own.own_projection


class PlacesOfBody(NamedTuple):
    """All places of one body at which links and forces act.

    Attributes:
        body: Its number.
        own: Its unknowns.
        places: Numbers of the places.
        first: Number of the first of them among those of all bodies, body after body.
        points: The places.
    """

    body: int
    own: slice
    places: Indices
    first: int
    points: SurfacePoints


class CandidateSet(NamedTuple):
    """Points that are in contact or near it, of all interfaces.

    Attributes:
        number: Their numbers among all points, rising.
        frames: Rows normal and tangents at each of them, (m, d, d).
        kinematics: Kinematics of all interfaces, for where carried points stand.
    """

    number: Indices
    frames: Array
    kinematics: Kinematics

    def members(self, sides: Sequence[BodyRole]) -> list[tuple[int, Indices, Indices]]:
        """For each side that has any: its number, places of its points here, their own numbers."""
        result = []
        for k, side in enumerate(sides):
            inside = (self.number >= side.first) & (self.number < side.first + side.count)
            places = np.flatnonzero(inside)
            if len(places):
                result.append((k, places, self.number[places] - side.first))
        return result


class Response(Protocol[Configuration, Coupling]):
    """The face of a body towards the contact problem."""

    @property
    def nbytes(self) -> float:
        """Memory that it takes, on all ranks together, bytes."""

    def at(self, u: Array, start: Array | None) -> Configuration:
        """The configuration at u, in a step at whose start the body had the rotation `start`."""

    def of_mass(self, u: Array) -> Configuration:
        """The configuration in which the mass alone answers; u: owned unknowns."""

    def close(self, now: Configuration, before: Configuration) -> bool:
        """True if compliances are the same in both, as far as corrections need it."""

    def free(self, at: Configuration, residual: Array) -> Array:
        """The free motion -K^-1 r, without any change of contact forces."""

    def read(
        self,
        at: Configuration,
        motion: Array,
        moved: Array,
        kinematics: Kinematics,
    ) -> None:
        """Add what a motion does to the augmented positions of all points to `moved`."""

    def couple(self, at: Configuration, near: CandidateSet, weight: float, W: Array) -> Coupling:
        """Add `weight` times the compliance among near points to W (m, d, m, d)."""

    def at_rest(self) -> Array:
        """A motion of zero."""

    def moved_by(
        self, at: Configuration, coupling: Coupling, near: CandidateSet, force: Array, weight: float
    ) -> Array:
        """The motion by forces at near points, (m, d), N, which count `weight` times."""

    def owned(self, at: Configuration, motion: Array, further: Array) -> Array:
        """The correction of the owned unknowns that two motions make together."""


AnyResponse = Response[Any, Any]
"""The response of a body, whatever its kind."""


class DenseConfiguration(NamedTuple):
    """Rows of the surface points of a rigid body at a displacement, side by side of its roles.

    Attributes:
        pose: All unknowns; None for a body whose rows are the same everywhere.
        rows: Derivatives of the positions of its own points, (points, d, unknowns).
    """

    pose: Array | None
    rows: Sequence[Array]


def _rows(side: BodyRole, pose: Array) -> Array:
    """Rows of the points of a rigid body for all unknowns, (points, d, unknowns)."""
    assert isinstance(side.points, RigidPoints)
    return side.points.rows(pose)


class DenseResponse:
    """Response of a rigid block or of a platform: rows on few unknowns."""

    def __init__(self, body: DenseBody, tangent: Array, sides: Sequence[BodyRole]):
        """Take the body, the diagonal of its tangent or mass, and its parts in interfaces."""
        self.body, self.tangent, self.sides = body, tangent, sides
        self._unmoved = self._configuration(np.zeros(body.unknowns)) if body.clamped else None

    @property
    def nbytes(self) -> float:
        """0: a few numbers."""
        return 0.0

    def at(self, u: Array, start: Array | None) -> DenseConfiguration:
        """Rows of all surface points at a displacement; those of a step's start are not needed."""
        if self._unmoved is not None:
            return self._unmoved
        return self._configuration(self.body.replicate(u))

    def of_mass(self, u: Array) -> DenseConfiguration:
        """Rows of all surface points where the body is."""
        return self.at(u, None)

    def _configuration(self, pose: Array) -> DenseConfiguration:
        """Rows of all surface points for all unknowns."""
        rows = [_rows(side, pose) for side in self.sides]
        return DenseConfiguration(None if self.body.clamped else pose, rows)

    def close(self, now: DenseConfiguration, before: DenseConfiguration) -> bool:
        """True if the body has not moved, or has the same rows wherever it is."""
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
            # What carries points on an endless plane moves all of them alike.
            return np.repeat(-rows[:1], side.count, axis=0)[own] if side.carries else rows[own]
        weights, nodes = side.sign * spots.weights[own], spots.nodes[own]
        return np.einsum("mk,mkdu->mdu", weights, rows[nodes])

    def read(
        self,
        at: DenseConfiguration,
        motion: Array,
        moved: Array,
        kinematics: Kinematics,
    ) -> None:
        """Add what a motion does to the positions of all points to `moved`."""
        for number, side in enumerate(self.sides):
            rows = self._at(at, number, kinematics)
            moved[side.own] += in_frames(rows @ motion, kinematics[side.interface].frame)

    def couple(self, at: DenseConfiguration, near: CandidateSet, weight: float, W: Array) -> Array:
        """Add the compliance among near points; returns their rows, (m, d, unknowns)."""
        J = np.zeros((*W.shape[:2], self.body.unknowns))
        for number, places, own in near.members(self.sides):
            J[places] += self._at(at, number, near.kinematics, own)
        J = near.frames @ J
        W += weight * np.tensordot(J / self.tangent, J, ([2], [2]))
        return J

    def moved_by(
        self,
        at: DenseConfiguration,
        coupling: Array,
        near: CandidateSet,
        force: Array,
        weight: float,
    ) -> Array:
        """The motion by forces on the rows of near points."""
        return weight * (force.ravel() @ coupling.reshape(force.size, -1)) / self.tangent

    def owned(self, at: DenseConfiguration, motion: Array, further: Array) -> Array:
        """The part of two motions together that this rank owns."""
        return (motion + further)[self.body.own]


class ElasticCoupling(NamedTuple):
    """Coupling of near points to the ports of a body.

    Attributes:
        ports: Numbers of the ports that they act on, rising.
        load: How much of each point's force each port gets, (m, ports); None where every point is
            one port and gets all of its own.
    """

    ports: Indices
    load: Array | None


class _ReadRows(NamedTuple):
    """Sparse rows that read points from a motion, as `Layer.reached` gives its nodes.

    Attributes:
        start: Place of the first entry of each row, and their end, (m d + 1,).
        column: Number of the unknown of each entry.
        weight: By which it counts.
    """

    start: Indices
    column: Indices
    weight: Array

    @classmethod
    def of(cls, port: InterfaceDofs, d: int) -> _ReadRows:
        """The rows of a group of ports."""
        rows = port.read_rows
        index = rows.indices.astype(np.int64)
        column = port.layer.numbers(index // d) * d + index % d
        return cls(rows.indptr.astype(np.int64), column, rows.data)


def _unspread(count: int) -> Interpolation:
    """Points that are a body's own ports, each as a place with the whole weight of one."""
    return Interpolation(np.arange(count)[:, None], np.ones((count, 1)))


class ElasticResponse:
    """Response of a meshed body, K^-1 = R (K_0^-1 + S) R_m^T, from one factorization of K_0.

    Motions without strain end in R, and forces of strain have no moment in R_m, the rotation in the
    middle of the step. Inertia contains neither: S = (R^T R_m - I)/(w m) on all nodes alike gives
    translations what their inertia w m alone does.
    """

    def __init__(
        self,
        body: ElasticBody | ReducedBody,
        compliance: Compliance,
        sides: Sequence[BodyRole],
        inertia: float = np.inf,
    ):
        """Take a body, the compliance of its ports, and its parts in interfaces, port by port.

        The inertia is w m, the factor of M in the tangent times the mass; infinite where the body
        is held or does not turn.
        """
        self.body, self.compliance, self.sides, self._inertia = body, compliance, sides, inertia
        self._rows = [_ReadRows.of(port, body.dimension) for port in compliance.ports]
        self._itself = [_unspread(side.points.count) for side in sides]
        self._ports = sum(side.points.count for side in sides)
        self._whole = np.ones(self._ports)  # of their forces, that points which are ports get
        unturned = np.eye(body.dimension)
        self._unturned: Array = np.array([unturned, unturned, np.zeros_like(unturned)])
        self._at_rest: Array = np.zeros(body.size)

    @property
    def nbytes(self) -> float:
        """Memory of the factorization and of compliances, on all ranks together, bytes."""
        return self.compliance.nbytes

    def at(self, u: Array, start: Array | None) -> Array:
        """R, R_m and S at a displacement, (3, d, d); without a step R_m is R, and S is zero."""
        rotation = self.body.rotation(u)
        if start is None:
            return np.array([rotation, rotation, np.zeros_like(rotation)])
        turns = np.empty(self._unturned.shape)
        meshed.turn(start, rotation, self._inertia, turns)
        return turns

    def of_mass(self, u: Array) -> Array:
        """The unturned body: its mass commutes with rotations."""
        return self._unturned

    def close(self, now: Array, before: Array) -> bool:
        """True if neither rotation has changed to speak of."""
        return meshed.largest_turn(now, before) <= TURNED

    def at_rest(self) -> Array:
        """A motion of zero."""
        return self._at_rest

    def free(self, at: Array, residual: Array) -> Array:
        """The free motion -K^-1 r."""
        turned, total = np.empty(residual.shape), np.empty(self.body.dimension)
        meshed.into_frame(residual, at, -1.0, turned, total)
        free = self.compliance.factor.solve(turned)
        meshed.add_shift(global_sum(self.body.comm, total)[None], at[2], free)
        return free

    def read(
        self,
        at: Array,
        motion: Array,
        moved: Array,
        kinematics: Kinematics,
    ) -> None:
        """Add what a motion does to the augmented positions of all points to `moved`."""
        d = self.body.dimension
        for side, port, rows in zip(self.sides, self.compliance.ports, self._rows, strict=True):
            seen = kinematics[side.interface]
            nodes = port.layer.reached(motion.reshape(-1, d)).reshape(-1)
            points: Array = np.empty((side.points.count, d))
            meshed.read_points(*rows, nodes, points)
            spots = side.spots(kinematics)
            if spots is not None:
                points = spots.carried(points)
            each = seen.frame[None] if seen.frame.ndim == 2 else seen.frame
            meshed.add_places(moved, side.first, side.sign, points, each, at[0])

    def couple(self, at: Array, near: CandidateSet, weight: float, W: Array) -> ElasticCoupling:
        """Add the compliance among near points; returns the ports that they act on."""
        coupling = self._coupling(near)
        if not len(coupling.ports):
            return coupling
        count, d, load = len(coupling.ports), self.body.dimension, coupling.load
        C: Any = self.compliance.among(coupling.ports).reshape(count, d, count, d)
        share = self._whole[:count]
        if load is not None:
            m, share = len(load), np.add.reduce(load, axis=1)
            half = (load @ C.reshape(count, -1)).reshape(m * d, count, d).swapaxes(1, 2)
            whole = half.reshape(m * d * d, count) @ load.T
            C = np.ascontiguousarray(whole.reshape(m, d, d, m).swapaxes(2, 3))
        meshed.add_compliance(W, weight, near.frames, at, C, share)
        return coupling

    def _coupling(self, near: CandidateSet) -> ElasticCoupling:
        """Ports that near points act on, and how much of each point's force each of them gets.

        There is at least one such point.
        """
        first, last = near.number[0], near.number[-1]
        for side in self.sides:
            alone = side.first <= first and last < side.first + side.count
            if alone and not side.carries and side.spots(near.kinematics) is None:
                shift = side.port - side.first
                return ElasticCoupling(near.number + shift if shift else near.number, None)
        sides = zip(self.sides, self._itself, strict=True)
        parts = [(side, side.spots(near.kinematics) or itself) for side, itself in sides]
        used = np.zeros(self._ports, dtype=np.bool_)
        for side, spots in parts:
            meshed.mark_ports(near.number, side.first, side.count, side.port, spots.nodes, used)
        ports = used.nonzero()[0]
        load = np.zeros((len(near.number), len(ports)))
        for side, spots in parts:
            where = near.number, side.first, side.count, side.port, spots.nodes
            meshed.add_loads(*where, spots.weights, side.sign, ports, load)
        return ElasticCoupling(ports, load)

    def moved_by(
        self, at: Array, coupling: ElasticCoupling, near: CandidateSet, force: Array, weight: float
    ) -> Array:
        """The motion by forces at near points, from the columns of the ports that they act on."""
        if not len(coupling.ports):
            return self._at_rest
        vectors = np.empty(force.shape)
        meshed.point_vectors(force, weight, near.frames, at[1], vectors)
        if coupling.load is not None:
            vectors = coupling.load.T @ vectors
        moved = self.compliance.displacement(coupling.ports, vectors)
        meshed.add_shift(vectors, at[2], moved)
        return moved

    def owned(self, at: Array, motion: Array, further: Array) -> Array:
        """Two motions of the owned unknowns, from the frame of the body back into space."""
        moved = np.empty(motion.size)
        meshed.out_of_frame(motion, further, at[0], moved)
        return moved


def saved_compliances(responses: Sequence[Any]) -> list[Any]:
    """Batches of columns of meshed bodies; None for all others."""
    return [
        response.compliance.batches if isinstance(response, ElasticResponse) else None
        for response in responses
    ]


def repeat_compliances(responses: Sequence[Any], saved: Sequence[Any]) -> None:
    """Compute the same again, to the last digit; collective."""
    for response, compliance in zip(responses, saved, strict=True):
        if compliance is not None:
            response.compliance.repeat(compliance)
