"""Pieces of smooth motion between events, for the event-driven reference solutions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Acceleration = Callable[[float], float]
"""Acceleration of the ground, m/s^2, at a time in s; positive towards +x."""


State = Sequence[float] | NDArray[np.float64]
"""Positions and velocities, one after the other."""

EXACT = 1e-11
"""Relative tolerance of the integrator where nothing is said; others are those of quicker ones."""


def still(time: float) -> float:
    """The ground that does not move."""
    return 0.0


def first_beyond(
    acceleration: Acceleration, limit: Acceleration, start: float, end: float, step: float
) -> float | None:
    """The first time at which |acceleration| exceeds the limit of that time, or None.

    Looked for every `step` and then narrowed down; what is returned lies beyond the limit, by
    round-off, so that a motion that begins there does begin.
    """

    def beyond(time: float) -> bool:
        return abs(acceleration(time)) > limit(time)

    low = start
    while not beyond(low):
        high = min(low + step, end)
        if high <= low:
            return None
        if beyond(high):
            return _narrowed(beyond, low, high)
        low = high
    return low


def _narrowed(beyond: Callable[[float], bool], low: float, high: float) -> float:
    while low < (middle := (low + high) / 2) < high:
        if beyond(middle):
            high = middle
        else:
            low = middle
    return high


@dataclass(slots=True)
class Recorder:
    """The state at the output times, filled phase by phase: position, velocity and what follows."""

    time: NDArray[np.float64]
    size: int = 2
    """Numbers in a state."""
    states: NDArray[np.float64] = field(init=False)
    """One row for each time."""

    def __post_init__(self) -> None:
        """Begin with a body at rest."""
        self.states = np.zeros((len(self.time), self.size))

    def rest(self, start: float, position: float) -> None:
        """From `start` on the body stays where it is; later phases write over it."""
        later = self.time >= start
        self.states[later] = 0.0
        self.states[later, 0] = position

    def move(self, start: float, end: float, solution: Callable[..., Any]) -> None:
        """From `start` to `end` the state is what a dense solution says."""
        inside = (self.time >= start) & (self.time <= end)
        if inside.any():
            self.states[inside] = solution(self.time[inside]).T


def output_times(end: float, step: float) -> NDArray[np.float64]:
    """0, step, 2 step ... up to `end`."""
    times = np.arange(int(end / step * (1 + 1e-12)) + 1, dtype=np.float64) * step
    return np.minimum(times, end)  # k step may exceed the end by round-off, and no phase reaches it


def event(function: Callable[..., float], *, falling: bool, terminal: bool) -> Any:
    """A zero of function(time, state) as `scipy.integrate.solve_ivp` takes its events."""
    marked: Any = function
    marked.direction, marked.terminal = -1 if falling else 1, terminal
    return marked


def _first_step(span: float, step: float, velocity: float, pull: float) -> float:
    """First step of the integrator, s, of a phase that takes no longer than the span.

    A flight that begins with velocity v and is pulled back by a lasts about 2 v / a: the first step
    must end well inside, as only sign changes between steps are noticed.
    """
    first = min(step, span) / 64
    return min(first, abs(velocity / (8 * pull))) if velocity and pull else first


def solve(
    derivative: Callable[[float, Any], Sequence[float]],
    span: tuple[float, float],
    state: State,
    *,
    step: float,
    events: list[Any],
    tolerance: float = EXACT,
) -> Any:
    """Solve y' = derivative(time, y) until a terminal event; scipy's solution object.

    Args:
        derivative: Smooth over the phase or nearly so.
        span: Start and end, s.
        state: y at the start, a position, its velocity, and what follows.
        step: Largest step of the integrator, s: no feature of the ground's motion is stepped over.
        events: As `scipy.integrate.solve_ivp` takes them.
        tolerance: Relative.
    """
    from scipy.integrate import solve_ivp

    start, end = span
    first = _first_step(end - start, step, float(state[1]), derivative(start, state)[1])
    # Where nothing moves yet, scipy's estimate of the error may be 0/0: it then shortens the step.
    with np.errstate(invalid="ignore"):
        return solve_ivp(
            derivative,
            span,
            state,
            method="DOP853" if tolerance <= EXACT else "RK45",
            dense_output=True,
            events=events,
            rtol=tolerance,
            atol=1e-3 * tolerance,
            max_step=step,
            first_step=first,
        )
