"""Links between bodies: their extensions, the forces of a step, and what they remember.

A link is axial, or acts along axes that turn with its first body. With x_a, x_b the places of its
ends, b = x_b - x_a, and axes a_i, its extensions are |b| - length, or a_i.b - length_i. Because
products change by d(a.b) = a_m.db + da.b_m, and d|b| = (b_0 + b_1).db/(|b_0| + |b_1|), they change
by products of rows with the changes of places, exactly; the law (M61) is that of `link.hpp`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solver.kernels import meshed
from solver.kernels.world import LinkLaw
from solver.types import Array, Indices, Mask

BREAKING = 1e-9
"""Part of its strength by which a link is loaded more before it breaks."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyLink:
    """A link between two bodies, by the numbers of places."""

    ends: tuple[int, int]
    """Numbers of the places of its ends, on its first and on its second body."""
    axes: tuple[int, ...] = ()
    """Of its axes, on its first body; none: it is axial."""
    length: Array | None
    """Distance of its ends at which it is not extended, along axes its components, (1,) or (d,), m;
    None: that at the start."""
    laws: Sequence[LinkLaw]
    """One for an axial link, else d."""
    preload: float = 0.0
    """Tension at the start, N."""
    strength: float = np.inf
    """Force at which it breaks, N."""


class LinkForces(NamedTuple):
    """Links at the end of a step.

    Attributes:
        extension: Of each direction, (n,), m.
        force: Mean over the step, in tension, (n,), N.
        slope: Derivative of that over the extension, (n,), N/m.
        share: Part of the step in which each link acts, (links,): less than 1 where it breaks.
    """

    extension: Array
    force: Array
    slope: Array
    share: Array


class LinkMemory(NamedTuple):
    """Links at an instant, as `LinkStates` has them.

    Attributes:
        extension: Of each direction, (n,), m.
        force: Mean over the step that led here, in tension, (n,), N.
        plastic: Plastic part of the extension, (n,), m.
        broken: Links that are broken, (links,).
        broken_at: When they broke, (links,), s.
        lost: Energy that they had then, (links,), J.
    """

    extension: Array
    force: Array
    plastic: Array
    broken: Mask
    broken_at: Array
    lost: Array


