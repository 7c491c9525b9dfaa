"""The tables of the study: all numbers as CSV, the most important ones in words."""

from __future__ import annotations

from collections.abc import Sequence

from solver.study.inertia.findings import Finding, row_of
from solver.study.inertia.portion import Portion
from solver.study.tables import as_csv, column_names, in_markdown

HEADING = (
    *("by", "λ", "90 %", "λ geometric", "90 %", "drift mm", "drift / fixed"),
    *("base shear / fixed", "base shear / empty", "all roots, remark"),
)
"""Words above the columns that follow those of the axes."""


def csv_text(findings: Sequence[Finding]) -> str:
    """All numbers, with ten digits."""
    rows = [row_of(finding) for finding in findings]
    return as_csv(rows, column_names(rows), digits=10)


def words(findings: Sequence[Finding]) -> list[list[str]]:
    """The most important numbers as words, row by row; the first row is the heading."""
    axes = [name for name, _ in findings[0].cell.values]
    return [[*axes, *HEADING], *(_row(finding) for finding in findings)]


def _row(finding: Finding) -> list[str]:
    arithmetic, geometric = finding.arithmetic, finding.geometric
    roots = ", ".join(f"{root:.3f}" for root in arithmetic.roots)
    several = roots if len(arithmetic.roots) > 1 else ""
    return [
        *(f"{value:g}" for _, value in finding.cell.values),
        finding.by,
        number(arithmetic.value),
        interval(arithmetic),
        number(geometric.value),
        interval(geometric),
        f"{1e3 * finding.drift:.2f}",
        f"{finding.drift_over_fixed:.3f}",
        f"{finding.shear_over_fixed:.3f}",
        f"{finding.shear_over_bare:.3f}",
        "; ".join(part for part in (several, finding.remark) if part),
    ]


def number(value: float | None) -> str:
    """A lambda as a word."""
    return "none" if value is None else f"{value:.3f}"


def interval(portion: Portion) -> str:
    """The ends of an interval as words."""
    if portion.value is None or portion.low is None or portion.high is None:
        return "-"
    return f"{number(portion.low)} to {number(portion.high)}"


def markdown(
    title: str, findings: Sequence[Finding], failed: Sequence[str], notes: Sequence[str]
) -> str:
    """The table in Markdown, with what failed and what is noted of the motions."""
    count = f"Motions: {findings[0].motions}. λ is by the mean of peaks unless it says geometric."
    lines = [f"# {title}", "", count, "", *in_markdown(words(findings))]
    lines += ["", *(f"- failed: {name}" for name in failed)] if failed else []
    lines += ["", *(f"- {note}" for note in notes)]
    return "\n".join(lines) + "\n"
