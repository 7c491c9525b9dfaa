"""The runs of the study: each known by the hash of what it computes, and never computed twice."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from solver import VERSION
from solver.errors import NotConverged, Statement
from solver.scene import parse_scene
from solver.study.inertia.cells import Cell, Structure, tables_of
from solver.study.inertia.portion import grid
from solver.study.suite.case import SuiteCase, scene_of
from solver.study.suite.motions import SuiteMotion

CURVE, BARE = "curve", "bare"
"""Runs of the structure with portions of the live load fixed to it, and without live load."""

TOP, RATIO = 4, 1.25
"""The ladder of friction by which lambda is followed goes down from 1.25^4 in such ratios."""

TOGETHER = 10
"""Motions that one process is given at a time."""

ENGINES = {"rigid": "rigid blocks", "elements": "finite elements"}
"""Ways to compute the drift besides the closed form, and what they are called."""

_CLOSED = ("scene", "excitation", "reference")
_BLOCKS = (
    *("scene", "excitation", "law", "scheme", "history", "bodies", "contact", "stepping"),
    *("rigid", "build", "results", "run"),
)


@cache
def code(closed: bool) -> str:
    """The version of the code that runs depend on: its number, and a digest of its sources."""
    from solver.law.compiled import digest

    root = Path(__file__).parents[2]
    folders = [root / name for name in (_CLOSED if closed else _BLOCKS)]
    sources = digest(folders if closed else [*folders, root.parent / "geometry"])
    own = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
    return f"{VERSION}-{_hash([sources, own])[:12]}"


def _hash(said: Any) -> str:
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()[:20]


def content_of(motion: SuiteMotion) -> str:
    """Hash of what a motion says and of its files, not of their names."""
    return _hash(motion.held)


def closed_key(structure: Structure, what: str | float, motion: str) -> str:
    """The key of a run by the closed form: `what` is a friction coefficient, CURVE or BARE."""
    said: dict[str, Any] = {"structure": asdict(structure), "what": str(what), "motion": motion}
    if what == CURVE:
        said["grid"] = grid().tolist()
    return _hash([code(True), said])


def ladder(frictions: Iterable[float]) -> list[float]:
    """Friction from infinity down to the least that is asked for, which all are part of."""
    asked = set(frictions)
    steps, number = set[float](), TOP
    while RATIO**number > min(asked):
        steps.add(RATIO**number)
        number -= 1
    return [math.inf, *sorted(steps | asked, reverse=True)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedTask:
    """Runs by the closed form, of one structure under some motions."""

    name: str
    structure: Structure
    tables: Mapping[str, Any]
    """The scene, whose limits a motion has to keep."""
    folder: Path
    """Where its relative names start from."""
    wanted: tuple[tuple[SuiteMotion, tuple[tuple[str, str | float], ...]], ...]
    """For each motion the keys and what is computed for each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockTask:
    """A run of rigid or meshed blocks."""

    name: str
    key: str
    case: SuiteCase
    unit_pga: bool


Task = ClosedTask | BlockTask


def closed_tasks(
    structures: Mapping[Structure, Sequence[float]],
    motions: Sequence[SuiteMotion],
    tables: Mapping[str, Any],
    folder: Path,
    known: Mapping[str, Any],
) -> Iterator[ClosedTask]:
    """What is not known yet of all structures, each with its ladder of friction."""
    for structure, frictions in structures.items():
        for first in range(0, len(motions), TOGETHER):
            wanted = []
            for motion in motions[first : first + TOGETHER]:
                content = content_of(motion)
                whats: tuple[str | float, ...] = (CURVE, BARE, *frictions)
                keys = ((closed_key(structure, what, content), what) for what in whats)
                missing = tuple((key, what) for key, what in keys if key not in known)
                if missing:
                    wanted.append((motion, missing))
            if wanted:
                yield ClosedTask(
                    name=f"T {structure.period:g} s, motions {first + 1} on",
                    structure=structure,
                    tables=tables,
                    folder=folder,
                    wanted=tuple(wanted),
                )


