"""Ctrl-C and SIGTERM end a run in good order instead of killing it."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any

from mpi4py import MPI

from solver.parallel import any_rank


class Interruption:
    """While entered, SIGINT and SIGTERM are noted; `requested` tells every rank that one was."""

    def __init__(self, comm: MPI.Intracomm):
        """Watch on behalf of `comm`."""
        self._comm = comm
        self._signal: int | None = None
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Interruption:
        """Take over the signals; only the main thread of a process may."""
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
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
    def signal_name(self) -> str:
        """Name of the signal that came, on the rank that got it."""
        return (
            signal.Signals(self._signal).name
            if self._signal is not None
            else "a signal to another rank"
        )

    def requested(self) -> bool:
        """Whether the run is to stop; collective, the same on every rank."""
        return any_rank(self._comm, self._signal is not None)
