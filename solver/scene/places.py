"""Places of blocks at the start, each on what carries it; places that cannot be are refused."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from geometry.arrangement import (
    Pose,
    initial_position,
    level,
    middle_of,
    pose_of_top,
    rotation_of,
)
from geometry.boxes import Boxes, overlap_depth
from geometry.convex import Convex
from geometry.overlap import common_depth, descent
from geometry.shapes import hull
from geometry.top import top_of as outline_of
from solver.errors import SceneError, Statement
from solver.scene.block import BlockSpec
from solver.scene.checking import shown
from solver.scene.force import ForceSpec
from solver.scene.laws import GROUND
from solver.scene.link import LinkSpec
from solver.scene.quantities import Dimension
from solver.types import Array

Drift = tuple[float, float]

ROUND_OFF = 1e-9
"""Blocks that overlap by less than this part of their size touch, and tops that are uneven by less
are level."""

UNEVEN = 1e-6
"""Part of a block's size from which the top of its carrier is lower where it stands."""


def poses(
    blocks: Sequence[BlockSpec],
    dimension: Dimension,
    *,
    upright: bool = False,
    drift: Drift = (0.0, 0.0),
) -> dict[str, Pose]:
    """For each block, by its name, the rigid motion from its own frame to its place at the start.

    Args:
        blocks: Each after its carriers.
        dimension: Of space.
        upright: As if nothing were tilted.
        drift: Place of the platform along x and y, m; all blocks are moved with it.
    """
    placed: dict[str, Pose] = {}
    known = {spec.name: spec for spec in blocks}
    tops = {"foundation": level(np.array([*drift[: dimension - 1], 0.0]))}
    for spec in blocks:
        tilt = 0.0 if upright else spec.tilt
        if spec.position is not None:
            pose = tops["foundation"].after(_in_the_air(spec, spec.position, tilt))
        else:
            below = middle_of([tops[name] for name in spec.carriers])
            offset = (spec.offset, spec.offset_second)[: dimension - 1]
            own = initial_position(spec.shape, offset, tilt, spec.tilt_direction)
            carriers = [(known[name], placed[name]) for name in spec.carriers if name in known]
            pose = below.after(_lowered(spec, own, below, carriers, dimension))
        placed[spec.name], tops[spec.name] = pose, pose_of_top(pose, spec.shape.height)
    return placed


def stands(blocks: Sequence[BlockSpec], dimension: Dimension) -> dict[str, tuple[Pose, Pose]]:
    """For each block two rigid motions, by its name; blocks as in `poses`.

    The first takes the block's own frame to where it would stand if nothing was tilted (a
    translation: there it is meshed), the second goes on from there to where it starts.
    """
    upright = poses(blocks, dimension, upright=True)
    return {
        name: (
            upright[name],
            Pose(
                rotation=pose.rotation,
                about=upright[name](pose.about[None])[0],
                place=pose.place,
            ),
        )
        for name, pose in poses(blocks, dimension).items()
    }


def _lowered(
    spec: BlockSpec,
    own: Pose,
    below: Pose,
    carriers: Sequence[tuple[BlockSpec, Pose]],
    dimension: Dimension,
) -> Pose:
    """The place of a block on what it touches first as it goes down from the level of a top.

    Args:
        spec: The block.
        own: Its place on that level.
        below: The frame of the top.
        carriers: What carries it, and where that is.
        dimension: Of space.
    """
    if all(each.shape.solid is None for each in (spec, *(other for other, _ in carriers))):
        return own
    parts = _parts(spec, own, dimension)
    drops = (
        descent(parts, _parts(other, _seen_from(below, pose), dimension))
        for other, pose in carriers
    )
    drop = min(drops, default=np.inf)
    if not UNEVEN * spec.shape.half_diagonal < drop < np.inf:
        return own
    down = np.append(np.zeros(dimension - 1), drop)
    return Pose(rotation=own.rotation, about=own.about, place=own.place - down)


