"""Words in columns."""

from __future__ import annotations

from solver.study.tables import in_columns


def test_words_stand_left_and_numbers_right() -> None:
    table = [["name", "", "value"], ["a", "bb", "1"], ["long one", "c", ""]]
    assert in_columns(table) == ["name          value", "a         bb      1", "long one   c"]
    assert in_columns(table, left=2) == [
        "name          value",
        "a         bb      1",
        "long one  c",
    ]
