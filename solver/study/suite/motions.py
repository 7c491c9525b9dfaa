"""The motions of a suite: files, folders of files, lists of files, synthetic ones."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from solver.errors import SceneError
from solver.scene.checking import to_table
from solver.scene.reader import find_files
from solver.study.folder import contents, with_contents

#: The word that stands for the synthetic motions.
SYNTHETIC = "synthetic"

#: Endings of the files of a folder that are taken for motions, in lower case.
MOTION_SUFFIXES = (".at2", ".txt", ".csv", ".dat", ".acc")

#: Files of a folder that are no motions whatever their ending: descriptions of the others.
IGNORED_NAMES = ("readme", "index", "license", "licence")

#: How the names of vertical components end, which a folder holds beside the horizontal ones.
VERTICAL = re.compile(r"(?:[-_.](?:up|ver|vert|ud|v)|dwn)$", re.IGNORECASE)

#: Kinds of motions of a scene of which a suite changes the file alone.
KINDS_WITH_FILE = ("record", "table")


@dataclass(frozen=True, slots=True, kw_only=True)
class SuiteMotion:
    """One motion of a suite."""

    name: str
    """What the suite calls it, and no other of its motions."""
    table: Mapping[str, Any]
    """What stands in `[motion]`, with names of files that hold in every folder."""
    held: Any = field(init=False, repr=False)
    """What it says, with digests of what its files hold instead of their names; read once."""

    def __post_init__(self) -> None:
        """Read the files."""
        object.__setattr__(self, "held", with_contents(self.table, contents(self.table)))


def find_motions(
    words: Sequence[str],
    motion: Any,
    *,
    count: int | None,
    seed: int | None,
    folder: str | Path = ".",
) -> list[SuiteMotion]:
    """The motions that a command line names.

    Args:
        words: Files, folders, `@` and a file with names of files, "synthetic"; none: "synthetic".
        motion: The `[motion]` of the scene: where it is one with a file, or says no kind (a record
            then), its other keys hold for all files.
        count: Number of synthetic motions; None: 30.
        seed: Of the synthetic motions; None: the default one.
        folder: Where relative names in that `[motion]` start from.

    Raises:
        SceneError: Something is not there.
    """
    words = words or [SYNTHETIC]
    if SYNTHETIC not in words:
        for option, value in (("--count", count), ("--seed", seed)):
            if value is not None:
                raise SceneError(option, f"{value}", f"nothing without --motions {SYNTHETIC}")
    record = {"kind": KINDS_WITH_FILE[0]}
    kept = record | dict(motion) if isinstance(motion, Mapping) else record
    if kept["kind"] not in KINDS_WITH_FILE:
        kept = record
    if any(word != SYNTHETIC for word in words):
        for direction in ("vertical", "second"):
            find_files(kept.get(direction), f"motion.{direction}", folder)
    found: list[SuiteMotion] = []
    for word in words:
        if word == SYNTHETIC:
            found += _synthetic(count, seed)
            continue
        for file in _files(word):
            table = kept | {"file": os.path.abspath(file)}
            found.append(SuiteMotion(name=file.stem, table=table))
    return list(_named_apart(found))


def _synthetic(count: int | None, seed: int | None) -> Iterator[SuiteMotion]:
    """Motions drawn inside the ranges of Table 1."""
    from solver.excitation.synthetic.table1 import table1_suite

    if count is not None and count < 1:
        raise SceneError("--count", f"{count}", "a whole number > 0")
    chosen = {"count": count, "seed": seed}
    specs = table1_suite(**{key: value for key, value in chosen.items() if value is not None})
    for number, spec in enumerate(specs, start=1):
        yield SuiteMotion(name=f"{SYNTHETIC}_{number:02d}", table=to_table(spec))


def _files(word: str) -> list[Path]:
    """The files that a word of the command line stands for."""
    if word.startswith("@"):
        return list(_listed(Path(word[1:])))
    path = Path(word)
    if not os.path.exists(path):  # unlike pathlib, says False to names that no file can have
        raise SceneError("--motions", word, "a file, a folder, @LIST, or synthetic")
    if not path.is_dir():
        return [path]
    try:
        files = sorted(file for file in path.iterdir() if _is_motion(file))
    except OSError as error:
        reason = (error.strerror or "unreadable").lower()
        raise SceneError("--motions", f"{word} ({reason})", "a folder of motions") from None
    if not files:
        allowed = f"files {', '.join(MOTION_SUFFIXES)}, not named as vertical components are (-UP)"
        raise SceneError("--motions", f"{word} without any", allowed)
    return files


def _is_motion(file: Path) -> bool:
    """Whether a file of a folder looks like a horizontal motion."""
    described = file.stem.lower() in IGNORED_NAMES or VERTICAL.search(file.stem)
    return file.suffix.lower() in MOTION_SUFFIXES and not described and not file.is_dir()


def _listed(file: Path) -> Iterator[Path]:
    """The files in a list, one name a line, relative to its folder; # begins a comment."""
    try:
        lines = file.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = (getattr(error, "strerror", None) or "no text").lower()
        raise SceneError("--motions", f"@{file} ({reason})", "a list of files") from None
    for number, line in enumerate(lines, start=1):
        name = line.split("#")[0].strip()
        if name and not os.path.exists(file.parent / name):
            raise SceneError(f"{file}: line {number}", name, "a file that exists")
        if name:
            yield file.parent / name


def _named_apart(motions: Sequence[SuiteMotion]) -> Iterator[SuiteMotion]:
    """Motions with unique names: a name that has been used before is given a number."""
    seen: set[str] = set()
    for motion in motions:
        name, number = motion.name, 1
        while name in seen:
            number += 1
            name = f"{motion.name}_{number}"
        seen.add(name)
        yield motion if number == 1 else replace(motion, name=name)
