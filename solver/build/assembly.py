"""From a scene to its bodies, its contacts and a stepper; only what the scene needs is meshed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from mpi4py import MPI

import numpy as np
from dolfinx.mesh import MeshTags

from geometry.arrangement import Pose
from geometry.foundation import level_frame
from geometry.mesh import move
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.rigid_body import RigidBox, rigid_box
from solver.build.foundation import FoundationBody, foundation
from solver.build.meshed_body import mesh_of_block, meshed_body
from solver.contact.body_points import FacePoints, FixedPoints, NodePoints, RigidPoints
from solver.contact.carriers import Carrier, Face
from solver.contact.edge_crossings import CrossingInterface, Crossings, Outline
from solver.contact.facets import carrier_surface
from solver.contact.interface import Interface
from solver.contact.pairs import ContactPair, FixedContactPair, MeshedContactPair
from solver.excitation.motion import GroundMotion, read_ground
from solver.scene import BlockSpec, Scene
from solver.scene.places import stands
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.state import State
from solver.stepping.stepper import StepFailed, Stepper
from solver.stepping.system import Body, System
from solver.types import Array

FACE_CORNERS = {
    (2, FacetTag.TOP): ((3, 2), "interval"),
    (2, FacetTag.BOTTOM): ((1, 0), "interval"),
    (3, FacetTag.TOP): ((4, 5, 7, 6), "quadrilateral"),
    (3, FacetTag.BOTTOM): ((0, 3, 1, 2), "quadrilateral"),
}
"""Corners of a box on a level face, in the order of a facet of `carrier_surface`, and its shape."""


@dataclass(slots=True)
class BlockBody:
    """A block as a body.

    Attributes:
        spec: What the scene says of it.
        body: The body.
        number: Of the body in the system.
        stand: From the body's reference configuration to where it begins.
        tags: Facet tags of a meshed body.
        contacts: Numbers of its contacts: with its own points, with those of the edge below it, and
            in space where its edges cross those below.
    """

    spec: BlockSpec
    body: ElasticBody | RigidBox
    number: int
    stand: Pose
    tags: MeshTags | None = None
    contacts: list[int] = field(default_factory=list)


@dataclass(slots=True)
class Assembly:
    """A scene made of bodies.

    Attributes:
        stepper: Steps them.
        members: The blocks, in the order of the scene.
        support: What carries them.
    """

    stepper: Stepper
    members: Sequence[BlockBody]
    support: FoundationBody


def build(
    scene: Scene,
    ground: GroundMotion | None = None,
    *,
    petsc_options: Sequence[str] = (),
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> Assembly:
    """Mesh what has to be meshed and set the solver up.

    The motion of the ground is read here where it is not given; the options are for SNES.
    """
    ground = ground or read_ground(scene, comm)
    placed = stands(scene.order, scene.dimension)
    members = [_member(scene, k, placed[spec.name], comm) for k, spec in enumerate(scene.blocks)]
    support = foundation(scene, len(members), comm, ground)
    bodies: list[Body] = []
    bodies += [member.body for member in members]
    if support.body is not None:
        bodies.append(support.body)
    contacts: list[ContactPair] = []
    for member in members:
        contacts += _contacts(scene, member, members, support, len(contacts))
    stepper = Stepper(
        System(bodies),
        contacts,
        GeneralizedAlpha(scene.time.rho_inf, scene.time.damped_steps * scene.time.step),
        gravity=np.array(scene.gravity_vector),
        ground=ground if ground.moves else None,
        velocity_solve=scene.contact.velocity_solve,
        petsc_options=petsc_options,
    )
    return Assembly(stepper, members, support)


def _member(scene: Scene, number: int, placed: tuple[Pose, Pose], comm: MPI.Intracomm) -> BlockBody:
    """One block: meshed upright at its place, or rigid."""
    spec = scene.blocks[number]
    upright, stand = placed
    if spec.model == "rigid":
        centre = np.zeros(scene.dimension)
        centre[-1] = spec.height / 2
        block = rigid_box(spec.name, spec.shape, upright(centre[None])[0], comm=comm)
        return BlockBody(spec, block, number, stand)
    made = mesh_of_block(scene, spec, comm)
    move(made.mesh, upright)
    body = meshed_body(
        scene,
        spec.name,
        made,
        material=spec.material(scene.material_plane),
        thickness=spec.thickness,
        degree=spec.degree,
        damping=scene.damping_of(spec),
    )
    return BlockBody(spec, body, number, stand, made.facet_tags)


def _contacts(
    scene: Scene,
    member: BlockBody,
    members: Sequence[BlockBody],
    support: FoundationBody,
    first: int,
) -> list[ContactPair]:
    """The contact of a block with what carries it, of that one's edge with it, of both edges."""
    law, bed = scene.friction_of(member.spec), scene.bed_of(member.spec)
    below = next((other for other in members if other.spec.name == member.spec.carrier), None)
    carrier, on = (support.carrier(), support.number) if below is None else _top(below)
    own: ContactPair
    if isinstance(member.body, ElasticBody):
        assert member.tags is not None
        contact = scene.contact
        own = MeshedContactPair(
            member.body,
            member.tags,
            carrier,
            law,
            points=contact.points,
            gamma=contact.gamma,
            theta=contact.theta,
            body=member.number,
            on=on,
            bed=bed,
        )
    else:
        points = RigidPoints(member.body, *_outline(member.body, carrier))
        interface = Interface(points, carrier, law, bed=bed)
        own = FixedContactPair(interface, body=member.number, on=on)
    contacts = [own]
    if isinstance(carrier, Face):
        bottom = _bottom(member)
        area = (bottom.facet / 2) ** (scene.dimension - 1)
        area *= member.spec.thickness if scene.dimension == 2 else 1.0
        edge = Interface(
            outline_points(carrier.points), bottom, law, bed=bed, corner_area=area, of_edge=True
        )
        contacts.append(FixedContactPair(edge, body=on, on=member.number))
        if scene.dimension == 3:
            crossings = _crossings(bottom, carrier)
            crossing = CrossingInterface(crossings, law, bed=bed, corner_area=area)
            contacts.append(FixedContactPair(crossing, body=member.number, on=on))
    member.contacts = list(range(first, first + len(contacts)))
    return contacts


