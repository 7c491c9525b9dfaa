"""Feet of blocks: pads below a box, and above it, with nothing but their ends in the scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, TypeAlias

from geometry.block import Block
from solver.errors import SceneError, Statement
from solver.scene.checking import Checked, shown
from solver.scene.quantities import Dimension, Length, NotNegativeLength, Place

if TYPE_CHECKING:
    from geometry.solid import Solid

Plan: TypeAlias = tuple[Place] | tuple[Place, Place]
Sides: TypeAlias = Length | tuple[Length, Length]


@dataclass(frozen=True, slots=True, kw_only=True)
class FootSpec(Checked):
    """One foot: a pad below or above the box, without mass."""

    at: Plan
    """Its middle from that of the box, `[x]`, in 3-D `[x, y]`, m."""
    size: Sides
    """Its width along x, in 3-D along y, too, or `[a, b]` along x and y, m."""
    height: Length
    """Of its end below the box, or above it, m; the box stands on the longest ones."""
    face: Literal["bottom", "top"] = "bottom"
    """Face of the box that it is on; those on top carry what stands on the block."""

    @property
    def sides(self) -> tuple[float, float]:
        """Its widths along x and y, m."""
        return _sides_of(self.size)


@dataclass(frozen=True, slots=True, kw_only=True)
class EvenFeetSpec(Checked):
    """A foot below each corner of the box, all alike."""

    inset: NotNegativeLength = 0.0
    """Distance of their outer edges from the sides of the box, m."""
    size: Sides
    """Width of each along x, in 3-D along y, too, or `[a, b]` along x and y, m."""
    height: Length
    """Of their bottoms below the box, m."""
    top: Length | None = None
    """Of the tops of four more above the box, which carry what stands on the block, m. Default:
    none."""


def _sides_of(size: Sides) -> tuple[float, float]:
    """Widths along x and y, m."""
    return size if isinstance(size, tuple) else (size, size)


def single_feet(
    feet: EvenFeetSpec | tuple[FootSpec, ...], across: tuple[float, float], dimension: Dimension
) -> tuple[FootSpec, ...]:
    """All feet, each for itself, of a box by its width and thickness, m.

    Raises:
        SceneError: They reach beyond the box, or into each other.
    """
    sides = across[: dimension - 1]
    if isinstance(feet, EvenFeetSpec):
        _refuse_pair(feet.size, "feet.size", dimension)
        size = _sides_of(feet.size)
        reach = [side / 2 - feet.inset - own / 2 for side, own in zip(sides, size, strict=False)]
        if any(far < own / 2 for far, own in zip(reach, size, strict=False)):
            wide = " x ".join(f"{own:g}" for own in dict.fromkeys(size))
            said = f"do not fit below the box: {wide} m wide, inset by {feet.inset:g} m"
            raise Statement("feet", said)
        plans: list[Plan] = [(-reach[0],), (reach[0],)]
        if dimension == 3:
            x, y = reach
            plans = [(-x, -y), (x, -y), (x, y), (-x, y)]
        found = [FootSpec(at=at, size=feet.size, height=feet.height) for at in plans]
        if feet.top is not None:
            found += [replace(foot, height=feet.top, face="top") for foot in found]
        return tuple(found)
    for number, foot in enumerate(feet, start=1):
        _refuse_pair(foot.size, f"feet.{number}.size", dimension)
        for place, side, own in zip(foot.at, sides, foot.sides, strict=False):
            if abs(place) + own / 2 > side / 2 * (1 + 1e-9):
                raise Statement(f"feet.{number}", "reaches beyond the box: move it (at), or size")
        for k, other in enumerate(feet[: number - 1], start=1):
            if foot.face == other.face and _overlap(foot, other):
                raise Statement(f"feet.{number}", f"is in foot {k}: move it (at), or size")
    return feet


def _refuse_pair(size: Sides, where: str, dimension: Dimension) -> None:
    """Refuse two widths in the plane, where there is one."""
    if dimension == 2 and isinstance(size, tuple):
        raise SceneError(where, shown(size), "1 value where dimension = 2")


def _overlap(foot: FootSpec, other: FootSpec) -> bool:
    """True if two feet on one face have some of it in common."""
    along = zip(foot.at, other.at, foot.sides, other.sides, strict=False)
    return all(abs(a - b) < (own + its) / 2 * (1 - 1e-9) for a, b, own, its in along)


@lru_cache(maxsize=256)
def block_on_feet(box: Block, feet: tuple[FootSpec, ...], dimension: Dimension) -> Block:
    """A box with feet outside of it; mass and inertia are those of the box."""
    low, high = _longest(feet, "bottom"), _longest(feet, "top")
    x, y, z = box.centre_of_mass(3)
    height = low + box.height + high
    around = Block(
        width=box.width,
        height=height,
        thickness=box.thickness,
        density=box.density * box.height / height,
        centre=(x, y, z + low),
        inertia=box.inertia_tensor,
        walls=(low, low + box.height),
    )
    return block_between_feet(around, feet, dimension)


@lru_cache(maxsize=256)
def block_between_feet(whole: Block, feet: tuple[FootSpec, ...], dimension: Dimension) -> Block:
    """A block whose lowest and highest parts are feet, which are within its height.

    Args:
        whole: The box from the ends of the lower feet to those of the upper ones; mass, centre of
            mass, inertia, and the walls on which a pressure acts, are as it has them.
        feet: All of them.
        dimension: Of the scene.
    """
    from geometry import shapes

    ends = _longest(feet, "bottom"), whole.height - _longest(feet, "top")
    body = _prism((0.0, 0.0), (whole.width, whole.thickness), ends, whole.thickness, dimension)
    above = [_pad(foot, ends, whole.thickness, dimension) for foot in feet if foot.face == "top"]
    below = [_pad(foot, ends, whole.thickness, dimension) for foot in feet if foot.face != "top"]
    solid = shapes.union([body, *above, *below])
    bottom = [tuple(map(float, corner)) for pad in below or [body] for corner in pad.bottom]
    along = [corner[0] for corner in bottom]
    x, y, z = whole.centre_of_mass(3)
    return replace(
        whole,
        density=whole.mass / solid.volume,
        centre=(x, y, z),
        inertia=whole.inertia_tensor,
        base=(min(along), max(along)),
        solid=solid,
        bottom=tuple(bottom),
        feet=len(below),
    )


def _longest(feet: Sequence[FootSpec], face: str) -> float:
    """Height of the longest foot on a face, m; 0 if there is none."""
    return max((foot.height for foot in feet if foot.face == face), default=0.0)


def _pad(foot: FootSpec, ends: tuple[float, float], deep: float, dimension: Dimension) -> Solid:
    """A foot as a body below a box, or above it, whose levels are given, m."""
    low, high = ends
    levels = (high, high + foot.height) if foot.face == "top" else (low - foot.height, low)
    x, y = (*foot.at, 0.0)[:2]
    return _prism((x, y), foot.sides, levels, deep, dimension)


def _prism(
    middle: tuple[float, float],
    sides: tuple[float, float],
    levels: tuple[float, float],
    deep: float,
    dimension: Dimension,
) -> Solid:
    """A box between two levels, in the plane as deep as its scene, m."""
    from geometry import shapes

    half, (low, high) = sides[0] / 2, levels
    ring = [(-half, low), (half, low), (half, high), (-half, high)]
    flat = shapes.polygon(ring, 1.0, deep)
    if dimension == 2:
        return flat.moved((middle[0], 0.0))
    return shapes.prism(flat, sides[1]).moved((*middle, 0.0))
