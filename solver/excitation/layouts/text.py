"""Text files with numbers: their lines, rows and headers, statements, and components of motions."""

from __future__ import annotations

import codecs
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from solver.errors import SceneError
from solver.scene.checking import shown
from solver.types import Array

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?"
"""A number, as a regular expression without groups."""

CLOSE = 1e-4
"""Relative difference up to which two printed intervals are the same."""

_END_OF_NUMBER = re.compile(r"(?<=[\d.])(?=[-+\s])")

T = TypeVar("T")

_NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x1f]")
_DECIMAL_COMMA = re.compile(r"\d,\d.*[;\s]|[;\s].*\d,\d")
_WORD = re.compile(r"(?!nan\b|inf\b|infinity\b)[a-z]{2,}", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Row:
    """A line of numbers."""

    line: int
    """Its number in the file, from 1."""
    words: list[str]
    values: list[float]


def read_lines(file: Path, key: str, expected: str) -> list[str]:
    """The lines of a text file that a key names and that should hold what is expected, in words.

    Raises:
        SceneError: It cannot be read, is no text, or there is nothing in it.
    """
    if file.is_dir():
        raise SceneError(key, f"{file} (a folder)", f"a file with {expected}")
    try:
        content = file.read_bytes()
    except OSError as error:
        reason = (error.strerror or "unreadable").lower()
        raise SceneError(key, f"{file} ({reason})", f"a file with {expected}") from None
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        content = content.decode("utf-16", errors="replace").encode()
    content = content.rstrip(b"\x1a")  # how text ended under DOS
    strange = _NO_TEXT.search(content)
    if strange is not None:
        line = 1 + content.count(b"\n", 0, strange.start())
        raise SceneError(f"{file}: line {line}", "binary data", f"a text with {expected}")
    if not content.strip():
        raise SceneError(f"{file}: line 1", "an empty file", expected)
    return content.decode("utf-8-sig", errors="replace").splitlines()


def is_binary(file: Path) -> bool:
    """True if a file can be read and is no text."""
    try:
        content = file.read_bytes()
    except OSError:
        return False
    utf16 = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return not utf16 and _NO_TEXT.search(content.rstrip(b"\x1a")) is not None


def number_in(word: str) -> float | None:
    """The number that a word stands for, an exponent written with D counted in; NaN is one."""
    try:
        # Python alone would take 1_000 for a number.
        return None if "_" in word else float(word.replace("D", "E").replace("d", "e"))
    except ValueError:
        return None


def words_of(line: str) -> list[str]:
    """The words of a line, which commas, semicolons or blanks separate, without their quotes."""
    separator = next((sign for sign in ",;" if sign in line), None)
    words = [word.strip() for word in line.split(separator)] if line.strip() else []
    if '"' in line:
        return [word[1:-1].strip() if _is_quoted(word) else word for word in words]
    return words


def _is_quoted(word: str) -> bool:
    """True if a word is quoted as a whole."""
    return len(word) > 1 and word[0] == word[-1] == '"'


def rows_of(file: Path, lines: list[str], expected: str, first: int = 1) -> list[Row]:
    """All lines of numbers, the first of them with its number in the file.

    Blank lines and those that begin with # are skipped. Errors say what a line should hold.

    Raises:
        SceneError: There is a line with anything but finite numbers.
    """
    rows = []
    for line, text in enumerate(lines, start=first):
        words = words_of(text)
        if not words or words[0].startswith("#"):
            continue
        values = []
        for word in words:
            number = number_in(word)
            if number is None or not math.isfinite(number):
                both = bool(_DECIMAL_COMMA.search(text.strip()))
                got = text.strip() if both or len(words) <= 2 else word
                point = ", decimals with a point" if both else ""
                raise SceneError(f"{file}: line {line}", shown(got), f"{expected}{point}")
            values.append(number)
        rows.append(Row(line, words, values))
    return rows


def split_header(lines: list[str]) -> tuple[list[str], list[str]]:
    """The header and the rest: from the first line that begins with a number and is no sentence."""
    for i, line in enumerate(lines):
        words = words_of(line)
        if words and number_in(words[0]) is not None and len(_WORD.findall(line)) < 2:
            return lines[:i], lines[i:]
    return lines, []


@dataclass(frozen=True, slots=True)
class Stated(Generic[T]):
    """A statement of a file: the value, and the number of its line, from 1."""

    value: T
    line: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Component:
    """One accelerogram of a file."""

    name: str = ""
    """Its name in the file; empty: none."""
    number: int = 0
    """Number of its column in the file, from 1; 0: its place among all components of the file."""
    values: Array
    """The samples in the unit below, (n,)."""
    lines: list[int]
    """The number of the line of each sample, n of them."""
    units: tuple[Stated[str], ...] = ()
    """The units that the header states: keys of `UNITS`, or others than accelerations have."""
    steps: tuple[Stated[float], ...] = ()
    """The times between samples that the header states, s."""
    time: Array | None = None
    """The times of the samples where the file has them, s, (n,)."""
    even: float | None = None
    """The time between samples by these times, s; None: none, or not the same for all."""
    notes: tuple[str, ...] = ()
    """Changes of the samples, in words: the factor of counts, a mean that was taken off."""


@dataclass(frozen=True, slots=True)
class TextFile:
    """The lines of a file."""

    path: Path
    lines: list[str]

    def error(self, line: int, got: str, allowed: str) -> SceneError:
        """The refusal of a line, by its number from 1."""
        return SceneError(f"{self.path}: line {line}", got, allowed)

    def optional(
        self, pattern: str, among: Iterable[int] | None = None
    ) -> Stated[re.Match[str]] | None:
        """The first line that has a pattern, of all or of those with these numbers; None: none."""
        seen = re.compile(pattern, re.IGNORECASE)
        for line in range(1, len(self.lines) + 1) if among is None else among:
            found = seen.search(self.lines[line - 1])
            if found:
                return Stated(found, line)
        return None

    def required(
        self, pattern: str, what: str, among: Iterable[int] | None = None
    ) -> Stated[re.Match[str]]:
        """The first line that has a pattern, which the layout requires; `what`: in words."""
        found = self.optional(pattern, among)
        if found is None:
            raise SceneError(str(self.path), "a header without it", what)
        return found

    def count(self, pattern: str, what: str, among: Iterable[int] | None = None) -> Stated[int]:
        """A number of samples: the first group of the pattern."""
        found = self.required(pattern, what, among)
        if int(found.value[1]) < 2:
            raise self.error(found.line, shown(found.value[0].strip()), f"{what}, 2 or more")
        return Stated(int(found.value[1]), found.line)

    def positive(
        self, pattern: str, what: str, among: Iterable[int] | None = None
    ) -> Stated[float]:
        """A positive number: the first group of the pattern."""
        found = self.required(pattern, what, among)
        value = number_in(found.value[1])
        if value is None or not 0 < value < math.inf:
            raise self.error(found.line, shown(found.value[0].strip()), f"{what}, above 0")
        return Stated(value, found.line)

    def agree(
        self, one: Stated[int] | Stated[float], other: Stated[int] | Stated[float], what: str
    ) -> None:
        """Refuse two numbers that should be the same."""
        if not math.isclose(one.value, other.value, rel_tol=CLOSE):
            got, allowed = f"{what} {other.value:g}", f"{one.value:g} as in line {one.line}"
            raise self.error(other.line, got, allowed)

    def similar(self, peak: Stated[re.Match[str]] | None, values: Array) -> None:
        """Refuse a largest value, a group of a pattern, that is less than half of that of samples.

        Or more than twice: headers are about raw and about filtered samples, but in one unit.
        """
        most = float(np.abs(values).max())
        said = abs(float(peak.value[1])) if peak else 0.0
        if peak and said and most and not 0.5 <= most / said <= 2.0:
            got, allowed = f"a peak of {said:g}", f"{most:.4g}, the largest of the values"
            raise self.error(peak.line, got, allowed)

    def block(
        self,
        after: int,
        count: Stated[int],
        *,
        width: int | None = None,
        columns: int | None = None,
    ) -> tuple[Array, list[int]]:
        """So many samples in reading order, from the line after a number on, and their lines.

        `width` is that of the numbers where the file states it, and `columns` how many stand in
        each line; of several columns there are as many rows as samples, (n, columns).
        """
        values: list[float] = []
        lines: list[int] = []
        wanted = count.value * (columns or 1)
        noun = "rows" if columns else "values"
        expected = f"{count.value} {noun}, as line {count.line} says"
        line = after
        while len(values) < wanted:
            line += 1
            if line > len(self.lines):
                got = f"the end of the file after {len(values) // (columns or 1)} {noun}"
                raise self.error(len(self.lines), got, expected)
            row = self.row(line, width)
            if columns and row and len(row) != columns:
                raise self.error(line, f"a line of {len(row)}", f"{columns} columns")
            values += row
            lines += [line] * (1 if columns and row else len(row))
        if len(values) > wanted:
            raise self.error(line, "more values", expected)
        found = np.array(values)
        return (found.reshape(-1, columns) if columns else found), lines

    def row(self, line: int, width: int | None = None) -> list[float]:
        """The numbers of a line, which may touch where they stand in columns of one width."""
        text = self.lines[line - 1]
        words = words_of(text)
        numbers = [number_in(word) for word in words]
        if None in numbers:
            cut = [number_in(cell) for cell in _cells(text, width)]
            numbers = cut if cut and None not in cut else numbers
        for number, word in zip(numbers, words, strict=False):
            if number is None or not math.isfinite(number):
                touch = " that do not touch" if re.search(r"\d[-+.]\d+[-+.]", word) else ""
                got = text.strip() if len(words) <= 2 else word
                raise self.error(line, shown(got), f"finite numbers{touch}")
        return [number for number in numbers if number is not None]

    def nothing_after(self, line: int, count: Stated[int], *, whole: bool = True) -> None:
        """Refuse values after the last one: in the whole rest, or in the next line with words."""
        for later in range(line + 1, len(self.lines) + 1):
            words = words_of(self.lines[later - 1])
            if (whole and self.row(later)) or (words and number_in(words[0]) is not None):
                raise self.error(later, "more values", f"{count.value}, as line {count.line} says")
            if words and not whole:
                return


def _cells(text: str, width: int | None) -> list[str]:
    """The cells of a line of equal widths; none where its numbers do not end in such a grid."""
    text = text.rstrip()
    if width is None:
        ends = [found.start() for found in _END_OF_NUMBER.finditer(text)] + [len(text)]
        width = ends[0]
        if not width or any(end % width for end in ends):
            return []
    return [text[i : i + width] for i in range(0, len(text), width)]


def width_of(form: str) -> int | None:
    """The width of the numbers of a Fortran format such as 8F10.5; None: it states none."""
    found = re.search(r"\d*\s*[a-z]+(\d+)", form, re.IGNORECASE)
    return int(found[1]) or None if found else None
