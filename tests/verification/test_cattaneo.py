"""Cattaneo and Mindlin: two equal half discs pressed together, then sheared.

Equal bodies, so that pressing causes no friction and shearing no pressure, as in the closed form.
Friction then depends on the past: the load steps go on from the memory of contact.
"""

from __future__ import annotations

from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
import pytest

from benchmarks.verification.disc_mesh import disc_mesh
from benchmarks.verification.fixed_pair import FixedPair, faces_on
from benchmarks.verification.hertz import (
    HertzLine,
    contact_modulus,
    contact_radius,
    shear_traction,
    stick_half_width,
)
from benchmarks.verification.load_steps import Tractions, contact_tractions, shifted, support_load
from geometry.mesh import move
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, Support
from solver.contact.carriers import Face
from solver.contact.facets import carrier_surface
from solver.scene import FrictionSpec
from solver.scene.material import Material
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.stepper import Stepper
from solver.stepping.system import System

pytestmark = pytest.mark.serial

RADIUS, YOUNG, POISSON, FRICTION = 1.0, 1.0, 0.3, 0.3
HALF, FACETS = 0.01, 20
MODULUS = contact_modulus((YOUNG, POISSON), (YOUNG, POISSON))
PAIR = contact_radius(RADIUS, RADIUS)
LOAD = np.pi * MODULUS * HALF**2 / (4 * PAIR)
SHEARED = 0.5
"""Q/(mu P)."""


@dataclass
class Sequence:
    """Tractions pressed, then after each step of shear."""

    pressed: Tractions
    steps: list[Tractions]


@pytest.fixture(scope="module")
def discs() -> Stepper:
    """The upper one carried by the lower one, which is the same turned round."""
    size, core = HALF / FACETS, 1.5 * HALF
    upper, lower = (
        disc_mesh(RADIUS, size=size, core=core, growth=1.2, comm=MPI.COMM_SELF) for _ in range(2)
    )
    move(lower.mesh, np.negative)
    material = Material(young=YOUNG, poisson=POISSON, density=1.0)
    bodies = [
        ElasticBody(
            made.mesh,
            material,
            supports=[Support(facets=made.facet_tags.find(FacetTag.TOP), directions=(0, 1))],
        )
        for made in (upper, lower)
    ]
    surface = carrier_surface(bodies[1].space, lower.facet_tags, int(FacetTag.BOTTOM))
    frame = np.array([[0.0, 1.0], [1.0, 0.0]])
    face = Face.of_mesh(bodies[1], surface, frame)
    law = FrictionSpec(static=FRICTION)
    contact = FixedPair(faces_on(bodies[0], upper.facet_tags, face, law), on=1)
    return Stepper(System(bodies), [contact], GeneralizedAlpha(0.8), gravity=np.zeros(2))


@pytest.fixture(scope="module")
def sequence(discs) -> Sequence:
    """Pressed by about P, then sheared in steps to about Q = mu P/2."""

    def seen() -> Tractions:
        return contact_tractions(discs.links[0], state.contacts[0])

    expected = support_load(discs, body=0, force=(0.0, -LOAD))
    compliance = (2 * np.log(4 * RADIUS / HALF) - 1) / (np.pi * MODULUS)  # of both discs
    start = shifted(discs, np.zeros(discs.system.size), body=0, by=(0.0, -LOAD * compliance))
    state = discs.static_start(start, load=expected)
    pressed, steps = seen(), []
    count, shift = 5, 0.1 * SHEARED * FRICTION * LOAD * compliance
    for number in range(count + 1):
        moved = shifted(discs, state.u, body=0, by=(shift, 0.0))
        state = discs.static_start(moved, load=expected, start=state)
        steps.append(seen())
        if not number:  # the first step tells how stiff it is
            missing = SHEARED * FRICTION * LOAD + steps[0].resultant[1]
            shift *= missing / count / -steps[0].resultant[1]
    return Sequence(pressed, steps)


def loads(found: Tractions) -> tuple[HertzLine, float]:
    """Hertz's contact for the normal force, and the tangential force, on the upper disc."""
    normal, tangential = found.resultant
    return HertzLine(load=normal, radius=PAIR, modulus=MODULUS), float(tangential)


def zone(found: Tractions) -> float:
    """Half-width of the stick zone: its ends lie between the last points that stick and slip."""
    closed = found.force[:, 0] > 0
    sticking = np.flatnonzero(closed & ~found.slipping)
    x = found.position[:, 0]
    assert np.all(np.diff(sticking) == 1)
    first, last = sticking[0], sticking[-1]
    return float(x[last : last + 2].mean() - x[first - 1 : first + 1].mean()) / 2


def test_pressing_equal_bodies_causes_no_friction(sequence):
    hertz, tangential = loads(sequence.pressed)
    assert abs(tangential) < 1e-7 * hertz.load
    assert np.abs(sequence.pressed.shear).max() < 1e-3 * hertz.peak_pressure
    assert sequence.pressed.pressure.max() == pytest.approx(hertz.peak_pressure, rel=0.01)


def test_stick_zone_shrinks_as_it_should(sequence):
    """In every step from a quarter of the friction on, to within the distance of points."""
    for found in sequence.steps:
        hertz, tangential = loads(found)
        expected = stick_half_width(hertz, tangential, FRICTION)
        assert zone(found) == pytest.approx(expected, abs=0.55 * hertz.half_width / FACETS)


def test_tractions(sequence):
    """L2 errors over the points, in relation to the closed forms."""
    found = sequence.steps[-1]
    hertz, tangential = loads(found)
    # The contact moves along: by half as much as the upper disc.
    x = found.position[:, 0]
    x = x - found.force[:, 0] @ x / hertz.load
    exact = shear_traction(hertz, tangential, FRICTION, x)
    for values, reference, most in (
        (found.pressure, hertz.pressure(x), 0.02),
        (found.shear[:, 0], exact, 0.04),
    ):
        error = np.sqrt(found.weight @ (values - reference) ** 2)
        assert error < most * np.sqrt(found.weight @ reference**2)
