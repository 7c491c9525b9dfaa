"""Ladders of runs, each finer than the one before: what climbing them gives, and those of a scene.

Whatever can be solved, timed and measured can be a rung. A scene has ladders of its step,
tolerance, mesh, degree, contact points, rho_inf and model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from statistics import median
from typing import Any, Literal

from solver.errors import SceneError
from solver.scene import Scene
from solver.scene.cells import refined
from solver.scene.checking import nearest, shown
from solver.types import Array

Solve = Callable[[Any], "RunOutcome"]

Variant = tuple[str, float, float, Any]
"""What is set, in words; what errors fall with; what it takes; the scene, or what else is run."""

#: Steps of a ladder begin with this times that of the scene, and are halved from there.
COARSEST_STEP_RATIO = 4.0

#: Ladders of what is no refinement (points, rho_inf, model) have so many rungs less.
FEWER = 2

#: Cells along an edge, over those of the scene.
REFINEMENTS = (0.5, 1.0, 2.0)

#: Values of rho_inf besides that of the scene.
RHOS = (0.0, 0.5, 1.0)

#: Tolerances of adaptive steps, over that of the scene or the default.
TOLERANCES = (16.0, 4.0, 1.0, 0.25)

#: What `--families` takes.
NAMES = ("step", "adaptive", "mesh", "degree", "points", "rho_inf", "model")


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
        """True if it came to its end."""
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
        own: True if it solves the scene as it is, not another model of it.
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
        tell: Called for every rung.
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


def families(scene: Scene, names: Sequence[str], rungs: int, solve: Solve) -> list[LadderFamily]:
    """The families that are asked for, those that the scene has something for.

    Args:
        scene: Where they start.
        names: Of `NAMES`; "step" comes first whether it is among them or not.
        rungs: Of the ladder of steps.
        solve: Runs a scene.
    """
    adaptive, scene = scene, with_step(scene, scene.time.step)
    fewer = max(2, rungs - FEWER)
    made = [ladder("step", "step", steps(scene, rungs), solve)]
    meshed = not scene.is_rigid
    elastic = any(block.model == "elastic" for block in scene.blocks)
    if "adaptive" in names and meshed:
        made.append(ladder("adaptive", "tolerance", _tolerances(adaptive), solve))
    if "mesh" in names and meshed:
        made.append(ladder("mesh", "cells", meshes(scene), solve))
    if "degree" in names and meshed:
        degree: Literal[1, 2] = 1 if scene.blocks[0].degree == 2 else 2
        if (changed := _of_degree(scene, degree)) is not None:
            made.append(ladder(f"degree {degree}", "cells", meshes(changed), solve))
    if "points" in names and elastic:
        points: Literal["nodes", "gauss"] = "gauss" if scene.contact.points == "nodes" else "nodes"
        changed = replace(scene, contact=replace(scene.contact, points=points))
        made.append(ladder(f"points {points}", "step", steps(changed, fewer), solve))
    if "rho_inf" in names and (meshed or scene.has_platform or scene.motion is not None):
        for rho in (rho for rho in RHOS if rho != scene.time.rho_inf):
            changed = replace(scene, time=replace(scene.time, rho_inf=rho))
            made.append(ladder(f"rho_inf {rho:g}", "step", steps(changed, fewer), solve))
    known = all(block.young is not None and block.poisson is not None for block in scene.blocks)
    if "model" in names and (elastic or known):
        model: Literal["elastic", "rigid"] = "rigid" if elastic else "elastic"
        changed = replace(scene, blocks=tuple(replace(b, model=model) for b in scene.blocks))
        made.append(ladder(f"{model} blocks", "step", steps(changed, fewer), solve, own=False))
    return made


def check_names(names: Sequence[str]) -> None:
    """Refuse names that are those of no family."""
    for name in names:
        if name not in NAMES:
            raise SceneError("--families", shown(name), ", ".join(NAMES), nearest(name, NAMES))


def coarsest_step(scene: Scene) -> float:
    """The largest step of the ladders, s."""
    return min(COARSEST_STEP_RATIO * scene.time.step, scene.time.end)


def ladder(
    name: str, size: str, variants: Iterable[Variant], solve: Solve, *, own: bool = True
) -> LadderFamily:
    """A family of variants, from the coarsest to the finest; arguments as its own."""
    rungs = (
        Rung(setting=setting, size=number, work=work, solve=partial(solve, what))
        for setting, number, work, what in variants
    )
    return LadderFamily(name=name, size=size, rungs=tuple(rungs), own=own)


def steps(scene: Scene, rungs: int) -> Iterator[Variant]:
    """Variants with other steps, each half of the one before."""
    for level in range(rungs):
        step = coarsest_step(scene) / 2**level
        yield f"step {step:g} s", step, 1 / step, with_step(scene, step)


def with_step(scene: Scene, step: float) -> Scene:
    """The scene with another step, fixed; its smallest one is the same part of it."""
    smallest = scene.time.smallest / scene.time.step * step
    fixed = replace(scene.time, adaptive=False, tolerance=None, largest=None)
    return replace(scene, time=replace(fixed, step=step, smallest=smallest))


def _tolerances(scene: Scene) -> Iterator[Variant]:
    """Variants with adaptive steps, none longer than those of the ladders of steps."""
    span = replace(scene.time, adaptive=True)
    largest = max(coarsest_step(scene), span.step)
    for factor in TOLERANCES:
        tolerance = factor * (span.tolerance or math.nan)  # adaptive: it has one
        time = replace(span, tolerance=tolerance, largest=largest)
        work = factor ** (-1 / 3)  # the error of a step falls with its cube
        yield f"tolerance {tolerance:g}", tolerance, work, replace(scene, time=time)


def meshes(scene: Scene) -> Iterator[Variant]:
    """Variants with other meshes, at the step of the scene."""
    seen = list[Scene]()
    for factor in REFINEMENTS:
        changed = _refined(scene, factor)
        if changed not in seen:  # one cell cannot be halved
            seen.append(changed)
            yield _cells(changed), 1 / factor, factor**scene.dimension, changed


def _cells(scene: Scene) -> str:
    """The mesh of the first meshed body, in words."""
    bodies = [block for block in scene.blocks if block.model == "elastic"]
    body: Any = bodies[0] if bodies else scene.foundation
    cells = body.cells
    return (
        f"cells {' x '.join(map(str, cells))}" if isinstance(cells, tuple) else "cells of the frame"
    )


def _refined(scene: Scene, factor: float) -> Scene:
    """The scene with so many times the cells along every edge."""

    def times(count: int) -> int:
        return max(1, round(factor * count))

    blocks = tuple(replace(block, cells=refined(block.cells, times)) for block in scene.blocks)
    return replace(scene, blocks=blocks, foundation=scene.foundation.refined(times))


def _of_degree(scene: Scene, degree: Literal[1, 2]) -> Scene | None:
    """The scene with elements of a degree; None where it does not allow it."""
    blocks = tuple(replace(block, degree=degree) for block in scene.blocks)
    try:
        foundation: Any = scene.foundation
        if foundation.kind == "elastic":
            foundation = replace(foundation, degree=degree)
        return replace(scene, blocks=blocks, foundation=foundation)
    except SceneError:
        return None