def block_tasks(
    cell: Cell,
    motions: Sequence[SuiteMotion],
    tables: Mapping[str, Any],
    folder: Path,
    how: str,
) -> Iterator[BlockTask]:
    """The runs of a cell by an engine of the program."""
    model = "rigid" if how == "rigid" else "elastic"
    resolved = tables_of(tables, cell, model)
    unit_pga = cell.structure.unit_pga
    said = parse_scene(resolved, folder=folder).to_dict() | {"title": "", "pga": unit_pga}
    values = ", ".join(f"{name} {value:g}" for name, value in cell.values)
    for motion in motions:
        yield BlockTask(
            name=f"{ENGINES[how]}, {values}, {motion.name}",
            key=_hash([code(False), said, content_of(motion)]),
            case=_case(motion, resolved, folder),
            unit_pga=unit_pga,
        )


def run_task(task: Task) -> dict[str, Any]:
    """Numbers of a task's runs by their keys; on one process."""
    found = _run_closed(task) if isinstance(task, ClosedTask) else _run_blocks(task)
    return {"status": "completed", "runs": found}


def _run_closed(task: ClosedTask) -> dict[str, list[float]]:
    """Peak drift (m), base shear over the mass of the platform (m/s^2), slip (m); or the curve."""
    from solver.reference.friction import Resistance
    from solver.reference.sliding_peaks import Stretches, fixed_drifts, slider_peaks
    from solver.scene import FrictionSpec

    structure, found = task.structure, dict[str, list[float]]()
    platform, mass, gravity = structure.platform(), structure.mass_ratio, structure.gravity
    for motion, wanted in task.wanted:
        ground = _ground(task, motion)
        scale = gravity / ground.peak if structure.unit_pga else 1.0
        stretches = Stretches.of(ground, scale)
        for key, what in wanted:
            if what == CURVE:
                drifts = fixed_drifts(stretches, platform, mass * grid())
                found[key] = [float(drift) for drift in drifts]
                continue
            carried, mu = (0.0, math.inf) if what == BARE else (mass, float(what))
            law = FrictionSpec(static=min(mu, 1e9), dynamic=min(structure.dynamic * mu, 1e9))
            resistance = Resistance(law=law)
            found[key] = list(slider_peaks(stretches, platform, carried, resistance, gravity))
    return found


_GROUNDS: dict[str, Any] = {}
"""The motions that this process has read: each is needed for many structures."""


def _ground(task: ClosedTask, motion: SuiteMotion) -> Any:
    """The motion of the ground along x, read or made once in a process."""
    from solver.excitation.sampled import SampledMotion

    content = content_of(motion)
    if content not in _GROUNDS:
        along, *others = scene_of(_case(motion, task.tables, task.folder))[1].parts
        if not isinstance(along, SampledMotion) or any(others):
            raise Statement(motion.name, "is no motion given by samples along x alone")
        _GROUNDS[content] = along
    return _GROUNDS[content]


def _case(motion: SuiteMotion, tables: Mapping[str, Any], folder: Path) -> SuiteCase:
    """A case of a suite, which reads the motion and holds it against the scene's limits."""
    return SuiteCase(
        name=motion.name,
        motion=motion,
        varied=(),
        tables=tables,
        folder=folder,
        tail=0.0,
        reference=False,
        keep=None,
    )


def _run_blocks(task: BlockTask) -> dict[str, list[float]]:
    """Peak drift, base shear over the mass of the platform, slip, angle (rad), 1 if one fell."""
    from mpi4py import MPI

    from solver.run.simulate import simulate

    case = task.case
    scene, ground = scene_of(case)
    if task.unit_pga and ground.along is not None:
        table = dict(case.motion.table)
        table["scale"] = table.get("scale", 1.0) * scene.gravity / ground.along.peak
        scene, ground = scene_of(replace(case, motion=replace(case.motion, table=table)))
    result = simulate(scene, comm=MPI.COMM_SELF, ground=ground)
    if result.status != "completed":
        raise NotConverged(f"{result.status}: {result.summary['reason']}")
    m, k, c = scene.platform()
    history, blocks = result.history, result.summary["blocks"].values()
    shear = np.abs(k * history["platform.drift_m"] + c * history["platform.velocity_m_s"])
    numbers = [
        result.summary["platform"]["peak_drift_m"],
        float(shear.max()) / m,
        max(block["peak_slip_m"] for block in blocks),
        max(block["peak_angle_rad"] for block in blocks),
        float(any(b["overturned_at_s"] or b["fell_at_s"] for b in blocks)),
    ]
    return {task.key: numbers}
