"""An elastic body: what it weighs, how it resists, one factorization of that for each step size.

Total Lagrangian, St. Venant-Kirchhoff. All vectors are per unit of thickness and hold the owned
unknowns of a rank, node by node.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem, la, mesh
from numpy.typing import NDArray

from solver.compat import PackedForm
from solver.dynamics.generalized_alpha import TangentWeights
from solver.mechanics.factorization import Factorization
from solver.mechanics.kinematics import polar_rotation
from solver.mechanics.material import Material, green_strain
from solver.parallel import global_sum

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Damping:
    """Rayleigh damping C = lambda_R M + beta_R K; the second part acts on the rate of Green strain.

    Attributes:
        mass: lambda_R, 1/s.
        stiffness: beta_R, s.
    """

    mass: float = 0.0
    stiffness: float = 0.0


@dataclass(frozen=True, slots=True)
class StrainWeights:
    """S = C:(new E_{n+1} + old E_n + rate dE_n/dt), the stress of a step's internal force."""

    new: float
    old: float
    rate: float = 0.0


class ElasticBody:
    """Forces, energies and tangents of one meshed body."""

    def __init__(
        self,
        domain: mesh.Mesh,
        material: Material,
        *,
        degree: int = 1,
        damping: Damping | None = None,
        clamped: Callable[[Array], NDArray[np.bool_]] | None = None,
    ):
        """Compile the forms and assemble mass and stiffness.

        Args:
            domain: Mesh of the body in its own frame.
            material: Its material.
            degree: Polynomial degree of the displacement.
            damping: Rayleigh damping; None assembles no such terms.
            clamped: Marker of boundary points held fixed, as dolfinx's `locate_entities_boundary`
                takes it.
        """
        self.material, self.damping = material, damping or Damping()
        d = domain.geometry.dim
        self.dimension, self.comm = d, domain.comm
        self.space = fem.functionspace(domain, ("Lagrange", degree, (d,)))
        self.owned = self.space.dofmap.index_map.size_local
        self.size = self.owned * d
        self.unknowns = self.space.dofmap.index_map.size_global * d
        self.u, self.u_old = fem.Function(self.space, name="displacement"), fem.Function(self.space)
        self.v_old = fem.Function(self.space, name="velocity")
        self.nodes = self.space.tabulate_dof_coordinates()[: self.owned, :d].copy()
        self.clamped = clamped is not None
        bcs = self._clamp(domain, clamped)
        self.fixed = (
            np.concatenate([bc.dof_indices()[0] for bc in bcs]) if bcs else np.empty(0, np.int32)
        )
        self.fixed = self.fixed[self.fixed < self.size]
        self._compile(domain, degree)
        self._buffer = la.vector(self.space.dofmap.index_map, self.space.dofmap.index_map_bs)
        self._factorizations: dict[TangentWeights, Factorization] = {}
        self.factorizations = 0
        """How many tangents were factorized so far."""
        self._interface: PETSc.Mat | None = None
        self._measure_inertia()

    def _clamp(
        self, domain: mesh.Mesh, clamped: Callable[[Array], NDArray[np.bool_]] | None
    ) -> list[fem.DirichletBC]:
        """Homogeneous Dirichlet conditions on the clamped boundary."""
        if clamped is None:
            return []
        facets = mesh.locate_entities_boundary(domain, domain.topology.dim - 1, clamped)
        dofs = fem.locate_dofs_topological(self.space, domain.topology.dim - 1, facets)
        return [fem.dirichletbc(np.zeros(self.dimension), dofs, self.space)]

    def _compile(self, domain: mesh.Mesh, degree: int) -> None:
        """The weak forms, with the weights of a step as constants."""
        d, material = self.dimension, self.material
        simplex = domain.basix_cell().name in ("triangle", "tetrahedron")
        quadrature = max(1, 2 * degree - 2) if simplex else 2 * degree
        dx = ufl.Measure("dx", domain, metadata={"quadrature_degree": quadrature})
        values = (1.0, 0.0, 0.0, material.lame, material.shear)
        self._constants = [fem.Constant(domain, value) for value in values]
        new, old, rate, lame, shear = self._constants
        identity, test, trial = (
            ufl.Identity(d),
            ufl.TestFunction(self.space),
            ufl.TrialFunction(self.space),
        )

        def stress(strain: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
            return lame * ufl.tr(strain) * identity + 2 * shear * strain

        strain, strain_old = green_strain(ufl.grad(self.u)), green_strain(ufl.grad(self.u_old))
        midpoint = identity + ufl.grad(0.5 * self.u + 0.5 * self.u_old)
        averaged = new * strain + old * strain_old
        increment = strain - strain_old
        if self.damping.stiffness:
            strain_rate = ufl.sym((identity + ufl.grad(self.u_old)).T * ufl.grad(self.v_old))
            averaged = averaged + rate * strain_rate
            self._rate_form = PackedForm(ufl.inner(strain_rate, stress(increment)) * dx)
        self._force = PackedForm(ufl.inner(midpoint * stress(averaged), ufl.grad(test)) * dx)
        self._strain_energy = PackedForm(0.5 * ufl.inner(strain, stress(strain)) * dx)
        self._increment_energy = PackedForm(ufl.inner(increment, stress(increment)) * dx)
        linear = ufl.inner(stress(ufl.sym(ufl.grad(trial))), ufl.sym(ufl.grad(test)))
        self.stiffness_matrix = PackedForm(linear * dx).matrix()
        inertia = fem.Constant(domain, material.density) * ufl.inner(trial, test)
        self.mass_matrix = PackedForm(
            inertia * ufl.dx(domain, metadata={"quadrature_degree": 2 * degree})
        ).matrix()
        self._product = self.mass_matrix.createVecs()
        self._factor, self._image = (vector.array for vector in self._product)  # kept

    def _measure_inertia(self) -> None:
        """Mass, centre and moments that the best-fit rotation needs, from the consistent mass."""
        d = self.dimension
        unit = np.zeros((d, self.owned, d))
        for i in range(d):
            unit[i, :, i] = 1.0
        self.directional_mass = np.array([self.inertia(unit[i].ravel()) for i in range(d)])
        sums = [
            self.directional_mass[0] @ unit[0].ravel(),
            *(self.directional_mass[i] @ self.nodes.ravel() for i in range(d)),
        ]
        total = global_sum(self.comm, np.array(sums))
        self.mass, self.centre = float(total[0]), total[1:] / total[0]
        self.arm = self.nodes - self.centre
        self._moment_row = self.inertia(self.arm.ravel()).reshape(-1, d)
        self._moment = global_sum(self.comm, self.arm.T @ self._moment_row)
        self.polar_inertia = float(np.trace(self._moment))

    def inertia(self, vector: Array) -> Array:
        """M x, with the consistent mass."""
        self._factor[:] = vector
        self.mass_matrix.mult(*self._product)
        return self._image.copy()

    def rotation(self, u: Array) -> Array:
        """The rotation R that fits the displacement u best, (d, d)."""
        if self.clamped:
            return np.eye(self.dimension)
        moment = u.reshape(-1, self.dimension).T @ self._moment_row
        return polar_rotation(global_sum(self.comm, moment) + self._moment)

    def begin(self, u_old: Array, v_old: Array, weights: StrainWeights) -> None:
        """Fix what a step starts from: state at t_n and the weights of its stress."""
        self._assign(self.u_old, u_old)
        if self.damping.stiffness:
            self._assign(self.v_old, v_old)
        values = (weights.new, weights.old, weights.rate)
        if values != tuple(float(c.value) for c in self._constants[:3]):
            for constant, value in zip(self._constants[:3], values, strict=True):
                constant.value = value
            self._force.refresh()

    def _assign(self, function: fem.Function, values: Array) -> None:
        """Owned values into a function, ghosts from their owners."""
        function.x.array[: self.size] = values
        if self.comm.size > 1:
            function.x.scatter_forward()

    def internal_force(self, u: Array, *, static: bool = False) -> Array:
        """Averaged internal force at displacement u: stress of averaged strain, midpoint gradient.

        With `static` the midpoint is the configuration itself.
        """
        self._assign(self.u, u)
        if static:
            self._assign(self.u_old, u)
        self._force.vector(self._buffer.array)
        if self.comm.size > 1:
            self._buffer.scatter_reverse(la.InsertMode.add)
        return self._buffer.array[: self.size].copy()

    def strain_energy(self) -> float:
        """Integral of E:C:E/2 over this rank's cells, J/m, at the displacement last assigned."""
        return self._strain_energy.scalar()

    def increment_energy(self) -> float:
        """Integral of dE:C:dE over this rank's cells, J/m, dE = E_{n+1} - E_n."""
        return self._increment_energy.scalar()

    def rate_energy(self) -> float:
        """Integral of dE_n/dt:C:dE over this rank's cells, W s/m; 0 without stiffness damping."""
        return self._rate_form.scalar() if self.damping.stiffness else 0.0

    def stiffen(self, interface: PETSc.Mat) -> None:
        """Hand over the theta term of Nitsche's method, which tangents subtract.

        Args:
            interface: (theta/gamma_h) G_T^T w G_T.
        """
        self._interface = interface
        self._factorizations.clear()

    def factorization(self, weights: TangentWeights) -> Factorization:
        """The tangent of the unrotated body for these weights, factorized once and kept."""
        if weights not in self._factorizations:
            matrix = self.stiffness_matrix.copy()
            matrix.scale(weights.stiffness)
            matrix.axpy(weights.mass, self.mass_matrix)
            if self._interface is not None:
                matrix.axpy(-weights.interface, self._interface)
            self._factorizations[weights] = Factorization(self.hold(matrix))
            self.factorizations += 1
        return self._factorizations[weights]

    def hold(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """Identity rows and columns for clamped unknowns, in place."""
        if self.clamped:
            start = matrix.getOwnershipRange()[0]
            matrix.zeroRowsColumns(self.fixed + start, 1.0)
        return matrix
