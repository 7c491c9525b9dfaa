"""Response of a structure in the history: base shear; meshed: moments, storeys, columns, too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.build.assembly import Assembly
from solver.history.engine_rows import along, of_owner
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

    def columns(self, state: State, forces: GroundForces) -> dict[str, Any]:
        """The columns of the structure but its base shear, of its storeys and of its columns.

        By the state after a step, and the mean forces of the ground in the step.
        """
        d, (base, *feet) = self._body.dimension, self._resultants(forces, state)
        known = along("overturning_moment{}_Nm", base[d:]) | self._storey_columns(state)
        for number, foot in enumerate(feet, start=1):
            known |= of_owner(
                f"column_{number}",
                {
                    "axial_force_N": foot[d - 1],
                    **along("shear{}_N", -foot[: d - 1]),
                    **along("moment{}_Nm", foot[d:]),
                },
            )
        return of_owner("foundation", known)

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

    def _storey_columns(self, state: State) -> dict[str, Any]:
        """Drifts and velocities of the storeys."""
        known = dict[str, Any]()
        if not self._storeys.floors:
            return known
        place, velocity = (self._means(vector[self._own]) for vector in (state.u, state.v))
        drift = np.diff(place, axis=0, prepend=0.0)
        for k in range(len(drift)):
            motion = along("drift{}_m", drift[k]) | along("velocity{}_m_s", velocity[k])
            known |= of_owner(f"storey_{k + 1}", motion)
        return known

    def _means(self, vector: Array) -> Array:
        """Horizontal means over the floors, (floors, d - 1)."""
        own = [rows @ vector for rows in self._floors]
        return global_sum(self._body.comm, joined(own).reshape(-1, self._body.dimension - 1))
