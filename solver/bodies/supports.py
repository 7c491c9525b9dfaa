"""Supports of a meshed body: held facets, and springs to the ground."""

from __future__ import annotations

from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np
import ufl
from dolfinx import fem, mesh
from numpy.typing import NDArray

from solver.bodies.packed_form import PackedForm


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
