"""Whether a table is of the code that it speaks of, and if not, why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.tables.accepted import Change, changed
from benchmarks.tables.listed import Evidence
from benchmarks.tables.record import Made
from benchmarks.tables.sources import ROOT, differing, digests, of_bytes
from solver import VERSION

#: Releases (the second number of a version) that a table of times may be behind.
OLDEST_TIMES = 1

#: Processes on the machine, beside which no time means anything.
BUSY = 0.5


@dataclass(frozen=True, kw_only=True)
class State:
    """How a table stands to the code.

    Attributes:
        reasons: Why it has to be made anew; empty where it has not.
        harmless: Sources that have changed since without a table that shows it.
        busy: Whether its times were taken while something else ran.
    """

    reasons: tuple[str, ...]
    harmless: tuple[str, ...]
    busy: bool

    @property
    def stale(self) -> bool:
        """Whether it is older than the code."""
        return bool(self.reasons)

    @property
    def word(self) -> str:
        """The state in a few words."""
        times = ", times of a busy machine" if self.busy else ""
        if self.stale:
            return f"older{times}"
        return f"{'harmless changes' if self.harmless else 'up to date'}{times}"


def state(
    name: str,
    evidence: Evidence,
    made: Made | None,
    changes: Sequence[Change],
    root: Path = ROOT,
) -> State:
    """The state of a table."""
    if made is None:
        return State(reasons=("no record",), harmless=(), busy=False)
    now = digests(evidence.code, root)
    older = changed(name, made.code, now, changes)
    reasons = [f"changed: {source}" for source in older]
    if evidence.timed and releases_behind(made.version) > OLDEST_TIMES:
        reasons.append(f"times of version {made.version}")
    files = {file: of_bytes(root / file) for file in evidence.files}
    reasons += [f"not as recorded: {file}" for file in differing(made.files, files)]
    return State(
        reasons=tuple(reasons),
        harmless=tuple(source for source in differing(made.code, now) if source not in older),
        busy=evidence.timed and made.load > BUSY,
    )


def states(
    evidence: Mapping[str, Evidence], record: Mapping[str, Made], changes: Sequence[Change]
) -> dict[str, State]:
    """The state of every table, by name."""
    return {name: state(name, one, record.get(name), changes) for name, one in evidence.items()}


def releases_behind(version: str, today: str = VERSION) -> int:
    """Releases between two versions; a first number that differs is many."""
    (major, minor), (now_major, now_minor) = (
        [int(number) for number in f"{text}.0".split(".")[:2]] for text in (version, today)
    )
    return now_minor - minor if major == now_major else 1000
