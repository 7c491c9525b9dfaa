"""An oracle: a scene, and its key numbers with the tolerance and the origin of each.

Numbers are read through what users have: `simulate`, the command line, the files of a run.
"""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from rockslip import SceneError, parse_scene, read_run, simulate

Tables = dict[str, Any]
Changes = Mapping[str, Any]
scene = tomllib.loads

REPOSITORY = Path(__file__).resolve().parents[2]
CASES = REPOSITORY.parent / "shared" / "cases"


@dataclass(frozen=True)
class Value:
    """A number that a run has to give, or a word that it has to say.

    Attributes:
        expected: The number; or a text that the run's contains.
        tolerance: Largest difference that the physics allows, in the number's own unit.
        source: Where it comes from: "closed form: ...", "independent program: ...", or "today".
    """

    expected: float | str
    tolerance: float
    source: str

    def off(self, found: Any) -> float:
        """Difference over tolerance: 1 or less is right."""
        if isinstance(self.expected, str):
            return 0.0 if self.expected in str(found) else np.inf
        if found is None or not np.isfinite(found):
            return np.inf
        return abs(found - self.expected) / self.tolerance


Numbers = dict[str, Value]


def today(expected: float, *, rel: float = 0.0, abs: float = 0.0, source: str = "today") -> Value:
    """A number of today, which `Oracle.beside` confirms; relative or absolute tolerance."""
    return Value(float(expected), abs + rel * np.abs(expected), source)


def closed(expected: float, formula: str, **tolerance: float) -> Value:
    """A number with a closed form."""
    return today(expected, source=f"closed form: {formula}", **tolerance)


def program(expected: float, name: str, **tolerance: float) -> Value:
    """A number of an independent program."""
    return today(expected, source=f"independent program: {name}", **tolerance)


def count(expected: int, source: str) -> Value:
    """A count."""
    return Value(expected, 0.5, source)


def word(expected: str, source: str = "definition") -> Value:
    """A word."""
    return Value(expected, 0.0, source)


@dataclass(frozen=True)
class Oracle:
    """A scene and its numbers.

    Attributes:
        name: Its name.
        base: The scene that is changed.
        changes: Values by path, as `--set` has them.
        numbers: Values by what is read (`READERS`), or what makes them.
        command: Arguments of `rockslip` with SCENE and OUT; empty: `simulate`.
        files: Files beside the scene, by name: their text.
        beside: What confirms the values of today, by its name: changes to another engine, step or
            tolerance. `python3 -m tests.oracles --beside` runs them.
        slow: Whether it takes more than two seconds.
        needs: A file outside the repository, without which there is nothing to run.
    """

    name: str
    base: Tables
    changes: Changes
    numbers: Numbers | Callable[[], Numbers]
    _: KW_ONLY
    command: str = ""
    files: Mapping[str, str] = field(default_factory=dict)
    beside: Mapping[str, Changes] = field(default_factory=dict)
    slow: bool = False
    needs: Path = REPOSITORY

    def differences(self, other: Changes | None = None) -> list[tuple[str, Value, Any]]:
        """Each number: its name, its value, and what a run gives; with other changes, too."""
        numbers = dict(self.numbers() if callable(self.numbers) else self.numbers)
        tables = changed(self.base, {**self.changes, **(other or {})})
        tables.setdefault("output", {}).setdefault("fields", "none")
        with tempfile.TemporaryDirectory() as name:
            for file, text in self.files.items():
                Path(name, file).write_text(text)
            run = Run.of(tables, Path(name), self.command)
        if run.refusal and not any("refusal" in number for number in numbers):
            return [("refusal", word("none", "it runs"), run.refusal)]
        if not self.command and not run.refusal:
            meshed = run.summary["model"] == "finite elements"
            for what, size in (("largest_gain", 1e-5), ("ledger_error", 1e-8)):
                within = size if meshed else 1e-10
                numbers[f"energy.{what}_fraction"] = closed(0.0, "conservation", abs=within)
        return [(name, value, run.read(name)) for name, value in numbers.items()]


