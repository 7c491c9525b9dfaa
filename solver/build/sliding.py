"""The linearised sliding of a meshed block on rigid ground."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np
from dolfinx import fem

from geometry.mesh import block_mesh
from geometry.tags import FacetTag
from solver.bodies.flutter import SlidingModes, sliding_modes
from solver.bodies.supports import Support
from solver.build.meshed_body import meshed_body
from solver.scene import BlockSpec, Scene


def modes_of_sliding(scene: Scene, block: BlockSpec) -> SlidingModes:
    """The modes of an elastic block of a scene that slides; on every rank for itself."""
    d, comm = scene.dimension, MPI.COMM_SELF
    made = block_mesh(
        block.shape,
        dimension=d,
        cells=block.cells,
        cell=block.cell,
        refinement=block.refinement,
        comm=comm,
    )
    base = made.facet_tags.find(FacetTag.BOTTOM)
    body = meshed_body(
        scene,
        block.name,
        made,
        material=block.material(scene.material_plane),
        thickness=block.thickness,
        degree=block.degree,
        damping=None,
        supports=[Support(facets=base, directions=(d - 1,))],
    )
    nodes = fem.locate_dofs_topological(body.space, d - 1, base)
    return sliding_modes(body, np.sort(nodes), scene.bending_frequency(block))
