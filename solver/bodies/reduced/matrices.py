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
    """What a reduced body is made of, on the rank that owns it."""

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
