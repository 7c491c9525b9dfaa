"""Changes that no table can show, and tables that are known to be older than the code."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.tables.sources import Digests, differing

HARMLESS = Path(__file__).with_name("harmless.toml")
KNOWN_STALE = Path(__file__).with_name("known_stale.toml")

HARMLESS_HEAD = """\
# Changes of code that the named tables do not show, each with what says so. Written by
#
#     ./in-env python3 -m benchmarks.tables NAME ... --harmless "WHY, and what was compared"
#
# which takes the digests as they were accepted last and as they are now. Changes that follow on
# each other make a chain. What no record needs any more is removed when a table is made.
"""

STALE_HEAD = """\
# Tables and pictures that are known to be older than the code, and why nothing is done about it
# yet. `./in-env python3 -m benchmarks.tables --known-stale WHY` adds those that are; a table that
# is made anew is taken out.
"""


@dataclass(frozen=True, kw_only=True)
class Change:
    """A change of a source that some tables do not show.

    Attributes:
        source: File or folder.
        before: Its digest before the change.
        after: Its digest after it.
        tables: Names of those for which this is true.
        why: What says so: what was run again and compared, or why nothing can differ.
    """

    source: str
    before: str
    after: str
    tables: tuple[str, ...]
    why: str


def harmless(file: Path = HARMLESS) -> list[Change]:
    """The stated changes, the latest at the end."""
    found = tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}
    return [
        Change(**{**entry, "tables": tuple(entry["tables"])}) for entry in found.get("change", [])
    ]


def known_stale(file: Path = KNOWN_STALE) -> dict[str, str]:
    """Tables that are known to be older than the code, and why nothing is done about it yet."""
    found = tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}
    return {name: str(why) for name, why in found.items()}


def reached(name: str, source: str, digest: str, changes: Iterable[Change]) -> list[str]:
    """Digests of a source that are as good as the recorded one for a table, that one first."""
    known = [digest]
    own = [c for c in changes if c.source == source and name in c.tables]
    for before in known:
        known += [c.after for c in own if c.before == before and c.after not in known]
    return known


def changed(name: str, before: Digests, now: Digests, changes: Sequence[Change]) -> list[str]:
    """Sources that a table is older than: those that differ, but for harmless changes."""
    return [
        source
        for source in differing(before, now)
        if now.get(source) not in reached(name, source, before.get(source, ""), changes)
    ]


def state_harmless(
    why: str,
    tables: Sequence[tuple[str, Digests, Digests]],
    changes: Sequence[Change],
) -> list[Change]:
    """The changes with one more for each source that differs; returns all.

    Args:
        why: What says that the tables do not show it.
        tables: Their names, the digests of their records, and those of today.
        changes: Those that are stated already.
    """
    meant: dict[tuple[str, str, str], list[str]] = {}
    for name, before, now in tables:
        for source in changed(name, before, now, changes):
            last = reached(name, source, before.get(source, ""), changes)[-1]
            meant.setdefault((source, last, now.get(source, "")), []).append(name)
    more = [
        Change(source=source, before=before, after=after, tables=tuple(names), why=why)
        for (source, before, after), names in meant.items()
    ]
    return [*changes, *more]


def needed(changes: Sequence[Change], recorded: Sequence[tuple[str, Digests]]) -> list[Change]:
    """The changes without those that no record leads to, for any of their tables."""
    kept = []
    for change in changes:
        names = [
            name
            for name, code in recorded
            if name in change.tables
            and change.before in reached(name, change.source, code.get(change.source, ""), changes)
        ]
        if names:
            kept.append(Change(**{**asdict(change), "tables": tuple(names)}))
    return kept


def write(changes: Sequence[Change], file: Path = HARMLESS) -> None:
    """Write the stated changes."""
    import tomli_w

    entries = [{**asdict(change), "tables": list(change.tables)} for change in changes]
    text = tomli_w.dumps({"change": entries}) if entries else ""
    file.write_text(f"{HARMLESS_HEAD}\n{text}", encoding="utf-8")


def write_known_stale(known: Mapping[str, str], file: Path = KNOWN_STALE) -> None:
    """Write which tables are known to be older than the code."""
    import tomli_w

    file.write_text(f"{STALE_HEAD}\n{tomli_w.dumps(dict(known))}", encoding="utf-8")
