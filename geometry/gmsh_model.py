"""Gmsh models: made on rank 0, and distributed by dolfinx."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any

from mpi4py import MPI

import gmsh
import numpy as np
from dolfinx.mesh import Mesh, MeshTags

from geometry.cells import Cells
from geometry.compat import model_to_mesh
from geometry.convex import Convex
from geometry.gmsh_session import silent_model
from geometry.polygon import around
from geometry.tags import ALL_CELLS
from solver.types import Indices


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshedBody:
    """The mesh of a body in the body's own frame."""

    mesh: Mesh
    facet_tags: MeshTags
    """Values of `FacetTag`, on all of the boundary."""


def make(name: str, build: Callable[[], None], dimension: int, comm: MPI.Intracomm) -> MeshedBody:
    """The mesh that `build` makes in a new Gmsh model, called on rank 0; collective."""
    with silent_model(name) if comm.rank == 0 else nullcontext():
        if comm.rank == 0:
            build()
        mesh, _, facet_tags = model_to_mesh(gmsh.model, comm, dimension)
    return MeshedBody(mesh=mesh, facet_tags=facet_tags)


def put(cells: Cells, tags: Indices) -> None:
    """Cells, and the facets of their boundary with tags, into Gmsh's current model."""
    d, model = cells.dimension, gmsh.model
    used = np.unique(cells.numbers)
    body = model.addDiscreteEntity(d)
    places = np.pad(cells.points[used], ((0, 0), (0, 3 - d)))
    model.mesh.addNodes(d, body, used + 1, places.ravel())
    model.mesh.addElementsByType(body, cells.kind, [], cells.numbers.ravel() + 1)
    model.addPhysicalGroup(d, [body], ALL_CELLS)
    for tag in np.unique(tags):
        face = model.addDiscreteEntity(d - 1)
        facets = cells.boundary[tags == tag]
        model.mesh.addElementsByType(face, cells.kind_of_facets, [], facets.ravel() + 1)
        model.addPhysicalGroup(d - 1, [face], int(tag))


def convex_body(kernel: Any, part: Convex) -> int:
    """The number of a convex polygon or polyhedron that is made in the current Gmsh model.

    In a kernel of it, `gmsh.model.geo` or `gmsh.model.occ`.
    """
    places = np.pad(part.corners, ((0, 0), (0, 3 - part.dimension)))
    points = [kernel.addPoint(*place) for place in places]
    lines: dict[tuple[int, int], int] = {}

    def line(a: int, b: int) -> int:
        """The line from one corner to another; negative where it is there the other way round.

        Not for OpenCASCADE, which turns lines round by itself.
        """
        if (b, a) in lines:
            return lines[b, a] if kernel is gmsh.model.occ else -lines[b, a]
        return lines.setdefault((a, b), kernel.addLine(points[a], points[b]))

    if part.dimension == 2:
        return int(kernel.addPlaneSurface([kernel.addCurveLoop([line(*f) for f in part.faces])]))
    sides = [
        kernel.addPlaneSurface([kernel.addCurveLoop([line(*ends) for ends in around(face)])])
        for face in part.faces
    ]
    return int(kernel.addVolume([kernel.addSurfaceLoop(sides)]))
