"""The memory of an interface from one step to the next, and what a step lost in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from solver.contact.body_points import SurfaceState
from solver.contact.kinematics import ContactKinematics, Observed
from solver.kernels import meshed
from solver.law.friction import slipped_before
from solver.types import Array, Indices, Mask


class Memory(NamedTuple):
    """The state of contact of an interface at one instant; its arrays are never written to.

    Attributes:
        surface: Positions of the points, and tractions where they have any.
        kinematics: Their gaps and tangential positions, and the frame that both are given in.
        force: Point forces f = w l on the body of the points, (points, d), N: normal, tangential.
        anchor: Stick memory, (points, d-1), m.
        may_touch: Points that may touch: of the coinciding points of a corner, the one whose face
            opposes the carrier; no point that came round the carrier's edge.
        past: What they remember of their friction (`solver.law.friction.PAST`), (points, PAST).
        compression: Of the bed below them, (points,), m; 0 where there is none.
    """

    surface: SurfaceState
    kinematics: ContactKinematics
    force: Array
    anchor: Array
    may_touch: Mask
    past: Array
    compression: Array

    @property
    def seen(self) -> Observed:
        """The points, and where they are."""
        return self.surface, self.kinematics

    @property
    def slipped(self) -> Mask:
        """Points that slipped in the last step."""
        return slipped_before(self.past)

    def take(self, rows: Indices, other: Memory, others: Indices) -> Memory:
        """This memory, with what another one remembers of some points, there `others`, here `rows`.

        Surface and kinematics stay: they say where points are, and those here are up to date.
        """
        kept = {}
        for name in REMEMBERED:
            values = getattr(self, name).copy()
            values[rows] = getattr(other, name)[others]
            kept[name] = values
        return self._replace(**kept)

    def touching(self, may_touch: Mask) -> Memory:
        """This memory where only some points may touch: the others let go of what they hold."""
        lost = ~may_touch
        return self._replace(
            force=np.where(lost[:, None], 0.0, self.force),
            anchor=np.where(lost[:, None], self.kinematics.augmented[:, 1:], self.anchor),
            may_touch=may_touch,
            compression=np.where(lost, 0.0, self.compression),
        )


KINEMATICS = ("surface", "kinematics")
"""Fields of a memory that say where points are; all others follow from the past alone."""

REMEMBERED = tuple(name for name in Memory._fields if name not in KINEMATICS)
"""Fields of a memory that hold what only the past tells, one row for each point."""


class Dissipation(NamedTuple):
    """Energy lost in an interface in a step, J; `damping` in the dashpots of its bed."""

    friction: float
    contact: float
    damping: float


INTERFACE_SHARE = 1e-3
"""Part of the forces of an interface: points that carry less than it together shake nothing."""

TOTAL_SHARE = 1e-6
"""Part of the forces of all interfaces, likewise: a grazing interface has no other forces to be
compared with."""


def contact_changed(old: Sequence[Memory], new: Sequence[Memory], rigid: Sequence[bool]) -> bool:
    """True if points that carry something changed their state of contact in a step.

    By the memories of all interfaces before and after it; `rigid`: neither body that touches is
    meshed.
    """
    changes = [
        meshed.changed_forces(before.force, after.force, before.past, after.past, alone)
        for before, after, alone in zip(old, new, rigid, strict=True)
    ]
    least = TOTAL_SHARE * sum(carried for _, carried in changes)
    return any(shaken > max(INTERFACE_SHARE * carried, least) for shaken, carried in changes)


SAME_PLACE = 9
"""Decimals, of the body's size, to which places that are one agree."""


class CornerPoints:
    """Groups of contact points of different faces at one place.

    At each corner only one of its points may touch at a time: that of the face which is most
    opposed to the carrier.
    """

    def __init__(self, places: Array, normal: Array):
        """Find the groups by the points' places over the body's size and their outward normals."""
        _, group = np.unique(np.round(places, SAME_PLACE), axis=0, return_inverse=True)
        members = [np.flatnonzero(group.ravel() == k) for k in range(group.max() + 1)]
        self._groups = [each for each in members if len(each) > 1]
        self._normal = normal
        self._member = np.array([p for each in self._groups for p in each], dtype=np.int64)
        self._group = np.repeat(np.arange(len(self._groups)), list(map(len, self._groups)))
        self._first = np.searchsorted(self._group, np.arange(len(self._groups)))

    def chosen(self, rotation: Array, towards: Array) -> Mask:
        """The points that may touch: one of each corner, and all that share no place.

        The body has turned by a rotation (d, d); `towards` is the normal of the carrier, (d,).
        """
        mask = np.ones(len(self._normal), dtype=np.bool_)
        if len(self._member):
            cosine = self._normal[self._member] @ (towards @ rotation)
            order = np.lexsort((cosine, self._group))
            mask[self._member] = False
            mask[self._member[order[self._first]]] = True
        return mask

    def closed_to_all(self, may_touch: Mask) -> Mask | None:
        """Points that may not touch, but for those at whose corner another one may; None: none."""
        outside = ~may_touch
        if len(self._member):
            closed = np.logical_and.reduceat(outside[self._member], self._first)
            outside[self._member] = closed[self._group]
        return outside if outside.any() else None

    def moves(self, before: Mask, after: Mask) -> Iterator[tuple[int, int]]:
        """Pairs (old, new) of points of a corner between which contact changes."""
        for corner in self._groups:
            old, new = _first(corner, before), _first(corner, after)
            if old is not None and new is not None and old != new:
                yield old, new


def _first(corner: Indices, mask: Mask) -> int | None:
    """The first point of a corner that is in the mask; None where none is."""
    chosen = corner[mask[corner]]
    return int(chosen[0]) if len(chosen) else None
