"""How bodies answer to forces at contact points: their compliance, and the motion they take.

A body takes part in interfaces with its points (it is carried) or with what it carries them on (it
carries). For all of them together it offers its free motion and its compliance, and takes forces:
an elastic body with its factorized tangent in the frame that turns with it, a rigid block or a
platform with its mass. The contact problem sees only rows and a small dense matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.bodies.dense_body import DenseBody
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.kinematics import polar_rotation
from solver.contact.body_points import SurfacePoints
from solver.contact.projection import ContactKinematics, Interpolation, in_frames
from solver.parallel import global_sum
from solver.stepping.compliance import Compliance
from solver.types import Array, Indices

TURNED = 1e-5
"""Change of the entries of a rotation, below which the compliance of a body is not made anew: it is
part of the correction of an iteration, not of the residual, and neglects strains as large."""


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
        """Of its motion in gap and slip."""
        return -1.0 if self.carries else 1.0

    def spots(self, seats: Sequence[ContactKinematics]) -> Interpolation | None:
        """Where the contact points are among the body's own; None where they are the same."""
        seat = seats[self.interface]
        return seat.foot if self.carries else seat.tip


@dataclass(slots=True)
class CandidateSet:
    """Points that are in contact or near it, of all interfaces.

    Attributes:
        number: Their numbers among all points, rising.
        frames: Rows normal and tangents at each of them, (m, d, d).
        seats: Of every interface, for where carried points stand.
    """

    number: Indices
    frames: Array
    seats: Sequence[ContactKinematics]


class Response(Protocol):
    """What a body offers to the contact problem."""

    def begin(self, rotation: Array | None) -> None:
        """The rotation of the body at the start of a step, (d, d); None: an equilibrium."""

    def at(self, u: Array) -> bool:
        """The displacement that is corrected; whether the compliance there is another."""

    def free(self, residual: Array) -> Array:
        """The free correction -K^-1 r of the owned unknowns."""

    def read(
        self, moved: Array, frames: Sequence[Array], seats: Sequence[ContactKinematics]
    ) -> None:
        """Add what the last free correction does to the augmented positions of all points."""

    def couple(self, near: CandidateSet, weight: float, W: Array) -> None:
        """Add `weight` times the compliance among near points to W (m, d, m, d)."""

    def respond(self, near: CandidateSet, force: Array, weight: float) -> Array | None:
        """Correction for forces (m, d) at the near points of the last `couple`, owned unknowns."""


def _members(
    sides: Sequence[BodyRole], near: CandidateSet
) -> list[tuple[BodyRole, Indices, Indices]]:
    """For each side its near points: places in `near`, numbers within the interface."""
    result = []
    for side in sides:
        inside = (near.number >= side.first) & (near.number < side.first + side.count)
        places = np.flatnonzero(inside)
        if len(places):
            result.append((side, places, near.number[places] - side.first))
    return result


