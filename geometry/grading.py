"""Grading of a structured mesh: growth of its cells along an edge."""

from __future__ import annotations

import numpy as np

from solver.types import Array


def graded(count: int, ratio: float) -> Array:
    """Points 0 ... 1 of `count` cells growing geometrically, the last `ratio` times the first."""
    sizes = ratio ** (np.arange(count) / max(count - 1, 1))
    return _points(sizes)


def graded_to_both_ends(count: int, ratio: float) -> Array:
    """Points 0 ... 1 of `count` cells, in the middle `ratio` times as long as at both ends."""
    to_end = np.minimum(np.arange(count), np.arange(count)[::-1])
    sizes = ratio ** (to_end / max((count - 1) // 2, 1))
    return _points(sizes)


def _points(sizes: Array) -> Array:
    """Points 0 ... 1 between cells of these relative sizes."""
    points = np.concatenate([[0.0], np.cumsum(sizes)])
    fractions: Array = points / points[-1]
    return fractions


def centred(length: float, fractions: Array) -> Array:
    """Points from -length/2 to length/2 at fractions 0 ... 1, symmetric to the last digit."""
    symmetric: Array = length / 2 * (fractions - fractions[::-1])
    return symmetric
