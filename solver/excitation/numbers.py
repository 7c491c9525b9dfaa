"""Numbers in text files: what files of motions have in common, and what is wrong with them."""

from __future__ import annotations

import codecs
import math
import re
from dataclasses import dataclass
from pathlib import Path

from solver.errors import SceneError
from solver.scene.checking import shown

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
    """Whether a file can be read and is no text."""
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
    """Whether a word is quoted as a whole."""
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
