"""Whether compiled functions run as machine code or are interpreted: decided for each run.

Importing numba takes longer than a short run that is interpreted, and four times the memory. So
the runs of a process are interpreted until they have taken as long as the import would have.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol
from weakref import WeakSet

#: Environment variable; set to anything but "" or "0": interpret.
SWITCH = "ROCKSLIP_NO_NUMBA"

#: Steps of one block in the plane that take as long interpreted as numba takes to be imported.
SHORT = 1000.0


class Follower(Protocol):
    """What runs as was chosen."""

    def choose_again(self) -> None:
        """Ask what was chosen at the next call."""


@dataclass(slots=True)
class _Choice:
    """What this process does."""

    interprets: bool = False
    """Whether compiled functions are interpreted now."""
    spent: float = 0.0
    """Steps of one block that were interpreted so far."""
    followers: WeakSet[Follower] = field(default_factory=WeakSet)
    """Told whenever another choice was made."""

    def make(self, *, interprets: bool) -> None:
        """Choose."""
        if interprets != self.interprets:
            self.interprets = interprets
            for follower in self.followers:
                follower.choose_again()


CHOICE = _Choice()


def is_interpreted() -> bool:
    """Whether the environment asks to interpret, always."""
    return os.environ.get(SWITCH, "0") not in ("", "0")


@contextmanager
def chosen_for(block_steps: float) -> Iterator[None]:
    """Interpret while a run lasts, if it is short enough for that to be faster.

    By the number of its steps times that of its blocks; infinite: never interpret.
    """
    before = CHOICE.interprets
    CHOICE.make(interprets=CHOICE.spent + block_steps <= SHORT)
    if CHOICE.interprets:
        CHOICE.spent += block_steps
    try:
        yield
    finally:
        CHOICE.make(interprets=before)
