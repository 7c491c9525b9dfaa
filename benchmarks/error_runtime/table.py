"""The findings of a study of error against run time as CSV, as JSON and as text."""

from __future__ import annotations

import math
from typing import Any

from benchmarks.error_runtime.findings import Findings
from benchmarks.error_runtime.ladders import Trial
from solver.study import tables
from solver.study.tables import column_names, in_columns

#: What columns of measures are called in the text.
LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"

#: Below this part of a processor a run did not have the machine to itself.
UNDISTURBED_SHARE = 0.9


def rows(findings: Findings) -> list[dict[str, Any]]:
    """One row for each run; numbers are plain, errors relative."""
    return [_row(findings, trial) for trial in findings.trials]


def _row(findings: Findings, trial: Trial) -> dict[str, Any]:
    outcome = trial.outcome
    row: dict[str, Any] = {
        "family": trial.family.name,
        "setting": trial.rung.setting,
        "size": trial.rung.size,
        "status": outcome.status,
        "loop_s": trial.loop_s,
        "loop_least_s": min(trial.seconds),
        "loop_most_s": max(trial.seconds),
        "setup_s": outcome.setup_s,
        **outcome.counts,
    }
    for measure in findings.names:
        value = outcome.measures.get(measure)
        if findings.references[measure].value.size == 1:
            row[measure] = float(value[0]) if value is not None else math.nan
        row[f"error.{measure}"] = findings.error(trial, measure)
    return row


def as_csv(findings: Findings) -> str:
    """The rows as CSV; what is not known is left empty."""
    table = rows(findings)
    return tables.as_csv(table, column_names(table), digits=8)


def everything(findings: Findings) -> dict[str, Any]:
    """Runs, references, slopes and sentences, for programs."""
    references = {
        measure: {
            "name": name,
            "source": findings.references[measure].source,
            "value": _one(findings.references[measure].value),
            "uncertainty": findings.references[measure].uncertainty,
            "own_limit_differs_by": findings.references[measure].own,
        }
        for measure, name in findings.names.items()
    }
    slopes = {
        measure: {
            family.name: {"order": slope.order, "against_time": slope.time}
            for family in findings.families
            for slope in [findings.slope(family, measure)]
        }
        for measure in findings.names
    }
    return {
        "schema": 1,
        "title": findings.title,
        "machine": findings.machine,
        "repeat": findings.repeat,
        "target": findings.target,
        "references": references,
        "slopes": slopes,
        "sentences": {measure: findings.sentence(measure) for measure in findings.names},
        "left_out": list(findings.left_out),
        "runs": rows(findings),
    }


def _one(value: Any) -> float | None:
    """A single value; samples are too many to write."""
    return float(value[0]) if value.size == 1 else None


def text(findings: Findings) -> str:
    """Findings as text."""
    measures = list(findings.names)
    parts = [f"{findings.title}\n{findings.machine}\n"]
    parts.append("Errors are relative; seconds are those of the time loop without set-up, ")
    times = f"the median of {findings.repeat} runs" if findings.repeat > 1 else "of one run"
    parts.append(f"{times}.\n{_busy(findings)}\n")
    for letter, measure in zip(LETTERS, measures, strict=False):
        parts.append(f"{letter}  {_about(findings, measure)}\n")
    parts.append(f"\n{_table(findings, measures)}\n{_slopes(findings, measures)}")
    if findings.left_out:
        parts.append(f"\nleft out: {'; '.join(findings.left_out)}\n")
    parts.append("\n" + "".join(f"{findings.sentence(measure)}\n" for measure in measures))
    return "".join(parts)


def _busy(findings: Findings) -> str:
    """A warning where something else ran beside the study."""
    shares = [trial.outcome.counts.get("processor_share", 1.0) for trial in findings.trials]
    if min(shares, default=1.0) > UNDISTURBED_SHARE:
        return ""
    least, most = (f"{100 * share:.0f}" for share in (min(shares), max(shares)))
    return f"The machine was busy: runs had {least} to {most} % of a processor; times are long.\n"


def _about(findings: Findings, measure: str) -> str:
    """A measure and its reference."""
    reference = findings.references[measure]
    value = f" {reference.value[0]:.7g}" if reference.value.size == 1 else ""
    line = f"{findings.names[measure]} ({measure}):{value}, {reference.source}"
    line += f", uncertain by {reference.uncertainty:.1e}"
    if not math.isnan(reference.own):
        line += f"; what its own ladders go to differs by {reference.own:.1e}"
    return line


def _table(findings: Findings, measures: list[str]) -> str:
    """The runs, with a column for each measure."""
    head = ["family", "setting", "loop s", "least", "most", "set-up s"]
    lines = [[*head, *LETTERS[: len(measures)]]]
    for trial in findings.trials:
        outcome = trial.outcome
        times = (trial.loop_s, min(trial.seconds), max(trial.seconds), outcome.setup_s)
        found = [_number(findings.error(trial, measure), ".1e") for measure in measures]
        if not outcome.completed:
            found = [outcome.status, *[""] * (len(measures) - 1)]
        seconds = [_number(time, ".3g") for time in times]
        lines.append([trial.family.name, trial.rung.setting, *seconds, *found])
    return _columns(lines)


def _slopes(findings: Findings, measures: list[str]) -> str:
    """The orders of all families, and their slopes against time in brackets."""
    lines = [["order (against time)", "", *LETTERS[: len(measures)]]]
    for family in findings.families:
        found = [findings.slope(family, measure) for measure in measures]
        cells = [
            "-" if math.isnan(slope.order) else f"{slope.order:.2f} ({slope.time:.2f})"
            for slope in found
        ]
        lines.append([family.name, f"in the {family.size}", *cells])
    return _columns(lines)


def _number(value: float, form: str) -> str:
    return "-" if math.isnan(value) else f"{value:{form}}"


def _columns(table: list[list[str]]) -> str:
    """The lines of a table, with words in its first two columns."""
    return "\n".join(in_columns(table, left=2)) + "\n"
