"""What contact does at the nodes of a meshed body: pressure, friction, and what sticks."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from solver.contact.memory import Memory
from solver.contact.nitsche_points import ContactPoints
from solver.types import Array

LEAST_AREA = 1e-6
"""Area of a node, over the largest, below which it is round-off."""


class NodeState(IntEnum):
    """How a node stands to what carries its body, as files of fields have it."""

    AWAY = 0
    """A node that is not on a face that may touch."""
    OPEN = 1
    """A node on such a face, without a force."""
    SLIPS = 2
    """A node that is pressed, and slipped in the last step."""
    STICKS = 3
    """A node that is pressed, and did not slip."""


class NodalContact(NamedTuple):
    """The contact of a body at the nodes of its layer."""

    pressure: Array
    """Normal force over the area of each node, (n,), Pa, >= 0."""
    friction: Array
    """Tangential force on the body over that area, as a vector in space, (n, d), Pa."""
    state: Array
    """Values of `NodeState`, (n,)."""


def nodal_contact(points: ContactPoints, memory: Memory, thickness: float) -> NodalContact:
    """The point forces spread over the nodes, over the area that belongs to each of them.

    Quadratic shape functions are negative in places, and those at the corners of triangles have no
    area at all: there nodes have the mean of the points around, by the sizes of these functions.
    """
    spread, force = points.values_T, memory.force
    whole = thickness * (spread @ points.weight)
    if np.any(whole < LEAST_AREA * whole.max(initial=0.0)):
        spread = abs(spread)
    area = thickness * (spread @ (points.weight * memory.may_touch))
    friction = np.asarray(spread @ (force[:, 1:] @ memory.kinematics.frame[1:]))
    return NodalContact(
        pressure=np.maximum(_over(spread @ force[:, 0], area), 0.0),
        friction=_over(friction, area[:, None]),
        state=_states(points, memory),
    )


def _over(force: Array, area: Array) -> Array:
    """Force over area, Pa; 0 where there is none."""
    return np.divide(force, area, out=np.zeros_like(force), where=area > 0)


def _states(points: ContactPoints, memory: Memory) -> Array:
    """What most of the points next to each node do, by their weights."""
    near = abs(points.values_T)  # quadratic shape functions are negative in places
    pressed = memory.force[:, 0] > 0
    may_touch, carries, slips = (
        near @ (points.weight * which)
        for which in (memory.may_touch, pressed, pressed & memory.slipped)
    )
    choices = [may_touch <= 0, carries <= 0, 2 * slips >= carries]
    states = [float(state) for state in (NodeState.AWAY, NodeState.OPEN, NodeState.SLIPS)]
    return np.select(choices, states, float(NodeState.STICKS))
