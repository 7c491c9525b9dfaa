"""Units of accelerations, and the names that files give them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

G_UNIT = 9.81
"""What "g" means in amplitudes, records and tables, m/s^2, whatever the gravity of the scene is."""

UNITS = {
    "g": G_UNIT,
    "m/s2": 1.0,
    "cm/s2": 0.01,
    "mm/s2": 0.001,
    "mg": 0.001 * G_UNIT,
    "ft/s2": 0.3048,
    "in/s2": 0.0254,
}
"""In m/s^2."""

OTHERS = ("cm/s", "m/s", "mm/s", "in/s", "ft/s", "cm", "m", "mm", "in", "ft", "%g")
"""Units of velocities and displacements, which stand in files that look the same, and of parts."""

_TIMES = ("s", "ms", "min", "h", "hz")
"""Units of times and frequencies, which stand beside those of accelerations."""

_SPELLINGS = (
    # "²", the same in a file of another encoding; "m s^-2", "m·s⁻²".
    (re.compile("[²\ufffd]"), "2"),
    (re.compile("⁻"), "-"),
    (re.compile(r"\^|\*\*"), ""),
    (re.compile(r"[*·]|(?<!\d)\.(?!\d)"), " "),
    (re.compile(r"(?<![a-z])(m?)sec(?:ond)?s?(?![a-z])"), r"\1s"),
    (re.compile(r"\s*/\s*s\s*/\s*s(?![a-z])|\s*/\s*s2(?![\d.])|(?<=[mnt]) ?s ?- ?2(?!\d)"), "/s2"),
)
"""What becomes of the spellings of a unit, one after another, in small letters."""

_COMPOUND = re.compile(r"(?<![a-z/])(?:mm|cm|m|ft|in)/s2(?!\w)")
_NAMED = re.compile(
    r"\bunits?\b\s*(?:of|are|is|in)?\s*[:=]?\s*[(\[]?\s*([a-z%][\w/%]*)"  # "UNITS OF G"
    r"|[(\[]\s*([a-z%][\w/%]*)\s*[)\]]"  # "acceleration [g]"
)
_MILLISECONDS = re.compile(
    r"[(\[]\s*(?:ms|msec|milli-?seconds?)\s*[)\]]|\bt(?:ime)?_ms\b", re.IGNORECASE
)


class NamedUnit(NamedTuple):
    """A unit that a line of a header names.

    Attributes:
        line: Number of the line, from 1.
        unit: Its name in small letters; of accelerations a key of `UNITS`.
        stated: Whether the line says that it is the unit: "units of".
    """

    line: int
    unit: str
    stated: bool


def units_named(header: Sequence[str]) -> Iterator[NamedUnit]:
    """The units in a header, line by line, without those of times beside others."""
    for line, text in enumerate(header, start=1):
        plain = text.lower()
        for pattern, spelling in _SPELLINGS:
            plain = pattern.sub(spelling, plain)
        for found in _COMPOUND.finditer(plain):
            yield NamedUnit(line, found[0], stated=False)
        for found in _NAMED.finditer(plain):
            unit = found[1] or found[2]
            unit = "cm/s2" if unit in ("gal", "gals") else unit
            if unit not in _TIMES:
                yield NamedUnit(line, unit, stated=found[1] is not None)


def names_milliseconds(header: Sequence[str]) -> int:
    """The number of the line in which a header says that times are in ms, from 1; 0: none."""
    for line, text in enumerate(header, start=1):
        if _MILLISECONDS.search(text):
            return line
    return 0
