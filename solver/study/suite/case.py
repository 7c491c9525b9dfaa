"""One case of a suite: a scene under one motion, run beside the rigid-body answer."""

from __future__ import annotations

import itertools
import math
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solver.errors import SceneError
from solver.scene import Scene, parse_scene
from solver.scene.checking import shown
from solver.study.suite.engines import ODE, equation, with_model
from solver.study.suite.intensity import Intensity
from solver.study.suite.motions import SuiteMotion

if TYPE_CHECKING:
    from solver.excitation.motion import GroundMotion

#: What is compared with the reference: the key of the summary, and the name of the ratio.
COMPARED = {
    "peak_drift_m": "peak_drift_ratio",
    "peak_slip_m": "peak_slip_ratio",
    "peak_angle_rad": "peak_angle_ratio",
}


#: What is kept of the summary of a block, where it is there (turns are in space).
KEPT = (
    *("peak_slip_m", "peak_slip_while_standing_m", "residual_slip_m"),
    *("peak_displacement_m", "residual_displacement_m", "peak_turn_rad", "residual_turn_rad"),
    *("peak_angle_rad", "peak_angle_while_standing_rad"),
    *("peak_angle_over_alpha", "peak_angle_over_alpha_while_standing"),
    *("mode", "overturned_at_s", "fell_at_s"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class SuiteCase:
    """Case of a suite, as one process is given it."""

    name: str
    """What the suite calls it, and no other case; also the name of its file."""
    motion: SuiteMotion
    """The motion."""
    varied: tuple[tuple[str, str], ...]
    """Keys and values, as text, that differ from case to case."""
    engine: str | None = None
    """What answers, one of `ENGINES`; None: the scene as it stands."""
    level: float | None = None
    """Intensity that the motion is scaled to; None: it stays as it is."""
    intensity: Intensity | None = None
    """The measure of the level."""
    tables: Mapping[str, Any]
    """The scene as plain tables."""
    folder: Path
    """Where the relative names of the scene start from."""
    tail: float
    """How long the run goes on after the motion, s."""
    reference: bool
    """Whether the rigid-body answer is computed, too."""
    keep: Path | None
    """Folder for all files of the run; None: none are written."""


def variations(words: Sequence[str]) -> Iterator[tuple[tuple[str, str], ...]]:
    """Every combination of the values in `KEY=VALUE,VALUE...`."""
    ladders = []
    for word in words:
        key, _, text = word.partition("=")
        values = [value.strip() for value in text.split(",")]
        if not key.strip() or not all(values) or len(set(values)) < len(values):
            allowed = "KEY=VALUE,VALUE..., such as contact.friction=0.1,0.2"
            raise SceneError("--vary", shown(word), allowed)
        ladders.append([(key.strip(), value) for value in values])
    if len({ladder[0][0] for ladder in ladders}) < len(ladders):
        raise SceneError("--vary", "one key twice", "each key once")
    yield from itertools.product(*ladders)


def scene_of(case: SuiteCase) -> tuple[Scene, GroundMotion]:
    """The scene of a case, which ends with its motion, and the motion of the ground."""
    from solver.excitation.motion import read_ground
    from solver.results.endings import motion_end

    tables = with_model(case.tables, case.engine) | {"motion": dict(case.motion.table)}
    sets = [f"{key}={value}" for key, value in case.varied]
    scene = parse_scene(tables, folder=case.folder, overrides=sets)
    ground = read_ground(scene)
    if case.level is not None and case.intensity is not None:
        scene = _scaled(scene, case.level / case.intensity.of_ground(ground))
        ground = read_ground(scene)
    time = scene.time
    if ground.along is None:  # no motion of a suite is one of these
        raise SceneError("motion", "nothing that moves", "a motion along x")
    # Whole steps: a last, shorter one would need factorizations of its own.
    end = math.ceil((motion_end(ground) + case.tail) / time.step * (1 - 1e-9)) * time.step
    return replace(scene, time=replace(time, end=end)), ground


def _scaled(scene: Scene, factor: float) -> Scene:
    """A scene under a stronger motion, by the same factor in all directions.

    It ends once a block has overturned: what comes then does not tell how strong the motion was.
    """
    assert scene.motion is not None
    time = replace(scene.time, stop="overturned")
    return replace(scene, motion=scene.motion.times(factor), time=time)


def run_case(case: SuiteCase) -> dict[str, Any]:
    """Run a case on one process; its row of the table, without name, motion and varied keys.

    Raises:
        SceneError: The motion or a varied value is bad input.
    """
    from mpi4py import MPI

    from solver.run.simulate import simulate

    scene, ground = scene_of(case)
    if case.engine == ODE:
        return equation(scene, ground)
    if case.keep is not None:
        shutil.rmtree(case.keep, ignore_errors=True)  # what an interrupted suite left
    result = simulate(scene, folder=case.keep, comm=MPI.COMM_SELF, ground=ground, many=True)
    summary = result.summary
    measures = _measures(summary)
    row = {
        "status": result.status,
        "reason": summary["reason"],
        "end_s": summary["end_s"],
        **_peaks(scene, ground),
        **measures,
    }
    if case.reference:
        try:
            row |= _compared(measures, _reference(scene, ground))
        except SceneError as error:
            row["reason"] = f"no reference, {error}"
    energy, cost = summary["energy"], summary["cost"]
    return row | {
        "largest_gain_fraction": energy["largest_gain_fraction"],
        "ledger_error_fraction": energy["ledger_error_fraction"],
        "steps": cost["steps"],
        "rejected_steps": cost["rejected_steps"],
        "wall_s": cost["wall_s"],
        "cautions": "; ".join(summary["cautions"]),
    }


def _peaks(scene: Scene, ground: GroundMotion) -> dict[str, float]:
    """The largest acceleration of each component of the motion, g."""
    from solver.scene.motion import G_UNIT

    parts = dict(zip(scene.directions, ground.parts, strict=True))
    return {
        f"pga{where.removeprefix('motion').replace('.', '_')}_g": part.peak / G_UNIT
        for where, part in parts.items()
        if part is not None
    }


def _measures(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Measures that are kept of a summary: peaks, residual slips, modes."""
    found: dict[str, Any] = {}
    platform = summary.get("platform", {})
    for key in ("peak_drift_m", "peak_drift_second_m"):
        if key in platform:
            found[f"platform.{key}"] = platform[key]
    for name, block in summary["blocks"].items():
        found |= {f"{name}.{key}": block[key] for key in KEPT if key in block}
    return found


def _reference(scene: Scene, ground: GroundMotion) -> dict[str, Any]:
    """Measures of the rigid-body answer."""
    from solver.reference.answer import reference_history
    from solver.results.summary import summarise

    history = reference_history(scene, ground=ground)
    return _measures(summarise(scene, history, status="completed", cost={}, versions={}))


def _compared(found: Mapping[str, Any], reference: Mapping[str, Any]) -> dict[str, Any]:
    """The measures of the reference, and the ratios to those that are not zero."""
    row = {f"reference.{key}": value for key, value in reference.items()}
    for key, value in found.items():
        owner, _, measure = key.rpartition(".")
        if measure in COMPARED and reference[key]:
            row[f"{owner}.{COMPARED[measure]}"] = value / reference[key]
    return row
