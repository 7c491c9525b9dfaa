"""The active faces of a body in contact: those turned towards what carries the body.

Every boundary facet is a candidate. But the theta term of Nitsche's method and the tractions of a
face cost time in every iteration, so a face joins when it has turned to within 60 degrees of facing
its carrier, which a block that stands, slides or rocks never lets its sides do; one that tips over
does, before it touches with them.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from dolfinx import mesh

from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.contact.body_points import NitschePoints
from solver.contact.carriers import Carrier
from solver.contact.facets import evaluate_facets, extent, gather
from solver.contact.interface import Interface
from solver.contact.nitsche_points import contact_points
from solver.scene import Bed, FrictionSpec
from solver.types import Array

FACING = -0.5
"""Cosine of the angle between a face's normal and the carrier's below which the face joins."""


class ContactPair(Protocol):
    """A pair of a body and its carrier that may touch, and their interface.

    Attributes:
        body: Number of the body whose points these are; None for what is fixed to the ground.
        carrier: Number of the body that carries them; None for the ground and what is fixed to it.
        surface: The carrier's surface.
        always: Tags of the faces that are active from the beginning.
    """

    body: int | None
    carrier: int | None
    surface: Carrier
    always: frozenset[int]

    def facing(self, rotation: Array) -> frozenset[int]:
        """Tags of the faces active under a rotation: turned to the carrier, or always active."""

    def join(self, faces: frozenset[int]) -> Interface:
        """The interface of these faces, made anew; collective."""


class MeshedContactPair:
    """The faces of a meshed body, and what carries it."""

    def __init__(
        self,
        member: ElasticBody,
        facet_tags: mesh.MeshTags,
        carrier: Carrier,
        law: FrictionSpec,
        *,
        points: str = "nodes",
        gamma: float = 100.0,
        theta: int = 1,
        body: int = 0,
        on: int | None = None,
        cuts: Array | None = None,
        bed: Bed | None = None,
    ):
        """Take what `contact_points` and `Interface` need; `join` builds the interface.

        Args:
            member: The body.
            facet_tags: Tags of its boundary facets.
            carrier: What carries it.
            law: Friction.
            points: "nodes" or "gauss".
            gamma: Nondimensional Nitsche parameter.
            theta: Variant of Nitsche's method.
            body: Number of the body in its system.
            on: Number of the body that carries it; None for the ground.
            cuts: As for `contact_points`.
            bed: Springs and dashpots between points and carrier.
        """
        self.body: int | None = body
        self.carrier, self.surface = on, carrier
        self._member, self._tags, self._law = member, facet_tags, law
        self._points, self._gamma, self._theta, self._cuts = points, gamma, theta, cuts
        self._bed = bed
        space = member.space
        records = evaluate_facets(space, facet_tags, points, space.ufl_element().degree)
        facets, _ = gather(space, records, extent(space.mesh))
        self._face, self._outward = facets.tag, np.ascontiguousarray(facets.normal)
        self._found: dict[bytes, frozenset[int]] = {}  # faces, by the facets that are turned there
        # The bottom is always active: the gaps in the history are those of its corners.
        self.always: frozenset[int] = frozenset({int(FacetTag.BOTTOM)})

    def facing(self, rotation: Array) -> frozenset[int]:
        """Tags of faces with a facet turned towards the carrier, and of the bottom."""
        towards = self._outward @ (self.surface.frame[0] @ rotation) < FACING
        key = towards.tobytes()
        if key not in self._found:
            self._found[key] = self.always.union(map(int, self._face[towards]))
        return self._found[key]

    def join(self, faces: frozenset[int]) -> Interface:
        """The interface of these faces, made anew; collective."""
        chosen = np.isin(self._tags.values, list(faces))
        space = self._member.space
        tags = mesh.meshtags(
            space.mesh, self._tags.dim, self._tags.indices[chosen], self._tags.values[chosen]
        )
        points = contact_points(
            space,
            tags,
            self._member.material,
            points=self._points,
            gamma=self._gamma,
            cuts=self._cuts,
        )
        member = NitschePoints(self._member, points)
        return Interface(member, self.surface, self._law, theta=self._theta, bed=self._bed)


class FixedContactPair:
    """Points that are active from the beginning to the end: of rigid bodies, of edges."""

    always: frozenset[int] = frozenset()

    def __init__(self, interface: Interface, *, body: int | None, on: int | None):
        """Take the interface, and the numbers of the body of its points and of what they touch."""
        self.body, self.carrier, self.surface = body, on, interface.carrier
        self._interface = interface

    def facing(self, rotation: Array) -> frozenset[int]:
        """Tags of active faces: no face ever joins."""
        return self.always

    def join(self, faces: frozenset[int]) -> Interface:
        """The interface that was given."""
        return self._interface
