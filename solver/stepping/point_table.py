"""The contact points of all interfaces put together, numbered interface after interface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from solver.contact.bed import Yielding
from solver.contact.kinematics import ContactKinematics
from solver.contact.memory import Memory
from solver.contact.pairs import Link
from solver.law.friction import Bounds, new_pasts
from solver.stepping.system import System
from solver.types import Array, Indices, Mask

Scalar = TypeVar("Scalar", bound=np.generic)

GAP_ROUND_OFF = 2 * float(np.finfo(float).eps)
"""Round-off of a gap, over the size of the body."""


def joined(arrays: Sequence[NDArray[Scalar]]) -> NDArray[Scalar]:
    """Arrays of several interfaces one after another; a single one as it is."""
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


def copied(arrays: Sequence[NDArray[Scalar]]) -> NDArray[Scalar]:
    """Arrays of several interfaces one after another, always in a new array."""
    return arrays[0].copy() if len(arrays) == 1 else np.concatenate(arrays)


def numbered(links: Sequence[Link]) -> list[slice]:
    """Numbers of the points of each interface among those of all."""
    ends = np.cumsum([link.interface.count for link in links]).tolist()
    return [slice(start, end) for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def joined_bounds(each: Sequence[Bounds]) -> Bounds:
    """Bounds of friction of several interfaces one after another."""
    return Bounds(joined([own.mu for own in each]), joined([own.cohesion for own in each]))


class PointTable:
    """All contact points of a scene, the same while no face joins.

    Attributes:
        links: The interfaces.
        carriers: What carries the points of each.
        own: Numbers of the points of each interface.
        count: Number of all points.
        softness: 1/(gamma_h w), 0 for points of rigid bodies, (points,), m/N.
        has_bed: True if points stand on beds.
        no_bed: The softness of beds where there are none, (points,), m/N.
        decays: True if that of some points decays with the speed.
        bounds: Bounds of friction that depends on neither speed nor the past; None: some does.
        turning: Points whose carriers turn, (points,).
        size: Of the body that each point belongs to, (points,), m.
        round_off: Round-off of their gaps, (points,), m.
    """

    def __init__(self, system: System, links: Sequence[Link]):
        """Number the points."""
        self._system, self.links, self.own = system, tuple(links), numbered(links)
        self.carriers = tuple(link.interface.carrier for link in links)
        self.softness: Array = np.concatenate([link.interface.softness for link in links])
        self.count = len(self.softness)
        self.size: Array = np.concatenate(
            [np.full(link.interface.count, link.interface.size) for link in links]
        )
        self.no_bed: Array = np.zeros(self.count)
        self.has_bed = any(link.interface.beds is not None for link in links)
        laws = [link.interface.law for link in links]
        self.decays = any(law.decays for law in laws)
        self.bounds: Bounds | None = None
        if all(law.constant for law in laws):
            interfaces = [link.interface for link in links]
            each = [interface.bounds(new_pasts(interface.count)) for interface in interfaces]
            self.bounds = joined_bounds(each)
        counts = [link.interface.count for link in links]
        self.turning: Mask = np.repeat([carrier.turns for carrier in self.carriers], counts)
        self._frames_of: tuple[bytes, Array] | None = None
        """Frames that were given last, and for which points."""
        self.round_off = GAP_ROUND_OFF * self.size

    def frames_at(self, chosen: Indices, seen: Sequence[ContactKinematics]) -> Array:
        """Frames at some of the points, whose numbers rise, (m, d, d); to be read only.

        By the kinematics of all interfaces.
        """
        key, kept = chosen.tobytes(), self._frames_of
        if kept is None or kept[0] != key or self.turning.take(chosen).any():
            kept = self._frames_of = key, self._new_frames(chosen, seen)
        return kept[1]

    def _new_frames(self, chosen: Indices, seen: Sequence[ContactKinematics]) -> Array:
        """Frames at some of the points, put together."""
        d = self._system.dimension
        found = np.empty((len(chosen), d, d))
        for kinematics, part in zip(seen, self.own, strict=True):
            first, last = chosen.searchsorted((part.start, part.stop))
            own, frame = chosen[first:last] - part.start, kinematics.frame
            found[first:last] = frame if frame.ndim == 2 else frame[own]
        return found

    def beds(self, memories: Sequence[Memory], step: float) -> Yielding | None:
        """Yielding of the beds below all points in a step of length `step` (s); None: no bed."""
        if not self.has_bed:
            return None
        parts = []
        for link, memory in zip(self.links, memories, strict=True):
            beds, nothing = link.interface.beds, np.zeros(link.interface.count)
            rigid = Yielding(nothing, nothing)
            parts.append(rigid if beds is None else beds.yielding(memory.compression, step))
        return Yielding(*(joined(list(arrays)) for arrays in zip(*parts, strict=True)))

    def rest(self, memories: Sequence[Memory]) -> Array | None:
        """Gaps from which points are not pushed out in a step, (points,), m; None: all are 0."""
        pairs = zip(self.links, memories, strict=True)
        each = [link.interface.rest(memory) for link, memory in pairs]
        if all(rest is None for rest in each):
            return None
        rests = np.zeros(self.count)
        for own, rest in zip(self.own, each, strict=True):
            if rest is not None:
                rests[own] = rest
        return rests
