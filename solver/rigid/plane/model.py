"""Arrays that the compiled code of the plane works on: the system, its state, its memory.

Unknowns q: x, y of the centre and the angle (clockwise) of each block, then the drift of the
platform if there is one. Masses, forces and energies are those of the whole thickness.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.law.friction import FrictionLaws, new_pasts
from solver.law.local_problem import new_counts
from solver.rigid.system import RigidBlock, RigidPlatform, carriers_of
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array, Indices

#: Corners of a block in its own frame, in units of half width and half height: anticlockwise from
#: the left bottom one.
CORNERS = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))


class PlaneModel(NamedTuple):
    """What stays the same during a run."""

    mass: Array
    """m, m, I of each block (kg, kg m2), then the platform's mass, (n,)."""
    flexibility: Array
    """1/mass, (n,)."""
    mass_x: Array
    """The mass that moves along x with each unknown, kg, (n,)."""
    mass_y: Array
    """Along y."""
    half: Array
    """B/2, H/2 of each block, m, (b, 2)."""
    thickness: Array
    """t of each block, m, (b,)."""
    carrier: Indices
    """Block that carries each block, -1: floor or platform, (b,)."""
    friction: FrictionLaws
    """Friction of each block on what carries it, (b,)."""
    restitution: Array
    """e of each block on what carries it; 0: it lands without rebound, (b,)."""
    corner_of: Indices
    """Block whose corner each contact point is, (p,); points 4 b to 4 b + 3 are the corners of
    block b over what carries it."""
    corner: Array
    """Position of each contact point in the frame of the block whose corner it is, m, (p, 2)."""
    face_of: Indices
    """Block whose faces it may touch, -1: floor or platform, (p,)."""
    upper: Indices
    """Which of the two the other one carries, (p,)."""
    gravity: Array
    """Acceleration of gravity, m/s2, (2,)."""
    spring: Array
    """Stiffness (N/m) and damping (N s/m) of the platform, (2,)."""
    scheme: Array
    """alpha_m, alpha_f, beta of the time stepping, (3,)."""
    velocity_solve: bool
    """Whether contact is also solved at velocity level after each step."""
    size: float
    """Largest half diagonal, m: what lengths are small against."""


class PlaneGround(NamedTuple):
    """Acceleration of the ground, linear in time from the start of a step on."""

    x: float
    """At the start, m/s2."""
    y: float
    rise_x: float
    """How it grows, m/s3."""
    rise_y: float


class PlaneState(NamedTuple):
    """What moves, changed in place."""

    q: Array
    """Place of each unknown, m, rad, (n,)."""
    v: Array
    """Velocity, m/s, rad/s, (n,)."""
    p: Array
    """Inertia force of the platform against its spring, N, (1,)."""
    slip: Array
    """Slip of each block on what carries it, m, (b,)."""
    exchanged: Array
    """Energy taken in; lost in friction, damping, contact, time stepping, J, (5,)."""


class PlaneMemory(NamedTuple):
    """What each contact point remembers from step to step, (p,)."""

    closed: Indices
    """1 where it carried a force in the last step."""
    face: Indices
    """Face that it touches: 0 bottom, 1 right, 2 top, 3 left."""
    gap: Array
    """Gap of closed points, m, summed up from increments: their digits are those of the step."""
    offset: Array
    """Tangential place minus that where the point sticks, m."""
    past: Array
    """What it remembers of its friction (`solver.law.friction.PAST`), (p, PAST)."""
    state: Indices
    """Its state in the last local problem."""
    force: Array
    """f_n, f_t of the last step, N, (p, 2)."""


class PlaneWork(NamedTuple):
    """The step that is being solved; its first `counts[0]` points are near a face."""

    counts: Indices
    """Number of points near a face; of iterations; of local problems by what came
    of them (`OUTCOMES`), (2 + outcomes,)."""
    points: Indices
    """Which points they are, (p,)."""
    face: Indices
    """Face of each, (p,)."""
    gap: Array
    """Gap at the start of the step, m, (p,)."""
    offset: Array
    """Tangential place minus anchor at the start of the step, m, (p,)."""
    friction: Array
    """mu of each, (p,)."""
    cohesion: Array
    """Cohesion times area of each, N, (p,)."""
    state: Indices
    """State of each in the local problem, (p,)."""
    slips: Indices
    """1 where it slips in this step, (p,)."""
    rows: Array
    """Rows of gap and tangential place, (2 p, n)."""
    force: Array
    """Point forces, flat, N, (2 p,)."""
    place: Array
    """y of the points at the end of the step, flat, m, (2 p,)."""
    fixed: Array
    """y of the points without contact forces, flat, m, (2 p,)."""
    moved: Array
    """Changes of gap and tangential place in the step, flat, m, (2 p,)."""
    increment: Array
    """Increment of q, (n,)."""
    tried: Array
    """The increment of the iteration that is under way, (n,)."""
    free: Array
    """Increment of q without contact forces, (n,)."""
    flexibility: Array
    """What forces add to it: w_c/M_eff of each unknown, m/N or rad/(N m), (n,)."""
    inertia: Array
    """p at the end of the step, N, (1,)."""
    impulse: Array
    """Impulse of contact on each block so far in the full step, N s, (b, 2)."""
    pushed: Array
    """Impulse of the platform on the ground so far in the full step, N s, (1,)."""


