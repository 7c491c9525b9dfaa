"""Ladders of runs, each finer than the one before: what climbing them gives, and those of a scene.

Whatever can be solved, timed and measured can be a rung. A scene has ladders of its step,
tolerance, mesh, degree, contact points, rho_inf and model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from statistics import median
from typing import Any, Literal

from solver.errors import SceneError
from solver.scene import Scene
from solver.scene.cells import refined
from solver.scene.checking import nearest, shown
from solver.types import Array

Solve = Callable[[Scene], "RunOutcome"]

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
    made = [steps("step", scene, rungs, solve)]
    meshed = not scene.is_rigid
    elastic = any(block.model == "elastic" for block in scene.blocks)
    if "adaptive" in names and meshed:
        made.append(_tolerances(adaptive, solve))
    if "mesh" in names and meshed:
        made.append(meshes("mesh", scene, solve))
    if "degree" in names and meshed:
        made += _other_degree(scene, solve)
    if "points" in names and elastic:
        other: Literal["nodes", "gauss"]
        other = "gauss" if scene.contact.points == "nodes" else "nodes"
        changed = replace(scene, contact=replace(scene.contact, points=other))
        made.append(steps(f"points {other}", changed, fewer, solve))
    if "rho_inf" in names and (meshed or scene.has_platform or scene.motion is not None):
        for rho in (rho for rho in RHOS if rho != scene.time.rho_inf):
            changed = replace(scene, time=replace(scene.time, rho_inf=rho))
            made.append(steps(f"rho_inf {rho:g}", changed, fewer, solve))
    if "model" in names:
        made += _other_model(scene, fewer, solve)
    return made


def check_names(names: Sequence[str]) -> None:
    """Refuse names that are those of no family."""
    for name in names:
        if name not in NAMES:
            raise SceneError("--families", shown(name), ", ".join(NAMES), nearest(name, NAMES))


def coarsest_step(scene: Scene) -> float:
    """The largest step of the ladders, s."""
    return min(COARSEST_STEP_RATIO * scene.time.step, scene.time.end)


def steps(name: str, scene: Scene, rungs: int, solve: Solve, *, own: bool = True) -> LadderFamily:
    """A ladder of steps, each half of the one before."""
    found = []
    for level in range(rungs):
        step = coarsest_step(scene) / 2**level
        changed = with_step(scene, step)
        found.append(Rung(
            setting=f"step {step:g} s", size=step, work=1 / step, solve=partial(solve, changed)
        ))  # fmt: skip
    return LadderFamily(name=name, size="step", rungs=tuple(found), own=own)


def with_step(scene: Scene, step: float) -> Scene:
    """The scene with another step, fixed; its smallest one is the same part of it."""
    smallest = scene.time.smallest / scene.time.step * step
    fixed = replace(scene.time, adaptive=False, tolerance=None, largest=None)
    return replace(scene, time=replace(fixed, step=step, smallest=smallest))


def _tolerances(scene: Scene, solve: Solve) -> LadderFamily:
    """A ladder of tolerances of adaptive steps, none longer than those of the ladders of steps."""
    span, found = replace(scene.time, adaptive=True), []
    largest = max(coarsest_step(scene), span.step)
    for factor in TOLERANCES:
        tolerance = factor * (span.tolerance or math.nan)  # adaptive: it has one
        changed = replace(scene, time=replace(span, tolerance=tolerance, largest=largest))
        rung = Rung(
            setting=f"tolerance {tolerance:g}",
            size=tolerance,
            work=factor ** (-1 / 3),  # the error of a step falls with its cube
            solve=partial(solve, changed),
        )
        found.append(rung)
    return LadderFamily(name="adaptive", size="tolerance", rungs=tuple(found))


def meshes(name: str, scene: Scene, solve: Solve) -> LadderFamily:
    """A ladder of meshes, at the step of the scene."""
    found, seen = [], []
    for factor in REFINEMENTS:
        changed = _refined(scene, factor)
        if changed in seen:  # one cell cannot be halved
            continue
        seen.append(changed)
        found.append(Rung(
            setting=_cells(changed),
            size=1 / factor,
            work=factor**scene.dimension,
            solve=partial(solve, changed),
        ))  # fmt: skip
    return LadderFamily(name=name, size="cells", rungs=tuple(found))


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


def _other_degree(scene: Scene, solve: Solve) -> list[LadderFamily]:
    """The ladder of meshes with the other degree; none where the scene does not allow it."""
    other: Literal[1, 2] = 1 if scene.blocks[0].degree == 2 else 2
    blocks = tuple(replace(block, degree=other) for block in scene.blocks)
    try:
        foundation: Any = scene.foundation
        if foundation.kind == "elastic":
            foundation = replace(foundation, degree=other)
        changed = replace(scene, blocks=blocks, foundation=foundation)
    except SceneError:
        return []
    return [meshes(f"degree {other}", changed, solve)]


def _other_model(scene: Scene, rungs: int, solve: Solve) -> list[LadderFamily]:
    """A ladder of steps with the other model, where the scene says what that one needs."""
    elastic = any(block.model == "elastic" for block in scene.blocks)
    other: Literal["elastic", "rigid"] = "rigid" if elastic else "elastic"
    if other == "elastic" and any(b.young is None or b.poisson is None for b in scene.blocks):
        return []
    blocks = tuple(replace(block, model=other) for block in scene.blocks)
    return [steps(f"{other} blocks", replace(scene, blocks=blocks), rungs, solve, own=False)]
