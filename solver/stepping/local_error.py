"""The error of a step, from third differences of the motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from solver.scheme.step_control import Tolerance
from solver.stepping.state import State
from solver.stepping.system import System
from solver.types import Array


class StepError(NamedTuple):
    """Error of a step, over a length of the scene.

    Attributes:
        rigid: Of the motion of a body as a whole, the largest.
        vibration: Of the points of a meshed body beside the motion as a whole, root of the mean
            square, the largest.
        reversal: Of slips that turned round within the step, the largest.
    """

    rigid: float
    vibration: float
    reversal: float


class Past(NamedTuple):
    """Differences over earlier steps, for the estimate."""

    u: Array
    """Displacement at t_n, m."""
    rigid: Array
    """Velocities of the bodies as a whole at t_n, m/s."""
    rigid_change: Array
    """Their mean accelerations in the last step, m/s2; 0 before the first."""
    mean: Array
    """Mean velocities of all points in the last step, m/s; before the first, those at its start."""
    change: Array
    """Accelerations between the last two steps, m/s2; 0 before the second."""
    dt: float = 0.0
    """Length of the last step, s; 0 before the first."""
    dt_before: float = 0.0
    """Length of the step before the last one, s; 0 likewise."""


class LocalError:
    """Estimates the error that a step makes in the motion of the bodies.

    The scheme moves every body by u_{n+1} - u_n = dt (v_n + v_{n+1})/2, the trapezoidal rule, whose
    error in a step is dt^3/12 u''' (Hairer, Norsett and Wanner 1993, II.1). For bodies as a whole
    u''' is the change of the mean acceleration from one step to the next; for the points of meshed
    bodies it is the third difference of the displacement, less that of the motion as a whole, which
    is judged already: velocities at the shortest waves of the mesh change their sign from step to
    step and are no measure of anything.

    A slip that turns round within a step leaves no such trace, since friction has the old direction
    in all of it. It moves back at the end with a velocity v that friction has not opposed: as an
    error, dt v/12.

    Before the start nothing accelerates. What is let go, or meets its support as it starts, does so
    in the first step, which is judged like every other.
    """

    def __init__(self, system: System, size: float):
        """Refer errors to a length R, m."""
        self._system, self._size = system, size
        self._meshed = [(system.bodies.index(body), body, own) for body, own in system.meshed]

    def start(self, state: State) -> Past:
        """Differences before the first step, from a state."""
        rigid = self._rigid_velocity(state)
        return Past(
            u=state.u,
            rigid=rigid,
            rigid_change=np.zeros_like(rigid),
            mean=state.v,
            change=np.zeros_like(state.v),
        )

    def of(self, past: Past, new: State, dt: float) -> tuple[StepError, Past]:
        """Error of the step of length `dt` (s) that led to `new`, and what it leaves itself."""
        rigid, third = self._rigid_velocity(new), dt**3 / 12 / self._size
        between, apart = (dt + past.dt) / 2, (dt + 2 * past.dt + past.dt_before) / 4
        mean: Array = np.divide(new.u - past.u, dt)
        change: Array = np.divide(mean - past.mean, between)
        third_difference: Array = np.divide(change - past.change, apart)
        rigid_change: Array = np.divide(rigid - past.rigid, dt)
        jerk = float(np.abs(rigid_change - past.rigid_change).max()) / between
        vibration = third * self._vibration(new, third_difference)
        errors = third * jerk, vibration, dt * new.reversal / 12 / self._size
        if self._system.comm.size > 1:  # all ranks decide by the same digits
            errors = self._system.comm.bcast(errors, root=0)
        left = Past(new.u, rigid, rigid_change, mean, change, dt, past.dt)
        return StepError(*errors), left

    def _vibration(self, new: State, motion: Array) -> float:
        """Root of the mean square of the vibration in a motion of a meshed body, the largest."""
        squares = [
            body.vibration(new.u[own], motion[own], new.rigid_motion(self._system, number).rotation)
            for number, body, own in self._meshed
        ]
        return math.sqrt(max(squares, default=0.0))

    def _rigid_velocity(self, state: State) -> Array:
        """Velocities of the centres of all bodies, and of points at R for their turning, m/s."""
        parts = []
        for number in range(len(self._system.bodies)):
            motion = state.rigid_motion(self._system, number)
            parts += [motion.velocity, self._size * motion.spin]
        return np.concatenate(parts)


class Judge:
    """Says which steps are good enough, and when longer ones may be tried.

    A change of contact that falls on the very end of a step leaves nothing in its own error, and
    all of it in that of the next step. So a step in which contact changes is judged by the step
    after it as well, of the same length.
    """

    def __init__(self, error: LocalError, tolerance: Tolerance, start: State):
        """Compare an error with a tolerance, from a state on."""
        self._estimate, self._tolerance = error, tolerance
        self._past = self._tried = error.start(start)
        self._used = 0.0

    def saved(self) -> Any:
        """Differences over earlier steps, for `resume`."""
        return self._past, self._used

    def resume(self, saved: Any) -> None:
        """Go on from the earlier steps of another judge."""
        self._past, self._used = saved
        self._tried = self._past

    def accepts(
        self, new: State, dt: float, following: Callable[[State, float], State | None]
    ) -> bool:
        """True if a step is good enough.

        Args:
            new: Where it led.
            dt: Its length, s.
            following: Gives the state a step of a length (s) after another; None if it fails.
        """
        error, self._tried = self._estimate.of(self._past, new, dt)
        self._used = self._tolerance.used(
            rigid=error.rigid,
            vibration=error.vibration,
            reversal=error.reversal,
            changed=new.changed,
        )
        if self._used <= 1.0 and new.changed:
            after = following(new, dt)
            if after is not None:
                later, _ = self._estimate.of(self._tried, after, dt)
                used = self._tolerance.used(
                    rigid=later.rigid, vibration=0.0, reversal=0.0, changed=True
                )
                if used > self._tolerance.GROWTH:
                    self._used = used / self._tolerance.GROWTH
        return self._used <= 1.0

    @property
    def halvings(self) -> int:
        """Halvings of the step that was judged last, and refused."""
        return self._tolerance.halvings(self._used)

    def climbs(self) -> bool:
        """Take the step that was judged last; True if one twice as long may follow."""
        self._past = self._tried
        return self._tolerance.climbs(self._used)
