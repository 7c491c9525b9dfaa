"""Signals and a limit of wall time end a run in good order instead of killing it."""

from __future__ import annotations

import signal
import threading
import time
from types import FrameType
from typing import Any

from solver.parallel import Comm, any_rank

#: Signals to end: Ctrl-C, the usual signal to terminate, and what batch systems announce the end
#: of their time with. The mpirun of Open MPI 6 hands only the last of them on to its ranks.
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)


class Interruption:
    """While entered, signals are noted; `requested` is true on every rank once one was."""

    def __init__(self, comm: Comm, seconds: float | None = None):
        """Watch on behalf of `comm`; `seconds` from now on is also a reason to stop."""
        self._comm, self._seconds = comm, seconds
        self._began = time.monotonic()
        self._signal: int | None = None
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Interruption:
        """Take over the signals; only the main thread of a process may."""
        if threading.current_thread() is threading.main_thread():
            for number in ENDING:
                self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *trouble: object) -> None:
        """Give the signals back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, number: int, frame: FrameType | None) -> None:
        """Signal handler; a second signal does what it did before the run."""
        if self._signal is not None:
            signal.signal(number, self._before[number])
            signal.raise_signal(number)
        self._signal = number

    @property
    def _over(self) -> bool:
        """True if the limit of wall time is reached on this rank."""
        return self._seconds is not None and time.monotonic() - self._began > self._seconds

    @property
    def cause(self) -> str:
        """Cause of the end, as seen on this rank: a signal, the limit, or another rank."""
        if self._signal is not None:
            return signal.Signals(self._signal).name
        return f"the limit of {self._seconds:g} s" if self._over else "another rank"

    def requested(self) -> bool:
        """True if the run is to stop; collective, the same on every rank."""
        return self.anywhere(self._signal is not None or self._over)

    def anywhere(self, here: bool) -> bool:
        """True if `here` is true on any rank; collective, the same on every rank."""
        return any_rank(self._comm, here)
