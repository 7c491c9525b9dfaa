"""A frame as a body: a meshed deck on columns."""

from __future__ import annotations

from mpi4py import MPI

from geometry.foundation import Frame, Plate
from geometry.frame_mesh import FrameCells, frame_mesh
from geometry.gmsh_model import MeshedBody
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.supports import Support
from solver.build.meshed_body import meshed_body
from solver.build.support import FoundationBody, damping_of, with_top
from solver.scene import Scene
from solver.scene.damping import DampingSpec
from solver.scene.foundation import FrameSpec


def build_frame(spec: FrameSpec, scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """Build a frame; `number` is that of its body."""
    damping = damping_of(scene, spec, lambda own: _body(spec, scene, None, own)[0])
    return with_top(*_body(spec, scene, damping, comm), number)


def _body(
    spec: FrameSpec, scene: Scene, damping: DampingSpec | None, comm: MPI.Intracomm
) -> tuple[ElasticBody, MeshedBody]:
    """The body of a frame, clamped at its feet, and its mesh."""
    made = _mesh(spec, scene.dimension, comm)
    feet = made.facet_tags.find(FacetTag.FEET)
    body = meshed_body(
        scene,
        spec.kind,
        made,
        material=spec.material(scene.material_plane),
        thickness=spec.deck.thickness,
        degree=spec.degree,
        damping=damping,
        supports=[Support(facets=feet, directions=tuple(range(scene.dimension)))],
    )
    return body, made


def _mesh(spec: FrameSpec, dimension: int, comm: MPI.Intracomm) -> MeshedBody:
    """The mesh of a frame; collective."""
    deck = Plate(width=spec.deck.width, height=spec.deck.height, thickness=spec.deck.thickness)
    frame = Frame(
        deck=deck,
        column_width=spec.column.width,
        storey=spec.storey,
        bays=spec.bays,
        column_thickness=spec.column.thickness if dimension == 3 else None,
    )
    cells = FrameCells(
        bay=spec.cells.bay,
        column=spec.cells.column,
        deck=spec.cells.deck,
        storey=spec.cells.storey,
    )
    return frame_mesh(frame, dimension=dimension, cells=cells, comm=comm)
