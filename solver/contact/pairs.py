"""Pairs of bodies that may touch, and the interfaces between them that are active.

Two bodies are active while they are near, a block and what carries it at the start always: then two
of their faces look at each other, those along whose normals they are apart, or overlap least (the
separating axis theorem). The outline of the second body's face is active while the first's face is
not well within it. Bodies that are not convex meet what carries them by the faces of their convex
hulls, of which they may have less than all, and others by those of their convex parts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.kinematics import RigidMotion
from solver.contact.carriers import Carrier, Face
from solver.contact.edge_crossings import CrossingInterface, Crossings
from solver.contact.hull import (
    Floor,
    PlacedHull,
    depth_inside,
    gaps,
    opposite_face,
    separating_face,
)
from solver.contact.interface import Interface
from solver.contact.surfaces import BlockSurface, outline_of, outline_points
from solver.scene import Bed, FrictionSpec
from solver.types import Array


@dataclass(frozen=True, slots=True)
class Link:
    """An interface between two bodies of a system."""

    interface: Interface
    """Kinematics and law."""
    body: int | None
    """Number of the body whose points these are; None for what is fixed to the ground."""
    carrier: int | None
    """Number of the body that carries them; None likewise."""
    stands: bool = True
    """True if the one stands on the other at the start."""


class Bodies(Protocol):
    """The bodies of a system at the start of a step."""

    def unknowns(self, body: int | None) -> Array | None:
        """Owned unknowns of a body; None for the ground."""

    def expected(self, body: int | None) -> Array | None:
        """Owned unknowns of a body expected at the end of the step; None for the ground."""

    def motion(self, body: int) -> RigidMotion:
        """Motion of a body as a whole."""


class PairSearch(NamedTuple):
    """What was found active of a pair, and for how long.

    Attributes:
        active: A value that only the pair itself understands; None: nothing.
        slack: Distance that both bodies may move, together, before something else can be, m.
        reach: Distance by which a turn by an angle moves any of their points against the other's
            faces, at most, m.
    """

    active: Any
    slack: float
    reach: float


class ContactPair(Protocol):
    """Two bodies that may touch, and the interfaces between them.

    Attributes:
        body: Number of the first body.
        on: Number of the second body; None for what is fixed to the ground.
    """

    body: int
    on: int | None

    def search(self, bodies: Bodies, before: Any) -> PairSearch:
        """What is active in a step, by what was before it; None before the first."""

    def is_missed(self, bodies: Bodies, active: Any) -> bool:
        """True if something else than what is active is in contact."""

    def faces(self, active: Any) -> frozenset[int]:
        """Tags of the faces of the body whose points with tractions are active."""

    def links(self, active: Any, shared: frozenset[int]) -> tuple[Link, ...]:
        """The interfaces; collective. The theta terms of `shared` faces are others'."""


class ActiveFaces(NamedTuple):
    """Two faces that look at each other.

    Attributes:
        first: Tag of that of the first body.
        second: That of the second body; `FLOOR` of what is no block.
        faces: Tags of the faces of the first body that are turned towards the second's, or were so
            since that looks at it.
        at_edge: True if the first body's face is near the outline of the second's.
    """

    first: int
    second: int
    faces: frozenset[int]
    at_edge: bool = False


FLOOR = 0
"""Number of the only face of what is no block."""

FACING = -0.45
"""Cosine of the angle between a face's normal and that of the second body's face, below which its
points are active: 63 degrees. A box that stands, slides or rocks never lets its sides do so, which
would cost time in every iteration; one that tips over does, before it touches with them. Sides of
no regular polygon stand there: those of a hexagon and of a triangle that is about to touch with its
next side are at 60 degrees, where round-off would decide."""

NEAR = 0.01
"""Part of the smaller body's size below which two bodies are near: their faces are active; and by
which a face is farther within the outline of another one where that is not. They stay so up to
twice as far."""

HELD = 1e-6
"""Part of that size by which bodies may overlap more along the normal of the active face than along
another one before that takes over."""

MUTUAL = -0.9
"""Cosine between two faces that look at each other, below which no other face comes in before the
bodies have turned a good deal."""

TURN = 0.1
"""Sum of the entries of the rotations by which they may turn before that."""

BESIDE_CARRIED, BESIDE_BELOW = 1e-5, -1e-6
"""Part of a facet: up to this far beyond its edge a face carries the points of the first body, and
from this far within its edge the points of the second. One of two corners that are at one place is
carried at any time."""


