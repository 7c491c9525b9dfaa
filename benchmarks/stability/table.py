"""Verdicts of the stability study as tables."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, fields

from benchmarks.stability.verdict import Verdict
from solver.study import tables
from solver.study.tables import groups, in_columns

#: Marks of the verdicts in the text: what held is shown by its energy gain instead.
MARKS = {"ended": "ended", "refused": "refused", "failed": "FAILED"}


def as_csv(verdicts: Sequence[Verdict]) -> str:
    """All numbers; values that are not known are empty."""
    names = [field.name for field in fields(Verdict)]
    return tables.as_csv([asdict(verdict) for verdict in verdicts], names, digits=4)


def as_text(verdicts: Sequence[Verdict]) -> str:
    """A grid of energy gains for each family, then why scenes ended, were refused or failed."""
    lines: list[str] = []
    for family, inside in groups(verdicts, lambda verdict: verdict.family).items():
        if len({verdict.column for verdict in inside}) > 1:
            lines += [f"{family}: largest energy gain", *_grid(inside), ""]
        else:
            lines += [f"{family}: {_counted(inside)}", ""]
    for word in MARKS:
        lines += [
            f"{word}: {verdict.name}: {verdict.reason}"
            for verdict in verdicts
            if verdict.verdict == word
        ]
    return "\n".join([*lines, sentence(verdicts)]) + "\n"


def _grid(verdicts: Sequence[Verdict]) -> list[str]:
    """The lines of one family's grid."""
    rows = list(dict.fromkeys(verdict.row for verdict in verdicts))
    columns = list(dict.fromkeys(verdict.column for verdict in verdicts))
    cells = {(verdict.row, verdict.column): _cell(verdict) for verdict in verdicts}
    table = [["", *columns]]
    table += [[row, *(cells.get((row, column), "-") for column in columns)] for row in rows]
    return in_columns(table)


def _cell(verdict: Verdict) -> str:
    """Entry of the grid."""
    return MARKS.get(verdict.verdict, f"{max(0.0, verdict.energy_gain):.0e}")


def _counted(verdicts: Sequence[Verdict]) -> str:
    """Counts of each verdict, in words."""
    counts: Counter[str] = Counter(verdict.verdict for verdict in verdicts)
    return ", ".join(f"{counts[word]} {word}" for word in ("holds", *MARKS))


def _largest(values: Sequence[float]) -> float:
    """The largest that is a number: where nothing moves there is no scale to divide by."""
    return max((value for value in values if not math.isnan(value)), default=math.nan)


def sentence(verdicts: Sequence[Verdict]) -> str:
    """The study in one line."""
    held = [verdict for verdict in verdicts if verdict.verdict == "holds"]
    gain = _largest([verdict.energy_gain for verdict in held])
    error = _largest([verdict.ledger_error for verdict in held])
    return (
        f"{len(verdicts)} scenes: {_counted(verdicts)}; where it holds the largest energy gain is "
        f"{max(0.0, gain):.1e}, the largest ledger error {error:.1e}"
    )
