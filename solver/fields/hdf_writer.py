"""Fields of a meshed body on their way into the one file: gathered from all ranks."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import fem, plot

from solver.fields.hdf_file import Cells, HdfBody, HdfFile
from solver.fields.writer import BodyFunctions
from solver.types import Array, Indices


class HdfFieldWriter:
    """Writes the fields of one meshed body; every rank calls every method.

    Nodes and cells stand in the order of their global numbers, those of each rank once.
    """

    def __init__(self, file: HdfFile | None, name: str, functions: BodyFunctions):
        """Gather the mesh; the file is None on all ranks but the first."""
        self._functions, self._comm = functions, functions.mesh.comm
        cells = gathered_cells(functions.space)
        self._body: HdfBody | None = None
        if file is not None and cells is not None:
            self._body = file.body(name, cells)

    def write(self, time: float) -> None:
        """Write the fields as they are."""
        self._functions.fill()
        fields = self._functions
        nodal = {f.name: self._whole(_of_nodes(f)) for f in fields.nodal}
        means = {mean.function.name: self._whole(_of_cells(mean.function)) for mean in fields.means}
        if self._body is not None:
            self._body.write(nodal, means)

    def _whole(self, own: Array) -> Array:
        """An array of all ranks on the first one, one behind the other; its own on others."""
        parts = self._comm.gather(own, root=0)
        return own if parts is None else np.concatenate(parts)

    def close(self) -> None:
        """The file is closed by who opened it."""


def gathered_cells(space: fem.FunctionSpace) -> Cells | None:
    """The nodes of a function space and the cells over them; None on all ranks but the first."""
    topology, kinds, places = plot.vtk_mesh(space)
    per_cell = int(topology[0]) if len(topology) else space.dofmap.dof_layout.num_dofs
    nodes = np.asarray(topology, dtype=np.int32).reshape(-1, per_cell + 1)[:, 1:]
    index_map = space.dofmap.index_map
    whole: Indices = index_map.local_to_global(np.ascontiguousarray(nodes).ravel())
    own = whole.reshape(nodes.shape), places[: index_map.size_local], [int(k) for k in kinds[:1]]
    parts = space.mesh.comm.gather(own, root=0)
    if parts is None:
        return None
    return Cells(
        points=np.concatenate([part[1] for part in parts]),
        nodes=np.concatenate([part[0] for part in parts]).astype(np.int64),
        kind=next(kind for part in parts for kind in part[2]),
    )


def _of_nodes(function: fem.Function) -> Array:
    """Values at the nodes of this rank, (n,), or vectors, which VTK wants to be three, (n, 3)."""
    size = function.function_space.dofmap.index_map_bs
    own = function.function_space.dofmap.index_map.size_local
    values = function.x.array[: own * size]
    if size == 1:
        return values.copy()
    return np.pad(values.reshape(-1, size), ((0, 0), (0, 3 - size)))


def _of_cells(function: fem.Function) -> Array:
    """Values of the cells of this rank in their order, (cells,) or (cells, 9)."""
    space: Any = function.function_space
    own = space.mesh.topology.index_map(space.mesh.topology.dim).size_local
    size = space.dofmap.index_map_bs
    values = function.x.array.reshape(-1, size)[space.dofmap.list[:own, 0]]
    return np.asarray(values[:, 0] if size == 1 else values)
