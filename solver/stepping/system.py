"""The bodies of a scene and their interfaces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mpi4py import MPI

import numpy as np
import scipy.sparse as sp

from solver.bodies.body import Body
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.bodies.rigid_body import DenseBody
from solver.contact.body_points import NitschePoints, NodePoints, SurfacePoints
from solver.contact.interface import Interface
from solver.contact.kinematics import Parts
from solver.contact.pairs import Link
from solver.scheme.generalized_alpha import TangentWeights
from solver.stepping.compliance import Compliance, InterfaceDofs
from solver.stepping.response import (
    AnyResponse,
    BodyRole,
    DenseResponse,
    ElasticResponse,
    PlacesOfBody,
)
from solver.types import Array


class System:
    """All bodies, with one vector of owned unknowns: body after body."""

    def __init__(self, bodies: Sequence[Body]):
        """Number the unknowns."""
        self.bodies = tuple(bodies)
        self.comm: MPI.Intracomm = bodies[0].comm
        self.dimension = bodies[0].dimension
        ends = np.cumsum([body.size for body in bodies])
        self.slices = tuple(
            slice(int(end) - body.size, int(end)) for body, end in zip(bodies, ends, strict=True)
        )
        self.size = int(ends[-1])
        self.unknowns = sum(body.unknowns for body in bodies)
        self.directional_mass = np.hstack([body.directional_mass for body in bodies])
        fixed = [body.fixed + own.start for body, own in zip(bodies, self.slices, strict=True)]
        self.fixed = np.concatenate(fixed).astype(np.int64)
        """Owned unknowns that do not move."""

        self._ports: dict[tuple[Interface, SurfacePoints, bool], InterfaceDofs] = {}
        self._unturned: Array = np.eye(self.dimension)
        self._unturned.flags.writeable = False

        self.members = tuple(zip(self.bodies, self.slices, strict=True))
        """All bodies, and where their unknowns are."""
        self.meshed = tuple(
            (body, own) for body, own in self.members if isinstance(body, ElasticBody | ReducedBody)
        )
        """Meshed and reduced ones."""

        self.grounded = tuple((body, own) for body, own in self.members if body.clamped)
        """Bodies that supports or springs to the ground hold, and where their unknowns are."""
        self.clamped = tuple((body, own) for body, own in self.meshed if body.clamped)
        """The meshed ones of these; the same on all ranks."""

        self.tied = tuple(
            (body, own) for body, own in self.members if _is_tied(body, np.zeros(body.size))
        )
        """Bodies on which springs or dashpots to the ground act, or damping like these, and where
        their unknowns are."""

    def ports(
        self, points: SurfacePoints, interface: Interface, *, tractions: bool
    ) -> InterfaceDofs:
        """Rows between points of a meshed body and its nodes: made once, for all tangents."""
        key = interface, points, tractions
        if key not in self._ports:
            self._ports[key] = ports_of(points, interface, tractions=tractions)
        return self._ports[key]

    def part(self, vector: Array, body: int | None) -> Array | None:
        """The unknowns of one body; None for the ground."""
        return None if body is None else vector[self.slices[body]]

    def parts(self, vector: Array, link: Link) -> Parts:
        """The unknowns of the body and of the carrier of an interface; None for the ground."""
        return self.part(vector, link.body), self.part(vector, link.carrier)

    def settled(self, u: Array) -> Array:
        """The unknowns that the next step starts from, of those at the end of a step."""
        if len(self.bodies) == 1:
            return self.bodies[0].settled(u)
        return np.concatenate([body.settled(u[own]) for body, own in self.members])

    def rigid(self, link: Link) -> bool:
        """True if neither of the two bodies is meshed: their point forces are not unique then."""
        return all(isinstance(member, DenseBody) for member in self._ends(link))

    def is_at_rigid(self, link: Link) -> bool:
        """True if one of the two bodies is rigid, or both are."""
        return any(isinstance(member, DenseBody) for member in self._ends(link))

    def _ends(self, link: Link) -> list[Body]:
        """The bodies of an interface that move."""
        return [self.bodies[body] for body in (link.body, link.carrier) if body is not None]

    def rotation(self, u: Array, body: int | None) -> Array:
        """The rotation of a body, (d, d); the identity for the ground."""
        if body is None:
            return self._unturned
        return self.bodies[body].rotation(u[self.slices[body]])


def _is_tied(body: Body, at_rest: Array) -> bool:
    """True if a spring, a dashpot or damping acts on what moves over the ground; collective."""
    return body.spring(at_rest) is not None or body.drag(at_rest) is not None


def sides_of(body: int, links: Sequence[Link]) -> list[BodyRole]:
    """The parts that a body takes in the interfaces."""
    sides: list[BodyRole] = []
    first = port = 0
    for number, link in enumerate(links):
        interface = link.interface
        for owner, carries, points in (
            (link.body, False, interface.points),
            (link.carrier, True, interface.carrier.points),
        ):
            if owner == body and points is not None:
                sides.append(BodyRole(number, first, interface.count, carries, points, port))
                port += points.count
        first += interface.count
    return sides


def role_of(attached: PlacesOfBody, links: Sequence[Link], sides: Sequence[BodyRole]) -> BodyRole:
    """The part of the places of a body, which stand behind the points of all interfaces.

    By the parts that the body takes in these.
    """
    first = sum(link.interface.count for link in links) + attached.first
    port = sum(side.points.count for side in sides)
    return BodyRole(len(links), first, attached.points.count, False, attached.points, port)


def response_of(
    system: System,
    body: int,
    links: Sequence[Link],
    factor: Any,
    weights: TangentWeights | None = None,
    attached: PlacesOfBody | None = None,
) -> AnyResponse:
    """The response of a body, by its number.

    The factor is the factorized tangent or mass of a meshed body, the diagonal of a rigid one's.
    Weights are those of the tangent, whose points are read with their tractions; None for the mass.
    Places at which links act are further points of the body.
    """
    member, own = system.bodies[body], sides_of(body, links)
    sides = own if attached is None else [*own, role_of(attached, links, own)]
    if isinstance(member, DenseBody):
        return DenseResponse(member, factor, sides)
    assert isinstance(member, ElasticBody | ReducedBody)
    ports = [
        system.ports(side.points, links[side.interface].interface, tractions=weights is not None)
        for side in own
    ]
    if attached is not None:
        assert isinstance(attached.points, NodePoints)
        ports.append(InterfaceDofs.of_nodes(attached.points.layer, member.dimension))
    inertia = np.inf if weights is None or member.clamped else weights.mass * member.mass
    return ElasticResponse(member, Compliance(member, factor, ports), sides, inertia)


def ports_of(points: SurfacePoints, interface: Interface, *, tractions: bool) -> InterfaceDofs:
    """Rows between points of a meshed body, read with their tractions or not, and its nodes."""
    if isinstance(points, NodePoints):
        return InterfaceDofs.of_nodes(points.layer, points.dimension)
    assert isinstance(points, NitschePoints)
    position = points.points.position_rows()
    read = force = position
    if tractions:
        scale = sp.diags(np.repeat(interface.inverse_gamma, points.dimension))
        given = scale @ points.points.traction_rows()
        read = force = _without_zeros(position - given)
        if interface.theta != 1:
            force = _without_zeros(position - interface.theta * given)
    return InterfaceDofs(points.points.layer, force, read, points.count)


def _without_zeros(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """A matrix without the entries that are zero, the others of each row in order."""
    found = sp.csr_matrix(matrix)
    found.eliminate_zeros()
    found.sort_indices()
    return found
