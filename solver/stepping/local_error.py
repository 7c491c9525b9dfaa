"""How far a step is wrong, told from the motion of the bodies as a whole."""

from __future__ import annotations

import numpy as np

from solver.scheme.step_control import Tolerance
from solver.stepping.state import State
from solver.stepping.system import System
from solver.types import Array


class LocalError:
    """Estimates the error that a step makes in the rigid motion of the bodies.

    The scheme moves every body by u_{n+1} - u_n = dt (v_n + v_{n+1})/2, the trapezoidal rule, whose
    error in a step is dt^3/12 u''' (Hairer, Norsett and Wanner 1993, II.1). The third derivative is
    the change of the mean acceleration from one step to the next. Only the velocity of the centre
    of mass and the angular momentum go in: a stiff block's vibration, which no step but the
    shortest resolves, does not hold the steps down.
    """

    def __init__(self, system: System, state: State, size: float):
        """Start at a state.

        Args:
            system: The bodies.
            state: Where the run starts.
            size: Length R to which errors are referred, m.
        """
        self._system, self._size = system, size
        self._velocity = self._rigid_velocity(state)
        self._acceleration: Array | None = None
        self._dt = 0.0
        self._tried: tuple[Array, Array, float] | None = None

    def of(self, new: State, dt: float) -> float:
        """Error of the step of length `dt` (s) that led to `new`, over R; 0 for the first step."""
        velocity = self._rigid_velocity(new)
        acceleration = np.asarray((velocity - self._velocity) / dt)
        self._tried = velocity, acceleration, dt
        if self._acceleration is None:
            return 0.0
        jerk = (acceleration - self._acceleration) / ((dt + self._dt) / 2)
        error = dt**3 / 12 * float(np.abs(jerk).max()) / self._size
        comm = self._system.comm
        return error if comm.size == 1 else float(comm.bcast(error, root=0))  # to the last digit

    def accept(self) -> None:
        """The step that was judged last is taken."""
        assert self._tried is not None
        self._velocity, self._acceleration, self._dt = self._tried
        self._tried = None

    def _rigid_velocity(self, state: State) -> Array:
        """Velocities of the centres of all bodies, and of points at R for their turning, m/s."""
        parts = []
        for number in range(len(self._system.bodies)):
            motion = state.rigid_motion(self._system, number)
            parts += [motion.velocity, self._size * motion.spin]
        return np.concatenate(parts)


class Judge:
    """Says which steps are good enough, and when longer ones may be tried."""

    def __init__(self, error: LocalError, tolerance: Tolerance):
        """Compare an error with a tolerance."""
        self._estimate, self._tolerance = error, tolerance
        self._error = 0.0

    def accepts(self, new: State, dt: float) -> bool:
        """Whether the step of length `dt` (s) that led to `new` is good enough."""
        self._error = self._estimate.of(new, dt)
        return self._tolerance.accepts(self._error)

    def climbs(self) -> bool:
        """The step that was judged last is taken: whether one twice as long may follow."""
        self._estimate.accept()
        return self._tolerance.climbs(self._error)
