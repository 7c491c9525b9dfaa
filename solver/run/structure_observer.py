"""Response of a structure in the history: base shear; meshed: moments, storeys, columns, too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.build.assembly import Assembly
from solver.history.columns import Structure, positions
from solver.history.engine_rows import DIRECTIONS
from solver.parallel import global_sum
from solver.stepping.point_table import joined
from solver.stepping.state import GroundForces, State
from solver.types import Array


class StructureObserver:
    """Forces of a structure on the ground, and the motion of its storeys, means of each step."""

    def __init__(self, assembly: Assembly):
        """Start at rest."""
        self._stepper, support = assembly.stepper, assembly.support
        assert support.number is not None and isinstance(support.body, ElasticBody | ReducedBody)
        self._body, self._storeys = support.body, support.storeys
        floors = support.storeys.floors
        sparse = [floor for floor in floors if sp.issparse(floor)]
        self._floors: Sequence[Any] = [sp.vstack(sparse, format="csr")] if sparse else floors
        self._own = self._stepper.system.slices[support.number]
        d = self._body.dimension
        self._at = tuple(positions(part, d) for part in ("foundation", "storey", "column"))

    @property
    def parts(self) -> Structure:
        """Numbers of storeys and columns."""
        return Structure(len(self._storeys.floors), len(self._storeys.feet))

    def write(self, state: State, forces: GroundForces, row: Array) -> None:
        """The columns of the structure but its base shear, of its storeys and of its columns.

        By the state after a step, and the mean forces of the ground in the step.
        """
        own, storey, column = self._at
        d, (base, *feet) = self._body.dimension, self._resultants(forces, state)
        for k, direction in enumerate(DIRECTIONS[: d - 1]):
            row[getattr(own, f"overturning_moment{direction}_Nm")] = base[d + k]
        floors = row[len(own) :]
        self._write_storeys(state, floors)
        columns = floors[len(storey) * len(self._storeys.floors) :]
        for number, foot in enumerate(feet):
            part, pushed, moment = columns[len(column) * number :], foot[:d], foot[d:]
            part[column.axial_force_N] = pushed[-1]
            for k, direction in enumerate(DIRECTIONS[: len(moment)]):
                part[getattr(column, f"shear{direction}_N")] = -pushed[k]
                part[getattr(column, f"moment{direction}_Nm")] = moment[k]

    def _resultants(self, forces: GroundForces, state: State) -> Array:
        """Forces of the ground on all nodes, and on those of each foot, with their moments.

        The moments are about the middle of the base and of the feet, (1 + feet, 2 d - 1).
        """
        d, feet = self._body.dimension, self._storeys.feet
        nodes = self._body.nodes
        force, moved = (
            vector[self._own].reshape(-1, d)[: len(nodes)] for vector in (forces.nodal, state.u)
        )
        place = (nodes + moved)[:, :-1]
        own = np.empty((1 + len(feet), 2 * d - 1))
        own[0, :d], own[0, d:] = np.add.reduce(force, axis=0), place.T @ force[:, -1]
        for number, foot in enumerate(feet, start=1):
            pushed = force.take(foot.nodes, axis=0)
            arm = place.take(foot.nodes, axis=0) - foot.centre
            own[number, :d], own[number, d:] = np.add.reduce(pushed, axis=0), arm.T @ pushed[:, -1]
        return global_sum(self._body.comm, own)

    def _write_storeys(self, state: State, row: Array) -> None:
        """Drifts and velocities of the storeys."""
        at, floors = self._at[1], self._storeys.floors
        if not floors:
            return
        place, velocity = (self._means(vector[self._own]) for vector in (state.u, state.v))
        drift = place.copy()
        drift[1:] -= place[:-1]
        for number in range(len(floors)):
            part = row[len(at) * number :]
            for k, direction in enumerate(DIRECTIONS[: place.shape[1]]):
                part[getattr(at, f"drift{direction}_m")] = drift[number, k]
                part[getattr(at, f"velocity{direction}_m_s")] = velocity[number, k]

    def _means(self, vector: Array) -> Array:
        """Horizontal means over the floors, (floors, d - 1)."""
        own = [rows @ vector for rows in self._floors]
        return global_sum(self._body.comm, joined(own).reshape(-1, self._body.dimension - 1))
