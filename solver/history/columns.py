"""Names of the columns of a history, by the one table of columns, and rows by these names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

from solver.history.table import TABLE, Part
from solver.types import Array

STORED_ENERGIES = ("kinetic", "strain", "gravity", "spring", "interface")
"""Energies whose sum is `energy.total_J`."""

DISSIPATED_ENERGIES = ("friction", "damping", "contact_damping", "contact", "numerical")
"""Names of the energies dissipated since the start, each from its own formula."""


def columns(
    blocks: Sequence[str],
    *,
    dimension: int = 2,
    platform: bool = False,
    vertical: bool = False,
    second: bool = False,
    structure: tuple[int, int] | None = None,
    links: Mapping[str, bool] | None = None,
    feet: Mapping[str, int] | None = None,
) -> tuple[str, ...]:
    """Names of all columns of the history of a scene, in their order, by the names of its blocks.

    `platform`: whether what carries the blocks moves as a whole, and `structure` the numbers of its
    storeys and columns where it is meshed; `vertical`, `second`: whether the ground also moves up
    and down, or along the second horizontal direction. `links`: of each link by its name whether it
    acts along axes; `feet`: how many blocks have, by their names.
    """
    links = links or {}
    exists = {"": True, "axes": True, "vertical": vertical, "second": second}
    exists["structure"] = structure is not None
    storeys, standing = structure or (0, 0)
    owners: dict[Part, Sequence[str]] = {
        "run": [""],
        "block": blocks,
        "platform": ["platform"] * platform,
        "energy": ["energy"],
        "foundation": ["foundation"] * platform,
        "storey": [f"foundation.storey_{k + 1}" for k in range(storeys)],
        "column": [f"foundation.column_{k + 1}" for k in range(standing)],
        "link": list(links),
        "foot": [f"{name}.foot_{k + 1}" for name, n in (feet or {}).items() for k in range(n)],
    }
    there = [c for c in TABLE if c.dimension in (None, dimension) and exists[c.needs]]
    return tuple(
        f"{owner}.{column.name.partition('.')[2]}" if owner else column.name
        for part, group in groupby(there, key=lambda column: column.part)
        for own in [list(group)]
        for owner in owners[part]
        for column in own
        if column.needs != "axes" or links[owner]
    )


class Rows:
    """Rows by the names of their columns."""

    def __init__(self, names: Sequence[str], rows: Array):
        """Rows of (n, columns)."""
        self._place = {name: number for number, name in enumerate(names)}
        self._rows = rows

    def __contains__(self, column: object) -> bool:
        """True if there is a column of that name."""
        return column in self._place

    def __getitem__(self, column: str) -> Array:
        """One column, over the rows."""
        return self._rows[:, self._place[column]]
