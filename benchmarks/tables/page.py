"""The page of the documents that says of every table and picture how and when it was made."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from benchmarks.tables.listed import EVIDENCE, OWN, Evidence
from benchmarks.tables.record import Made
from benchmarks.tables.sources import ROOT
from benchmarks.tables.state import BUSY

PAGE = ROOT / "docs" / "tables.md"

HEAD = """\
# Tables and pictures

    make tables                                    # those that are older than the code
    make tables ONLY=hertz                         # one of them
    ./in-env python3 -m benchmarks.tables --list   # what each is, and why one is older

`python3 -m benchmarks.tables` writes this page.
It lists each table and picture of `benchmarks/`, of these pages and of the README:
the command that makes it, the version, day and machine that made it, and its processor time.
The cheapest are made first, and what was stopped goes on.
A test fails if the code that decides the numbers of a table has changed since it was made.
Comments and docstrings do not count, nor do changes that `benchmarks/tables/harmless.toml`
states with a reason, nor the tables that are named here as older ones.
Times belong to their machine; tables of times may be one release old.
Tables of keys and columns are written by `make docs-tables`, and have a test of their own.
"""


def page(record: Mapping[str, Made], older: Mapping[str, str]) -> str:
    """The page."""
    lines = [HEAD, "## Older than the code", ""]
    if older:
        lines += ["These are the numbers of the commit below; today's code may give others.", ""]
        lines += ["| what | version, day, commit | why |", "|---|---|---|"]
        lines += [f"| {name} | {_when(record.get(name))} | {why} |" for name, why in older.items()]
    else:
        lines.append("None.")
    lines += ["", "## All", ""]
    lines += ["| what | files | made by | version, day, commit | minutes | machine |"]
    lines += ["|---|---|---|---|---|---|"]
    machines = sorted({made.machine for made in record.values() if made.machine})
    for name, evidence in EVIDENCE.items():
        made = record.get(name)
        files = ", ".join(f"`{Path(file).name}`" for file in evidence.files)
        cells = (
            *(name, files, _commands(evidence), _when(made)),
            *(_cost(made), _where(made, machines, timed=evidence.timed)),
        )
        lines.append(f"| {' | '.join(cells)} |")
    lines += ["", "## Machines", ""]
    lines += [f"{number}. {machine}" for number, machine in enumerate(machines, 1)]
    return "\n".join(lines) + "\n"


def _commands(evidence: Evidence) -> str:
    """What makes it."""
    shown = [
        command.removesuffix(f" -o {OWN}").removesuffix(f" --output {OWN}").replace(f"{OWN}/", "")
        for command in evidence.commands
    ]
    return ", ".join(f"`{command}`" for command in shown)


def _when(made: Made | None) -> str:
    """Version, day and commit."""
    return f"{made.version}, {made.date}, {made.commit}" if made else "not known"


def _cost(made: Made | None) -> str:
    """Minutes of processor time."""
    return f"{made.minutes:.2g}" if made and made.minutes else "-"


def _where(made: Made | None, machines: list[str], *, timed: bool) -> str:
    """Number of the machine, and whether something else ran on it where that matters."""
    if made is None or not made.machine:
        return "-"
    busy = ", busy" if timed and made.load > BUSY else ""
    return f"{machines.index(made.machine) + 1}{busy}"
