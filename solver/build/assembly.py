"""From a scene to its bodies, its contacts and a stepper; only what the scene needs is meshed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product

from mpi4py import MPI

import numpy as np

from solver.bodies.body import Body
from solver.bodies.rigid_body import RigidBox
from solver.build.attached import attached_of
from solver.build.block_body import BlockBody, block_body
from solver.build.foundation import FoundationBody, foundation
from solver.contact.pairs import FacePair, FloorSurface
from solver.contact.surfaces import BlockSurface
from solver.excitation.motion import GroundMotion, read_ground
from solver.scene import Scene
from solver.scene.places import standing_part, stands
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.contact_solve import StepFailed
from solver.stepping.state import State
from solver.stepping.stepper import Stepper
from solver.stepping.system import System
from solver.types import Array


@dataclass(slots=True)
class Assembly:
    """A scene made of bodies.

    Attributes:
        stepper: Steps them.
        members: The blocks, in the order of the scene.
        support: What carries them.
        floor: Its surface.
    """

    stepper: Stepper
    members: Sequence[BlockBody]
    support: FoundationBody
    floor: FloorSurface


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
    members = [
        block_body(scene, k, *placed[spec.name], comm) for k, spec in enumerate(scene.blocks)
    ]
    support = foundation(scene, len(members), comm, ground)
    bodies: list[Body] = []
    bodies += [member.body for member in members]
    if support.body is not None:
        bodies.append(support.body)
    floor = FloorSurface(support.carrier, support.number, scene.dimension)
    carried = [_below(scene, member, members, floor) for member in members]
    pairs = [
        FacePair(
            member.surface,
            below,
            scene.friction_of(member.spec),
            bed=scene.bed_of(member.spec),
            stands=True,
        )
        for member, below in zip(members, carried, strict=True)
    ]
    pairs += _meetings(scene, members, carried, floor)
    names = {member.spec.name: member.number for member in members}
    for member in members:
        member.carriers = tuple(names[name] for name in member.spec.carriers if name in names)
    system = System(bodies)
    stepper = Stepper(
        system,
        pairs,
        GeneralizedAlpha(scene.time.rho_inf, scene.time.damped_steps * scene.time.step),
        gravity=np.array(scene.gravity_vector),
        ground=ground if ground.moves else None,
        velocity_solve=scene.contact.velocity_solve,
        petsc_options=petsc_options,
        attached=attached_of(scene, members, support, system),
    )
    return Assembly(stepper, members, support, floor)


def _below(
    scene: Scene, member: BlockBody, members: Sequence[BlockBody], floor: FloorSurface
) -> BlockSurface | FloorSurface:
    """What a block stands on, of several bodies the first: its hull, or a part in a hollow."""
    below = next((other for other in members if other.spec.name == member.spec.carrier), None)
    if below is None:
        return floor
    if len(below.parts) == 1:
        return below.surface
    part = standing_part(member.spec, below.spec, scene.poses(), scene.dimension)
    return below.surface if part is None else below.parts[part]


def _meetings(
    scene: Scene,
    members: Sequence[BlockBody],
    carried: Sequence[BlockSurface | FloorSurface],
    floor: FloorSurface,
) -> Iterator[FacePair]:
    """All pairs of bodies that may meet, but for blocks and what they stand on, `carried`."""
    laws = scene.laws
    for one, other in combinations(members, 2):
        law = laws.between(one.spec.name, other.spec.name)[0]
        for upper, lower in ((one, other), (other, one)):
            if lower.spec.name in upper.spec.carriers[1:]:
                yield FacePair(upper.surface, lower.surface, law, bed=scene.bed_of(upper.spec))
            elif lower.spec.name == upper.spec.carrier:
                if carried[upper.number] is not lower.surface:
                    rest = [part for part in lower.parts if part is not carried[upper.number]]
                    for own, others in product(upper.parts, rest):
                        yield FacePair(own, others, law)
                break
        else:
            if not {one.spec.name, other.spec.name} & {*one.spec.carriers, *other.spec.carriers}:
                first, second = sorted((one, other), key=_fineness, reverse=True)
                for own, others in product(first.parts, second.parts):
                    yield FacePair(own, others, law)
    for member in members:
        if member.spec.carrier != "foundation":
            law = laws.between(member.spec.name, "foundation")[0]
            yield FacePair(member.surface, floor, law)


def _fineness(member: BlockBody) -> float:
    """Facets over the size of a block, 1/m: none of a rigid one."""
    return 0.0 if member.spec.model == "rigid" else member.spec.mesh.fineness


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
    closed = all(block.tilt == 0.0 and block.position is None for block in scene.blocks)
    meshed = bool(stepper.system.meshed)
    if scene.time.initial == "static" and closed and meshed and scene.gravity > 0:
        # Forces that act from the start on are in it where they let blocks stand.
        pushes = [(False, True)] if scene.forces else []
        for glued, pushed in (*pushes, (False, False), (True, False)):
            try:
                state = stepper.static_start(u, glued=glued, pushed=pushed)
                return stepper.launch(state, v) if v.any() else state, remark
            except StepFailed as trouble:
                if pushed:
                    continue
                remark = f"no equilibrium at the start ({trouble}): it begins without stress"
                if not glued:
                    remark = "friction does not hold the blocks at the start: they are let go there"
    return stepper.start(u, v), remark


def _placed(member: BlockBody) -> tuple[Array, Array]:
    """Initial displacement and velocity of the owned unknowns of a block."""
    body, spec = member.body, member.spec
    centre, rotation = member.start(body.centre[None])[0], member.start.rotation
    if isinstance(body, RigidBox):
        linear, spin = np.asarray(spec.velocity), np.atleast_1d(spec.angular_velocity)
        speed = body.initial_velocity(linear, spin, rotation)
        return body.initial(centre - body.centre, rotation), speed
    place = member.start(body.nodes)
    arm = place - centre
    velocity = np.tile(np.asarray(spec.velocity, dtype=float), (len(arm), 1))
    if body.dimension == 2:
        assert isinstance(spec.angular_velocity, float)
        velocity += spec.angular_velocity * arm[:, ::-1] * (1.0, -1.0)
    else:
        velocity += np.cross(np.asarray(spec.angular_velocity, dtype=float), arm)
    return (place - body.nodes).ravel(), velocity.ravel()
