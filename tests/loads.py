"""Loads on meshed bodies that scenes do not know."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx import fem, la, mesh

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.packed_form import PackedForm


def surface_force(body: ElasticBody, facets: np.ndarray, traction: Sequence[float]) -> np.ndarray:
    """Forces of a traction (Pa) on boundary facets, per undeformed area, on the owned unknowns."""
    domain = body.space.mesh
    order = np.argsort(facets)
    tags = mesh.meshtags(
        domain, domain.topology.dim - 1, facets[order], np.ones(len(facets), dtype=np.int32)
    )
    ds = ufl.Measure("ds", domain, subdomain_data=tags)(1)
    value = fem.Constant(domain, body.thickness * np.asarray(traction, dtype=float))
    form = PackedForm(ufl.inner(value, ufl.TestFunction(body.space)) * ds)
    vector = la.vector(body.space.dofmap.index_map, body.space.dofmap.index_map_bs)
    form.vector(vector.array)
    vector.scatter_reverse(la.InsertMode.add)
    force = vector.array[: body.size].copy()
    force[body.fixed] = 0.0
    return force
