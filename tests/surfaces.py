"""Compiled functions on the contact points of a surface, to test their equations."""

from __future__ import annotations

import numpy as np

from solver.contact.nitsche_points import ContactPoints, NitscheState, new_state
from solver.kernels import meshed
from solver.types import Array


def evaluated(points: ContactPoints, displacement: Array) -> NitscheState:
    """Positions and tractions for the displacements (nodes, d) of the layer."""
    state = new_state(points.rows)
    meshed.evaluate(*points.rows, displacement, state.values)
    return state


def traction_gradient(
    points: ContactPoints, old: NitscheState, new: NitscheState, vector: Array
) -> Array:
    """Nodal values of `vector`.DT[v], (nodes, d), with one vector per point, (points, d).

    DT is the discrete gradient of the traction between two states.
    """
    nodal = np.zeros((points.layer.size, points.dimension))
    numbers, table, _ = points.rows
    # A pull by these vectors alone: no tractions, and no forces at the points.
    scale = np.tile([0.0, -1.0], (points.count, 1))
    pull = scale, vector, np.eye(points.dimension), 0.0, 0.0
    states, forces = (old.values, new.values), np.zeros_like(vector)
    meshed.add_contact_forces(numbers, table, *states, forces, *pull, nodal)
    return nodal
