"""Fields of a meshed body on their way into the one file: gathered from all ranks."""

from __future__ import annotations

import numpy as np
from dolfinx import fem

from solver.fields.body_functions import BodyFunctions
from solver.fields.cells import Cells
from solver.fields.function_arrays import cells_of, owned_cells, owned_nodes
from solver.fields.hdf_file import HdfBody, HdfFile
from solver.types import Array, Indices


class HdfFieldWriter:
    """Writes the fields of one meshed body; every rank calls every method.

    Nodes and cells stand in the order of their global numbers, those of each rank once.
    """

    def __init__(self, file: HdfFile | None, name: str, functions: BodyFunctions):
        """Gather the mesh; the file is None on all ranks but the first."""
        self._functions, self._comm = functions, functions.mesh.comm
        cells = gathered_cells(functions.space)
        self._nodes, self._cells = owned_nodes(functions.space), owned_cells(functions.space)
        self._body: HdfBody | None = None
        if file is not None and cells is not None:
            self._body = file.body(name, cells)

    def write(self, time: float) -> None:
        """Write the fields as they are."""
        self._functions.fill()
        nodal, means = self._functions.arrays()
        nodal = {name: self._whole(known[: self._nodes]) for name, known in nodal.items()}
        means = {name: self._whole(known[: self._cells]) for name, known in means.items()}
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
    known, index_map = cells_of(space), space.dofmap.index_map
    nodes = np.ascontiguousarray(known.nodes[: owned_cells(space)], dtype=np.int32)
    whole: Indices = index_map.local_to_global(nodes.ravel())
    own = whole.reshape(nodes.shape), known.points[: owned_nodes(space)], known.kind
    parts = space.mesh.comm.gather(own, root=0)
    if parts is None:
        return None
    nodes_of_all, points, kinds = zip(*parts, strict=True)
    return Cells(
        points=np.concatenate(points),
        nodes=np.concatenate(nodes_of_all).astype(np.int64),
        kind=max(kinds),  # 0 on ranks without a cell
    )
