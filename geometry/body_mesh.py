"""Meshes of bodies that are no boxes and not convex: of parts, of a closed surface, of files.

All of them are made by Gmsh on one rank as plain cells, whose outside gets the tags of the faces
that contact sees, and are then distributed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from mpi4py import MPI

import gmsh
import numpy as np

from geometry.body_faces import BodyFaces, faces_on_mesh
from geometry.cells import Cells, cells_of_model
from geometry.convex import Convex
from geometry.gmsh_model import MeshedBody, convex_body, make
from geometry.gmsh_session import failures, options, silent_model
from geometry.surface import Surface
from geometry.tags import ALL_CELLS, FINER
from solver.types import Indices

SHARP = 40.0
"""Angle between facets of a surface, degrees, from which the edge between them stays an edge."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyMesh:
    """The mesh of a body, and the faces of it that contact sees."""

    made: MeshedBody
    """The mesh; tags of facets are those of the faces."""
    faces: tuple[BodyFaces, ...]
    """Faces of its convex hull, then faces of its parts, in the frame of the mesh."""


def body_mesh(
    name: str,
    build: Callable[[], Cells],
    dimension: int,
    parts: Sequence[Convex] = (),
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> BodyMesh:
    """Distribute the cells that `build` makes on rank 0; collective.

    Args:
        name: Of the body.
        build: Makes its cells.
        dimension: 2 or 3.
        parts: The convex parts it is made of; none where they are not known.
        comm: The ranks that share the mesh.

    Raises:
        ValueError: On every rank: there is no mesh of it, or not of one piece.
    """
    put, faces, trouble = _nothing, list[BodyFaces](), ""
    if comm.rank == 0:
        try:
            cells = build()
            _refuse_pieces(cells)
            faces, tags = faces_on_mesh(cells.points, cells.boundary, parts)
            put = partial(_put, cells, tags)
        except ValueError as error:
            trouble = str(error)
    trouble, faces = comm.bcast((trouble, faces))
    if trouble:
        raise ValueError(trouble)
    made = make(name, put, dimension, comm)
    return BodyMesh(made=made, faces=tuple(faces))


def _nothing() -> None:
    """Make no mesh: another rank does."""


def _put(cells: Cells, tags: Indices) -> None:
    """Cells and the facets of their boundary as discrete entities of Gmsh's current model."""
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


def _refuse_pieces(cells: Cells) -> None:
    """ValueError where cells do not hang together by their facets."""
    if cells.pieces > 1:
        raise ValueError(
            f"got {cells.pieces} pieces that have no face in common, allowed one body: elastic"
            " parts hold together where their faces touch"
        )


# ---------------------------------------------------------------- of convex parts


def cells_of_parts(parts: Sequence[Convex], size: float) -> Cells:
    """Simplices of convex parts that touch; where two do, their cells have facets in common.

    Args:
        parts: The parts.
        size: Length of the edges of the cells, m.
    """
    d = parts[0].dimension
    with silent_model("parts"), failures("got parts that Gmsh cannot mesh ({})"):
        bodies = [(d, convex_body(gmsh.model.occ, part)[0]) for part in parts]
        if len(bodies) > 1:
            gmsh.model.occ.fragment(bodies[:1], bodies[1:])
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.setSize(gmsh.model.getEntities(0), size)
        gmsh.model.mesh.generate(d)
        return cells_of_model(d)


# ---------------------------------------------------------------- of a surface


def cells_of_surface(surface: Surface, size: float) -> Cells:
    """Tetrahedra within a closed surface, whose facets are made anew from its own.

    Between its sharp edges the surface is parametrised (Gmsh's discrete geometry); sharp edges keep
    their own corners where these are not much nearer to one another than `size`.

    Args:
        surface: The surface.
        size: Length of the edges of the cells, m.
    """
    if surface.bodies > 1:
        raise ValueError(f"got {surface.bodies} bodies apart, allowed one")
    with silent_model("surface"), failures("got a surface that Gmsh cannot mesh ({})"):
        whole = gmsh.model.addDiscreteEntity(2)
        used = np.unique(surface.triangles)
        gmsh.model.mesh.addNodes(2, whole, used + 1, surface.points[used].ravel())
        gmsh.model.mesh.addElementsByType(whole, 2, [], surface.triangles.ravel() + 1)
        gmsh.model.mesh.classifySurfaces(math.radians(SHARP), True, True, math.pi)
        own = {line: (_edges(line), _length(line)) for _, line in gmsh.model.getEntities(1)}
        gmsh.model.mesh.createGeometry()
        faces = [number for _, number in gmsh.model.getEntities(2)]
        gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop(faces)])
        gmsh.model.geo.synchronize()  # forgets what is said of curves before it
        for line, (count, length) in own.items():
            coarse = max(1, math.ceil(length / size - 1e-9))
            gmsh.model.mesh.setTransfiniteCurve(line, 1 + min(max(count, coarse), FINER * coarse))
        with options({"Mesh.MeshSizeMax": size, "Mesh.MeshSizeExtendFromBoundary": 0}):
            gmsh.model.mesh.generate(3)
        return cells_of_model(3)


def _edges(line: int) -> int:
    """Number of the edges of a discrete curve."""
    _, numbers, _ = gmsh.model.mesh.getElements(1, line)
    return sum(map(len, numbers))


def _length(line: int) -> float:
    """Length of a discrete curve, m."""
    _, _, nodes = gmsh.model.mesh.getElements(1, line)
    total = 0.0
    for a, b in np.concatenate(nodes).reshape(-1, 2):
        first, second = (np.array(gmsh.model.mesh.getNode(int(node))[0]) for node in (a, b))
        total += float(np.linalg.norm(second - first))
    return total
