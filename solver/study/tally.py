"""How many tasks of a study are done: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time as clock
from typing import Any

from solver.run.progress import EVERY_PART, EVERY_SECONDS


class Tally:
    """Counts finished tasks and shows the time that is left; on rank 0 only."""

    def __init__(self, total: int, *, done: int = 0, quiet: bool = False, rank: int = 0):
        """Start.

        Args:
            total: Number of tasks.
            done: How many of them had been done before.
            quiet: Show nothing.
            rank: Rank of this process: all but 0 show nothing.
        """
        self._total, self._before, self._done = total, done, done
        self._silent = quiet or rank != 0
        self._began = self._shown_at = clock.monotonic()
        self._shown = done
        self._bar: Any = None
        if not self._silent and sys.stderr.isatty():
            self._bar = _bar(total, done)

    def add(self, name: str) -> None:
        """A task with this name is done."""
        self._done += 1
        if self._silent:
            return
        now = clock.monotonic()
        if self._bar is not None:
            self._bar.set_postfix_str(name, refresh=False)
            self._bar.update()
        elif self._done == self._total or (
            now - self._shown_at >= EVERY_SECONDS
            and self._done - self._shown >= EVERY_PART * self._total
        ):
            self._shown_at, self._shown = now, self._done
            spent = now - self._began
            left = spent * (self._total - self._done) / (self._done - self._before)
            sys.stderr.write(
                f"{self._done} of {self._total} ({name}), {spent:.0f} s spent, {left:.0f} s left\n"
            )
            sys.stderr.flush()

    def close(self) -> None:
        """Show no more."""
        if self._bar is not None:
            self._bar.close()
        self._silent = True


def _bar(total: int, done: int) -> Any:
    """A bar over the tasks, or None without tqdm."""
    try:
        from tqdm import tqdm
    except ImportError:
        return None
    layout = "{percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} {elapsed}<{remaining}{postfix}"
    return tqdm(total=total, initial=done, bar_format=layout, file=sys.stderr, leave=True)
