"""The matrices of a reduced body, by Galerkin's projection of those of the mesh on its shapes.

    u = u_s + T (y - y_s),    A_y = T^T A T,    T = (1  0; Psi  Phi)

The unknowns y are the displacements of the nodes that are kept, node by node, and the amplitudes of
the shapes of the inner part; these are scaled to the mass of the whole body, so that they are
lengths, too. Numbers of nodes go up to whole ones: amplitudes that no shape has are held.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.kinematics import rigid_modes
from solver.bodies.reduced.craig_bampton import FixedInterface, InnerBasis
from solver.bodies.reduced.linearised import Linearised
from solver.types import Array, Indices


class Shapes:
    """Displacements of the whole mesh by the unknowns of the reduced body."""

    def __init__(self, interface: FixedInterface, basis: InnerBasis, mass: float, dimension: int):
        """Take T from its parts; mass in kg."""
        self.kept, self.inner, self._constraint = (
            interface.kept,
            interface.inner,
            interface.constraint_modes,
        )
        self._basis = np.sqrt(mass) * basis.shapes
        self.used = len(self.kept) + self._basis.shape[1]
        """Number of unknowns without those that stand for nothing."""
        self.owned = -(-self.used // dimension)
        """Number of groups of d unknowns: nodes kept, then amplitudes."""
        self.unknowns = self.owned * dimension

    def expanded(self, y: Array) -> Array:
        """T y, on the whole mesh."""
        kept, amplitudes = y[: len(self.kept)], y[len(self.kept) : self.used]
        u = np.empty(len(self.kept) + len(self.inner))
        u[self.kept] = kept
        u[self.inner] = self._constraint @ kept + self._basis @ amplitudes
        return u

    def amplitudes_of(self, u: Array, mass: sp.csr_matrix) -> Array:
        """The unknowns y of a displacement that the shapes can have; M of the mesh."""
        y = np.zeros(self.unknowns)
        y[: len(self.kept)] = u[self.kept]
        inner = u[self.inner] - self._constraint @ u[self.kept]
        own = mass[self.inner][:, self.inner] @ self._basis
        y[len(self.kept) : self.used] = np.linalg.solve(self._basis.T @ own, own.T @ inner)
        return y

    def rows(self, unknowns: Indices) -> Array:
        """Rows of T of some unknowns of the mesh, (m, unknowns)."""
        found = np.zeros((len(unknowns), self.unknowns))
        place = np.full(len(self.kept) + len(self.inner), -1)
        place[self.kept] = np.arange(len(self.kept))
        kept = place[unknowns] >= 0
        found[np.flatnonzero(kept), place[unknowns[kept]]] = 1.0
        place[:] = -1
        place[self.inner] = np.arange(len(self.inner))
        inner = place[unknowns[~kept]]
        found[~kept, : len(self.kept)] = self._constraint[inner]
        found[~kept, len(self.kept) : self.used] = self._basis[inner]
        return found

    def projected(self, matrix: sp.csr_matrix) -> Array:
        """T^T A T of a symmetric matrix of the mesh, (unknowns, unknowns)."""
        k = len(self.kept)
        rows, inner = matrix[self.kept], matrix[self.inner]
        own, coupling = inner[:, self.inner], inner[:, self.kept]
        shapes = np.hstack([self._constraint, self._basis])
        moved = own @ shapes
        moved[:, :k] += coupling.toarray()
        small = shapes.T @ moved
        both = rows[:, self.inner] @ shapes
        both[:, :k] += rows[:, self.kept].toarray()
        small[:k] += both
        result = np.zeros((self.unknowns, self.unknowns))
        result[: self.used, : self.used] = (small + small.T) / 2
        return result

    def pushed(self, forces: Array) -> Array:
        """T^T f of forces on the mesh, (m, n) for n of them or (m,)."""
        inner = forces[self.inner]
        result = np.zeros((self.unknowns, *forces.shape[1:]))
        result[: len(self.kept)] = forces[self.kept] + self._constraint.T @ inner
        result[len(self.kept) : self.used] = self._basis.T @ inner
        return result


class ReducedMatrices(NamedTuple):
    """What a reduced body is made of, on the rank that owns it."""

    mass: Array
    """M, (n, n), kg."""
    stiffness: Array
    """K about the equilibrium, (n, n), N/m."""
    undeformed: Array
    """That of the undeformed body, which damping goes with; empty without such damping."""
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
    still = shapes.amplitudes_of(about.u, about.mass)
    force = shapes.pushed(about.force)
    turning = rigid_modes(body.arm)[body.dimension :]
    if body.dimension == 2:
        turning = [-turning[0]]  # clockwise
    elif body.dimension == 3:
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
