"""Functions on a mesh as arrays, as VTK wants them: what this rank knows, its own first."""

from __future__ import annotations

import numpy as np
from dolfinx import fem, plot

from solver.fields.cells import Cells, in_space
from solver.types import Array


def cells_of(space: fem.FunctionSpace) -> Cells:
    """The nodes of a function space and the cells over them."""
    topology = space.mesh.topology
    cells = topology.index_map(topology.dim)
    known = range(cells.size_local + cells.num_ghosts)
    connectivity, kinds, places = plot.vtk_mesh(space, known)
    per_cell = space.dofmap.dof_layout.num_dofs
    nodes = np.asarray(connectivity, dtype=np.int64).reshape(len(known), per_cell + 1)[:, 1:]
    return Cells(points=places, nodes=nodes, kind=int(kinds[0]) if len(kinds) else 0)


def owned_nodes(space: fem.FunctionSpace) -> int:
    """How many of the nodes belong to this rank."""
    return int(space.dofmap.index_map.size_local)


def owned_cells(space: fem.FunctionSpace) -> int:
    """How many of the cells belong to this rank."""
    topology = space.mesh.topology
    return int(topology.index_map(topology.dim).size_local)


def at_nodes(function: fem.Function) -> Array:
    """Values at the nodes, (n,), or vectors, (n, 3); new."""
    size = function.function_space.dofmap.index_map_bs
    values = function.x.array
    return values.copy() if size == 1 else in_space(values.reshape(-1, size))


def in_cells(function: fem.Function) -> Array:
    """Values of a function that is constant in each cell, (cells,) or (cells, components); new."""
    dofmap = function.function_space.dofmap
    size = dofmap.index_map_bs
    values: Array = function.x.array.reshape(-1, size)[dofmap.list[:, 0]]
    return values[:, 0] if size == 1 else values
