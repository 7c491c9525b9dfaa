"""Surfaces of the bodies of a run: from the files of the fields, or rigid ones by the history."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias
from xml.etree import ElementTree as ET

import numpy as np

from geometry.block import FACES
from geometry.skin import skin_of
from solver.fields.ground import platform_corners
from solver.fields.part import in_space
from solver.pictures.contact import block_poses, drift_at
from solver.pictures.style import largest
from solver.results.runs import Run
from solver.scene import BlockSpec, Scene
from solver.scene.names import CONTACTS, LINKS
from solver.types import Array

#: Snapshots that the range of the colours of a film is taken from.
SAMPLED = 25

#: What a surface says of its edges: their ends, two by two, and the normals of faces beside them.
EDGES, EDGE_NORMALS = "edges", "edge_normals"

#: And the cosine of the angle between these from which on an edge in space is drawn.
SHARP = "sharp"

#: That angle, of shapes and of surfaces of triangles: what bends less is round, degrees.
BENDS, BENDS_OF_SURFACE = 28.0, 45.0


class FieldFiles:
    """The bodies in the files that `fields.pvd` lists, by their times."""

    def __init__(self, file: Path):
        """Read the index; a time that a killed run left without some of the bodies is none."""
        import pyvista

        self._reader = pyvista.get_reader(str(file))
        entries = list(ET.parse(file).iter("DataSet"))
        listed = [entry.get("timestep") for entry in entries]
        whole = [float(t or 0) for t in set(listed) if listed.count(t) == listed.count(listed[0])]
        self.times: Array = np.array(sorted(whole))
        """s."""
        names = [e.get("name", "") for e in entries if e.get("timestep") == listed[0]]
        self._numbers = [k for k, name in enumerate(names) if name not in (LINKS, CONTACTS)]
        self.names = [names[k] for k in self._numbers]
        """Names of the bodies, in their order; empty where the file has none. Links and forces
        are drawn by the history."""

    def read(self, index: int) -> list[Any]:
        """Surface of each body at one of the times, as `pyvista.PolyData`, in their order.

        Points are where the bodies stand, m; faces of meshed bodies have the von Mises stress of
        their cells (`von_mises`, Pa).
        """
        self._reader.set_active_time_value(self.times[index])
        grids = self._reader.read()
        return [_surface(grids[k]) for k in self._numbers]

    def nearest(self, times: Sequence[float]) -> list[int]:
        """The snapshots nearest to some times, each once, by their numbers."""
        return sorted({int(np.argmin(np.abs(self.times - time))) for time in times})


def _surface(grid: Any) -> Any:
    """The outer faces of a body in space, the cells of one in the plane, by their corners."""
    import pyvista
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    # VTK's own filter: pyvista's changes its defaults from version to version.
    skin = vtkDataSetSurfaceFilter()
    skin.SetInputData(grid)
    skin.SetNonlinearSubdivisionLevel(0)
    skin.Update()
    surface = pyvista.wrap(skin.GetOutput())
    surface.points = np.asarray(surface.points) + np.asarray(surface.point_data["displacement"])
    return surface


def stress_of(surface: Any) -> Array:
    """The von Mises stress of the faces of a surface, Pa; zero on rigid bodies."""
    known = surface.cell_data.get("von_mises", np.zeros(surface.n_cells))
    return np.asarray(known, dtype=float)


def polygons(surface: Any) -> list[Array]:
    """Corners of each face of a surface, m, (k, 3)."""
    import pyvista

    polys = surface.GetPolys()
    offsets = pyvista.convert_array(polys.GetOffsetsArray())
    corners = pyvista.convert_array(polys.GetConnectivityArray())
    return np.split(np.asarray(surface.points)[corners], offsets[1:-1])


class RigidShape:
    """A rigid block as it is drawn: its skin, about the middle of the box around it."""

    def __init__(self, block: BlockSpec, dimension: int):
        """Take its shape."""
        skin = skin_of(block.shape, dimension)
        middle = np.array(block.shape.middle(dimension))
        self._corners, self._edges = skin.corners - middle, skin.edges - middle
        self._faces = np.concatenate([[len(loop), *loop] for loop in skin.faces])
        self._normals = skin.normals
        solid = block.shape.solid
        rough = solid is not None and solid.surface is not None
        self._sharp = math.cos(math.radians(BENDS_OF_SURFACE if rough else BENDS))

    def at(self, centre: Array, frame: Array) -> Any:
        """It as it stands, `pyvista.PolyData`, m, by its middle, (d,), and its axes as columns.

        Its edges are beside it: the ends of each, `edges`, m, and the normals of the faces that
        meet there, `edge_normals`; in space those are drawn that bend by `sharp`.
        """
        import pyvista

        d = self._corners.shape[1]
        surface = pyvista.PolyData(
            in_space(centre[:d] + self._corners @ frame[:d, :d].T), faces=self._faces
        )
        edges = (centre[:d] + self._edges @ frame[:d, :d].T).reshape(-1, d)
        surface.field_data[EDGES] = in_space(edges)
        normals = (self._normals @ frame[:d, :d].T).reshape(-1, d)
        surface.field_data[EDGE_NORMALS] = in_space(normals)
        surface.field_data[SHARP] = [self._sharp]
        return surface


def rigid_shapes(scene: Scene) -> dict[str, RigidShape]:
    """The rigid blocks of a scene as they are drawn, by name."""
    blocks = (block for block in scene.blocks if block.model == "rigid")
    return {block.name: RigidShape(block, scene.dimension) for block in blocks}


class RigidBodies:
    """Rigid blocks and the platform, from the history: exact at any time."""

    stress_limit = 0.0
    """No body has any stress."""

    def __init__(self, run: Run, times: Array):
        """Take the motion of the blocks and of the platform in a run at some times, s."""
        blocks, d = run.scene.blocks, run.scene.dimension
        self._shapes = [RigidShape(block, d) for block in blocks]
        self._poses = [block_poses(run, block, times) for block in blocks]
        self._platform = platform_corners(run.scene) if run.scene.has_platform else None
        self._drift = drift_at(run, times)
        self.names = [block.name for block in blocks]
        self.names += ["platform"] if self._platform is not None else []

    def at(self, frame: int) -> list[Any]:
        """All as they stand."""
        surfaces = [
            shape.at(centres[frame], frames[frame])
            for shape, (centres, frames) in zip(self._shapes, self._poses, strict=True)
        ]
        if self._platform is not None:
            surfaces.append(_box(self._platform + self._drift[frame]))
        return surfaces


def _box(corners: Array) -> Any:
    """A box by its corners."""
    import pyvista

    faces = FACES if corners.shape[1] == 3 else ((0, 1, 2, 3),)
    return pyvista.PolyData(
        in_space(corners), faces=np.concatenate([[len(face), *face] for face in faces])
    )


class DeformedBodies:
    """Bodies from the files of the fields.

    Between two snapshots a block moves as the history says, and deforms evenly.
    """

    def __init__(self, run: Run, file: Path, times: Array):
        """Open the files of a run for frames at these times, s."""
        self._files, self._times = FieldFiles(file), times
        self._read: dict[int, list[Any]] = {}
        self.names, self._shapes = self._files.names, rigid_shapes(run.scene)
        blocks = {block.name: block for block in run.scene.blocks}
        both = np.concatenate([self._files.times, times])
        self._poses = [_poses(run, blocks.get(name), both) for name in self.names]

    @property
    def stress_limit(self) -> float:
        """Stress that has the last colour, Pa, by some of the snapshots."""
        last = len(self._files.times) - 1
        sampled = {int(k) for k in np.linspace(0, last, min(SAMPLED, last + 1))}
        found = [stress_of(s) for index in sorted(sampled) for s in self._files.read(index)]
        everything = np.concatenate(found)
        return float(np.quantile(everything, 0.98)) if largest(everything) else 0.0

    def at(self, frame: int) -> list[Any]:
        """Surfaces with their stress at the time of a frame."""
        written, time = self._files.times, self._times[frame]
        after = min(int(np.searchsorted(written, time)), len(written) - 1)
        before = max(after - 1, 0)
        step = written[after] - written[before]
        part = float(np.clip((time - written[before]) / step, 0, 1)) if step else 1.0
        now = len(written) + frame if time <= written[-1] else after
        bodies = []
        for name, first, second, (centres, frames) in zip(
            self.names, self._snapshot(before), self._snapshot(after), self._poses, strict=True
        ):
            if name in self._shapes:
                bodies.append(self._shapes[name].at(centres[now], frames[now]))
                continue
            old, new = (
                (np.asarray(surface.points) - centres[k]) @ frames[k]
                for k, surface in ((before, first), (after, second))
            )
            moved = second.copy()
            moved.points = ((1 - part) * old + part * new) @ frames[now].T + centres[now]
            if "von_mises" in second.cell_data:
                stress = (1 - part) * stress_of(first) + part * stress_of(second)
                moved.cell_data["von_mises"] = stress
            bodies.append(moved)
        return bodies

    def _snapshot(self, index: int) -> list[Any]:
        """A snapshot; the last few stay in memory."""
        if index not in self._read:
            self._read = {k: v for k, v in self._read.items() if abs(k - index) <= 1}
            self._read[index] = self._files.read(index)
        return self._read[index]


def _poses(run: Run, block: BlockSpec | None, times: Array) -> tuple[Array, Array]:
    """Centre, m, (n, 3), and axes as columns, (n, 3, 3), of a block at some times, s.

    Those of the ground for what is no block.
    """
    centres, turned = np.zeros((len(times), 3)), np.tile(np.eye(3), (len(times), 1, 1))
    if block is not None:
        own, frames = block_poses(run, block, times)
        d = own.shape[1]
        centres[:, :d], turned[:, :d, :d] = own, frames
    return centres, turned


Bodies: TypeAlias = RigidBodies | DeformedBodies
"""The surfaces of all bodies, frame by frame."""


def bodies_of(run: Run, times: Array) -> Bodies:
    """The bodies of a run at some times, s; what is meshed without fields is drawn as rigid."""
    if run.model == "finite elements" and run.fields is not None:
        return DeformedBodies(run, run.fields, times)
    return RigidBodies(run, times)
