"""The base of all studies: cases that run side by side, the folder that keeps them, the end.

A study is a subclass of `Study` in `solver/study/NAME/cases.py`:

- class attributes name it and the files that it leaves in its folder;
- `__init__(options)` reads the command line, refuses all that can be refused, and sets `settings`
  (what a study that is resumed must have in common with the earlier one) and `wanted` (its cases);
- a case is a frozen dataclass with a `name`, its own in the study, and `run()`, which returns its
  row: a mapping that JSON can hold, with "status" and "reason" unless it completed. Cases run in
  other processes;
- `rounds()` is overridden where the cases of one round follow from the rows of the rounds before;
- `keep(case, row)` is overridden where a row has parts that go into files of their own;
- `write()` leaves (`leave`) and draws (`draw`) what `completed` (or `ordered`) rows say, and
  returns that in words.

`solver/study/command.py` has the options of all studies and calls `Study.run(options)`, which does
the rest, the same on any number of ranks: claims the folder, or refuses to write over another one;
takes the rows of an earlier study with `--resume`; runs what is missing; writes, also after an
interruption; returns the exit code.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import shutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Protocol, Self, TypeVar

from solver import VERSION
from solver.errors import NotConverged, SceneError
from solver.excitation.layouts.text import number_in
from solver.parallel import Comm, abort_on_exceptions, on_first_rank
from solver.run.folders import REPORT, hold_folder, make_folder, unusable_is_refused
from solver.run.streams import say
from solver.scene.checking import nearest, shown
from solver.scene.reader import differing
from solver.study.pool import Named, finished_cases, reason_of
from solver.study.tables import as_csv, column_names, write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SETTINGS, CASES, SUMMARY = "settings.json", "cases", "summary.json"

ENDINGS = ("csv", "txt", "md", "png")
"""Endings of the files that have the name of a study."""

FORMAT = 2
"""Number of the format of the rows that are kept; studies of another one are not gone on with."""

HELD = "held"
"""Key of the settings for what a study that is resumed is compared with."""

Row = dict[str, Any]


class StudyCase(Named, Protocol):
    """A case of a study; its name is its own there."""

    def run(self) -> Row:
        """Run the case on one process; its row."""


Case = TypeVar("Case", bound=StudyCase)


class Study(ABC, Generic[Case]):
    """A study of one command line.

    Class attributes:
        kind: The name of its command, and the ending of its folder.
        table: The name of its table and text; "": the kind.
        noun: What it is, for errors.
        same: What a study that is resumed must have in common with the earlier one, in words.
        files: Names or patterns of what it leaves besides the settings, the summary, and files of
            its own name; `--force` removes all of these.
        folders: Names of its folders besides that of the cases.

    Attributes:
        options: Of the command.
        folder: Where the study is kept.
        settings: What it is made from, besides the version; of files only what they hold counts.
        wanted: Its cases, where it has one round.
        cases: All cases of the rounds so far, by their keys.
        rows: Rows by the keys of their cases; on rank 0 alone they grow.
    """

    kind: ClassVar[str]
    table: ClassVar[str] = ""
    noun: ClassVar[str]
    same: ClassVar[str]
    files: ClassVar[tuple[str, ...]] = ()
    folders: ClassVar[tuple[str, ...]] = ()

    def __init__(self, options: argparse.Namespace):
        """Read the options that all studies have."""
        if options.processes is not None and options.processes < 1:
            raise SceneError("-j", f"{options.processes}", "a whole number > 0")
        self.options = options
        self.folder = Path(options.output or f"{options.scene.stem}.{self.kind}")
        self.settings: dict[str, Any] = {}
        self.wanted: Sequence[Case] = ()
        self.cases: dict[str, Case] = {}
        self.rows: dict[str, Row] = {}

    # ------------------------------------------------------------ what a kind of study adds

    @abstractmethod
    def write(self) -> str:
        """Write tables and pictures of the rows that there are; what is said of them, or ""."""

    def rounds(self) -> Iterator[Sequence[Case]]:
        """Cases, round after round; those of a later one may follow from `rows`. On rank 0."""
        yield self.wanted

    def key(self, case: Case) -> str:
        """The key of the row of a case, and the name of its file: its name, if it has no other."""
        return str(getattr(case, "key", case.name))

    def keep(self, case: Case, row: Row) -> Row:
        """Keep the row of a case in the folder; returns it."""
        write(self.folder / CASES / f"{self.key(case)}.json", row)
        return row

    def failure(self, case: Case, error: Exception) -> Row:
        """The row of a case that raised an error."""
        return {"status": "failed", "reason": reason_of(error)}

    @property
    def good(self) -> bool:
        """True if all is done and right, so that the exit code is 0."""
        return len(self.completed) == len(self.cases)

    # ------------------------------------------------------------ the same for all

    def leave(
        self,
        table: Sequence[Mapping[str, Any]],
        text: str,
        summary: Mapping[str, Any],
        *,
        names: Sequence[str] | None = None,
        digits: int | None = None,
    ) -> None:
        """Write what was found: the table, the text, and what is for programs.

        The text is Markdown where it begins with a title. Columns and digits are as of `as_csv`; no
        names: all columns there are, in the order of the row that has most of them.
        """
        if names is None:  # a case that failed has few
            names = column_names(sorted(table, key=len, reverse=True))
        own = self.folder / (self.table or self.kind)
        write(own.with_suffix(".csv"), as_csv(table, names, digits))
        write(own.with_suffix(".md" if text.startswith("# ") else ".txt"), text)
        write(self.folder / SUMMARY, summary)

    def draw(self, name: str, picture: Callable[..., Figure], *told: Any) -> None:
        """Draw a picture of what it is told, into a file of that name."""
        from solver.pictures.style import save

        save(lambda: picture(*told), self.folder / name)

    @classmethod
    def run(cls, options: argparse.Namespace) -> int:
        """Run the study of a command line; its exit code. Collective on all ranks."""
        from mpi4py import MPI

        comm = MPI.COMM_WORLD
        abort_on_exceptions(comm)
        study: Self = on_first_rank(comm, lambda: cls(options).claimed())
        try:
            study.run_rounds(comm)
        except BaseException:
            if comm.rank == 0:
                study.conclude()
            raise
        return 0 if on_first_rank(comm, study.conclude) else NotConverged.exit_code

    def run_rounds(self, comm: Comm) -> None:
        """Run the cases that have no row yet, and keep their rows; collective on all ranks."""
        rounds = self.rounds()
        while (waiting := on_first_rank(comm, lambda: self._waiting(rounds))) is not None:
            outcomes = finished_cases(
                _run,
                waiting,
                done=len(self.cases) - len(waiting),
                processes=self.options.processes,
                quiet=self.options.quiet,
            )
            with closing(outcomes):
                for case, outcome in outcomes:
                    if isinstance(outcome, Exception):
                        outcome = self.failure(case, outcome)
                    if outcome["status"] != "interrupted":
                        self.rows[self.key(case)] = self.keep(case, outcome)

    def _waiting(self, rounds: Iterator[Sequence[Case]]) -> list[Case] | None:
        """The cases of the next round that have no row yet; None where there is no more round."""
        more = next(rounds, None)
        if more is None:
            return None
        found = {self.key(case): case for case in more}
        self.cases |= found
        return [case for key, case in found.items() if key not in self.rows]

    def conclude(self) -> bool:
        """Write the results of the study and print them; True if all is done and right."""
        text = self.write() if self.rows else ""
        if not self.options.quiet:
            self.say(text)
        return self.good

    def say(self, text: str) -> None:
        """Say what the study found, what of it failed, and where everything stands."""
        failed = [
            f"failed: {case.name}: {self.rows[key]['reason']}\n"
            for key, case in self.cases.items()
            if key in self.rows and self.rows[key]["status"] != "completed"
        ]
        say(f"{text}{''.join(failed)}written to {self.folder}\n")

    @property
    def ordered(self) -> list[Row]:
        """The rows that there are, in the order of the cases."""
        return [self.rows[key] for key in self.cases if key in self.rows]

    @property
    def completed(self) -> list[Row]:
        """The rows of cases that completed."""
        return [row for row in self.ordered if row["status"] == "completed"]

    # ------------------------------------------------------------ the folder

    def claimed(self) -> Self:
        """The study itself, which has made its folder, or refused to write over what is there."""
        options, folder = self.options, self.folder
        settings = {"version": VERSION, "format": FORMAT, **self.settings}
        held = json.loads(json.dumps(with_digests(settings)))
        allowed = "an empty folder, --force, or --resume"
        if folder.exists() and options.scene.resolve().parent == folder.resolve():
            raise SceneError("-o", f"{folder}, which holds the scene itself", "another folder")
        with unusable_is_refused(folder):
            used = make_folder(folder, force=options.force or options.resume, allowed=allowed)
            hold_folder(folder)
            if options.resume and used:
                self._compare(held)
                self.rows = finished(folder)
            else:
                self._clear()
            kept = {"command": options.repeated, **settings, HELD: held}
            write(folder / SETTINGS, kept)
            (folder / CASES).mkdir(exist_ok=True)
        return self

    def _clear(self) -> None:
        """Remove an earlier study; folders of such names that are of no study are refused."""
        folders = [self.folder / name for name in (CASES, *self.folders)]
        others = [folder for folder in folders if folder.exists()]
        if others and "version" not in read_mapping(self.folder / SETTINGS):
            got = f"{self.folder}, which holds {others[0].name}/, but no study"
            raise SceneError("-o", got, "another folder")
        own = (f"{self.kind}.{ending}" for ending in ENDINGS)
        for pattern in (SETTINGS, SUMMARY, REPORT, *own, *self.files):
            for file in self.folder.glob(pattern):
                file.unlink()
        for folder in folders:
            shutil.rmtree(folder, ignore_errors=True)

    def _compare(self, held: Mapping[str, Any]) -> None:
        """Refuse a folder that was made from something else, or by another version."""
        earlier = read_mapping(self.folder / SETTINGS).get(HELD)
        if not isinstance(earlier, dict):
            got = f"{self.folder}, which holds no {self.noun} of this version"
            raise SceneError("--resume", got, "its folder")
        keys = sorted(differing(earlier, held))
        if keys:
            more = f" and {len(keys) - 1} more" if len(keys) > 1 else ""
            got = f"{self.folder}, made with another {keys[0]}{more}"
            raise SceneError("--resume", got, self.same)


def _run(case: StudyCase) -> Row:
    """Run a case, in another process; it completed unless its row says something else."""
    return {"status": "completed", "reason": ""} | case.run()


def read_mapping(file: Path) -> Row:
    """A mapping of a JSON file; an empty one where there is none."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def finished(folder: Path) -> dict[str, Row]:
    """The rows of the completed cases by name; failed and damaged ones are tried again."""
    rows = {file.stem: read_mapping(file) for file in sorted((folder / CASES).glob("*.json"))}
    return {name: row for name, row in rows.items() if row.get("status") == "completed"}


