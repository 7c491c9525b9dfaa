"""Rows of engines, and the columns that all engines fill alike.

An engine hands over a table of values by the names of columns: one value for each, or one array
over several steps. Columns that a scene does not have are left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from solver.history.columns import DISSIPATED_ENERGIES, STORED_ENERGIES
from solver.types import Array

ENERGIES = (*STORED_ENERGIES, "input", *DISSIPATED_ENERGIES, "total", "ledger_error")
"""Names of all energies, in the order in which `energy_columns` has them."""


def rows_of(names: Sequence[str], known: Mapping[str, Any], count: int = 1) -> Array:
    """The rows of so many steps with columns of these names, (count, columns).

    Raises:
        KeyError: The engine has no value for a column; names it.
    """
    rows: Array = np.empty((count, len(names)))
    for place, name in enumerate(names):
        rows[:, place] = known[name]
    return rows


def along(
    pattern: str, vector: Iterable[Any], ways: Sequence[str] = ("", "_second")
) -> dict[str, Any]:
    """The columns of the parts of a vector: along x and, in space, y, or others that are named.

    By the pattern of their names, in which {} stands for the direction.
    """
    return {pattern.format(way): part for way, part in zip(ways, vector, strict=False)}


def of_owner(owner: str, known: Mapping[str, Any]) -> dict[str, Any]:
    """The columns of a block, a storey and so on, by its name."""
    return {f"{owner}.{name}": value for name, value in known.items()}


def run_columns(
    time: Any, step: float, iterations: Any, closed: Any, base: Array
) -> dict[str, Any]:
    """The columns of the run, by the end, length and iterations of a step and its closed points.

    The acceleration of the ground is (d,), m/s2.
    """
    return {
        "time_s": time,
        "step_s": step,
        "newton_iterations": iterations,
        "contact_points_closed": closed,
        "base.acceleration_m_s2": base[0],
        "base.second_acceleration_m_s2": base[1],
        "base.vertical_acceleration_m_s2": base[-1],
    }


def platform_columns(drift: Any, velocity: Any, gained: Any, shear: Any) -> dict[str, Any]:
    """The columns of what carries the blocks and moves as a whole, and of its base shear.

    Drift (m), velocity (m/s), mean acceleration of the step (m/s2), and force on the ground (N)
    along the horizontal directions, (d - 1,).
    """
    return {
        **along("platform.drift{}_m", drift),
        **along("platform.velocity{}_m_s", velocity),
        **along("platform.acceleration{}_m_s2", gained),
        **along("foundation.base_shear{}_N", shear),
    }


def energy_columns(stored: Sequence[Any], exchanged: Sequence[Any], start: Any) -> dict[str, Any]:
    """The columns of all energies, J.

    Args:
        stored: In the order of `STORED_ENERGIES`.
        exchanged: What was taken in, and lost by `DISSIPATED_ENERGIES`, since the start.
        start: What was stored then.
    """
    total, (taken, *lost) = sum(stored), exchanged
    error = total - taken + sum(lost) - start
    values = (*stored, taken, *lost, total, error)
    return {f"energy.{name}_J": value for name, value in zip(ENERGIES, values, strict=True)}
