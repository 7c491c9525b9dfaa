"""Lambda over a map: sliding blocks, rigid blocks, finite elements under a suite of motions."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, cast

from mpi4py import MPI

import numpy as np

from solver.errors import NotConverged, SceneError
from solver.excitation.sampled import SampledMotion
from solver.reference.answer import refuse_joined
from solver.run.simulate import simulate
from solver.scene import parse_scene
from solver.study.inertia.cells import Cell, Structure, cells_of, chosen, ladder, tables_of
from solver.study.inertia.numbers import (
    Finding,
    Line,
    differences,
    entry_of,
    grid,
    markdown,
    row_of,
    widest,
)
from solver.study.inertia.sliding import STEPS, fixed_drifts, jumps, peaks
from solver.study.scenes import HERE, Tables, refuse_components, scene_tables
from solver.study.study import Row, Study, digest
from solver.study.suite.cases import SuiteCase, scene_of
from solver.study.suite.motions import SuiteMotion, find_motions
from solver.study.tables import column_names, groups

COUNT = 300
"""Default number of synthetic motions."""

MOST_CELLS = 12
"""Cells for which finite elements are offered."""

TOGETHER = 10
"""Motions that slide in one case."""

NEVER = 1e9
"""Coefficient of friction with which nothing slides."""

ENGINES = {"rigid": "rigid blocks", "elements": "finite elements"}
"""Ways to compute the drift besides the sliding block, and what they are called."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SlidingCase:
    """One structure under some motions: portions fixed, no live load, a block that slides.

    Attributes:
        structure: The empty structure and its live load.
        frictions: Coefficients of friction, from infinity down.
        motions: Of the ground.
        tables: The scene, whose limits a motion has to keep.
        folder: Where its relative names start from.
    """

    structure: Structure
    frictions: tuple[float, ...]
    motions: tuple[SuiteMotion, ...]
    tables: Tables
    folder: Path

    @property
    def name(self) -> str:
        """Its own among those that are run at a time."""
        of, first = self.structure, self.motions[0].name
        return f"T {of.period:g} s, mass ratio {of.mass_ratio:g}, {first} on"

    @property
    def key(self) -> str:
        """Made from all that it computes."""
        held = [motion.held for motion in self.motions]
        return digest([asdict(self.structure), [str(mu) for mu in self.frictions], held])

    def run(self) -> Row:
        """Peak drift (m) and base shear over the mass of the platform (m/s^2), motion by motion."""
        structure, grounds = self.structure, [self._ground(motion) for motion in self.motions]
        gravity, load, platform = structure.gravity, structure.mass_ratio, structure.platform()
        scales = [gravity / g.peak if structure.unit_pga else 1.0 for g in grounds]
        step = structure.period / STEPS
        changes = [jumps(g, scale, step) for g, scale in zip(grounds, scales, strict=True)]
        # The first one is the structure without live load.
        slides = gravity * np.minimum([math.inf, *self.frictions], NEVER)
        masses = np.append(0.0, np.full(len(self.frictions), load))
        found = peaks(changes, step, platform, masses, slides, structure.dynamic * slides)
        both = np.stack(found, axis=-1)
        return {
            "curve": [fixed_drifts(c, step, platform, load * grid()).tolist() for c in changes],
            "bare": both[:, 0].tolist(),
            "peaks": both[:, 1:].tolist(),
        }

    def _ground(self, motion: SuiteMotion) -> SampledMotion:
        """The motion of the ground along x, held against the scene's limits."""
        case = SuiteCase(motion=motion, tables=self.tables, folder=self.folder)
        return cast("SampledMotion", scene_of(case)[1].along)  # as all motions of suites


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockCase:
    """A run of rigid or meshed blocks.

    Attributes:
        name: Way, cell and motion.
        key: Made from all that it computes.
        case: The scene under the motion.
        unit_pga: True if the motion is scaled to a peak of 1 g.
    """

    name: str
    key: str
    case: SuiteCase
    unit_pga: bool

    def run(self) -> Row:
        """Peak drift, base shear over the mass of the platform, slip, angle (rad), 1 if it fell."""
        case = self.case
        scene, ground = scene_of(case)
        if self.unit_pga and ground.along is not None:
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
        return {"numbers": numbers}


def block_cases(
    cell: Cell, motions: Sequence[SuiteMotion], tables: Mapping[str, Any], folder: Path, how: str
) -> list[BlockCase]:
    """The runs of a cell by an engine of the program, "rigid" or "elements"."""
    resolved = tables_of(tables, cell, "rigid" if how == "rigid" else "elastic")
    unit_pga = cell.structure.unit_pga
    said = parse_scene(resolved, folder=folder).to_dict() | {"title": "", "pga": unit_pga}
    values = ", ".join(f"{name} {value:g}" for name, value in cell.values)
    return [
        BlockCase(
            name=f"{ENGINES[how]}, {values}, {motion.name}",
            key=digest([said, motion.held]),
            case=SuiteCase(motion=motion, tables=resolved, folder=folder),
            unit_pga=unit_pga,
        )
        for motion in motions
    ]


