"""Motion of a block from its columns of the history, in the plane and in space alike.

In space everything is told in the one upright plane in which the block leans most: its signed lean
there is the angle of two dimensions, and the width of its base across that plane is the width.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from geometry.block import Block
from geometry.boxes import Boxes
from solver.history.block_columns import STEEPEST_TOP
from solver.history.history import History
from solver.scene import BlockSpec, Scene
from solver.types import Array, Mask

#: The upright direction in space.
UP = np.array([0.0, 0.0, 1.0])


ACCELERATIONS = (
    ("base.acceleration_m_s2", "platform.acceleration_m_s2"),
    ("base.second_acceleration_m_s2", "platform.acceleration_second_m_s2"),
)
"""Columns that add up to the acceleration of what carries blocks, along x and along y."""


class Columns(Protocol):
    """Rows of a history by the names of their columns: all of them, or some as they come."""

    def __contains__(self, column: object) -> bool:
        """Whether there is a column of that name."""

    def __getitem__(self, column: str) -> Array:
        """One column, over the rows."""


class Leaning(NamedTuple):
    """How a block leans in one upright plane.

    Attributes:
        angle: Lean in that plane, rad, with its sign (towards +x, or +y where that plane has no x),
            unwrapped, (rows,).
        shape: The block as it stands in that plane.
        direction: Horizontal unit vector of the plane, (1,) or, in 3-D, (2,).
        aside: Lean out of the plane, rad; 0 in 2-D.
    """

    angle: Array
    shape: Block
    direction: Array
    aside: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockMotion:
    """Motion of one block over a run."""

    time: Array
    """t, s."""
    angle: Array
    """Lean against what carries the block, in the plane of the largest one, rad, with its sign
    (towards +x, or +y where that plane has no x), unwrapped."""
    lean: Array
    """Angle from upright, rad; signed and unwrapped in 2-D, 0 to pi in 3-D."""
    slip: Array
    """Along what carries the block, m, (rows, 1) or, in 3-D, (rows, 2)."""
    friction: Array
    """Force from what carries the block, N, (rows, 1 or 2)."""
    lift: Array
    """Gap of the bottom corner that is highest, m."""
    low: Array
    """That of the one that is lowest, m."""
    shape: Block
    """The block as it stands in that plane."""
    fell: bool
    """Whether it ends below what carried it."""
    aside: Array
    """Lean out of that plane, rad; 0 in 2-D."""
    base: Array | None
    """Acceleration of the ground, or of the platform, less that of gravity, in that plane, m/s2:
    along it, and upwards, (rows, 2); None where neither moves and the ground is level."""


def block_motion(scene: Scene, history: History, block: BlockSpec) -> BlockMotion:
    """The motion of a block as its columns give it."""
    name, carrier = block.name, scene.carrier_of(block)
    leans = leaning(history, block, carrier)
    if is_spatial(history, name):
        gaps, second = [f"gap_{corner}_m" for corner in (1, 2, 3, 4)], ["", "_second"]
    else:
        gaps, second = ["gap_left_m", "gap_right_m"], [""]
    gap = _stack(history, name, gaps)
    return BlockMotion(
        time=history["time_s"],
        angle=leans.angle,
        lean=total_lean(history, name),
        slip=_stack(history, name, [f"slip{direction}_m" for direction in second]),
        friction=_stack(history, name, [f"friction_force{direction}_N" for direction in second]),
        lift=gap.max(axis=1),
        low=gap.min(axis=1),
        shape=leans.shape,
        fell=_fell(history, block, carrier),
        aside=leans.aside,
        base=_base(scene, history, leans.direction),
    )


def leaning(history: History, block: BlockSpec, carrier: BlockSpec | None = None) -> Leaning:
    """How a block leans most: against its carrier, or from upright where none is given."""
    if is_spatial(history, block.name):
        return _leaning_in_space(history, block, carrier)
    angle = history[f"{block.name}.angle_rad"]
    if carrier is not None:
        angle = angle - history[f"{carrier.name}.angle_rad"]
    return Leaning(angle, block.shape, np.array([1.0]), np.zeros_like(angle))


def angular_velocity(history: Columns, name: str, direction: Array) -> Array:
    """Angular velocity of a block with which it leans towards a horizontal direction, rad/s."""
    if not is_spatial(history, name):
        return history[f"{name}.angular_velocity_rad_s"]
    x, y = direction
    about_x, about_y = (history[f"{name}.angular_velocity_{axis}_rad_s"] for axis in "xy")
    return np.asarray(x * about_y - y * about_x)


def is_spatial(history: Columns, name: str) -> bool:
    """True if a block's columns are those of three dimensions."""
    return f"{name}.angle_x_rad" in history


