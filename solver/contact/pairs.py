"""Pairs of bodies that may touch, and the interfaces between them that are active.

A block and what carries it at the start are a pair throughout. Any other two bodies are one while
they are near: then two of their faces look at each other, those along whose normals they are apart,
or overlap least (the separating axis theorem).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from dolfinx import mesh

from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.kinematics import RigidMotion
from solver.contact.carriers import Carrier, Face
from solver.contact.edge_crossings import CrossingInterface, Crossings
from solver.contact.facets import evaluate_facets, extent, gather
from solver.contact.hull import (
    Floor,
    PlacedHull,
    gaps,
    opposite_face,
    separating_face,
)
from solver.contact.interface import Interface
from solver.contact.surfaces import BlockSurface, nitsche_points, outline_of, outline_points
from solver.scene import Bed, FrictionSpec
from solver.types import Array

FACING = -0.5
"""Cosine of the angle between a face's normal and the carrier's below which the face joins."""


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

    step: float
    """Length of the step, s."""

    def unknowns(self, body: int | None) -> Array | None:
        """Owned unknowns of a body; None for the ground."""

    def ahead(self, body: int | None) -> Array | None:
        """Owned unknowns of a body expected at the end of the step; None for the ground."""

    def rotation(self, body: int | None) -> Array:
        """Rotation of a body, (d, d)."""

    def motion(self, body: int) -> RigidMotion:
        """Motion of a body as a whole."""


class ContactPair(Protocol):
    """Two bodies that may touch, and the interfaces between them.

    What is active of them is a value that pairs of one kind understand: tags of faces, or a
    `ActiveFaces`.

    Attributes:
        body: Number of the body whose points these are; None for what is fixed to the ground.
    """

    body: int | None

    def active(self, bodies: Bodies, before: Any) -> Any:
        """What is active in a step, by what was before it; None before the first."""

    def faces(self, active: Any) -> frozenset[int]:
        """Tags of the faces of the body whose points with tractions are active."""

    def links(self, active: Any, shared: frozenset[int]) -> tuple[Link, ...]:
        """The interfaces, made anew; collective. The theta terms of `shared` faces are others'."""


