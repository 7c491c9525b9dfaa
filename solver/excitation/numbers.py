"""Numbers in text files: what files of motions have in common, and what is wrong with them."""

from __future__ import annotations

import codecs
import math
from dataclasses import dataclass
from pathlib import Path

from solver.errors import SceneError
from solver.scene.checking import shown


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
    strange = next((i for i, byte in enumerate(content) if byte < 9 or 13 < byte < 32), None)
    if strange is not None:
        line = 1 + content.count(b"\n", 0, strange)
        raise SceneError(f"{file}: line {line}", "binary data", f"a text with {expected}")
    if not content.strip():
        raise SceneError(f"{file}: line 1", "an empty file", expected)
    return content.decode("utf-8-sig", errors="replace").splitlines()


def number_in(word: str) -> float | None:
    """The number that a word stands for, an exponent written with D counted in; NaN is one."""
    try:
        # Python alone would take 1_000 for a number.
        return None if "_" in word else float(word.replace("D", "E").replace("d", "e"))
    except ValueError:
        return None


def words_of(line: str) -> list[str]:
    """The words of a line, which commas, semicolons or blanks separate."""
    separator = next((sign for sign in ",;" if sign in line), None)
    return [word.strip() for word in line.split(separator)] if line.strip() else []


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
                both = "," in text and ";" in text
                got = text.strip() if both or len(words) <= 2 else word
                point = ", decimals with a point" if both else ""
                raise SceneError(f"{file}: line {line}", shown(got), f"{expected}{point}")
            values.append(number)
        rows.append(Row(line, words, values))
    return rows


def split_header(lines: list[str]) -> tuple[list[str], list[str]]:
    """The header and the rest: from the first line that begins with a number."""
    for i, line in enumerate(lines):
        words = words_of(line)
        if words and number_in(words[0]) is not None:
            return lines[:i], lines[i:]
    return lines, []
