"""Meshes of blocks, the elastic body on a mesh, and the linearised sliding of a block."""

from __future__ import annotations

from collections.abc import Sequence

from mpi4py import MPI

import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import assemble_scalar

from geometry.body_faces import BodyFaces
from geometry.body_mesh import body_mesh, cells_of_parts, cells_of_surface
from geometry.cells import Cells
from geometry.compat import geometry_nodes
from geometry.gmsh_model import MeshedBody
from geometry.mesh import block_mesh, shape_mesh
from geometry.mesh_file import STEPS, cells_of_step
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, GroundSpring, Support
from solver.bodies.elastic_forms import Region
from solver.bodies.flutter import SlidingModes, sliding_modes
from solver.errors import Statement
from solver.scene import BlockSpec, Scene
from solver.scene.damping import DampingSpec
from solver.scene.material import Material
from solver.scene.quantities import Dimension
from solver.types import Array


def mesh_of_block(
    scene: Scene, block: BlockSpec, comm: MPI.Intracomm
) -> tuple[MeshedBody, tuple[BodyFaces, ...]]:
    """The mesh of an elastic block of a scene, in its own frame; collective.

    With the faces that contact sees, of its hull and of its parts; none where they are those of its
    shape.

    Raises:
        SceneError: Gmsh makes no mesh of its shape.
    """
    solid = block.shape.solid
    if solid is None:
        made = block_mesh(
            block.shape,
            dimension=scene.dimension,
            cells=block.cells,
            cell=block.cell,
            refinement=block.refinement,
            comm=comm,
        )
        return made, ()
    if solid.is_convex and solid.surface is None:
        return shape_mesh(solid.parts[0], block.cell_size, comm), ()
    parts = () if solid.surface is not None else solid.parts
    try:
        found = body_mesh(
            block.name, lambda: _cells(block, scene.dimension), scene.dimension, parts, comm
        )
    except ValueError as error:
        raise Statement(f"{block.name}.shape:", str(error)) from None
    return found.made, found.faces


def _cells(block: BlockSpec, dimension: Dimension) -> Cells:
    """The cells of an elastic block that is neither a box nor convex, in its own frame."""
    shape, solid = block.given_shape, block.shape.solid
    assert solid is not None
    if solid.surface is None:
        return cells_of_parts(solid.parts, block.cell_size)
    assert shape is not None
    if shape.is_mesh:
        return shape.cells().moved(block.shift(dimension))
    if shape.file is not None and shape.file.suffix.lower() in STEPS:
        cells = cells_of_step(shape.file, shape.scale, block.cell_size)
        return cells.moved(block.shift(dimension))
    return cells_of_surface(solid.surface, block.cell_size)


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
    given = block.relative_density()
    if given is None:
        return _of_mesh(block, domain)
    cells = domain.geometry.x[geometry_nodes(domain)][:, :, : domain.geometry.dim] - origin
    found = fem.Function(fem.functionspace(domain, ("DG", given.degree)))
    found.x.array[found.function_space.dofmap.list.ravel()] = given.in_cells(cells).ravel()
    return found


def _of_mesh(block: BlockSpec, domain: mesh.Mesh) -> fem.Function | None:
    """The density by which a mesh that fills its surface not quite has all of its mass.

    None where there is no surface, or the mesh has its volume.
    """
    solid = block.shape.solid
    if solid is None or solid.surface is None:
        return None
    own = assemble_scalar(fem.form(fem.Constant(domain, 1.0) * ufl.dx(domain)))
    factor = solid.volume / domain.comm.allreduce(own)
    if abs(factor - 1) < 1e-12:
        return None
    found = fem.Function(fem.functionspace(domain, ("DG", 0)))
    found.x.array[:] = factor
    return found


def modes_of_sliding(scene: Scene, block: BlockSpec) -> SlidingModes:
    """The modes of an elastic block of a scene that slides; on every rank for itself."""
    d = scene.dimension
    made, faces = mesh_of_block(scene, block, MPI.COMM_SELF)
    below = faces[0].points[FacetTag.BOTTOM] if faces else {int(FacetTag.BOTTOM)}
    base = made.facet_tags.indices[np.isin(made.facet_tags.values, list(below))]
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
