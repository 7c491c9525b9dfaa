"""Make the tables and pictures of the repository; `benchmarks/tables.toml` lists them.

    ./in-env python3 -m benchmarks.tables            # all, the cheapest first: hours
    ./in-env python3 -m benchmarks.tables NAME ...   # some
    ./in-env python3 -m benchmarks.tables --page     # docs/tables.md only

Times belong to their machine: make tables of times on one that does nothing else.
"""

from __future__ import annotations

import argparse
import datetime as dt
import resource
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from benchmarks.error_runtime.machine import machine
from solver import VERSION

ROOT = Path(__file__).resolve().parents[1]
LIST = ROOT / "benchmarks" / "tables.toml"
PAGE = ROOT / "docs" / "tables.md"
FOLDER = ROOT / "output" / "tables"

OWN = "{own}"
"""In a command: a folder of its own."""

HEAD = """\
# Tables and pictures

    make tables               # all of them, before a release: hours
    make tables ONLY=hertz    # one of them

Each table and picture of `benchmarks/`, of these pages and of the README has its command here,
with the version, day and commit of the program and the machine that made it last.
Numbers are those of that commit.
`benchmarks/tables.toml` is the list, and `make tables` writes this page.

| what | files | made by | version, day, commit | minutes | machine |
|---|---|---|---|---|---|
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python3 -m benchmarks.tables", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="default: all")
    parser.add_argument("--page", action="store_true", help="write docs/tables.md only")
    options = parser.parse_args(arguments)
    listed = read()
    if unknown := [name for name in options.names if name not in listed]:
        parser.error(f"{unknown[0]}: allowed {', '.join(listed)}")
    names = sorted(options.names or listed, key=lambda name: float(listed[name]["minutes"]))
    for name in [] if options.page else names:
        if outside := listed[name].get("outside"):
            print(f"{name}: left out, for it needs {outside}")
            continue
        print(f"{name}: about {listed[name]['minutes']:.2g} processor minutes", flush=True)
        make(name, listed[name])
        write(listed)
    PAGE.write_text(page(listed), encoding="utf-8")
    return 0


def read() -> dict[str, dict[str, Any]]:
    """The list."""
    return tomllib.loads(LIST.read_text("utf-8"))


def write(listed: Mapping[str, Any]) -> None:
    """Write the list, below the comment that it begins with."""
    head = LIST.read_text("utf-8").partition("\n\n")[0]
    LIST.write_text(f"{head}\n\n{tomli_w.dumps(listed)}", encoding="utf-8")


def make(name: str, entry: dict[str, Any]) -> None:
    """Run the commands of an entry, put its files where they are kept, and note when and where."""
    own, began = FOLDER / name, _processor_seconds()
    shutil.rmtree(own, ignore_errors=True)
    own.parent.mkdir(parents=True, exist_ok=True)
    for kept, left in entry["files"].items():
        if kept == left:
            (ROOT / kept).unlink(missing_ok=True)  # some commands go on with what is there
    for command in entry["commands"]:
        first, *words = (word.replace(OWN, str(own)) for word in shlex.split(command))
        run = [sys.executable, *(["-m", "rockslip"] if first == "rockslip" else []), *words]
        subprocess.run(run, cwd=ROOT, check=True)
    for kept, left in entry["files"].items():
        if kept != left:
            shutil.copyfile(own / left, ROOT / kept)
    shutil.rmtree(own, ignore_errors=True)
    day = dt.datetime.now(dt.UTC).date().isoformat()
    entry["made"] = f"{VERSION}, {day}, {_commit()}"
    entry["machine"] = machine()
    entry["minutes"] = round((_processor_seconds() - began) / 60, 2)


def page(listed: Mapping[str, Mapping[str, Any]]) -> str:
    """The page of the documents that says of every entry how, when and where it was made."""
    machines = sorted({entry["machine"] for entry in listed.values() if entry["machine"]})
    rows = []
    for name, entry in listed.items():
        files = ", ".join(f"`{Path(file).name}`" for file in entry["files"])
        commands = ", then ".join(f"`{_plain(command)}`" for command in entry["commands"])
        where = str(machines.index(entry["machine"]) + 1) if entry["machine"] else "-"
        cells = (name, files, commands, entry["made"] or "-", f"{entry['minutes']:.2g}", where)
        rows.append(f"| {' | '.join(cells)} |\n")
    kinds = "".join(f"{number}. {text}\n" for number, text in enumerate(machines, 1))
    return f"{HEAD}{''.join(rows)}\n## Machines\n\n{kinds}"


def _plain(command: str) -> str:
    """A command without the folder of its own, if that is all that an option of it says."""
    for option in (f" -o {OWN}", f" --output {OWN}"):
        command = command.removesuffix(option)
    return command.replace(f"{OWN}/", "")


def _processor_seconds() -> float:
    """Processor time of all commands that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _commit() -> str:
    """The commit that is checked out, with + where files differ; empty without git."""
    try:
        at, changes = (
            subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True, text=True)
            for words in (("rev-parse", "--short", "HEAD"), ("status", "--porcelain", "solver"))
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return f"{at.stdout.strip()}{'+' if changes.stdout else ''}"


if __name__ == "__main__":
    sys.exit(main())