def centres(history: Columns, name: str) -> Array:
    """Places of a block's centre of mass, m, (rows, d)."""
    axes = "xyz" if is_spatial(history, name) else "xy"
    return _stack(history, name, [f"centre_{axis}_m" for axis in axes])


def lost_carrier(history: Columns, block: BlockSpec, carrier: BlockSpec) -> Mask:
    """In which rows a block has lost the one that carried it, by `has_lost_carrier`."""
    below = boxes(history, carrier)
    up = below.frames[:, :, -1]
    height = np.sum((centres(history, block.name) - below.centres) * up, axis=1)
    return np.asarray((up[:, -1] <= STEEPEST_TOP) | (height <= carrier.height / 2))


def total_lean(history: Columns, name: str) -> Array:
    """Angle of a block from upright, rad: signed and unwrapped in 2-D, 0 to pi in 3-D."""
    if not is_spatial(history, name):
        return history[f"{name}.angle_rad"]
    return _angle_from_up(_axes(history, name))


def slenderness(history: Columns, block: BlockSpec) -> Array:
    """Slenderness alpha of a block in the direction in which it leans, over the rows, rad."""
    shape = block.shape
    if not is_spatial(history, block.name):
        return np.full(len(history["time_s"]), shape.slenderness)
    # The upright direction as the block sees it.
    across = np.abs(boxes(history, block).frames[:, 2, :2])
    length = np.hypot(across[:, 0], across[:, 1])
    width = across @ [shape.width, shape.thickness]
    straight = length == 0
    width = np.where(straight, shape.width, width / np.where(straight, 1.0, length))
    return np.arctan2(width, shape.height)


def lean_over_alpha(history: Columns, block: BlockSpec) -> Array:
    """|theta|/alpha of a block, over the rows: its lean over alpha in the direction of the lean."""
    return np.abs(total_lean(history, block.name)) / slenderness(history, block)


def boxes(history: Columns, block: BlockSpec) -> Boxes:
    """A block as a rigid box, over the rows."""
    name = block.name
    if is_spatial(history, name):
        turns = _rotations(history, name)
        axes = [rotated(turns, axis) for axis in np.eye(3)]
    else:
        angle = history[f"{name}.angle_rad"]
        cosine, sine = np.cos(angle), np.sin(angle)
        axes = [np.stack([cosine, -sine], axis=1), np.stack([sine, cosine], axis=1)]
    half = np.array(block.shape.half_lengths(len(axes)))
    return Boxes(half=half, centres=centres(history, name), frames=np.stack(axes, axis=2))


def rotated(rotations: Array, vectors: Array) -> Array:
    """Vectors (..., 3) turned by rotation vectors (n, 3), rad (formula of Rodrigues)."""
    angle = np.linalg.norm(rotations, axis=1, keepdims=True)
    axis = np.divide(rotations, angle, out=np.zeros_like(rotations), where=angle > 0)
    along = np.sum(axis * vectors, axis=1, keepdims=True) * axis
    across = np.cross(axis, vectors)
    return along + np.cos(angle) * (vectors - along) + np.sin(angle) * across


def _stack(history: Columns, name: str, columns: list[str]) -> Array:
    """Some columns of a block side by side, (rows, columns)."""
    return np.stack([history[f"{name}.{column}"] for column in columns], axis=1)


