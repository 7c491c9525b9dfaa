"""Links and forces of a scene with meshed bodies: the places at which they act, and their laws."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from geometry.arrangement import Pose, level
from solver.bodies.attachment import (
    MeshedPlace,
    RigidPlace,
    axes_of,
    centre_of,
    face_of,
    point_of,
)
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.bodies.rigid_body import DenseBody
from solver.build.block_body import BlockBody
from solver.build.foundation import FoundationBody
from solver.contact.carriers import Face
from solver.excitation.forces import mean_factor, normal_of, place_of, whole_force
from solver.law.links import axes_of as axes_of_link
from solver.law.links import laws_of
from solver.scene import Scene
from solver.scene.force import ForceSpec
from solver.scene.laws import GROUND
from solver.scene.link import LinkSpec
from solver.scene.places import own_ends
from solver.stepping.attached import AppliedForce, Attached, BodyPlace
from solver.stepping.body_links import BodyLink, BodyLinks
from solver.stepping.system import System
from solver.types import Array


class End(NamedTuple):
    """What links end on: a body, or the ground.

    Attributes:
        body: Number of the body in the system; None: the ground.
        point: The place that a point of the own frame is, (d,), m; collective.
        axis: That which a direction of the own frame is, (d,); collective.
    """

    body: int | None
    point: Callable[[Array], Any]
    axis: Callable[[Array], Any]


def _rigid(number: int, upright: Pose) -> End:
    """A rigid block or a platform, by the motion from its own frame to its initial place."""

    def point(place: Array) -> RigidPlace:
        return RigidPlace(upright(place[None]), np.ones(1))

    def axis(direction: Array) -> RigidPlace:
        """The difference of two points."""
        ends = upright(np.array([direction, np.zeros_like(direction)]))
        return RigidPlace(ends, np.array([1.0, -1.0]))

    return End(number, point, axis)


def _elastic(number: int, body: ElasticBody, upright: Pose) -> End:
    """An elastic block, whose own frame is not turned where it is meshed."""
    axes = cache(partial(axes_of, body))

    def point(place: Array) -> MeshedPlace:
        return point_of(body, upright(place[None])[0])

    def axis(direction: Array) -> MeshedPlace:
        first, *others = (share * own.rows for share, own in zip(direction, axes(), strict=True))
        return MeshedPlace(sp.csr_matrix(sum(others, first)), direction)

    return End(number, point, axis)


def _deck(number: int, body: ElasticBody | ReducedBody, top: Face) -> End:
    """The top of a meshed foundation, which does not turn as a whole."""

    def point(place: Array) -> MeshedPlace:
        """By the shape functions of the facet on which the point is."""
        points, d = top.points, body.dimension
        state = points.observe(np.zeros(body.size))
        projection = top.kinematics(place[None], state, top.reference_frame).projection
        assert projection is not None
        rows = np.zeros((d, body.size))
        for row, along in zip(rows, np.eye(d), strict=True):
            force = np.zeros((points.count, d))
            force[projection.nodes[0]] = np.outer(projection.weights[0], along)
            points.add_forces(row, state, state, force)
        return MeshedPlace(sp.csr_matrix(rows), place)

    def axis(direction: Array) -> MeshedPlace:
        return MeshedPlace(sp.csr_matrix((len(direction), body.size)), direction)

    return End(number, point, axis)


def _of_block(block: BlockBody) -> End:
    """The ends of links to a block."""
    if isinstance(block.body, ElasticBody):
        return _elastic(block.number, block.body, block.upright)
    return _rigid(block.number, block.upright)


def _of_support(support: FoundationBody) -> End:
    """The ends of links to the foundation."""
    body, number = support.body, support.number
    if body is None or number is None:
        return End(None, np.asarray, np.asarray)
    if isinstance(body, DenseBody):
        return _rigid(number, level(np.zeros(body.dimension)))
    assert isinstance(support.carrier, Face)
    return _deck(number, body, support.carrier)


def _acted_on(force: ForceSpec, block: BlockBody, end: End) -> MeshedPlace | RigidPlace:
    """Where a force acts on a block: a point, the mean of a face, or the centre; collective."""
    body, d = block.body, block.body.dimension
    if not isinstance(body, ElasticBody):
        return end.point(place_of(force, block.spec.shape, d))
    if force.face is not None:
        assert block.facet_tags is not None
        axis, sense = normal_of(force, d)
        facets = block.parts[0].facets_towards(-sense * np.eye(d)[axis])
        return face_of(body, block.facet_tags, *facets)
    return centre_of(body) if force.at is None else end.point(np.array(force.at))


def attached_of(
    scene: Scene, blocks: Sequence[BlockBody], support: FoundationBody, system: System
) -> Attached | None:
    """Links and forces of a scene; None where it has neither; collective."""
    if not (scene.links or scene.forces):
        return None
    ends = {GROUND: _of_support(support)} | {block.spec.name: _of_block(block) for block in blocks}
    known = {block.spec.name: block for block in blocks}
    poses = scene.poses() | {GROUND: level(np.zeros(scene.dimension))}
    places: list[BodyPlace] = []
    links = list[BodyLink]()
    for link in scene.links:
        first = len(places)
        places += _places_of(link, ends, poses)
        links.append(_link(link, range(first, len(places))))
    forces = list[AppliedForce]()
    for force in scene.forces:
        block, end = known[force.on], ends[force.on]
        whole = whole_force(force, poses[force.on], block.spec.shape)
        forces.append(AppliedForce(len(places), whole, partial(mean_factor, force)))
        places.append(BodyPlace(end.body, _acted_on(force, block, end)))
    return Attached(system, places, BodyLinks(links, scene.dimension), forces)


def _places_of(
    link: LinkSpec, ends: Mapping[str, End], poses: Mapping[str, Pose]
) -> Iterator[BodyPlace]:
    """Places of the ends of a link, then its axes; collective."""
    for name, place in zip(link.between, own_ends(link, poses), strict=True):
        yield BodyPlace(ends[name].body, ends[name].point(place))
    if not link.is_axial:
        own = ends[link.between[0]]
        for direction in axes_of_link(link, poses):
            yield BodyPlace(own.body, own.axis(direction))


def _link(link: LinkSpec, places: Sequence[int]) -> BodyLink:
    """A link whose ends and axes have these numbers."""
    return BodyLink(
        ends=(places[0], places[1]),
        axes=tuple(places[2:]),
        length=None if link.length is None else np.array([link.length]),
        laws=laws_of(link, len(link.at)),
        preload=link.preload or 0.0,
        strength=np.inf if link.strength is None else link.strength,
    )
