"""Motion of a block from its columns of the history, and its mode, in the plane and in space.

In space everything is given in the one upright plane in which the block leans most: its signed lean
there is the angle of two dimensions, and the width of its base across that plane is the width.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from geometry.block import Block
from geometry.boxes import Boxes
from geometry.outline import limits_towards, rolls
from geometry.top import top_over_centre
from solver.history.block_columns import has_lost_carrier
from solver.results.rocking import SMALLEST_SWING, no_return
from solver.scene import BlockSpec, Scene
from solver.types import Array, Indices, Mask

#: The upright direction in space.
UP = np.array([0.0, 0.0, 1.0])

SMALLEST_WAY = 1e-2
"""A block has slid, turned or hopped beyond this part of its width; pivots skid by less at impacts,
and elastic blocks hop on them by less (the paper's block by 8e-4)."""

CLEAR = 1e-6
"""Gap of its lowest bottom corner over its width from which on a block is clear of its carrier."""


SMALLEST_LIFT = 2e-4
"""A block rocks when a corner is lifted by more than this part of its width, in a swing."""

NEAR_BALANCE = 0.9
"""A shape that is no box leans by less than this part of its slenderness without being near to any
balance: feet of different heights stand on corners that are some thousandths off."""

DIRECTIONS = 3600
"""Horizontal directions in which such a shape leans in space, all the way round."""

ACCELERATIONS = (
    ("base.acceleration_m_s2", "platform.acceleration_m_s2"),
    ("base.second_acceleration_m_s2", "platform.acceleration_second_m_s2"),
)
"""Columns that add up to the acceleration of what carries blocks, along x and along y."""


class Columns(Protocol):
    """Rows of a history by the names of their columns: all of them, or some as they come."""

    def __contains__(self, column: object) -> bool:
        """True if there is a column of that name."""

    def __getitem__(self, column: str) -> Array:
        """One column, over the rows."""


class Tipping(NamedTuple):
    """`geometry.outline.Limits` of a block in the direction in which it leans, (rows,) each, rad.

    Where a shape that is no box leans so little that it is near to none, they are infinite.
    """

    next_face: Array
    balance: Array
    no_return: Array


class Leaning(NamedTuple):
    """Lean of a block in one upright plane.

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


class BlockMotion:
    """Motion of one block over rows of a run; its parts are computed when they are first read."""

    def __init__(self, scene: Scene, rows: Columns, block: BlockSpec):
        """The block leans against what carries it, in the plane of the largest such lean."""
        self._scene, self._rows, self._block = scene, rows, block
        self._name, self._carrier = block.name, scene.carrier_of(block)
        self._ways = ("", "_second") if is_spatial(rows, block.name) else ("",)
        self.time = rows["time_s"]
        """t, s."""
        self.normal = rows[f"{block.name}.normal_force_N"]
        """Normal force from what carries the block, N."""
        self.angle, self.shape, self.direction, self.aside = leaning(rows, block, self._carrier)
        """As in `Leaning`."""

    @cached_property
    def lean(self) -> Array:
        """Angle from upright, rad; signed and unwrapped in 2-D, 0 to pi in 3-D."""
        return total_lean(self._rows, self._name)

    @cached_property
    def displacement(self) -> Array:
        """Displacement of its base along what carries it, m, (rows, 1) or, in 3-D, (rows, 2)."""
        return _stack(self._rows, self._name, [f"slip{way}_m" for way in self._ways])

    @cached_property
    def flies(self) -> Mask:
        """True where it is in free flight that counts as a hop, (rows,)."""
        return flights(self.normal, self.low, self.displacement, self._block.width)

    @cached_property
    def slip(self) -> Array:
        """The part of its displacement which it moved in contact, not in flight, m."""
        steps = np.diff(self.displacement, axis=0, prepend=self.displacement[:1])
        flown = np.cumsum(np.where(self.flies[:, None], steps, 0.0), axis=0)
        return np.asarray(self.displacement - flown)

    @cached_property
    def turn(self) -> Array:
        """Angle about the upright axis of what carries the block, rad, unwrapped; 0 in 2-D."""
        return _turn(self._rows, self._block, self._carrier)

    @cached_property
    def friction(self) -> Array:
        """Force from what carries the block, N, (rows, 1 or 2)."""
        return _stack(self._rows, self._name, [f"friction_force{way}_N" for way in self._ways])

    @cached_property
    def gaps(self) -> Array:
        """Gaps of its bottom corners, m, (rows, corners)."""
        return gaps_of(self._rows, self._name)

    @cached_property
    def low(self) -> Array:
        """Gap of its lowest corner, m."""
        return lowest_gap(self._rows, self._block, self._carrier)

    @property
    def fell(self) -> bool:
        """True if it ends below what carried it."""
        return _fell(self._rows, self._block, self._scene.carriers_of(self._block))

    @cached_property
    def tipping(self) -> Tipping:
        """How far it leans without rolling on and without overturning, in the direction of that."""
        return tipping(self._rows, self._block)

    @property
    def overturned(self) -> bool:
        """True if it ends beyond its balance, or has been where it does not come back from."""
        lean = np.abs(self.lean)
        return bool(lean[-1] > self.tipping.balance[-1] or np.any(lean > self.tipping.no_return))


def of_side(number: Callable[[int], float], lean: Array) -> Array:
    """A number of a block about the edge to which it leans, by the sign of that, over the rows."""
    return np.where(lean < 0, number(-1), number(1))


def mode(block: Block, motion: BlockMotion, *, fell: bool = False) -> str:
    """Mode of a block: "fell", "overturned", or all of what it did otherwise.

    That is "slide", "turn", "rock" or "roll", and "hop", joined by hyphens in that order, as in
    "slide-rock"; "rest" where it did none. A block that rolls to another face does not rock.

    Args:
        block: Its shape.
        motion: What it did.
        fell: True if it left what carried it, besides where `motion` says so.
    """
    if fell or motion.fell:
        return "fell"
    shape = motion.shape
    if motion.overturned:
        return "overturned"
    swinging = np.abs(motion.angle) > SMALLEST_SWING * shape.slenderness()
    lifted = motion.gaps.max(axis=1) > SMALLEST_LIFT * shape.width
    round_corners = np.abs(motion.turn) * math.hypot(block.width, block.thickness) / 2
    rolls = np.abs(motion.lean) > motion.tipping.next_face
    found = {
        "slide": np.linalg.norm(motion.slip, axis=1) > SMALLEST_WAY * shape.width,
        "turn": round_corners > SMALLEST_WAY * block.width,
        "rock": swinging & lifted & (not rolls.any()),
        "roll": rolls,
        "hop": motion.flies,
    }
    return "-".join(word for word, rows in found.items() if np.any(rows)) or "rest"


def leaning(history: Columns, block: BlockSpec, carrier: BlockSpec | None = None) -> Leaning:
    """Largest lean of a block: against its carrier, or from upright where none is given.

    What rolls turns below others, which do not lean by that.
    """
    if is_spatial(history, block.name):
        return _leaning_in_space(history, block, carrier)
    angle = history[f"{block.name}.angle_rad"]
    if carrier is not None and not rolls(carrier.shape, 2):
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


def gaps_of(history: Columns, name: str) -> Array:
    """Gaps of the bottom corners of a block, m, (rows, corners)."""
    names = (1, 2, 3, 4) if is_spatial(history, name) else ("left", "right")
    return _stack(history, name, [f"gap_{corner}_m" for corner in names])


def lost_carrier(history: Columns, block: BlockSpec, carrier: BlockSpec) -> Mask:
    """In which rows a block has lost the one that carried it, by `has_lost_carrier`."""
    up = top_axes(history, carrier)[:, :, -1]
    shift = centres(history, block.name) - centres(history, carrier.name)
    top = top_over_centre(carrier.shape, up.shape[1])
    return np.asarray(has_lost_carrier(up[:, -1], np.sum(shift * up, axis=1), top))


def top_axes(history: Columns, carrier: BlockSpec) -> Array:
    """Axes of the top of a block as columns, (rows, d, d): level ones of what rolls."""
    frames = boxes(history, carrier).frames
    d = frames.shape[1]
    return np.broadcast_to(np.eye(d), frames.shape) if rolls(carrier.shape, d) else frames


def platform_drift(history: Columns, dimension: int) -> Array:
    """Displacement of the foundation, (rows, d), m; 0 where it is the ground."""
    drift = np.zeros((len(history["time_s"]), dimension))
    for axis, way in enumerate(("", "_second")[: dimension - 1]):
        if f"platform.drift{way}_m" in history:
            drift[:, axis] = history[f"platform.drift{way}_m"]
    return drift


def total_lean(history: Columns, name: str) -> Array:
    """Angle of a block from upright, rad: signed and unwrapped in 2-D, 0 to pi in 3-D."""
    if not is_spatial(history, name):
        return history[f"{name}.angle_rad"]
    return _angle_from_up(upright_axes(history, name))


def slenderness(history: Columns, block: BlockSpec) -> Array:
    """Slenderness alpha of a block in the direction in which it leans, over the rows, rad."""
    shape = block.shape
    if not is_spatial(history, block.name):
        return of_side(shape.slenderness, history[f"{block.name}.angle_rad"])
    # The upright direction in the block's own frame: it leans away from there, towards the place of
    # its bottom that is farthest that way.
    upright = boxes(history, block).frames[:, 2, :2]
    length = np.linalg.norm(upright, axis=1)
    straight = length == 0
    towards = -upright / np.where(straight, 1.0, length)[:, None]
    places = (np.array(shape.standing_corners()) - shape.centre_of_mass(3))[:, :2]
    far = np.where(straight, shape.arm(), (towards @ places.T).max(axis=1))
    return np.arctan2(far, shape.centre_height)


def tipping(history: Columns, block: BlockSpec) -> Tipping:
    """How far a block leans without rolling on and without overturning, over the rows."""
    alpha, signed = slenderness(history, block), total_lean(history, block.name)
    if block.shape.solid is None:
        return Tipping(np.full_like(alpha, math.inf), alpha, no_return(alpha))
    found: Array = np.full((3, len(alpha)), math.inf)
    ways: dict[float, tuple[float, ...]]
    rows = np.flatnonzero(np.abs(signed) > NEAR_BALANCE * alpha)
    if is_spatial(history, block.name):
        # It leans away from the upright direction in its own frame.
        towards = -boxes(history, block).frames[rows, 2, :2]
        step = 2 * math.pi / DIRECTIONS
        angles = np.arctan2(towards[:, 1], towards[:, 0])
        keys = np.round(angles / step) % DIRECTIONS
        ways = {key: (math.cos(key * step), math.sin(key * step)) for key in np.unique(keys)}
    else:
        keys = np.where(signed[rows] < 0, -1.0, 1.0)
        ways = {key: (float(key),) for key in np.unique(keys)}
    for key, way in ways.items():
        found[:, rows[keys == key]] = np.array(limits_towards(block.shape, way))[:, None]
    return Tipping(*found)


def lowest_gap(history: Columns, block: BlockSpec, carrier: BlockSpec | None) -> Array:
    """Gap between a block and the plane on which it stands, m, (rows,): of its lowest corner.

    That is one of its bottom, unless it is no box and near to a balance, or beyond it.
    """
    gaps, shape = gaps_of(history, block.name), block.shape
    low = gaps.min(axis=1)
    if shape.solid is None:
        return low
    lean = np.abs(total_lean(history, block.name))
    rows = np.flatnonzero(lean > NEAR_BALANCE * slenderness(history, block))
    if not len(rows):
        return low
    d = len(boxes(history, block).half)
    up: Array = np.broadcast_to(np.eye(d)[-1], (len(rows), d))
    if carrier is not None:
        lost = lost_carrier(history, block, carrier)[rows]
        up = np.where(lost[:, None], up, top_axes(history, carrier)[rows, :, -1])
    # Its bottom corners have gaps, which say how high the plane is.
    bottom = np.array(shape.bottom_corners(d))
    reach = -extents(history, block, rows, -up[:, None], bottom)[:, 0]
    low[rows] += -extents(history, block, rows, -up[:, None])[:, 0] - reach
    return low


def extents(
    history: Columns,
    block: BlockSpec,
    rows: Indices,
    axes: Array,
    corners: Array | None = None,
) -> Array:
    """How far a block reaches from the origin along unit vectors (rows, axes, d) in some rows, m.

    By its corners, or by some of them, (n, d), m, in its own frame.
    """
    box, shape = boxes(history, block).at(rows), block.shape
    d = len(box.half)
    arms = np.array(shape.corners(d) if corners is None else corners) - shape.middle(d)
    along = np.einsum("nad,nd->na", axes, box.centres)
    own = axes @ box.frames
    return along + np.array([(each @ arms.T).max(axis=1) for each in own])


def lean_over_alpha(history: Columns, block: BlockSpec) -> Array:
    """|theta|/alpha of a block, over the rows: its lean over alpha in the direction of the lean."""
    return np.abs(total_lean(history, block.name)) / slenderness(history, block)


def boxes(history: Columns, block: BlockSpec) -> Boxes:
    """A block as a rigid box, over the rows: the one around it, along its axes, of a shape."""
    frames, shape = _frames(history, block.name), block.shape
    return Boxes(
        half=np.array(shape.half_lengths(frames.shape[-1])),
        centres=middles(history, block),
        frames=frames,
    )


def middles(history: Columns, block: BlockSpec) -> Array:
    """The middle of the box around a block, over the rows, (rows, d), m."""
    middle, shape = centres(history, block.name), block.shape
    if shape.centre is None:
        return middle
    d = middle.shape[-1]
    off = np.array(shape.middle(d)) - shape.centre_of_mass(d)
    return np.asarray(middle + _frames(history, block.name) @ off)


def _frames(history: Columns, name: str) -> Array:
    """The axes of a block as columns, over the rows, (rows, d, d)."""
    if is_spatial(history, name):
        turns = _rotations(history, name)
        axes = [rotated(turns, axis) for axis in np.eye(3)]
    else:
        angle = history[f"{name}.angle_rad"]
        cosine, sine = np.cos(angle), np.sin(angle)
        axes = [np.stack([cosine, -sine], axis=1), np.stack([sine, cosine], axis=1)]
    return np.stack(axes, axis=2)


def rotated(rotations: Array, vectors: Array) -> Array:
    """Vectors (..., 3) turned by rotation vectors (n, 3), rad (formula of Rodrigues)."""
    angle = np.linalg.norm(rotations, axis=1, keepdims=True)
    axis = np.divide(rotations, angle, out=np.zeros_like(rotations), where=angle > 0)
    along = np.sum(axis * vectors, axis=1, keepdims=True) * axis
    across = np.cross(axis, vectors)
    return along + np.cos(angle) * (vectors - along) + np.sin(angle) * across


def flights(normal: Array, clear: Array, way: Array, width: float) -> Mask:
    """Rows of flights in which a block clears its carrier, or moves, by `SMALLEST_WAY` or more.

    The row with which a flight ends is one of them: what it moved up to there, it flew. An elastic
    block that vibrates is off for a moment, too: that is no flight.

    Args:
        normal: Force from the carrier, N, (rows,).
        clear: Gap of the lowest corner, m, (rows,).
        way: What the base moved along the carrier, m, (rows, 1 or 2).
        width: Of the block, m.
    """
    found = np.zeros(len(normal), dtype=bool)
    off = np.r_[False, (normal <= 0) & (clear > CLEAR * width), False]
    for first, end in np.flatnonzero(np.diff(off)).reshape(-1, 2):
        moved = np.linalg.norm(way[min(end, len(way) - 1)] - way[max(first - 1, 0)])
        if max(float(moved), float(clear[first:end].max())) > SMALLEST_WAY * width:
            found[first : end + 1] = True
    return found


def _turn(history: Columns, block: BlockSpec, carrier: BlockSpec | None) -> Array:
    """Rotation `BlockMotion.turn`: the twist of the block against its carrier, rad."""
    if not is_spatial(history, block.name):
        return np.zeros(len(history["time_s"]))
    frames = boxes(history, block).frames
    if carrier is not None:
        frames = np.swapaxes(top_axes(history, carrier), 1, 2) @ frames
    sine, cosine = frames[:, 1, 0] - frames[:, 0, 1], frames[:, 0, 0] + frames[:, 1, 1]
    # Where it leans beyond 90 degrees, as what rolls does, that is no turn about the vertical.
    known = np.where(frames[:, 2, 2] > 0, np.arange(len(frames)), 0)
    return np.unwrap(np.arctan2(sine, cosine)[np.maximum.accumulate(known)])


def _stack(history: Columns, name: str, columns: list[str]) -> Array:
    """Some columns of a block side by side, (rows, columns)."""
    return np.stack([history[f"{name}.{column}"] for column in columns], axis=1)


def _rotations(history: Columns, name: str) -> Array:
    """Rotation vectors of a block in space, rad, (rows, 3)."""
    return _stack(history, name, [f"angle_{axis}_rad" for axis in "xyz"])


def upright_axes(history: Columns, name: str) -> Array:
    """Direction of a block's upright axis, (rows, 3)."""
    return rotated(_rotations(history, name), UP)


def _angle_from_up(axes: Array) -> Array:
    """Angle of unit vectors from upright, rad, 0 to pi; exact for small ones, too."""
    return np.arctan2(np.linalg.norm(axes[:, :2], axis=1), axes[:, 2])


def _leaning_in_space(history: Columns, block: BlockSpec, carrier: BlockSpec | None) -> Leaning:
    """Lean of a block in space against its carrier, or from upright."""
    rotations = _rotations(history, block.name)
    axes = rotated(rotations, UP)
    # The carrier's upright axis in the block's own frame gives the direction of the lean.
    below = np.broadcast_to(UP, axes.shape)
    if carrier is not None and not rolls(carrier.shape, 3):
        below = upright_axes(history, carrier.name)
        axes = rotated(-_rotations(history, carrier.name), axes)
    most = int(np.argmax(_angle_from_up(axes)))
    own = -rotated(-rotations, below)[most, :2]
    direction = _towards(axes[most, :2])
    angle = np.unwrap(np.arctan2(axes[:, :2] @ direction, axes[:, 2]))
    across = axes[:, 0] * direction[1] - axes[:, 1] * direction[0]
    aside = np.abs(np.arcsin(np.clip(across, -1.0, 1.0)))
    length, backwards = float(np.linalg.norm(own)), float(axes[most, :2] @ direction) < 0
    way = own / (-length if backwards else length) if length else np.array([1.0, 0.0])
    return Leaning(angle, block.shape.across((float(way[0]), float(way[1]))), direction, aside)


def _towards(horizontal: Array) -> Array:
    """The unit vector along a horizontal one that points to +x, or to +y where it has no x."""
    length = float(np.linalg.norm(horizontal))
    if length == 0:
        return np.array([1.0, 0.0])
    unit = horizontal / length
    backwards = unit[0] < -1e-9 or (abs(unit[0]) <= 1e-9 and unit[1] < 0)
    return np.asarray(-unit if backwards else unit)


def _fell(history: Columns, block: BlockSpec, carriers: Sequence[BlockSpec]) -> bool:
    """True if the centre of a block ends below the surface that it stood on, or all of them.

    That of the foundation is at level 0. That of a block is its top; a block that lies beside an
    overturned carrier is above the plane of that top, but not above its centre.
    """
    centre = centres(history, block.name)[-1]
    if not carriers:
        return bool(centre[-1] < 0)
    return all(_is_below(history, centre, carrier) for carrier in carriers)


def _is_below(history: Columns, centre: Array, carrier: BlockSpec) -> bool:
    """True if a place is below the top of a block at the end, or below its centre."""
    above = centre - centres(history, carrier.name)[-1]
    normal = top_axes(history, carrier)[-1, :, -1]
    top = top_over_centre(carrier.shape, len(centre))
    return bool(above @ normal < top or above[-1] < 0)
