"""A bar that bounces against a wall, with the exact answer (Dabaghi et al. 2014).

The bar stands on the floor as a strip of one cell's width, without gravity and without Poisson
effect, its top held, first stretched upwards; the amplitude is so small that strains are linear.
Time stepping and contact are those of every run.
"""

from __future__ import annotations

from dataclasses import dataclass

from mpi4py import MPI

import bar_impact
import numpy as np
import pytest

from benchmarks.verification.fixed_pair import FixedPair, faces_on
from geometry.block import Block
from geometry.mesh import block_mesh
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, Support
from solver.contact.carriers import Plane
from solver.scene import FrictionSpec
from solver.scene.material import Material
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.stepper import Stepper
from solver.stepping.system import System

AMPLITUDE = 1e-6
ELEMENTS = 100
END = 4 * bar_impact.PERIOD


@dataclass(frozen=True, slots=True)
class Bounce:
    """Errors over four periods of the bar, relative to the exact solution."""

    highest_energy: float
    changes: int
    displacement_error: float
    stress_error: float
    ledger_error: float


def bounce(rho_inf: float, gamma: float) -> Bounce:
    """Run the bar at CFL 1."""
    h = 1.0 / ELEMENTS
    shape = Block(width=h, height=1.0, thickness=1.0, density=1.0)
    domain = block_mesh(
        shape, cells=(1, ELEMENTS), cell="quadrilateral", refinement=1.0, comm=MPI.COMM_SELF
    )
    material = Material(young=1.0, poisson=0.0, density=1.0)
    top = Support(facets=domain.facet_tags.find(FacetTag.TOP), directions=(0, 1))
    body = ElasticBody(domain.mesh, material, supports=[top])
    law = FrictionSpec(static=0.0)
    contact = FixedPair(faces_on(body, domain.facet_tags, Plane.level(2), law, gamma=gamma))
    stepper = Stepper(System([body]), [contact], GeneralizedAlpha(rho_inf), gravity=np.zeros(2))
    x = body.nodes[:, 1]
    u = np.zeros_like(body.nodes)
    u[:, 1] = AMPLITUDE * (1 - x) / 2
    state = stepper.start(u.ravel(), np.zeros(u.size))

    def energy() -> float:
        return state.kinetic + state.strain + stepper.interface_energy(state)

    start = energy()
    assert start == pytest.approx(AMPLITUDE**2 * h * bar_impact.ENERGY, rel=1e-5)
    highest, changes, closed, error_u, error_s, lost = start, 0, False, 0.0, 0.0, 0.0
    ledger = 0.0
    dt = h
    for k in range(round(END / dt)):
        state, exchange = stepper.advance(state, dt)
        t = (k + 1) * dt
        lost += exchange.contact + exchange.numerical
        highest = max(highest, energy())
        ledger = max(ledger, abs(energy() - start + lost))
        pressure = state.contacts[0].force[:, 0].sum() / h / AMPLITUDE
        changes += (pressure > 0) != closed
        closed = pressure > 0
        exact = bar_impact.displacement(t, x)
        error = state.u.reshape(-1, 2)[:, 1] / AMPLITUDE - exact
        error_u = max(error_u, float(np.sqrt(np.mean(error**2))))
        error_s += dt * (pressure + float(bar_impact.contact_stress(t - dt / 2))) ** 2
    norm = np.sqrt(1 / 12)  # of the first displacement, and of the contact stress in time
    return Bounce(
        highest_energy=highest / start,
        changes=int(changes),
        displacement_error=error_u / norm,
        stress_error=float(np.sqrt(error_s / END)) / norm,
        ledger_error=ledger / start,
    )


@pytest.mark.parametrize("gamma", [10.0, 100.0])
@pytest.mark.parametrize("rho_inf", [1.0, 0.8, 0.5, 0.0])
def test_bar_against_a_wall(rho_inf: float, gamma: float) -> None:
    """Four periods: eight changes of contact, energy never rises, first-order errors."""
    result = bounce(rho_inf, gamma)
    assert 8 <= result.changes <= 10
    assert result.highest_energy < 1.0001
    assert result.displacement_error < (0.10 if rho_inf == 0 else 0.06)
    assert result.stress_error < 0.30
    assert result.ledger_error < 1e-8
