"""Supports that move, and contact forces as tractions: a bar between two plates."""

from mpi4py import MPI

import numpy as np
import pytest

from benchmarks.verification.fixed_pair import FixedPair, faces_on
from benchmarks.verification.load_steps import (
    contact_tractions,
    nodal_pressure,
    shifted,
    support_load,
)
from geometry.block import Block
from geometry.mesh import block_mesh
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, Support
from solver.contact.body_points import NodePoints
from solver.contact.carriers import Plane
from solver.contact.facets import carrier_surface
from solver.contact.interface import Interface
from solver.contact.pairs import Link
from solver.scene import FrictionSpec
from solver.scene.material import Material
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.stepper import Stepper
from solver.stepping.system import System

pytestmark = pytest.mark.serial

WIDTH, HEIGHT, YOUNG, SHORTER = 0.5, 2.0, 3.0, 1e-6


@pytest.fixture(scope="module")
def made():
    shape = Block(width=WIDTH, height=HEIGHT, thickness=1.0, density=1.0)
    return block_mesh(shape, cells=(3, 4), comm=MPI.COMM_SELF)


@pytest.fixture(scope="module")
def stepper(made) -> Stepper:
    """A bar that stands on rigid ground; its top is held along its axis."""
    top = Support(facets=made.facet_tags.find(FacetTag.TOP), directions=(1,))
    material = Material(young=YOUNG, poisson=0.0, density=1.0)
    body = ElasticBody(made.mesh, material, supports=[top])
    law = FrictionSpec(static=0.5)
    contact = FixedPair(faces_on(body, made.facet_tags, Plane.level(2), law))
    return Stepper(System([body]), [contact], GeneralizedAlpha(0.8), gravity=np.zeros(2))


def test_top_moved_down_presses(stepper):
    """P = E B strain, evenly, as what contact transmits; moved on, the rest follows."""
    force = YOUNG * WIDTH * SHORTER / HEIGHT
    load = support_load(stepper, body=0, force=(0.0, -force))
    assert load.sum() == pytest.approx(-force)
    assert np.flatnonzero(load).tolist() == sorted(stepper.system.bodies[0].fixed)
    u, state = np.zeros(stepper.system.size), None
    for factor in (1, 2):
        guess = shifted(stepper, u, body=0, by=(0.0, -SHORTER))
        state = stepper.static_start(guess, load=load, start=state)
        u = state.u
        found = contact_tractions(stepper.links[0], state.contacts[0])
        assert found.resultant == pytest.approx([factor * force, 0.0], rel=1e-5, abs=1e-5 * force)
        assert found.pressure == pytest.approx(factor * force / WIDTH, rel=1e-5)
        assert np.abs(found.shear).max() < 1e-5 * force
        nodal = nodal_pressure(stepper.links[0], state.contacts[0])
        assert nodal == pytest.approx(factor * force / WIDTH, rel=1e-5)
        assert found.place[:, 0] == pytest.approx(np.linspace(-0.5, 0.5, 4) * WIDTH)
        assert found.weight.sum() == pytest.approx(WIDTH)
        assert not found.slipping.any()


def test_what_has_no_area_has_no_tractions(made, stepper):
    body = stepper.system.bodies[0]
    surface = carrier_surface(body.space, made.facet_tags, int(FacetTag.TOP))
    corners = NodePoints(body, surface.layer, surface.positions)
    interface = Interface(corners, Plane.level(2), FrictionSpec(static=0.0))
    link = Link(interface, 0, None)
    for function in (contact_tractions, nodal_pressure):
        with pytest.raises(TypeError, match="NodePoints"):
            function(link, None)


def test_support_load_needs_a_support(stepper):
    with pytest.raises(ValueError, match="not held in direction 0"):
        support_load(stepper, body=0, force=(1.0, 0.0))
