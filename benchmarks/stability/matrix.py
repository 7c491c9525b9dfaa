"""The scenes of the stability study: families, each a grid of two things that are driven far.

A family starts from one scene; each row and each column changes some of its values. Scenes stay
plain tables here, since some of them are to be refused when they are read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from solver.study.scenes import Changes, Tables, changed


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
        rows: Changes by the word for them.
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