def digest(said: Any) -> str:
    """A name made from values that JSON can hold: equal values have one."""
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()[:20]


def with_digests(said: Any) -> Any:
    """Tables with digests of what files hold in place of their names, where they can be read."""
    if isinstance(said, Mapping):
        changed = {key: with_digests(value) for key, value in said.items()}
        if isinstance(said.get("file"), str):
            with suppress(OSError):
                changed["file"] = hashlib.sha256(Path(said["file"]).read_bytes()).hexdigest()
        return changed
    if isinstance(said, (list, tuple)):
        return [with_digests(value) for value in said]
    return said


# ---------------------------------------------------------------- words of options


def numbers(option: str, text: str | None) -> list[float]:
    """The positive numbers of an option: V1,V2,... or LOW:HIGH:COUNT, equally spaced.

    There are none where it is not given.

    Raises:
        SceneError: It holds something else.
    """
    import numpy as np

    if text is None:
        return []
    try:
        if text.count(":") == 2:
            low, high, count = text.split(":")
            found = [float(f"{v:.6g}") for v in np.linspace(float(low), float(high), int(count))]
        else:
            found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if not found or not all(0 < value < math.inf for value in found):
        raise SceneError(option, shown(text), "numbers > 0: V1,V2,... or LOW:HIGH:COUNT")
    return list(dict.fromkeys(found))


