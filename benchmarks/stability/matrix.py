"""The scenes of the stability study: families, each a grid of two things that are driven far.

A family starts from one scene; each row and each column changes some of its values. Scenes stay
plain tables here, since some of them are to be refused when they are read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

Tables = dict[str, Any]
Changes = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Place of a scene in the study.

    Attributes:
        family: What is driven far.
        row: Value along the rows of the family's grid, in words.
        column: The same along its columns.
    """

    family: str
    row: str
    column: str

    @property
    def name(self) -> str:
        """The scene in one line."""
        return ", ".join(part for part in (f"{self.family}: {self.row}", self.column) if part)


@dataclass(frozen=True, slots=True, kw_only=True)
class StabilityCase(Place):
    """One scene of the study.

    Attributes:
        tables: The scene, as plain tables.
        compared: True if its peak slip is held against the reference.
    """

    tables: Tables
    compared: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class StabilityFamily:
    """A grid of scenes.

    Attributes:
        name: What is driven far.
        base: The scene that rows and columns change, as plain tables.
        rows: Changes by the word for them; a path such as "block.young", its last part the key.
        columns: The same; the rows' changes come after them.
        compared: True if the peak slip of its scenes is held against the reference.
    """

    name: str
    base: Tables
    rows: Mapping[str, Changes]
    columns: Mapping[str, Changes]
    compared: bool = False

    def cases(self) -> Iterator[StabilityCase]:
        """Every scene of the grid, row by row."""
        for row, along in self.rows.items():
            for column, down in self.columns.items():
                tables = changed(self.base, {**down, **along})
                place = {"family": self.name, "row": row, "column": column}
                yield StabilityCase(**place, tables=tables, compared=self.compared)


def changed(tables: Tables, changes: Changes) -> Tables:
    """A scene with other values.

    Args:
        tables: The scene.
        changes: Values by path; "block.KEY" is meant for every block, "NAME.KEY" for the block of
            that name, "TABLE.KEY" for a table; None takes the key away.
    """
    new = deepcopy(tables)
    for path, value in changes.items():
        *parents, key = path.split(".")
        for table in _meant(new, parents):
            if value is None:
                table.pop(key, None)
            else:
                table[key] = deepcopy(value)
    return new


def _meant(tables: Tables, parents: list[str]) -> list[Tables]:
    """The tables at a path."""
    if not parents:
        return [tables]
    blocks = {block["name"]: block for block in tables["block"]}
    if parents[0] == "block":
        return list(blocks.values())
    if parents[0] in blocks:
        return [blocks[parents[0]]]
    table = tables
    for parent in parents:
        table = table.setdefault(parent, {})
    return [table]
