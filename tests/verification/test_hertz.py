"""Hertz's line contact: half an elastic disc pressed on rigid ground, or on an equal disc.

`benchmarks/hertz.py` has more of the first. The flat side is moved down as a whole: held so, the
disc cannot roll, and the load is what contact answers with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from benchmarks.hertz import Disc, errors, l2
from benchmarks.verification.hertz import (
    HertzLine,
    centre_approach,
    contact_modulus,
    contact_radius,
)
from benchmarks.verification.load_steps import Tractions, contact_tractions, shifted, support_load
from benchmarks.verification.load_steps import pressed as pressed_by
from benchmarks.verification.pressed_disc import disc_on_disc, disc_on_ground
from solver.scene.material import Material

pytestmark = pytest.mark.serial

RADIUS, YOUNG, POISSON = 1.0, 1.0, 0.3
MODULUS = contact_modulus((YOUNG, POISSON))


def pressed(
    facets: float, ratio: float, points: str = "nodes", *, more: Sequence[float] = (1.0,)
) -> Iterator[tuple[Tractions, HertzLine]]:
    """Contact of a half disc, and Hertz's for the load that it takes, under rising loads.

    Args:
        facets: About how many there are on the half-width of the contact.
        ratio: About a/R.
        points: Rule.
        more: Half-widths over that of `ratio`, about.
    """
    half = ratio * RADIUS
    material = Material(young=YOUNG, poisson=POISSON, density=1.0)
    stepper = disc_on_ground(material, radius=RADIUS, half_width=half, facets=facets, points=points)
    u, state, reached = np.zeros(stepper.system.size), None, 0.0
    for factor in more:
        load = np.pi * MODULUS * (factor * half) ** 2 / (4 * RADIUS)
        sinking = centre_approach(HertzLine(load=load, radius=RADIUS, modulus=MODULUS))
        expected = support_load(stepper, body=0, force=(0.0, -load))
        guess = shifted(stepper, u, body=0, by=(0.0, reached - sinking))
        state = stepper.static_start(guess, load=expected, start=state)
        u, reached = state.u, sinking
        found = contact_tractions(stepper.links[0], state.contacts[0])
        taken = HertzLine(load=found.resultant[0], radius=RADIUS, modulus=MODULUS)
        assert taken.half_width == pytest.approx(factor * half, rel=0.05)
        yield found, taken


def error(found: Tractions, hertz: HertzLine) -> float:
    """L2 norm of the error of the pressure, linear between points, over that of Hertz's."""
    x = np.linspace(-1.5, 1.5, 20001) * hertz.half_width
    return l2(found.position[:, 0], found.pressure, hertz.pressure(x), x)


@pytest.mark.parametrize("points", ["nodes", "gauss"])
def test_peak_pressure_and_half_width(points):
    """At 20 facets on the half-width; what is left is the strain of a/R = 0.01."""
    found, hertz = next(pressed(20, 0.01, points))
    assert found.pressure.max() == pytest.approx(hertz.peak_pressure, rel=0.008)
    assert found.half_width == pytest.approx(hertz.half_width, rel=0.005)
    closed = found.position[found.force[:, 0] > 0, 0]
    assert np.abs(closed).max() == pytest.approx(hertz.half_width, rel=0.06)  # +- one facet
    assert error(found, hertz) < 0.03
    np.testing.assert_allclose(found.pressure, found.pressure[::-1], atol=1e-6 * MODULUS)


@pytest.mark.parametrize(("lower", "l2_error"), [(20, 0.02), (17, 0.03), (12, 0.035)])
def test_two_equal_elastic_discs(lower: int, l2_error: float) -> None:
    """Matching facets and others, 20 of the disc whose nodes are the points: peak within 3 %."""
    half, body = 0.01 * RADIUS, (YOUNG, POISSON)
    material = Material(young=YOUNG, poisson=POISSON, density=1.0)
    stepper = disc_on_disc(material, radius=RADIUS, half_width=half, facets=(20, lower))
    load = np.pi * MODULUS * half**2 / (4 * RADIUS)
    both = HertzLine(
        load=load, radius=contact_radius(RADIUS, RADIUS), modulus=contact_modulus(body, body)
    )
    assert both.half_width == pytest.approx(half)

    def approach(load: float) -> float:
        """Each disc gives way as on rigid ground under the same load."""
        return 2 * centre_approach(HertzLine(load=load, radius=RADIUS, modulus=MODULUS))

    found = next(pressed_by(stepper, [load], approach=approach))
    assert found.pressure.max() == pytest.approx(both.peak_pressure, rel=0.03)
    assert found.half_width == pytest.approx(both.half_width, rel=0.005)
    assert error(found, both) < l2_error


@pytest.mark.slow
@pytest.mark.parametrize(("facet", "published"), [(0.104, 0.065), (0.052, 0.036), (0.026, 0.018)])
def test_public_case_in_linear_elasticity(facet: float, published: float) -> None:
    """dolfinx_contact's case at its load and facets: with one value a facet its errors or less.

    Linear between the points the errors are half of that.
    """
    modulus = contact_modulus((200.0, POISSON))
    half = HertzLine(load=10.0, radius=8.0, modulus=modulus).half_width
    disc = Disc(radius=8.0, young=200.0, half=half, facet=facet * half, share=1e-6)
    found = errors(next(disc.pressed([10.0])), disc.hertz(10.0))
    assert found["l2_constant"] < 1.01 * published
    assert found["l2"] < 0.55 * published
    assert found["peak"] == pytest.approx(0.0, abs=0.005)
    assert found["half_width"] == pytest.approx(0.0, abs=0.005)


def test_pressure_converges_in_first_order():
    """L2 error at small strain.

    It depends on where in its facet the contact ends: hence the mean over loads that move the end
    through one facet.
    """
    errors = []
    for facets in (10, 20):
        ends = 1 + np.arange(8) / (8 * facets)
        squares = [error(*each) ** 2 for each in pressed(facets, 0.001, more=ends)]
        errors.append(np.sqrt(np.mean(squares)))
    assert np.log2(errors[0] / errors[1]) > 0.95
    assert errors[1] < 0.015
