"""The energy ledger of a step: what it stored, took in and lost, each from its own formula."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import NamedTuple

from mpi4py import MPI

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.elastic_forms import MOST_COMPRESSED
from solver.bodies.reduced_body import ReducedBody
from solver.contact.memory import Memory
from solver.contact.pairs import Link
from solver.parallel import any_rank, global_sum
from solver.stepping.system import System
from solver.types import Array


@dataclass(slots=True)
class Energies:
    """Energies of all bodies, J: kinetic, of strain, and of springs to the ground."""

    kinetic: float = 0.0
    strain: float = 0.0
    spring: float = 0.0


@dataclass(slots=True)
class StepSums:
    """Sums of a step over all bodies."""

    energies: Energies
    """Energies at t_{n+1}, J."""
    moved: Array
    """Sum of m du along each direction, (d,), kg m."""
    increment: float = 0.0
    """du.dr with r = p + F but for the theta term of contact, J."""
    damping: float = 0.0
    """du.C du/dt, J."""
    residual: float = 0.0
    """Work of what the iteration left out of balance, J."""

    def over_ranks(self, comm: MPI.Intracomm) -> StepSums:
        """The sums over all ranks, in one message."""
        if comm.size == 1:
            return self
        work = self.increment, self.damping, self.residual
        own = np.concatenate([self.moved, astuple(self.energies), work])
        d = len(self.moved)
        total = global_sum(comm, own)
        kinetic, strain, spring, increment, damping, residual = (float(x) for x in total[d:])
        energies = Energies(kinetic, strain, spring)
        return StepSums(energies, total[:d], increment, damping, residual)


def energies(system: System, u: Array, v: Array) -> Energies:
    """Energies at displacements (m) and velocities (m/s) of the owned unknowns; collective."""
    total = _own_energies(system, u, v)
    sums = global_sum(system.comm, np.array(astuple(total)))
    return Energies(*(float(value) for value in sums))


def _own_energies(system: System, u: Array, v: Array) -> Energies:
    """This rank's part of the energies."""
    total = Energies()
    for body, own in system.members:
        total.kinetic += 0.5 * float(v[own].dot(body.inertia(v[own])))
    for meshed, own in system.meshed:
        total.strain += meshed.strain_energy(u[own])
    for body, own in system.tied:
        spring = body.spring(u[own])
        if spring is not None:
            total.spring += 0.5 * float(u[own] @ spring)
    return total


BEYOND_LAW = "is compressed beyond St. Venant-Kirchhoff's law"
"""What is said of a body whose strain energy is infinite."""


def beyond_law(system: System, u: Array) -> str:
    """Which bodies are strained beyond their law at displacements u (m), in words; collective."""
    found = [
        body.name
        for body, own in system.meshed
        if any_rank(system.comm, not math.isfinite(body.strain_energy(u[own])))
    ]
    left = math.sqrt(1 - 2 * MOST_COMPRESSED)
    return f"{' and '.join(found)} {BEYOND_LAW}, to less than {left:.2f} of a length"


class StepEnds(NamedTuple):
    """Both ends of a step, before velocities are corrected."""

    dt: float
    """Step, s."""
    u: Array
    """u_{n+1}, m."""
    v: Array
    """v_{n+1}, m/s."""
    du: Array
    """u_{n+1} - u_n, m."""
    mean: Array
    """du/dt, m/s."""
    impulsive: Sequence[Array | None]
    """`impulsive_force` of each body, N; None: it has none."""
    residual: Array
    """Residual of the iteration, N."""
    inertia: Array
    """M (u_{n+1} - u_n - dt v_n), kg m."""


def step_sums(system: System, ends: StepEnds, dp: Array) -> StepSums:
    """Sums of a step, from its ends; collective.

    `dp` is p_{n+1} - p_n in the frame of the middle of the step, N.
    """
    du, dt = ends.du, ends.dt
    sums = StepSums(
        energies=_own_energies(system, ends.u, ends.v),
        moved=system.directional_mass.dot(du),
        increment=float(du.dot(dp)),
        residual=float(ends.residual.dot(du)),
    )
    for body, own, viscous in zip(system.bodies, system.slices, ends.impulsive, strict=True):
        if isinstance(body, ElasticBody) and viscous is not None:
            # The gradient of du at the midpoint is dE: du.C du/dt is beta_R/dt times int dE:C:dE.
            lost = float(viscous.dot(du[own]))
            sums.damping += lost
            sums.increment += dt / body.damping.stiffness * lost
        elif isinstance(body, ElasticBody | ReducedBody):
            sums.increment += body.increment_energy(ends.u[own])
            if viscous is not None:
                sums.damping += float(viscous @ du[own])
    for body, own in system.tied:
        spring, drag = body.spring(du[own]), body.drag(du[own])
        if spring is not None:
            sums.increment += float(du[own] @ spring)
        if drag is not None:
            sums.damping += float(drag @ du[own]) / dt
    return sums.over_ranks(system.comm)


def numerical_loss(
    sums: StepSums,
    links: Sequence[Link],
    *,
    old: Sequence[Memory],
    new: Sequence[Memory],
    skew: float,
) -> float:
    """Energy that the averaging of forces takes, skew du.dr, less the work of the residual, J.

    By what the step adds up, and all interfaces' memories at its ends; skew is 1/2 - alpha_f of the
    scheme of the step.
    """
    increment = sums.increment
    for link, first, last in zip(links, old, new, strict=True):
        increment -= link.interface.theta_increment(first, last)
    return skew * increment - sums.residual
