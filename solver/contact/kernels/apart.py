"""How far points are from a body; compiled."""

from __future__ import annotations

import math

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array


@compiled
def least_distance(points: Array, nodes: Array) -> float:
    """Distance of the nearest of points (m, d) from the level box around nodes (n, d), m."""
    low, high = np.empty(points.shape[1]), np.empty(points.shape[1])
    for i in range(points.shape[1]):
        low[i], high[i] = np.min(nodes[:, i]), np.max(nodes[:, i])
    least = np.inf
    for p in range(len(points)):
        squares = 0.0
        for i in range(points.shape[1]):
            squares += max(low[i] - points[p, i], points[p, i] - high[i], 0.0) ** 2
        least = min(least, squares)
    return math.sqrt(least)