def standing_part(
    spec: BlockSpec, carrier: BlockSpec, placed: Mapping[str, Pose], dimension: Dimension
) -> int | None:
    """Number of the part on which a block stands below the hull of its carrier; None: it does not.

    As on the roof of a container, between its castings.
    """
    solid, below = carrier.shape.solid, placed[carrier.name]
    if solid is None or len(solid.parts) == 1:
        return None
    own = _parts(spec, _seen_from(below, placed[spec.name]), dimension)
    size = spec.shape.half_diagonal
    if descent(own, hull(solid.corners).parts) > -UNEVEN * size:
        return None
    drops = [descent(own, [part]) for part in solid.parts]
    return int(np.argmin(drops))


def _seen_from(frame: Pose, pose: Pose) -> Pose:
    """A pose in a frame."""
    place = frame.rotation.T @ (pose.place - frame.place) + frame.about
    return Pose(rotation=frame.rotation.T @ pose.rotation, about=pose.about, place=place)


def _in_the_air(spec: BlockSpec, position: tuple[float, ...], tilt: float) -> Pose:
    """Place of a block whose centre of mass is at a position, m, turned about it."""
    rotation = rotation_of(len(position), tilt, spec.tilt_direction)
    about = np.array(spec.shape.centre_of_mass(len(position)))
    return Pose(rotation=rotation, about=about, place=np.array(position))


def refuse_places(
    blocks: Sequence[BlockSpec], dimension: Dimension, top: Sequence[float] | None
) -> None:
    """Refuse blocks that stand uneven, reach into the foundation, or overlap at the start.

    Args:
        blocks: All of a scene, as in `poses`.
        dimension: Of space.
        top: Sides of the foundation's top, m, beyond which a block may hang over; None: it has no
            ends.

    Raises:
        Statement: Names the blocks, and levels or depth.
    """
    placed = poses(blocks, dimension)
    tops = {spec.name: pose_of_top(placed[spec.name], spec.shape.height) for spec in blocks}
    tops["foundation"] = level(np.zeros(dimension))
    halves = {spec.name: np.array(spec.shape.half_lengths(dimension))[:-1] for spec in blocks}
    halves["foundation"] = np.full(dimension - 1, np.inf)
    for spec in blocks:
        if len(spec.carriers) > 1:
            _refuse_uneven(spec, tops)
            _refuse_short(spec, tops, halves)
        _refuse_hollow(spec, blocks, placed, dimension)
        depth = -placed[spec.name](np.array(spec.shape.corners(dimension)))[:, -1].min()
        if top is not None and depth > 0:
            depth = min(depth, _depth_in(top, spec, placed[spec.name], dimension))
        if depth > ROUND_OFF * spec.shape.half_diagonal:
            key = "offset" if spec.position is None else "position"
            said = f"reaches into the foundation by {depth:.4g} m at the start: move it ({key})"
            raise Statement(f"block {spec.name}", said)
    for first, second, depth in _overlaps(blocks, placed, dimension):
        raise Statement(
            f"blocks {first.name} and {second.name}",
            f"overlap by {depth:.4g} m at the start: move one (offset or position), or let one "
            f"carry the other (on)",
        )


def _depth_in(top: Sequence[float], spec: BlockSpec, pose: Pose, dimension: Dimension) -> float:
    """How deep a block is in a foundation with ends, taken as deep as wide, m."""
    half = 0.5 * np.array([*top[: dimension - 1], top[0]])
    middle = np.zeros((1, dimension))
    middle[0, -1] = -half[-1]
    slab = Boxes(half=half, centres=middle, frames=np.eye(dimension)[None])
    return float(overlap_depth(slab, _box(spec, pose, dimension))[0])


def _refuse_uneven(spec: BlockSpec, tops: Mapping[str, Pose]) -> None:
    """Refuse several carriers whose tops are not in one plane."""
    first, *others = spec.carriers
    base = tops[first]
    for name in others:
        top = tops[name]
        tilted = bool(np.abs(top.rotation - base.rotation).max() > ROUND_OFF)
        step = (top.place - base.place) @ base.rotation[:, -1]
        if tilted or abs(step) > ROUND_OFF * spec.shape.half_diagonal:
            levels = f"that of {first} is at {base.place[-1]:.10g} m, that of {name} at "
            levels += f"{top.place[-1]:.10g} m{', tilted against it' * tilted}"
            raise Statement(f"{spec.name}.on", f"needs level tops: {levels}")


