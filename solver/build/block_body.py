"""A block of a scene as a body: meshed or rigid, with the surfaces that contact sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
from dolfinx.mesh import MeshTags

from geometry.arrangement import Pose
from geometry.body_faces import BodyFaces, faces_of_block
from geometry.mesh import move
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.rigid_body import RigidBox, rigid_box
from solver.build.meshed_body import mesh_of_block, meshed_body, relative_density
from solver.contact.surfaces import BlockSurface
from solver.scene import BlockSpec, Scene


@dataclass(slots=True)
class BlockBody:
    """A block as a body.

    Attributes:
        spec: What the scene says of it.
        body: The body.
        number: Of the body in the system.
        upright: From the block's own frame to the body's reference configuration.
        start: From there to where it begins.
        surface: Its surface, that of its convex hull.
        parts: Those of its convex parts; of a convex body its surface.
        facet_tags: Of its mesh; None: it is rigid.
        carriers: Numbers of the bodies that carry it.
    """

    spec: BlockSpec
    body: ElasticBody | RigidBox
    number: int
    upright: Pose
    start: Pose
    surface: BlockSurface
    parts: tuple[BlockSurface, ...]
    facet_tags: MeshTags | None = None
    carriers: tuple[int, ...] = ()


def block_body(
    scene: Scene, number: int, upright: Pose, start: Pose, comm: MPI.Intracomm
) -> BlockBody:
    """A block by its number: meshed upright at its place, or rigid; collective."""
    spec, d = scene.blocks[number], scene.dimension
    faces: Sequence[BodyFaces] = ()
    facet_tags: MeshTags | None = None
    body: ElasticBody | RigidBox
    if spec.model == "rigid":
        centre = np.array(spec.shape.centre_of_mass(d))
        body = rigid_box(spec.name, spec.shape, upright(centre[None])[0], comm=comm)
    else:
        made, faces = mesh_of_block(scene, spec, comm)
        move(made.mesh, upright)
        facet_tags = made.facet_tags
        body = meshed_body(
            scene,
            spec.name,
            made,
            material=spec.material(scene.material_plane),
            thickness=spec.thickness,
            degree=spec.degree,
            damping=scene.damping_of(spec),
            density=relative_density(spec, made.mesh, upright(np.zeros((1, d)))[0]),
        )
    ends, by = upright(np.array(spec.shape.bottom_corners(d))), upright(np.zeros((1, d)))[0]
    hull, *parts = (
        BlockSurface(body, number, each.moved(by), scene.contact, facet_tags, ends=ends)
        for each in faces or faces_of_block(spec.shape, d)
    )
    return BlockBody(spec, body, number, upright, start, hull, tuple(parts) or (hull,), facet_tags)
