"""A frame as a body: a meshed deck on columns."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np

from geometry.foundation import Frame, Plate
from geometry.frame_mesh import FrameCells, frame_mesh
from geometry.gmsh_model import MeshedBody
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.supports import Support
from solver.build.meshed_body import meshed_body
from solver.build.support import Foot, FoundationBody, Storeys, damping_of, with_top
from solver.scene import Scene
from solver.scene.damping import DampingSpec
from solver.scene.foundation import FrameSpec
from solver.types import Array


def build_frame(spec: FrameSpec, scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """Build a frame; `number` is that of its body."""
    damping = damping_of(scene, spec, lambda own: _body(spec, scene, None, own)[0])
    body, made = _body(spec, scene, damping, comm)
    return with_top(body, made, number, _storeys(spec, body))


def _storeys(spec: FrameSpec, body: ElasticBody) -> Storeys:
    """The feet and the floors of a frame, by the places of its nodes."""
    near = 1e-9 * spec.deck.width
    level = body.nodes[:, -1]
    grounded = np.flatnonzero(np.abs(level + spec.depth) < near)
    feet = []
    for centre in _centres(spec, body.dimension):
        sizes = np.array([spec.column.width, spec.column.thickness])[: body.dimension - 1]
        off = np.abs(body.nodes[grounded, :-1] - centre)
        feet.append(Foot(grounded[np.all(off < sizes / 2 + near, axis=1)], centre))
    floors = [np.flatnonzero(np.abs(level) < near)]
    return Storeys(feet, floors)


def _centres(spec: FrameSpec, dimension: int) -> list[Array]:
    """Centres of the columns in plan, in their order, m."""
    outer = (spec.deck.width - spec.column.width) / 2
    if dimension == 2:
        return [np.array([x]) for x in np.linspace(-outer, outer, spec.bays + 1)]
    side = (spec.deck.thickness - spec.column.thickness) / 2
    return [np.array([sx * outer, sy * side]) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


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
