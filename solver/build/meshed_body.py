"""From a mesh to the elastic body of a scene: plane or space, thickness, damping."""

from __future__ import annotations

from collections.abc import Sequence

from geometry.gmsh_model import MeshedBody
from solver.bodies.elastic_body import Damping, ElasticBody
from solver.bodies.supports import GroundSpring, Support
from solver.scene import Scene
from solver.scene.material import Material


def meshed_body(
    scene: Scene,
    name: str,
    made: MeshedBody,
    *,
    elasticity: tuple[float, float],
    density: float,
    thickness: float,
    degree: int,
    supports: Sequence[Support] = (),
    spring: GroundSpring | None = None,
) -> ElasticBody:
    """The elastic body on a mesh.

    Args:
        scene: Says plane strain, plane stress or space, and Rayleigh's damping.
        name: Of the body.
        made: Its mesh.
        elasticity: E, Pa, and nu.
        density: kg/m3.
        thickness: t, m; in space it is in the mesh.
        degree: Polynomial degree of the displacement.
        supports: Held facets.
        spring: To the ground.
    """
    plane = scene.dimension == 2
    young, poisson = elasticity
    given = scene.damping
    return ElasticBody(
        made.mesh,
        Material(
            young=young,
            poisson=poisson,
            density=density,
            plane=scene.plane if plane else "solid",
        ),
        degree=degree,
        damping=None if given is None else Damping(mass=given.mass, stiffness=given.stiffness),
        name=name,
        thickness=thickness if plane else 1.0,
        supports=supports,
        spring=spring,
    )
