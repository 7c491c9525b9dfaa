"""The weak forms of an elastic body: internal force, energies, stiffness and mass.

Total Lagrangian, St. Venant-Kirchhoff. The internal force of a step is that of the averaged strain
with the deformation gradient of the midpoint (Simo and Tarnow 1992),

    S = C : (w_new E_{n+1} + w_old E_n),   F = I + grad (u_n + u_{n+1})/2,   f.v = int F S : grad v,

which keeps energy and does no work in rotations.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem, mesh
from numpy.typing import NDArray

from solver.bodies.packed_form import PackedForm, packed_coefficients
from solver.kernels import meshed
from solver.scene.material import Material, Plane
from solver.types import Array


class CellValues:
    """Values of some functions cell by cell, as the forms of cells take them.

    dolfinx packs all functions of a form at each assembly, which takes a third of its time.
    """

    def __init__(self, form: Any, functions: Sequence[fem.Function]):
        """Find the order in which dolfinx packs the values for a compiled form of functions."""
        self._arrays = [function.x.array for function in functions]
        kept = [array.copy() for array in self._arrays]
        starts = np.cumsum([0, *map(len, kept)])
        for array, start in zip(self._arrays, starts, strict=False):
            array[:] = start + np.arange(len(array))
        self.packed = packed_coefficients(form)
        for array, before in zip(self._arrays, kept, strict=True):
            array[:] = before
        (table,) = self.packed.values()
        order = table.astype(np.int64)
        self._parts = []
        for start, end in pairwise(starts):
            columns = ((order[:1] >= start) & (order[:1] < end)).ravel().nonzero()[0]
            first, end = (int(columns[0]), int(columns[-1]) + 1) if len(columns) else (0, 0)
            index = np.ascontiguousarray(order[:, first:end] - start)
            self._parts.append((index, table, first))
        for number in range(len(functions)):
            self.read(number)

    def read(self, number: int) -> None:
        """Take the present values of a function."""
        meshed.read_cells(self._arrays[number], *self._parts[number])

    def place(self, number: int, u: Array) -> None:
        """Let u be the values of a function whose nodes are all on this rank, and take them.

        Nothing is done where they are so already, as after the last residual of a step.
        """
        meshed.place_in_cells(u, self._arrays[number], *self._parts[number])


STRAINED_STIFFNESS_CHANGE = 0.1
"""Change of the stiffness by strain, times (lambda + 2 mu)/mu, from which on the tangent follows
it: what iterations with the undeformed tangent leave of an error is of that size."""


MOST_COMPRESSED = 1 / 3
"""Compressive strain, E, from which on more compression takes less pressure: along one direction,
of a stretch s, St. Venant-Kirchhoff's law has the pressure M s (1 - s^2)/2, which is largest at
s = 1/sqrt(3). Beyond, cells collapse, and turn inside out without any force."""


class Region(NamedTuple):
    """Cells of another material."""

    cells: NDArray[np.int32]
    """Numbers of cells on this rank, ghosts included."""
    material: Material
    """Their material."""


class StrainWeights(NamedTuple):
    """Weights of the strains in the stress of a step's internal force."""

    new: float
    """w_new, of E_{n+1}."""
    old: float
    """w_old, of E_n."""


class Moduli(NamedTuple):
    """Lame's constants of a body as UFL takes them: constants, or functions where regions differ.

    Attributes:
        lame: lambda; of a body in the plane that of its material times the thickness.
        shear: mu, likewise.
        plane: The state of stress.
    """

    lame: Any
    shear: Any
    plane: Plane

    @classmethod
    def of(cls, domain: mesh.Mesh, material: Material, regions: Sequence[Region] = ()) -> Moduli:
        """The moduli of a material on a mesh, and of others in some of its regions."""
        lame, shear = (property_of(domain, each, material, regions) for each in ("lame", "shear"))
        return cls(lame, shear, material.plane)


def property_of(
    domain: mesh.Mesh, name: str, material: Material, regions: Sequence[Region] = ()
) -> fem.Constant | fem.Function:
    """A property of a material: a constant, or a function where regions have others."""
    value = float(getattr(material, name))
    if not regions:
        return fem.Constant(domain, value)
    found = fem.Function(fem.functionspace(domain, ("DG", 0)))
    found.x.array[:] = value
    for region in regions:
        found.x.array[region.cells] = float(getattr(region.material, name))
    return found


