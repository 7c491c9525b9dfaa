"""The motions of a suite: files, folders and lists of files, synthetic ones.

Files of one event are components of one earthquake at one site.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from solver.errors import SceneError
from solver.scene.checking import shown, to_table
from solver.scene.motion import COMPONENTS
from solver.study.study import with_digests

#: The word that stands for the synthetic motions.
SYNTHETIC = "synthetic"

#: Endings of the files of a folder that are taken for motions, in lower case.
MOTION_SUFFIXES = (".at2", ".txt", ".csv", ".dat", ".acc")

#: Files of a folder that are no motions whatever their ending: descriptions of the others.
IGNORED_NAMES = ("readme", "index", "license", "licence")

#: Kinds of motions of a scene of which a suite changes the file alone.
KINDS_WITH_FILE = ("record", "table")

#: Keys of the synthetic motions of a scene that hold for those of a suite, too.
KEPT_OF_SYNTHETIC = ("scale", "start", "dt")

#: What stands in a list where there is no file.
NO_FILE = "-"

WORDS = {"second": "y", "vertical": "the vertical"}

#: How names end that are those of a component: vertical, a bearing, degrees from north, letters.
#: What follows them is PEER's mark of an older processing.
COMPONENT = re.compile(
    r"(?:(?P<up>[-_. ]?DWN|[-_. ](?:UP|VERT?|UD|V|Z)|(?-i:(?<=[A-Z\d])UP))"
    r"|(?P<bearing>[NS]\d\d[EW])"
    r"|[-_. ]?(?P<azimuth>[0-2]\d\d|3[0-5]\d|360)"
    r"|[-_. ](?P<letter>NS|EW|N|E|X|Y|H1|H2|L|T))(?P<rest>_p\d+)?$",
    re.IGNORECASE,
)

FIRST_LETTERS = ("NS", "N", "X", "H1", "L")
"""Letters of the component that shakes along x."""

SQUARE = math.cos(math.radians(85))
"""Components whose azimuths are farther from a right angle than 5 degrees are no pair."""

ALLOWED = "files as NAME_000, NAME_090, NAME_UP, or @LIST of x, y, vertical"

DIRECTIONS = ("", "second", "vertical")
"""Directions of components: "" is x, the others are keys of `[motion]`."""

MISSING = {
    "": "a horizontal component",
    "second": "a second horizontal component (motion.second)",
    "vertical": "a vertical component (motion.vertical)",
}

Item: TypeAlias = tuple[Path | None, ...]
"""One file, which is put to others by its name; or those along x, y and the vertical."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SuiteMotion:
    """One motion of a suite."""

    name: str
    """Its own in the suite."""
    table: Mapping[str, Any]
    """The table `[motion]`, with names of files that hold in every folder."""
    held: Any = field(init=False, repr=False)
    """The table with digests of its files in place of their names; read once."""

    @property
    def beside(self) -> list[str]:
        """Keys of the components that it has besides that along x."""
        return [key for key in DIRECTIONS[1:] if key in self.table]

    def __post_init__(self) -> None:
        """Read the files."""
        object.__setattr__(self, "held", with_digests(self.table))


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
    """The tables of the scene for each direction in which it moves: "" is x, the others are keys.

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
    """The table of a direction if it is of these kinds, else that of x."""
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
    """A note on the keys of the scene's motion that those of the suite do not have from it."""
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
    if not os.path.exists(path):  # unlike pathlib, False for names that no file can have
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
    """True if a file of a folder looks like a motion."""
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


@dataclass(frozen=True, slots=True)
class Component:
    """The component that a file holds, by its name.

    Attributes:
        event: The name without the component.
        vertical: True for the vertical one.
        azimuth: From the one that shakes along x, or from north, degrees; None: not said.
    """

    event: str
    vertical: bool = False
    azimuth: float | None = None

    @classmethod
    def of(cls, stem: str) -> Component:
        """The component of a name without its ending."""
        found = COMPONENT.search(stem)
        if found is None or found.start() == 0:
            return cls(stem)
        event = stem[: found.start()] + (found["rest"] or "")
        if found["up"]:
            return cls(event, vertical=True)
        if found["bearing"]:
            side = found["bearing"].upper()
            azimuth = float(side[1:3]) if side[0] == "N" else 180 - float(side[1:3])
            return cls(event, azimuth=azimuth if side[3] == "E" else -azimuth % 360)
        if found["letter"]:
            return cls(event, azimuth=0.0 if found["letter"].upper() in FIRST_LETTERS else 90.0)
        return cls(event, azimuth=float(found["azimuth"]) % 360)


@dataclass(frozen=True, slots=True)
class Event:
    """Files of one event by their directions."""

    name: str
    files: dict[str, Path]


