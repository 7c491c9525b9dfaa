"""How rigid blocks in the plane start: the arrays of the compiled code."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from solver.law.friction import FrictionLaws
from solver.rigid.plane.model import CORNERS, PlaneModel, PlaneState
from solver.rigid.start import RigidBlock, RigidPlatform, carriers_of
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array, Indices


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
