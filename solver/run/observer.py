"""Rows of the history, one for each step."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.bodies.rigid_body import Oscillator
from solver.build.assembly import Assembly
from solver.build.foundation import FoundationBody
from solver.history.columns import DISSIPATED_ENERGIES
from solver.history.engine_rows import energy_columns, platform_columns, rows_of, run_columns
from solver.history.events import Event
from solver.history.link_columns import LinkRows
from solver.parallel import global_sum
from solver.resumable import Resumable
from solver.run.block_observer import BlockObserver
from solver.run.structure_observer import StructureObserver
from solver.scene.link import LinkSpec
from solver.stepping.state import Exchange, State
from solver.types import Array

_EXCHANGED = attrgetter("input", *DISSIPATED_ENERGIES)
"""Energies that a step takes in and dissipates, of an `Exchange`."""


class Observer(Resumable):
    """Motion of all blocks and of the platform, and the energy ledger.

    Slip and the dissipated energies are carried on from step to step, so every step has to be seen.
    """

    CARRIED = ("_exchanged", "_start", "_blocks", "_platform")

    def __init__(
        self,
        assembly: Assembly,
        state: State,
        names: Sequence[str],
        links: Sequence[LinkSpec] = (),
    ):
        """Start where the run starts; `names` are the columns that are written down."""
        self._stepper = assembly.stepper
        members = {member.spec.name: member for member in assembly.members}
        self._blocks = [
            BlockObserver(member, self._stepper, state, members.get(member.spec.carrier))
            for member in assembly.members
        ]
        self._platform = None
        if "platform.drift_m" in names:
            self._platform = PlatformObserver(assembly)
        self._structure = None
        if "foundation.overturning_moment_Nm" in names:
            self._structure = StructureObserver(assembly)
        self._links = LinkRows(links, self._stepper.system.dimension) if links else None
        self.names = tuple(names)
        # The datum of what carries the blocks is where it stands without load.
        self._at_rest = sum(
            member.body.mass * float(self._stepper.gravity @ member.body.centre)
            for member in assembly.members
        )
        self._exchanged: Sequence[float] = [0.0] * (1 + len(DISSIPATED_ENERGIES))
        self._start: float | None = None

    def row(self, state: State, exchange: Exchange, step: float) -> Array:
        """The values of a history row, in the order of the columns.

        Args:
            state: Where a step led.
            exchange: What it exchanged.
            step: Its length, s.
        """
        links = self._stepper.links
        closed = sum(np.count_nonzero(memory.force[:, 0] > 0) for memory in state.contacts)
        base = self._stepper.base(state.time)
        known = run_columns(state.time, step, exchange.iterations, closed, base)
        for block in self._blocks:
            known |= block.columns(state, links)
        if self._platform is not None:
            forces = exchange.ground or self._stepper.ground_forces(state)
            shear = global_sum(self._stepper.system.comm, forces.total)
            known |= platform_columns(*self._platform.motion(state, step), -shear)
            if self._structure is not None:
                known |= self._structure.columns(state, forces)
        if self._links is not None:
            known |= self._links.columns(self._link_numbers(state)[None])
        known |= self._energies(state, exchange)
        return rows_of(self.names, known)[0]

    def _link_numbers(self, state: State) -> Array:
        """All links in a state, as `LinkStates` takes them apart."""
        attached = self._stepper.attached
        assert attached is not None and state.body_links is not None
        return attached.links.numbers(state.body_links)

    def link_events(self, before: State, after: State) -> tuple[Event, ...]:
        """What happened to links in the step between two states."""
        if self._links is None:
            return ()
        numbers = np.array([self._link_numbers(state) for state in (before, after)])
        return tuple(self._links.events(numbers, np.array([after.time])))

    def _energies(self, state: State, exchange: Exchange) -> dict[str, Any]:
        """Stored, taken in and dissipated energy, J."""
        stepper, system = self._stepper, self._stepper.system
        moved = global_sum(system.comm, system.directional_mass.dot(state.u))
        gravity = -self._at_rest - float(stepper.gravity.dot(moved))
        interface = stepper.interface_energy(state)
        stored = state.kinetic, state.strain, gravity, state.spring, interface
        now = zip(self._exchanged, _EXCHANGED(exchange), strict=True)
        self._exchanged = [before + step for before, step in now]
        if self._start is None:
            self._start = sum(stored)
        return energy_columns(stored, self._exchanged, self._start)


class PlatformObserver(Resumable):
    """Drift, velocity and acceleration of what carries the blocks, where it moves as a whole."""

    CARRIED = ("velocity",)

    def __init__(self, assembly: Assembly):
        """Start at rest."""
        self._support, system = assembly.support, assembly.stepper.system
        assert assembly.support.number is not None
        self._own = system.slices[assembly.support.number]
        self.velocity: Array | None = None

    def motion(self, state: State, step: float) -> tuple[Array, Array, Array]:
        """Drift, velocity and acceleration along x, in space along y, too, after a step, (d - 1,).

        The acceleration is the increment of velocity over the step, impulses of contact counted in.
        """
        drift, velocity = (self._mean(vector[self._own]) for vector in (state.u, state.v))
        before = velocity if self.velocity is None else self.velocity
        self.velocity = velocity
        return drift, velocity, np.asarray((velocity - before) / step)

    def _mean(self, vector: Array) -> Array:
        """Horizontal components of the platform's motion."""
        return mean_of_top(self._support, vector)[:-1]


def mean_of_top(support: FoundationBody, vector: Array) -> Array:
    """Mean of a displacement or velocity over the top of a foundation that moves, (d,).

    By its owned unknowns; collective.
    """
    body, surface = support.body, support.surface
    if isinstance(body, Oscillator):
        return np.append(body.replicate(vector), 0.0)
    assert isinstance(body, ElasticBody | ReducedBody) and surface is not None
    nodes = surface.layer.gather(vector.reshape(-1, body.dimension))
    total: Array = np.add.reduce(nodes, axis=0)
    return total / len(nodes)
