"""Fields of a run for ParaView: those at the nodes of a body as they are given, and its stress.

The mesh in the files is the undeformed block in its own frame; mesh + displacement is the place in
the ground frame, so "warp by vector" with factor 1 shows the block as it stands.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from solver.bodies.elastic_forms import green_strain
from solver.fields.function_arrays import at_nodes, cells_of, in_cells, owned_cells, owned_nodes
from solver.fields.piece import COPIES, PieceWriter, Values, write_parts
from solver.fields.pvd import PvdIndex, entry_of, write_index
from solver.parallel import any_rank
from solver.scene.material import Material


def cauchy_stress(displacement: fem.Function, material: Material) -> Any:
    """The Cauchy stress F S F^T / det F, with S of St. Venant-Kirchhoff, in UFL, (3, 3), Pa.

    In plane strain it has the out-of-plane part lambda tr(E) / det F; in plane stress none.
    """
    mesh, gradient = displacement.function_space.mesh, ufl.grad(displacement)
    # Constants: what is compiled serves all materials.
    lame, shear = (fem.Constant(mesh, value) for value in (material.lame, material.shear))
    dimension = mesh.geometry.dim
    identity = ufl.Identity(dimension)
    strain = green_strain(gradient)
    second = lame * ufl.tr(strain) * identity + 2 * shear * strain
    deformation = identity + gradient
    volume = ufl.det(deformation)
    cauchy = deformation * second * deformation.T / volume
    if dimension == 3:
        return cauchy
    across = lame * ufl.tr(strain) / volume if material.plane == "strain" else 0
    rows = [[cauchy[0, 0], cauchy[0, 1], 0], [cauchy[1, 0], cauchy[1, 1], 0], [0, 0, across]]
    return ufl.as_tensor(rows)


def von_mises_stress(cauchy: Any) -> Any:
    """The von Mises stress sqrt(3/2 s : s), s the deviator of the Cauchy stress, in UFL, Pa."""
    deviator = cauchy - ufl.tr(cauchy) / 3 * ufl.Identity(3)
    return ufl.sqrt(1.5 * ufl.inner(deviator, deviator))


class CellMean:
    """The mean of an expression over each cell of a mesh, as a function that files can hold."""

    def __init__(
        self, name: str, expression: Any, mesh: Any, *, times: float, rule: Mapping[str, int]
    ):
        """Compile the integral; `times` is what the expression is to be divided by."""
        shape = expression.ufl_shape
        space = fem.functionspace(mesh, ("DG", 0, shape) if shape else ("DG", 0))
        self.function = fem.Function(space, name=name)
        test, dx = ufl.TestFunction(space), ufl.dx(metadata=dict(rule))
        self._integral = fem.form(ufl.inner(expression, test) * dx)
        each = ufl.TestFunction(fem.functionspace(mesh, ("DG", 0)))
        volume = times * fem.assemble_vector(fem.form(each * ufl.dx(domain=mesh))).array
        self._owned = space.dofmap.index_map.size_local * space.dofmap.index_map_bs
        self._volume = np.repeat(volume, space.dofmap.index_map_bs)[: self._owned]

    def fill(self) -> None:
        """Let the function be the mean of the expression as it is; collective."""
        integral = fem.assemble_vector(self._integral).array
        self.function.x.array[: self._owned] = integral[: self._owned] / self._volume


class BodyFunctions:
    """The fields of a meshed body as functions: those at the nodes as given, and its stress."""

    def __init__(
        self, nodal: Mapping[str, fem.Function], material: Material | None, thickness: float = 1.0
    ):
        """Take the functions at the nodes, all of one degree, by the names of their fields.

        Their `displacement` (m) is place in the ground frame minus mesh position. The thickness (m)
        is what stresses of the material are times; no material: no stress.
        """
        displacement = nodal["displacement"]
        self.space = displacement.function_space
        self.mesh = self.space.mesh
        self.nodal = list(nodal.values())
        for field, function in nodal.items():
            function.name = field
        self.means: list[CellMean] = []
        if material is not None:
            degree = self.space.element.basix_element.degree
            stress, rule = cauchy_stress(displacement, material), {"quadrature_degree": 2 * degree}
            named = {"von_mises": von_mises_stress(stress), "stress": stress}
            self.means = [
                CellMean(name, each, self.mesh, times=thickness, rule=rule)
                for name, each in named.items()
            ]

    @property
    def all(self) -> list[fem.Function]:
        """Every function, in the order in which files list them."""
        return [*self.nodal, *(mean.function for mean in self.means)]

    def arrays(self) -> tuple[dict[str, Values], dict[str, Values]]:
        """Values at the nodes and in the cells that this rank knows, by the names of the fields."""
        nodal: dict[str, Values] = {each.name: at_nodes(each) for each in self.nodal}
        means: dict[str, Values] = {
            mean.function.name: in_cells(mean.function) for mean in self.means
        }
        return nodal, means

    def fill(self) -> None:
        """Let the stress be that of the displacement as it is; collective."""
        for mean in self.means:
            mean.fill()


class FieldWriter:
    """Writes the pieces of one body and lists them in the index; every rank calls every method.

    The functions are written as they are at the time of the call. The stress is the mean over each
    cell; the other fields have the degree of the displacement.
    """

    def __init__(
        self,
        file: Path,
        functions: BodyFunctions,
        *,
        index: PvdIndex | None = None,
        part: int = 0,
        name: str = "",
    ):
        """Prepare what does not change.

        The file gives the pieces their names: `fields_NAME.pvd` makes `fields_NAME000000.vtu`. On
        several ranks each has a piece of its own, and `fields_NAME000000.pvtu` opens all of them.
        When the writer is closed the file lists them, too: the body alone. The index lists the
        pieces of all bodies as they are written, by number and name of the body; None: `file` does.
        """
        self._functions, self._comm = functions, functions.mesh.comm
        self._file, self._folder, self._stem, self._count = file, file.parent, file.stem, 0
        self._index = PvdIndex(file, writes=self._comm.rank == 0) if index is None else index
        self._part, self._name, self._way = part, name, self._index.way_to(file.parent)
        self._alone: list[bytes] | None = None if index is None else []
        """What the file is to list."""
        self._piece = PieceWriter(cells_of(functions.space))
        self._copies = None if self._comm.size == 1 else copies_of(functions.space)

    def write(self, time: float) -> None:
        """Write the fields at a time (s).

        An OSError is raised where it happens, after all that ranks do together.
        """
        functions, comm = self._functions, self._comm
        functions.fill()
        for function in functions.all:
            function.x.scatter_forward()
        number, self._count = self._count, self._count + 1  # whatever follows
        trouble = None
        try:
            self._write_piece(number)
        except OSError as error:
            trouble = error
        # Ranks may be killed at any time: what is listed has been written by all of them.
        complete = not any_rank(comm, trouble is not None)
        if trouble is not None:
            raise trouble
        if complete and comm.rank == 0:
            self._list(time, number)

    def _write_piece(self, number: int) -> None:
        """Write the piece of this rank, and on the first of several what opens all pieces."""
        nodal, means = self._functions.arrays()
        if self._copies is None:
            self._piece.write(self._folder / f"{self._stem}{number:06d}.vtu", nodal, means)
            return
        nodal[COPIES], means[COPIES] = self._copies
        parts = [f"{self._stem}_p{rank}_{number:06d}.vtu" for rank in range(self._comm.size)]
        self._piece.write(self._folder / parts[self._comm.rank], nodal, means)
        if self._comm.rank == 0:
            write_parts(self._folder / f"{self._stem}{number:06d}.pvtu", parts, nodal, means)

    def _list(self, time: float, number: int) -> None:
        """List a snapshot."""
        piece = f"{self._stem}{number:06d}.{'vtu' if self._copies is None else 'pvtu'}"
        self._index.add(time, self._way + piece, self._part, self._name)
        if self._alone is not None:
            self._alone.append(entry_of(time, piece))

    def close(self) -> None:
        """Finish the files."""
        if self._alone is not None and self._comm.rank == 0:
            write_index(self._file, self._alone)


def copies_of(space: fem.FunctionSpace) -> tuple[Values, Values]:
    """Which of the nodes and cells that a rank knows are copies of another's: 1, else 0."""
    known = cells_of(space)
    nodes = np.zeros(len(known.points), dtype=np.uint8)
    cells = np.zeros(len(known.nodes), dtype=np.uint8)
    nodes[owned_nodes(space) :] = cells[owned_cells(space) :] = 1
    return nodes, cells
