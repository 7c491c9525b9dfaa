"""What a history tells of a meshed structure: base shear, moments, storeys and columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced.body import ReducedBody
from solver.build.assembly import Assembly
from solver.history.columns import Structure, positions
from solver.parallel import global_sum
from solver.stepping.state import Exchange, GroundForces, State
from solver.types import Array, Indices

WAYS = ("", "_second")
"""Names of the horizontal directions within those of columns."""


class StructureObserver:
    """Forces of a structure on the ground, and the motion of its storeys, means of each step."""

    def __init__(self, assembly: Assembly):
        """Start at rest."""
        self._stepper, support = assembly.stepper, assembly.support
        assert support.number is not None and isinstance(support.body, ElasticBody | ReducedBody)
        self._body, self._storeys = support.body, support.storeys
        self._own = self._stepper.system.slices[support.number]
        d = self._body.dimension
        self._at = tuple(positions(part, d) for part in ("foundation", "storey", "column"))

    @property
    def parts(self) -> Structure:
        """Numbers of storeys and columns."""
        return Structure(len(self._storeys.floors), len(self._storeys.feet))

    def write(self, state: State, exchange: Exchange, row: Array) -> None:
        """The columns of the structure, of its storeys and of its columns, in this order."""
        forces = exchange.ground or self._stepper.ground_forces(state)
        own, storey, column = self._at
        self._write_base(forces, state, row)
        floors = row[len(own) :]
        self._write_storeys(state, floors)
        feet = floors[len(storey) * len(self._storeys.floors) :]
        for number, foot in enumerate(self._storeys.feet):
            part = feet[len(column) * number :]
            pushed, moment = self._sums(forces, state, foot.nodes, foot.centre)
            part[column.axial_force_N] = pushed[-1]
            for k, way in enumerate(WAYS[: len(moment)]):
                part[getattr(column, f"shear{way}_N")] = -pushed[k]
                part[getattr(column, f"moment{way}_Nm")] = moment[k]

    def _write_base(self, forces: GroundForces, state: State, row: Array) -> None:
        """Base shear and overturning moment."""
        d, at = self._body.dimension, self._at[0]
        total = global_sum(self._body.comm, forces.total)
        everywhere = np.arange(len(self._body.nodes))
        _, moment = self._sums(forces, state, everywhere, np.zeros(d - 1))
        for k, way in enumerate(WAYS[: d - 1]):
            row[getattr(at, f"base_shear{way}_N")] = -total[k]
            row[getattr(at, f"overturning_moment{way}_Nm")] = moment[k]

    def _sums(
        self, forces: GroundForces, state: State, nodes: Indices, centre: Array
    ) -> tuple[Array, Array]:
        """Forces of the ground on some nodes, (d,), and moments about a centre, (d - 1,)."""
        d = self._body.dimension
        force = forces.nodal[self._own].reshape(-1, d)[nodes]
        moved = state.u[self._own].reshape(-1, d)[nodes]
        arm = (self._body.nodes[nodes] + moved)[:, :-1] - centre
        own = np.concatenate([force.sum(axis=0), arm.T @ force[:, -1]])
        sums = global_sum(self._body.comm, own)
        return sums[:d], sums[d:]

    def _write_storeys(self, state: State, row: Array) -> None:
        """Drifts and velocities of the storeys."""
        at, floors = self._at[1], self._storeys.floors
        if not floors:
            return
        place, velocity = (self._means(vector[self._own]) for vector in (state.u, state.v))
        drift = np.diff(place, axis=0, prepend=np.zeros((1, place.shape[1])))
        for number in range(len(floors)):
            part = row[len(at) * number :]
            for k, way in enumerate(WAYS[: place.shape[1]]):
                part[getattr(at, f"drift{way}_m")] = drift[number, k]
                part[getattr(at, f"velocity{way}_m_s")] = velocity[number, k]

    def _means(self, vector: Array) -> Any:
        """Horizontal means over the floors, (floors, d - 1)."""
        own = np.array([floor @ vector for floor in self._storeys.floors])
        return global_sum(self._body.comm, own)
