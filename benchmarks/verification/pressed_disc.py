"""An elastic half disc on rigid ground, ready to be pressed: Hertz's line contact."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np

from benchmarks.verification.disc_mesh import disc_mesh
from benchmarks.verification.fixed_pair import FixedPair, faces_on
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, Support
from solver.contact.carriers import Plane
from solver.scene import FrictionSpec
from solver.scene.material import Material
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.stepper import Stepper
from solver.stepping.system import System

#: Half-width of the finest part of the mesh over the largest half-width of the contact.
CORE_RATIO = 1.5

#: Growth of the layers of cells away from the contact.
GROWTH = 1.2


def disc_on_ground(
    material: Material,
    *,
    radius: float,
    half_width: float,
    facets: float,
    points: str = "nodes",
    ground: Plane | None = None,
) -> Stepper:
    """Half a disc in plane strain that touches rigid, frictionless ground at its lowest point.

    Its flat side, at the height R, is held as a whole: `load_steps.pressed` moves it. There is no
    gravity. Every rank that calls this has a disc of its own.

    Args:
        material: Elasticity of the disc.
        radius: R, m.
        half_width: Largest half-width of the contact to be expected, m, at most R/6.
        facets: Number of facets on that half-width.
        points: Rule for the contact points, "nodes" or "gauss".
        ground: What the disc is pressed on; None: the level y = 0.
    """
    made = disc_mesh(
        radius,
        size=half_width / facets,
        core=CORE_RATIO * half_width,
        growth=GROWTH,
        comm=MPI.COMM_SELF,
    )
    top = Support(facets=made.facet_tags.find(FacetTag.TOP), directions=(0, 1))
    body = ElasticBody(made.mesh, material, supports=[top])
    law = FrictionSpec(static=0.0)
    contact = faces_on(body, made.facet_tags, ground or Plane.level(2), law, points=points)
    return Stepper(System([body]), [FixedPair(contact)], GeneralizedAlpha(0.8), gravity=np.zeros(2))
