"""What the study leaves: tables, pictures, the page. Nothing in it depends on how long it took."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from solver.info import versions
from solver.study.inertia.findings import CLOSED, WANTED, Finding, Line, row_of, widest
from solver.study.inertia.folder import PAGE, SUMMARY, TABLE, TEXT
from solver.study.inertia.page import Picture, page
from solver.study.inertia.picture import (
    curves_picture,
    map_picture,
    of_lambda,
    of_shear,
    roots_picture,
)
from solver.study.inertia.runs import code
from solver.study.inertia.table import csv_text, markdown, words
from solver.study.tables import write


def write_all(
    folder: Path,
    lines: Sequence[Line],
    findings: Sequence[Finding],
    failed: Mapping[str, str],
    notes: Sequence[str],
    *,
    title: str,
    scene: str,
    command: str,
) -> None:
    """Write everything that the study leaves in its folder besides the numbers of its runs.

    Args:
        folder: Of the study.
        lines: The structures.
        findings: Of all cells.
        failed: Names of runs that failed, and why.
        notes: On the motions.
        title: Of the study.
        scene: Its text.
        command: What repeats the study.
    """
    told = [f"{name}: {reason}" for name, reason in sorted(failed.items())]
    write(folder / TABLE, csv_text(findings))
    write(folder / TEXT, markdown(title, findings, told, notes))
    summary = {
        "motions": findings[0].motions,
        "notes": list(notes),
        "widest_half_interval": widest(findings),
        "cells": [_entry(finding) for finding in findings],
        "failed": dict(sorted(failed.items())),
    }
    write(folder / SUMMARY, summary)
    for old in folder.glob("*.png"):
        old.unlink()
    content = page(
        title=title,
        summary=_sentences(findings),
        pictures=_pictures(folder, lines, findings),
        numbers=words(findings),
        failed=told,
        scene=scene,
        command=command,
        versions=_versions(findings),
    )
    write(folder / PAGE, content)


def _entry(finding: Finding) -> dict[str, Any]:
    """A cell for programs."""
    return row_of(finding) | {
        "roots": list(finding.arithmetic.roots),
        "roots_geometric": list(finding.geometric.roots),
        "resampled_without": finding.arithmetic.without,
    }


def _sentences(findings: Sequence[Finding]) -> list[str]:
    """What was computed and found, in words."""
    known = [f.arithmetic.value for f in findings if f.arithmetic.value is not None]
    by = " and ".join(dict.fromkeys(finding.by for finding in findings))
    cells = len({(finding.cell.values, finding.cell.aspect) for finding in findings})
    said = [f"{cells} cells, {findings[0].motions} motions, by {by}."]
    if known:
        said[0] += f" λ is {min(known):.3f} to {max(known):.3f} in the {len(known)} rows with one."
        wide = sum(
            f.arithmetic.half_width > WANTED for f in findings if f.arithmetic.value is not None
        )
        said.append(
            f"The widest interval of 90 % is ±{widest(findings):.3f}; {wide} rows have one wider "
            f"than ±{WANTED:g}."
        )
    several = sum(len(finding.arithmetic.roots) > 1 for finding in findings)
    negative = sum(value < 0 for value in known)
    said.append(
        f"{several} rows have several roots, {negative} a negative λ, "
        f"{len(findings) - len(known)} none."
    )
    other = _difference(findings)
    return [*said, other] if other else said


def _difference(findings: Sequence[Finding]) -> str:
    """How far the engines are from the closed form, in words; empty without any."""
    closed = {f.cell: f.arithmetic.value for f in findings if f.by == CLOSED}
    pairs = [
        (f.by, abs(f.arithmetic.value - value))
        for f in findings
        if f.by != CLOSED
        and f.arithmetic.value is not None
        and (value := closed[f.cell]) is not None
    ]
    said = [
        f"λ by {by} is within {max(d for name, d in pairs if name == by):.4f} of the closed form."
        for by in dict.fromkeys(name for name, _ in pairs)
    ]
    return " ".join(said)


def _pictures(folder: Path, lines: Sequence[Line], findings: Sequence[Finding]) -> list[Picture]:
    """Draw all pictures; a set for each combination of the axes before the last two."""
    made: list[Picture] = []
    groups: dict[tuple[tuple[str, float], ...], list[Finding]] = {}
    for finding in findings:
        groups.setdefault(finding.cell.values[:-2], []).append(finding)
    for number, (values, group) in enumerate(groups.items(), start=1):
        ending = f"_{number}" if len(groups) > 1 else ""
        at = "".join(f", {name} {value:g}" for name, value in values)
        cut = [_without(finding, len(values)) for finding in group]
        text = f"λ with its interval of 90 %; dashed: values of codes{at}"
        label, file = "portion of live load λ", folder / f"lambda{ending}.png"
        made.append((text, curves_picture(cut, of_lambda, label, file)))
        for by in dict.fromkeys(f.by for f in cut if len(f.cell.values) > 1):
            own = [finding for finding in cut if finding.by == by]
            file = folder / f"map{ending}_{by.replace(' ', '_')}.png"
            made.append((f"λ and half its interval of 90 %, {by}{at}", map_picture(own, file)))
        label = "base shear / that of the fixed live load"
        text = f"Mean peak base shear over that with the whole live load fixed; this is not λ{at}"
        file = folder / f"base_shear{ending}.png"
        made.append((text, curves_picture(cut, of_shear, label, file)))
    text = "Mean drift with a portion fixed; dots: roots reported, rings: further roots"
    made.append((text, roots_picture(lines, findings, folder / "roots.png")))
    return made


def _without(finding: Finding, count: int) -> Finding:
    """A finding whose cell names only its last axes."""
    from dataclasses import replace

    return replace(finding, cell=replace(finding.cell, values=finding.cell.values[count:]))


def _versions(findings: Sequence[Finding]) -> dict[str, str]:
    """Versions of what the numbers and pictures depend on, the same on any number of ranks."""
    blocks = any(finding.by != CLOSED for finding in findings)
    found = {"sources of the closed form": code(True)}
    if blocks:
        found["sources of the engines"] = code(False)
    known = versions()  # of what is loaded: with MPI more than without
    return {name: known[name] for name in ("rockslip", "python", "numpy")} | found