class ElasticResponse:
    """Of a meshed body: K^-1 = R (K_0^-1 + S) R_m^T from one factorization in its rotating frame.

    Motions without strain end in R, and forces of strain have no moment in R_m, the rotation in the
    middle of the step. Inertia knows of neither: S = (R^T R_m - I)/(w m) on all nodes alike gives
    translations what their inertia w m alone does.
    """

    def __init__(
        self,
        body: ElasticBody,
        compliance: Compliance,
        sides: Sequence[BodyRole],
        inertia: float = np.inf,
    ):
        """Set up.

        Args:
            body: The body.
            compliance: Of its ports.
            sides: Its parts in interfaces, port by port.
            inertia: w m, the factor of M in the tangent times the mass; infinite where the body is
                held or does not turn.
        """
        self.body, self.compliance, self.sides, self._inertia = body, compliance, sides, inertia
        self._simple = len(sides) == 1 and not sides[0].carries
        self._start: Array | None = None
        self._rotation = self._middle = np.eye(body.dimension)
        self._shift: Array | None = None
        self._coupled = np.array((self._rotation, self._middle))
        self._ports: Indices = np.empty(0, dtype=np.int64)
        self._load: Array | None = None

    def begin(self, rotation: Array | None) -> None:
        """The rotation of the body at the start of a step, (d, d); None: an equilibrium."""
        self._start = rotation

    def at(self, u: Array) -> bool:
        """The rotations R and R_m; whether either is another than its compliance was asked for."""
        self._rotation = self._middle = self.body.rotation(u)
        self._shift = None
        if self._start is not None:
            self._middle = polar_rotation(self._start + self._rotation)
            half_turn = self._rotation.T @ self._middle
            self._shift = np.asarray((half_turn - self.body.identity) / self._inertia)
        now = np.array((self._rotation, self._middle))
        return bool(np.abs(now - self._coupled).max() > TURNED)

    def free(self, residual: Array) -> Array:
        """-K^-1 r."""
        turned = residual.reshape(-1, self.body.dimension) @ self._middle
        self._free = -self.compliance.factor.solve(turned.ravel()).reshape(turned.shape)
        if self._shift is not None:
            self._free -= self._shift @ global_sum(self.body.comm, turned.sum(axis=0))
        return (self._free @ self._rotation.T).ravel()

    def read(
        self, moved: Array, frames: Sequence[Array], seats: Sequence[ContactKinematics]
    ) -> None:
        """Add what the last free correction does to the augmented positions of all points."""
        d = self.body.dimension
        for side, port in zip(self.sides, self.compliance.ports, strict=True):
            layer = port.layer.gather(self._free)
            own = slice(side.first, side.first + side.count)
            turned = frames[side.interface] @ self._rotation
            points = (port.read_rows @ layer.ravel()).reshape(-1, d)
            spots = side.spots(seats)
            if spots is not None:
                points = spots.carried(points)
            moved[own] += side.sign * in_frames(points, turned)

    def couple(self, near: CandidateSet, weight: float, W: Array) -> None:
        """Add the compliance among near points."""
        self._coupled = np.array((self._rotation, self._middle))
        G, H = near.frames @ self._rotation, near.frames @ self._middle
        if self._simple and len(near.number) == len(W):
            side = self.sides[0]
            if side.first == 0 and near.number[-1] < side.count:
                self._ports, self._load = near.number, None
                blocks = self.compliance.blocks(near.number)
                if self._shift is not None:
                    blocks = blocks + self._shift
                turned = G[:, None] @ blocks @ H.swapaxes(1, 2)[None]
                W += weight * turned.transpose(0, 2, 1, 3)
                return
        self._ports, self._load = self._loads(near)
        if not len(self._ports):
            return
        C = np.tensordot(self._load, self.compliance.blocks(self._ports), 1)
        C = np.tensordot(C, self._load, ([1], [1])).transpose(0, 3, 1, 2)
        if self._shift is not None:
            total = self._load.sum(axis=1)
            C += np.multiply.outer(np.outer(total, total), self._shift)
        W += weight * (G[:, None] @ C @ H.swapaxes(1, 2)[None]).transpose(0, 2, 1, 3)

    def _loads(self, near: CandidateSet) -> tuple[Indices, Array]:
        """Ports that near points act on, and how much of each point's force each of them gets."""
        entries: list[tuple[Indices, Indices, Array]] = []
        for side, places, own in _members(self.sides, near):
            spots = side.spots(near.seats)
            if spots is None:
                entries.append((places, side.port + own, np.full(len(own), side.sign)))
            else:
                nodes, weights = spots.nodes[own], side.sign * spots.weights[own]
                rows = np.repeat(places, nodes.shape[1])
                entries.append((rows, side.port + nodes.ravel(), weights.ravel()))
        if not entries:
            return np.empty(0, dtype=np.int64), np.empty((len(near.number), 0))
        rows, ports, weights = (np.concatenate(part) for part in zip(*entries, strict=True))
        used, column = np.unique(ports, return_inverse=True)
        load = np.zeros((len(near.number), len(used)))
        np.add.at(load, (rows, column), weights)
        return used, load

    def respond(self, near: CandidateSet, force: Array, weight: float) -> Array | None:
        """Correction for forces at the near points of the last `couple`."""
        if not len(self._ports):
            return None
        vectors = (force[:, None, :] @ near.frames)[:, 0] @ self._middle
        if self._load is not None:
            vectors = self._load.T @ vectors
        change = self.compliance.of(self._ports)[1] @ vectors.ravel()
        change = change.reshape(-1, self.body.dimension)
        if self._shift is not None:
            change += self._shift @ vectors.sum(axis=0)
        return (weight * change @ self._rotation.T).ravel()


class DenseResponse:
    """Of a rigid block or a platform: rows on few unknowns."""

    def __init__(self, body: DenseBody, tangent: Array, sides: Sequence[BodyRole]):
        """Take the body, the diagonal of its tangent or mass, and its parts in interfaces."""
        self.body, self.tangent, self.sides = body, tangent, sides
        self._rows: list[Array] = []
        self._level: list[Array] = []

    def begin(self, rotation: Array | None) -> None:
        """Nothing: rows are those where the block is."""

    def at(self, u: Array) -> bool:
        """Rows of all surface points at this configuration, (points, d, unknowns)."""
        if self._rows and not self.body.turns:
            return False
        pose = self.body.replicate(u)
        self._rows = [self.body.rows(side.points.reference, pose) for side in self.sides]
        # What carries points on an endless plane moves all of them alike.
        self._level = [
            np.repeat(-rows[:1], side.count, axis=0)
            for side, rows in zip(self.sides, self._rows, strict=True)
        ]
        return True

    def free(self, residual: Array) -> Array:
        """-K^-1 r."""
        own = -residual / self.tangent[self.body.own]
        self._free = self.body.replicate(own)
        return own

    def _at(
        self, number: int, seat: ContactKinematics, own: slice | Indices = slice(None)
    ) -> Array:
        """Rows of the points of a side's interface in what this body does to them."""
        side, rows = self.sides[number], self._rows[number]
        spots = seat.foot if side.carries else seat.tip
        if spots is None:
            return self._level[number][own] if side.carries else rows[own]
        weights, nodes = side.sign * spots.weights[own], spots.nodes[own]
        return np.einsum("mk,mkdu->mdu", weights, rows[nodes])

    def read(
        self, moved: Array, frames: Sequence[Array], seats: Sequence[ContactKinematics]
    ) -> None:
        """Add what the last free correction does to the positions of all points."""
        for number, side in enumerate(self.sides):
            k = side.interface
            own = slice(side.first, side.first + side.count)
            moved[own] += in_frames(self._at(number, seats[k]) @ self._free, frames[k])

    def couple(self, near: CandidateSet, weight: float, W: Array) -> None:
        """Add the compliance among near points."""
        J = np.zeros((*W.shape[:2], self.body.unknowns))
        for side, places, own in _members(self.sides, near):
            J[places] += self._at(self.sides.index(side), near.seats[side.interface], own)
        self._J = near.frames @ J
        W += weight * np.tensordot(self._J / self.tangent, self._J, ([2], [2]))

    def respond(self, near: CandidateSet, force: Array, weight: float) -> Array | None:
        """Correction for forces at the near points of the last `couple`."""
        change = weight * (force.ravel() @ self._J.reshape(force.size, -1)) / self.tangent
        return change[self.body.own]
