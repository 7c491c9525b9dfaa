"""Turkey's national network (AFAD, before it ERD): three columns of accelerations, no times."""

from __future__ import annotations

from collections.abc import Iterator

from solver.excitation.layouts.header import unit_of
from solver.excitation.layouts.text import NUMBER, Component, Stated, TextFile
from solver.scene.motion import FileSpec

TITLE = "AFAD, ERD (Turkey)"

_TITLE = r"STRONG GROUND MOTION RECORDS OF TURK"
_PGA = r"PGA VALUES\s*\((\w+)\)\s*:\s*(.*)"


def recognised(text: TextFile) -> bool:
    """The title in the first line."""
    return text.optional(_TITLE, [1]) is not None


def components(text: TextFile, spec: FileSpec) -> Iterator[Component]:
    """All three, in the unit in which the header gives their largest accelerations.

    These are held against the values, roughly: a unit taken from there has to be the right one.
    """
    heading = text.required(r"^\s*(N-?S)\s+(E-?W)\s+(U-?D|V|Z)\s*$", "a heading N-S E-W U-D")
    among = range(1, heading.line)
    count = text.count(r"NUMBER OF DATA\s*:\s*(\d+)", "NUMBER OF DATA", among)
    step = text.positive(
        rf"SAMPLING INTERVAL\s*\(sec\)\s*:\s*({NUMBER})", "SAMPLING INTERVAL (sec)", among
    )
    largest = text.required(_PGA, "RAW PGA VALUES (gal)", among)
    unit = Stated(unit_of(largest.value[1]), largest.line)
    values, lines = text.block(heading.line, count, columns=3)
    text.nothing_after(lines[-1], count)
    names = heading.value.groups()
    for i, name in enumerate(names):
        stated = text.optional(rf"\({name}\)\s*({NUMBER})", [largest.line])
        text.similar(stated, values[:, i])
        yield Component(name=name, values=values[:, i], lines=lines, units=(unit,), steps=(step,))