def green_strain(gradient: Any) -> Any:
    """E = (F^T F - I)/2 of a UFL displacement gradient, without the cancellation of F^T F - I."""
    return (gradient + gradient.T + gradient.T * gradient) / 2


def is_within_law(strain: Any) -> Any:
    """UFL condition that no direction is compressed by more than the law bears.

    E + I/3 is positive definite: its leading minors are positive.
    """
    d = strain.ufl_shape[0]
    shifted = strain + MOST_COMPRESSED * ufl.Identity(d)
    found = ufl.And(ufl.gt(shifted[0, 0], 0), ufl.gt(ufl.det(shifted), 0))
    if d == 2:
        return found
    minor = shifted[0, 0] * shifted[1, 1] - shifted[0, 1] * shifted[1, 0]
    return ufl.And(found, ufl.gt(minor, 0))


class ElasticForms:
    """Compiled forms of one body; what they are assembled into belongs to the caller.

    Attributes:
        force: Internal force of a step.
        viscous: The same of the strain increment, for Rayleigh's beta_R; None without damping.
        strain_energy: Integral of E:C:E/2 at the end of the step; infinite beyond the law.
        increment_energy: Integral of dE:C:dE, dE = E_{n+1} - E_n.
        moduli: Of the material and of its regions, times the thickness.
    """

    def __init__(
        self,
        u: fem.Function,
        u_old: fem.Function,
        material: Material,
        *,
        viscous: bool,
        regions: Sequence[Region] = (),
    ) -> None:
        """Compile the forms; those of the strain rate only where the body is viscous.

        The values of `u` are those at the time of assembly; stresses are times the thickness.
        """
        self._space, self._material, self._regions = u.function_space, material, regions
        domain = self._space.mesh
        self._shared = domain.comm.size > 1
        self._weights = StrainWeights(new=1.0, old=0.0)
        self._new, self._old = (fem.Constant(domain, value) for value in (1.0, 0.0))
        self.moduli = Moduli.of(domain, material, regions)
        degree = self._space.ufl_element().degree
        self._dx = _cell_measure(domain, degree)
        test = ufl.TestFunction(self._space)
        strain, strain_old = green_strain(ufl.grad(u)), green_strain(ufl.grad(u_old))
        midpoint = self._identity + ufl.grad(0.5 * u + 0.5 * u_old)
        averaged = self._new * strain + self._old * strain_old
        increment = strain - strain_old

        def internal(of: Any) -> PackedForm:
            return PackedForm(ufl.inner(midpoint * self._stress(of), ufl.grad(test)) * self._dx)

        self.force = internal(averaged)
        self.viscous = internal(increment) if viscous else None
        energy = 0.5 * ufl.inner(strain, self._stress(strain))
        beyond = fem.Constant(domain, np.inf)
        self.strain_energy = PackedForm(
            ufl.conditional(is_within_law(strain), energy, beyond) * self._dx
        )
        self.increment_energy = PackedForm(ufl.inner(increment, self._stress(increment)) * self._dx)
        self._strained: tuple[fem.Function, PackedForm] | None = None
        self._share_values((u, u_old))

    def _share_values(self, functions: tuple[fem.Function, fem.Function]) -> None:
        """Let all forms of both displacements read the same values, cell by cell."""
        # Views that are kept: asking dolfinx for one costs as much as copying the values.
        self._new_values, self._old_values = ((each, each.x.array) for each in functions)
        kept = [each for each in self.moduli if isinstance(each, fem.Function)]
        self._both = CellValues(self.force.form, [*functions, *kept])
        form = self.strain_energy.form
        self._last = CellValues(form, [functions[0], *kept])
        self.strain_energy.cells = self._last.packed
        for form in (self.force, self.viscous, self.increment_energy):
            if form is not None:
                form.cells = self._both.packed

    def _assign(self, target: tuple[fem.Function, Array], values: Array) -> None:
        """Owned values into a function and its array, ghosts from their owners."""
        function, array = target
        array[: len(values)] = values
        if self._shared:
            function.x.scatter_forward()

    def place(self, u: Array) -> None:
        """Let u be the owned unknowns at the end of the step."""
        if self._shared:  # ranks exchange ghosts together, or not at all
            self._assign(self._new_values, u)
            self._both.read(0)
        else:
            self._both.place(0, u)

    def begin(self, u: Array) -> None:
        """Let u be the owned unknowns at its start."""
        self._assign(self._old_values, u)
        self._both.read(1)

    def energy_at_end(self) -> float:
        """Strain energy at the end of the step, over this rank's cells, J; as that form has it."""
        self._last.read(0)
        return self.strain_energy.scalar()

    @property
    def _identity(self) -> Any:
        """I, (d, d)."""
        return ufl.Identity(self._space.mesh.geometry.dim)

    def _stress(self, strain: Any) -> Any:
        """S = lambda tr(E) I + 2 mu E."""
        lame, shear, _ = self.moduli
        return lame * ufl.tr(strain) * self._identity + 2 * shear * strain

    def weigh(self, weights: StrainWeights) -> None:
        """Set the weights of the strains in the internal force."""
        if weights != self._weights:
            self._weights = weights
            self._new.value, self._old.value = weights.new, weights.old
            self.force.refresh()

    def stiffness(self) -> PETSc.Mat:
        """K of the undeformed body, assembled."""
        trial, test = ufl.TrialFunction(self._space), ufl.TestFunction(self._space)
        strains = (ufl.sym(ufl.grad(of)) for of in (trial, test))
        strain, virtual = strains
        return PackedForm(ufl.inner(self._stress(strain), virtual) * self._dx).matrix()

    def mass(self, relative: fem.Function | None = None) -> PETSc.Mat:
        """M, consistent: a row-sum mass has the wrong rotary inertia.

        The density may vary over a cell, by a function that stands for it over the material's.
        """
        trial, test = ufl.TrialFunction(self._space), ufl.TestFunction(self._space)
        density = property_of(self._space.mesh, "density", self._material, self._regions)
        degree = 2 * self._space.ufl_element().degree
        if relative is not None:
            density = density * relative
            degree += relative.function_space.ufl_element().degree
        dx = ufl.dx(self._space.mesh, metadata={"quadrature_degree": degree})
        return without_zeros(PackedForm(density * ufl.inner(trial, test) * dx).matrix())

    def strained_stiffness(self, u: Array) -> PETSc.Mat:
        """K of the body strained by a displacement of its owned unknowns, assembled."""
        if self._strained is None:
            state, trial = fem.Function(self._space), ufl.TrialFunction(self._space)
            gradient = ufl.grad(state)
            stress = (self._identity + gradient) * self._stress(green_strain(gradient))
            force = ufl.inner(stress, ufl.grad(ufl.TestFunction(self._space))) * self._dx
            self._strained = state, PackedForm(ufl.derivative(force, state, trial))
        state, form = self._strained
        self._assign((state, state.x.array), u)
        return form.matrix()


