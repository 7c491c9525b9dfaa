"""Times at which blocks have overturned or fallen, and the watch that ends a run there.

A block has overturned where it leans, against upright, beyond the angle from which it does not come
back (`motion.tipping`); what rolls has none. It has fallen where it moves down and either all of it
is below the plane of the top of what carried it, or all of it is beside that top and some of it
below: nothing holds it any more. Where several carried it, it is off all of them. Where rigid
blocks with a restitution stand on a plate, their engine takes it for the ground, and a run ends
where a corner touches that beyond its edge. All are found from the columns of a history, in the
same way for all engines.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from geometry.top import Top, top_of
from solver.excitation.motion import GroundMotion
from solver.history.columns import Rows
from solver.history.history import scene_columns
from solver.results.motion import (
    Columns,
    boxes,
    centres,
    extents,
    middles,
    platform_drift,
    tipping,
    top_axes,
    total_lean,
)
from solver.resumable import Resumable
from solver.scene import BlockSpec, Scene
from solver.types import Array, Indices, Mask

AT_LEVEL = 1e-6
"""Height of a corner that touches the ground, at most, over the height of its block."""


def motion_end(ground: GroundMotion) -> float:
    """Time at which the motion of the ground is over in all directions, s; 0 without any."""
    return max((part.stop for part in ground.parts if part is not None), default=0.0)


def cut_short(summary: Mapping[str, Any]) -> str:
    """Tell in words that a run ends before the motion of the ground does, by its summary; or "".

    Every table of such runs begins with it.
    """
    end, motion = summary["end_s"], summary.get("motion_end_s") or 0.0
    if not motion > end * (1 + 1e-6):
        return ""
    return f"ends at {end:.6g} s, before its motion does at {motion:.6g} s"


@dataclass(frozen=True, slots=True)
class Ending:
    """Early end of a run."""

    row: int
    """Number of its last row among those that were looked at."""
    reason: str
    """In words."""


class Watch(Resumable):
    """Looks at the rows of a run as they come, for what ends it."""

    CARRIED = ("_before",)

    def __init__(self, scene: Scene):
        """Watch a scene from its start.

        What falls off a block lands on the floor; what falls over the end of a plate or of a deck
        lands on nothing.
        """
        self._scene, self._names = scene, scene_columns(scene)
        self._before: Array | None = None
        self._overturning = scene.blocks if scene.time.stop == "overturned" else ()
        ends = scene.foundation.top is not None
        self._falling = scene.blocks if ends and not scene.is_rigid else ()
        self._leaving = scene.blocks if ends and scene.is_rigid else ()

    @property
    def ends_runs(self) -> bool:
        """True if there is something to look for."""
        return bool(self._overturning or self._falling or self._leaving)

    def look(self, rows: Array) -> Ending | None:
        """The first of some rows, (n, columns), after which the run ends; None: it goes on."""
        if not self.ends_runs:
            return None
        before = rows[:1] if self._before is None else self._before
        table = Rows(self._names, np.vstack([before, rows]))
        self._before = rows[-1:].copy()
        lost = [(off_foundation(self._scene, table, b), b, "fell") for b in self._falling]
        lost += [(beyond_return(table, block), block, "overturned") for block in self._overturning]
        what = "came to the edge of the plate"
        lost += [(beyond_edge(self._scene, table, block), block, what) for block in self._leaving]
        found = [(int(np.argmax(m[1:])), block, what) for m, block, what in lost if m[1:].any()]
        if not found:
            return None
        row, lying, what = min(found, key=lambda entry: entry[0])
        where = _where(table, lying, row + 1) if what == "fell" else ""
        return Ending(row, f"{lying.name} {what} at t = {table['time_s'][row + 1]:.6g} s{where}")


def _where(history: Columns, block: BlockSpec, row: int) -> str:
    """Where the centre of a block that fell off the foundation was in a row, in words."""
    place = zip("xyz", centres(history, block.name)[row, :-1], strict=False)
    return ", off the foundation with its centre at " + ", ".join(
        f"{a} = {x:.4g} m" for a, x in place
    )


def overturned_at(history: Columns, block: BlockSpec) -> float | None:
    """Time at which a block has overturned, s; None where it has not.

    Where it ends beyond its point of balance, but not yet beyond return: when it last passed that.
    """
    time = history["time_s"]
    lost = np.flatnonzero(beyond_return(history, block))
    if len(lost):
        return float(time[lost[0]])
    held = np.abs(total_lean(history, block.name)) <= tipping(history, block).balance
    if held[-1]:
        return None
    last = np.flatnonzero(held)
    return float(time[last[-1] + 1 if len(last) else 0])


def beyond_return(history: Columns, block: BlockSpec) -> Mask:
    """In which rows a block leans beyond the angle from which it does not come back."""
    lean = np.abs(total_lean(history, block.name))
    return np.asarray(lean > tipping(history, block).no_return)


def beyond_edge(scene: Scene, history: Columns, block: BlockSpec) -> Mask:
    """In which rows a corner of a block touches the level of the foundation's top beside it."""
    box, dimension = boxes(history, block), scene.dimension
    assert scene.foundation.top is not None
    half = np.array(scene.foundation.top[: dimension - 1]) / 2
    shape = block.shape
    arms = np.array(shape.corners(dimension)) - shape.middle(dimension)
    corners = box.centres[:, None] + np.einsum("nij,kj->nki", box.frames, arms)
    beside = (np.abs(corners[..., :-1]) > half * (1 + AT_LEVEL)).any(axis=-1)
    return np.asarray((beside & (corners[..., -1] <= AT_LEVEL * block.height)).any(axis=1))


