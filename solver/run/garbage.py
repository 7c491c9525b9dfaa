"""Python's collector of cyclic garbage."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

RARER = 100


@contextmanager
def rarely_collected() -> Iterator[None]:
    """Let the collector run a hundred times more rarely inside a `with` block.

    Steps leave no cycles behind, and looking for some among all that dolfinx, UFL and numba have
    loaded costs a twentieth of the time of a small problem.
    """
    before = gc.get_threshold()
    gc.set_threshold(RARER * before[0], *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)
