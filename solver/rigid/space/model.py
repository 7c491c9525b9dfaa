"""What the compiled steps of rigid blocks in space work on: plain arrays with names.

Bodies 0 to n - 1 are the blocks, body n is what stands below all of them: the ground, or a platform
on horizontal springs. It does not turn, and its surface is z = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.law.friction import FrictionLaws, new_pasts
from solver.law.local_problem import new_counts
from solver.rigid.space.rotation import quaternion_of, rotation_of
from solver.rigid.system import RigidBlock, RigidPlatform, carriers_of
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array, Indices, Mask

AWAY = -1
"""Number of the face of a point that is near none."""

ENDS = 8
"""Two ends for each edge of the upper face, where it enters the lower one and where it leaves."""

CORNERS = 16
"""Places for contact points of a pair: first 8 corners of the upper body and 8 of the lower one,"""

SLOTS = CORNERS + ENDS
"""then the ends of the upper face's edges where they cross those of the lower one."""


BEARING = 1e-100
"""Normal force in the memory of a point that has just landed, N: it bears, no force is known."""


class SpaceModel(NamedTuple):
    """What does not change in a run. n blocks, k pairs."""

    mass: Array
    """(n + 1,) kg; 0 for the ground."""
    inertia: Array
    """(n + 1, 3) principal moments about the centre, kg m2."""
    half: Array
    """(n + 1, 3) half of width, thickness and height, m."""
    upper: Indices
    """(k,) upper body of each pair; the first n pairs are the blocks with the ground."""
    lower: Indices
    """(k,) lower body of each pair."""
    carried: Indices
    """(n,) the pair of each block with what carries it."""
    law: FrictionLaws
    """(k,) friction of each pair."""
    restitution: Array
    """(k,) e of each pair; 0: its points land without rebound."""
    spring: Array
    """(2,) stiffness (N/m) and damping (N s/m) of the platform, alike along x and y."""
    gravity: Array
    """(3,) m/s2."""
    scheme: Array
    """alpha_m, alpha_f, beta of the generalized-alpha method."""
    velocity_solve: bool
    """Whether contact is also solved at velocity level."""


class SpaceMemory(NamedTuple):
    """What the places for contact points of k pairs remember from step to step."""

    force: Array
    """(k, SLOTS, 3) contact forces of the last step, normal and two tangential, N."""
    face: Indices
    """(k, SLOTS) number of the face that a point was near in the last step; `AWAY` if none."""
    rest: Array
    """(k, SLOTS) gap that a point is held at, m."""
    past: Array
    """(k, SLOTS, PAST) what a point remembers of its friction (`solver.law.friction.PAST`)."""


class SpaceState(NamedTuple):
    """What a step changes, in place."""

    place: Array
    """(n + 1, 3) centres; of the ground its displacement, m."""
    quaternion: Array
    """(n + 1, 4) rotations."""
    velocity: Array
    """(n + 1, 3) of the centres, m/s."""
    spin: Array
    """(n + 1, 3) angular velocities W in the body, rad/s."""
    inertia_force: Array
    """p, the inertia of the platform against its spring, N, (2,)."""
    memory: SpaceMemory
    """What the contact points remember."""
    slip: Array
    """(n, 2) slip on what carries the block, m."""
    settled: Indices
    """Number of local problems by what settled them (`solver.law.local_problem.OUTCOMES`)."""
    exchanged: Array
    """(5,) work of the ground; dissipated by friction, damping, contact, time integration, J."""


class SpaceContacts(NamedTuple):
    """The m points that may touch within a step, as things stand at its start."""

    pair: Indices
    """(m,)"""
    slot: Indices
    """(m,) place in the pair's memory."""
    body: Indices
    """(m,) whose point it is."""
    base: Indices
    """(m,) whose face it may touch."""
    face: Indices
    """(m,) number of that face."""
    arm: Array
    """(m, 3) place in its body, m."""
    axes: Array
    """(m, 3, 3) rows normal and two tangential, in the body of the face; of a crossing in space."""
    gap: Array
    """(m,) gap counted from `rest`, m."""
    rest: Array
    """(m,) gap at which a point that bore before, or was found sunk in, is held; else 0, m."""
    way: Array
    """(m, 3) of a crossing the direction of the edge in the point's body; 0 for others."""
    foot: Array
    """(m, 3) its place on the other edge, in the body of the face, m."""
    border: Array
    """(m, 3) the direction of that edge, in that body."""


