"""Numbers of the study: restitution of runs, their limits over each parameter, the tables."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from solver.study.damping.axes import Axis, Sweep, SweptValue
from solver.study.tables import groups, in_columns, in_markdown

LEAST_ORDER, MOST_ORDER = 0.5, 2.0
"""Orders of convergence that are believed; no more than the second is relied on."""

Rows = Mapping[str, Mapping[str, Any]]
"""Rows of the finished cases by their keys."""


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
        sweep: The sweep of the command line.
        rows: What is finished.
        impacts: Number of impacts that count.
    """
    several = groups(sweep.values, lambda swept: (swept.axis.name, swept.at))
    return [_line(group, rows, impacts) for group in several.values()]


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


def sentence(line: Line, at: Axis | None) -> str:
    """The result of a line in words."""
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
        "limit": asdict(line.limit) if line.limit else None,
        "limits_of_impacts": [asdict(each) if each else None for each in line.limits],
    }


def rows_of_table(sweep: Sweep, rows: Rows, impacts: int) -> Iterator[dict[str, Any]]:
    """Rows of the table: the scene as it is, then axis by axis."""
    own = {"axis": "", "value": None, **({sweep.at.name: None} if sweep.at else {})}
    yield own | _measured(sweep.base, rows, impacts)
    for swept in sweep.values:
        named = {"axis": swept.axis.name, "value": swept.value}
        if sweep.at is not None:
            named[sweep.at.name] = swept.at
        yield named | _measured(swept.case, rows, impacts)


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


def words(table: Sequence[Mapping[str, Any]], sweep: Sweep, impacts: int) -> list[list[str]]:
    """The most important columns as words, the heading first."""
    at = [] if sweep.at is None else [(sweep.at.name, sweep.at.name, "g")]
    each = [(f"restitution_{k}", f"impact {k}", ".4f") for k in range(1, impacts + 1)]
    columns = [
        *(("axis", "axis", ""), ("value", "value", "g"), *at),
        *(("restitution", "restitution", ".4f"), ("standard_error", "± error", ".4f"), *each),
        *(("loss.damping", "damping", ".0%"), ("unresolved", "unresolved", ".0%")),
        *(("steps", "steps", "d"), ("wall_s", "wall s", ".1f")),
    ]
    found = [[heading for _, heading, _ in columns]]
    for row in table:
        unresolved = _sum(row, "loss.contact", "loss.numerical")
        told = {**row, "axis": row["axis"] or "the scene", "unresolved": unresolved}
        found.append([_number(told.get(key), form) for key, _, form in columns])
    return found


def _sum(row: Mapping[str, Any], *keys: str) -> float | None:
    """Sum of values, None where they are not known."""
    return sum(row[key] for key in keys) if all(key in row for key in keys) else None


def _number(value: Any, form: str) -> str:
    """A value as text."""
    return "-" if value is None else format(value, form)


def remarks(
    table: Sequence[Mapping[str, Any]], sweep: Sweep, found: Sequence[Line]
) -> Iterator[str]:
    """Sentences on the axes, then on what went wrong."""
    for line in found:
        yield sentence(line, sweep.at)
    for row in table:
        if row.get("reason"):
            at = "" if sweep.at is None else f", {sweep.at.name} {_number(row[sweep.at.name], 'g')}"
            name = f"{row['axis']} {row['value']:g}{at}" if row["axis"] else "the scene"
            yield f"{name}: {row['status']}: {row['reason']}"
    for text in sweep.left_out:
        yield f"left out: {text}"


def plain_text(
    cells: Sequence[Sequence[str]], lines: Sequence[str], first: Sequence[str] = ()
) -> str:
    """Table and remarks for a terminal, after what has to be known first."""
    return "\n".join([*first, *in_columns(cells), "", *lines]) + "\n"


def markdown(
    title: str, cells: Sequence[Sequence[str]], lines: Sequence[str], first: Sequence[str] = ()
) -> str:
    """Table and remarks as Markdown, after what has to be known first."""
    listed = [f"- {line}" for line in lines]
    before = [f"# {title}", "", *(text for line in first for text in (line, ""))]
    return "\n".join([*before, *in_markdown(cells), "", *listed]) + "\n"
