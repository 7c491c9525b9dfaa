"""The fields of a meshed body as functions on its mesh, and as arrays in VTK's form."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mpi4py import MPI

import numpy as np
import ufl
from dolfinx import fem, plot

from solver.bodies.elastic_forms import Moduli, green_strain
from solver.fields.part import Part, Values, in_space
from solver.types import Array


def cauchy_stress(
    displacement: fem.Function, moduli: Moduli, about: fem.Function | None = None
) -> Any:
    """The Cauchy stress F S F^T / det F, with S of St. Venant-Kirchhoff, in UFL, (3, 3), Pa.

    Of a body that is linear about a displacement, F and the derivative of E are those there: its
    rotations are small, but E would count their squares as strain. In plane strain it has the
    out-of-plane part lambda tr(E) / det F; in plane stress none.
    """
    gradient, (lame, shear, plane) = ufl.grad(displacement), moduli
    dimension = displacement.function_space.mesh.geometry.dim
    identity = ufl.Identity(dimension)
    strain = green_strain(gradient)
    if about is not None:
        change, gradient = gradient - ufl.grad(about), ufl.grad(about)
        strain = green_strain(gradient) + ufl.sym((identity + gradient).T * change)
    second = lame * ufl.tr(strain) * identity + 2 * shear * strain
    deformation = identity + gradient
    volume = ufl.det(deformation)
    cauchy = deformation * second * deformation.T / volume
    if dimension == 3:
        return cauchy
    across = lame * ufl.tr(strain) / volume if plane == "strain" else 0
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
        """Let the function be the mean of the expression as it is, on the rank's own cells."""
        integral = fem.assemble_vector(self._integral).array
        self.function.x.array[: self._owned] = integral[: self._owned] / self._volume


class BodyFunctions:
    """The fields of a meshed body as functions: those at the nodes as given, and its stress."""

    def __init__(
        self,
        nodal: Mapping[str, fem.Function],
        moduli: Moduli | None,
        thickness: float = 1.0,
        about: fem.Function | None = None,
    ):
        """Take the functions at the nodes, all of one degree, by the names of their fields.

        Their `displacement` (m) is place in the ground frame minus mesh position. The thickness (m)
        is what the moduli are times; without moduli there is no stress. A linear body is so about a
        displacement.
        """
        displacement = nodal["displacement"]
        self.space = displacement.function_space
        self.mesh = self.space.mesh
        self.nodal = list(nodal.values())
        for field, function in nodal.items():
            function.name = field
        self.means: list[CellMean] = []
        if moduli is not None:
            degree = self.space.element.basix_element.degree
            stress = cauchy_stress(displacement, moduli, about)
            rule = {"quadrature_degree": 2 * degree}
            named = {"von_mises": von_mises_stress(stress), "stress": stress}
            self.means = [
                CellMean(name, each, self.mesh, times=thickness, rule=rule)
                for name, each in named.items()
            ]

    def arrays(self) -> tuple[dict[str, Values], dict[str, Values]]:
        """Values at the nodes and in the cells that are this rank's own.

        They are named as the fields are; the stress is that of the displacement as it is.
        """
        for mean in self.means:
            mean.fill()
        nodal: dict[str, Values] = {each.name: at_nodes(each) for each in self.nodal}
        means: dict[str, Values] = {
            mean.function.name: in_cells(mean.function) for mean in self.means
        }
        return nodal, means


def part_of(space: fem.FunctionSpace) -> Part:
    """The nodes of a function space and the cells over them that are this rank's; collective."""
    topology, numbers = space.mesh.topology, space.dofmap.index_map
    cells = topology.index_map(topology.dim).size_local
    connectivity, kinds, places = plot.vtk_mesh(space, np.arange(cells, dtype=np.int32))
    nodes = np.asarray(connectivity, dtype=np.int32).reshape(cells, -1)[:, 1:]
    return Part(
        points=places[: numbers.size_local],
        nodes=numbers.local_to_global(nodes.ravel()).reshape(nodes.shape),
        kind=space.mesh.comm.allreduce(int(kinds.max(initial=0)), MPI.MAX),
        comm=space.mesh.comm,
    )


def at_nodes(function: fem.Function) -> Array:
    """Values at the rank's own nodes, (n,), or vectors, (n, 3); new."""
    dofmap = function.function_space.dofmap
    size = dofmap.index_map_bs
    values = function.x.array[: size * dofmap.index_map.size_local]
    return values.copy() if size == 1 else in_space(values.reshape(-1, size))


def in_cells(function: fem.Function) -> Array:
    """Values of a function that is constant in each cell, (n,) or (n, components); new.

    Of the rank's own cells.
    """
    dofmap = function.function_space.dofmap
    size = dofmap.index_map_bs
    own = dofmap.list[: dofmap.index_map.size_local, 0]
    values: Array = function.x.array.reshape(-1, size)[own]
    return values[:, 0] if size == 1 else values
