"""Arrangement of the blocks before they move: offset, tilt, carriers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from geometry.block import Block
from solver.types import Array

Placement = Callable[[Array], Array]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pose:
    """A rigid motion of points, X -> rotation (X - about) + place; call it with points (n, d)."""

    rotation: Array
    """Rotation matrix, (d, d)."""
    about: Array
    """A point of the block in its own frame, (d,), m: the one it stands on or is turned about."""
    place: Array
    """Position of this point, (d,), m, without round-off from the rotation."""

    def __call__(self, points: Array) -> Array:
        """Positions of points (n, d) given in the block's own frame."""
        stand: Array = (points - self.about) @ self.rotation.T + self.place
        return stand

    def after(self, first: Pose) -> Pose:
        """The pose that first does `first`, then this one."""
        return Pose(
            rotation=self.rotation @ first.rotation,
            about=first.about,
            place=self(first.place[None])[0],
        )


def initial_position(
    shape: Block, offset: Sequence[float], tilt: float, azimuth: float = 0.0
) -> Pose:
    """The map from the own frame of a block to where it stands on level 0, (n, d) -> (n, d).

    The own frame has its origin at the bottom centre; `offset` is that of this point before the
    tilt, along x and in space y, m. The block leans towards the azimuth (rad, from +x towards +y;
    in the plane 0) and stands on the edge or corner on that side, |tilt| < pi/2, which stays its
    lowest point. Where it leans straight over an edge, or not at all, the middle of this stays at
    its place.
    """
    if not abs(tilt) < math.pi / 2:
        raise ValueError(f"tilt: got {tilt} rad, allowed -pi/2 < tilt < pi/2")
    d = len(offset) + 1
    corner = np.array(shape.pivot([float(np.sign(tilt) * part) for part in _way(azimuth)[: d - 1]]))
    place = corner + np.array([*offset, 0.0])
    return _raised(shape, Pose(rotation=rotation_of(d, tilt, azimuth), about=corner, place=place))


def _raised(shape: Block, pose: Pose) -> Pose:
    """A pose with no point below level 0: what is no box may reach below the corner it leans on."""
    if shape.solid is None:
        return pose
    lowest = float(pose(shape.solid.corners)[:, -1].min())
    up = np.zeros(len(pose.place))
    up[-1] = max(-lowest, 0.0)
    return Pose(rotation=pose.rotation, about=pose.about, place=pose.place + up)


def rotation_of(d: int, tilt: float, azimuth: float = 0.0) -> Array:
    """Rotation matrix (d, d) of a tilt towards an azimuth, rad, from +x towards +y."""
    a, b = _way(azimuth)
    c, s = math.cos(tilt), math.sin(tilt)
    # Rodrigues' formula for the axis (-b, a, 0).
    found = np.array(
        [
            [c + b * b * (1 - c), -a * b * (1 - c), a * s],
            [-a * b * (1 - c), c + a * a * (1 - c), b * s],
            [-a * s, -b * s, c],
        ]
    )
    return found if d == 3 else found[::2, ::2].copy()


def _way(azimuth: float) -> tuple[float, float]:
    """The direction of an azimuth, exactly along an axis where meant so: cos(pi/2) is 6e-17."""
    along, across = math.cos(azimuth), math.sin(azimuth)
    return 0.0 if abs(along) < 1e-12 else along, 0.0 if abs(across) < 1e-12 else across


def level(place: Array) -> Pose:
    """The frame of a level surface at a place, (d,), m."""
    return Pose(rotation=np.eye(len(place)), about=np.zeros(len(place)), place=place)


def pose_of_top(carrier: Pose, height: float) -> Pose:
    """The frame of the top of a block of a height (m): its origin in the middle, tilted with it.

    `pose_of_top(carrier, height).after(own)` is the pose of a block on it that would stand at `own`
    on a surface at level 0.
    """
    top = np.zeros(len(carrier.place))
    top[-1] = height
    return carrier.after(level(top))


def middle_of(tops: Sequence[Pose]) -> Pose:
    """The frame of several tops that are level: turned as the first, its origin in their middle."""
    place = np.mean([top.place for top in tops], axis=0)
    return Pose(rotation=tops[0].rotation, about=tops[0].about, place=place)
