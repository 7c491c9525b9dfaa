"""What sweeps show: the limit of each axis that has one, the spread over each of the others."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from solver.study.damping.axes import Axis
from solver.study.damping.limit import Limit, limit
from solver.study.damping.restitution import Restitution
from solver.study.damping.sweep import Sweep, SweptValue

Rows = Mapping[str, Mapping[str, Any]]
"""Rows of the finished cases by their keys."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """The values of one axis, at one value of the axis that all is repeated for.

    Attributes:
        axis: The axis.
        at: That value; None: nothing is repeated.
        values: Values of which the restitution is known.
        found: The restitution at each of them.
        limit: The limit of its mean; None where there is none, or too few values.
        limits: The limit of each impact; empty without the one of the mean.
    """

    axis: Axis
    at: float | None
    values: tuple[float, ...]
    found: tuple[Restitution, ...]
    limit: Limit | None
    limits: tuple[Limit | None, ...]

    @property
    def means(self) -> list[float]:
        """Mean restitution at each value."""
        return [found.mean for found in self.found if found.mean is not None]


def lines(sweep: Sweep, rows: Rows, impacts: int) -> list[Line]:
    """The lines of a study, in the order of its table.

    Args:
        sweep: What was asked for.
        rows: What is finished.
        impacts: Number of impacts that count.
    """
    groups: dict[tuple[str, float | None], list[SweptValue]] = {}
    for swept in sweep.values:
        groups.setdefault((swept.axis.name, swept.at), []).append(swept)
    return [_line(group, rows, impacts) for group in groups.values()]


def _line(group: Sequence[SweptValue], rows: Rows, impacts: int) -> Line:
    """One line."""
    axis = group[0].axis
    known = [
        (swept.value, kept)
        for swept in group
        if (kept := restitution_of(rows.get(swept.case), impacts)) and kept.known
    ]
    values = tuple(value for value, _ in known)
    found = tuple(kept for _, kept in known)
    whole: Limit | None = None
    single: tuple[Limit | None, ...] = ()
    # A limit of runs with different numbers of impacts would compare different means.
    if axis.limit and all(each.complete for each in found):
        distances = [axis.distance(value) for value in values]
        means = [each.mean or math.nan for each in found]
        whole = limit(distances, means, [each.error for each in found])
    if whole is not None:
        none = [0.0] * len(found)
        single = tuple(
            limit(distances, [each.known[k] for each in found], none) for k in range(impacts)
        )
    return Line(axis=axis, at=group[0].at, values=values, found=found, limit=whole, limits=single)


def restitution_of(row: Mapping[str, Any] | None, impacts: int) -> Restitution | None:
    """Restitution in the row of a case; None where that did not complete."""
    if row is None or row["status"] != "completed":
        return None
    return Restitution.of(row, impacts)


def sentence(line: Line, at: Axis | None) -> str:
    """What a line shows, in words."""
    where = "" if line.at is None or at is None else f" at {at.name} {line.at:g}"
    head = f"{line.axis.name}{where}"
    if not line.means:
        return f"{head}: no run with a restitution"
    low, high = min(line.means), max(line.means)
    over = f"{min(line.values):g} to {max(line.values):g}"
    if line.limit is None:
        scatter = max(each.error for each in line.found)
        return (
            f"{head} {over}: restitution {low:.4f} to {high:.4f}, "
            f"standard error of a mean at most {scatter:.4f}"
        )
    to = {"zero": "0", "infinity": "infinity"}[line.axis.limit]
    how = {
        "extrapolated": f"extrapolated with order {line.limit.order:.1f}",
        "reached": "the last two agree",
        "scatter": "no order of convergence: the last value, and the range of the last three",
    }[line.limit.source]
    return (
        f"{head} to {to}: restitution {line.limit.value:.4f} ± {line.limit.uncertainty:.4f} "
        f"({how}); {low:.4f} to {high:.4f} over {over}"
    )


def as_json(line: Line) -> dict[str, Any]:
    """A line for programs."""
    return {
        "axis": line.axis.name,
        "meaning": line.axis.meaning,
        "at": line.at,
        "values": list(line.values),
        "restitution": line.means,
        "standard_error": [found.error for found in line.found],
        "limit": _limit_as_json(line.limit),
        "limits_of_impacts": [_limit_as_json(each) for each in line.limits],
    }


def _limit_as_json(found: Limit | None) -> dict[str, Any] | None:
    """A limit for programs."""
    if found is None:
        return None
    return {
        "value": found.value,
        "uncertainty": found.uncertainty,
        "source": found.source,
        "order": found.order,
    }
