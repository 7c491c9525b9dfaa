"""An elastic body: its inertia, its resistance, its supports, its factorized tangents.

All vectors hold the owned unknowns of a rank, node by node, and belong to the whole thickness.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem, la, mesh
from numpy.typing import NDArray

from solver.bodies.body import Body
from solver.bodies.elastic_forms import ElasticForms, Moduli, Region, StrainWeights, differs
from solver.bodies.factorization import Factorization, MassInverse
from solver.bodies.kinematics import RigidMotion
from solver.bodies.mass_properties import MassProperties
from solver.bodies.packed_form import PackedForm
from solver.kernels import meshed
from solver.scene.damping import DampingSpec
from solver.scene.material import Material
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.types import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Support:
    """Facets whose displacement is held, in some directions or in all."""

    facets: NDArray[np.int32]
    """Numbers of boundary facets."""
    directions: tuple[int, ...]
    """Held components of the displacement."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundSpring:
    """Springs and dashpots to the ground, spread evenly over some facets."""

    facets: NDArray[np.int32]
    """Numbers of boundary facets."""
    stiffness: tuple[float, ...]
    """k of the whole spring along each direction, N/m; 0: there is none."""
    delay: float = 0.0
    """Dashpots over springs, c/k, s."""

    def matrix(self, space: fem.FunctionSpace) -> PETSc.Mat:
        """Its stiffness for displacements of a space; collective."""
        domain, order = space.mesh, np.argsort(self.facets)
        facets = mesh.meshtags(
            domain, domain.topology.dim - 1, self.facets[order], np.ones_like(self.facets)
        )
        ds = ufl.Measure("ds", domain, subdomain_data=facets)(1)
        own = fem.assemble_scalar(fem.form(fem.Constant(domain, 1.0) * ds))
        area = domain.comm.allreduce(own)
        trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)
        density = fem.Constant(domain, [value / area for value in self.stiffness])
        pushed = sum(density[k] * trial[k] * test[k] for k in range(domain.geometry.dim))
        return PackedForm(pushed * ds).matrix()


