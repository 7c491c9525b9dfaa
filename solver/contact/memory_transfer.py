"""Memory of contact carried over: into the frame of a coming step, and to points that join."""

from __future__ import annotations

import numpy as np

from solver.contact.facet_target import Face
from solver.contact.interface import Interface
from solver.contact.memory import Memory
from solver.types import Array, Mask

SUNK_IN = 1e-9
"""Part of a face's length: points deeper than closed ones by more have sunk in elsewhere."""

HELD_DEPTH = 1e-3
"""Part of a face's length: points that are deeper beyond its edge have fallen beside it, and are
ignored until they separate; less is the lean of a block that stands."""


def _rest(interface: Interface, memory: Memory, beyond: Mask | None) -> Array:
    """The rest gaps of a coming step, m; `beyond`: points beyond an edge of the carrier.

    Beyond the edge nothing keeps a point from going below the surface, by a block that leans a
    little. Once back over the carrier it is held where it is. As long as it carries no force this
    follows the point; with one, the point would be lifted.
    """
    rest, holds = memory.rest, np.count_nonzero(memory.rest) > 0
    outside = beyond is not None and np.count_nonzero(beyond) > 0
    if not (holds or outside):
        return rest
    level = np.minimum(memory.kinematics.place[:, 0], memory.kinematics.augmented[:, 0])
    if holds:
        held = (rest == 0.0) | (memory.force[:, 0] > 0.0)
        rest = np.where(held, rest, np.minimum(level, 0.0))
    if beyond is None or not outside:
        return rest
    below = beyond & penetrating(interface, memory._replace(rest=np.zeros_like(rest)))
    below &= level > -HELD_DEPTH * _length(interface)
    if not (holds or below.any()):
        return rest
    return np.where(beyond, np.where(below, level, 0.0), rest)


def _ignored_until_open(interface: Interface, memory: Memory, beyond: Mask | None) -> Mask | None:
    """Points that sank in elsewhere: until they are out again contact would throw them out.

    They did so far below a face and beside it, or before the face that they are on joined: Gauss
    points of one face do not keep another from sinking in at an edge between them. None where there
    are none. `beyond`: points beyond an edge of the carrier.
    """
    may_touch, corners = memory.may_touch, interface.corners
    outside = ~may_touch if corners is None else corners.closed_to_all(may_touch)
    if beyond is not None:
        outside = beyond if outside is None else outside | beyond
    if outside is None or not np.count_nonzero(outside):
        return None
    return outside & penetrating(interface, memory)


def _length(interface: Interface) -> float:
    """Length of what carries an interface's points, or their body's size on a plane, m."""
    return interface.carrier.length if isinstance(interface.carrier, Face) else interface.size


def penetrating(interface: Interface, memory: Memory) -> Mask:
    """Points deeper in the carrier, below their rest gaps, than closed ones are pressed."""
    pressed = float(np.max(memory.force[:, 0], initial=0.0)) * interface.softness
    pressed += float(np.max(memory.compression, initial=0.0))
    depth = memory.kinematics.place[:, 0] - memory.rest
    deeper: Mask = depth < -pressed - SUNK_IN * _length(interface)
    return deeper


def rotate_frame(
    interface: Interface, memory: Memory, rotation: Array, carrier_rotation: Array | None
) -> tuple[Memory, float]:
    """The memory in the frame of a coming step, with the points of corners chosen anew.

    Anchors and point forces turn with the carrier; a force moves with its place to the other
    face of a corner.

    Args:
        interface: The interface.
        memory: Memory of t_n.
        rotation: Of the body of the points at t_n, (d, d).
        carrier_rotation: Of a carrier that turns, in the middle of the step; None for others.

    Returns:
        The memory that the step starts from, and the interface energy lost by the exchange
        (weights and tractions differ), J; it is added to what contact dissipates.
    """
    exchanged = 0.0
    if isinstance(interface.carrier, Face) and carrier_rotation is not None:
        memory, exchanged = _turn_face(interface, interface.carrier, memory, carrier_rotation)
    beyond = interface.carrier.beyond_edge(memory.kinematics)
    rest = _rest(interface, memory, beyond)
    if rest is not memory.rest:
        memory = memory._replace(rest=rest)
    may_touch = interface.may_touch(rotation, memory.kinematics)
    ignored = _ignored_until_open(interface, memory, beyond)
    if ignored is not None:
        may_touch &= ~ignored
    if may_touch.tobytes() == memory.may_touch.tobytes():
        return memory, exchanged
    before = interface.energy(memory)
    y = memory.kinematics.augmented
    memory = _at_other_faces(interface, memory, y, may_touch)
    lost = ~may_touch
    after = memory._replace(
        force=np.where(lost[:, None], 0.0, memory.force),
        anchor=np.where(lost[:, None], y[:, 1:], memory.anchor),
        may_touch=may_touch,
        compression=np.where(lost, 0.0, memory.compression),
    )
    return after, exchanged + before - interface.energy(after)


def _turn_face(
    interface: Interface, face: Face, memory: Memory, rotation: Array
) -> tuple[Memory, float]:
    """Turn the frame of a face, and forces with it; also the energy lost against tractions, J.

    Tractions do not turn. For theta = 1 the energy does not know of angles between the two.
    """
    face.rotate_frame(rotation)
    kinematics = interface.over(memory.surface, memory.kinematics.carrier)
    apart, anchor = memory.force[:, 0] <= 0, memory.anchor
    if apart.any():  # the foot of a point that is away from the face moves as the face turns
        anchor = np.where(apart[:, None], kinematics.augmented[:, 1:], anchor)
    turned = memory._replace(kinematics=kinematics, anchor=anchor)
    return turned, 0.0 if interface.theta == 1 else interface.energy(memory) - interface.energy(
        turned
    )


def _at_other_faces(interface: Interface, memory: Memory, y: Array, may_touch: Mask) -> Memory:
    """Forces at corners moved to the points of their other faces."""
    moves = (
        [] if interface.corners is None else interface.corners.moves(memory.may_touch, may_touch)
    )
    for old, new in moves:
        memory = memory.take(np.array([new]), memory, np.array([old]))
        memory.force[old] = memory.compression[old] = 0.0
        memory.anchor[new] = y[new, 1:] + memory.force[new, 1:] * interface.softness[new]
        memory.anchor[old] = y[old, 1:]
    return memory


def carry_over(memory: Memory, old: Interface, new: Interface, fresh: Memory) -> Memory:
    """The memory of `old`'s points in a fresh one of `new`, which holds those points and more.

    Points that join under the carrier's surface may not touch before they are out of it.
    """
    place = {key: k for k, key in enumerate(old.keys())}
    staying = np.array([key in place for key in new.keys()])
    before = np.array([place[key] for key in new.keys() if key in place], dtype=np.int64)
    carried = fresh.take(np.flatnonzero(staying), memory, before)
    sunk = ~staying & penetrating(new, carried)
    return carried._replace(may_touch=carried.may_touch & ~sunk)
