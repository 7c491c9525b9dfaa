"""Floor response spectra: what stands on a floor of a structure feels of its acceleration.

The absolute acceleration of a floor is taken from increments of its velocity, so that none is lost
where rows of a history are far apart, and from the acceleration of the ground at the rows.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solver.excitation.spectrum import PERIODS, longest_spacing, response_spectrum
from solver.history.history import History
from solver.types import Array

ALONG_Y = " along y"
"""How the names of spectra along y end, in space."""


def floor_spectra(history: History) -> dict[str, Array]:
    """Pseudo-spectral accelerations (m/s2) of ground and floors at `PERIODS`, by their names.

    The floors are the storeys of a frame, from the lowest upwards, or else the platform; empty
    where nothing moves that carries blocks, or where the history has one row.
    """
    floors = list(_velocities(history))
    time = history["time_s"]
    if not floors or len(time) < 2:
        return {}
    step = min(float(np.median(np.diff(time))), longest_spacing(PERIODS))
    found = {}
    grounds: list[tuple[str, str, str | None]] = [("ground", "", None)]
    if "base.second_acceleration_m_s2" in history:
        grounds.append((f"ground{ALONG_Y}", "second_", None))
    for name, way, velocity in (*grounds, *floors):
        if f"base.{way}acceleration_m_s2" in history:
            absolute = _ground_velocity(history, way)
        else:
            absolute = np.zeros(len(time))
        if velocity is not None:
            absolute = absolute + history[velocity]
        grid = np.arange(time[0], time[-1] + step / 2, step)
        samples = np.diff(np.interp(grid, time, absolute)) / step
        found[name] = response_spectrum(samples, step, PERIODS)
    return found


def _ground_velocity(history: History, way: str) -> Array:
    """Velocity of the ground at the rows, m/s; its acceleration is linear between them."""
    time, gained = history["time_s"], history[f"base.{way}acceleration_m_s2"]
    parts = np.diff(time) * (gained[1:] + gained[:-1]) / 2
    moved: Array = np.concatenate([[0.0], np.cumsum(parts)])
    return moved


def _velocities(history: History) -> Iterator[tuple[str, str, str]]:
    """Names of floors, directions as columns of the ground have them, and columns of velocities."""
    for way, along in (("", ""), ("second_", ALONG_Y)):
        column, number = f"velocity_{way}m_s", 1
        while f"foundation.storey_{number}.{column}" in history:
            yield f"storey {number}{along}", way, f"foundation.storey_{number}.{column}"
            number += 1
        if number == 1 and f"platform.{column}" in history:
            yield f"platform{along}", way, f"platform.{column}"
