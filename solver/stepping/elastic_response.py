"""How a meshed body answers to forces at contact points, with one factorization of its tangent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.kinematics import polar_rotation
from solver.contact.projection import ContactKinematics, in_frames
from solver.parallel import global_sum
from solver.stepping.compliance import Compliance
from solver.stepping.response import BodyRole, CandidateSet
from solver.types import Array, Indices

TURNED = 1e-5
"""Change of the entries of a rotation below which the compliance of a body is not made anew: it is
part of the correction of an iteration, not of the residual, and neglects strains as large."""


class ElasticConfiguration(NamedTuple):
    """How a meshed body is turned.

    Attributes:
        rotation: R, of the body, (d, d).
        middle: R_m, in the middle of the step, (d, d).
        shift: S = (R^T R_m - I)/(w m), (d, d); None where the two are the same.
    """

    rotation: Array
    middle: Array
    shift: Array | None


class ElasticCoupling(NamedTuple):
    """How near points act on the ports of a body.

    Attributes:
        ports: Numbers of the ports that they act on, rising.
        load: How much of each point's force each port gets, (m, ports); None where every point is
            one port and gets all of its own.
    """

    ports: Indices
    load: Array | None


class ElasticResponse:
    """Response of a meshed body, K^-1 = R (K_0^-1 + S) R_m^T, from one factorization of K_0.

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
        """Take a body, the compliance of its ports, and its parts in interfaces, port by port.

        The inertia is w m, the factor of M in the tangent times the mass; infinite where the body
        is held or does not turn.
        """
        self.body, self.compliance, self.sides, self._inertia = body, compliance, sides, inertia
        self._simple = len(sides) == 1 and not sides[0].carries
        self._unturned = ElasticConfiguration(np.eye(body.dimension), np.eye(body.dimension), None)

    def at(self, u: Array, start: Array | None) -> ElasticConfiguration:
        """The rotations R and R_m at a displacement."""
        rotation = self.body.rotation(u)
        if start is None:
            return ElasticConfiguration(rotation, rotation, None)
        middle = polar_rotation(start + rotation)
        shift = np.asarray((rotation.T @ middle - self.body.identity) / self._inertia)
        return ElasticConfiguration(rotation, middle, shift)

    def of_mass(self, u: Array) -> ElasticConfiguration:
        """The unturned body: its mass commutes with rotations."""
        return self._unturned

    def close(self, now: ElasticConfiguration, before: ElasticConfiguration) -> bool:
        """Whether neither rotation has changed to speak of."""
        turned = np.abs(now.rotation - before.rotation).max()
        return bool(max(turned, np.abs(now.middle - before.middle).max()) <= TURNED)

    def free(self, at: ElasticConfiguration, residual: Array) -> Array:
        """The free motion -K^-1 r."""
        turned = residual.reshape(-1, self.body.dimension) @ at.middle
        free = self.compliance.factor.solve(turned.ravel()).reshape(turned.shape)
        if at.shift is not None:
            free += at.shift @ global_sum(self.body.comm, turned.sum(axis=0))
        return np.negative(free, out=free)

    def read(
        self,
        at: ElasticConfiguration,
        free: Array,
        moved: Array,
        frames: Sequence[Array],
        kinematics: Sequence[ContactKinematics],
    ) -> None:
        """Add what a free motion does to the augmented positions of all points to `moved`."""
        d = self.body.dimension
        for side, port in zip(self.sides, self.compliance.ports, strict=True):
            layer = port.layer.gather(free)
            turned = frames[side.interface] @ at.rotation
            points = (port.read_rows @ layer.ravel()).reshape(-1, d)
            spots = side.spots(kinematics)
            if spots is not None:
                points = spots.carried(points)
            moved[side.own] += side.sign * in_frames(points, turned)

    def couple(
        self, at: ElasticConfiguration, near: CandidateSet, weight: float, W: Array
    ) -> ElasticCoupling:
        """Add the compliance among near points; returns the ports that they act on."""
        coupling = self._coupling(near)
        if not len(coupling.ports):
            return coupling
        C: Any = self.compliance.blocks(coupling.ports)
        if coupling.load is None:
            if at.shift is not None:
                C = C + at.shift
        else:
            C = np.tensordot(coupling.load, C, 1)
            C = np.tensordot(C, coupling.load, ([1], [1])).transpose(0, 3, 1, 2)
            if at.shift is not None:
                total = coupling.load.sum(axis=1)
                C += np.multiply.outer(np.outer(total, total), at.shift)
        G, H = near.frames @ at.rotation, near.frames @ at.middle
        W += weight * (G[:, None] @ C @ H.swapaxes(1, 2)[None]).transpose(0, 2, 1, 3)
        return coupling

    def _coupling(self, near: CandidateSet) -> ElasticCoupling:
        """Ports that near points act on, and how much of each point's force each of them gets."""
        if self._simple:
            side = self.sides[0]
            if side.first == 0 and near.number[-1] < side.count:
                return ElasticCoupling(near.number, None)
        entries: list[tuple[Indices, Indices, Array]] = []
        for number, places, own in near.members(self.sides):
            side = self.sides[number]
            spots = side.spots(near.kinematics)
            if spots is None:
                entries.append((places, side.port + own, np.full(len(own), side.sign)))
            else:
                nodes, weights = spots.nodes[own], side.sign * spots.weights[own]
                rows = np.repeat(places, nodes.shape[1])
                entries.append((rows, side.port + nodes.ravel(), weights.ravel()))
        if not entries:
            return ElasticCoupling(np.empty(0, dtype=np.int64), np.empty((len(near.number), 0)))
        rows, ports, weights = (np.concatenate(part) for part in zip(*entries, strict=True))
        used, column = np.unique(ports, return_inverse=True)
        load = np.zeros((len(near.number), len(used)))
        np.add.at(load, (rows, column), weights)
        return ElasticCoupling(used, load)

    def respond(
        self,
        at: ElasticConfiguration,
        coupling: ElasticCoupling,
        near: CandidateSet,
        force: Array,
        weight: float,
    ) -> Array | None:
        """Motion by forces at near points; None where the body has none of them."""
        if not len(coupling.ports):
            return None
        vectors = ((weight * force)[:, None, :] @ near.frames)[:, 0] @ at.middle
        if coupling.load is not None:
            vectors = coupling.load.T @ vectors
        change = self.compliance.among(coupling.ports).responses @ vectors.ravel()
        change = change.reshape(-1, self.body.dimension)
        if at.shift is not None:
            change += at.shift @ vectors.sum(axis=0)
        return change

    def owned(self, at: ElasticConfiguration, motion: Array) -> Array:
        """A motion in space."""
        return (motion @ at.rotation.T).ravel()
