"""Floor response spectra: what stands on a floor of a structure feels of its acceleration.

The absolute acceleration of a floor is taken from increments of its velocity, so that none is lost
where rows of a history are far apart, and of that of the ground.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solver.excitation.motion import GroundMotion
from solver.excitation.sampled import running_integral
from solver.excitation.spectrum import PERIODS, longest_spacing, response_spectrum
from solver.history.history import History
from solver.types import Array

ALONG_Y = " along y"
"""Ending of the names of spectra along y, in space."""


def has_floors(history: History) -> bool:
    """True if something that carries blocks moves, over more than one row."""
    return len(history) > 1 and any(True for _ in _velocities(history))


def floor_spectra(history: History, ground: GroundMotion | None = None) -> dict[str, Array]:
    """Pseudo-spectral accelerations (m/s2) of ground and floors at `PERIODS`, by their names.

    Where the motion of the ground is not given, it is linear between its rows. The floors are the
    storeys of a frame, from the lowest upwards, or else the platform; empty where nothing moves
    that carries blocks, or where the history has one row.
    """
    if not has_floors(history):
        return {}
    floors, time = list(_velocities(history)), history["time_s"]
    step = min(float(np.median(np.diff(time))), longest_spacing(PERIODS))
    found = {}
    grounds: list[tuple[str, str, str | None]] = [("ground", "", None)]
    if "base.second_acceleration_m_s2" in history:
        grounds.append((f"ground{ALONG_Y}", "second_", None))
    for name, way, velocity in (*grounds, *floors):
        grid = np.arange(time[0], time[-1] + step / 2, step)
        absolute = _ground_velocity(history, ground, way, grid)
        if velocity is not None:
            absolute = absolute + np.interp(grid, time, history[velocity])
        samples = np.diff(absolute) / step
        found[name] = response_spectrum(samples, step, PERIODS)
    return found


def _ground_velocity(
    history: History, ground: GroundMotion | None, way: str, times: Array
) -> Array:
    """Velocity of the ground at some times, m/s."""
    column = f"base.{way}acceleration_m_s2"
    if column not in history:
        return np.zeros(len(times))
    if ground is not None:
        return np.asarray(ground.velocity(times)[:, 1 if way else 0])
    time = history["time_s"]
    return np.interp(times, time, running_integral(time, history[column]))


def _velocities(history: History) -> Iterator[tuple[str, str, str]]:
    """Names of floors, directions as columns of the ground have them, and columns of velocities."""
    for way, along in (("", ""), ("second_", ALONG_Y)):
        column, number = f"velocity_{way}m_s", 1
        while f"foundation.storey_{number}.{column}" in history:
            yield f"storey {number}{along}", way, f"foundation.storey_{number}.{column}"
            number += 1
        if number == 1 and f"platform.{column}" in history:
            yield f"platform{along}", way, f"platform.{column}"
