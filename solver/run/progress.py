"""Progress of a run: a bar on a terminal, a line now and then elsewhere; on rank 0 only."""

from __future__ import annotations

import sys
import time as clock
from typing import Any

from solver.run.streams import tell

#: Share of the whole that has to be done between two lines, and the time (s) between them.
EVERY_PART = 0.1
EVERY_SECONDS = 2.0

#: Shortest time between two drawings of the bar of a run, s.
EVERY_DRAWING = 0.1


class ProgressDisplay:
    """Bar or lines on the standard error output, shared by runs and studies."""

    def __init__(self, *, quiet: bool, rank: int, done: float = 0.0, **bar: Any):
        """Start, with the share that had been done before; shows nothing but on rank 0.

        `bar` are arguments for tqdm: total, initial, bar_format.
        """
        self._silent = quiet or rank != 0
        self._began = self._shown_at = clock.monotonic()
        self._shown_share = done
        self._bar: Any = None
        if not self._silent and sys.stderr.isatty():
            self._bar = _bar(**bar)

    def _line_is_due(self, now: float, share: float) -> bool:
        """True if a line is to be written at this share of the whole; it then counts as written."""
        late = now - self._shown_at >= EVERY_SECONDS
        due = late and share - self._shown_share >= EVERY_PART
        if due:
            self._shown_at, self._shown_share = now, share
        return due

    def _write(self, line: str) -> None:
        """Write a line at once."""
        tell(f"{line}\n")

    def close(self) -> None:
        """Show no more."""
        if self._bar is not None:
            self._bar.close()
        self._silent = True


class Progress(ProgressDisplay):
    """Time, step size and iterations of a run, and the time that is left."""

    def __init__(self, end: float, *, quiet: bool = False, rank: int = 0):
        """Start at time 0 of a run up to a time `end`, s; shows nothing but on rank 0."""
        layout = "{percentage:3.0f}%|{bar}| {elapsed}<{remaining}{postfix}"
        super().__init__(quiet=quiet, rank=rank, total=100.0, bar_format=layout)
        self._end = end
        self._last = (0.0, 0.0, 0)
        self._from, self._steps_began = 0.0, self._began

    def begin(self, time: float) -> None:
        """Count what is left from here: set-up is over, and steps begin at a time (s)."""
        self._from, self._steps_began = time, clock.monotonic()
        if self._bar is not None:
            self._bar.unpause()

    def update(self, time: float, step: float, iterations: int) -> None:
        """Tell of a finished step: the time at its end, its length (s), its Newton iterations."""
        if self._silent:
            return
        self._last = (time, step, iterations)
        now = clock.monotonic()
        if self._bar is not None:
            if now - self._shown_at >= EVERY_DRAWING:
                self._shown_at = now
                self._draw()
        elif self._line_is_due(now, time / self._end):
            self._write_state(now)

    def close(self) -> None:
        """Show the last step and stop."""
        if self._silent:
            return
        if self._bar is not None:
            self._draw()
        else:
            self._write_state(clock.monotonic())
        super().close()

    def _draw(self) -> None:
        """Draw the bar at the last step."""
        time, step, iterations = self._last
        self._bar.n = round(100 * min(1.0, time / self._end), 1)
        self._bar.set_postfix_str(
            f"t {time:.4g}/{self._end:.4g} s, step {step:.2g} s, {iterations} iterations"
        )

    def _write_state(self, now: float) -> None:
        """Write a line about the last step."""
        time, step, iterations = self._last
        spent = now - self._began
        done = time - self._from
        stepping = now - self._steps_began
        line = f"t {time:.4g} of {self._end:.4g} s ({100 * time / self._end:.0f} %), "
        if done > 0:
            left = stepping * (self._end - time) / done
            line += f"step {step:.2g} s, {iterations} iterations, "
            self._write(f"{line}{spent:.0f} s spent, {left:.0f} s left")
        else:
            self._write(f"{line}{spent:.0f} s spent")


def _bar(**bar: Any) -> Any:
    """A bar of tqdm, or None without tqdm."""
    try:
        from tqdm import tqdm
    except ImportError:
        return None
    return tqdm(file=sys.stderr, leave=True, **bar)