def _outline(body: RigidBox, carrier: Carrier) -> tuple[Array, Array]:
    """Points of a rigid block that may touch, and the area of the bottom that each stands for, m2.

    They are its corners, on facets that deform also a grid on its bottom, no closer than the
    facets: forces of more points than there are nodes below are not unique. Those of the top stand
    for as much as those of the bottom: they touch where the block lies on its back.
    """
    sides = np.ptp(body.bottom, axis=0)[:-1]
    counts = [1] * len(sides)
    if isinstance(carrier, Face) and not isinstance(carrier.points, FixedPoints):
        counts = [max(1, int(side / carrier.facet + 1e-9)) for side in sides]
    lines = [np.linspace(0, 1, count + 1) for count in counts]
    fractions = np.stack(np.meshgrid(*lines, indexing="ij"), -1).reshape(-1, len(sides))
    inner = (fractions > 0) & (fractions < 1)
    cell = float(np.prod(sides / counts)) * (body.shape.thickness if body.dimension == 2 else 1.0)
    area = cell * np.prod(np.where(inner, 1.0, 0.5), axis=1)
    between = inner.any(axis=1)
    upwards = np.zeros((np.count_nonzero(between), 1))
    grid = body.corners[0] + np.hstack([fractions[between] * sides, upwards])
    corners = np.full(len(body.corners), cell / 2 ** len(sides))
    return np.vstack([body.corners, grid]), np.concatenate([corners, area[between]])


