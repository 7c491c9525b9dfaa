"""How rigid blocks in space start: the arrays of the compiled code."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.law.friction import FrictionLaws, new_pasts
from solver.law.local_problem import new_counts
from solver.rigid.space.boxes import SLOTS
from solver.rigid.space.model import AWAY, SpaceMemory, SpaceModel, SpaceState
from solver.rigid.space.rotation import quaternion_of, rotation_of
from solver.rigid.start import RigidBlock, RigidPlatform, carriers_of
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array


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