class MeshedContactPair:
    """The faces of a meshed body, and what carries it.

    Every boundary facet is a candidate. But the theta term of Nitsche's method and the tractions of
    a face cost time in every iteration, so a face joins when it has turned to within 60 degrees of
    facing its carrier, which a block that stands, slides or rocks never lets its sides do; one that
    tips over does, before it touches with them. Faces that have joined stay.
    """

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
        """Take what `contact_points` and `Interface` need.

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
        self._on, self._carrier = on, carrier
        self._member, self._tags, self._law = member, facet_tags, law
        self._points, self._gamma, self._theta, self._cuts = points, gamma, theta, cuts
        self._bed = bed
        space = member.space
        records = evaluate_facets(space, facet_tags, points, space.ufl_element().degree)
        facets, _ = gather(space, records, extent(space.mesh))
        self._face, self._outward = facets.tag, np.ascontiguousarray(facets.normal)
        self._found: dict[bytes, frozenset[int]] = {}  # faces, by the facets that are turned there
        # The bottom is always active: the gaps in the history are those of its corners.
        self._always: frozenset[int] = frozenset({int(FacetTag.BOTTOM)})

    def active(self, bodies: Bodies, before: frozenset[int] | None) -> frozenset[int]:
        """Tags of the bottom, of faces that were active, and of those turned to the carrier."""
        frame = self._carrier.frame
        if before is None and isinstance(self._carrier, Face):
            frame = self._carrier.reference_frame @ bodies.rotation(self._on).T
        towards = self._outward @ (frame[0] @ bodies.rotation(self.body)) < FACING
        key = towards.tobytes()
        if key not in self._found:
            self._found[key] = self._always.union(map(int, self._face[towards]))
        found = self._found[key]
        if before is None or found == before:
            return found
        return before | found

    def faces(self, active: frozenset[int]) -> frozenset[int]:
        """Tags of the active faces."""
        return active

    def links(self, active: frozenset[int], shared: frozenset[int]) -> tuple[Link, ...]:
        """The interface of the active faces, made anew; collective."""
        points = nitsche_points(
            self._member,
            self._tags,
            active,
            points=self._points,
            gamma=self._gamma,
            cuts=self._cuts,
        )
        interface = Interface(
            points, self._carrier, self._law, theta=self._theta, bed=self._bed, shared=shared
        )
        return (Link(interface, self.body, self._on),)


class FixedContactPair:
    """Points that are active from the beginning to the end: of rigid bodies, of edges."""

    def __init__(self, interface: Interface, *, body: int | None, on: int | None):
        """Take the interface, and the numbers of the body of its points and of what they touch."""
        self.body = body
        self._links = (Link(interface, body, on),)

    def active(self, bodies: Bodies, before: frozenset[int] | None) -> frozenset[int]:
        """No face ever joins."""
        return frozenset()

    def faces(self, active: frozenset[int]) -> frozenset[int]:
        """No faces: these points have no tractions."""
        return active

    def links(self, active: frozenset[int], shared: frozenset[int]) -> tuple[Link, ...]:
        """The interface that was given."""
        return self._links


class ActiveFaces(NamedTuple):
    """Two faces that look at each other.

    Attributes:
        first: Tag of that of the first body.
        second: Number of that of the second body: its tag, or 0 of a floor.
        faces: Tags of the faces of the first body that are turned towards the second's.
    """

    first: int
    second: int
    faces: frozenset[int]


FLOOR = 0
"""Number of the only face of what is no block."""

NEAR = 0.01
"""Part of the smaller body's size below which two bodies are near: their faces are active. They
stay so up to twice as far."""

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
    the first; in space, edges cross.

    Attributes:
        on: Number of the second body; None for what is fixed to the ground.
        turns: True if the second body turns: it is a block.
        looked: What was found active last; None before the first look.
        slack: Distance that both may move, together, before something else can be, m.
        reach: Distance by which a turn by an angle moves any of their points against the other's
            faces, at most, m.
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
                Some faces of theirs are active then, wherever they are.
        """
        self.body: int | None = first.number
        self.on = second.number
        self.turns = isinstance(second, BlockSurface)
        self._first, self._second, self._law, self._bed = first, second, law, bed
        self._stands, self._size = stands, min(first.hull.size, second.hull.size)
        self.looked: tuple[ActiveFaces | None] | None = None
        self.slack = self.reach = 0.0
        self._lower: dict[int, Carrier] = {}  # faces of the second body
        self._outlines: dict[tuple[int, int], list[Interface]] = {}

    # ------------------------------------------------------------- which faces

    def active(self, bodies: Bodies, before: ActiveFaces | None) -> ActiveFaces | None:
        """The faces that look at each other in a step; None where the bodies are not near."""
        if before is None and self._stands:
            top = self._second.tags[self._second.top]
            before = ActiveFaces(int(FacetTag.BOTTOM), top, frozenset({int(FacetTag.BOTTOM)}))
        now, first, second = self._placed(bodies.unknowns)
        ahead, _, _ = self._placed(bodies.ahead)
        size = self._size
        near = NEAR * size * (1.0 if before is None else 2.0)
        apart = float(np.minimum(now, ahead).max())  # bodies may pass one another in a step
        if apart > near:
            return self._keep(before if self._stands else None, bodies, apart - near)
        count = len(first.levels)
        best, keeps = separating_face(now, ahead), self._numbers(before, count)
        if keeps and max(now[k] for k in keeps) > now[best] - HELD * size:
            best = max(keeps, key=lambda k: float(now[k]))
        if best < count:
            one, other = best, opposite_face(second, first.normals[best])
        else:
            one, other = opposite_face(first, second.normals[best - count]), best - count
        tag, number = self._first.tags[one], self._second.tags[other]
        slack = self._slack(now, one, count + other)
        if before is not None:
            slack = min(slack, near - apart)
        if float(first.normals[one] @ second.normals[other]) > MUTUAL:
            slack = 0.0
        turned = first.normals @ second.normals[other] < FACING
        faces = frozenset(
            t for t, is_turned in zip(self._first.tags, turned, strict=True) if is_turned
        )
        faces |= {tag}
        if before is not None and before.second == number:
            faces |= before.faces
        return self._keep(ActiveFaces(tag, number, faces), bodies, slack)

    def overlaps(self, bodies: Bodies, active: ActiveFaces | None) -> bool:
        """True if the bodies are in one another, though no faces of theirs were active so far."""
        if active is not None:
            return False
        now, _, _ = self._placed(bodies.unknowns)
        return float(now.max()) < -HELD * self._size

    def _numbers(self, meeting: ActiveFaces | None, count: int) -> list[int]:
        """The faces of a meeting by their numbers among the gaps; `count`: those of the first."""
        if meeting is None:
            return []
        other = count + self._second.tags.index(meeting.second)
        return [self._first.tags.index(meeting.first), other]

    @staticmethod
    def _slack(now: Array, one: int, other: int) -> float:
        """How far other faces are from taking the place of two that look at each other, m."""
        best, rest = max(now[one], now[other]), np.delete(now, [one, other])
        most = float(rest.max(initial=-np.inf))
        return min(float(best) - most, -most) if np.isfinite(most) else np.inf

    def _placed(
        self, unknowns: Callable[[int | None], Array | None]
    ) -> tuple[Array, PlacedHull, PlacedHull]:
        """Gaps and hulls for the owned unknowns of bodies."""
        one = self._first.hull.placed(unknowns(self.body))
        other = self._second.hull.placed(unknowns(self.on))
        return gaps(one, other), one, other

    def _keep(self, active: ActiveFaces | None, bodies: Bodies, slack: float) -> ActiveFaces | None:
        """What is active for as long as bodies move by less than half a slack, m."""
        d, size = self._first.dimension, self._first.hull.size
        middle = self._first.body.centre + bodies.motion(self._first.number).moved
        if isinstance(self._second, BlockSurface):
            size += self._second.hull.size
            other = self._second.body.centre + bodies.motion(self._second.number).moved
            size += float(np.abs(middle - other).max())
        self.looked, self.slack = (active,), 0.5 * slack
        self.reach = d**0.5 * size + self.slack
        return active

    # ------------------------------------------------------------- interfaces

    def faces(self, active: ActiveFaces | None) -> frozenset[int]:
        """Tags of the active faces of the first body, if they have tractions."""
        if active is None or not isinstance(self._first.body, ElasticBody):
            return frozenset()
        return active.faces

    def links(self, active: ActiveFaces | None, shared: frozenset[int]) -> tuple[Link, ...]:
        """The interfaces between the faces; collective.

        That of the points is made anew, those of outlines are kept: their points stay the same.
        """
        if active is None:
            return ()
        if active.second not in self._lower:
            self._lower[active.second] = self._second.face(active.second, BESIDE_CARRIED)
        lower = self._lower[active.second]
        own = self._first.over(lower, self._law, active.faces, shared=shared, bed=self._bed)
        links = [Link(own, self.body, self.on, stands=self._stands)]
        if isinstance(lower, Face):
            faces = active.first, active.second
            if faces not in self._outlines:
                upper = self._first.face(active.first, BESIDE_BELOW)
                beside = edge_interfaces(upper, lower, self._first.thickness, self._law, self._bed)
                self._outlines[faces] = beside
            edge, *crossings = self._outlines[faces]
            links.append(Link(edge, self.on, self.body, stands=self._stands))
            links += [Link(each, self.body, self.on, stands=self._stands) for each in crossings]
        return tuple(links)


def edge_interfaces(
    upper: Face, lower: Face, thickness: float, law: FrictionSpec, bed: Bed | None = None
) -> list[Interface]:
    """The interface of a face's outline with the face on it; in space, that of both outlines, too.

    In the plane the thickness is that of the upper body, m.
    """
    d = len(lower.frame)
    area = (upper.facet / 2) ** (d - 1) * (thickness if d == 2 else 1.0)
    outline = outline_points(lower.points, lower.reference_frame)
    found = [Interface(outline, upper, law, bed=bed, corner_area=area, of_edge=True)]
    if d == 3:
        up = lower.reference_frame[0]
        over, under = outline_of(upper, -upper.reference_frame[0]), outline_of(lower, up)
        crossings = Crossings(over, under, lower, upper)
        found.append(CrossingInterface(crossings, law, bed=bed, corner_area=area))
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
