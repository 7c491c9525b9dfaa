"""References that errors are measured against: a rigid-body answer, or the limit of own ladders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.error_runtime.ladders import Trial, ladder_of, with_step
from benchmarks.error_runtime.measures import measures, scale_of
from solver.errors import SceneError
from solver.reference.answer import (
    ROCKING,
    ROCKING_ON_PLATFORM,
    reference_history,
    reference_name,
)
from solver.results.summary import summarise
from solver.scene import Scene
from solver.types import Array

#: Differences between rungs have to fall by this factor, or the ladder is not taken to converge.
LEAST_FALL = 1.3

#: No more than second order is counted on.
MOST_FALL = 4.0

#: Rows of a rigid-body answer in a step of the scene; half as many tell its uncertainty.
ROWS = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """Reference value of a measure.

    Attributes:
        value: The value, or the samples.
        uncertainty: How far the truth may be from it, over `scale`.
        scale: What errors are relative to.
        source: Where it comes from, in words.
        own: Where it is a rigid body's and the scene is meshed: distance of the limit of the
            scene's own ladders from it, over `scale`; nan where that is no more than uncertain.
    """

    value: Array
    uncertainty: float
    scale: float
    source: str
    own: float = np.nan

    @property
    def floor(self) -> float:
        """Errors below this say nothing: uncertainty, or the difference of two models."""
        return max(self.uncertainty, 0.0 if np.isnan(self.own) else self.own)

    def error(self, value: Array) -> float:
        """Relative error of a value; nan for samples that are not comparable."""
        if value.shape != self.value.shape:
            return np.nan
        return float(np.linalg.norm(value - self.value)) / self.scale


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """Limit of a ladder: its value, and how far off that may be (in the same unit)."""

    value: Array
    uncertainty: float
    converges: bool


def limit(values: Sequence[Array]) -> Limit:
    """Richardson's extrapolation from the last three of a ladder, each twice as fine.

    The fall of the differences from rung to rung tells the order, of which no more than 2 is
    counted on; the whole correction is the uncertainty, and no less than what second order would
    leave of the difference before the last, which may be small by chance. Where differences do not
    fall, or change their direction, nothing is extrapolated: the finest value stands, and the
    largest of the last differences is its uncertainty.

    Args:
        values: From the coarsest to the finest, at least two.
    """
    last = values[-1]
    latest = last - values[-2]
    moved = float(np.linalg.norm(latest))
    if len(values) < 3:
        return Limit(value=last, uncertainty=moved, converges=False)
    former = values[-2] - values[-3]
    before = float(np.linalg.norm(former))
    fall = before / moved if moved else np.inf
    if fall < LEAST_FALL or float(former @ latest) < 0:
        return Limit(value=last, uncertainty=max(moved, before), converges=False)
    rest = 1 / (min(fall, MOST_FALL) - 1)
    uncertainty = rest * max(moved, before / MOST_FALL)
    return Limit(value=last + rest * latest, uncertainty=uncertainty, converges=True)


def references(
    scene: Scene, trials: Sequence[Trial], every: float, answered_by: Scene | None = None
) -> dict[str, Reference]:
    """The best reference there is for each measure of a scene.

    A rigid-body answer, where there is one and the finest run moved as it does; of an elastic
    block that rocks it tells the first impact alone, for what an impact takes from such a block is
    no part of it. For the others the limits of the scene's own ladders of steps and of meshes.

    Args:
        scene: The scene as it is.
        trials: What was run.
        every: Between two samples of an angle, s.
        answered_by: The scene whose rigid-body answer it is; None: this one.
    """
    ladder = ladder_of(trials, "step")
    if len(ladder) < 2:
        return {}
    exact = _rigid_answer(answered_by or scene, ladder[-1], every)
    found = {}
    for measure in ladder[-1].outcome.measures:
        own = own_limit(trials, measure)
        if measure in exact:
            found[measure] = exact[measure] if scene.is_rigid else _beside(exact[measure], own)
        elif own is not None:
            found[measure] = own
    return found


def _beside(exact: Reference, own: Reference | None) -> Reference:
    """A rigid-body answer, with the distance of what the scene's own ladders go to."""
    if own is None or own.uncertainty * own.scale > exact.error(own.value) * exact.scale:
        return exact
    return replace(exact, own=exact.error(own.value))


