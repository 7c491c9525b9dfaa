"""Statements of a header of plain text: units, times between samples, numbers of samples.

Only a statement counts: "units of g", "acceleration (cm/s2)", "acceleration in gal". A quantity is
none: "1 g = 981 cm/s2", "PGA 294 cm/s/s", "Trigger level (gal): 4", the full scale of a sensor.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from solver.excitation.layouts.text import NUMBER, Stated
from solver.scene.motion import UNITS

OTHERS = (
    "cm/s",
    "m/s",
    "mm/s",
    "in/s",
    "ft/s",
    "cm",
    "m",
    "mm",
    "in",
    "ft",
    "%g",
    "counts",
    "volts",
)
"""Units of velocities, displacements, parts and readings, in files that look the same."""

_TIMES = ("s", "ms", "min", "h", "hz", "sec")

_SPELLINGS = (
    # "²", the same in a file of another encoding; "m s^-2", "m·s⁻²".
    (re.compile("[²\ufffd]"), "2"),
    (re.compile("⁻"), "-"),
    (re.compile(r"\^|\*\*"), ""),
    (re.compile(r"milli-?\s?g(?:'?s)?\b"), "mg"),
    (re.compile(r"[*·]|(?<!\d)\.(?!\d)"), " "),
    (re.compile(r"(?<![a-z])(m?)sec(?:ond)?s?(?![a-z])"), r"\1s"),
    (re.compile(r"\s*/\s*s\s*/\s*s(?![a-z])|\s*/\s*s2(?![\d.])|(?<=[mnt]) ?s ?- ?2(?!\d)"), "/s2"),
)
"""Spellings of a unit and their replacements, one after another, in small letters."""

_ALIASES = {"gal": "cm/s2", "gals": "cm/s2", "g's": "g", "cm_s2": "cm/s2", "m_s2": "m/s2"}

_UNIT = r"%?[a-z][\w/%']*"
_QUANTITY = re.compile(
    r"\b(?:peak|max(?:imum)?|min(?:imum)?|pg[avd]|largest|trigger|threshold|level|scale|range|sensitiv\w*|"
    r"rms|resolution|noise|full)\b"
)
"""Words of a statement about a quantity, not about the samples."""

_SAMPLES = (
    r"(?<![a-z])(?:acc(?:el\w*|l?n)?|acel\w*|besch\w*|data|values?|samples?|readings|amplitudes?)"
    r"(?![a-z])"
)
_COLUMN = r"(?<![\w-])(?:a_?[xyzg]?|[xyzneu]|n-?s|e-?w|u-?d|h[nl][nez12])"
_BRACKETS = rf"[(\[]\s*(?:in\s+)?(?P<unit>{_UNIT})\s*[)\]](?!\s*[:=]?\s*[-+.]?\d)"
_OF = r"acc\w*|amplitudes?|data|measure\w*|samples?|the|values?"
_STATED = (
    # "unit of acceleration: gal"; "UNITS OF G", "AmplitudeUnit: gal", "UNITS ARE SEC AND G/10"
    re.compile(rf"units?\s+of\s+(?:(?:{_OF})\s*)+[:=]\s*[(\[]?\s*(?P<unit>{_UNIT})"),
    re.compile(
        r"units?\b\s*(?:(?:of|are|is|in)\b)?(?:\s+[\w ]*?\bare\b)?\s*[:=]?\s*[(\[]?\s*"
        rf"(?:s\s+and\s+)?(?!(?:{_OF}|of|are|is|in)\b)(?P<unit>{_UNIT})"
    ),
    # "ACCELERATION TIME HISTORY (G'S)", the headings "acc [g]" and "N-S (gal)"
    re.compile(rf"{_SAMPLES}[^()\[\]]*{_BRACKETS}"),
    re.compile(rf"{_COLUMN}\s*{_BRACKETS}"),
    # "acceleration time series in cm/s2"
    re.compile(
        rf"(?:{_SAMPLES}|\b(?:vel|disp)\w*)[^:=()]*?\bin\s+(?P<unit>{_UNIT})(?!\s*[:=]\s*[-+.]?\d)"
    ),
    # the heading acc_g
    re.compile(r"(?<![a-z])a(?:cc\w*?)?_(?P<unit>g|gal|mg|cm[_/]s2|m[_/]s2)(?![a-z])"),
)
_MENTIONED = re.compile(r"(?<![a-z/])(?:gals?|mg|g/10|%g|counts?|(?:mm|cm|m|ft|in)/s2?)(?!\w)")
_BARE = re.compile(
    r"(?<![\w/.])(?<!\d )(?P<unit>gals?|mg|g/10|(?:mm|cm|m|ft|in)/s2)"
    r"(?!\w)(?!\s*[)\]]?\s*[:=]?\s*\d)"
)
_CLAUSE = re.compile(r"[,;\t|]|(?<![:=\s])\s{2,}(?![-+.\d\s])")

_MILLISECONDS = re.compile(
    r"[(\[]\s*(?:ms|msec|milli-?seconds?)\s*[)\]](?!\s*[:=]?\s*\d)|\bt(?:ime)?_ms\b", re.IGNORECASE
)

_SECONDS = r"(?P<unit>m?s(?:ec(?:onds?)?)?|milli-?seconds?)\b"
_STEPS = (
    rf"\bdt\b\s*(?:[(\[]\s*{_SECONDS}\s*[)\]])?\s*[:=]?\s*(?P<number>{NUMBER})",
    rf"\bdt\b\s*[:=]?\s*(?P<number>{NUMBER})\s*{_SECONDS}",
    r"\b(?:sampl\w*|time)[ _-]*(?:interval|step|spacing|period|increment)s?\s*"
    rf"[(\[]?\s*{_SECONDS}\s*[)\]]?\s*[:=]?\s*(?P<number>{NUMBER})",
    r"\b(?:sampl\w*|time)[ _-]*(?:interval|step|spacing|period|increment)s?\s*(?:of|is)?\s*[:=]?\s*"
    rf"(?P<number>{NUMBER})\s*(?:{_SECONDS})?",
    rf"\b(?:spac\w+|intervals?)\s+(?:of|at)\s*(?P<number>{NUMBER})\s*{_SECONDS}",
)
_RATES = (
    r"\bsampl\w*[ _-]*(?:rate|freq\w*)\s*[(\[]\s*(?:hz|sps)\s*[)\]]\s*[:=]?\s*"
    rf"(?P<number>{NUMBER})",
    rf"\bsampl\w*[ _-]*(?:rate|freq\w*)\s*[:=]?\s*(?P<number>{NUMBER})\s*(?:hz|sps)\b",
    rf"(?P<number>{NUMBER})\s*(?:samples|points|pts|values)\s*(?:/|per)\s*s",
)
_COUNTS = (
    r"\b(?:npts|ndata)\b\s*[:=]?\s*(\d+)(?![.\d])",
    r"\b(?:number|no\.?|num\.?)\s*of\s*(?:data|points|samples|values)(?:\s*points)?\s*[:=]?\s*(\d+)"
    r"(?![.\d])",
    r"(?<![.\d])(\d+)\s+(?:data\s+)?(?:points|samples|values)\b(?!\s*(?:/|per))",
)


def unit_of(word: str) -> str:
    """A unit by its name: of accelerations a key of `UNITS`, of others the word, small."""
    plain = _plain(word).strip(" .,:;()[]")
    return _ALIASES.get(plain, plain)


def _plain(text: str) -> str:
    """A text in small letters, its units spelt in one way."""
    plain = text.lower()
    for pattern, spelling in _SPELLINGS:
        plain = pattern.sub(spelling, plain)
    return plain


def units_stated(header: Sequence[str]) -> Iterator[Stated[str]]:
    """The units of the samples that a header states, line by line."""
    for line, text in enumerate(header, start=1):
        for clause in _CLAUSE.split(text):
            plain = _plain(clause)
            for i, pattern in enumerate(_STATED):
                for found in pattern.finditer(plain):
                    unit = unit_of(found["unit"])
                    # What stands in brackets or after "in" may be anything.
                    said = i < 2 or unit in UNITS or unit in OTHERS
                    if (
                        said
                        and unit not in _TIMES
                        and not _QUANTITY.search(plain[: found.start("unit")])
                    ):
                        yield Stated(unit, line)


def unit_of_heading(heading: str) -> str | None:
    """The unit in the heading of a column, such as "vel (cm/s)"; None: it has none."""
    plain = _plain(heading)
    found = re.fullmatch(rf"[^()\[\]]*[(\[]\s*(?:in\s+)?(?P<unit>{_UNIT})\s*[)\]]\s*", plain)
    if found and not _QUANTITY.search(plain[: found.start("unit")]):
        unit = unit_of(found["unit"])
        return unit if unit in UNITS or unit in OTHERS else None
    return next((said.value for said in units_stated([heading])), None)


def units_hinted(header: Sequence[str]) -> Iterator[Stated[str]]:
    """Units of accelerations in a header that belong to no number: enough to doubt another one."""
    for line, text in enumerate(header, start=1):
        for clause in _CLAUSE.split(text):
            plain = _plain(clause)
            if not _QUANTITY.search(plain):
                for found in _BARE.finditer(plain):
                    yield Stated(unit_of(found["unit"]), line)


def mentions_units(header: Sequence[str]) -> int:
    """The number of the first line that has a unit other than g, stated or not, from 1; 0: none."""
    return next((k for k, text in enumerate(header, 1) if _MENTIONED.search(_plain(text))), 0)


def steps_stated(header: Sequence[str]) -> Iterator[Stated[float]]:
    """The times between samples that a header states, s."""
    for line, text in enumerate(header, start=1):
        for pattern in (*_STEPS, *_RATES):
            for found in re.finditer(pattern, text, re.IGNORECASE):
                value = float(found["number"].upper().replace("D", "E"))
                unit = (found.groupdict().get("unit") or "").lower()
                if pattern in _RATES:
                    value = 1 / value if value > 0 else 0.0
                elif unit.startswith("m"):
                    value /= 1000
                elif not unit and value > 1:
                    continue  # hardly in s
                if 0 < value < 1e9:
                    yield Stated(value, line)


def counts_stated(header: Sequence[str]) -> Iterator[Stated[int]]:
    """The numbers of samples that a header states."""
    for line, text in enumerate(header, start=1):
        for pattern in _COUNTS:
            for found in re.finditer(pattern, text, re.IGNORECASE):
                yield Stated(int(found[1]), line)


def names_milliseconds(header: Sequence[str]) -> int:
    """The number of the line in which a header states times in ms, from 1; 0: none."""
    return next((k for k, text in enumerate(header, 1) if _MILLISECONDS.search(text)), 0)