def _refuse_hollow(
    spec: BlockSpec, blocks: Sequence[BlockSpec], placed: Mapping[str, Pose], dimension: Dimension
) -> None:
    """Refuse a block with its centre below the top of what carries it, such as beside a tower."""
    for other in blocks:
        if other.name not in spec.carriers or other.shape.solid is None:
            continue
        own = _seen_from(placed[other.name], placed[spec.name])
        level = outline_of(other.shape, dimension).level
        middle = own(np.array([spec.shape.centre_of_mass(dimension), spec.shape.middle(dimension)]))
        if middle[:, -1].min() < level:
            centre = placed[spec.name](np.array(spec.shape.centre_of_mass(dimension))[None])[0]
            place = shown(tuple(float(f"{x:.10g}") + 0.0 for x in centre))
            raise Statement(
                f"{spec.name}.on",
                f"names {other.name}, beside whose top it stands, with its centre lower than that:"
                f" give its place instead of on and offset, position = {place}",
            )


def _refuse_short(spec: BlockSpec, tops: Mapping[str, Pose], halves: Mapping[str, Array]) -> None:
    """Refuse a block whose bottom does not reach over each of its several carriers.

    `halves` has half the lengths of blocks in plan, (d - 1,), m.
    """
    middle = middle_of([tops[name] for name in spec.carriers])
    offset = np.array([spec.offset, spec.offset_second])[: len(middle.place) - 1]
    for name in spec.carriers:
        place = middle.rotation.T @ (tops[name].place - middle.place)
        reach = halves[spec.name] + halves[name] - np.abs(place[:-1] - offset)
        if reach.min() <= ROUND_OFF * spec.shape.half_diagonal:
            said = f"names {name}, over which its bottom does not reach: move it (offset), or"
            raise Statement(f"{spec.name}.on", f"{said} make it wider")


def _overlaps(
    blocks: Sequence[BlockSpec], placed: Mapping[str, Pose], dimension: Dimension
) -> Iterator[tuple[BlockSpec, BlockSpec, float]]:
    """Pairs of blocks that overlap, and the depth, m."""
    boxes = [_box(spec, placed[spec.name], dimension) for spec in blocks]
    shapes: list[Sequence[Convex]] = [()] * len(blocks)
    if any(spec.shape.solid is not None for spec in blocks):
        shapes = [_parts(spec, placed[spec.name], dimension) for spec in blocks]
    centres = np.concatenate([box.centres for box in boxes])
    reaches = np.concatenate([box.reach(np.eye(dimension)[None]) for box in boxes])
    for k, first in enumerate(blocks):
        apart = np.abs(centres[k + 1 :] - centres[k]) - reaches[k + 1 :] - reaches[k]
        for other in k + 1 + np.flatnonzero(np.all(apart <= 0, axis=1)):
            depth = float(overlap_depth(boxes[k], boxes[other])[0])
            if depth > 0 and shapes[k] and shapes[other]:
                depth = common_depth(shapes[k], shapes[other])
            size = max(first.shape.half_diagonal, blocks[other].shape.half_diagonal)
            if depth > ROUND_OFF * size:
                yield first, blocks[other], depth


def _box(spec: BlockSpec, pose: Pose, dimension: Dimension) -> Boxes:
    """A block as a box at its place."""
    centre = pose(np.array(spec.shape.middle(dimension))[None])
    half = np.array(spec.shape.half_lengths(dimension))
    return Boxes(half=half, centres=centre, frames=pose.rotation[None])


def _parts(spec: BlockSpec, pose: Pose, dimension: Dimension) -> Sequence[Convex]:
    """The convex parts of a block at its place; of a box itself."""
    solid = spec.shape.solid or hull(spec.shape.corners(dimension))
    at_origin = [part.moved(-pose.about).rotated(pose.rotation) for part in solid.parts]
    return [part.moved(pose.place) for part in at_origin]


