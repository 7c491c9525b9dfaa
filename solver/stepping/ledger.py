"""The energy ledger of a step: what it stored, took in and lost, each from its own formula."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.parallel import global_sum
from solver.stepping.state import Exchange, State
from solver.stepping.system import System
from solver.types import Array

if TYPE_CHECKING:
    from solver.stepping.stepper import Stepper


def energies(system: System, state: State) -> tuple[float, float, float]:
    """Kinetic, strain and spring energy, J, at the displacements last given to the bodies."""
    kinetic = strain = stored = 0.0
    for body, own in zip(system.bodies, system.slices, strict=True):
        kinetic += 0.5 * float(state.v[own] @ body.inertia(state.v[own]))
        if isinstance(body, ElasticBody):
            strain += body.strain_energy()
        spring = body.spring(state.u[own])
        if spring is not None:
            stored += 0.5 * float(state.u[own] @ spring)
    total = global_sum(system.comm, np.array([kinetic, strain, stored]))
    return float(total[0]), float(total[1]), float(total[2])


def _present(force: Array | None) -> Array:
    """A force that is there."""
    assert force is not None
    return force


class StepLedger:
    """Energies of the new state before the velocity solve; what damping and averaging took.

    With r = p + F a step loses skew du.dr to the averaging of forces, and du.C du/dt to
    damping.
    """

    def __init__(self, stepper: Stepper, old: State, new: State, dt: float, skew: float):
        """Take the states at both ends of a step; the energies of `new` are filled in.

        Args:
            stepper: Bodies, interfaces and ground.
            old: State at t_n.
            new: At t_{n+1}.
            dt: Step, s.
            skew: Of the scheme of the step, 1/2 - alpha_f.
        """
        self._stepper, self._old, self._new, self._dt = stepper, old, new, dt
        self._skew = skew

    def exchange(self, residual: Array) -> Exchange:
        """Work of the ground, losses by damping and in time integration.

        Args:
            residual: What the iteration left out of balance (owned unknowns), N.
        """
        stepper, old, new = self._stepper, self._old, self._new
        system = stepper.system
        du = new.u - old.u
        # kinetic, strain, spring, du.dr, loss by damping, work of what is left of the residual
        sums = np.zeros(6 + system.dimension)
        sums[5] = residual @ du
        sums[6:] = system.directional_mass @ du
        sums[3] = du @ (new.p - old.p)
        for body, own in zip(system.bodies, system.slices, strict=True):
            moved = du[own]
            sums[0] += 0.5 * float(new.v[own] @ body.inertia(new.v[own]))
            if isinstance(body, ElasticBody):
                self._elastic(body, sums)
            spring = body.spring(moved)
            if spring is not None:
                sums[2] += 0.5 * float(new.u[own] @ _present(body.spring(new.u[own])))
                sums[3] += float(moved @ spring)
            drag = body.drag(moved)
            if drag is not None:
                sums[4] += float(drag @ moved) / self._dt
        total = global_sum(system.comm, sums)
        new.kinetic, new.strain, new.spring = (float(value) for value in total[:3])
        return self._booked(total)

    def _elastic(self, body: ElasticBody, sums: Array) -> None:
        """Strain energy, and the parts of stiffness and strain-rate damping."""
        squared = body.increment_energy()
        sums[1] += body.strain_energy()
        sums[3] += squared
        sums[4] += body.damping.stiffness * squared / self._dt

    def _booked(self, total: Array) -> Exchange:
        """The exchange, from sums over all ranks."""
        stepper, old, new = self._stepper, self._old, self._new
        moved, increment = total[6:], float(total[3])
        for link, first, last in zip(stepper.links, old.contacts, new.contacts, strict=True):
            increment -= link.interface.theta_increment(first, last)
        return Exchange(
            input=-float(moved @ stepper.mean_base(old.time, self._dt)),
            damping=float(total[4]),
            numerical=float(self._skew * increment - total[5]),
        )
