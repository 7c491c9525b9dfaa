"""A suite: one scene under many motions side by side, beside the rigid-body answer or each other.

As an ensemble it has its motions at several levels of intensity, by several engines.
"""

from __future__ import annotations

import argparse
import itertools
import math
import re
import shutil
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from mpi4py import MPI

from solver.errors import SceneError, missing_key
from solver.excitation.motion import GroundMotion, read_ground
from solver.reference.answer import as_history, reference_history, reference_name, rock
from solver.results.cautions import cautions_of_input
from solver.results.endings import motion_end
from solver.results.summary import summarise
from solver.run.simulate import simulate
from solver.run.streams import say
from solver.scene import Scene, parse_scene
from solver.scene.checking import shown
from solver.scene.motion import G_UNIT
from solver.study.scenes import refuse_components, refuse_others, scene_tables, with_model
from solver.study.study import Row, Study, by_name, words
from solver.study.study import numbers as numbers_of
from solver.study.suite import numbers
from solver.study.suite.intensity import ROTD50, Intensity
from solver.study.suite.motions import SuiteMotion, find_motions
from solver.study.tables import as_csv, column_names, write

RIGID, ELASTIC, ODE = ENGINES = ("rigid", "elastic", "ode")

STEP, LONGEST, TOLERANCE = 0.01, 0.04, 1e-6
"""Steps between rows of Housner's equation, and of its integration, times p; its tolerance."""

RUNS = "runs"
FRAGILITY, FRAGILITY_TEXT = "fragility.csv", "fragility.txt"
CURVES, DISTRIBUTIONS = "fragility.png", "peaks.png"

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

OF_ROCKING = tuple(key for key in KEPT if "angle" in key or key in ("mode", "overturned_at_s"))
"""Keys that are kept of Housner's equation, which has no slip."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SuiteCase:
    """Case of a suite, as one process is given it.

    Attributes:
        motion: The motion.
        varied: Keys and values, as text, that differ from case to case.
        engine: What answers, one of `ENGINES`; None: the scene as it stands.
        level: Intensity that the motion is scaled to; None: it stays as it is.
        intensity: The measure of the level.
        tables: The scene as plain tables.
        folder: Where the relative names of the scene start from.
        tail: How long the run goes on after the motion, s.
        reference: True if the rigid-body answer is computed, too.
        keep: Folder for the folders of runs with all their files; None: none are written.
    """

    motion: SuiteMotion
    varied: tuple[tuple[str, str], ...] = ()
    engine: str | None = None
    level: float | None = None
    intensity: Intensity | None = None
    tables: Mapping[str, Any]
    folder: Path
    tail: float = 0.0
    reference: bool = False
    keep: Path | None = None

    @property
    def part(self) -> Row:
        """What varies besides the motion: keys, and engine and level where it has such."""
        own = {"engine": self.engine, "level": self.level}
        return dict(self.varied) | {k: value for k, value in own.items() if value is not None}

    @property
    def name(self) -> str:
        """Its own in the suite; also the name of its file."""
        parts = [self.motion.name, *(f"{key}={value}" for key, value in self.part.items())]
        return re.sub(r"[^\w.=+-]+", "_", ",".join(parts).replace(",", "__"))

    @property
    def columns(self) -> Row:
        """The columns of its row that do not follow from its run."""
        strength = {"intensity": self.intensity.name} if self.intensity else {}
        return {"motion": self.motion.name, **self.part, **strength}

    def run(self) -> Row:
        """Run the case on one process; its row of the table.

        Raises:
            SceneError: The motion or a varied value is bad input.
        """
        scene, ground = scene_of(self)
        kept = self.keep / self.name if self.keep else None
        if kept is not None:
            shutil.rmtree(kept, ignore_errors=True)  # what an interrupted suite left
        if self.engine == ODE:
            summary = equation(scene, ground)
        else:
            run = simulate(scene, folder=kept, comm=MPI.COMM_SELF, ground=ground)
            summary = run.summary
        measures = _measures(summary, OF_ROCKING if self.engine == ODE else KEPT)
        row = self.columns | {
            "status": summary["status"],
            "reason": summary["reason"],
            "end_s": summary["end_s"],
            **_peaks(scene, ground),
            **measures,
        }
        if self.reference:
            try:
                row |= _compared(measures, _reference(scene, ground))
            except SceneError as error:
                row["reason"] = f"no reference, {error}"
        if self.engine != ODE:
            energy = ("largest_gain_fraction", "ledger_error_fraction")
            row |= {key: summary["energy"][key] for key in energy}
            row |= {key: summary["cost"][key] for key in ("steps", "rejected_steps")}
        return row | {
            "wall_s": summary["cost"]["wall_s"],
            "cautions": "; ".join(summary["cautions"]),
        }


def scene_of(case: SuiteCase) -> tuple[Scene, GroundMotion]:
    """The scene of a case, which ends with its motion, and the motion of the ground."""
    tables = with_model(case.tables, case.engine) | {"motion": dict(case.motion.table)}
    sets = [f"{key}={value}" for key, value in case.varied]
    scene = parse_scene(tables, folder=case.folder, overrides=sets)
    ground = read_ground(scene)
    if case.level is not None and case.intensity is not None:
        assert scene.motion is not None
        # It ends once a block has overturned: what comes then does not tell how strong it was.
        factor = case.level / case.intensity.of_ground(ground)
        stops = replace(scene.time, stop="overturned")
        scene = replace(scene, motion=scene.motion.times(factor), time=stops)
        ground = read_ground(scene)
    step = scene.time.step
    # Whole steps: a last, shorter one would need factorizations of its own.
    end = math.ceil((motion_end(ground) + case.tail) / step * (1 - 1e-9)) * step
    return replace(scene, time=replace(scene.time, end=end)), ground


def equation(scene: Scene, ground: GroundMotion) -> dict[str, Any]:
    """The summary of a case by Housner's equation, which has no slip."""
    began, p = time.perf_counter(), scene.blocks[0].shape.frequency(scene.gravity)
    known = rock(scene, ground, step=STEP / p, longest=LONGEST / p, tolerance=TOLERANCE)
    history, _ = as_history(scene, known)
    found = summarise(scene, history, status="completed", cost={}, versions={}, ground=ground)
    cost = {"wall_s": time.perf_counter() - began}
    return found | {"cost": cost, "cautions": cautions_of_input(scene, ground)}