def fallen(scene: Scene, history: Columns, block: BlockSpec) -> Mask:
    """In which rows a block moves down, off what carried it; never in the first one."""
    return _off(history, block, _carriers(scene, history, block))


def off_foundation(scene: Scene, history: Columns, block: BlockSpec) -> Mask:
    """In which rows a block moves down, off the foundation, which has ends."""
    return _off(history, block, _foundation(scene, history))


def _off(history: Columns, block: BlockSpec, tops: Iterator[_PlacedTop]) -> Mask:
    """In which rows a block moves down, off all of some tops; never in the first one."""
    middle = middles(history, block)
    falls = np.zeros(len(middle), dtype=np.bool_)
    falls[1:] = middle[1:, -1] < middle[:-1, -1]
    if not np.count_nonzero(falls):  # most often: a run looks at every row
        return falls
    for top, origins, frames in tops:
        # Only where its middle is off the top, too.
        falls &= top.is_off(np.einsum("nji,nj->ni", frames, middle - origins))
        rows = np.flatnonzero(falls)
        if not len(rows):
            return falls
        inwards, at = np.swapaxes(frames[rows], 1, 2), origins[rows]
        out = top.normals @ inwards[:, :-1]
        high = _reach(history, block, rows, inwards[:, -1:], at)[:, 0]
        low = -_reach(history, block, rows, -inwards[:, -1:], at)[:, 0]
        near = -_reach(history, block, rows, -out, at)
        beside = (near >= top.reach).any(axis=1) & (low < top.level)
        falls[rows] = (high <= top.level) | beside
    return np.asarray(falls)


def _reach(history: Columns, block: BlockSpec, rows: Indices, axes: Array, origins: Array) -> Array:
    """How far a block reaches along unit vectors (rows, axes, d) from origins (rows, d), m."""
    return extents(history, block, rows, axes) - np.einsum("nad,nd->na", axes, origins)


def has_ends(scene: Scene, block: BlockSpec) -> bool:
    """True if what carries a block has ends over which it may fall."""
    return scene.carrier_of(block) is not None or scene.foundation.top is not None


class _PlacedTop(NamedTuple):
    """A top that carries a block, over the rows."""

    top: Top
    origins: Array
    """The origin of its frame, (rows, d), m."""
    frames: Array
    """The axes of that frame as columns, (rows, d, d)."""


def _carriers(scene: Scene, history: Columns, block: BlockSpec) -> Iterator[_PlacedTop]:
    """Tops that carry a block."""
    for carrier in scene.carriers_of(block):
        axes, d = top_axes(history, carrier), scene.dimension
        centre = carrier.shape.centre_of_mass(d)
        origins = centres(history, carrier.name) - axes @ np.array(centre)
        yield _PlacedTop(top_of(carrier.shape, d), origins, axes)
    if scene.carrier_of(block) is None:
        yield from _foundation(scene, history)


def _foundation(scene: Scene, history: Columns) -> Iterator[_PlacedTop]:
    """The top of a foundation that has ends."""
    assert scene.foundation.top is not None
    dimension = scene.dimension
    half = tuple(side / 2 for side in scene.foundation.top[: dimension - 1])
    origins = platform_drift(history, dimension)
    frames = np.eye(dimension)[None].repeat(len(origins), axis=0)
    yield _PlacedTop(Top.rectangle(half, 0.0), origins, frames)
