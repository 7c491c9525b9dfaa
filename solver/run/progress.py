"""Progress of a run: a line that is written over on a terminal, one now and then elsewhere."""

from __future__ import annotations

import sys
import time as clock

from solver.run.streams import tell

#: Share of the whole that has to be done between two lines, and the time (s) between them.
EVERY_PART = 0.1
EVERY_SECONDS = 2.0

#: Shortest time between two drawings of the line on a terminal, s.
EVERY_DRAWING = 0.1

LINE = "\r{}\x1b[K"
"""A line over the one before, and nothing of that behind it."""


class ProgressDisplay:
    """Lines on the standard error output, shared by runs and studies; on rank 0 only."""

    def __init__(self, *, quiet: bool, rank: int, done: float = 0.0):
        """Start, with the share that had been done before."""
        self._silent = quiet or rank != 0
        self._on_terminal = not self._silent and sys.stderr.isatty()
        self._began = self._shown_at = clock.monotonic()
        self._shown_share = done
        self._is_open = False

    def _text(self, now: float) -> str:
        """How far it is at a time of the clock, s."""
        raise NotImplementedError

    def _show(self, share: float, *, last: bool = False) -> None:
        """Show how far it is where a line is due at this share of the whole, or the last one."""
        if self._silent:
            return
        now = clock.monotonic()
        waited, more = now - self._shown_at, share - self._shown_share
        due = waited >= EVERY_SECONDS and more >= EVERY_PART
        if self._on_terminal:
            due = waited >= EVERY_DRAWING
        if not (due or last):
            return
        self._shown_at, self._shown_share = now, share
        text = self._text(now)
        self._is_open = self._on_terminal and not last
        tell((LINE.format(text) if self._on_terminal else text) + "\n" * (not self._is_open))

    def close(self) -> None:
        """Show no more."""
        if self._is_open:
            tell("\n")
        self._is_open, self._silent = False, True


class Progress(ProgressDisplay):
    """Time, step size and iterations of a run, and the time that is left."""

    def __init__(self, end: float, *, quiet: bool = False, rank: int = 0):
        """Start at time 0 of a run up to a time `end`, s; shows nothing but on rank 0."""
        super().__init__(quiet=quiet, rank=rank)
        self._end = end
        self._last = (0.0, 0.0, 0)
        self._from, self._steps_began = 0.0, self._began

    def begin(self, time: float) -> None:
        """Count what is left from here: set-up is over, and steps begin at a time (s)."""
        self._from, self._steps_began = time, clock.monotonic()

    def update(self, time: float, step: float, iterations: int) -> None:
        """Tell of a finished step: the time at its end, its length (s), its Newton iterations."""
        self._last = (time, step, iterations)
        self._show(time / self._end)

    def close(self) -> None:
        """Show the last step and stop."""
        self._show(1.0, last=True)
        super().close()

    def _text(self, now: float) -> str:
        """The last step, the wall time that was spent, and what is left of it."""
        time, step, iterations = self._last
        done, spent = time - self._from, f"{now - self._began:.0f} s spent"
        reached = f"t {time:.4g} of {self._end:.4g} s ({100 * time / self._end:.0f} %)"
        if done <= 0:
            return f"{reached}, {spent}"
        left = (now - self._steps_began) * (self._end - time) / done
        return f"{reached}, step {step:.2g} s, {iterations} iterations, {spent}, {left:.0f} s left"