class BodyLinks:
    """All links of a scene, direction by direction."""

    def __init__(self, links: Sequence[BodyLink], dimension: int):
        """Number the directions."""
        self.links, self.dimension = tuple(links), dimension
        self.count = len(links)
        counts = np.array([len(link.laws) for link in links], dtype=np.int64)
        self.of: Indices = np.repeat(np.arange(self.count), counts)
        """The link of each direction."""
        self._first = np.cumsum([0, *counts])
        self._laws = np.array(
            [
                [law.stiffness, law.damping, law.gap, float(law.compression), law.yields]
                for link in links
                for law in link.laws
            ]
        ).reshape(-1, 5)
        self._strength = np.array([link.strength for link in links])
        self._length = np.zeros(len(self.of))
        for own, link in zip(self._own, links, strict=True):
            if link.length is not None:
                self._length[own] = link.length
        self._preload = np.array([link.preload for link in links])[self.of]
        self._waits = np.array([link.length is None for link in links])[self.of]
        self._axis = np.arange(len(self.of)) - self._first[self.of]
        """Number of each direction among those of its link."""

    @property
    def _own(self) -> list[slice]:
        """Directions of each link."""
        ends = self._first.tolist()
        return [slice(a, b) for a, b in pairwise(ends)]

    def stiffness(self, places: int) -> Array:
        """Sum of the stiffnesses of the links that end at each of so many places, (m,), N/m."""
        found = np.zeros(places)
        for own, link in zip(self._own, self.links, strict=True):
            found[list(link.ends)] += self._laws[own, 0].max()
        return found

    def measure(self, places: Array) -> Array:
        """Extensions at places (m, d), (n,), m."""
        found = np.empty(len(self.of))
        for own, link in zip(self._own, self.links, strict=True):
            between = places[link.ends[1]] - places[link.ends[0]]
            if link.axes:
                found[own] = places[list(link.axes)] @ between
            else:
                found[own] = np.sqrt(between @ between)
        return found - self._length

    def rows(self, before: Array, now: Array) -> Array:
        """What changes between places before and now, (m, d), do to extensions, (n, m, d)."""
        found = np.zeros((len(self.of), *now.shape))
        for own, link in zip(self._own, self.links, strict=True):
            a, b = link.ends
            ends = before[b] - before[a], now[b] - now[a]
            if link.axes:
                axes = list(link.axes)
                along = 0.5 * (before[axes] + now[axes])
                directions = np.arange(own.start, own.stop)
                found[directions, axes] += 0.5 * (ends[0] + ends[1])
            else:
                lengths = sum(float(np.linalg.norm(end)) for end in ends)
                along = ((ends[0] + ends[1]) / lengths)[None]
            found[own, b] += along
            found[own, a] -= along
        return found

    # ---- The start

    def start(self, places: Array) -> LinkMemory:
        """Links at the start, with the lengths of places (m, d) from now on, if not given."""
        self._length += np.where(self._waits, self.measure(places), 0.0)
        extension, nothing = self.measure(places), np.zeros(self.count)
        force, _, _ = self._springs(extension)
        unbroken = np.zeros(self.count, dtype=np.bool_)
        return LinkMemory(extension, force, np.zeros_like(extension), unbroken, nothing, nothing)

    def in_equilibrium(self, extension: Array) -> LinkForces:
        """Links in equilibrium before the start, at extensions.

        Those whose length is that at the start pull with their preload until then.
        """
        force, slope = np.empty((2, len(extension)))
        always = np.full_like(extension, np.inf)
        meshed.link_forces(self._laws, extension, extension, always, np.inf, force, slope)
        force = np.where(self._waits, self._preload, force)
        slope = np.where(self._waits, 0.0, slope)
        return LinkForces(extension, force, slope, np.ones(self.count))

    # ---- A step

    def in_step(self, memory: LinkMemory, end: Array, dt: float, breaks: Mask) -> LinkForces:
        """Forces of a step of dt (s) to extensions at its end; `breaks`: in it."""
        start, to = memory.extension - memory.plastic, end - memory.plastic
        share = np.where(memory.broken, 0.0, 1.0)
        for number in breaks.nonzero()[0]:
            share[number] = self._share(number, start, to)
        acts = share[self.of]
        to = np.where(acts < 1.0, start + acts * (to - start), to)
        force, slope = np.empty((2, len(end)))
        meshed.link_forces(self._laws, start, to, acts * dt, dt, force, slope)
        return LinkForces(end, force, np.where(acts < 1.0, 0.0, slope), share)

    def _share(self, number: int, start: Array, end: Array) -> float:
        """Part of the way between elastic extensions at which a link is loaded as it can bear."""
        own, strength = self._own[number], self._strength[number]

        def left(share: float) -> float:
            return strength - self._load(own, start[own] + share * (end[own] - start[own]))

        low, high = 0.0, 1.0
        if left(low) <= 0 or left(high) > 0:
            return float(left(low) > 0)
        while low < (middle := 0.5 * (low + high)) < high:
            low, high = (low, middle) if left(middle) <= 0 else (middle, high)
        return low

    def _load(self, own: slice, elastic: Array) -> float:
        """Size of the spring force of a link at elastic extensions of its directions, N."""
        return float(np.linalg.norm(self._springs(elastic, own)[0]))

    def overloaded(self, memory: LinkMemory, end: Array) -> Mask:
        """Links that are loaded by more than their strength at extensions, (links,)."""
        loads = [self._load(own, (end - memory.plastic)[own]) for own in self._own]
        return ~memory.broken & (np.array(loads) > (1 + BREAKING) * self._strength)

    def after(
        self, memory: LinkMemory, reached: LinkForces, time: float, dt: float, breaks: Mask
    ) -> tuple[LinkMemory, float]:
        """Links after a step of dt (s) from a time, and what flow, dashpots, fracture took, J."""
        way, broken = reached.extension - memory.extension, memory.broken | breaks
        _, _, flow = self._springs(reached.extension - memory.plastic)
        to = memory.extension - memory.plastic + reached.share[self.of] * way
        _, energy, _ = self._springs(to)
        held = np.bincount(self.of, energy, self.count)
        after = LinkMemory(
            extension=reached.extension,
            force=reached.force,
            plastic=memory.plastic + np.where(broken[self.of], 0.0, flow),
            broken=broken,
            broken_at=np.where(breaks, time + reached.share * dt, memory.broken_at),
            lost=np.where(breaks, held, memory.lost),
        )
        return after, self.energy(memory) + float(reached.force @ way) - self.energy(after)

    def energy(self, memory: LinkMemory) -> float:
        """Energy of all springs, J."""
        _, energy, _ = self._springs(memory.extension - memory.plastic)
        return float(energy[~memory.broken[self.of]].sum())

    def _springs(self, elastic: Array, own: slice = slice(None)) -> tuple[Array, Array, Array]:
        """Forces (N) and energies (J) of springs at elastic extensions, and their flow, m.

        Of all directions, or of some.
        """
        force, energy, flow = np.empty((3, len(elastic)))
        meshed.link_springs(self._laws[own], elastic, force, energy, flow)
        return force, energy, flow

    def numbers(self, memory: LinkMemory) -> Array:
        """All links as `LinkStates` takes them apart, (links, 3 d + 3)."""
        d = self.dimension
        found = np.zeros((self.count, 3 * d + 3))
        for k, values in enumerate((memory.extension, memory.force, memory.plastic)):
            found[self.of, k * d + self._axis] = values
        found[:, 3 * d] = memory.broken
        found[:, 3 * d + 1], found[:, 3 * d + 2] = memory.broken_at, memory.lost
        return found
