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

    @property
    def translation(self) -> Array:
        """Position of the origin of the own frame, (d,), m: X -> rotation X + translation."""
        origin: Array = self.place - self.rotation @ self.about
        return origin

    def after(self, first: Pose) -> Pose:
        """The pose that first does `first`, then this one."""
        return Pose(
            rotation=self.rotation @ first.rotation,
            about=first.about,
            place=self(first.place[None])[0],
        )


def initial_position(shape: Block, offset: float, tilt: float) -> Pose:
    """The map from the block's own frame to where it stands on the surface y = 0, (n, 2) -> (n, 2).

    The own frame has its origin at the bottom centre. `offset` is that of this point along x before
    the tilt, m; `tilt` turns about the bottom corner on that side, rad, positive clockwise; |tilt|
    < pi/2, so that this corner stays the lowest point and touches y = 0.
    """
    _refuse_lying(tilt)
    corner = np.array(shape.pivot([float(np.sign(tilt))]))
    place = corner + np.array([offset, 0.0])
    return _raised(shape, Pose(rotation=rotation_in_plane(tilt), about=corner, place=place))


def rotation_in_plane(tilt: float) -> Array:
    """Rotation matrix (2, 2) of a tilt, rad, positive clockwise: towards +x."""
    c, s = math.cos(tilt), math.sin(tilt)
    return np.array([[c, s], [-s, c]])


def initial_position_in_space(
    shape: Block, offset: tuple[float, float], tilt: float, azimuth: float = 0.0
) -> Pose:
    """The map from the own frame of a block in space to where it stands on z = 0, (n, 3) -> (n, 3).

    The own frame has its origin at the bottom centre; `offset` is that of this point along x and y
    before the tilt, m. The block leans towards the azimuth (rad, from +x towards +y; 0 is a
    rotation about +y) and stands on the edge or corner on that side, |tilt| < pi/2. Where it leans
    straight over an edge, or not at all, the middle of this stays at its place.
    """
    _refuse_lying(tilt)
    towards = np.array([math.cos(azimuth), math.sin(azimuth)])
    towards = np.sign(tilt) * np.where(np.abs(towards) < 1e-12, 0.0, towards)
    corner = np.array(shape.pivot([float(part) for part in towards]))
    place = corner + np.array([*offset, 0.0])
    pose = Pose(rotation=rotation_in_space(tilt, azimuth), about=corner, place=place)
    return _raised(shape, pose)


def _raised(shape: Block, pose: Pose) -> Pose:
    """A pose with no point below level 0: what is no box may reach below the corner it leans on."""
    if shape.solid is None:
        return pose
    lowest = float(pose(shape.solid.corners)[:, -1].min())
    up = np.zeros(len(pose.place))
    up[-1] = max(-lowest, 0.0)
    return Pose(rotation=pose.rotation, about=pose.about, place=pose.place + up)


def rotation_in_space(tilt: float, azimuth: float) -> Array:
    """Rotation matrix (3, 3) of a tilt towards an azimuth, rad, from +x towards +y."""
    # Exactly along the axes where meant so: cos(pi/2) is 6e-17.
    a, b = (0.0 if abs(part) < 1e-12 else part for part in (math.cos(azimuth), math.sin(azimuth)))
    c, s = math.cos(tilt), math.sin(tilt)
    # Rodrigues' formula for the axis (-b, a, 0).
    return np.array(
        [
            [c + b * b * (1 - c), -a * b * (1 - c), a * s],
            [-a * b * (1 - c), c + a * a * (1 - c), b * s],
            [-a * s, -b * s, c],
        ]
    )


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


def _refuse_lying(tilt: float) -> None:
    """The corner a block stands on must stay its lowest point."""
    if not abs(tilt) < math.pi / 2:
        raise ValueError(f"tilt: got {tilt} rad, allowed -pi/2 < tilt < pi/2")
