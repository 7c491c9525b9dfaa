"""Compiled functions on the contact points of a surface, to test their equations."""

from __future__ import annotations

import numpy as np

from solver.contact.kernels.nitsche import (
    NitscheState,
    add_traction_gradient,
    evaluate,
    new_state,
)
from solver.contact.nitsche_points import ContactPoints
from solver.types import Array


def evaluated(points: ContactPoints, displacement: Array) -> NitscheState:
    """Positions and tractions for the displacements (nodes, d) of the layer."""
    state = new_state(points.rows)
    evaluate(*points.rows, displacement, state.values)
    return state


def traction_gradient(
    points: ContactPoints, old: NitscheState, new: NitscheState, vector: Array
) -> Array:
    """Nodal values of `vector`.DT[v], (nodes, d), with one vector per point, (points, d).

    DT is the discrete gradient of the traction between two states.
    """
    nodal = np.zeros((points.layer.size, points.dimension))
    numbers, table, _ = points.rows
    add_traction_gradient(numbers, table, old.values, new.values, vector, nodal)
    return nodal
