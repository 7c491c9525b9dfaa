"""Meshes of blocks, the elastic body on a mesh, and the linearised sliding of a block."""

from __future__ import annotations

from collections.abc import Sequence

from mpi4py import MPI

import numpy as np
from dolfinx import fem, mesh

from geometry.density import LinearDensity
from geometry.gmsh_model import MeshedBody
from geometry.mesh import block_mesh, shape_mesh
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, GroundSpring, Support
from solver.bodies.elastic_forms import Region
from solver.bodies.flutter import SlidingModes, sliding_modes
from solver.scene import BlockSpec, Scene
from solver.scene.damping import DampingSpec
from solver.scene.material import Material
from solver.types import Array


def mesh_of_block(scene: Scene, block: BlockSpec, comm: MPI.Intracomm) -> MeshedBody:
    """The mesh of an elastic block of a scene, in its own frame; collective."""
    if block.shape.solid is not None:
        return shape_mesh(block.shape.solid.parts[0], block.cell_size, comm)
    return block_mesh(
        block.shape,
        dimension=scene.dimension,
        cells=block.cells,
        cell=block.cell,
        refinement=block.refinement,
        comm=comm,
    )


def meshed_body(
    scene: Scene,
    name: str,
    made: MeshedBody,
    *,
    material: Material,
    thickness: float,
    degree: int,
    damping: DampingSpec | None,
    supports: Sequence[Support] = (),
    spring: GroundSpring | None = None,
    regions: Sequence[Region] = (),
    density: fem.Function | None = None,
) -> ElasticBody:
    """The elastic body on a mesh.

    Args:
        scene: Says whether it is in the plane or in space.
        name: Of the body.
        made: Its mesh.
        material: What it is made of.
        thickness: t, m; in space it is in the mesh.
        degree: Polynomial degree of the displacement.
        damping: Its Rayleigh damping; None: it has none.
        supports: Held facets.
        spring: To the ground.
        regions: Cells of other materials.
        density: Over that of the material; None: it is the same everywhere.
    """
    return ElasticBody(
        made.mesh,
        material,
        degree=degree,
        damping=damping,
        name=name,
        thickness=thickness if scene.dimension == 2 else 1.0,
        supports=supports,
        spring=spring,
        regions=regions,
        density=density,
    )


def relative_density(block: BlockSpec, domain: mesh.Mesh, origin: Array) -> fem.Function | None:
    """The density of a block over its mean, on its mesh; None: it is the same everywhere.

    One that varies linearly is exact; parts count by their mean over each cell.

    Args:
        block: The block.
        domain: Its mesh, unrotated.
        origin: Of its own frame there, m.
    """
    given, d = block.relative_density(), domain.geometry.dim
    if given is None:
        return None
    if isinstance(given, LinearDensity):
        found = fem.Function(fem.functionspace(domain, ("Lagrange", 1)))
        points = found.function_space.tabulate_dof_coordinates()[:, :d]
        found.x.array[:] = given.at(points - origin)
        return found
    found = fem.Function(fem.functionspace(domain, ("DG", 0)))
    nodes = domain.geometry.x[domain.geometry.dofmap][:, :, :d] - origin
    simplices = domain.basix_cell().name in ("triangle", "tetrahedron")
    found.x.array[found.function_space.dofmap.list.ravel()] = given.means(
        nodes, simplices=simplices
    )
    return found


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
        density=relative_density(block, made.mesh, np.zeros(d)),
    )
    nodes = fem.locate_dofs_topological(body.space, d - 1, base)
    return sliding_modes(body, np.sort(nodes), scene.bending_frequency(block))
