"""A pair of bodies with one interface that is active from the beginning to the end."""

from __future__ import annotations

import numpy as np
from dolfinx import mesh

from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.contact.body_points import NitschePoints
from solver.contact.carriers import Carrier
from solver.contact.interface import Interface
from solver.contact.nitsche_points import contact_points
from solver.contact.pairs import Bodies, Link, PairSearch
from solver.contact.quadrature import Cut
from solver.scene import FrictionSpec


class FixedPair:
    """One interface, always active; a `ContactPair`."""

    def __init__(self, interface: Interface, *, body: int = 0, on: int | None = None):
        """Take the interface, and the numbers of the body of its points and of what they touch."""
        self.body, self.on = body, on
        self._links = (Link(interface, body, on),)

    def search(self, bodies: Bodies, before: tuple[()] | None) -> PairSearch:
        """No face ever joins."""
        return PairSearch((), slack=np.inf, reach=0.0)

    def is_missed(self, bodies: Bodies, active: tuple[()]) -> bool:
        """False: there is nothing else."""
        return False

    def faces(self, active: tuple[()]) -> frozenset[int]:
        """No faces that another pair could have, too."""
        return frozenset()

    def links(self, active: tuple[()], shared: frozenset[int]) -> tuple[Link, ...]:
        """The interface that was given."""
        return self._links


def faces_on(
    body: ElasticBody,
    facet_tags: mesh.MeshTags,
    carrier: Carrier,
    law: FrictionSpec,
    *,
    faces: frozenset[int] = frozenset({FacetTag.BOTTOM}),
    points: str = "nodes",
    gamma: float = 100.0,
    theta: int = 1,
    cut: Cut | None = None,
) -> Interface:
    """The interface of some faces of a meshed body; `points` and `cut` as of `contact_points`."""
    chosen = np.isin(facet_tags.values, list(faces))
    domain, dim = body.space.mesh, facet_tags.dim
    tags = mesh.meshtags(domain, dim, facet_tags.indices[chosen], facet_tags.values[chosen])
    found = contact_points(body.space, tags, body.material, points=points, gamma=gamma, cut=cut)
    return Interface(NitschePoints(body, found), carrier, law, theta=theta)
