"""Links and forces of a scene with meshed bodies: the places at which they act, and their laws."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import accumulate
from typing import Any, Generic, TypeVar

import numpy as np
import scipy.sparse as sp

from geometry.arrangement import Pose, level
from geometry.block import Block
from solver.bodies.attachment import (
    Attachment,
    MeshedAttachment,
    MeshedPlace,
    RigidAttachment,
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
from solver.law.links import laws_of, sense_of
from solver.scene import Scene
from solver.scene.force import ForceSpec
from solver.scene.laws import GROUND
from solver.scene.link import LinkSpec
from solver.scene.places import own_ends
from solver.stepping.attached import AppliedForce, Attached, Attachments
from solver.stepping.body_links import BodyLink, BodyLinks
from solver.stepping.system import System
from solver.types import Array

Place = TypeVar("Place")


class Holder(ABC, Generic[Place]):
    """What has places: a body, or the ground; they are numbered as they are asked for.

    Attributes:
        number: Of the body in the system; None: the ground.
        found: The places.
    """

    def __init__(self, number: int | None):
        """Begin without any."""
        self.number, self.found = number, list[Place]()

    def add(self, place: Place) -> tuple[Holder[Any], int]:
        """Take a place; who has it, and its number there."""
        self.found.append(place)
        return self, len(self.found) - 1

    @abstractmethod
    def point(self, place: Array) -> Place:
        """A point of the own frame, (d,), m; collective."""

    @abstractmethod
    def axis(self, direction: Array) -> Place:
        """A direction of the own frame, (d,); collective."""

    def acted_on(self, force: ForceSpec) -> Place:
        """Where a force acts; collective."""
        raise NotImplementedError  # forces are on blocks

    @abstractmethod
    def attachment(self) -> Attachment | None:
        """All places; None for the ground."""


class Ground(Holder[Array]):
    """The ground: places that stand still."""

    def __init__(self) -> None:
        """Begin without any."""
        super().__init__(None)

    def point(self, place: Array) -> Array:
        """A point."""
        return place

    def axis(self, direction: Array) -> Array:
        """A direction."""
        return direction

    def attachment(self) -> None:
        """None."""
        return


class RigidHolder(Holder[tuple[Array, Array]]):
    """A rigid block or a platform: places are sums of points, (m, d), with shares, (m,)."""

    def __init__(self, number: int, body: DenseBody, upright: Pose, shape: Block | None = None):
        """Take the body, the motion from its own frame to its initial place, and its shape."""
        super().__init__(number)
        self._body, self._upright, self._shape = body, upright, shape

    def point(self, place: Array) -> tuple[Array, Array]:
        """A point of the own frame."""
        return self._upright(place[None]), np.ones(1)

    def axis(self, direction: Array) -> tuple[Array, Array]:
        """A direction: the difference of two points."""
        ends = self._upright(np.array([direction, np.zeros_like(direction)]))
        return ends, np.array([1.0, -1.0])

    def acted_on(self, force: ForceSpec) -> tuple[Array, Array]:
        """The place of a force."""
        assert self._shape is not None
        return self.point(place_of(force, self._shape, self._body.dimension))

    def attachment(self) -> RigidAttachment:
        """All places."""
        points = np.concatenate([points for points, _ in self.found])
        shares = sp.block_diag([shares[None] for _, shares in self.found]).toarray()
        return RigidAttachment(self._body, points, shares)


class MeshedHolder(Holder[MeshedPlace]):
    """An elastic block."""

    def __init__(self, block: BlockBody):
        """Take the block."""
        super().__init__(block.number)
        assert isinstance(block.body, ElasticBody) and block.facet_tags is not None
        self._body, self._upright, self._tags = block.body, block.upright, block.facet_tags
        self._box = block.parts[0]
        self._axes: list[MeshedPlace] | None = None

    def point(self, place: Array) -> MeshedPlace:
        """A point of the own frame."""
        return point_of(self._body, self._upright(place[None])[0])

    def axis(self, direction: Array) -> MeshedPlace:
        """A direction of the own frame, which is not turned where the block is meshed."""
        self._axes = self._axes or axes_of(self._body)
        first, *others = (
            share * axis.rows for share, axis in zip(direction, self._axes, strict=True)
        )
        return MeshedPlace(sp.csr_matrix(sum(others, first)), direction)

    def acted_on(self, force: ForceSpec) -> MeshedPlace:
        """The mean of a face, a point, or the centre of mass."""
        if force.face is not None:
            axis, sense = normal_of(force, self._body.dimension)
            outwards = -sense * np.eye(self._body.dimension)[axis]
            return face_of(self._body, self._tags, *self._box.facets_towards(outwards))
        if force.at is not None:
            return self.point(np.array(force.at))
        return centre_of(self._body)

    def attachment(self) -> MeshedAttachment:
        """All places."""
        return MeshedAttachment(self._body, self.found)


class DeckHolder(Holder[MeshedPlace]):
    """The top of a meshed foundation."""

    def __init__(self, number: int, body: ElasticBody | ReducedBody, top: Face):
        """Take the body and its top."""
        super().__init__(number)
        self._body, self._top = body, top

    def point(self, place: Array) -> MeshedPlace:
        """A point of the top, between the nodes around it."""
        points, d = self._top.points, self._body.dimension
        state = points.observe(np.zeros(self._body.size))
        frame = self._top.reference_frame
        projection = self._top.kinematics(place[None], state, frame).projection
        assert projection is not None
        rows = np.zeros((d, self._body.size))
        for row, along in zip(rows, np.eye(d), strict=True):
            force = np.zeros((points.count, d))
            force[projection.nodes[0]] = np.outer(projection.weights[0], along)
            points.add_forces(row, state, state, force)
        return MeshedPlace(sp.csr_matrix(rows), place)

    def axis(self, direction: Array) -> MeshedPlace:
        """A direction: it does not turn as a whole."""
        return MeshedPlace(sp.csr_matrix((len(direction), self._body.size)), direction)

    def attachment(self) -> MeshedAttachment:
        """All places."""
        return MeshedAttachment(self._body, self.found)


def attached_of(
    scene: Scene, blocks: Sequence[BlockBody], support: FoundationBody, system: System
) -> Attached | None:
    """Links and forces of a scene; None where it has neither; collective."""
    if not (scene.links or scene.forces):
        return None
    holders: dict[str, Holder[Any]] = {GROUND: _of_support(support)}
    for block in blocks:
        if isinstance(block.body, ElasticBody):
            holders[block.spec.name] = MeshedHolder(block)
        else:
            own = block.number, block.body, block.upright, block.spec.shape
            holders[block.spec.name] = RigidHolder(*own)
    poses = scene.poses() | {GROUND: level(np.zeros(scene.dimension))}
    asked = [list(_places_of(link, holders, poses)) for link in scene.links]
    pushed = [(holder := holders[force.on]).add(holder.acted_on(force)) for force in scene.forces]
    # Places are numbered body after body, those on the ground last.
    used = [holder for holder in holders.values() if holder.found]
    used.sort(key=lambda holder: np.inf if holder.number is None else holder.number)
    counts = accumulate((len(holder.found) for holder in used[:-1]), initial=0)
    first = dict(zip(used, counts, strict=True))
    links = [
        _link(link, [first[holder] + k for holder, k in places])
        for link, places in zip(scene.links, asked, strict=True)
    ]
    shapes = {block.spec.name: block.spec.shape for block in blocks}
    forces = [
        AppliedForce(
            first[holder] + k,
            whole_force(force, poses[force.on], shapes[force.on]),
            partial(mean_factor, force),
        )
        for force, (holder, k) in zip(scene.forces, pushed, strict=True)
    ]
    of_bodies = {
        holder.number: places
        for holder in used
        if holder.number is not None and (places := holder.attachment()) is not None
    }
    ground = [place for holder in used if holder.number is None for place in holder.found]
    return Attached(
        Attachments(system, of_bodies, np.reshape(ground, (-1, scene.dimension))),
        BodyLinks(links, scene.dimension),
        forces,
    )


def _of_support(support: FoundationBody) -> Holder[Any]:
    """What links to the foundation end on."""
    body, d = support.body, support.dimension
    if body is None:
        return Ground()
    assert support.number is not None
    if isinstance(body, DenseBody):
        return RigidHolder(support.number, body, level(np.zeros(d)))
    top = support.carrier()
    assert isinstance(top, Face)
    return DeckHolder(support.number, body, top)


def _places_of(
    link: LinkSpec, holders: Mapping[str, Holder[Any]], poses: Mapping[str, Pose]
) -> Iterator[tuple[Holder[Any], int]]:
    """Places of the ends of a link, then its axes; collective."""
    for name, place in zip(link.between, own_ends(link, poses), strict=True):
        yield holders[name].add(holders[name].point(place))
    if not link.is_axial:
        own = holders[link.between[0]]
        # At the start they are those of space, and turn with the first body from there.
        axes = poses[link.between[0]].rotation.copy()
        axes[-1] *= sense_of(link, poses)
        for direction in axes:
            yield own.add(own.axis(direction))


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
