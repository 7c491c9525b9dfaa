"""Boxes in the plane over level ground, in the compiled world (solver/kernels), for tests."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solver.kernels.world import Body, Mobility, World
from solver.types import Array


class PlaneWorld:
    """Boxes in the plane over level ground, with one law for all pairs."""

    def __init__(self, friction: float, restitution: float = 0.0):
        """Begin with the ground alone."""
        self._world = World(2, (0.0, -9.81), (0.0, 0.5, 0.5), True)
        self._law = (friction, friction, 0.0, 0.0, 0.0, restitution)
        self._world.add(Body(shape=self._world.half_space(), mobility=Mobility.FIXED))
        self._count = 1

    def box(
        self,
        size: tuple[float, float],
        place: Sequence[float] | Array,
        mass: float,
        *,
        turn: float = 0.0,
        velocity: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Add a box by its size (m), centre (m), mass (kg), turn (rad, anticlockwise), velocity."""
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * size
        body = Body(
            shape=self._world.polygon(corners),
            mass=mass,
            inertia=mass * (size[0] ** 2 + size[1] ** 2) / 12,
            centre=place,
            rotation=turn,
            velocity=velocity,
        )
        self._world.add(body)
        self._count += 1

    def begin(self) -> None:
        """Begin with the bodies that are there."""
        pairs = np.zeros((self._count, self._count), dtype=int)
        self._world.begin([self._law], pairs, [()] * self._count)

    def run(self, steps: int, dt: float) -> int:
        """Take steps; returns how many were solved."""
        ground, shift = np.zeros((steps + 1, 2)), np.zeros((steps, 2))
        return len(self._world.run(steps, dt, dt / 4096, ground, shift).closed)

    def bodies(self) -> Array:
        """Of each body x, y, turn, velocities, spin; the first one is the ground."""
        now = self._world.now()
        return np.concatenate([now.centre, now.rotation, now.velocity, now.spin], axis=-1)[0]

    def ledger(self) -> float:
        """Stored energies less input plus losses, J."""
        now = self._world.now()
        return float(now.stored.sum() - now.exchanged[0, 0] + now.exchanged[0, 1:].sum())
