"""Pieces of smooth motion between events, for the event-driven reference solutions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Acceleration = Callable[[float], float]
"""Of the ground, m/s^2, at a time in s; positive towards +x."""


def still(time: float) -> float:
    """The ground that does not move."""
    return 0.0


def first_beyond(
    acceleration: Acceleration, limit: float, start: float, end: float, step: float
) -> float | None:
    """The first time at which |acceleration| exceeds `limit`, or None.

    Looked for every `step` and then narrowed down; what is returned lies beyond the limit, by
    round-off, so that a motion that begins there does begin.
    """
    low = start
    while abs(acceleration(low)) <= limit:
        high = min(low + step, end)
        if high <= low:
            return None
        if abs(acceleration(high)) > limit:
            return _narrowed(acceleration, limit, low, high)
        low = high
    return low


def _narrowed(acceleration: Acceleration, limit: float, low: float, high: float) -> float:
    while low < (middle := (low + high) / 2) < high:
        if abs(acceleration(middle)) > limit:
            high = middle
        else:
            low = middle
    return high


@dataclass(slots=True)
class Recorder:
    """Position and velocity at the output times, filled phase by phase."""

    time: NDArray[np.float64]
    position: NDArray[np.float64] = field(init=False)
    velocity: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        """Begin with a body at rest."""
        self.position, self.velocity = np.zeros_like(self.time), np.zeros_like(self.time)

    def rest(self, start: float, position: float) -> None:
        """From `start` on the body stays where it is; later phases write over it."""
        later = self.time >= start
        self.position[later], self.velocity[later] = position, 0.0

    def move(self, start: float, end: float, solution: Callable[..., Any]) -> None:
        """From `start` to `end` the body moves as a dense solution of (position, velocity) says."""
        inside = (self.time >= start) & (self.time <= end)
        if inside.any():
            self.position[inside], self.velocity[inside] = solution(self.time[inside])


def output_times(end: float, step: float) -> NDArray[np.float64]:
    """0, step, 2 step ... up to `end`."""
    times = np.arange(int(end / step * (1 + 1e-12)) + 1, dtype=np.float64) * step
    return np.minimum(times, end)  # k step may exceed the end by round-off, and no phase reaches it


def event(function: Callable[..., float], *, falling: bool, terminal: bool) -> Any:
    """A zero of function(time, state) as `scipy.integrate.solve_ivp` takes its events."""
    marked: Any = function
    marked.direction, marked.terminal = -1 if falling else 1, terminal
    return marked


def integrate(
    rate: Callable[[float, float], float],
    start: float,
    end: float,
    state: tuple[float, float],
    *,
    step: float,
    events: list[Any],
) -> Any:
    """Solve position'' = rate(time, position) until a terminal event; scipy's solution object.

    Args:
        rate: Second derivative, smooth over the phase or nearly so.
        start: s.
        end: s.
        state: Position and velocity at the start.
        step: Largest step of the integrator, s: no feature of the ground's motion is stepped over.
        events: As `scipy.integrate.solve_ivp` takes them.
    """
    from scipy.integrate import solve_ivp

    # A flight that begins with velocity v and is pulled back by a lasts about 2 v / a: the first
    # step must end well inside, as only sign changes between steps are noticed.
    first = min(step, end - start) / 64
    pull = abs(rate(start, state[0]))
    if state[1] and pull:
        first = min(first, abs(state[1]) / (8 * pull))
    return solve_ivp(
        lambda time, y: (y[1], rate(time, y[0])),
        (start, end),
        state,
        method="DOP853",
        dense_output=True,
        events=events,
        rtol=1e-11,
        atol=1e-14,
        max_step=step,
        first_step=first,
    )
