"""Pictures of the study, and one HTML page that needs no other file.

Nothing in it depends on how long the study took, nor on how often it was stopped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from html import escape
from pathlib import Path

from solver.info import versions
from solver.pictures.html import (
    document,
    figure,
    heading,
    items,
    paragraphs,
    table,
    verbatim,
)
from solver.pictures.style import save
from solver.study.inertia.numbers import (
    CODE_VALUES,
    SLIDING,
    WANTED,
    Finding,
    Line,
    widest,
    words,
)
from solver.study.inertia.picture import (
    curves_picture,
    map_picture,
    of_lambda,
    of_shear,
    roots_picture,
)
from solver.study.tables import groups

DEFINITION = (
    "λ is the portion of the live load that, rigidly attached to the linear structure of the same "
    "stiffness k and the same dashpot c, gives the same mean peak drift over the suite of motions. "
    "The live load of mass m<sub>L</sub> slides with friction on the structure of mass "
    "m<sub>P</sub>; the linear structure has the mass m<sub>P</sub> + λ m<sub>L</sub>.",
    "All roots between -0.5 and 1.5 are listed. The one reported is followed from λ = 1, where "
    "friction is infinite and nothing slides, as friction goes down. Negative values say that "
    "friction keeps the drift below that of the empty structure; none is clipped. Intervals are "
    "those of 90 % of resampled suites (bootstrap).",
    "The base shear has a ratio of its own, which is not λ: its mean peak over that with the whole "
    "live load fixed, and over that of the empty structure.",
)

Picture = tuple[str, Path]
"""Caption of a picture, and its file."""


def inertia_page(
    findings: Sequence[Finding],
    pictures: Sequence[Picture],
    failures: Sequence[str],
    *,
    title: str,
    scene: str,
    command: str,
) -> str:
    """The page, which needs no other file.

    Args:
        findings: Of all cells.
        pictures: Of them.
        failures: Runs that failed, and why.
        title: Of the study.
        scene: Its text.
        command: What repeats the study.
    """
    known = versions()  # of what is loaded: with MPI more than without
    of_codes = [f"{value.portion:g}: {value.source}" for value in CODE_VALUES]
    parts = [
        *paragraphs(map(escape, _sentences(findings))),
        heading("What λ is"),
        *paragraphs(DEFINITION),
        heading("Pictures"),
        *(figure(text, file) for text, file in pictures),
        heading("Numbers"),
        table(words(findings)),
        *((heading("Runs that failed"), items(failures)) if failures else ()),
        heading("Values of codes"),
        items(of_codes),
        heading("The scene"),
        verbatim(scene),
        heading("How to repeat"),
        verbatim(command),
        heading("Versions"),
        items(f"{name} {known[name]}" for name in ("rockslip", "python", "numpy")),
    ]
    return document(title, parts)


def _sentences(findings: Sequence[Finding]) -> list[str]:
    """Summary of the findings, in words."""
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
    """Largest distance of the engines from the sliding block, in words; empty without any."""
    closed = {f.cell: f.arithmetic.value for f in findings if f.by == SLIDING}
    pairs = [
        (f.by, abs(f.arithmetic.value - value))
        for f in findings
        if f.by != SLIDING
        and f.arithmetic.value is not None
        and (value := closed[f.cell]) is not None
    ]
    said = [
        f"λ by {by} is within {max(d for name, d in pairs if name == by):.4f} of the sliding block."
        for by in dict.fromkeys(name for name, _ in pairs)
    ]
    return " ".join(said)


def draw_pictures(
    folder: Path, lines: Sequence[Line], findings: Sequence[Finding]
) -> list[Picture]:
    """Draw all pictures; a set for each combination of the axes before the last two."""
    for old in folder.glob("*.png"):
        old.unlink()
    made: list[Picture] = []
    maps = groups(findings, lambda finding: finding.cell.values[:-2])
    for number, (values, group) in enumerate(maps.items(), start=1):
        ending = f"_{number}" if len(maps) > 1 else ""
        at = "".join(f", {name} {value:g}" for name, value in values)
        cut = [_without(finding, len(values)) for finding in group]
        text = f"λ with its interval of 90 %; dashed: values of codes{at}"
        curves = partial(curves_picture, cut, of_lambda, "portion of live load λ")
        made.append((text, save(curves, folder / f"lambda{ending}.png")))
        mapped = [finding for finding in cut if len(finding.cell.values) > 1]
        for by, own in groups(mapped, lambda finding: finding.by).items():
            file = folder / f"map{ending}_{by.replace(' ', '_')}.png"
            text = f"λ and half its interval of 90 %, {by}{at}"
            made.append((text, save(partial(map_picture, own), file)))
        text = f"Mean peak base shear over that with the whole live load fixed; this is not λ{at}"
        curves = partial(curves_picture, cut, of_shear, "base shear / that of the fixed live load")
        made.append((text, save(curves, folder / f"base_shear{ending}.png")))
    text = "Mean drift with a portion fixed; dots: roots reported, rings: further roots"
    made.append((text, save(partial(roots_picture, lines, findings), folder / "roots.png")))
    return made


def _without(finding: Finding, count: int) -> Finding:
    """A finding whose cell names only its last axes."""
    return replace(finding, cell=replace(finding.cell, values=finding.cell.values[count:]))
