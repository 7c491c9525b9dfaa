"""What is recorded of tables and pictures when they are made: `record.toml`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

RECORD = Path(__file__).with_name("record.toml")

HEAD = """\
# Of each table and picture: when, where and from what code it was made. Written when it is made
# (`make tables`), or entered afterwards (`--made-by COMMIT`), then with a load of -1. `code` has
# digests of what decides its numbers, `files` those of the files themselves; `commit` is the last
# one at that time, with a + where there were changes that had not been committed.
"""


@dataclass(frozen=True, kw_only=True)
class Made:
    """When, where and from what code something was made.

    Attributes:
        version: Of rockslip.
        date: Day, as 2026-11-23.
        machine: Its processor, system and Python; empty where that was not recorded.
        commit: The last one when it was made; empty without git.
        minutes: Of processor time; 0 where that was not measured.
        wall_minutes: From the beginning to the end; 0 where that was not measured.
        load: Processes that ran on the machine when it began; -1 where that was not measured.
        code: Digests of what decides its numbers.
        files: Digests of its files.
    """

    version: str
    date: str
    machine: str
    commit: str
    minutes: float
    wall_minutes: float
    load: float
    code: Mapping[str, str]
    files: Mapping[str, str]


def read(file: Path = RECORD) -> dict[str, Made]:
    """What is recorded, by name."""
    found = tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}
    return {name: Made(**entry) for name, entry in found.items()}


def write(record: Mapping[str, Made], file: Path = RECORD) -> None:
    """Write the record, its entries in the order of their names."""
    import tomli_w

    text = tomli_w.dumps({name: asdict(record[name]) for name in sorted(record)})
    file.write_text(f"{HEAD}\n{text}", encoding="utf-8")
