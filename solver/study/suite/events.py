"""The events of a suite: which files are components of one earthquake at one site."""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from solver.errors import SceneError

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
"""Where components shake: "" is x, the others are keys of `[motion]`."""

MISSING = {
    "": "a horizontal component",
    "second": "a second horizontal component (motion.second)",
    "vertical": "a vertical component (motion.vertical)",
}

Item: TypeAlias = tuple[Path | None, ...]
"""One file, which is put to others by its name; or those along x, y and the vertical."""


@dataclass(frozen=True, slots=True)
class Component:
    """What the name of a file says of the component that it holds.

    Attributes:
        event: The name without the component.
        vertical: Whether it is the vertical one.
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
    """How files are put together, and which are left out."""
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