@dataclass(slots=True)
class _Recording:
    """Files whose names are those of one event, with their azimuths, and the vertical ones."""

    event: str
    horizontal: dict[Path, float | None] = field(default_factory=dict)
    vertical: dict[Path, None] = field(default_factory=dict)

    def up(self, beside: Sequence[str]) -> dict[str, Path]:
        """The vertical component, where the scene has one and there is one."""
        if "vertical" not in beside:
            return {}
        if len(self.vertical) > 1:
            got = f"{self.event} with {_named(self.vertical)}"
            raise SceneError("--motions", got, "one vertical component")
        return {"vertical": file for file in self.vertical}

    def pair(self) -> dict[str, Path]:
        """The components along x and y, as far as there are such, by their azimuths."""
        if len(self.horizontal) < 2:
            return {"": file for file in self.horizontal}
        one, other = sorted(self.horizontal.items(), key=lambda item: item[1] or 0.0)[:2]
        azimuths = [azimuth for azimuth in self.horizontal.values() if azimuth is not None]
        square = len(azimuths) == 2 and abs(math.cos(math.radians(np.ptp(azimuths)))) < SQUARE
        if len(self.horizontal) > 2 or not square:
            allowed = "two horizontal components at a right angle, by the azimuths in their names"
            raise SceneError("--motions", f"{self.event} with {_named(self.horizontal)}", allowed)
        return {"": one[0], "second": other[0]}


def events_of(
    items: Sequence[Item], beside: Sequence[str], chosen: Container[Path | None]
) -> tuple[list[Event], list[str]]:
    """The events that files make, in their order, and what is to be said of them.

    Args:
        items: Files one by one, or by their directions.
        beside: What the scene has besides x: "second", "vertical".
        chosen: Files that were named themselves: where the scene has nothing besides x, they are
            taken as they are, whatever their name says.

    Raises:
        SceneError: An event has not what the scene has, or more than one file for it.
    """
    recordings: dict[tuple[Path, str], _Recording] = {}
    alone = [file for file, *others in items if file is not None and not others]
    for file in alone:
        named = Component.of(file.stem)
        own = recordings.setdefault((file.parent, named.event), _Recording(named.event))
        if named.vertical and (beside or file not in chosen):
            own.vertical[file] = None
        else:
            own.horizontal[file] = named.azimuth
    found = list(_events(items, recordings, beside))
    lacks = [(e.name, MISSING[d]) for e in found for d in ("", *beside) if d not in e.files]
    if lacks:
        others = len({name for name, _ in lacks}) - 1
        more = f", and {others} more events" if others else ""
        raise SceneError("--motions", f"{lacks[0][0]} without {lacks[0][1]}{more}", ALLOWED)
    if items and not found:
        raise SceneError("--motions", f"{_named(alone)}: vertical alone", "a horizontal component")
    rows = [dict(zip(DIRECTIONS, item, strict=False)) for item in items if len(item) > 1]
    return found, list(_notes(recordings.values(), rows, beside))


def _events(
    items: Sequence[Item], recordings: Mapping[tuple[Path, str], _Recording], beside: Sequence[str]
) -> Iterator[Event]:
    """The events with the files that there are for them."""
    done: list[_Recording] = []
    for along, *others in items:
        assert along is not None  # the first one always is a file
        if others:
            files = dict(zip(DIRECTIONS[1:], others, strict=False))
            yield Event(along.stem, {"": along, **{d: f for d, f in files.items()
                                                   if f is not None and d in beside}})  # fmt: skip
            continue
        own = recordings[along.parent, Component.of(along.stem).event]
        if "second" in beside:
            if own not in done:
                done.append(own)
                yield Event(own.event.rstrip("-_. "), own.pair() | own.up(beside))
        elif along in own.horizontal:
            yield Event(along.stem, {"": along} | own.up(beside))
        elif not own.horizontal and "vertical" in beside:
            yield Event(own.event, own.up(beside))


def _notes(
    recordings: Iterable[_Recording], rows: Sequence[dict[str, Path | None]], beside: Sequence[str]
) -> Iterator[str]:
    """Notes on how files are put together, and on those that are left out."""
    several = [own for own in recordings if len(own.horizontal) > 1]
    if several and "second" in beside:
        yield (
            "events are put together by the names of files: of two horizontal components the one "
            "of the smaller azimuth (360 is 0) shakes along x, the other one along y"
        )
    elif several:
        yield (
            f"{sum(len(own.horizontal) for own in several)} horizontal components of "
            f"{len(several)} recordings: each is an event of its own along x, for the scene has "
            "no [motion.second]"
        )
    up = [file for own in recordings for file in own.vertical]
    for direction, named in (("second", []), ("vertical", up)):
        left = [*named, *(row[direction] for row in rows if row.get(direction))]
        if left and direction not in beside:
            yield f"left out, for the scene has no [motion.{direction}]: {_named(left)}"
    down = [file for file in up if file.stem.upper().endswith("DWN")]
    if down and "vertical" in beside:
        yield f"taken as it stands, positive upwards: {_named(down)}"


def _named(files: Iterable[Any]) -> str:
    """Names of the first files, and how many there are."""
    names = [file.name for file in files]
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(names[:3]) + more
