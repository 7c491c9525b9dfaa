"""The contact points of all interfaces put together, as one step sees them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from solver.contact.body_points import SurfaceState
from solver.contact.interface import Memory
from solver.contact.projection import ContactKinematics
from solver.law.friction import Bounds
from solver.law.local_problem import image
from solver.stepping.system import Link, System
from solver.types import Array, Indices, Mask

Scalar = TypeVar("Scalar", bound=np.generic)

MOST_CROSSED = 8
"""How often a point may cross an edge in the corrections of a step."""

GLUE = 1e6
"""Coefficient of friction that holds anything."""

MARGIN = 0.002
"""Points farther from their carrier than this part of their body's size after the free step are not
pressed into it by the others."""


def joined(arrays: Sequence[NDArray[Scalar]]) -> NDArray[Scalar]:
    """Arrays of several interfaces one after another; a single one as it is."""
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


def frames_at(chosen: Indices, frames: Sequence[Array], own: Sequence[slice]) -> Array:
    """Frames at some of the points of all interfaces, (m, d, d).

    Args:
        chosen: Numbers of the points.
        frames: Of each interface: one, (d, d), or one for each of its points.
        own: Numbers of the points of each interface.
    """
    d = frames[0].shape[-1]
    found = np.empty((len(chosen), d, d))
    for frame, part in zip(frames, own, strict=True):
        inside = (chosen >= part.start) & (chosen < part.stop)
        found[inside] = frame if frame.ndim == 2 else frame[chosen[inside] - part.start]
    return found


@dataclass(frozen=True, slots=True)
class Contact:
    """One interface at the end of a step: its points, their seats, forces and bounds."""

    surface: SurfaceState
    seat: ContactKinematics
    force: Array
    bounds: Bounds


class AllPoints:
    """Forces, anchors and bounds of all points; who sleeps, who breaks loose.

    Attributes:
        force: Point forces f of the present iterate, (points, d), N.
        anchor: Stick memory, (points, d-1), m.
        softness: 1/(gamma_h w), 0 for points of rigid bodies, (points,), m/N.
        round_off: Of their gaps, (points,), m.
        seen: Surface and seat of each interface at the present iterate.
    """

    def __init__(self, system: System, links: Sequence[Link]):
        """Number the points: interface after interface."""
        self._system, self.links = system, tuple(links)
        ends = np.cumsum([link.interface.count for link in links]).tolist()
        self.own = [slice(*pair) for pair in zip([0, *ends[:-1]], ends, strict=True)]
        self.softness = np.concatenate([link.interface.softness for link in links])
        self._near: tuple[Indices, Bounds] | None = None
        self._bound_glued = False
        self._speed: Array = np.empty((0,))
        self._mu: Array = np.empty((0,))
        self._cohesion: Array = np.empty((0,))
        # Whether friction depends on neither speed nor the past.
        self._steady = all(link.interface.law.constant for link in links)
        self._decays = any(link.interface.law.decays for link in links)
        self._size: Array = np.concatenate(
            [np.full(link.interface.count, link.interface.size) for link in links]
        )
        self._margin = MARGIN * self._size
        self.round_off = 2 * float(np.finfo(float).eps) * self._size
        self._out: Mask | None = None
        self._was_out: Mask | None = None

    def begin(
        self, memories: Sequence[Memory], guess: Array, *, step: float, static: bool, glued: bool
    ) -> None:
        """Start a step from what contact remembers.

        Args:
            memories: Of each interface.
            guess: Predicted displacement of all owned unknowns.
            step: dt, s, for the speed of slip; infinite in equilibrium.
            static: Whether it is an equilibrium.
            glued: Whether closed points hold any friction.
        """
        self.memories, self._step, self._glued = memories, step, glued
        self.force = np.concatenate([memory.force for memory in memories])
        self.anchor = joined([memory.anchor for memory in memories])
        self._may_touch = joined([memory.may_touch for memory in memories])
        self.frames = [link.interface.carrier.frame for link in self.links]
        self.seen: list[tuple[SurfaceState, ContactKinematics]] = []
        self._slipped = [memory.slipped for memory in memories]
        self._bind(None)
        self._was_out = None
        self._crossed = np.zeros(len(self.force), dtype=np.int64)
        self.asleep = [not static and self._far(k, guess) for k in range(len(self.links))]

    def look(self, number: int, u: Array) -> tuple[SurfaceState, ContactKinematics]:
        """An interface at a displacement of all owned unknowns."""
        link, part = self.links[number], self._system.part
        return link.interface.observe(part(u, link.body), part(u, link.carrier))

    def augmented(self) -> Array:
        """Augmented positions of all points."""
        parts, self._out = [], None
        for number, (surface, seat) in enumerate(self.seen):
            parts.append(self.links[number].interface.augmented(surface, seat))
            off = True if self.asleep[number] else self._off(number, seat)
            if off is not None and np.any(off):
                if self._out is None:
                    self._out = np.zeros(len(self.force), dtype=bool)
                self._out[self.own[number]] = off
        self._settle_edges()
        return parts[0].copy() if len(parts) == 1 else np.concatenate(parts)

    def _settle_edges(self) -> None:
        """Points that go to and fro over an edge, pushed off and falling back, stay off."""
        last, self._was_out = self._was_out, self._out
        if last is None and self._out is None:
            return
        none = np.zeros(len(self.force), dtype=bool)
        was, is_out = (none if out is None else out for out in (last, self._out))
        self._crossed += was != is_out
        lively = self._crossed > MOST_CROSSED
        if lively.any():
            self._out = self._was_out = is_out | lively

    def _off(self, number: int, seat: ContactKinematics) -> Mask | None:
        """Points beyond the edge of their carrier, where it has one.

        One that the step begins with stays a point until its end: let go in the middle of a solve,
        it would lose the friction that keeps it from going.
        """
        carrier = self.links[number].interface.carrier
        before, now = carrier.beyond_edge(self.memories[number].seat), carrier.beyond_edge(seat)
        return None if before is None or now is None else before & now

    def near(self, y: Array) -> Indices:
        """Numbers of the points that may be in contact at augmented positions y.

        Those of sleeping interfaces and beyond an edge are put far from their carrier, whatever
        their gap: a foot far beyond an edge goes to and fro with the face.
        """
        if self._out is not None:
            y[self._out, 0] = self._size[self._out]
        touching = (y[:, 0] < self._margin) & self._may_touch | (self.force[:, 0] > 0)
        return touching.nonzero()[0]

    def frames_at(self, near: Indices) -> Array:
        """Frames of the carriers of points, (m, d, d)."""
        return frames_at(near, self.frames, self.own)

    def bounds_at(self, near: Indices, y: Array) -> Bounds:
        """Bounds of friction at near points, by the slip of the last iterate."""
        if not self._steady:
            slip = y[:, 1:] - self.anchor
            slip += self.softness[:, None] * self.force[:, 1:]
            self._speed = self._speed_of(slip)
            self._bind(self._speed)
        return self._bounds_near(near)

    def follow(self, near: Indices, q: Array, W: Array, force: Array) -> Bounds | None:
        """Bounds at near points by the slip q + W f that they led to; None if they are the same.

        Args:
            near: Numbers of the points.
            q: Free values of the local problem, (m, d), m.
            W: Its compliance, (m, d, m, d), m/N.
            force: Its solution, (m, d), N.
        """
        if not self._decays:
            return None
        slip = (q + image(W, force))[:, 1:]
        self._speed[near] = self._speed_of(slip)
        before = self._mu
        self._bind(self._speed)
        if np.abs(self._mu - before).max() <= 1e-9 * before.max():
            return None
        return self._bounds_near(near)

    def _speed_of(self, slip: Array) -> Array:
        """Speed (m/s) of slips in a step, (m, d-1)."""
        return np.sqrt(np.sum(slip**2, axis=1)) / self._step

    def _bounds_near(self, near: Indices) -> Bounds:
        """The present bounds of near points; kept as long as both are the same."""
        if self._near is None or near is not self._near[0]:
            self._near = near, Bounds(self._mu[near], self._cohesion[near])
        return self._near[1]

    def _bind(self, speed: Array | None) -> None:
        """Bounds of friction of all points, by their speed of slip (m/s)."""
        self.bounds = [
            Bounds.uniform(GLUE, link.interface.count)
            if self._glued
            else link.interface.bounds(memory, slipped, None if speed is None else speed[own])
            for link, memory, slipped, own in zip(
                self.links, self.memories, self._slipped, self.own, strict=True
            )
        ]
        if not self._steady or self._bound_glued != self._glued:
            self._near, self._bound_glued = None, self._glued
        self._mu = joined([bounds.mu for bounds in self.bounds])
        self._cohesion = joined([bounds.cohesion for bounds in self.bounds])

    def break_loose(self) -> bool:
        """Points that held on static friction and reached it slip from now on: mu_s to mu_d only.

        True where there are any: their forces are those of the wrong friction then.
        """
        any_loose = False
        for k, (link, own) in enumerate(zip(self.links, self.own, strict=True)):
            if link.interface.jumps and not self._glued:
                loose = link.interface.at_bound(self.force[own], self.bounds[k])
                loose &= ~self._slipped[k]
                if loose.any():
                    self._slipped[k] = self._slipped[k] | loose
                    any_loose = True
        if any_loose:
            self._bind(None)
        return any_loose

    def _far(self, number: int, guess: Array) -> bool:
        """Whether an interface need not be looked at in this step, far from contact as it is.

        Only those without tractions can sleep: the theta term acts on open points, too.
        """
        interface = self.links[number].interface
        if interface.theta or self.memories[number].force.any():
            return False
        return self._clearance(number, guess) > 5 * MARGIN * interface.size

    def _clearance(self, number: int, u: Array) -> float:
        """Smallest gap of an interface's points that may touch, m."""
        _, seat = self.look(number, u)
        off = self._off(number, seat)
        may_touch = self.memories[number].may_touch
        may = may_touch if off is None else may_touch & ~off
        return float(np.min(seat.place[may, 0], initial=np.inf))

    def wake(self, u: Array) -> bool:
        """Whether interfaces that were left out have come into contact after all."""
        woken = [
            number
            for number, asleep in enumerate(self.asleep)
            if asleep and self._clearance(number, u) < 0
        ]
        for number in woken:
            self.asleep[number] = False
        return bool(woken)

    def contacts(self, u: Array) -> list[Contact]:
        """Every interface at the end of the step."""
        seen = [
            self.look(number, u) if asleep else self.seen[number]
            for number, asleep in enumerate(self.asleep)
        ]
        return [
            Contact(*pair, self.force[own], bounds)
            for pair, own, bounds in zip(seen, self.own, self.bounds, strict=True)
        ]
