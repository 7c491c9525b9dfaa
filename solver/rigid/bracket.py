"""Where in a step something happens: a root between two ends. Compiled."""

from __future__ import annotations

from solver.law.compiled import compiled
from solver.types import Array


@compiled
def next_length(bracket: Array, length: float, value: float) -> float:
    """One round of regula falsi (Illinois) for a value that falls from positive to negative.

    Args:
        bracket: Length and value at the lower and the upper end, the side that moved last.
        length: Tried last.
        value: What it gave.
    """
    side = 1.0 if value > 0.0 else -1.0
    moving, staying = (0, 2) if value > 0.0 else (2, 0)
    bracket[moving], bracket[moving + 1] = length, value
    if bracket[4] == side:
        bracket[staying + 1] *= 0.5
    bracket[4] = side
    return bracket[0] + (bracket[2] - bracket[0]) * bracket[1] / (bracket[1] - bracket[3])