class ElasticBody(Body):
    """Forces, energies and tangents of one meshed body."""

    def __init__(
        self,
        domain: mesh.Mesh,
        material: Material,
        *,
        degree: int = 1,
        damping: DampingSpec | None = None,
        name: str = "block",
        thickness: float = 1.0,
        supports: Sequence[Support] = (),
        spring: GroundSpring | None = None,
        regions: Sequence[Region] = (),
        density: fem.Function | None = None,
    ):
        """Compile the forms and assemble mass and stiffness.

        Args:
            domain: Mesh of the body in its own frame.
            material: Its material.
            degree: Polynomial degree of the displacement.
            damping: Rayleigh damping; None assembles no such terms.
            name: What messages and files call it.
            thickness: t, m; 1 in 3-D.
            supports: Held facets.
            spring: Between some facets and the ground.
            regions: Cells of other materials.
            density: Over that of the material; None: it is the same everywhere.
        """
        self.name, self.thickness, self.damping = name, thickness, damping or DampingSpec()
        self.material = material.times(thickness)
        """Its stresses are times the thickness."""
        self._regions = [Region(cells, own.times(thickness)) for cells, own in regions]
        self._density = density
        self._discretise(domain, degree)
        self.clamped = bool(supports) or spring is not None
        """True if it stands on the ground, and does not turn."""
        self.fixed = self._held(supports)
        self._assemble()
        self.spring_matrix = None if spring is None else spring.matrix(self.space)
        self.has_spring, self.delay = spring is not None, 0.0 if spring is None else spring.delay
        self._properties = own = MassProperties(self.comm, self.nodes, self.inertia)
        self.mass, self.centre, self.arm = own.mass, own.centre, own.arm
        self.directional_mass = own.directional
        length = 1.0 if self.dimension == 2 else float(np.cbrt(own.mass / self.material.density))
        self.rigidity = self.material.longitudinal * length

    def _discretise(self, domain: mesh.Mesh, degree: int) -> None:
        """The space of displacements: its size, nodes, functions, and vectors that are kept."""
        d = domain.geometry.dim
        self.dimension, self.comm, self.identity = d, domain.comm, np.eye(d)
        self.space = fem.functionspace(domain, ("Lagrange", degree, (d,)))
        dofs = self.space.dofmap
        self.owned = dofs.index_map.size_local
        self.size, self.unknowns = self.owned * d, dofs.index_map.size_global * d
        self.u, self.u_old = fem.Function(self.space, name="displacement"), fem.Function(self.space)
        self.nodes = self.space.tabulate_dof_coordinates()[: self.owned, :d].copy()
        self._buffer = la.vector(dofs.index_map, dofs.index_map_bs)
        self._forces = self._buffer.array
        self._own_forces = self._forces[: self.size]

    def _assemble(self) -> None:
        """Forms, mass and stiffness; no tangent is factorized yet."""
        viscous = bool(self.damping.stiffness)
        self._forms = ElasticForms(
            self.u, self.u_old, self.material, viscous=viscous, regions=self._regions
        )
        self.stiffness_matrix, self.mass_matrix = (
            self._forms.stiffness(),
            self._forms.mass(self._density),
        )
        self._diagonal = self.stiffness_matrix.getDiagonal().array
        self._product = self.mass_matrix.createVecs()
        self._factor, self._image = (vector.array for vector in self._product)  # kept
        self._factorizations: dict[TangentWeights, Factorization] = {}
        self._rounding: tuple[TangentWeights, Array] | None = None
        self._interfaces: tuple[PETSc.Mat, ...] = ()
        self.strained_at: Array | None = None  # of the stiffness
        self.factorizations = 0
        """Number of tangents factorized so far."""
        self.solvers: set[str] = set()
        """Names of the linear solvers that solved with them."""

    def _held(self, supports: Sequence[Support]) -> NDArray[np.int32]:
        """Owned unknowns that supports hold."""
        held = [np.empty(0, dtype=np.int32)]
        dimension = self.space.mesh.topology.dim - 1
        for support in supports:
            nodes = fem.locate_dofs_topological(self.space, dimension, support.facets)
            held += [nodes * self.dimension + k for k in support.directions]
        unknowns = np.unique(np.concatenate(held))
        return unknowns[unknowns < self.size].astype(np.int32)

    @property
    def moduli(self) -> Moduli:
        """Lame's constants of its material and of its regions, times the thickness."""
        return self._forms.moduli

    def inertia(self, vector: Array) -> Array:
        """M x, with the consistent mass."""
        return self._times(self.mass_matrix, vector)

    def _times(self, matrix: PETSc.Mat, vector: Array) -> Array:
        """A product, by way of vectors that are kept."""
        self._factor[:] = vector
        matrix.mult(*self._product)
        return self._image.copy()

    def rigid_motion(self, u: Array, v: Array) -> RigidMotion:
        """Motion of the rigid body that has the same momentum and angular momentum."""
        return self._properties.rigid_motion(u, v, self.rotation(u))

    def vibration(self, u: Array, v: Array, rotation: Array) -> float:
        """Mean square of a velocity v over the mass, less that of the motion as a whole, m2/s2."""
        return self._properties.vibration(u, v, rotation, turns=not self.clamped)

    def extrapolated(
        self, u: Array, v: Array, dt: float, angle: Array, motion: RigidMotion
    ) -> Array:
        """The owned unknowns after dt if the body moved on as a whole, and its strains stayed.

        u + dt v would stretch a body that turns or vibrates, by whole per cents in long steps; an
        error of the angle (rad) stretches it by its square, which takes a correction more.
        """
        if self.clamped:
            return super().extrapolated(u, v, dt, angle, motion)
        after, way = np.empty(len(u)), dt * motion.velocity
        meshed.move_on(self.arm, u, motion.moved, angle, way, after)
        return after

    def turned(self, force: Array, vector: Array) -> Array:
        """Nodal forces that turn with the body, by an angle or a rotation vector."""
        if self.clamped:
            return force
        turned = np.empty(len(force))
        meshed.turn_all(force, vector, turned)
        return turned

    def rotation(self, u: Array) -> Array:
        """The rotation R that fits the displacement u best, (d, d)."""
        if self.clamped:
            return self.identity
        return self._properties.rotation(u)

    def begin_step(self, u_old: Array, scheme: GeneralizedAlpha, dt: float) -> None:
        """Fix what a step of length `dt` starts from."""
        viscous = scheme.contact_weight * self.damping.stiffness / dt
        self.begin(u_old, StrainWeights(1 - scheme.alpha_f + viscous, scheme.alpha_f - viscous))

    def begin_static(self, u: Array) -> None:
        """Prepare for the elastic forces of a state itself."""
        self.begin(u, StrainWeights(new=1.0, old=0.0))

    def begin(self, u_old: Array, weights: StrainWeights) -> None:
        """Fix what a step starts from: displacement at t_n and the weights of its stress."""
        self._forms.begin(u_old)
        self._forms.weigh(weights)

    def internal_force(self, u: Array, *, static: bool = False) -> Array:
        """Averaged internal force at displacement u: stress of averaged strain, midpoint gradient.

        A new array. With `static` the midpoint is the configuration itself.
        """
        self._forms.place(u)
        if static:
            self._forms.begin(u)
        return self._assembled(self._forms.force)

    def _assembled(self, form: PackedForm) -> Array:
        """Forces of a form on the owned unknowns."""
        form.vector(self._forces)
        if self.comm.size > 1:
            self._buffer.scatter_reverse(la.InsertMode.add)
        return self._own_forces.copy()

    def impulsive_force(self, u: Array, dt: float) -> Array | None:
        """Internal force outside the averages of the step that ends at u.

        C du/dt by strain rates; None without damping.
        """
        if self._forms.viscous is None:
            return None
        self._forms.place(u)
        return self.damping.stiffness / dt * self._assembled(self._forms.viscous)

    def spring(self, vector: Array) -> Array | None:
        """Force of the spring to the ground for a displacement; None without one."""
        return None if self.spring_matrix is None else self._times(self.spring_matrix, vector)

    def resultant(self, force: Array) -> Array:
        """Sum of the forces on the owned unknowns along each direction, (d,), N."""
        total = np.empty(self.dimension)
        meshed.resultant(force, total)
        return total

    def round_off(self, u: Array, weights: TangentWeights) -> float:
        """Square of the residual that round-off leaves at u; this rank's part."""
        if self._rounding is None or self._rounding[0] != weights:
            node_mass = self.mass * self.dimension / self.unknowns
            # Small and thin cells are stiff, and so are damped ones in short steps.
            terms = 0.28 if self.dimension == 2 else 0.7  # more nodes make more round-off
            stiffness = terms * max(1.0, weights.stiffness) * self._diagonal
            stiffness += 0.1 * weights.mass * node_mass
            self._rounding = weights, (float(np.finfo(float).eps) * stiffness) ** 2
        return float(self._rounding[1].dot(u**2))

    def strain_energy(self, u: Array) -> float:
        """Integral of E:C:E/2 over this rank's cells at displacement u, J.

        Infinite where a cell is compressed beyond St. Venant-Kirchhoff's law.
        """
        self._forms.place(u)
        return self._forms.energy_at_end()

    def increment_energy(self, u: Array) -> float:
        """Integral of dE:C:dE over this rank's cells, J, dE from what `begin` was given to u."""
        self._forms.place(u)
        return self._forms.increment_energy.scalar()

    def stiffen(self, interfaces: Sequence[PETSc.Mat]) -> None:
        """Hand over (theta/gamma_h) G_T^T w G_T of Nitsche's method, which tangents subtract."""
        self._interfaces = tuple(interfaces)
        self._factorizations.clear()

    def restiffen(self, u: Array) -> bool:
        """Take the stiffness as strained at u, turned back, if it differs enough; collective."""
        strained = self._strained_stiffness(u)
        if not differs(strained, self.stiffness_matrix, self.material):
            return False
        self.stiffness_matrix, self.strained_at = strained, u.copy()
        self._factorizations.clear()
        return True

    def _strained_stiffness(self, u: Array) -> PETSc.Mat:
        """Stiffness of the body as it is strained at u, turned back."""
        turned = (self.arm + u.reshape(-1, self.dimension)) @ self.rotation(u)
        return self._forms.strained_stiffness((turned - self.arm).ravel())

    def resume_stiffness(self, strained_at: Array) -> None:
        """Take the stiffness of an earlier run; collective."""
        self.stiffness_matrix, self.strained_at = self._strained_stiffness(strained_at), strained_at
        self._factorizations.clear()

    def factorization(self, weights: TangentWeights) -> Factorization:
        """The tangent of the unrotated body for these weights, factorized once and kept.

        Its stiffness is that of the undeformed body, or of the one that `restiffen` was given last.
        """
        if weights not in self._factorizations:
            matrix = self.stiffness_matrix.copy()
            matrix.scale(weights.stiffness)
            matrix.axpy(weights.mass, self.mass_matrix)
            if self.spring_matrix is not None:
                matrix.axpy(weights.spring, self.spring_matrix)
            for interface in self._interfaces:
                matrix.axpy(-weights.interface, interface)
            self._factorizations[weights] = Factorization(
                self.hold(matrix), dimension=self.dimension, what=self.name
            )
            self.factorizations += 1
            self.solvers.add(self._factorizations[weights].name)
        return self._factorizations[weights]

    def mass_inverse(self) -> MassInverse:
        """The factorized mass."""
        return MassInverse(self.mass_matrix, self.fixed, self.dimension)

    def hold(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """Identity rows and columns for clamped unknowns, in place."""
        if self.clamped:
            start = matrix.getOwnershipRange()[0]
            matrix.zeroRowsColumns(self.fixed + start, 1.0)
        return matrix
