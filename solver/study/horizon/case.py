"""One case of the study: an engine, an amplitude of the motion, and twins of the run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from solver.results.endings import cut_short, overturned_at
from solver.results.motion import lean_over_alpha
from solver.scene import Scene, parse_scene
from solver.study.suite.engines import with_model

POINTS = 400
"""Times at which the difference of both is kept for the picture."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HorizonCase:
    """Case of the study, as one process is given it.

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
        """What the study calls it, and no other case; also the name of its file."""
        return f"{self.engine or 'scene'},scale={self.scale:.8g}"

    def scene(self) -> Scene:
        """The scene of the run."""
        scene = parse_scene(with_model(self.tables, self.engine), folder=self.folder)
        if scene.motion is None or self.scale == 1:
            return scene
        return replace(scene, motion=scene.motion.times(self.scale))


def run_case(case: HorizonCase) -> dict[str, Any]:
    """Run a scene and its twins on one process; the row of the case."""
    from mpi4py import MPI

    from solver.run.simulate import simulate
    from solver.run.twin import APART, difference, horizon, twin_of

    scene = case.scene()
    first = simulate(twin_of(scene, 0.0), comm=MPI.COMM_SELF)
    row = {"status": first.status, "reason": first.summary["reason"], "engine": case.engine,
           "scale": case.scale, "end_s": first.summary["end_s"], "apart": APART,
           "cut_short": cut_short(first.summary),
           "overturned": any(overturned_at(first.history, b) is not None for b in scene.blocks),
           "peak": _peak(scene, first.history), "twins": []}  # fmt: skip
    for perturbation in case.perturbations if first.status == "completed" else ():
        twin = simulate(twin_of(scene, perturbation), comm=MPI.COMM_SELF)
        if twin.status != "completed":
            reason = f"twin at {perturbation:g}: {twin.summary['reason']}"
            return row | {"status": twin.status, "reason": reason}
        time, apart = difference(scene, first.history, twin.history)
        kept = np.unique(np.linspace(0, len(time) - 1, POINTS).astype(int))
        # The largest up to each time that is kept, since the last one: nothing is passed over.
        largest = [float(part.max()) for part in np.split(apart, kept[:-1] + 1)]
        row["twins"].append({
            "perturbation": perturbation,
            "horizon_s": horizon(scene, first.history, twin.history),
            "largest": float(apart.max()),
            "time": time[kept].tolist(), "difference": largest,
        })  # fmt: skip
    return row


def _peak(scene: Scene, history: Any) -> float:
    """Largest |theta|/alpha of any block, in the direction in which it leans."""
    return max(float(lean_over_alpha(history, block).max()) for block in scene.blocks)
