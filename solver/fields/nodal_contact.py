"""Contact at the nodes of a meshed body: pressure, friction, and states."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from solver.bodies.surface_layer import Layer
from solver.contact.body_points import NodePoints
from solver.contact.carriers import Face
from solver.contact.edge_crossings import Crossings
from solver.contact.interface import Interface
from solver.contact.kinematics import in_space
from solver.contact.memory import Memory
from solver.contact.nitsche_points import ContactPoints
from solver.kernels import meshed
from solver.types import Array

LEAST_AREA = 1e-6
"""Area of a node, over the largest, below which it is round-off."""


class NodeState(IntEnum):
    """Contact state of a node, as in files of fields."""

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
    area: Array
    """Area of each node: of what may touch, or of all where nothing does, (n,), m2."""


class EdgeForces(NamedTuple):
    """Edge forces at the nodes of a body that edges press on, or that has them."""

    layer: Layer
    """The nodes."""
    normal: Array
    """Normal force, (n, 2), N: all of it, and that of points that slipped in the last step."""
    friction: Array
    """Tangential force on the body as a vector in space, (n, d), N."""


def nodal_contact(points: ContactPoints, memory: Memory, thickness: float) -> NodalContact:
    """The point forces spread over the nodes, over the area that belongs to each of them.

    Quadratic shape functions are negative in places, and those at the corners of triangles have no
    area at all: there nodes have the mean of the points around, by the sizes of these functions.
    """
    shares, force = points.values_T, memory.force
    whole = thickness * (shares @ points.weight)
    if np.any(whole < LEAST_AREA * whole.max(initial=0.0)):
        shares = abs(shares)
        whole = thickness * (shares @ points.weight)
    area = thickness * (shares @ (points.weight * memory.may_touch))
    friction = np.asarray(shares @ (force[:, 1:] @ memory.kinematics.frame[1:]))
    return NodalContact(
        pressure=np.maximum(_over(shares @ force[:, 0], area), 0.0),
        friction=_over(friction, area[:, None]),
        state=_states(points, memory),
        area=np.where(area > 0, area, whole),
    )


def edge_forces(interface: Interface, memory: Memory, *, carries: bool) -> EdgeForces | None:
    """Edge forces at the bottom of a meshed body that overhangs what carries it.

    The outline of the latter presses on it: for that interface the body is the one that `carries`.
    In space edges of both cross, too. None for all other interfaces.
    """
    seen, carrier = memory.kinematics, interface.carrier
    points = carrier.points if carries else interface.points
    if not isinstance(points, NodePoints):
        return None
    looks_down = isinstance(carrier, Face) and carrier.reference_frame[0, -1] < 0
    if not (looks_down if carries else isinstance(carrier, Crossings)):
        return None
    places = seen.projection if carries else seen.own_projection
    assert places is not None
    friction = in_space(memory.force * (np.arange(memory.force.shape[1]) > 0), seen.frame)
    normal = memory.force[:, :1] * np.column_stack([np.ones(len(memory.slipped)), memory.slipped])
    acting = np.hstack([normal, -friction if carries else friction])
    # Quadratic shape functions are negative in places: nodes take the force by their sizes.
    shares = np.abs(places.weights)
    shares /= np.maximum(shares.sum(axis=1, keepdims=True), LEAST_AREA)
    nodal = np.zeros((points.count, acting.shape[1]))
    meshed.add_spread(places.nodes, shares, 1.0, acting, nodal)
    return EdgeForces(points.layer, nodal[:, :2], nodal[:, 2:])


def _over(force: Array, area: Array) -> Array:
    """Force over area, Pa; 0 where there is none."""
    return np.divide(force, area, out=np.zeros_like(force), where=area > 0)


def _states(points: ContactPoints, memory: Memory) -> Array:
    """State of most of the points next to each node, by their weights."""
    near = abs(points.values_T)  # quadratic shape functions are negative in places
    pressed = memory.force[:, 0] > 0
    may_touch, carries, slips = (
        near @ (points.weight * which)
        for which in (memory.may_touch, pressed, pressed & memory.slipped)
    )
    choices = [may_touch <= 0, carries <= 0, 2 * slips >= carries]
    states = [float(state) for state in (NodeState.AWAY, NodeState.OPEN, NodeState.SLIPS)]
    return np.select(choices, states, float(NodeState.STICKS))
