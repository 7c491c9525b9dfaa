"""How the motion of the ground enters the steps of rigid blocks."""

from __future__ import annotations

import numpy as np

from solver.types import Array


def ground_of_steps(
    count: int, dimension: int, ground: Array | None, mean: Array | None
) -> tuple[Array, Array]:
    """Accelerations of the ground at the ends of steps, and by how much both ends of each shift.

    Within a step, and the pieces into which events cut it, the ground's acceleration is linear; the
    shift gives it the right mean, so that no impulse goes missing whatever happens in between.

    Args:
        count: Number of steps.
        dimension: d.
        ground: (count + 1, d) accelerations at the ends of the steps, m/s2; None: it stands.
        mean: (count, d) mean accelerations over the steps, m/s2; None: linear between the ends.
    """
    if ground is None:
        return np.zeros((count + 1, dimension)), np.zeros((count, dimension))
    ground = np.ascontiguousarray(ground, dtype=np.float64)
    if mean is None:
        return ground, np.zeros((count, dimension))
    return ground, np.ascontiguousarray(mean - (ground[1:] + ground[:-1]) / 2)
