"""The faces of a body that take part in contact: those turned towards what carries it.

Every boundary facet is a candidate. But the theta term of Nitsche's method and the tractions of a
face cost time in every iteration, so a face joins when it has turned to within 60 degrees of facing
the plane, which a block that stands, slides or rocks never lets its sides do; one that tips over
does, before it touches with them.
"""

from __future__ import annotations

import numpy as np
from dolfinx import fem, mesh
from numpy.typing import NDArray

from geometry.foundation import RigidFoundation
from geometry.tags import FacetTag
from solver.contact.facets import evaluate_facets, gather
from solver.contact.plane_contact import ContactState, PlaneContact
from solver.contact.points import contact_points, extent
from solver.mechanics.material import Material

Array = NDArray[np.float64]

FACING = -0.5
"""Cosine of the angle between a face's normal and the plane's below which the face joins."""


class ContactFaces:
    """Builds the interface of a body with a rigid plane from the faces that can touch."""

    def __init__(
        self,
        space: fem.FunctionSpace,
        facet_tags: mesh.MeshTags,
        material: Material,
        plane: RigidFoundation,
        *,
        points: str,
        gamma: float,
        friction: float,
        theta: int,
    ):
        """Take what `contact_points` and `PlaneContact` need; `join` builds the interface."""
        self._space, self._tags, self._material, self._plane = space, facet_tags, material, plane
        self._points, self._gamma, self.friction, self._theta = points, gamma, friction, theta
        self._normal = np.asarray(plane.normal)
        records = evaluate_facets(space, facet_tags, points, space.ufl_element().degree)
        facets, _ = gather(space, records, extent(space.mesh))
        self._face, self._outward = facets.tag, facets.normal
        # The bottom always takes part: the gaps in the history are those of its corners.
        self.joined: frozenset[int] = frozenset({int(FacetTag.BOTTOM)})

    def facing(self, rotation: Array) -> frozenset[int]:
        """Tags of faces with a facet turned towards the plane, and of those that joined before."""
        towards = self._outward @ rotation.T @ self._normal < FACING
        return self.joined.union(self._face[towards].tolist())

    def join(self, faces: frozenset[int]) -> PlaneContact:
        """The interface of these faces."""
        self.joined = faces
        chosen = np.isin(self._tags.values, list(faces))
        tags = mesh.meshtags(
            self._space.mesh, self._tags.dim, self._tags.indices[chosen], self._tags.values[chosen]
        )
        points = contact_points(
            self._space, tags, self._material, points=self._points, gamma=self._gamma
        )
        return PlaneContact(points, self._plane, theta=self._theta)


def carry_over(
    state: ContactState, old: PlaneContact, new: PlaneContact, fresh: ContactState
) -> ContactState:
    """The memory of `old`'s points in a fresh state of `new`, which holds those points and more."""
    place = {key: k for k, key in enumerate(old.keys())}
    for k, key in enumerate(new.keys()):
        if key in place:
            fresh.force[k], fresh.anchor[k] = state.force[place[key]], state.anchor[place[key]]
            fresh.eligible[k] = state.eligible[place[key]]
    return fresh
