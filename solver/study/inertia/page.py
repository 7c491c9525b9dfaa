"""One HTML page that holds the whole study: it needs no other file and no network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from solver.pictures.html import (
    document,
    figure,
    heading,
    items,
    paragraphs,
    table,
    verbatim,
)
from solver.study.inertia.codes import CODE_VALUES

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
"""What a picture shows, and its file."""


def page(
    *,
    title: str,
    summary: Sequence[str],
    pictures: Sequence[Picture],
    numbers: Sequence[Sequence[str]],
    failed: Sequence[str],
    scene: str,
    command: str,
    versions: Mapping[str, str],
) -> str:
    """The page.

    Args:
        title: Of the study.
        summary: Sentences on what was computed and found.
        pictures: In their order.
        numbers: A table of words; the first row is the heading.
        failed: What failed, in words.
        scene: Text of the scene.
        command: What repeats the study.
        versions: Of the program and what it uses, by name.
    """
    parts = [
        *paragraphs(map(escape, summary)),
        heading("What λ is"),
        *paragraphs(DEFINITION),
        heading("Pictures"),
        *(figure(text, file) for text, file in pictures),
        heading("Numbers"),
        table(numbers),
    ]
    if failed:
        parts += [heading("Runs that failed"), items(failed)]
    values = [f"{value.portion:g}: {value.source}" for value in CODE_VALUES]
    parts += [heading("Values of codes"), items(values)]
    parts += [heading("The scene"), verbatim(scene)]
    parts += [heading("How to repeat"), verbatim(command)]
    parts += [heading("Versions"), items(f"{name} {value}" for name, value in versions.items())]
    return document(title, parts)
