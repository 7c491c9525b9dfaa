"""Units of accelerations, and the names that files give them."""

from __future__ import annotations

import re

G_UNIT = 9.81
"""What "g" means in amplitudes, records and tables, m/s^2, whatever the gravity of the scene is."""

UNITS = {"g": G_UNIT, "m/s2": 1.0, "cm/s2": 0.01}
"""In m/s^2."""

MOVED = ("cm/s", "m/s", "mm/s", "in/s", "cm", "m", "mm", "in")
"""Units of velocities and displacements, which stand in files that look the same."""

# "UNITS OF G", "The units are (g)", "units: cm/s^2"; a unit in brackets, "acceleration [m/s/s]".
_AFTER = re.compile(r"\bunits?\b\s*(?:of|are|is|in)?\s*[:=]?\s*[(\[]?\s*([a-z][\w/^*]*)", re.I)
_BRACKETS = re.compile(r"[(\[]\s*([a-z][\w/^*]*)\s*[)\]]", re.I)


def units_named(header: list[str]) -> tuple[int, str | None]:
    """The number of the line in which a header names a unit, from 1, and the unit; 0 and None.

    A unit of acceleration, in any spelling, is a key of `UNITS`.
    """
    for line, text in enumerate(header, start=1):
        found = _AFTER.search(text)
        if found:
            return line, _spelt(found[1])
    for line, text in enumerate(header, start=1):
        for word in _BRACKETS.findall(text):
            if _spelt(word) in UNITS:
                return line, _spelt(word)
    return 0, None


def _spelt(word: str) -> str:
    """One spelling of a unit: `cm/sec/sec`, `CM/S**2`, `gal` and `cm/s^2` are `cm/s2`."""
    plain = word.lower().replace("sec", "s").replace("/s/s", "/s2")
    plain = plain.replace("^", "").replace("**", "")
    return {"gal": "cm/s2", "gals": "cm/s2"}.get(plain, plain)