def without_zeros(matrix: PETSc.Mat) -> PETSc.Mat:
    """A matrix without the entries that are zero, which products need not read.

    Of the mass that is half of them in the plane, two thirds in space: between directions.
    """
    starts, columns, values = matrix.getValuesCSR()
    there = values != 0
    before = np.concatenate([[0], np.cumsum(there)])
    rows = before[starts].astype(PETSc.IntType), columns[there], values[there]
    return PETSc.Mat().createAIJ(matrix.getSizes(), csr=rows, comm=matrix.comm)


def differs(strained: PETSc.Mat, stiffness: PETSc.Mat, material: Material) -> bool:
    """True if a stiffness differs from another by enough for iterations to need it."""
    change = strained.copy()
    change.axpy(-1.0, stiffness)
    share = change.norm(PETSc.NormType.INFINITY) / strained.norm(PETSc.NormType.INFINITY)
    return bool(share * material.longitudinal >= STRAINED_STIFFNESS_CHANGE * material.shear)


def _cell_measure(domain: mesh.Mesh, degree: int) -> ufl.Measure:
    """The measure dx with the lowest quadrature that is accurate enough.

    Degree 2 p on quadrilaterals and hexahedra, 2 p - 2 on simplices, at least 1; the degree that
    UFL estimates costs two to five times as much.
    """
    simplex = domain.basix_cell().name in ("triangle", "tetrahedron")
    quadrature = max(1, 2 * degree - 2) if simplex else 2 * degree
    return ufl.Measure("dx", domain, metadata={"quadrature_degree": quadrature})
