"""How far a run is: a bar on a terminal, a line now and then elsewhere; on rank 0 only."""

from __future__ import annotations

import sys
import time as clock
from typing import Any

#: Lines are written after this part of the run, but not within this time of the last (s).
EVERY_PART = 0.1
EVERY_SECONDS = 2.0

#: The bar is drawn at most this often (s).
EVERY_DRAWING = 0.1


class Progress:
    """Shows time, step size, iterations and the time that is left."""

    def __init__(self, end: float, *, quiet: bool = False, rank: int = 0):
        """Start at time 0.

        Args:
            end: Time at which the run ends, s.
            quiet: Show nothing.
            rank: Rank of this process: all but 0 show nothing.
        """
        self._end = end
        self._silent = quiet or rank != 0
        self._began = self._shown_at = clock.monotonic()
        self._shown_part = 0.0
        self._last = (0.0, 0.0, 0)
        self._bar: Any = None
        if not self._silent and sys.stderr.isatty():
            self._bar = _bar()

    def update(self, time: float, step: float, iterations: int) -> None:
        """Tell of a finished step.

        Args:
            time: Time at the end of the step, s.
            step: Step size, s.
            iterations: Newton iterations of the step.
        """
        if self._silent:
            return
        self._last = (time, step, iterations)
        now = clock.monotonic()
        if self._bar is not None:
            if now - self._shown_at >= EVERY_DRAWING:
                self._shown_at = now
                self._draw()
        elif (
            now - self._shown_at >= EVERY_SECONDS
            and time / self._end - self._shown_part >= EVERY_PART
        ):
            self._shown_at, self._shown_part = now, time / self._end
            self._write_line(now)

    def close(self) -> None:
        """Show the last step and stop."""
        if self._silent:
            return
        if self._bar is not None:
            self._draw()
            self._bar.close()
        else:
            self._write_line(clock.monotonic())
        self._silent = True

    def _draw(self) -> None:
        """The bar at the last step."""
        time, step, iterations = self._last
        self._bar.n = round(100 * min(1.0, time / self._end), 1)
        self._bar.set_postfix_str(
            f"t {time:.4g}/{self._end:.4g} s, step {step:.2g} s, {iterations} iterations"
        )

    def _write_line(self, now: float) -> None:
        """A line for the last step."""
        time, step, iterations = self._last
        spent = now - self._began
        left = spent * (self._end - time) / time if time > 0 else float("nan")
        sys.stderr.write(
            f"t {time:.4g} of {self._end:.4g} s ({100 * time / self._end:.0f} %), "
            f"step {step:.2g} s, {iterations} iterations, {spent:.0f} s spent, {left:.0f} s left\n"
        )
        sys.stderr.flush()


def _bar() -> Any:
    """A bar from 0 to 100 %, or None without tqdm."""
    try:
        from tqdm import tqdm
    except ImportError:
        return None
    layout = "{percentage:3.0f}%|{bar}| {elapsed}<{remaining}{postfix}"
    return tqdm(total=100.0, bar_format=layout, file=sys.stderr, leave=True)
