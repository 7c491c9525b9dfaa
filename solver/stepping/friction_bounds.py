"""Bounds of friction of all contact points in one step, as points slip and break loose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.contact.memory import Memory
from solver.law.friction import Bounds, points_at_bound
from solver.law.local_problem import image
from solver.stepping.point_table import JoinedBounds, PointTable
from solver.types import Array, Indices

GLUE = 1e6
"""Coefficient of friction that holds anything."""

SAME_FRICTION = 1e-9
"""Part of the largest coefficient of friction within which friction fits the slip it allows."""


class FrictionBounds:
    """Bounds of friction in one step.

    Attributes:
        bounds: Bounds of each interface, by the slip that was told last.
        steady: Whether friction depends on neither speed nor the past, and need not be told.
    """

    def __init__(self, points: PointTable, memories: Sequence[Memory], *, step: float, glued: bool):
        """Start from what contact remembers at t_n.

        The step, s, is infinite in equilibrium; `glued`: closed points hold any friction.
        """
        self._points, self.steady, self._decays = points, points.steady, points.decays
        self._step, self._glued = step, glued
        self._joined = points.bounds
        if self._joined is not None and not glued:
            self.bounds: Sequence[Bounds] = self._joined.each
            return  # nobody tells speeds, and no point breaks loose
        self._pasts = [memory.past for memory in memories]
        laws = [link.interface.law for link in points.links]
        # Asked of the points only where a law needs it.
        self._slips = [
            np.zeros(0, dtype=bool) if law.constant else memory.slipped
            for law, memory in zip(laws, memories, strict=True)
        ]
        self._speed: Array = np.zeros(points.count)
        pairs = zip(points.links, self._pasts, strict=True)
        self.bounds = [link.interface.bounds(past) for link, past in pairs]
        # The coefficients follow the speed that is told, not that of the last step.
        self.bounds = self._at_speed(self._speed)

    def at(self, near: Indices) -> Bounds:
        """Bounds of some points."""
        mu, cohesion = self.of_all()
        return Bounds(mu.take(near), cohesion.take(near))

    def of_all(self) -> tuple[Array, Array]:
        """Coefficients of friction of all points, (points,), and their cohesion, N.

        They are put together once, for as long as they stay.
        """
        if self._joined is None or self._joined.each is not self.bounds:
            self._joined = JoinedBounds.of(self.bounds)
        return self._joined.mu, self._joined.cohesion

    def tell(self, slip: Array) -> None:
        """Take the bounds that go with slips of all points in the step, (points, d-1), m."""
        self._speed = self._speed_of(slip)
        self.bounds = self._at_speed(self._speed)

    def follows(self, near: Indices, W: Array, q: Array, force: Array) -> bool:
        """Take the bounds that go with the slip q + W f; whether they are others than before.

        W is the compliance of the near points, (m, d, m, d), m/N, q their free values, (m, d), m,
        and f the solution with the bounds so far, (m, d), N.
        """
        if not self._decays:
            return False
        solved_with = self.bounds
        before, _ = self.of_all()
        self._speed = self._speed.copy()
        self._speed[near] = self._speed_of((q + image(W, force))[:, 1:])
        self.bounds = self._at_speed(self._speed)
        after, _ = self.of_all()
        if np.abs(after - before).max() > SAME_FRICTION * before.max():
            return True
        # Points that slip are at the bounds that their forces were solved with, to the last digit.
        self.bounds = solved_with
        return False

    def break_loose(self, force: Array) -> bool:
        """Let points that reached their static friction slip from now on; whether there are any.

        They go from mu_s to mu_d only. By forces of all points, (points, d), N, which are then
        those of the wrong friction.
        """
        any_loose = False
        if self.steady:
            return any_loose
        for k, (link, own) in enumerate(zip(self._points.links, self._points.own, strict=True)):
            if link.interface.law.jumps and not self._glued:
                loose = points_at_bound(force[own], self.bounds[k]) & ~self._slips[k]
                self._slips[k] |= loose
                any_loose |= bool(loose.any())
        if any_loose:
            self.bounds = self._at_speed(np.zeros_like(self._speed))
        return any_loose

    def _speed_of(self, slip: Array) -> Array:
        """Speed (m/s) of slips in a step, (m, d-1)."""
        return np.sqrt(np.sum(slip**2, axis=1)) / self._step

    def _at_speed(self, speed: Array) -> list[Bounds]:
        """Bounds of each interface, by the speed of slip of all points, m/s."""
        points = self._points
        if self._glued:
            return [Bounds.uniform(GLUE, link.interface.count) for link in points.links]
        parts = zip(points.links, points.own, self._pasts, self._slips, self.bounds, strict=True)
        return [
            link.interface.bounds_followed(past, before.mu, speed[own], slips)
            for link, own, past, slips, before in parts
        ]