def link_ends(link: LinkSpec, placed: Mapping[str, Pose]) -> tuple[Array, Array]:
    """Places of the ends of a link at the start, (d,), m.

    `placed` has the rigid motions of `poses`, and that of the foundation where it is not at 0.
    """
    here = {GROUND: level(np.zeros(len(link.at)))} | dict(placed)
    first = here[link.between[0]](np.array([link.at]))[0]
    if link.to is None:
        return first, first
    return first, here[link.between[1]](np.array([link.to]))[0]


def own_ends(link: LinkSpec, placed: Mapping[str, Pose]) -> tuple[Array, Array]:
    """The ends of a link in the own frames of its bodies, (d,), m; `placed` as in `link_ends`."""
    first = np.array(link.at)
    if link.to is not None:
        return first, np.array(link.to)
    here = {GROUND: level(np.zeros(len(link.at)))} | dict(placed)
    one, other = (here[name] for name in link.between)
    return first, (one(first[None])[0] - other.place) @ other.rotation + other.about


def second_is_above(link: LinkSpec, placed: Mapping[str, Pose]) -> bool:
    """True if its second body is not lower than the first at the start, by their bottoms."""
    first, second = (
        -np.inf if name == GROUND else placed[name](np.zeros((1, len(link.at))))[0, -1]
        for name in link.between
    )
    return bool(second >= first)


OUTSIDE = 0.01
"""How far outside of an elastic block, as a part of its half diagonal, a place counts as one on its
surface: facets of a round face lie within it."""


def refuse_outside(
    links: Sequence[LinkSpec],
    forces: Sequence[ForceSpec],
    blocks: Sequence[BlockSpec],
    deck: Sequence[float] | None,
) -> None:
    """Refuse places at which nothing is that deforms: outside of elastic blocks, off a meshed top.

    Args:
        links: All of a scene.
        forces: The same.
        blocks: The same.
        deck: Sides of the top of a meshed foundation, m; None: it is not meshed.

    Raises:
        SceneError: Names the place.
    """
    elastic = {block.name: block for block in blocks if block.model == "elastic"}
    ends = [
        (f"{link.name}.{key}", name, place)
        for link in links
        for key, name, place in zip(("at", "to"), link.between, (link.at, link.to), strict=True)
    ]
    ends += [(f"{force.name}.at", force.on, force.at) for force in forces]
    for where, name, place in ends:
        if place is None:
            continue
        if name in elastic and not _is_in(elastic[name], np.array(place)):
            raise SceneError(where, shown(place), f"a place in {name} or on it, which is elastic")
        if name == GROUND and deck is not None:
            half = 0.5 * np.array(deck[: len(place) - 1]) * (1 + ROUND_OFF)
            if place[-1] or np.any(np.abs(place[:-1]) > half):
                raise SceneError(where, shown(place), "a place on the foundation's top, at level 0")


def _is_in(spec: BlockSpec, place: Array) -> bool:
    """True if a place of its own frame, (d,), m, is in a block or on its surface."""
    solid = spec.shape.solid or hull(spec.shape.corners(len(place)))
    reach = OUTSIDE * spec.shape.half_diagonal
    if solid.surface is not None:
        return solid.surface.is_near(place, reach)
    return any(part.beyond(place[None])[0] <= reach for part in solid.parts)


def refuse_links(
    links: Sequence[LinkSpec], placed: Mapping[str, Pose], dimension: Dimension
) -> None:
    """Refuse axial links without a length, and twist-locks of bodies side by side.

    Raises:
        SceneError: Names the link.
    """
    for link in links:
        first, second = link_ends(link, placed)
        apart, size = float(np.linalg.norm(second - first)), max(1.0, *np.abs(first))
        if link.is_axial and apart <= ROUND_OFF * size:
            got = f"{shown(link.to)}, the place of the other end"
            raise SceneError(f"{link.name}.to", got, f"a place away from it: {link.kind} is axial")
        if link.pulls and not link.is_axial and GROUND not in link.between:
            levels = [placed[name](np.zeros((1, dimension)))[0, -1] for name in link.between]
            if abs(levels[0] - levels[1]) <= ROUND_OFF * size:
                what = f"{shown(link.between)}, side by side"
                raise SceneError(f"{link.name}.between", what, "one block above the other")