def _rotations(history: Columns, name: str) -> Array:
    """Rotation vectors of a block in space, rad, (rows, 3)."""
    return _stack(history, name, [f"angle_{axis}_rad" for axis in "xyz"])


def _axes(history: Columns, name: str) -> Array:
    """Direction of a block's upright axis, (rows, 3)."""
    return rotated(_rotations(history, name), UP)


def _angle_from_up(axes: Array) -> Array:
    """Angle of unit vectors from upright, rad, 0 to pi; exact for small ones, too."""
    return np.arctan2(np.linalg.norm(axes[:, :2], axis=1), axes[:, 2])


def _base(scene: Scene, history: History, direction: Array) -> Array | None:
    """What `BlockMotion.base` says, along a horizontal direction."""
    if not (scene.motion or scene.carrier_moves or scene.gravity_tilt_deg):
        return None
    found = np.zeros((len(history["time_s"]), 2))
    for part, columns in zip(direction, ACCELERATIONS, strict=False):
        for column in columns:
            if column in history:
                found[:, 0] += part * history[column]
    if "base.vertical_acceleration_m_s2" in history:
        found[:, 1] = history["base.vertical_acceleration_m_s2"]
    gravity = scene.gravity_vector
    return found - np.array([direction[0] * gravity[0], gravity[-1]])


def _leaning_in_space(history: History, block: BlockSpec, carrier: BlockSpec | None) -> Leaning:
    """How a block in space leans against its carrier, or from upright."""
    rotations = _rotations(history, block.name)
    axes = rotated(rotations, UP)
    # The carrier's upright axis as the block sees it tells where the block leans, in its own frame.
    below = np.broadcast_to(UP, axes.shape)
    if carrier is not None:
        below = _axes(history, carrier.name)
        axes = rotated(-_rotations(history, carrier.name), axes)
    most = int(np.argmax(_angle_from_up(axes)))
    own = -rotated(-rotations, below)[most, :2]
    direction = _towards(axes[most, :2])
    angle = np.unwrap(np.arctan2(axes[:, :2] @ direction, axes[:, 2]))
    across = axes[:, 0] * direction[1] - axes[:, 1] * direction[0]
    aside = np.abs(np.arcsin(np.clip(across, -1.0, 1.0)))
    return Leaning(angle, _shape_across(block.shape, _towards(own)), direction, aside)


def _towards(horizontal: Array) -> Array:
    """The unit vector along a horizontal one that points to +x, or to +y where it has no x."""
    length = float(np.linalg.norm(horizontal))
    if length == 0:
        return np.array([1.0, 0.0])
    unit = horizontal / length
    backwards = unit[0] < -1e-9 or (abs(unit[0]) <= 1e-9 and unit[1] < 0)
    return np.asarray(-unit if backwards else unit)


def _shape_across(shape: Block, direction: Array) -> Block:
    """The block as one that leans in a direction of its base: as wide as the base is along it."""
    width = float(np.abs(direction) @ [shape.width, shape.thickness])
    area = shape.width * shape.thickness
    return Block(width=width, height=shape.height, thickness=area / width, density=shape.density)


def _fell(history: History, block: BlockSpec, carrier: BlockSpec | None) -> bool:
    """True if the centre of a block ends below the surface that it stood on.

    That of the foundation is at level 0. That of a block is its top; a block that lies beside an
    overturned carrier is above the plane of that top, but not above its centre.
    """
    centre = centres(history, block.name)[-1]
    if carrier is None:
        return bool(centre[-1] < 0)
    above = centre - centres(history, carrier.name)[-1]
    if is_spatial(history, carrier.name):
        normal = _axes(history, carrier.name)[-1]
    else:
        angle = history[f"{carrier.name}.angle_rad"][-1]
        normal = np.array([np.sin(angle), np.cos(angle)])
    return bool(above @ normal < carrier.height / 2 or above[-1] < 0)
