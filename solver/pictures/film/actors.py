"""What moves in a film: bodies from the files of the fields, or boxes from the history."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from solver.fields.ground import platform_corners
from solver.pictures.film.contact import BlockFrames, block_poses
from solver.pictures.style import largest
from solver.pictures.surfaces import FieldFiles
from solver.results.runs import Run
from solver.scene import BlockSpec
from solver.types import Array

#: Faces of a hexahedron in VTK's order of its corners, outwards.
SIDES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))

#: Snapshots that the range of the colours is taken from.
SAMPLED = 25


class Bodies(Protocol):
    """The surfaces of all bodies, frame by frame."""

    names: list[str]
    """What they are called."""
    stress_limit: float
    """Stress that has the last colour, Pa; 0 where no body has any."""

    def at(self, frame: int) -> list[Any]:
        """Surface of each body as `pyvista.PolyData`, m, in the order of `names`."""


class Boxes:
    """Rigid blocks and the platform, from the history: exact at any time."""

    stress_limit = 0.0

    def __init__(self, run: Run, blocks: list[BlockFrames], drift: Array):
        """Take the motion of the blocks and the drift of the platform, m, (n, d)."""
        self._blocks, self._drift = blocks, drift
        self._corners = [np.array(b.shape.corners(run.scene.dimension)) for b in run.scene.blocks]
        self._platform = platform_corners(run.scene) if run.scene.has_platform else None
        self.names = [block.name for block in run.scene.blocks]
        self.names += ["platform"] if self._platform is not None else []

    def at(self, frame: int) -> list[Any]:
        """Boxes as they stand."""
        surfaces = []
        for corners, block in zip(self._corners, self._blocks, strict=True):
            arms = corners - np.eye(corners.shape[1])[-1] * block.half[-1]
            surfaces.append(_box(block.centres[frame] + arms @ block.frames[frame].T))
        if self._platform is not None:
            surfaces.append(_box(self._platform + self._drift[frame]))
        return surfaces


def _box(corners: Array) -> Any:
    """A box by its corners."""
    import pyvista

    if corners.shape[1] == 2:
        flat = np.pad(corners, ((0, 0), (0, 1)))
        return pyvista.PolyData(flat, faces=np.array([4, 0, 1, 2, 3]))
    return pyvista.PolyData(corners, faces=np.array([(4, *side) for side in SIDES]).ravel())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Poses:
    """The motion of a block as a rigid body, at several times."""

    centres: Array
    """Its centre of mass, m, (n, 3)."""
    frames: Array
    """Its axes as columns, (n, 3, 3)."""

    def own(self, index: int, places: Array) -> Array:
        """Places, m, (k, 3), as the block sees them."""
        return np.asarray((places - self.centres[index]) @ self.frames[index])

    def placed(self, index: int, own: Array) -> Array:
        """Where places of the block's own stand, m, (k, 3)."""
        return np.asarray(own @ self.frames[index].T + self.centres[index])


def _poses(run: Run, block: BlockSpec, times: Array) -> Poses:
    """The motion of a block at these times, s; of the plane in space."""
    centres, frames = block_poses(run, block, times)
    missing = 3 - centres.shape[1]
    turned = np.tile(np.eye(3), (len(times), 1, 1))
    turned[:, : frames.shape[1], : frames.shape[2]] = frames
    return Poses(centres=np.pad(centres, ((0, 0), (0, missing))), frames=turned)


class Fields:
    """Bodies from the files of the fields.

    Between two snapshots a block moves as the history says, and deforms evenly.
    """

    def __init__(self, run: Run, file: Path, times: Array):
        """Open the files of a run for frames at these times, s."""
        self._files, self._times = FieldFiles(file, run.scene.dimension), times
        self._read: dict[int, list[Any]] = {}
        self.names = self._files.names
        blocks = {block.name: block for block in run.scene.blocks}
        self._poses = [
            (_poses(run, blocks[name], self._files.times), _poses(run, blocks[name], times))
            if name in blocks
            else None
            for name in self._files.names
        ]
        last = len(self._files.times) - 1
        sampled = {int(k) for k in np.linspace(0, last, min(SAMPLED, last + 1))}
        found = [
            np.asarray(surface.cell_data["von_mises"])
            for index in sorted(sampled)
            for surface in self._files.read(index)
        ]
        everything = np.concatenate(found)
        self.stress_limit = float(np.quantile(everything, 0.98)) if largest(everything) else 0.0

    def at(self, frame: int) -> list[Any]:
        """Surfaces with their stress at the time of a frame."""
        written, time = self._files.times, self._times[frame]
        after = int(np.clip(np.searchsorted(written, time), 1, max(len(written) - 1, 1)))
        if len(written) == 1:
            return self._snapshot(0)
        before = after - 1
        part = float(np.clip((time - written[before]) / (written[after] - written[before]), 0, 1))
        first, second = self._snapshot(before), self._snapshot(after)
        poses = self._poses if len(self._poses) == len(first) else [None] * len(first)
        bodies = []
        for one, other, pose in zip(first, second, poses, strict=True):
            if one.n_points != other.n_points or one.n_cells != other.n_cells:
                # The ranks changed when the run was resumed.
                bodies.append(one if part < 0.5 else other)
                continue
            places = [np.asarray(one.points), np.asarray(other.points)]
            if pose is not None and time <= written[-1]:
                seen = [pose[0].own(k, x) for k, x in zip((before, after), places, strict=True)]
                moved = pose[1].placed(frame, (1 - part) * seen[0] + part * seen[1])
            else:
                moved = (1 - part) * places[0] + part * places[1]
            bodies.append(_mixed(one, other, part, moved))
        return bodies

    def _snapshot(self, index: int) -> list[Any]:
        """A snapshot; the last few stay in memory."""
        if index not in self._read:
            self._read = {k: v for k, v in self._read.items() if abs(k - index) <= 1}
            self._read[index] = self._files.read(index)
        return self._read[index]


def _mixed(first: Any, second: Any, part: float, places: Array) -> Any:
    """A body at these places, m, with stress between that of two snapshots."""
    mixed = first.copy()
    mixed.points = places
    stress = [np.asarray(surface.cell_data["von_mises"]) for surface in (first, second)]
    mixed.cell_data["von_mises"] = (1 - part) * stress[0] + part * stress[1]
    return mixed


def bodies_of(run: Run, blocks: list[BlockFrames], drift: Array, times: Array) -> Bodies:
    """The bodies of a run; what is meshed and has left no fields is drawn as rigid boxes."""
    if run.model == "finite elements" and run.fields is not None:
        return Fields(run, run.fields, times)
    return Boxes(run, blocks, drift)