def _peaks(scene: Scene, ground: GroundMotion) -> dict[str, float]:
    """The largest acceleration of each component of the motion, g."""
    parts = dict(zip(scene.directions, ground.parts, strict=True))
    return {
        f"pga{where.removeprefix('motion').replace('.', '_')}_g": part.peak / G_UNIT
        for where, part in parts.items()
        if part is not None
    }


def _measures(summary: Mapping[str, Any], kept: Sequence[str] = KEPT) -> dict[str, Any]:
    """Measures that are kept of a summary: peaks, residual slips, modes."""
    platform = summary.get("platform", {})
    drifts = (key for key in ("peak_drift_m", "peak_drift_second_m") if key in platform)
    found: dict[str, Any] = {f"platform.{key}": platform[key] for key in drifts}
    for name, block in summary["blocks"].items():
        found |= {f"{name}.{key}": block[key] for key in kept if key in block}
    return found


def _reference(scene: Scene, ground: GroundMotion) -> dict[str, Any]:
    """Measures of the rigid-body answer."""
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


class SuiteStudy(Study[SuiteCase]):
    """One scene under many motions.

    Attributes:
        varied: The columns that vary: keys, engine and level.
        engines: What answers, each beside the others; none: the scene as it stands.
        levels: Intensities to which motions are scaled; none: they stay as they are.
        intensity: The measure of the levels.
        blocks: Names of the blocks.
        notes: How motions are made up of components, and what is left out.
    """

    kind, noun = "suite", "suite"
    same = "the same scene, motions and options"
    files = (FRAGILITY, FRAGILITY_TEXT, CURVES, DISTRIBUTIONS)
    folders = (RUNS,)

    def __init__(self, options: argparse.Namespace):
        """Read the command line; refuse all that can be refused."""
        super().__init__(options)
        if not 0 <= options.tail < 1e6:
            raise SceneError("--tail", f"{options.tail:g}", "0 <= tail < 1e6 s")
        tables, where = scene_tables(options), options.scene.parent
        motions, notes = find_motions(
            options.motions, tables.pop("motion", None), count=options.count, seed=options.seed
        )
        beside, combinations = motions[0].beside, list(variations(options.vary))
        base = parse_scene(tables, folder=where, source=options.scene.name)
        self._read_ensemble(tables, beside)
        for values in combinations:  # what is no valid scene is refused before anything is written
            sets = [f"{key}={value}" for key, value in values]
            moving = tables | {"motion": dict(motions[0].table)}
            parse_scene(moving, folder=where, overrides=sets, source=options.scene.name)
        if options.reference:
            reference_name(base)
        self.wanted = [
            SuiteCase(
                motion=motion,
                varied=values,
                engine=engine,
                level=level,
                intensity=self.intensity,
                tables=tables,
                folder=where,
                tail=options.tail,
                reference=options.reference,
                keep=self.folder / RUNS if options.keep else None,
            )
            for values in combinations
            for engine in self.engines or (None,)
            for level in self.levels or (None,)
            for motion in motions
        ]
        self.varied = tuple(self.wanted[0].part)
        self.blocks = tuple(block.name for block in base.blocks)
        self.notes = [*notes, *self._notes_on_levels(beside)]
        self.settings = {
            "kept": KEPT,
            "scene": base.to_dict(),
            "vary": options.vary,
            "tail": options.tail,
            "reference": options.reference,
            "keep": options.keep,
            "motions": {motion.name: motion.table for motion in motions},
            "engines": self.engines,
            "levels": self.levels,
            "intensity": self.intensity.name if self.intensity else None,
        }

    def _read_ensemble(self, tables: Mapping[str, Any], beside: Collection[str]) -> None:
        """Engines and levels of the command line, for motions with these components besides x."""
        options = self.options
        for option in ("intensity", "horizontal"):
            if getattr(options, option) and not options.levels:
                raise missing_key("--levels", f"beside --{option}")
        if options.horizontal and "second" not in beside:
            allowed = "it for a scene with [motion.second]"
            raise SceneError("--horizontal", options.horizontal, allowed)
        asked = words("--engines", options.engines, ENGINES)
        for engine in asked:
            scene = parse_scene(with_model(tables, engine), folder=options.scene.parent)
            if engine == ODE:
                refuse_others(scene)
                refuse_components(beside)
                if options.reference:
                    allowed = f"{RIGID}, {ELASTIC} beside --reference"
                    raise SceneError("--engines", shown(options.engines), allowed)
        self.engines, self.intensity = asked, None
        self.levels = sorted(numbers_of("--levels", options.levels))
        if self.levels:
            self.intensity = Intensity.read(options.intensity or "PGA")
            if "second" in beside:
                how = options.horizontal or ROTD50
                self.intensity = replace(self.intensity, horizontal=how)

    @property
    def axis(self) -> str:
        """The measure of the levels with its unit."""
        return f"{self.intensity.name} ({self.intensity.unit})" if self.intensity else ""

    def _notes_on_levels(self, beside: Collection[str]) -> list[str]:
        """Notes on the meaning of levels, and on the end of their runs."""
        if self.intensity is None:
            return []
        of = "" if self.intensity.horizontal else " along x"
        factor = "; all components of an event have one factor" if beside else ""
        ends = "runs end before their motions do once a block has overturned"
        return [f"levels are of {self.axis}{of}{factor}", ends]

    def failure(self, case: SuiteCase, error: Exception) -> Row:
        """The row of a case that raised an error."""
        return case.columns | super().failure(case, error)

    def write(self) -> str:
        """Write the tables of what has been done; of ensembles the statistics, too."""
        rows, varied = self.ordered, self.varied
        text, done = numbers.as_text(rows, varied, self.notes), len(self.completed)
        found: dict[str, Any] = {
            "cases": len(self.cases), "completed": done, "failed": len(rows) - done,
            "notes": self.notes, "ratios": numbers.ratios(rows, varied),
        }  # fmt: skip
        if self.engines or self.levels:
            failed = [row for row in rows if row["status"] != "completed"]
            lines = numbers.remarks(failed, varied) + numbers.cautions(rows, varied) + self.notes
            told = self._write_ensemble(rows, text, found)
            return "\n".join([told, *lines, ""])
        self.leave(rows, text, found)
        if len(rows) == len(self.cases):
            from solver.study.suite.picture import panels_of, suite_picture

            shown = [row for row in rows if row.get("pga_g") is not None]
            if panels := panels_of(shown):
                self.draw("suite.png", suite_picture, shown, varied, panels)
        return text

    def _write_ensemble(self, rows: Sequence[Row], text: str, summary: Row) -> str:
        """Write tables and pictures of an ensemble, and what there is of all suites; its text."""
        found = numbers.samples(rows, self.varied, self.blocks)
        measure = {"intensity": self.axis} if self.intensity else {}
        table = [sample.row() | measure for sample in found]
        curves, apart = list(numbers.fits(found)), numbers.distances(found)
        fits = [
            {**dict(own[0].group), "engine": own[0].engine, **(asdict(curve) if curve else {})}
            for own, curve in curves
        ]
        told = numbers.fragility_text(found, curves, apart, self.axis)
        self.leave(rows, text, summary | {"levels": table, "fits": fits, "distances": apart})
        write(self.folder / FRAGILITY, as_csv(table, column_names(table)))
        write(self.folder / FRAGILITY_TEXT, told)
        if found:
            from solver.study.suite.picture import fragility_picture, peaks_picture

            if curves:
                self.draw(CURVES, fragility_picture, curves, self.axis)
            self.draw(DISTRIBUTIONS, peaks_picture, found, self.axis)
        return told

    def say(self, text: str) -> None:
        """Say what was found, and where everything stands."""
        done = f"{len(self.completed)} of {len(self.cases)} completed; written to {self.folder}\n"
        say(text + done)


def variations(words: Sequence[str]) -> Iterator[tuple[tuple[str, str], ...]]:
    """Every combination of the values in `KEY=VALUE,VALUE...`."""
    ladders, allowed = [], "KEY=VALUE,VALUE..., such as contact.friction=0.1,0.2"
    for key, values in by_name("--vary", words, allowed).items():
        if not values:
            raise SceneError("--vary", shown(key), allowed)
        ladders.append([(key, value) for value in values])
    yield from itertools.product(*ladders)
