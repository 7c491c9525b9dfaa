"""A meshed foundation reduced to few unknowns, by the method of Craig and Bampton.

It is linearised about its equilibrium under weight, P-delta included. With the displacements of the
nodes that are kept and the amplitudes q of fixed-interface modes,

    u_inner = Psi u_kept + Phi q,    Psi = -K_ii^-1 K_ik,    K_ii phi = omega^2 M_ii phi,

and beside the modes the shapes of the inner part, the kept unknowns held, under a uniform
acceleration of the ground or of the nodes that are touched, and under weight: what the modes left
out give way statically is in these. Its matrices are Galerkin's projections of those of the mesh,

    u = u_s + T (y - y_s),    A_y = T^T A T,    T = (1  0; Psi  Phi).

The amplitudes are scaled to the mass of the whole body, so that all y are lengths. Numbers of nodes
go up to whole ones: amplitudes that no shape has are held.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from petsc4py import PETSc

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.factorization import Factorization
from solver.bodies.kinematics import rigid_modes
from solver.bodies.modes import STATIC, compressed_rows, lowest_pairs
from solver.errors import NotConverged
from solver.types import Array, Indices

MOST_CORRECTIONS = 30
"""Newton corrections after which the search for the equilibrium is given up."""

SETTLED = 1e-8
"""A correction below this part of the displacement is the last one."""


class Linearised(NamedTuple):
    """Forces of strain F(u_s) + K (u - u_s) about an equilibrium u_s, and all other matrices."""

    u: Array
    """u_s, m."""
    force: Array
    """F(u_s) without that of springs, N."""
    energy: float
    """Strain energy at u_s, J."""
    stiffness: sp.csr_matrix
    """K, tangent at u_s: of the material and of the stresses there, N/m."""
    undeformed: sp.csr_matrix
    """K_0, of the undeformed body, which damping goes with, N/m."""
    mass: sp.csr_matrix
    """M, kg."""
    spring: sp.csr_matrix
    """Springs to the ground, N/m; empty where there are none."""


def linearised(body: ElasticBody, load: Array) -> Linearised:
    """A held body on one rank, about its equilibrium under a load (N), by Newton's method.

    The tangent of the body is afterwards that of the equilibrium.

    Raises:
        NotConverged: There is none: it buckles.
    """
    undeformed, mass = compressed_rows(body.stiffness_matrix), compressed_rows(body.mass_matrix)
    u: Array = np.zeros(body.size)
    for _ in range(MOST_CORRECTIONS):
        body.begin_static(u)
        force = body.internal_force(u, static=True)
        left, spring = load - force, body.spring(u)
        if spring is not None:
            left -= spring
        left[body.fixed] = 0.0
        body.resume_stiffness(u)
        change = body.factorization(STATIC).solve(left)
        if np.linalg.norm(change) <= SETTLED * np.linalg.norm(u):
            break
        u = u + change
    else:
        raise NotConverged(f"{body.name}: no equilibrium under its weight, to linearise about")
    held = sp.csr_matrix(mass.shape)
    if body.spring_matrix is not None:
        held = compressed_rows(body.spring_matrix)
    tangent = compressed_rows(body.stiffness_matrix)
    return Linearised(u, force, body.strain_energy(u), tangent, undeformed, mass, held)


MOST_LEFT_OUT = 5e-4
"""Force of the modes left out over mass times acceleration, at most, where the number of modes is
chosen: a quarter of the 0.2 % within which peaks are to agree."""

FREQUENCY_MARGIN = 2.0
"""Frequency of the first mode left out over the highest of the motion, at least; the usual rule for
fixed-interface modes needs 1.5 to 2."""

FIRST_MODES = 16
"""Number of modes that are computed first where their number is chosen; then twice as many."""

NEGLIGIBLE = 1e-12
"""Square of the part of a static shape that no mode and no other shape has, over that of all of it,
below which it is dropped."""


class Bound(NamedTuple):
    """Bound of the force on the ground that modes left out may take.

    Under an acceleration a of frequency W, uniform or that of the nodes touched, a mode j gives the
    force a L_j^2 W^2/(w_j^2 - W^2), L_j its participation. The static shapes match the first two
    terms of the series in W^2 of all modes left out together, with w_j >= w_c, so that

        error <= a W^2 (W/w_c)^4/(1 - (W/w_c)^2) sum of L_j^2/w_j^2,

    and the sum is the static compliance q.K_ii^-1 q, q = (M p)_i, less what modes kept have of it.
    """

    frequency: float
    """Highest frequency of the motion, rad/s."""
    part: float
    """Force left out over mass times acceleration of floor or nodes touched, for motions of this
    frequency and below; infinite where the first mode left out is not faster."""


class InnerBasis(NamedTuple):
    """Shapes of the inner unknowns while those kept are held, of unit mass and orthogonal."""

    shapes: Array
    """Modes, then static shapes, (inner, shapes)."""
    squared: Array
    """Squares of their frequencies, 1/s^2."""
    modes: int
    """Number of modes among them."""
    bound: Bound
    """Bound of what the modes left out may take."""


class LeftOut(NamedTuple):
    """Data of the bound of modes left out under accelerations of some patterns."""

    pushed: Array
    """q_p = (M p)_i of each pattern p, (inner, patterns), kg."""
    compliance: Array
    """q_p.K_ii^-1 q_p, (patterns,), kg s2."""
    mass: float
    """Mass of the whole body, kg."""
    frequency: float
    """Highest frequency of the motion, rad/s."""

    def bound(self, squared: Array, modes: Array, kept: int) -> Bound:
        """By the first modes, so many, of those that are known; with more there are none left."""
        if kept >= len(squared):
            return Bound(self.frequency, 0.0)
        taken = (self.pushed.T @ modes[:, :kept]) ** 2 @ (1 / squared[:kept])
        left = float(np.max(self.compliance - taken, initial=0.0))
        ratio = self.frequency**2 / float(squared[kept])
        if ratio >= 1:
            return Bound(self.frequency, math.inf)
        part = self.frequency**2 * left / self.mass * ratio**2 / (1 - ratio)
        return Bound(self.frequency, part)


class FixedInterface:
    """The inner unknowns of a body whose other unknowns are kept."""

    def __init__(self, body: Linearised, kept: Indices, touched: Indices, dimension: int):
        """Factorize the stiffness of the inner unknowns; `touched` are those kept on the deck.

        Unknowns stand node by node, and all of a node are kept or none.
        """
        self._body, self.kept, self._dimension = body, kept, dimension
        self.inner: Indices = np.setdiff1d(np.arange(len(body.u)), kept)
        self._stiffness = _part(body.stiffness, self.inner, self.inner)
        self._mass = _part(body.mass, self.inner, self.inner)
        self.constraint_modes: Array = np.zeros((len(self.inner), len(kept)))
        """Psi, (inner, kept)."""
        if len(self.inner):
            csr = self._stiffness.indptr, self._stiffness.indices, self._stiffness.data
            matrix = PETSc.Mat().createAIJ(self._stiffness.shape, csr=csr, comm=PETSc.COMM_SELF)
            self._factor = Factorization(matrix)
            coupling = _part(body.stiffness, self.inner, kept).toarray(order="F")
            self.constraint_modes = -self._factor.solve_many(coupling)
        self._touched = np.isin(kept, touched)

    def basis(self, count: int | None, frequency: float) -> InnerBasis:
        """So many modes, or with None as many as the highest frequency (rad/s) needs, and shapes.

        All there are where there are no more.
        """
        if not len(self.inner):
            return InnerBasis(np.zeros((0, 0)), np.zeros(0), 0, Bound(frequency, 0.0))
        patterns = self._patterns()
        moved = self._body.mass @ patterns
        pushed, total = moved[self.inner], float(patterns[:, 0] @ moved[:, 0])
        static = self._factor.solve_many(np.asfortranarray(pushed))
        left = LeftOut(pushed, np.einsum("ik,ik->k", pushed, static), total, frequency)
        if count is None:
            count, squared, modes = self._enough(left)
        else:
            squared, modes = self._modes(count + 1)
        count = min(count, len(self.inner))
        bound = left.bound(squared, modes, count)
        squared, modes = squared[:count], modes[:, :count]
        weight = self._body.u[self.inner] - self.constraint_modes @ self._body.u[self.kept]
        shapes, their = self._static_shapes(modes, np.column_stack([static, weight]))
        return InnerBasis(
            np.hstack([modes, shapes]), np.concatenate([squared, their]), count, bound
        )

    def _enough(self, left: LeftOut) -> tuple[int, Array, Array]:
        """The smallest number of modes that keeps the bound, and these modes and more."""
        number, every = FIRST_MODES, len(self.inner)
        while True:
            squared, modes = self._modes(number)
            for kept in range(1, len(squared)):
                fast = squared[kept] >= (FREQUENCY_MARGIN * left.frequency) ** 2
                if fast and left.bound(squared, modes, kept).part <= MOST_LEFT_OUT:
                    return kept, squared, modes
            if len(squared) >= every:
                return every, squared, modes
            number *= 2

    def _patterns(self) -> Array:
        """Motions of the whole body with the ground, and of the nodes touched against it."""
        size, dimension = len(self._body.u), self._dimension
        moved = np.zeros((size, 2 * dimension))
        for k in range(dimension):
            moved[k::dimension, k] = 1.0
            unit = np.where(self._touched & (self.kept % dimension == k), 1.0, 0.0)
            moved[self.kept, dimension + k] = unit
            moved[self.inner, dimension + k] = self.constraint_modes @ unit
        return moved

    def _modes(self, count: int) -> tuple[Array, Array]:
        """The lowest modes, of unit mass: squares of frequencies, rising, and columns."""
        return lowest_pairs(self._stiffness, self._mass, count, self._factor.solve)

    def _static_shapes(self, modes: Array, static: Array) -> tuple[Array, Array]:
        """Static shapes beside modes, of unit mass and orthogonal, with their frequencies."""
        length = np.sqrt(np.einsum("ik,ik->k", static, self._mass @ static))
        own = static[:, length > 0] / length[length > 0]
        for _ in range(2):  # once more for the digits that the first round loses
            own = own - modes @ (modes.T @ (self._mass @ own))
        squares, turns = la.eigh(own.T @ (self._mass @ own))
        lasting = squares > NEGLIGIBLE
        own = own @ (turns[:, lasting] / np.sqrt(squares[lasting]))
        squared, turns = la.eigh(own.T @ (self._stiffness @ own), own.T @ (self._mass @ own))
        return own @ turns, squared


def _part(matrix: sp.csr_matrix, rows: Indices, columns: Indices) -> sp.csr_matrix:
    """Some rows and columns of a matrix."""
    return sp.csr_matrix(matrix[rows][:, columns])


class Shapes:
    """T: displacements of the whole mesh by the unknowns of the reduced body."""

    def __init__(self, interface: FixedInterface, basis: InnerBasis, mass: float, dimension: int):
        """Put T together from its parts; mass in kg."""
        kept, inner = interface.kept, interface.inner
        self.used = len(kept) + basis.shapes.shape[1]
        """Number of unknowns without those that stand for nothing."""
        self.unknowns = -(-self.used // dimension) * dimension
        """Number of unknowns."""
        self._matrix = np.zeros((len(kept) + len(inner), self.unknowns))
        self._matrix[kept, np.arange(len(kept))] = 1.0
        self._matrix[inner, : len(kept)] = interface.constraint_modes
        self._matrix[inner, len(kept) : self.used] = np.sqrt(mass) * basis.shapes
        self._kept = kept

    def expanded(self, y: Array) -> Array:
        """T y, on the whole mesh."""
        return self._matrix @ y

    def unknowns_of(self, u: Array, mass: sp.csr_matrix) -> Array:
        """The y of a displacement that the shapes can have; M of the mesh."""
        y, kept = np.zeros(self.unknowns), len(self._kept)
        y[:kept] = u[self._kept]
        shapes = self._matrix[:, kept : self.used]
        own = mass @ shapes
        y[kept : self.used] = np.linalg.solve(shapes.T @ own, own.T @ (u - self.expanded(y)))
        return y

    def rows(self, unknowns: Indices) -> Array:
        """Rows of T of some unknowns of the mesh, (m, unknowns)."""
        return self._matrix[unknowns]

    def projected(self, matrix: sp.csr_matrix) -> Array:
        """T^T A T of a symmetric matrix of the mesh, (unknowns, unknowns)."""
        found = self._matrix.T @ (matrix @ self._matrix)
        return np.asarray((found + found.T) / 2)

    def pushed(self, forces: Array) -> Array:
        """T^T f of forces on the mesh, (m, n) for n of them or (m,)."""
        return self._matrix.T @ forces


class ReducedMatrices(NamedTuple):
    """Matrices of a reduced body, on the rank that owns it."""

    mass: Array
    """M, (n, n), kg."""
    stiffness: Array
    """K about the equilibrium, (n, n), N/m."""
    undeformed: Array
    """K_0 of the undeformed body, which damping goes with, (n, n), N/m; empty without damping."""
    spring: Array
    """Springs to the ground, (n, n), N/m; empty where there are none."""
    constant: Array
    """Forces of strain at y = 0, (n,), N."""
    energy: float
    """Strain energy at y = 0, J: that of the straight line through the equilibrium."""
    directional_mass: Array
    """Mass of each unknown in motion along each direction, (d, n), kg."""
    spin: Array
    """Angular velocity of the body as a whole for each velocity, (axes, n), 1/m."""


def reduced_matrices(body: ElasticBody, about: Linearised, shapes: Shapes) -> ReducedMatrices:
    """Project all matrices of a body that was linearised."""
    stiffness = shapes.projected(about.stiffness)
    still = shapes.unknowns_of(about.u, about.mass)
    force = shapes.pushed(about.force)
    turning = rigid_modes(body.arm)[body.dimension :]
    if body.dimension == 2:
        turning = [-turning[0]]  # clockwise
    else:
        turning = [turning[1], turning[2], turning[0]]  # about x, y, z
    turns = np.column_stack(turning)
    momenta = about.mass @ turns
    spin = np.linalg.solve(turns.T @ momenta, shapes.pushed(momenta).T)
    nothing = np.empty((0, 0))
    springs = about.spring.nnz > 0
    return ReducedMatrices(
        mass=shapes.projected(about.mass),
        stiffness=stiffness,
        undeformed=shapes.projected(about.undeformed) if body.damping.stiffness else nothing,
        spring=shapes.projected(about.spring) if springs else nothing,
        constant=force - stiffness @ still,
        energy=about.energy - float(force @ still) + 0.5 * float(still @ (stiffness @ still)),
        directional_mass=shapes.pushed(body.directional_mass.T).T.copy(),
        spin=spin,
    )
