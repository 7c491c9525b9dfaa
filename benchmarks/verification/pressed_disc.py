"""An elastic half disc on rigid ground or on another one, to be pressed: Hertz's line contact."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np

from benchmarks.verification.disc_mesh import disc_mesh
from benchmarks.verification.fixed_pair import FixedPair, faces_on
from geometry.gmsh_model import MeshedBody
from geometry.mesh import move
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, Support
from solver.contact.body_points import NodePoints
from solver.contact.carriers import Face, Plane
from solver.contact.facets import carrier_surface
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
    made = _mesh(radius, half_width, facets)
    body = _held(made, material)
    law = FrictionSpec(static=0.0)
    contact = faces_on(body, made.facet_tags, ground or Plane.level(2), law, points=points)
    return Stepper(System([body]), [FixedPair(contact)], GeneralizedAlpha(0.8), gravity=np.zeros(2))


def disc_on_disc(
    material: Material,
    *,
    radius: float,
    half_width: float,
    facets: tuple[float, float],
    points: str = "nodes",
) -> Stepper:
    """Two equal half discs that touch in the origin, without friction; the upper one is pressed.

    Args:
        material: Elasticity of both.
        radius: R, m.
        half_width: As for `disc_on_ground`.
        facets: Number of facets on that half-width, of the upper disc and of the lower one.
        points: Rule for the contact points, which are those of the upper disc.
    """
    upper, lower = (_mesh(radius, half_width, each) for each in facets)
    move(lower.mesh, lambda x: -x)
    bodies = [_held(made, material) for made in (upper, lower)]
    surface = carrier_surface(bodies[1].space, lower.facet_tags, int(FacetTag.BOTTOM))
    nodes = NodePoints(bodies[1], surface.layer, surface.positions)
    face = Face(nodes, surface.nodes, np.eye(2)[::-1], surface.cell, surface.degree)
    law = FrictionSpec(static=0.0)
    contact = faces_on(bodies[0], upper.facet_tags, face, law, points=points)
    pair = FixedPair(contact, on=1)
    return Stepper(System(bodies), [pair], GeneralizedAlpha(0.8), gravity=np.zeros(2))


def _mesh(radius: float, half_width: float, facets: float) -> MeshedBody:
    """Half a disc on y = 0 with so many facets on the half-width of the contact."""
    return disc_mesh(
        radius,
        size=half_width / facets,
        core=CORE_RATIO * half_width,
        growth=GROWTH,
        comm=MPI.COMM_SELF,
    )


def _held(made: MeshedBody, material: Material) -> ElasticBody:
    """The body of a half disc, whose flat side is held."""
    flat = Support(facets=made.facet_tags.find(FacetTag.TOP), directions=(0, 1))
    return ElasticBody(made.mesh, material, supports=[flat])
