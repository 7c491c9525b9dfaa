"""Feet of blocks: pads below a box, with nothing but their tops and their bottoms in the scene."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from geometry.block import Block
from solver.errors import SceneError, Statement
from solver.scene.checking import Checked, shown
from solver.scene.quantities import Dimension, Length, NotNegativeLength, Place

if TYPE_CHECKING:
    from geometry.solid import Solid

Plan: TypeAlias = tuple[Place] | tuple[Place, Place]


@dataclass(frozen=True, slots=True, kw_only=True)
class FootSpec(Checked):
    """One foot: a pad below the box, without mass."""

    at: Plan
    """Its middle from that of the box, `[x]`, in 3-D `[x, y]`, m."""
    size: Length
    """Its width along x, in 3-D along y, too, m."""
    height: Length
    """Of its bottom below the box, m; the box stands on the longest ones."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EvenFeetSpec(Checked):
    """A foot below each corner of the box, all alike."""

    inset: NotNegativeLength = 0.0
    """Distance of their outer edges from the sides of the box, m."""
    size: Length
    """Width of each along x, in 3-D along y, too, m."""
    height: Length
    """Of their bottoms below the box, m."""


class Box(NamedTuple):
    """The block above its feet."""

    width: float
    """B, m."""
    height: float
    """H, m."""
    thickness: float
    """t, m."""


def single_feet(
    feet: EvenFeetSpec | tuple[FootSpec, ...], box: Box, dimension: Dimension
) -> tuple[FootSpec, ...]:
    """All feet, each for itself.

    Raises:
        SceneError: They reach beyond the box, or into each other.
    """
    sides = (box.width, box.thickness)[: dimension - 1]
    if isinstance(feet, EvenFeetSpec):
        reach = [side / 2 - feet.inset - feet.size / 2 for side in sides]
        if min(reach) < feet.size / 2:
            said = f"do not fit below the box: {feet.size:g} m wide, inset by {feet.inset:g} m"
            raise Statement("feet", said)
        plans: list[Plan] = [(-reach[0],), (reach[0],)]
        if dimension == 3:
            x, y = reach
            plans = [(-x, -y), (x, -y), (x, y), (-x, y)]
        return tuple(FootSpec(at=at, size=feet.size, height=feet.height) for at in plans)
    for number, foot in enumerate(feet, start=1):
        if len(foot.at) != dimension - 1:
            allowed = f"{'1 value' if dimension == 2 else '2 values'} where dimension = {dimension}"
            raise SceneError(f"feet.{number}.at", shown(foot.at), allowed)
        for place, side in zip(foot.at, sides, strict=True):
            if abs(place) + foot.size / 2 > side / 2 * (1 + 1e-9):
                raise Statement(f"feet.{number}", "reaches beyond the box: move it (at), or size")
        for k, other in enumerate(feet[: number - 1], start=1):
            apart = max(abs(a - b) for a, b in zip(foot.at, other.at, strict=True))
            if apart < (foot.size + other.size) / 2 * (1 - 1e-9):
                raise Statement(f"feet.{number}", f"is in foot {k}: move it (at), or size")
    return feet


@lru_cache(maxsize=256)
def block_on_feet(block: Block, feet: tuple[FootSpec, ...], dimension: Dimension) -> Block:
    """A box with feet below it; mass and inertia are those of the box."""
    from geometry import solid as solids

    longest = max(foot.height for foot in feet)
    half, deep = block.width / 2, block.thickness
    ring = [(-half, longest), (half, longest)]
    ring += [(x, longest + block.height) for x, _ in reversed(ring)]
    body = solids.polygon(ring, block.density, deep)
    parts = [body if dimension == 2 else solids.prism(body, deep)]
    parts += [_pad(foot, longest, dimension, block) for foot in feet]
    bottom = tuple(tuple(map(float, corner)) for pad in parts[1:] for corner in pad.bottom)
    ends = [corner[0] for corner in bottom]
    x, y, z = block.centre_of_mass(3)
    return Block(
        width=block.width,
        height=block.height + longest,
        thickness=block.thickness,
        density=block.mass / solids.union(parts).volume,
        centre=(x, y, z + longest),
        inertia=block.inertia_tensor,
        base=(min(ends), max(ends)),
        solid=solids.union(parts),
        bottom=bottom,
        feet=len(feet),
    )


def _pad(foot: FootSpec, longest: float, dimension: Dimension, block: Block) -> Solid:
    """A foot as a body below its box, whose bottom is where the longest foot lets it be."""
    from geometry import solid as solids

    half, low = foot.size / 2, longest - foot.height
    ring = [(-half, low), (half, low), (half, longest), (-half, longest)]
    flat = solids.polygon(ring, 1.0, block.thickness)
    if dimension == 2:
        return flat.moved((foot.at[0], 0.0))
    return solids.prism(flat, foot.size).moved((*foot.at, 0.0))