def _face(member: BlockBody, tag: FacetTag, up: float, margin: float) -> Face:
    """A level face of a block as a carrier."""
    frame = level_frame(member.body.dimension, up)
    if isinstance(member.body, ElasticBody):
        assert member.tags is not None
        surface = carrier_surface(member.body.space, member.tags, int(tag))
        nodes = NodePoints(member.body, surface.layer, surface.positions)
        return Face(nodes, surface.nodes, frame, surface.cell, surface.degree, margin)
    # The corners along the tangent of the frame, in space in the order of basix, turned outwards.
    chosen, cell = FACE_CORNERS[member.body.dimension, tag]
    points = RigidPoints(member.body, member.body.corners[list(chosen)])
    return Face(points, np.arange(len(chosen))[None], frame, cell, 1, margin)


def _top(member: BlockBody) -> tuple[Face, int]:
    """The top of a block as a carrier.

    It carries a little beyond its edge: so a block of the same width, whose own edge is there, has
    its corner carried by one of the two at any time (`_bottom` leaves less than that out).
    """
    return _face(member, FacetTag.TOP, 1.0, 1e-5), member.number


def _bottom(member: BlockBody) -> Face:
    """The bottom of a block as what an edge below it presses on, its own edges left out."""
    return _face(member, FacetTag.BOTTOM, -1.0, -1e-6)


def _crossings(bottom: Face, top: Face) -> Crossings:
    """Edges of a block's bottom that may cross those of what carries it."""
    upper, lower = (Outline(outline_points(face.points), face.degree) for face in (bottom, top))
    return Crossings(upper, lower, top, bottom)


def outline_points(points: FacePoints) -> FacePoints:
    """Points of a level face that lie on its outline: of what cannot bend, its corners."""
    if isinstance(points, RigidPoints):
        return points
    level = points.reference[:, :-1]
    near = 1e-9 * np.ptp(level, axis=0)
    low, high = level.min(axis=0) + near, level.max(axis=0) - near
    extreme = (level < low) | (level > high)
    if isinstance(points, FixedPoints):
        return FixedPoints(points.reference[np.all(extreme, axis=1)])
    outline = np.flatnonzero(np.any(extreme, axis=1))
    return NodePoints(points.body, points.layer, points.reference, chosen=outline)


def initial_state(scene: Scene, assembly: Assembly) -> tuple[State, str]:
    """The state at t = 0, and a remark where it could not be as requested.

    In equilibrium where the blocks begin closed, else unstressed.
    """
    stepper, remark = assembly.stepper, ""
    u = np.zeros(stepper.system.size)
    v = np.zeros_like(u)
    for member in assembly.members:
        own = stepper.system.slices[member.number]
        u[own], v[own] = _placed(member)
    closed = all(block.tilt == 0.0 for block in scene.blocks)
    meshed = bool(stepper.system.meshed)
    if scene.time.initial == "static" and closed and meshed and scene.gravity > 0:
        for glued in (False, True):
            try:
                state = stepper.static_start(u, glued=glued)
                return stepper.launch(state, v) if v.any() else state, remark
            except StepFailed as trouble:
                remark = f"no equilibrium at the start ({trouble}): it begins without stress"
                if not glued:
                    remark = "friction does not hold the blocks at the start: they are let go there"
    return stepper.start(u, v), remark


def _placed(member: BlockBody) -> tuple[Array, Array]:
    """Initial displacement and velocity of the owned unknowns of a block."""
    body, spec = member.body, member.spec
    centre, rotation = member.stand(body.centre[None])[0], member.stand.rotation
    if isinstance(body, RigidBox):
        linear, spin = np.asarray(spec.velocity), np.atleast_1d(spec.angular_velocity)
        speed = body.initial_velocity(linear, spin, rotation)
        return body.initial(centre - body.centre, rotation), speed
    place = member.stand(body.nodes)
    arm = place - centre
    velocity = np.tile(np.asarray(spec.velocity, dtype=float), (len(arm), 1))
    if body.dimension == 2:
        assert isinstance(spec.angular_velocity, float)
        velocity += spec.angular_velocity * arm[:, ::-1] * (1.0, -1.0)
    else:
        velocity += np.cross(np.asarray(spec.angular_velocity, dtype=float), arm)
    return (place - body.nodes).ravel(), velocity.ravel()
