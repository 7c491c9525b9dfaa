"""What is worth writing down of each step: one row of the history."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.oscillator import Oscillator
from solver.bodies.reduced.body import ReducedBody
from solver.build.assembly import Assembly
from solver.history.columns import (
    DISSIPATED_ENERGIES,
    check_filled,
    columns,
    positions,
    row_layout,
)
from solver.parallel import global_sum
from solver.run.block_observer import BlockObserver
from solver.run.structure_observer import StructureObserver
from solver.stepping.state import Exchange, State
from solver.types import Array

STORED = ("kinetic", "strain", "gravity", "spring", "interface")
"""Energies that a state stores, in the order in which they are added up."""

EXCHANGED = ("input", *DISSIPATED_ENERGIES)
"""What a step takes in and dissipates: the fields of an `Exchange`."""


_EXCHANGED = attrgetter(*EXCHANGED)


class Observer:
    """Motion of all blocks and of the platform, and the energy ledger.

    Slip and the dissipated energies are carried on from step to step, so every step has to be seen.
    """

    def __init__(self, assembly: Assembly, state: State, names: Sequence[str]):
        """Start where the run starts; `names` are the columns that are written down."""
        self._stepper = assembly.stepper
        members = {member.spec.name: member for member in assembly.members}
        self._blocks = [
            BlockObserver(member, self._stepper, state, members.get(member.spec.on))
            for member in assembly.members
        ]
        self._platform = None
        if "platform.drift_m" in names:
            self._platform = PlatformObserver(assembly)
        self._structure = None
        if "foundation.base_shear_N" in names:
            self._structure = StructureObserver(assembly)
        d, moves = self._stepper.system.dimension, self._platform is not None
        self._columns = columns(
            list(members),
            dimension=d,
            platform=moves,
            vertical=True,
            second=d == 3,
            structure=None if self._structure is None else self._structure.parts,
        )
        self._layout = row_layout(len(members), dimension=d, platform=moves)
        self._written = [self._columns.index(name) for name in names]
        # The datum of what carries the blocks is where it stands without load.
        self._at_rest = sum(
            member.body.mass * float(self._stepper.gravity @ member.body.centre)
            for member in assembly.members
        )
        self._exchanged = np.zeros(len(EXCHANGED))
        at = positions("energy", d)
        energies = *STORED, *EXCHANGED, "total", "ledger_error"
        self._energies = [getattr(at, f"{name}_J") for name in energies]
        self._start: float | None = None

    def saved(self) -> dict[str, Any]:
        """What is carried on from step to step, for `resume`."""
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

    def row(self, state: State, exchange: Exchange, step: float) -> list[float]:
        """The values of a history row, in the order of the columns."""
        layout, row = self._layout, np.full(len(self._columns), np.nan)
        run = positions("run", self._stepper.system.dimension)
        row[run.time_s], row[run.step_s] = state.time, step
        row[run.newton_iterations] = exchange.iterations
        row[run.contact_points_closed] = sum(
            int((memory.force[:, 0] > 0).sum()) for memory in state.contacts
        )
        ground = self._stepper.base(state.time)
        row[run.base_acceleration_m_s2] = ground[0]
        row[run.base_vertical_acceleration_m_s2] = ground[-1]
        if len(ground) == 3:
            row[run.base_second_acceleration_m_s2] = ground[1]
        for number, block in enumerate(self._blocks):
            first = layout.block + layout.stride * number
            block.write(state, row[first : first + layout.stride])
        if self._platform is not None:
            self._platform.write(state, step, row[layout.platform : layout.energy])
        if self._structure is not None:
            self._structure.write(state, exchange, row[layout.foundation :])
        begins = self._start is None
        self._write_energies(state, exchange, row[layout.energy :])
        if begins:
            check_filled(self._columns, row[None])
        written: Any = row.take(self._written).tolist()
        return list(written)

    def _write_energies(self, state: State, exchange: Exchange, row: Array) -> None:
        """Stored, taken in and dissipated energy, J."""
        stepper, system = self._stepper, self._stepper.system
        moved = global_sum(system.comm, system.directional_mass @ state.u)
        gravity = -self._at_rest - float(stepper.gravity @ moved)
        interface = stepper.interface_energy(state)
        stored = state.kinetic, state.strain, gravity, state.spring, interface
        self._exchanged += _EXCHANGED(exchange)
        taken, *lost = self._exchanged.tolist()
        total = sum(stored)
        if self._start is None:
            self._start = total
        error = total - self._start - taken + sum(lost)
        row[self._energies] = [*stored, taken, *lost, total, error]


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
        """Horizontal components of the platform's motion: of a meshed one, the mean of its top."""
        body, surface = self._support.body, self._support.surface
        if isinstance(body, Oscillator):
            return body.replicate(vector)
        assert isinstance(body, ElasticBody | ReducedBody) and surface is not None
        nodes = surface.layer.gather(vector.reshape(-1, body.dimension))
        return np.asarray(nodes.mean(axis=0)[:-1])
