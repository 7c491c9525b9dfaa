"""Families of runs, each a ladder of finer and finer settings, and what climbing them gives.

Nothing here knows of scenes: whatever can be solved, timed and measured can be a rung.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median

from solver.types import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOutcome:
    """Result of one run.

    Attributes:
        measures: What it is judged by, by name; one value or many.
        loop_s: Seconds of solving, without set-up and output.
        setup_s: Seconds of set-up.
        status: "completed", or why it is of no use.
        counts: Unknowns, steps and the like, by name.
        modes: How the blocks moved, by their names.
    """

    measures: Mapping[str, Array]
    loop_s: float
    setup_s: float
    status: str = "completed"
    counts: Mapping[str, float] = field(default_factory=dict)
    modes: Mapping[str, str] = field(default_factory=dict)

    @property
    def completed(self) -> bool:
        """Whether it came to its end."""
        return self.status == "completed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """One run of a family.

    Attributes:
        setting: What is set, in words.
        size: What errors are expected to fall with: the step (s), or the size of the cells.
        work: What it takes, in relation to the others of its family.
        solve: Runs it.
    """

    setting: str
    size: float
    work: float
    solve: Callable[[], RunOutcome]


@dataclass(frozen=True, slots=True, kw_only=True)
class LadderFamily:
    """A line of the picture.

    Attributes:
        name: What it is called.
        size: What `Rung.size` is, such as "step".
        rungs: From the coarsest to the finest.
        own: Whether it solves the scene as it is, not another model of it.
    """

    name: str
    size: str
    rungs: tuple[Rung, ...]
    own: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A rung that was run, several times."""

    family: LadderFamily
    rung: Rung
    outcome: RunOutcome
    """Outcome of the first run; the others give the same numbers."""
    seconds: tuple[float, ...]
    """Seconds of every run, without set-up."""

    @property
    def loop_s(self) -> float:
        """Median of the seconds."""
        return median(self.seconds)


def climb(
    families: Sequence[LadderFamily],
    *,
    repeat: int,
    longest: float,
    tell: Callable[[Trial], None] = lambda trial: None,
) -> tuple[list[Trial], list[str]]:
    """Run all families, one run after the other; returns the runs, and what was left out.

    The first rung of a family is run once before without being counted: what is compiled or
    imported on first use is no part of its time.

    Args:
        families: What to run.
        repeat: Times that each rung is run.
        longest: Rungs that would take longer than this, by what the one before took, are left
            out, s.
        tell: Is told of every rung.
    """
    trials: list[Trial] = []
    left_out: list[str] = []
    for family in families:
        before: Trial | None = None
        for rung in family.rungs:
            expected = before.loop_s * rung.work / before.rung.work if before else 0.0
            if expected > longest:
                left_out.append(f"{family.name}, {rung.setting} (about {expected:.3g} s)")
                continue
            if before is None:
                rung.solve()
            first = rung.solve()
            again = [rung.solve().loop_s for _ in range(repeat - 1)] if first.completed else []
            trial = Trial(family=family, rung=rung, outcome=first, seconds=(first.loop_s, *again))
            trials.append(trial)
            tell(trial)
            before = trial if first.completed else before
    return trials, left_out


def ladder_of(trials: Sequence[Trial], name: str) -> list[Trial]:
    """The completed runs of a family, from the coarsest to the finest."""
    return [trial for trial in trials if trial.family.name == name and trial.outcome.completed]
