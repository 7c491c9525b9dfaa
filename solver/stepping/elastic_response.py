"""How a meshed body answers to forces at contact points, with one factorization of its tangent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced.body import ReducedBody
from solver.contact.kernels.turned import (
    add_compliance,
    add_loads,
    add_places,
    add_readings,
    into_frame,
    largest_turn,
    mark_ports,
    moved_by_few,
    moved_with_strain,
    out_of_frame,
    point_vectors,
    read_points,
    turn,
)
from solver.contact.kinematics import Interpolation
from solver.parallel import global_sum
from solver.stepping.compliance import Compliance
from solver.stepping.ports import InterfaceDofs
from solver.stepping.response import BodyRole, CandidateSet, Kinematics
from solver.types import Array, Indices, Mask

TURNED = 1e-5
"""Change of the entries of a rotation below which the compliance of a body is not made anew: it is
part of the correction of an iteration, not of the residual, and neglects strains as large."""


class ElasticMotion(NamedTuple):
    """A motion of a meshed body in the frame that turns with it: x + S p.

    Attributes:
        nodes: x, of the owned nodes, (n d,), m.
        push: p, the forces that make it, added up over all nodes, (d,), N.
    """

    nodes: Array
    push: Array


class ElasticCoupling(NamedTuple):
    """How near points act on the ports of a body.

    Attributes:
        ports: Numbers of the ports that they act on, rising.
        load: How much of each point's force each port gets, (m, ports); None where every point is
            one port and gets all of its own.
    """

    ports: Indices
    load: Array | None


def _pressed_ports(coupling: ElasticCoupling, pressed: Mask) -> Indices:
    """The ports that points act on which are pressed, (m,)."""
    if coupling.load is None:
        return coupling.ports[pressed]
    return coupling.ports[coupling.load[pressed].any(axis=0)]


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
        rows = sp.csr_matrix(port.read_rows)
        index = rows.indices.astype(np.int64)
        column = port.layer.numbers(index // d) * d + index % d
        return cls(rows.indptr.astype(np.int64), column, rows.data)


def _unspread(count: int) -> Interpolation:
    """Points that are a body's own ports, each as a place with the whole weight of one."""
    return Interpolation(np.arange(count)[:, None], np.ones((count, 1)))


class ElasticResponse:
    """Response of a meshed body, K^-1 = R (K_0^-1 + S) R_m^T, from one factorization of K_0.

    Motions without strain end in R, and forces of strain have no moment in R_m, the rotation in the
    middle of the step. Inertia knows of neither: S = (R^T R_m - I)/(w m) on all nodes alike gives
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
        still = np.zeros(body.owned * body.dimension)
        self._at_rest = ElasticMotion(still, np.zeros(body.dimension))

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
        turn(start, rotation, self._inertia, turns)
        return turns

    def of_mass(self, u: Array) -> Array:
        """The unturned body: its mass commutes with rotations."""
        return self._unturned

    def close(self, now: Array, before: Array) -> bool:
        """Whether neither rotation has changed to speak of."""
        return largest_turn(now, before) <= TURNED

    def at_rest(self) -> ElasticMotion:
        """A motion of zero."""
        return self._at_rest

    def free(self, at: Array, residual: Array) -> ElasticMotion:
        """The free motion -K^-1 r."""
        turned, total = np.empty(residual.shape), np.empty(self.body.dimension)
        into_frame(residual, at, -1.0, turned, total)
        free = self.compliance.factor.solve(turned)
        return ElasticMotion(free, global_sum(self.body.comm, total))

    def read(
        self,
        at: Array,
        free: ElasticMotion,
        moved: Array,
        frames: Sequence[Array],
        kinematics: Kinematics,
    ) -> None:
        """Add what a free motion does to the augmented positions of all points to `moved`."""
        for side, port, rows in zip(self.sides, self.compliance.ports, self._rows, strict=True):
            if kinematics[side.interface] is None:
                continue
            nodes = port.layer.reached(free.nodes.reshape(-1, self.body.dimension)).reshape(-1)
            frame = frames[side.interface]
            each = frame[None] if frame.ndim == 2 else frame
            spots = side.spots(kinematics)
            if spots is None:
                add_readings(moved, side.first, side.sign, *rows, nodes, free.push, each, at)
            else:
                points = np.empty((side.points.count, self.body.dimension))
                read_points(*rows, nodes, free.push, at[2], points)
                add_places(moved, side.first, side.sign, spots.carried(points), each, at[0])

    def couple(self, at: Array, near: CandidateSet, weight: float, W: Array) -> ElasticCoupling:
        """Add the compliance among near points; returns the ports that they act on."""
        coupling = self._coupling(near)
        if not len(coupling.ports):
            return coupling
        count, d, load = len(coupling.ports), self.body.dimension, coupling.load
        known = self.compliance.among(
            coupling.ports, lambda: _pressed_ports(coupling, near.pressed)
        )
        C: Any = known.matrix.reshape(count, d, count, d)
        share = self._whole[:count]
        if load is not None:
            m, share = len(load), np.add.reduce(load, axis=1)
            half = (load @ C.reshape(count, -1)).reshape(m * d, count, d).swapaxes(1, 2)
            whole = half.reshape(m * d * d, count) @ load.T
            C = np.ascontiguousarray(whole.reshape(m, d, d, m).swapaxes(2, 3))
        add_compliance(W, weight, near.frames, at, C, share)
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
            mark_ports(near.number, side.first, side.count, side.port, spots.nodes, used)
        ports = used.nonzero()[0]
        load = np.zeros((len(near.number), len(ports)))
        for side, spots in parts:
            where = near.number, side.first, side.count, side.port, spots.nodes
            add_loads(*where, spots.weights, side.sign, ports, load)
        return ElasticCoupling(ports, load)

    def respond(
        self,
        at: Array,
        coupling: ElasticCoupling,
        near: CandidateSet,
        force: Array,
        weight: float,
        motion: ElasticMotion,
    ) -> Array:
        """The correction of the owned unknowns by a motion and what forces at near points add."""
        if not len(coupling.ports):
            return self.owned(at, motion)
        moved, load = np.empty(motion.nodes.size), coupling.load
        few = self.compliance.few_columns(coupling.ports) if load is None else None
        if few is not None:
            moved_by_few(*motion, force, weight, near.frames, few, at, moved)
            return moved
        vectors = np.empty(force.shape)
        point_vectors(force, weight, near.frames, at[1], vectors)
        if load is not None:
            vectors = load.T @ vectors
        strain = self.compliance.displacement(coupling.ports, vectors)
        moved_with_strain(*motion, strain, vectors, at, moved)
        return moved

    def owned(self, at: Array, motion: ElasticMotion) -> Array:
        """A motion of the owned unknowns, from the frame of the body back into space."""
        vectors = np.empty(motion.nodes.size)
        out_of_frame(*motion, at, vectors)
        return vectors
