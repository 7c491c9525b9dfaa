"""How rigid blocks in the plane start: blocks and platform as data, and the arrays of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrangement import Pose
from geometry.block import Block
from solver.law.friction import FrictionLaws
from solver.rigid.plane.model import CORNERS, PlaneModel, PlaneState
from solver.scene import FrictionSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.types import Array, Indices

GROUND = "foundation"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaneBlock:
    """A block and how it starts."""

    name: str = "block"
    on: str = GROUND
    """Name of the block that carries it, or "foundation"."""
    shape: Block
    friction: FrictionSpec
    """On what carries it and on the floor."""
    pose: Pose
    """From its own frame, origin at the bottom centre, to where it stands; the floor is y = 0."""
    velocity: Sequence[float] = (0.0, 0.0)
    """Of the centre, relative to the ground, m/s."""
    angular_velocity: float = 0.0
    """rad/s, clockwise."""
    restitution: float = 0.0
    """e on what carries it and on the floor; 0: it lands without rebound."""

    @property
    def centre(self) -> Array:
        """Where its centre starts, m."""
        return self.pose(np.array([[0.0, self.shape.height / 2]]))[0]

    @property
    def angle(self) -> float:
        """At which it starts, rad, clockwise."""
        return math.atan2(self.pose.rotation[0, 1], self.pose.rotation[0, 0])


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanePlatform:
    """A rigid platform on a horizontal spring and dashpot."""

    mass: float
    """kg."""
    stiffness: float
    """k, N/m."""
    damping: float = 0.0
    """c, N s/m."""
    drift: float = 0.0
    """At the start, m."""


def system_of(
    blocks: Sequence[PlaneBlock],
    platform: PlanePlatform | None,
    gravity: Sequence[float],
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
    carriers = _carriers(blocks)
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
        gravity=np.array(gravity, dtype=np.float64),
        spring=np.array(spring, dtype=np.float64),
        scheme=np.array([scheme.alpha_m, scheme.alpha_f, scheme.beta]),
        velocity_solve=velocity_solve,
        size=max(shape.half_diagonal for shape in shapes),
    )


def _carriers(blocks: Sequence[PlaneBlock]) -> Indices:
    """Number of the block that carries each block, -1: floor or platform."""
    number = {GROUND: -1} | {block.name: b for b, block in enumerate(blocks)}
    return np.array([number[block.on] for block in blocks], dtype=np.int64)


def _points(carriers: Indices) -> Indices:
    """Contact points: block of the corner, corner, block of the face (-1: floor), upper block."""
    pairs = [(b, int(carrier)) for b, carrier in enumerate(carriers)]
    rows = [(b, k, carrier, b) for b, carrier in pairs for k in range(4)]
    for b, carrier in pairs:
        if carrier >= 0:
            rows += [(carrier, k, b, b) for k in range(4)]
            rows += [(b, k, -1, b) for k in range(4)]
    return np.array(rows, dtype=np.int64)


def state_of(blocks: Sequence[PlaneBlock], platform: PlanePlatform | None) -> PlaneState:
    """Where the blocks start, and the platform, whose inertia balances its spring."""
    q = [value for block in blocks for value in (*block.centre, block.angle)]
    v = [value for block in blocks for value in (*block.velocity, block.angular_velocity)]
    if platform is not None:
        q, v = [*q, platform.drift], [*v, 0.0]
    pull = 0.0 if platform is None else platform.stiffness * platform.drift
    return PlaneState(
        q=np.array(q, dtype=np.float64),
        v=np.array(v, dtype=np.float64),
        p=np.array([-pull]),
        slip=np.zeros(len(blocks)),
        exchanged=np.zeros(5),
    )
