"""Differences between dolfinx 0.9, 0.10 and 0.11: Gmsh models and the geometry of meshes."""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any

from mpi4py import MPI

import numpy as np
from dolfinx.mesh import GhostMode, Mesh, MeshTags, create_cell_partitioner
from numpy.typing import NDArray

# dolfinx.io.gmshio became dolfinx.io.gmsh in 0.10.
_newer = importlib.util.find_spec("dolfinx.io.gmsh") is not None
_reader: Any = importlib.import_module("dolfinx.io.gmsh" if _newer else "dolfinx.io.gmshio")


def model_to_mesh(
    model: Any, comm: MPI.Intracomm, dimension: int
) -> tuple[Mesh, MeshTags, MeshTags]:
    """Distribute the Gmsh model of rank 0, with the cells across a facet known to both sides.

    Returns:
        Mesh, cell tags and facet tags.
    """
    partitioner = _shared_facets()
    # 0.9 returns a tuple of these three, 0.10 a named tuple that begins with them.
    data = _reader.model_to_mesh(model, comm, 0, gdim=dimension, partitioner=partitioner)
    return data[0], data[1], data[2]


def _shared_facets() -> Any:
    """The partitioner that gives each rank the cells across its facets."""
    # 0.11 requires in addition the largest number of cells that a facet joins.
    dispatched = hasattr(create_cell_partitioner, "dispatch")
    return create_cell_partitioner(GhostMode.shared_facet, *((2,) if dispatched else ()))


def geometry_nodes(domain: Any) -> NDArray[np.int32]:
    """Numbers of the geometry's nodes of each cell of a mesh, (cells, k)."""
    found = getattr(domain.geometry, "dofmaps", None)  # since 0.11, which has several kinds of cell
    return domain.geometry.dofmap if found is None else found[0]


def geometry_degree(domain: Any) -> int:
    """Degree of the map from the reference cell to the cells of a mesh."""
    found = getattr(domain.geometry, "cmaps", None)
    return int((domain.geometry.cmap if found is None else found[0]).degree)