@dataclass(frozen=True)
class Run:
    """Results of a run.

    Attributes:
        files: Text of its files by their names.
        printed: What the last command printed.
        exit: Its exit code.
        refusal: Why `simulate` refused the scene.
        summary: The summary, of `simulate` or of the folder `out`.
        history: Columns by name, likewise.
    """

    files: Mapping[str, str] = field(default_factory=dict)
    printed: str = ""
    exit: int = 0
    refusal: str = ""
    summary: Mapping[str, Any] = field(default_factory=dict)
    history: Any = None

    @classmethod
    def of(cls, tables: Tables, folder: Path, commands: str) -> Run:
        """Run a scene in a folder, by `simulate` or by commands one after another."""
        if not commands:
            try:
                result = simulate(parse_scene(tables, folder=folder))
            except SceneError as refusal:
                return cls(refusal=str(refusal))
            return cls(summary=result.summary, history=result.history)
        (folder / "scene.toml").write_text(tomli_w.dumps(tables))
        for line in commands.replace("SCENE", "scene.toml").replace("OUT", "out").split(" && "):
            words = [sys.executable, str(REPOSITORY / "rockslip.py"), *line.split()]
            done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=300)
            if done.returncode:
                break
        kinds = (".json", ".csv", ".toml")
        found = [file for file in folder.rglob("*") if file.suffix in kinds]
        files = {str(file.relative_to(folder)): file.read_text() for file in found}
        printed = done.stdout + done.stderr
        if "out/history.csv" not in files:
            return cls(files, printed, done.returncode)
        left = read_run(folder / "out")
        return cls(files, printed, done.returncode, "", left.summary, left.history)

    def read(self, name: str) -> Any:
        """A number by its name, by the first of `READERS` that fits; None if there is none."""
        for pattern, reader in READERS.items():
            match = re.fullmatch(pattern, name)
            if match:
                try:
                    return reader(self, *match.groups())
                except (KeyError, IndexError, StopIteration):
                    return None
        raise ValueError(f"no reader of {name!r}")

    def rows(self, file: str) -> list[dict[str, str]]:
        """Rows of a table."""
        return list(csv.DictReader(self.files[file].splitlines()))

    def at(self, time: str, column: str) -> Any:
        """A column at a time, s."""
        return np.interp(float(time), self.history["time_s"], self.history[column])

    def past(self, column: str, level: str) -> Any:
        """Time at which a column first passes a level."""
        highest = np.maximum.accumulate(self.history[column])
        return np.interp(float(level), highest, self.history["time_s"])


#: How a number is read: a pattern of its name, and what is done with its groups.
READERS: dict[str, Callable[..., Any]] = {
    r"refusal(?: \d)?": lambda run: run.refusal,
    r"exit": lambda run: run.exit,
    r"printed(?: \d)?": lambda run: run.printed,
    r"(?:(\S+) )?impact (\d+) (time_s|restitution)": lambda run, block, n, key: run.summary[
        "blocks"
    ][block or "block"]["impacts"][int(n) - 1][key],
    r"(?:(\S+) )?peak (\d+)": lambda run, block, n: run.summary["blocks"][block or "block"][
        "peaks"
    ][int(n) - 1]["angle_rad"],
    r"sum of first (\S+) to (\d+)": lambda run, name, last: sum(
        run.history[name.format(k)][0] for k in range(1, int(last) + 1)
    ),
    r"last (\S+) \+ (\S+)": lambda run, *names: sum(run.history[name][-1] for name in names),
    r"impulse of (\S+) and (\S+) kg times (\S+)": lambda run, force, mass, velocity: (
        run.history[force] @ run.history["step_s"] + float(mass) * run.history[velocity][-1]
    ),
    r"first (\S+)": lambda run, column: run.history[column][0],
    r"last (\S+)": lambda run, column: run.history[column][-1],
    r"peak (\S+)": lambda run, column: np.abs(run.history[column]).max(),
    r"(\S+) at (\S+) s": lambda run, column, time: run.at(time, column),
    r"time of (\S+) past (\S+)": lambda run, column, level: run.past(column, level),
    r"(\S+\.json) (\S+)": lambda run, file, path: _at(json.loads(run.files[file]), path),
    r"(\S+\.toml) (\S+)": lambda run, file, path: _at(tomllib.loads(run.files[file]), path),
    r"(\S+\.csv) (\S+) of row (\d+)": lambda run, file, column, row: float(
        run.rows(file)[int(row)][column]
    ),
    r"(\S+\.csv) (\S+) where (\S+)=(\S+)": lambda run, file, column, key, value: next(
        float(row[column]) for row in run.rows(file) if row[key] == value
    ),
    r"(\S+)": lambda run, path: _at({**run.summary, **run.summary["blocks"]}, path),
}


def _at(tables: Any, path: str) -> Any:
    """Value at a path."""
    for part in path.split("."):
        tables = tables[int(part)] if isinstance(tables, list) else tables[part]
    return tables


def demo(name: str, file: str = "scene") -> Tables:
    """The scene of a demo."""
    return scene((REPOSITORY / "demos" / name / f"{file}.toml").read_text())


def changed(tables: Tables, changes: Changes) -> Tables:
    """A scene with other values: "block.KEY" of every block, "NAME.KEY" of one, else by tables.

    None takes a key away, "+block" adds a block.
    """
    new = deepcopy(tables)
    for path, value in changes.items():
        *parents, key = path.split(".")
        if path == "+block":
            new["block"].append(value)
            continue
        for table in _meant(new, parents):
            table[key] = deepcopy(value)
            if value is None:
                del table[key]
    return new


def _meant(tables: Tables, parents: Sequence[str]) -> list[Tables]:
    """The tables at a path."""
    if not parents:
        return [tables]
    named = [block for block in tables["block"] if parents[0] in ("block", block.get("name"))]
    found = named or [tables.setdefault(parents[0], {})]
    for parent in parents[1:]:
        found = [table.setdefault(parent, {}) for table in found]
    return found