class FacePair:
    """Two bodies of which faces look at each other.

    The points of the first are pressed on a face of the second, the outline of that on a face of
    the first; in space, edges cross. An endless plane has no outline.
    """

    def __init__(
        self,
        first: BlockSurface,
        second: BlockSurface | FloorSurface,
        law: FrictionSpec,
        *,
        bed: Bed | None = None,
        stands: bool = False,
    ):
        """Take the bodies, and their friction.

        Args:
            first: Whose points are pressed on the other: what stands on it, or the one with more
                of them.
            second: The other one.
            law: Friction.
            bed: Springs and dashpots between them.
            stands: True if the first stands on the second at the start: with its bottom on a top.
                Some faces of theirs are active then, wherever they are, the bottom always while the
                second body's face is that top.
        """
        self.body, self.on = first.number, second.number
        self._first, self._second, self._law, self._bed = first, second, law, bed
        self._stands, self._size = stands, min(first.hull.size, second.hull.size)
        self._lower: dict[int, Carrier | None] = {}  # faces of the second body
        self._own: dict[tuple[int, frozenset[int], frozenset[int]], Interface] = {}
        self._outlines: dict[tuple[int, int], list[Link]] = {}

    # ------------------------------------------------------------- which faces

    def search(self, bodies: Bodies, before: ActiveFaces | None) -> PairSearch:
        """The faces that look at each other in a step; None where the bodies are not near."""
        if before is None and self._stands:
            bottom, top = int(FacetTag.BOTTOM), self._second.tags[self._second.top]
            before = ActiveFaces(bottom, top, frozenset({bottom}))
        first, second = places = self._placed(bodies.unknowns)
        later = self._placed(bodies.expected)
        now, ahead = gaps(*places), gaps(*later)
        size = self._size
        near = NEAR * size * (1.0 if before is None else 2.0)
        apart = float(np.minimum(now, ahead).max())  # bodies may pass one another in a step
        if apart > near:
            idle = None
            if before is not None and self._stands:
                idle = before._replace(at_edge=False)
            return self._found(idle, bodies, apart - near)
        count = len(first.levels)
        best = separating_face(now, ahead)
        if before is not None:
            one, other = self._numbers(before)
            kept = max(one, count + other, key=lambda k: float(now[k]))
            if now[kept] > now[best] - HELD * size:
                best = kept
        if best < count:
            one, other = best, opposite_face(second, first.normals[best])
        else:
            one, other = opposite_face(first, second.normals[best - count]), best - count
        tag, number = self._first.tags[one], self._second.tags[other]
        slack = self._slack(now, one, count + other)
        inside = min(self._inside(*hulls, one, other) for hulls in (places, later))
        edge = NEAR * size
        at_edge = inside <= edge * (2.0 if before is not None and before.at_edge else 1.0)
        slack = min(slack, 2.0 * edge - inside if at_edge else inside - edge)
        if before is not None and (at_edge or not self._stands):
            slack = min(slack, near - apart)
        if float(first.normals[one] @ second.normals[other]) > MUTUAL:
            slack = 0.0
        turned = first.normals @ second.normals[other] < FACING
        faces = frozenset(
            t
            for t, is_turned in zip(self._first.tags, turned, strict=True)
            if is_turned and self._first.is_real(t)
        )
        faces |= {tag}
        if before is not None and before.second == number:
            faces |= before.faces
        return self._found(ActiveFaces(tag, number, faces, at_edge), bodies, slack)

    def is_missed(self, bodies: Bodies, active: ActiveFaces | None) -> bool:
        """True if the bodies are in one another, and so much as their active faces are not."""
        if active is not None and active.at_edge:
            return False
        places = self._placed(bodies.unknowns)
        if float(gaps(*places).max()) >= -HELD * self._size:
            return False
        return active is None or self._inside(*places, *self._numbers(active)) < 0.0

    def _numbers(self, active: ActiveFaces) -> tuple[int, int]:
        """The numbers of active faces in the hulls of their bodies."""
        return self._first.tags.index(active.first), self._second.tags.index(active.second)

    def _inside(self, first: PlacedHull, second: PlacedHull, one: int, other: int) -> float:
        """How far a face of the first body is within the outline of one of the second's, m."""
        return depth_inside(first.corners[self._first.hull.faces[one]], second, other)

    @staticmethod
    def _slack(now: Array, one: int, other: int) -> float:
        """How far other faces are from taking the place of two that look at each other, m."""
        best, rest = max(now[one], now[other]), np.delete(now, [one, other])
        most = float(rest.max(initial=-np.inf))
        return min(float(best) - most, -most) if np.isfinite(most) else np.inf

    def _placed(
        self, unknowns: Callable[[int | None], Array | None]
    ) -> tuple[PlacedHull, PlacedHull]:
        """The hulls for the owned unknowns of bodies."""
        other = self._second.hull.placed(unknowns(self.on))
        return self._first.hull.placed(unknowns(self.body)), other

    def _found(self, active: ActiveFaces | None, bodies: Bodies, slack: float) -> PairSearch:
        """What is active for as long as bodies move by less than half a slack, m."""
        d, size = self._first.dimension, self._first.hull.size
        middle = self._first.body.centre + bodies.motion(self._first.number).moved
        if isinstance(self._second, BlockSurface):
            size += self._second.hull.size
            other = self._second.body.centre + bodies.motion(self._second.number).moved
            size += float(np.abs(middle - other).max())
        half = 0.5 * slack
        return PairSearch(active, half, d**0.5 * size + half if np.isfinite(slack) else 0.0)

    # ------------------------------------------------------------- interfaces

    def faces(self, active: ActiveFaces | None) -> frozenset[int]:
        """Tags of the facets of the active faces of the first body, if they have tractions."""
        if active is None or not isinstance(self._first.body, ElasticBody):
            return frozenset()
        return self._first.touching(active.faces)

    def links(self, active: ActiveFaces | None, shared: frozenset[int]) -> tuple[Link, ...]:
        """The interfaces between the faces; collective.

        Each is made once: those of points that stay the same are kept.
        """
        if active is None:
            return ()
        lower, faces = self._carrier(active.second), self.faces(active)
        links = []
        if lower is not None and (faces or not isinstance(self._first.body, ElasticBody)):
            key = active.second, faces, shared
            if key not in self._own:
                own = self._first.over(lower, self._law, faces, shared=shared, bed=self._bed)
                self._own[key] = own
            links.append(Link(self._own[key], self.body, self.on, stands=self._stands))
        if active.at_edge:
            facing = active.first, active.second
            if facing not in self._outlines:
                self._outlines[facing] = self._beside(active.first, active.second)
            links += self._outlines[facing]
        return tuple(links)

    def _carrier(self, tag: int) -> Carrier | None:
        """A face of the second body as a carrier; None where it spans a hollow.

        What stands on it has its top instead, from which slips and gaps are counted.
        """
        if tag not in self._lower:
            found = self._second.face(tag, BESIDE_CARRIED)
            if found is None and self._stands:
                found = self._carrier(self._second.tags[self._second.top])
            self._lower[tag] = found
        return self._lower[tag]

    def _beside(self, first: int, second: int) -> list[Link]:
        """The interface of the outline of a face of the second body with a face of the first.

        By their tags; in space, also that of edges that cross. Of a face that spans a hollow the
        corners are the points.
        """
        upper, lower = self._first.face(first, BESIDE_BELOW), self._carrier(second)
        if upper is None:
            return []
        law, bed, d = self._law, self._bed, self._first.dimension
        area = (upper.facet / 2) ** (d - 1) * (self._first.thickness if d == 2 else 1.0)
        if isinstance(lower, Face) and self._second.is_real(second):
            points = outline_points(lower)
        else:
            assert isinstance(self._second, BlockSurface)
            points, lower = self._second.corners_of(second), None
        outline = Interface(points, upper, law, bed=bed, corner_area=area)
        found = [Link(outline, self.on, self.body, stands=self._stands)]
        if d == 3 and lower is not None:
            up = lower.reference_frame[0]
            over, under = outline_of(upper, -upper.reference_frame[0]), outline_of(lower, up)
            crossings = Crossings(over, under, lower, upper)
            edges = CrossingInterface(crossings, law, bed=bed, corner_area=area)
            found.append(Link(edges, self.body, self.on, stands=self._stands))
        return found


class FloorSurface:
    """What carries blocks and is none: one face that they can touch."""

    tags = (FLOOR,)
    top = 0

    def __init__(self, carrier: Carrier, number: int | None, dimension: int):
        """Take its surface and its number in the system; None where it does not move."""
        self.number, self._carrier = number, carrier
        points = carrier.points if isinstance(carrier, Face) else None
        self.hull = Floor(points, dimension)

    def face(self, tag: int, margin: float) -> Carrier:
        """Its face."""
        return self._carrier

    def is_real(self, tag: int) -> bool:
        """True: it has all of its face."""
        return True