def by_name(option: str, words: Sequence[str], allowed: str) -> dict[str, list[str]]:
    """The values that the words of an option, NAME=V1,V2,..., give to each name; NAME alone: none.

    SceneError where one is empty, or comes twice.
    """
    found: dict[str, list[str]] = {}
    for word in words:
        name, equals, text = (part.strip() for part in word.partition("="))
        values = [value.strip() for value in text.split(",")] if equals else []
        if not name or name in found or not all(values) or len(set(values)) < len(values):
            raise SceneError(option, shown(word), f"{allowed}, each name and value once")
        found[name] = values
    return found


def numbers_by_name(
    option: str, words: Sequence[str], known: Sequence[str], allowed: str
) -> dict[str, tuple[float, ...]]:
    """The numbers that the words of an option give to each of the names that are known.

    As `by_name`; SceneError where a name is not known, a value is no number, or one comes twice.
    """
    found: dict[str, tuple[float, ...]] = {}
    for name, texts in by_name(option, words, allowed).items():
        if name not in known:
            raise SceneError(option, shown(name), ", ".join(known), nearest(name, known))
        values = [number_in(text) for text in texts]
        found[name] = tuple(value for value in values if value is not None)
        if len(set(found[name])) < len(texts):
            raise SceneError(option, shown(f"{name}={','.join(texts)}"), allowed)
    return found


def words(option: str, text: str | None, known: Sequence[str]) -> list[str]:
    """The words of an option, V1,V2,..., all of them known; SceneError where one is not.

    There are none where it is not given.
    """
    found = [] if text is None else list(dict.fromkeys(text.split(",")))
    for word in found:
        if word not in known:
            raise SceneError(option, shown(word), ", ".join(known), nearest(word, known))
    return found