def own_limit(trials: Sequence[Trial], measure: str) -> Reference | None:
    """Limit of the scene's own ladders, of steps and of meshes if there are such.

    The limit of the steps at the scene's mesh, and what the meshes at the scene's step still
    change; the uncertainties of both are added.
    """
    steps, goes = _limit_of_steps(trials, measure)
    meshes = _limit_of(trials, "mesh", measure)
    found = [(text, each) for text, each in ((steps, goes), ("meshes", meshes)) if each is not None]
    if not found:
        return None
    finest = found[0][1].value
    if goes is not None and meshes is not None:
        finest = finest + meshes.value - _at_scene(trials, measure)
    scale = scale_of(measure, finest)
    if scale == 0:
        return None
    sources = [text if each.converges else f"{text} (not converged)" for text, each in found]
    return Reference(
        value=finest,
        uncertainty=sum(each.uncertainty for _, each in found) / scale,
        scale=scale,
        source=f"limit of its own {' and '.join(sources)}",
    )


def _limit_of(trials: Sequence[Trial], name: str, measure: str) -> Limit | None:
    """Limit of one of the scene's own ladders; None where there are less than two such values."""
    values = [trial.outcome.measures[measure] for trial in _with(trials, name, measure)]
    if len(values) < 2 or any(value.shape != values[-1].shape for value in values[-3:]):
        return None
    return limit(values)


def _limit_of_steps(trials: Sequence[Trial], measure: str) -> tuple[str, Limit | None]:
    """Limit of the scene's steps, and which these are.

    Adaptive steps, which become much smaller where something happens, check that of fixed ones.
    Where that does not converge, or the strictest are farther from it than its uncertainty, fixed
    steps have not seen what happens: their distance is the uncertainty then, and the limit is that
    of the adaptive ones if it is less uncertain.
    """
    fixed = _limit_of(trials, "step", measure)
    strictest = [t.outcome.measures[measure] for t in _with(trials, "adaptive", measure)][-1:]
    if fixed is None or not strictest or strictest[0].shape != fixed.value.shape:
        return "steps", fixed
    off = float(np.linalg.norm(strictest[0] - fixed.value))
    if fixed.converges and off <= fixed.uncertainty:
        return "steps", fixed
    checked = replace(fixed, uncertainty=max(off, fixed.uncertainty), converges=False)
    adaptive = _limit_of(trials, "adaptive", measure)
    if adaptive is not None and adaptive.uncertainty < checked.uncertainty:
        return "adaptive steps", adaptive
    return "steps", checked


def _with(trials: Sequence[Trial], name: str, measure: str) -> list[Trial]:
    """The finest runs of a family that have a measure, without a gap."""
    found: list[Trial] = []
    for trial in reversed(ladder_of(trials, name)):
        if measure not in trial.outcome.measures:
            break
        found.insert(0, trial)
    return found


def _at_scene(trials: Sequence[Trial], measure: str) -> Array:
    """The value at the mesh of the scene itself; at the finest where that has none."""
    meshes = _with(trials, "mesh", measure)
    chosen = [trial for trial in meshes if trial.rung.size == 1.0] or meshes[-1:]
    return chosen[0].outcome.measures[measure]


def _rigid_answer(scene: Scene, finest: Trial, every: float) -> dict[str, Reference]:
    """Rigid-body answer for a scene whose block moved in its mode; empty for other scenes."""
    try:
        name = reference_name(scene)
    except SceneError:
        return {}
    rocks = name in (ROCKING, ROCKING_ON_PLATFORM)
    if finest.outcome.modes.get(scene.blocks[0].name) not in ("rest", "rock" if rocks else "slide"):
        return {}
    steps = (scene.time.step / rows for rows in (ROWS, ROWS / 2))
    try:
        fine, coarse = (_answer(scene, name, step, every) for step in steps)
    except SceneError:  # found out on the way: a block that would rock on its platform
        return {}
    told = {
        measure: Reference(
            value=value,
            uncertainty=float(np.linalg.norm(value - coarse[measure])) / scale_of(measure, value),
            scale=scale_of(measure, value),
            source=name,
        )
        for measure, value in fine.items()
        if measure in coarse and coarse[measure].shape == value.shape and scale_of(measure, value)
    }
    if rocks and not scene.is_rigid:
        return {m: r for m, r in told.items() if m.endswith("first_impact_s")}
    return told


def _answer(scene: Scene, name: str, step: float, every: float) -> Mapping[str, Array]:
    """The measures of a rigid-body answer with rows that far apart (s)."""
    changed = with_step(scene, step)
    history = reference_history(changed)
    summary = summarise(changed, history, status="completed", cost={}, versions={}, model=name)
    return measures(changed, history, summary, every)
