"""Words in columns."""

from __future__ import annotations

from collections.abc import Sequence


def in_columns(table: Sequence[Sequence[str]], left: int = 1) -> list[str]:
    """The lines of a table: its first `left` columns to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = []
    for row in table:
        cells = [
            word.ljust(width) if number < left else word.rjust(width)
            for number, (word, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines
