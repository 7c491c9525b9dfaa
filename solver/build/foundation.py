"""What carries the blocks of a scene, as a body and as a surface."""

from __future__ import annotations

import math
from functools import singledispatch

from mpi4py import MPI

from dolfinx import fem

from geometry.foundation import Plate
from geometry.gmsh_model import MeshedBody
from geometry.mesh import plate_mesh
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, GroundSpring, Support
from solver.bodies.rigid_body import Oscillator
from solver.build.frame import build_frame
from solver.build.meshed_body import meshed_body
from solver.build.support import FoundationBody, damping_of, with_top
from solver.contact.facets import carrier_surface
from solver.excitation.motion import GroundMotion, read_ground
from solver.scene import Scene
from solver.scene.damping import DampingSpec
from solver.scene.foundation import Foundation, OscillatorSpec, PlateSpec


def foundation(
    scene: Scene, number: int, comm: MPI.Intracomm, ground: GroundMotion | None = None
) -> FoundationBody:
    """Build what carries the blocks; `number` is that of its body, if it is one.

    The motion of the ground is read where it is needed and not given.
    """

    def meshed(own: MPI.Intracomm) -> FoundationBody:
        """The foundation on a mesh, if it has one."""
        return _built(scene.foundation, scene, number, own)

    if scene.foundation.reduced_modes is None:
        return meshed(comm)
    from solver.build.reduction import reduced_foundation  # scipy's solvers take their time

    ground = ground or read_ground(scene, comm)
    return reduced_foundation(scene, number, comm, ground, meshed)


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
    """A meshed plate on its bottom, on rollers and a spring, or fully restrained.

    That which is fully restrained is a rigid face unless it is to be meshed.
    """
    if spec.support == "fixed":
        if spec.meshed:
            return _held_plate(spec, scene, comm)
        return FoundationBody(scene.dimension, width=spec.width, thickness=spec.thickness)
    damping = damping_of(scene, spec, lambda own: _plate_body(spec, scene, None, own)[0])
    return with_top(*_plate_body(spec, scene, damping, comm), number)


def _held_plate(spec: PlateSpec, scene: Scene, comm: MPI.Intracomm) -> FoundationBody:
    """A meshed plate that is fully restrained."""
    made = _plate_mesh(spec, scene, comm)
    space = fem.functionspace(made.mesh, ("Lagrange", 1, (scene.dimension,)))
    surface = carrier_surface(space, made.facet_tags, int(FacetTag.TOP))
    return FoundationBody(scene.dimension, surface=surface, held=space)


def _plate_mesh(spec: PlateSpec, scene: Scene, comm: MPI.Intracomm) -> MeshedBody:
    """The mesh of a plate."""
    return plate_mesh(
        Plate(width=spec.width, height=spec.height, thickness=spec.thickness),
        dimension=scene.dimension,
        cells=spec.cells,
        cell=spec.cell,
        comm=comm,
    )


def _plate_body(
    spec: PlateSpec, scene: Scene, damping: DampingSpec | None, comm: MPI.Intracomm
) -> tuple[ElasticBody, MeshedBody]:
    """The body of a plate, and its mesh."""
    dimension, made = scene.dimension, _plate_mesh(spec, scene, comm)
    bottom = made.facet_tags.find(FacetTag.BOTTOM)
    spring, directions = None, tuple(range(dimension))
    if spec.on_spring:
        platform = scene.platform()
        along = (platform.stiffness,) * (dimension - 1)
        delay = platform.damping / platform.stiffness
        spring = GroundSpring(facets=bottom, stiffness=(*along, 0.0), delay=delay)
        directions = (dimension - 1,)
    body = meshed_body(
        scene,
        "plate",
        made,
        material=spec.material(scene.material_plane, scene.carried_mass),
        thickness=spec.thickness,
        degree=spec.degree,
        damping=damping,
        supports=[Support(facets=bottom, directions=directions)],
        spring=spring,
    )
    return body, made


_built.register(build_frame)


def reduction_in_words(scene: Scene, ground: GroundMotion) -> tuple[str, ...]:
    """What is left of the mesh of a reduced foundation; computed on every rank for itself."""
    found = foundation(scene, 0, MPI.COMM_SELF, ground).reduction
    assert found is not None
    return found.in_words()


def natural_period(scene: Scene) -> float:
    """Longest natural period of the meshed foundation of a scene, without its blocks, s.

    Computed on every rank for itself.

    Raises:
        ValueError: For a foundation without a mesh, or one that nothing deforms.
    """
    from solver.bodies.modes import eigenvalues  # scipy's sparse solvers take their time

    body = _built(scene.foundation, scene, 0, MPI.COMM_SELF).body
    if not isinstance(body, ElasticBody):
        raise ValueError(f"a foundation of kind {scene.foundation.kind} has no mesh that moves")
    return 2 * math.pi / math.sqrt(float(eigenvalues(body)[0]))
