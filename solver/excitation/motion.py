"""The motion of the ground in all directions, read for a scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from solver.excitation.kinds import BaseMotion, base_motion
from solver.parallel import Comm, on_first_rank
from solver.scene import Scene
from solver.types import Array


@dataclass(frozen=True, slots=True)
class GroundMotion:
    """The motion of the ground in all directions together."""

    parts: tuple[BaseMotion | None, ...]
    """Along x and y (3-D: x, y and z); None: no motion in this direction."""

    @property
    def moves(self) -> bool:
        """True if there is motion in some direction."""
        return any(self.parts)

    @property
    def along(self) -> BaseMotion | None:
        """The motion along x."""
        return self.parts[0]

    @property
    def up(self) -> BaseMotion | None:
        """The vertical motion."""
        return self.parts[-1]

    def acceleration(self, time: Array | float) -> Array:
        """Acceleration of the ground at one time, m/s^2, (d,), or at many, (n, d)."""
        still = np.zeros(np.shape(time))
        return np.stack([p.acceleration(time) if p else still for p in self.parts], axis=-1)

    def velocity(self, time: Array | float) -> Array:
        """Velocity of the ground at one time, m/s, (d,), or at many, (n, d)."""
        still = np.zeros(np.shape(time))
        return np.stack([p.velocity(time) if p else still for p in self.parts], axis=-1)

    def mean(self, time: float, dt: float) -> Array:
        """Mean acceleration from a time on, for a time dt, m/s^2, (d,): see `means`."""
        return self.means(np.array([time, time + dt]))[0]

    def means(self, times: Array) -> Array:
        """Mean accelerations from each of n times to the next, m/s^2, (n - 1, d).

        What the velocity gains over the time that passes, so that steps of any length take up the
        whole impulse.
        """
        return np.asarray(np.diff(self.velocity(times), axis=0) / np.diff(times)[:, None])


def read_ground(scene: Scene, comm: Comm | None = None) -> GroundMotion:
    """The motion of the ground, read and computed on rank 0, and sent to the others.

    The limits of the scene are checked with its peaks here.
    Collective on all ranks of `comm`; without one this process reads for itself alone.

    Raises:
        SceneError: A file cannot be read, or the scene is beyond its limits; on every rank alike.
    """
    if comm is None:
        return _read(scene)
    return cast("GroundMotion", on_first_rank(comm, lambda: _read(scene)))


def _read(scene: Scene) -> GroundMotion:
    """The motions of all directions, each read once."""
    found, shaking = dict[str, BaseMotion | None](), 0.0
    for where, spec in scene.motions:
        found[where] = motion = base_motion(spec, scene.time.end, where)
        shaking += motion.peak if motion else 0.0
    scene.check_limits(shaking)
    return GroundMotion(tuple(found.get(direction) for direction in scene.directions))