class InertiaStudy(Study[SlidingCase | BlockCase]):
    """The portion of the live load that counts as inertia.

    Rows are known by what they compute, so that a study may go on with other axes and motions.

    Attributes:
        tables: The scene, without a motion.
        cells: Of the map.
        ladders: Friction from infinity down, for each structure.
        motions: All of them.
        notes: How they are made up, and what is left out.
        by: Ways to compute besides the sliding block.
    """

    kind, noun, same = "inertia", "study of inertia", "the same scene"
    files = ("*.png",)

    def __init__(self, options: argparse.Namespace):
        """Read the command line, and refuse cells that no way can compute."""
        super().__init__(options)
        path = options.scene
        self.tables = scene_tables(options)
        synthetic = not options.motions or "synthetic" in options.motions
        count = COUNT if options.count is None and synthetic else options.count
        motion = self.tables.pop("motion", None)
        refuse_components(motion if isinstance(motion, dict) else ())
        self.motions, self.notes = find_motions(
            options.motions, motion, count=count, seed=options.seed
        )
        self.scene = parse_scene(self.tables, folder=path.parent, source=path.name)
        refuse_joined(self.scene, HERE)
        self.by = sorted(set(options.by), reverse=True)
        axes = chosen(options.of)
        self.cells = cells_of(self.scene, axes)
        if "aspect" in axes and not self.by:
            allowed = "it with --by rigid or elements: sliding has no height"
            raise SceneError("--of", "aspect", allowed)
        if "elements" in self.by and len(self.cells) > MOST_CELLS:
            got = f"elements, {len(self.cells)} cells"
            raise SceneError("--by", got, f"at most {MOST_CELLS}")
        for cell in self.cells:
            for how in self.by or ("rigid",):
                parse_scene(tables_of(self.tables, cell, "rigid" if how == "rigid" else "elastic"))
        frictions: dict[Structure, set[float]] = {}
        for cell in self.cells:
            frictions.setdefault(cell.structure, set()).add(cell.friction)
        self.ladders = {structure: ladder(mus) for structure, mus in frictions.items()}
        self.settings = {"scene": self.scene.to_dict()}

    def rounds(self) -> Iterator[Sequence[SlidingCase | BlockCase]]:
        """The sliding blocks, then those of engines."""
        yield [case for cases in self.sliding().values() for case in cases]
        failed = [row for row in self.ordered if row["status"] != "completed"]
        if failed and not self.lines():
            raise NotConverged(f"runs of the sliding block failed: {failed[0]['reason']}")
        yield [case for *_, cases in self.blocks() for case in cases]

    def sliding(self) -> dict[Structure, list[SlidingCase]]:
        """The cases of sliding blocks, structure by structure."""
        return {
            structure: [
                SlidingCase(
                    structure=structure,
                    frictions=tuple(frictions),
                    motions=tuple(self.motions[first : first + TOGETHER]),
                    tables=self.tables,
                    folder=self.options.scene.parent,
                )
                for first in range(0, len(self.motions), TOGETHER)
            ]
            for structure, frictions in self.ladders.items()
        }

    def blocks(self) -> Iterator[tuple[Cell, str, list[BlockCase]]]:
        """Cell, way to compute, and runs."""
        folder = self.options.scene.parent
        for how in self.by:
            for cell in self.cells:
                yield cell, how, block_cases(cell, self.motions, self.tables, folder, how)

    def lines(self) -> dict[Structure, Line]:
        """All structures; none where a run of the sliding block is missing."""
        cases = self.sliding()
        rows = {s: [self.rows.get(case.key, {}) for case in own] for s, own in cases.items()}
        if any(row.get("status") != "completed" for own in rows.values() for row in own):
            return {}
        return {s: Line.of(s, self.ladders[s], own) for s, own in rows.items()}

    def findings(self, lines: Mapping[Structure, Line]) -> list[Finding]:
        """All cells by the sliding block, then by the engines."""
        found = [lines[cell.structure].finding(cell) for cell in self.cells]
        for cell, how, cases in self.blocks():
            outcomes = [self.rows.get(case.key, {}).get("numbers") for case in cases]
            if any(outcome is not None for outcome in outcomes):
                found.append(lines[cell.structure].finding_by(cell, ENGINES[how], outcomes))
        return found

    def write(self) -> str:
        """Write tables and pictures once all sliding blocks are known."""
        lines = self.lines()
        if not lines:
            return ""
        findings = self.findings(lines)
        failed = {
            case.name: self.rows[key]["reason"]
            for key, case in self.cases.items()
            if self.rows.get(key, {}).get("status") == "failed"
        }
        failures = [f"{name}: {reason}" for name, reason in sorted(failed.items())]
        title = self.scene.title or self.options.scene.stem
        title = f"Portion of the live load that counts as inertia: {title}"
        text = markdown(title, findings, failures, [*differences(findings), *self.notes])
        summary = {
            "motions": findings[0].motions,
            "notes": self.notes,
            "widest_half_interval": widest(findings),
            "cells": [entry_of(finding) for finding in findings],
            "failed": dict(sorted(failed.items())),
        }
        table = [row_of(finding) for finding in findings]
        self.leave(table, text, summary, names=column_names(table), digits=10)
        self._draw(list(lines.values()), findings)
        return text

    def _draw(self, lines: Sequence[Line], findings: Sequence[Finding]) -> None:
        """Draw the pictures; a set for each combination of the axes before the last two."""
        from solver.study.inertia.picture import (
            lambda_picture,
            map_picture,
            roots_picture,
            shear_picture,
        )

        for old in self.folder.glob("*.png"):
            old.unlink()
        maps = groups(findings, lambda finding: finding.cell.values[:-2])
        for number, group in enumerate(maps.values(), start=1):
            ending = f"_{number}" if len(maps) > 1 else ""
            self.draw(f"lambda{ending}.png", lambda_picture, group)
            self.draw(f"base_shear{ending}.png", shear_picture, group)
            mapped = [finding for finding in group if len(finding.cell.values) > 1]
            for by, own in groups(mapped, lambda finding: finding.by).items():
                self.draw(f"map{ending}_{by.replace(' ', '_')}.png", map_picture, own)
        self.draw("roots.png", roots_picture, lines, findings)
