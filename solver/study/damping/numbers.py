"""Numbers of the study: restitution of runs, their limits over each parameter, the tables."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from solver.study.damping.axes import Axis, DampingCase, SweptValue
from solver.study.tables import Column, early_ends, groups, in_markdown, in_words

LEAST_ORDER, MOST_ORDER = 0.5, 2.0
"""Orders of convergence that are believed; no more than the second is relied on."""

Rows = Mapping[str, Mapping[str, Any]]
"""Rows of the finished cases by their keys."""

TO = {"zero": "0", "infinity": "infinity"}
"""Where limits are, in words."""

HOW = {
    "reached": "the last two agree",
    "scatter": "no order of convergence: the last value, and the range of the last three",
}
"""Where limits come from, in words."""


@dataclass(frozen=True, slots=True)
class Restitution:
    """Restitution of the first impacts of a block.

    Attributes:
        known: That of each impact of which it is known, in their order.
        wanted: Number of impacts that count.
    """

    known: tuple[float, ...]
    wanted: int

    @classmethod
    def of(cls, block: Mapping[str, Any], wanted: int) -> Restitution:
        """From the part of a summary that describes a block.

        Args:
            block: `summary["blocks"][NAME]`.
            wanted: Number of impacts that count.
        """
        impacts = [impact["restitution"] for impact in block["impacts"][:wanted]]
        return cls(tuple(e for e in impacts if e is not None and e > 0), wanted)

    @property
    def mean(self) -> float | None:
        """Geometric mean; None where there is no impact."""
        return statistics.geometric_mean(self.known) if self.known else None

    @property
    def error(self) -> float:
        """Standard error of the mean; 0 for a single impact."""
        if len(self.known) < 2:
            return 0.0
        return statistics.stdev(self.known) / math.sqrt(len(self.known))

    @property
    def complete(self) -> bool:
        """True if all impacts that count are known."""
        return len(self.known) >= self.wanted

    def too_few(self, end: float) -> str:
        """Missing impacts in words; "" where there are enough.

        Args:
            end: Time at which the run ended, s.
        """
        if self.complete:
            return ""
        count = f"{len(self.known) or 'no'} impact{'s' * (len(self.known) != 1)}"
        return f"{count} with a restitution by {end:g} s, {self.wanted} are wanted"


def restitution_of(row: Mapping[str, Any] | None, impacts: int) -> Restitution | None:
    """Restitution in the row of a case; None where that did not complete."""
    if row is None or row["status"] != "completed":
        return None
    return Restitution.of(row, impacts)


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """Limit of a sequence.

    Attributes:
        value: The limit.
        uncertainty: How far off it may be.
        source: "extrapolated"; "reached": the last values agree within their own uncertainty;
            "scatter": they have no order of convergence, and the last of them stands.
        order: Order of the convergence, NaN where nothing is extrapolated.
    """

    value: float
    uncertainty: float
    source: Literal["extrapolated", "reached", "scatter"]
    order: float = math.nan


def limit(
    distances: Sequence[float], values: Sequence[float], errors: Sequence[float]
) -> Limit | None:
    """Limit for distances that go to zero, from the last three values; None for less than three.

    Values that differ by C x^p are extrapolated, and the whole correction is the uncertainty,
    besides that of the last value. The order p follows from the three values; of more than the
    second no use is made. Where the last two agree within their own uncertainties, nothing is left
    to extrapolate. Where differences fall more slowly than with order 0.5, or change their sign,
    nothing is extrapolated either: the last value stands, and the range of the three is the
    uncertainty.

    Args:
        distances: x, positive; in any order.
        values: What was measured there.
        errors: Uncertainty of each value, such as the standard error of its mean.
    """
    order = sorted(range(len(distances)), key=lambda i: -distances[i])[-3:]
    if len(order) < 3:
        return None
    x = [distances[i] for i in order]
    e = [values[i] for i in order]
    own = errors[order[-1]]
    former, latest = e[1] - e[0], e[2] - e[1]
    noise = math.hypot(own, errors[order[-2]])
    if abs(latest) <= noise:
        return Limit(value=e[2], uncertainty=max(abs(latest), own), source="reached")
    power = _order(x, former / latest)
    if power is None:
        spread = max(e) - min(e)
        return Limit(value=e[2], uncertainty=max(spread, own), source="scatter")
    correction = latest / ((x[1] / x[2]) ** power - 1)
    return Limit(
        value=e[2] + correction,
        uncertainty=abs(correction) + own,
        source="extrapolated",
        order=power,
    )


def _order(x: Sequence[float], fall: float) -> float | None:
    """The order p for which differences of x^p fall by this factor; None where none is believed."""

    def falls(power: float) -> float:
        return float((x[0] ** power - x[1] ** power) / (x[1] ** power - x[2] ** power))

    if fall < falls(LEAST_ORDER):
        return None
    if fall >= falls(MOST_ORDER):
        return MOST_ORDER
    from scipy.optimize import brentq

    return float(brentq(lambda power: falls(power) - fall, LEAST_ORDER, MOST_ORDER, xtol=1e-14))


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """The values of one axis.

    Attributes:
        axis: The axis.
        values: Values of which the restitution is known.
        found: The restitution at each of them.
        limit: The limit of its mean; None where there is none, or too few values.
    """

    axis: Axis
    values: tuple[float, ...]
    found: tuple[Restitution, ...]
    limit: Limit | None

    @property
    def means(self) -> list[float]:
        """Mean restitution at each value."""
        return [found.mean for found in self.found if found.mean is not None]


def lines(swept: Sequence[SweptValue], rows: Rows, impacts: int) -> list[Line]:
    """The lines of a study, in the order of its table.

    Args:
        swept: The values of the command line.
        rows: What is finished.
        impacts: Number of impacts that count.
    """
    return [_line(own, rows, impacts) for own in groups(swept, lambda s: s.axis.name).values()]


def _line(group: Sequence[SweptValue], rows: Rows, impacts: int) -> Line:
    """One line."""
    axis = group[0].axis
    kept = [(s.value, restitution_of(rows.get(s.case.key), impacts)) for s in group]
    known = [(value, found) for value, found in kept if found is not None and found.known]
    values, found = tuple(value for value, _ in known), tuple(found for _, found in known)
    made = Line(axis=axis, values=values, found=found, limit=None)
    # A limit of runs with different numbers of impacts would compare different means.
    if not axis.limit or not all(each.complete for each in found):
        return made
    distances = [axis.distance(value) for value in values]
    return replace(made, limit=limit(distances, made.means, [each.error for each in found]))


def sentence(line: Line) -> str:
    """The result of a line in words."""
    if not line.means:
        return f"{line.axis.name}: no run with a restitution"
    low, high = min(line.means), max(line.means)
    over = f"{min(line.values):g} to {max(line.values):g}"
    if line.limit is None:
        scatter = max(each.error for each in line.found)
        return (
            f"{line.axis.name} {over}: restitution {low:.4f} to {high:.4f}, "
            f"standard error of a mean at most {scatter:.4f}"
        )
    how = HOW.get(line.limit.source, f"extrapolated with order {line.limit.order:.1f}")
    return (
        f"{line.axis.name} to {TO[line.axis.limit]}: restitution {line.limit.value:.4f} "
        f"± {line.limit.uncertainty:.4f} ({how}); {low:.4f} to {high:.4f} over {over}"
    )


def as_json(line: Line) -> dict[str, Any]:
    """A line for programs."""
    return {
        "axis": line.axis.name,
        "meaning": line.axis.meaning,
        "values": list(line.values),
        "restitution": line.means,
        "standard_error": [found.error for found in line.found],
        "limit": asdict(line.limit) if line.limit else None,
    }


def rows_of_table(
    own: DampingCase, swept: Sequence[SweptValue], rows: Rows, impacts: int
) -> Iterator[dict[str, Any]]:
    """Rows of the table: the scene as it is, then axis by axis."""
    yield {"axis": "", "value": None} | _measured(own.key, rows, impacts)
    for axis, value, case in swept:
        yield {"axis": axis.name, "value": value} | _measured(case.key, rows, impacts)


def _measured(case: str, rows: Rows, impacts: int) -> dict[str, Any]:
    """The columns that come from a run."""
    if case not in rows:
        return {"case": case, "status": "not run"}
    row = rows[case]
    found = restitution_of(row, impacts)
    told: dict[str, Any] = {"case": case, "status": row["status"], "reason": row["reason"]}
    told |= {"cut_short": row["cut_short"]} if row.get("cut_short") else {}
    if found is None:
        return told
    told["reason"] = row["reason"] or found.too_few(row["end_s"])
    told |= measures(found)
    for number, impact in enumerate(row["impacts"][:impacts], start=1):
        told[f"restitution_{number}"] = impact["restitution"]
        told[f"impact_{number}_s"] = impact["time_s"]
    told |= {f"loss.{name}": share for name, share in row["loss_share"].items()}
    for key in ("largest_gain_fraction", "ledger_error_fraction", "steps", "wall_s"):
        told[key] = row[key]
    return told


def measures(found: Restitution) -> dict[str, Any]:
    """Columns of a mean restitution; empty ones where there is none."""
    return {
        "restitution": found.mean,
        "standard_error": found.error if found.known else None,
        "least": min(found.known, default=None),
        "largest": max(found.known, default=None),
        "impacts": len(found.known),
    }


def page(title: str, table: Sequence[Mapping[str, Any]], impacts: int, told: Sequence[str]) -> str:
    """The most important columns and remarks as Markdown, after what has to be known first."""
    columns = [
        *(Column("axis", "axis"), Column("value", "value", "g")),
        *(Column("restitution", "restitution", ".4f"), Column("standard_error", "± error", ".4f")),
        *(Column(f"restitution_{k}", f"impact {k}", ".4f") for k in range(1, impacts + 1)),
        *(Column("loss.damping", "damping", ".0%"), Column("unresolved", "unresolved", ".0%")),
        *(Column("steps", "steps"), Column("wall_s", "wall s", ".1f")),
    ]
    rows = [dict(row) | {"axis": row["axis"] or "the scene"} for row in table]
    for row in rows:
        if "loss.contact" in row:
            row["unresolved"] = row["loss.contact"] + row["loss.numerical"]
    return markdown(title, in_words(rows, columns), told, early_ends(table))


def remarks(
    table: Sequence[Mapping[str, Any]], found: Sequence[Line], left_out: Sequence[str]
) -> Iterator[str]:
    """Sentences on the axes, then on what went wrong and what is left out."""
    yield from map(sentence, found)
    for row in table:
        if row.get("reason"):
            name = f"{row['axis']} {row['value']:g}" if row["axis"] else "the scene"
            yield f"{name}: {row['status']}: {row['reason']}"
    yield from (f"left out: {text}" for text in left_out)


def markdown(
    title: str, cells: Sequence[Sequence[str]], lines: Sequence[str], first: Sequence[str] = ()
) -> str:
    """Table and remarks as Markdown, after what has to be known first."""
    listed = [f"- {line}" for line in lines]
    before = [f"# {title}", "", *(text for line in first for text in (line, ""))]
    return "\n".join([*before, *in_markdown(cells), "", *listed]) + "\n"