class SpaceSolution(NamedTuple):
    """What a step of length `dt` comes to, before it is taken."""

    settled: bool
    dt: float
    contacts: SpaceContacts
    iterations: int
    moved: Array
    """(n + 1, 3) increments of the centres, m."""
    turned: Array
    """(n + 1, 3) Cayley vectors psi in space."""
    force: Array
    """(m, 3) contact forces in the frames of the faces, N."""
    change: Array
    """(m, 3) changes of gap and place along the face, m."""
    pushed: Array
    """(m, 3) contact forces in space on the point's body, N."""
    mu: Array
    """(m,) coefficients of friction."""
    cohesion: Array
    """(m,) cohesive forces, N."""
    yielded: Array
    """(m, 3) D (f - f_n), what the points gave way beyond the motion of their bodies, m."""
    sliding: Mask
    """(m,) the points that slip."""


def model_of(
    blocks: Sequence[RigidBlock],
    scheme: GeneralizedAlpha,
    gravity: Array,
    platform: RigidPlatform | None,
    velocity_solve: bool,
) -> SpaceModel:
    """The constants of the compiled code."""
    n, base = len(blocks), platform or RigidPlatform(mass=0.0, stiffness=0.0)
    shapes, carriers = [block.shape for block in blocks], carriers_of(blocks)
    carried = np.flatnonzero(carriers >= 0)
    upper = np.append(np.arange(n), carried)
    lower = np.append(np.full(n, n), carriers[carried])
    own = np.arange(n)
    own[carried] = n + np.arange(len(carried))
    nothing = np.zeros(3)
    return SpaceModel(
        mass=np.array([*(shape.mass for shape in shapes), base.mass]),
        inertia=np.array([*(shape.principal_inertias for shape in shapes), nothing]),
        half=np.array([*(shape.half_lengths(3) for shape in shapes), nothing]),
        upper=upper,
        lower=lower,
        carried=own,
        law=FrictionLaws.of([blocks[b].friction for b in upper]),
        restitution=np.array([blocks[b].restitution for b in upper]),
        spring=np.array([base.stiffness, base.damping]),
        gravity=gravity,
        scheme=np.array([scheme.alpha_m, scheme.alpha_f, scheme.beta]),
        velocity_solve=velocity_solve,
    )


def new_memory(pairs: int) -> SpaceMemory:
    """The memory of points that have touched nothing yet."""
    size = pairs, SLOTS
    return SpaceMemory(
        force=np.zeros((*size, 3)),
        face=np.full(size, AWAY, dtype=np.int64),
        rest=np.zeros(size),
        past=new_pasts(*size),
    )


def state_of(
    blocks: Sequence[RigidBlock],
    model: SpaceModel,
    platform: RigidPlatform | None,
) -> SpaceState:
    """Where the blocks start, and the platform, whose inertia balances its spring."""
    n = len(blocks)
    place, velocity, spin = np.zeros((n + 1, 3)), np.zeros((n + 1, 3)), np.zeros((n + 1, 3))
    quaternion = np.zeros((n + 1, 4))
    quaternion[n, 0] = 1.0
    if platform is not None:
        place[n, :2] = platform.drift
    for b, block in enumerate(blocks):
        place[b], velocity[b] = block.centre, block.velocity
        quaternion[b] = quaternion_of(block.pose.rotation)
        spin[b] = rotation_of(quaternion[b]).T @ np.broadcast_to(block.angular_velocity, 3)
    pairs, inertia_force = len(model.upper), -model.spring[0] * place[n, :2]
    return SpaceState(
        place=place,
        quaternion=quaternion,
        velocity=velocity,
        spin=spin,
        inertia_force=inertia_force,
        memory=new_memory(pairs),
        slip=np.zeros((n, 2)),
        settled=new_counts(),
        exchanged=np.zeros(5),
    )
