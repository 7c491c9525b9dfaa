"""The motions of a suite: files, folders of files, lists of files, synthetic ones."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from solver.errors import SceneError
from solver.scene.checking import shown, to_table
from solver.scene.motion import COMPONENTS
from solver.study.folder import contents, with_contents
from solver.study.suite.events import DIRECTIONS, Event, Item, events_of

#: The word that stands for the synthetic motions.
SYNTHETIC = "synthetic"

#: Endings of the files of a folder that are taken for motions, in lower case.
MOTION_SUFFIXES = (".at2", ".txt", ".csv", ".dat", ".acc")

#: Files of a folder that are no motions whatever their ending: descriptions of the others.
IGNORED_NAMES = ("readme", "index", "license", "licence")

#: Kinds of motions of a scene of which a suite changes the file alone.
KINDS_WITH_FILE = ("record", "table")

#: What a scene says of its synthetic motions that is said of those of a suite, too.
KEPT_OF_SYNTHETIC = ("scale", "start", "dt")

#: What stands in a list where there is no file.
NO_FILE = "-"

WORDS = {"second": "y", "vertical": "the vertical"}


@dataclass(frozen=True, slots=True, kw_only=True)
class SuiteMotion:
    """One motion of a suite."""

    name: str
    """What the suite calls it, and no other of its motions."""
    table: Mapping[str, Any]
    """What stands in `[motion]`, with names of files that hold in every folder."""
    held: Any = field(init=False, repr=False)
    """What it says, with digests of what its files hold instead of their names; read once."""

    @property
    def beside(self) -> list[str]:
        """Keys of the components that it has besides that along x."""
        return [key for key in DIRECTIONS[1:] if key in self.table]

    def __post_init__(self) -> None:
        """Read the files."""
        object.__setattr__(self, "held", with_contents(self.table, contents(self.table)))


def find_motions(
    words: Sequence[str], motion: Any, *, count: int | None, seed: int | None
) -> tuple[list[SuiteMotion], list[str]]:
    """The motions that a command line names, and what is to be said of them.

    Each is an event with all components that the scene has: along x, and along y and the vertical
    where it has `[motion.second]` and `[motion.vertical]`.

    Args:
        words: Files, folders, `@` and a file with names of files, "synthetic"; none: "synthetic".
        motion: The `[motion]` of the scene. What tables with a file (or of no kind) say besides
            holds for all files, what synthetic ones say of `KEPT_OF_SYNTHETIC` for all synthetic
            motions, direction by direction; where a direction says nothing of the sort, what
            `[motion]` says.
        count: Number of synthetic motions; None: 30.
        seed: Of the synthetic motions; None: the default one.

    Raises:
        SceneError: Something is not there, or has not all components.
    """
    words = words or [SYNTHETIC]
    if SYNTHETIC not in words:
        for option, value in (("--count", count), ("--seed", seed)):
            if value is not None:
                raise SceneError(option, f"{value}", f"nothing without --motions {SYNTHETIC}")
    said = _directions(motion)
    beside = tuple(said)[1:]
    named = {word: _files(word) for word in words if word != SYNTHETIC}
    items = [item for word in words for item in named.get(word, ())]
    listed = (own for word, own in named.items() if not os.path.isdir(word))
    chosen = {file for own in listed for file, *_ in own}
    events, told = events_of(items, beside, chosen)
    notes = [f"motions shake along {', '.join(('x', *(WORDS[key] for key in beside)))}", *told]
    files = [_of_files(event, said) for event in events]
    made = list(_synthetic(count, seed, said)) if SYNTHETIC in words else []
    found = made + files if words[0] == SYNTHETIC else files + made
    if made and beside:
        parts = (f"{COMPONENTS[key]} along {WORDS[key]}" for key in beside)
        notes.append(f"components of each synthetic earthquake: 1 along x, {', '.join(parts)}")
    for several in (files, made):
        notes += _replaced(said, several[0].table) if several else []
    return list(_named_apart(found)), notes


def _directions(motion: Any) -> dict[str, dict[str, Any]]:
    """What the scene says of each direction in which it moves: "" is x, the others are keys.

    A table of no kind says what `[motion]` does where it says nothing itself.
    """
    given = dict(motion) if isinstance(motion, Mapping) else {}
    parts = {key: given.pop(key, None) for key in ("second", "vertical")}
    said = {"": {"kind": KINDS_WITH_FILE[0]} | given}
    for key, part in parts.items():
        if part is None or (isinstance(part, Mapping) and part.get("kind") == "none"):
            continue
        if not isinstance(part, Mapping):
            raise SceneError(f"motion.{key}", shown(part), "a table")
        said[key] = ({} if "kind" in part else said[""]) | dict(part)
    return said


def _kept(said: Mapping[str, dict[str, Any]], direction: str, kinds: Sequence[str]) -> Any:
    """What the scene says of a direction if it is of these kinds, else what it says of x."""
    own = said[direction] if said[direction]["kind"] in kinds else said[""]
    return own if own["kind"] in kinds else {"kind": kinds[0]}


def _of_files(event: Event, said: Mapping[str, dict[str, Any]]) -> SuiteMotion:
    """The motion of an event that stands in files."""
    parts = {
        key: _kept(said, key, KINDS_WITH_FILE) | {"file": os.path.abspath(file)}
        for key, file in event.files.items()
    }
    return SuiteMotion(name=event.name, table=parts.pop("") | parts)


def _synthetic(
    count: int | None, seed: int | None, said: Mapping[str, dict[str, Any]]
) -> Iterator[SuiteMotion]:
    """Motions drawn inside the ranges of Table 1; all components have one seed."""
    from solver.excitation.synthetic import table1_suite

    if count is not None and count < 1:
        raise SceneError("--count", f"{count}", "a whole number > 0")
    chosen = {"count": count, "seed": seed}
    specs = table1_suite(**{key: value for key, value in chosen.items() if value is not None})
    for number, spec in enumerate(specs, start=1):
        parts = {}
        for key in said:
            own = _kept(said, key, (SYNTHETIC,))
            component = {"component": COMPONENTS.get(key, 1)}
            kept = {name: own[name] for name in KEPT_OF_SYNTHETIC if name in own}
            parts[key] = to_table(spec) | component | kept
        yield SuiteMotion(name=f"{SYNTHETIC}_{number:02d}", table=parts.pop("") | parts)


def _replaced(said: Mapping[str, dict[str, Any]], table: Mapping[str, Any]) -> Iterator[str]:
    """What the scene says of its motion that the motions of the suite do not have from it."""
    gone = [
        f"motion.{key}.{name}" if key else f"motion.{name}"
        for key, own in said.items()
        for name in own.keys() - {"kind", "file"}
        if (table[key] if key else table).get(name) != own[name]
    ]
    if gone:
        yield f"not taken over from the scene: {', '.join(sorted(gone))}"


def _files(word: str) -> Sequence[Item]:
    """The files that a word of the command line stands for, one by one or by their directions."""
    if word.startswith("@"):
        return list(_listed(Path(word[1:])))
    path = Path(word)
    if not os.path.exists(path):  # unlike pathlib, says False to names that no file can have
        raise SceneError("--motions", word, "a file, a folder, @LIST, or synthetic")
    if not path.is_dir():
        return [(path,)]
    try:
        files = sorted(file for file in path.iterdir() if _is_motion(file))
    except OSError as error:
        reason = (error.strerror or "unreadable").lower()
        raise SceneError("--motions", f"{word} ({reason})", "a folder of motions") from None
    if not files:
        allowed = f"files {', '.join(MOTION_SUFFIXES)}"
        raise SceneError("--motions", f"{word} without any", allowed)
    return [(file,) for file in files]


def _is_motion(file: Path) -> bool:
    """Whether a file of a folder looks like a motion."""
    described = file.stem.lower() in IGNORED_NAMES
    return file.suffix.lower() in MOTION_SUFFIXES and not described and not file.is_dir()


def _listed(file: Path) -> Iterator[Item]:
    """The files in a list, relative to its folder; # begins a comment.

    A line names one file, or those along x, y and the vertical, separated by commas or, if no name
    has any, by blanks; "-" is none.
    """
    try:
        lines = file.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = (getattr(error, "strerror", None) or "no text").lower()
        raise SceneError("--motions", f"@{file} ({reason})", "a list of files") from None
    for number, line in enumerate(lines, start=1):
        name, place = line.split("#")[0].strip(), f"{file}: line {number}"
        whole = not name or os.path.exists(file.parent / name)
        names = [name] if whole else re.split(r"\s*,\s*" if "," in name else r"\s+", name)
        if len(names) > len(DIRECTIONS) or names[0] == NO_FILE:
            raise SceneError(place, name, "a file along x, then of y and the vertical, or -")
        for one in names:
            if one != NO_FILE and not os.path.exists(file.parent / one):
                raise SceneError(place, one, "a file that exists")
        if name:
            yield tuple(None if one == NO_FILE else file.parent / one for one in names)


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
