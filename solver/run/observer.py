"""Rows of the history, one for each step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from operator import attrgetter
from typing import Any

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.bodies.rigid_body import Oscillator
from solver.build.assembly import Assembly
from solver.build.block_body import BlockBody
from solver.build.foundation import FoundationBody
from solver.history.columns import (
    DISSIPATED_ENERGIES,
    check_filled,
    columns,
    positions,
    row_layout,
)
from solver.history.events import Event
from solver.history.link_columns import LinkRows
from solver.parallel import global_sum
from solver.run.block_observer import BlockObserver
from solver.run.structure_observer import StructureObserver, write_base_shear
from solver.scene.link import LinkSpec
from solver.stepping.state import Exchange, State
from solver.types import Array

STORED = ("kinetic", "strain", "gravity", "spring", "interface")
"""Energies that a state stores, in the order in which they are added up."""

EXCHANGED = ("input", *DISSIPATED_ENERGIES)
"""Energies that a step takes in and dissipates: the fields of an `Exchange`."""


_EXCHANGED = attrgetter(*EXCHANGED)


class Observer:
    """Motion of all blocks and of the platform, and the energy ledger.

    Slip and the dissipated energies are carried on from step to step, so every step has to be seen.
    """

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
        d, moves = self._stepper.system.dimension, self._platform is not None
        self._columns = columns(
            list(members),
            dimension=d,
            platform=moves,
            vertical=True,
            second=d == 3,
            structure=None if self._structure is None else self._structure.parts,
            links={link.name: not link.is_axial for link in links},
            feet={name: member.spec.shape.feet for name, member in members.items()},
        )
        self._links = LinkRows(links, self._columns, d) if links else None
        self._layout = row_layout(len(members), dimension=d, platform=moves)
        self.names = tuple(names)
        self._written = np.array([self._columns.index(name) for name in names])
        self._row = np.full(len(self._columns), np.nan)  # filled anew at every step
        self._run = positions("run", d)
        self._feet = [  # those of each block stand one after another
            self._row[first : first + count * d].reshape(count, d)
            for first, count in self._feet_of(members)
        ]
        layout = self._layout
        starts = layout.block + layout.stride * np.arange(len(members))
        self._parts = [self._row[first : first + layout.stride] for first in starts]
        # The datum of what carries the blocks is where it stands without load.
        self._at_rest = sum(
            member.body.mass * float(self._stepper.gravity @ member.body.centre)
            for member in assembly.members
        )
        self._exchanged = [0.0] * len(EXCHANGED)
        # The columns of the energies stand one after another, in this order.
        at, energies = positions("energy", d), (*STORED, *EXCHANGED, "total", "ledger_error")
        places = [getattr(at, f"{name}_J") for name in energies]
        assert places == [*range(places[0], places[-1] + 1)]
        self._energies = slice(places[0], places[-1] + 1)
        self._start: float | None = None

    def _feet_of(self, members: Mapping[str, BlockBody]) -> Iterator[tuple[int, int]]:
        """The first column of the feet of each block, and how many feet it has."""
        for name, member in members.items():
            count = member.spec.shape.feet
            yield self._columns.index(f"{name}.foot_1.normal_force_N") if count else 0, count

    def saved(self) -> dict[str, Any]:
        """Values carried on from step to step, for `resume`."""
        return {
            "own": (self._exchanged, self._start),
            "blocks": [block.saved() for block in self._blocks],
            "platform": None if self._platform is None else self._platform.velocity,
        }

    def resume(self, saved: dict[str, Any]) -> None:
        """Go on from the steps that another observer of the scene has seen."""
        self._exchanged, self._start = saved["own"]
        for block, own in zip(self._blocks, saved["blocks"], strict=True):
            block.resume(own)
        if self._platform is not None:
            self._platform.velocity = saved["platform"]

    def row(self, state: State, exchange: Exchange, step: float) -> Array:
        """The values of a history row, in the order of the columns.

        Args:
            state: Where a step led.
            exchange: What it exchanged.
            step: Its length, s.
        """
        links = self._stepper.links
        layout, row, run = self._layout, self._row, self._run
        row[run.time_s], row[run.step_s] = state.time, step
        row[run.newton_iterations] = exchange.iterations
        row[run.contact_points_closed] = sum(
            np.count_nonzero(memory.force[:, 0] > 0)
            for memory in state.contacts
            if not memory.clear
        )
        ground = self._stepper.base(state.time)
        row[run.base_acceleration_m_s2] = ground[0]
        row[run.base_vertical_acceleration_m_s2] = ground[-1]
        if len(ground) == 3:
            row[run.base_second_acceleration_m_s2] = ground[1]
        for block, part in zip(self._blocks, self._parts, strict=True):
            block.write(state, links, part)
        for block, feet in zip(self._blocks, self._feet, strict=True):
            block.write_feet(state, feet)
        if self._platform is not None:
            self._platform.write(state, step, row[layout.platform : layout.energy])
        if self._structure is not None:
            self._structure.write(state, exchange, row[layout.foundation :])
        elif self._platform is not None:
            forces = exchange.ground or self._stepper.ground_forces(state)
            write_base_shear(forces, self._stepper.system.comm, row[layout.foundation :])
        if self._links is not None:
            self._links.write(row[None], self._link_numbers(state)[None])
        begins = self._start is None
        self._write_energies(state, exchange, row[layout.energy :])
        if begins:
            check_filled(self._columns, row[None])
        return row.take(self._written)

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

    def _write_energies(self, state: State, exchange: Exchange, row: Array) -> None:
        """Stored, taken in and dissipated energy, J."""
        stepper, system = self._stepper, self._stepper.system
        moved = global_sum(system.comm, system.directional_mass.dot(state.u))
        gravity = -self._at_rest - float(stepper.gravity.dot(moved))
        interface = stepper.interface_energy(state)
        stored = state.kinetic, state.strain, gravity, state.spring, interface
        now = zip(self._exchanged, _EXCHANGED(exchange), strict=True)
        taken, *lost = self._exchanged = [before + step for before, step in now]
        total = sum(stored)
        if self._start is None:
            self._start = total
        error = total - self._start - taken + sum(lost)
        row[self._energies] = *stored, taken, *lost, total, error


class PlatformObserver:
    """Drift, velocity and acceleration of what carries the blocks, where it moves as a whole."""

    def __init__(self, assembly: Assembly):
        """Start at rest."""
        self._support, system = assembly.support, assembly.stepper.system
        assert assembly.support.number is not None
        self._own = system.slices[assembly.support.number]
        self.velocity: Array | None = None

    def write(self, state: State, step: float, row: Array) -> None:
        """Drift, velocity, acceleration along x; in space the same along y.

        The acceleration is the increment of velocity over the step, impulses of contact counted in.
        """
        drift, velocity = (self._mean(vector[self._own]) for vector in (state.u, state.v))
        before = velocity if self.velocity is None else self.velocity
        self.velocity = velocity
        at = positions("platform", len(drift) + 1)
        for k, way in enumerate(("", "_second")[: len(drift)]):
            row[getattr(at, f"drift{way}_m")] = drift[k]
            row[getattr(at, f"velocity{way}_m_s")] = velocity[k]
            row[getattr(at, f"acceleration{way}_m_s2")] = (velocity[k] - before[k]) / step

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
