"""Tables of studies: as text in columns, Markdown and CSV, and as files never half written."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from solver.results.summary import write_json, write_whole

Row = Mapping[str, Any]

Member = TypeVar("Member")
Key = TypeVar("Key")


class Column(NamedTuple):
    """A column of a table in words."""

    key: str
    heading: str
    form: str = ""
    """Format of numbers; values as they are where there is none."""
    factor: float = 1.0
    """That numbers are multiplied by."""
    least: float = 0.0
    """Magnitudes up to this are round-off."""
    unknown: str = "-"
    """Word for what is not known."""

    def word(self, row: Row) -> str:
        """The value of a row."""
        value = row.get(self.key)
        if value is None:
            return self.unknown
        if not self.form:
            return str(value)
        shown = self.factor * value
        return format(shown if abs(shown) > self.least else 0.0, self.form)


def in_words(rows: Iterable[Row], columns: Sequence[Column]) -> list[list[str]]:
    """The headings of columns, then rows as words; what is missing or None is not known."""
    heading = [column.heading for column in columns]
    return [heading, *([column.word(row) for column in columns] for row in rows)]


def in_columns(table: Sequence[Sequence[str]], left: int = 1) -> list[str]:
    """Lines of a table of words.

    Args:
        table: Rows of words, all of one length.
        left: Number of columns that are aligned to the left; the others are aligned to the right.
    """
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = []
    for row in table:
        cells = [
            word.ljust(width) if number < left else word.rjust(width)
            for number, (word, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines


def in_markdown(table: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table of words in Markdown, in columns; the first row is the heading."""
    widths = [max(3, *map(len, column)) for column in zip(*table, strict=True)]
    heading, *rows = table
    lines = (heading, ["-" * width for width in widths], *rows)
    padded = ([w.ljust(n) for w, n in zip(line, widths, strict=True)] for line in lines)
    return [f"| {' | '.join(line)} |" for line in padded]


def groups(rows: Iterable[Member], key: Callable[[Member], Key]) -> dict[Key, list[Member]]:
    """Rows by their keys, both in the order in which they come."""
    found: dict[Key, list[Member]] = {}
    for row in rows:
        found.setdefault(key(row), []).append(row)
    return found


def early_ends(rows: Iterable[Row]) -> list[str]:
    """Lines that a table of runs begins with: those of its runs that end before their motion does.

    Rows hold what `solver.results.endings.cut_short` says under its name.
    """
    told = (row.get("cut_short") for row in rows)
    return [f"a run {text}" for text in dict.fromkeys(told) if text]


def column_names(rows: Sequence[Row]) -> list[str]:
    """Names of all columns, in the order in which rows bring them."""
    return list(dict.fromkeys(key for row in rows for key in row))


def as_csv(rows: Sequence[Row], names: Sequence[str], digits: int | None = None) -> str:
    """Rows as CSV; values that are not known (missing or None) are empty.

    Args:
        rows: Values by the name of their column.
        names: Names of the columns.
        digits: Significant digits of numbers, NaN is then empty; None: all digits.
    """
    stream = io.StringIO()
    table = csv.DictWriter(stream, names, restval="", lineterminator="\n")
    table.writeheader()
    table.writerows({name: _rounded(value, digits) for name, value in row.items()} for row in rows)
    return stream.getvalue()


def _rounded(value: Any, digits: int | None) -> Any:
    """A value of a CSV file."""
    if digits is None or not isinstance(value, float):
        return value
    return "" if math.isnan(value) else f"{value:.{digits}g}"


def write(file: Path, content: Mapping[str, Any] | str) -> None:
    """Write a text, or a mapping as JSON; a reader sees the old file or the new one, never half."""
    if isinstance(content, str):
        write_whole(file, content)
    else:
        write_json(file, content)