def new_memory(points: int) -> PlaneMemory:
    """The memory of points that have touched nothing yet."""
    none = [np.zeros(points, dtype=np.int64) for _ in range(3)]
    return PlaneMemory(
        closed=none[0],
        face=none[1],
        gap=np.zeros(points),
        offset=np.zeros(points),
        past=new_pasts(points),
        state=none[2],
        force=np.zeros((points, 2)),
    )


def new_work(points: int, unknowns: int, blocks: int) -> PlaneWork:
    """Room for the steps of a system."""
    return PlaneWork(
        counts=np.append([0, 0], new_counts()),
        points=np.zeros(points, dtype=np.int64),
        face=np.zeros(points, dtype=np.int64),
        gap=np.zeros(points),
        offset=np.zeros(points),
        friction=np.zeros(points),
        cohesion=np.zeros(points),
        state=np.zeros(points, dtype=np.int64),
        slips=np.zeros(points, dtype=np.int64),
        rows=np.zeros((2 * points, unknowns)),
        force=np.zeros(2 * points),
        place=np.zeros(2 * points),
        fixed=np.zeros(2 * points),
        moved=np.zeros(2 * points),
        increment=np.zeros(unknowns),
        tried=np.zeros(unknowns),
        free=np.zeros(unknowns),
        flexibility=np.zeros(unknowns),
        inertia=np.zeros(1),
        impulse=np.zeros((blocks, 2)),
        pushed=np.zeros(1),
    )


def system_of(
    blocks: Sequence[RigidBlock],
    platform: RigidPlatform | None,
    gravity: Array,
    scheme: GeneralizedAlpha,
    velocity_solve: bool,
) -> PlaneModel:
    """The constants of the compiled code."""
    shapes = [block.shape for block in blocks]
    mass = np.array([m for s in shapes for m in (s.mass, s.mass, s.rotary_inertia)])
    if platform is not None:
        mass = np.append(mass, platform.mass)
    axis = np.arange(len(mass)) % 3
    half = np.array([(shape.width / 2, shape.height / 2) for shape in shapes])
    carriers = carriers_of(blocks)
    points = _points(carriers)
    spring = (0.0, 0.0) if platform is None else (platform.stiffness, platform.damping)
    return PlaneModel(
        mass=mass,
        flexibility=np.reciprocal(mass),
        mass_x=np.where(axis == 0, mass, 0.0),  # the platform's number is a multiple of three, too
        mass_y=np.where(axis == 1, mass, 0.0),
        half=half,
        thickness=np.array([shape.thickness for shape in shapes]),
        carrier=carriers,
        friction=FrictionLaws.of([block.friction for block in blocks]),
        restitution=np.array([block.restitution for block in blocks]),
        corner_of=points[:, 0].copy(),
        corner=np.array(CORNERS)[points[:, 1]] * half[points[:, 0]],
        face_of=points[:, 2].copy(),
        upper=points[:, 3].copy(),
        gravity=gravity,
        spring=np.array(spring, dtype=np.float64),
        scheme=np.array([scheme.alpha_m, scheme.alpha_f, scheme.beta]),
        velocity_solve=velocity_solve,
        size=max(shape.half_diagonal for shape in shapes),
    )


def _points(carriers: Indices) -> Indices:
    """Contact points: block of the corner, corner, block of the face (-1: floor), upper block."""
    pairs = [(b, int(carrier)) for b, carrier in enumerate(carriers)]
    rows = [(b, k, carrier, b) for b, carrier in pairs for k in range(4)]
    for b, carrier in pairs:
        if carrier >= 0:
            rows += [(carrier, k, b, b) for k in range(4)]
            rows += [(b, k, -1, b) for k in range(4)]
    return np.array(rows, dtype=np.int64)


def state_of(blocks: Sequence[RigidBlock], platform: RigidPlatform | None) -> PlaneState:
    """Where the blocks start, and the platform, whose inertia balances its spring."""
    q, v = np.zeros((2, 3 * len(blocks) + (platform is not None)))
    for b, block in enumerate(blocks):
        turn, own = block.pose.rotation, slice(3 * b, 3 * b + 3)
        q[own] = *block.centre, math.atan2(turn[0, 1], turn[0, 0])
        v[own] = *np.broadcast_to(block.velocity, 2), block.angular_velocity
    pull = 0.0
    if platform is not None:
        q[-1], pull = platform.drift[0], platform.stiffness * platform.drift[0]
    return PlaneState(
        q=q,
        v=v,
        p=np.array([-pull]),
        slip=np.zeros(len(blocks)),
        exchanged=np.zeros(5),
    )
