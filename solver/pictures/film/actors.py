"""What moves in a film: bodies from the files of the fields, or boxes from the history."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np

from solver.fields.ground import platform_corners
from solver.pictures.film.contact import BlockFrames
from solver.pictures.style import largest
from solver.pictures.surfaces import FieldFiles
from solver.results.runs import FIELDS, Run
from solver.types import Array

#: Faces of a hexahedron in VTK's order of its corners, outwards.
SIDES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))

#: Snapshots that the range of the colours is taken from.
SAMPLED = 25


class Bodies(Protocol):
    """The surfaces of all bodies, frame by frame."""

    stress_limit: float
    """Stress that has the last colour, Pa; 0 where no body has any."""

    def at(self, frame: int) -> list[Any]:
        """Surface of each body as `pyvista.PolyData`, m; blocks first, in their order."""


class Boxes:
    """Rigid blocks and the platform, from the history: exact at any time."""

    stress_limit = 0.0

    def __init__(self, run: Run, blocks: list[BlockFrames], drift: Array):
        """Take the motion of the blocks and the drift of the platform, m, (n, d)."""
        self._blocks, self._drift = blocks, drift
        self._corners = [np.array(b.shape.corners(run.scene.dimension)) for b in run.scene.blocks]
        self._platform = platform_corners(run.scene) if run.scene.has_platform else None

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


class Fields:
    """Bodies from the files of the fields, straight between two snapshots."""

    def __init__(self, file: Path, dimension: int, times: Array):
        """Open the files for frames at these times, s."""
        self._files, self._times = FieldFiles(file, dimension), times
        self._read: dict[int, list[Any]] = {}
        last = len(self._files.times) - 1
        sampled = {int(k) for k in np.linspace(0, last, min(SAMPLED, last + 1))}
        found = [
            np.asarray(surface.cell_data["von_mises"])
            for index in sorted(sampled)
            for surface in self._files.read(index)
            if surface.n_cells
        ]
        everything = np.concatenate(found)
        self.stress_limit = float(np.quantile(everything, 0.995)) if largest(everything) else 0.0

    def at(self, frame: int) -> list[Any]:
        """Surfaces with their stress at the time of a frame."""
        written, time = self._files.times, self._times[frame]
        after = int(np.clip(np.searchsorted(written, time), 1, max(len(written) - 1, 1)))
        if len(written) == 1:
            return self._snapshot(0)
        before = after - 1
        part = float(np.clip((time - written[before]) / (written[after] - written[before]), 0, 1))
        pairs = zip(self._snapshot(before), self._snapshot(after), strict=True)
        return [_between(first, second, part) for first, second in pairs]

    def _snapshot(self, index: int) -> list[Any]:
        """A snapshot; the last few stay in memory."""
        if index not in self._read:
            self._read = {k: v for k, v in self._read.items() if abs(k - index) <= 1}
            self._read[index] = self._files.read(index)
        return self._read[index]


def _between(first: Any, second: Any, part: float) -> Any:
    """A body between two snapshots: `part` is 0 at the first, 1 at the second."""
    if first.n_points != second.n_points or first.n_cells != second.n_cells:
        return first if part < 0.5 else second  # ranks changed when the run was resumed
    between = first.copy()
    between.points = (1 - part) * np.asarray(first.points) + part * np.asarray(second.points)
    stress = [np.asarray(surface.cell_data["von_mises"]) for surface in (first, second)]
    between.cell_data["von_mises"] = (1 - part) * stress[0] + part * stress[1]
    return between


def bodies_of(run: Run, blocks: list[BlockFrames], drift: Array, times: Array) -> Bodies:
    """The bodies of a run; what is meshed and has left no fields is drawn as rigid boxes."""
    fields = run.folder / FIELDS
    meshed = run.model == "finite elements"
    if meshed and fields.is_file():
        return Fields(fields, run.scene.dimension, times)
    return Boxes(run, blocks, drift)
