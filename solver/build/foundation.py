"""What carries the blocks of a scene, as a body and as a surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import singledispatch

from mpi4py import MPI

import numpy as np
from dolfinx import fem

from geometry.foundation import Frame, Plate, level_frame
from geometry.frame_mesh import FrameCells, frame_mesh
from geometry.gmsh_model import MeshedBody
from geometry.mesh import plate_mesh
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.oscillator import Oscillator
from solver.bodies.supports import GroundSpring, Support
from solver.build.meshed_body import meshed_body
from solver.contact.body_points import FacePoints, FixedPoints, NodePoints, RigidPoints
from solver.contact.carrier_surface import Facets, carrier_surface
from solver.contact.facet_target import Face
from solver.contact.plane_target import Carrier, Plane
from solver.scene import Scene
from solver.scene.foundation import Foundation, FrameSpec, OscillatorSpec, PlateSpec
from solver.types import Array, Indices


@dataclass(slots=True)
class FoundationBody:
    """What carries the blocks.

    Attributes:
        dimension: Of space.
        number: Of its body in the system; None for what does not move.
        body: The body; None for what does not move.
        width: Of a plate that is held altogether and not meshed, m; None for all others.
        thickness: The same of its thickness.
        surface: Facets of the top of a meshed one.
        held: Linear displacements on the mesh of a plate that is held altogether, all of them zero.
    """

    dimension: int
    number: int | None = None
    body: Oscillator | ElasticBody | None = None
    width: float | None = None
    thickness: float | None = None
    surface: Facets | None = None
    held: fem.FunctionSpace | None = None

    def carrier(self) -> Carrier:
        """The surface that blocks stand on."""
        frame = level_frame(self.dimension)
        if self.surface is not None:
            surface = self.surface
            points: FacePoints = FixedPoints(surface.positions)
            if isinstance(self.body, ElasticBody):
                points = NodePoints(self.body, surface.layer, surface.positions)
            return Face(points, surface.nodes, frame, surface.cell, surface.degree)
        if self.width is not None:
            corners, facets, cell = self._fixed(self.width)
            return Face(FixedPoints(corners), facets, frame, cell)
        if isinstance(self.body, Oscillator):
            platform = RigidPoints(self.body, np.zeros((1, self.dimension)))
            return Plane.level(self.dimension, platform)
        return Plane.level(self.dimension)

    def _fixed(self, width: float) -> tuple[Array, Indices, str]:
        """Corners and the one facet of the top of a plate that is held altogether."""
        if self.dimension == 2:
            return np.array([[-0.5, 0.0], [0.5, 0.0]]) * width, np.array([[0, 1]]), "interval"
        signs = np.array([[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]])
        corners = np.column_stack([signs * (width, self.thickness or width), np.zeros(4)])
        return corners, np.array([[0, 1, 2, 3]]), "quadrilateral"


def foundation(scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """Build what carries the blocks; `number` is that of its body, if it is one."""
    return _built(scene.foundation, scene, number, comm)


@singledispatch
def _built(spec: Foundation, scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """The foundation of a kind: rigid ground, unless a builder is registered below."""
    return FoundationBody(scene.dimension)


@_built.register
def _oscillator(
    spec: OscillatorSpec, scene: Scene, number: int, comm: MPI.Intracomm
) -> FoundationBody:
    """A rigid platform on a spring."""
    platform = scene.platform()
    body = Oscillator(
        mass=platform.mass,
        stiffness=platform.stiffness,
        dashpot=platform.damping,
        dimension=scene.dimension,
        comm=comm,
    )
    return FoundationBody(scene.dimension, number, body)


@_built.register
def _plate(spec: PlateSpec, scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """A meshed plate on its bottom, or on rollers and a spring; held altogether as a rigid face."""
    dimension = scene.dimension
    if spec.support == "fixed" and not spec.meshed:
        return FoundationBody(dimension, width=spec.width, thickness=spec.thickness)
    made = plate_mesh(
        Plate(width=spec.width, height=spec.height, thickness=spec.thickness),
        dimension=dimension,
        cells=spec.cells,
        cell=spec.cell,
        comm=comm,
    )
    if spec.support == "fixed":
        space = fem.functionspace(made.mesh, ("Lagrange", 1, (dimension,)))
        surface = carrier_surface(space, made.facet_tags, int(FacetTag.TOP))
        return FoundationBody(dimension, surface=surface, held=space)
    bottom = made.facet_tags.find(FacetTag.BOTTOM)
    spring, directions = None, tuple(range(dimension))
    if spec.on_spring:
        platform = scene.platform()
        spring = GroundSpring(facets=bottom, stiffness=platform.stiffness, dashpot=platform.damping)
        directions = (dimension - 1,)
    body = meshed_body(
        scene,
        "plate",
        made,
        material=spec.material(scene.material_plane, scene.carried_mass),
        thickness=spec.thickness,
        degree=spec.degree,
        damping=scene.damping_of(spec),
        supports=[Support(facets=bottom, directions=directions)],
        spring=spring,
    )
    return _with_top(body, made, number)


@_built.register
def _frame(spec: FrameSpec, scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """A meshed deck on columns."""
    dimension = scene.dimension
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
    made = frame_mesh(frame, dimension=dimension, cells=cells, comm=comm)
    return _on_feet(spec, scene, made, spec.deck.thickness, number)


def _on_feet(
    spec: FrameSpec, scene: Scene, made: MeshedBody, thickness: float, number: int
) -> FoundationBody:
    """A mesh that is clamped at its feet and carries blocks on its top; `thickness`: t, m."""
    feet = made.facet_tags.find(FacetTag.FEET)
    body = meshed_body(
        scene,
        spec.kind,
        made,
        material=spec.material(scene.material_plane),
        thickness=thickness,
        degree=spec.degree,
        damping=scene.damping_of(spec),
        supports=[Support(facets=feet, directions=tuple(range(scene.dimension)))],
    )
    return _with_top(body, made, number)


def _with_top(body: ElasticBody, made: MeshedBody, number: int) -> FoundationBody:
    """A meshed body that carries blocks on its top."""
    surface = carrier_surface(body.space, made.facet_tags, int(FacetTag.TOP))
    return FoundationBody(body.dimension, number, body, surface=surface)


def natural_period(scene: Scene) -> float:
    """Longest natural period of the meshed foundation of a scene, without its blocks, s.

    Computed on every rank for itself.

    Raises:
        ValueError: For a foundation without a mesh, or one that nothing deforms.
    """
    from solver.bodies.modes import eigenvalues  # scipy's sparse solvers take their time

    body = foundation(scene, 0, MPI.COMM_SELF).body
    if not isinstance(body, ElasticBody):
        raise ValueError(f"a foundation of kind {scene.foundation.kind} has no mesh that moves")
    return 2 * math.pi / math.sqrt(float(eigenvalues(body)[0]))
