"""The linearised sliding of a meshed block on rigid ground."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np
from dolfinx import fem

from geometry.tags import FacetTag
from solver.bodies.elastic_body import Support
from solver.bodies.flutter import SlidingModes, sliding_modes
from solver.build.meshed_body import mesh_of_block, meshed_body
from solver.scene import BlockSpec, Scene


def modes_of_sliding(scene: Scene, block: BlockSpec) -> SlidingModes:
    """The modes of an elastic block of a scene that slides; on every rank for itself."""
    d = scene.dimension
    made = mesh_of_block(scene, block, MPI.COMM_SELF)
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
