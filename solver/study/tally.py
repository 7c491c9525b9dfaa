"""Progress of a study: the number of finished cases and the time that is left."""

from __future__ import annotations

import time as clock

from solver.run.progress import ProgressDisplay


class Tally(ProgressDisplay):
    """Finished cases of a study, and the time that is left; shown on rank 0 only."""

    def __init__(self, total: int, *, done: int = 0, quiet: bool = False, rank: int = 0):
        """Start, where `done` of all cases had been done before; shows nothing but on rank 0."""
        layout = "{percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} {elapsed}<{remaining}{postfix}"
        share = done / max(total, 1)
        super().__init__(
            quiet=quiet, rank=rank, done=share, total=total, initial=done, bar_format=layout
        )
        self._total, self._before, self._done = total, done, done

    def add(self, name: str) -> None:
        """Count a finished case of this name."""
        self._done += 1
        if self._silent:
            return
        now = clock.monotonic()
        if self._bar is not None:
            self._bar.set_postfix_str(name, refresh=False)
            self._bar.update()
        elif self._line_is_due(now, self._done / self._total) or self._done == self._total:
            spent = now - self._began
            left = spent * (self._total - self._done) / (self._done - self._before)
            self._write(
                f"{self._done} of {self._total} ({name}), {spent:.0f} s spent, {left:.0f} s left"
            )
