"""Runs beside twins whose motions differ by a small part, for engines and amplitudes."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np

from solver.errors import SceneError
from solver.results.endings import cut_short, overturned_at
from solver.results.motion import lean_over_alpha
from solver.run.simulate import simulate
from solver.run.twin import difference, horizon, refuse_without_twin, twin_of
from solver.scene import Scene, parse_scene
from solver.study.horizon.numbers import NAMES, as_text, growth, twin_rows
from solver.study.scenes import scene_tables, with_model
from solver.study.study import Row, Study, numbers, words

ENGINES = ("rigid", "elastic")

POINTS = 400
"""Times at which the difference of both is kept for the picture."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HorizonCase:
    """An engine and an amplitude of the motion: a run, and its twins.

    Attributes:
        engine: "rigid" or "elastic"; None: the scene as it is.
        scale: Factor on the motion of the scene.
        perturbations: Relative differences between the run and its twins.
        tables: The scene.
        folder: Where the relative names of the scene start from.
    """

    engine: str | None
    scale: float
    perturbations: tuple[float, ...]
    tables: dict[str, Any]
    folder: Path

    @property
    def name(self) -> str:
        """Its own in the study; also the name of its file."""
        return f"{self.engine or 'scene'},scale={self.scale:.8g}"

    def scene(self) -> Scene:
        """The scene of the run."""
        scene = parse_scene(with_model(self.tables, self.engine), folder=self.folder)
        if scene.motion is None or self.scale == 1:
            return scene
        return replace(scene, motion=scene.motion.times(self.scale))

    def run(self) -> Row:
        """Run the scene and its twins on one process; the row of the case."""
        scene = self.scene()
        first = simulate(twin_of(scene, 0.0), comm=MPI.COMM_SELF)
        leans = [float(lean_over_alpha(first.history, block).max()) for block in scene.blocks]
        row: Row = {
            "status": first.status,
            "reason": first.summary["reason"],
            "engine": self.engine,
            "scale": self.scale,
            "end_s": first.summary["end_s"],
            "cut_short": cut_short(first.summary),
            "overturned": any(overturned_at(first.history, b) is not None for b in scene.blocks),
            "peak_angle_over_alpha": max(leans),
            "twins": [],
        }
        for perturbation in self.perturbations if first.status == "completed" else ():
            twin = simulate(twin_of(scene, perturbation), comm=MPI.COMM_SELF)
            if twin.status != "completed":
                reason = f"twin at {perturbation:g}: {twin.summary['reason']}"
                return row | {"status": twin.status, "reason": reason}
            time, apart = difference(scene, first.history, twin.history)
            kept = np.unique(np.linspace(0, len(time) - 1, POINTS).astype(int))
            # The largest up to each time that is kept, since the last one: nothing is passed over.
            largest = [float(part.max()) for part in np.split(apart, kept[:-1] + 1)]
            row["twins"].append(
                {
                    "perturbation": perturbation,
                    "horizon_s": horizon(scene, first.history, twin.history),
                    "largest_difference": float(apart.max()),
                    "time": time[kept].tolist(),
                    "difference": largest,
                }
            )
        return row


class HorizonStudy(Study[HorizonCase]):
    """Up to when a history means something."""

    kind, noun = "horizon", "study of horizons"
    same = "the same scene, motion and differences"

    def __init__(self, options: argparse.Namespace):
        """Read the command line, and refuse what has no twin."""
        super().__init__(options)
        differences = numbers("--differences", options.differences)
        if not all(1e-12 <= value <= 0.1 for value in differences):
            raise SceneError("--differences", options.differences, "1e-12 <= D <= 0.1")
        tables, scales = scene_tables(options), numbers("--scales", options.scales)
        if "motion" not in tables and set(scales) != {1.0}:
            raise SceneError("--scales", options.scales, "1 for a scene without [motion]")
        self.wanted = [
            HorizonCase(
                engine=engine,
                scale=scale,
                perturbations=tuple(sorted(differences)),
                tables=tables,
                folder=options.scene.parent,
            )
            for engine in words("--engines", options.engines, ENGINES) or (None,)
            for scale in scales
        ]
        scenes = {case.name: case.scene() for case in self.wanted}
        for scene in scenes.values():
            refuse_without_twin(scene, "study horizon")
        said = {name: scene.to_dict() for name, scene in scenes.items()}
        self.settings = {"scenes": said, "differences": differences}

    def write(self) -> str:
        """Write the table, the rates of growth, the picture."""
        from solver.study.horizon.picture import horizon_picture

        done = self.completed
        if not done:
            return ""
        text, twins = as_text(done), twin_rows(done)
        rates = [
            {"growth_1_s": growth(row), "scale": row["scale"], "engine": row["engine"]}
            for row in done
        ]
        self.leave(twins, text, {"twins": twins, "runs": rates}, names=NAMES)
        self.draw("horizon.png", horizon_picture, done)
        return text
