"""Pictures of runs for papers: angle, phase plane, energy, forces, and several runs overlaid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from solver.errors import SceneError
from solver.fields.ground import floor_level
from solver.pictures.angles import draw_angle, draw_overlay, draw_phase
from solver.pictures.deformed import draw_deformed
from solver.pictures.forces import draw_energy, draw_forces, draw_platform
from solver.pictures.style import BLUE, DASHES, GREEN, ORANGE, STYLE, new_figure, save
from solver.reference.answer import reference_history, reference_name
from solver.results.runs import FIELDS, Run

__all__ = ["BLUE", "DASHES", "GREEN", "ORANGE", "STYLE", "instants", "picture_run", "picture_runs"]


def picture_run(run: Run, folder: Path | None = None) -> list[Path]:
    """Draw everything about one run into a folder, its own unless given; returns the files."""
    folder = folder or run.folder
    rigid = _rigid_answer(run)
    figures: dict[str, Callable[[], Figure]] = {"angle.png": lambda: draw_angle(run, rigid)}
    if run.scene.gravity > 0:
        figures["phase.png"] = lambda: draw_phase(run, rigid)
    if "platform.drift_m" in run.history:
        figures["platform.png"] = lambda: draw_platform(run, rigid)
    figures["forces.png"] = lambda: draw_forces(run)
    if np.all(np.isfinite(run.history["energy.ledger_error_J"])):
        figures["energy.png"] = lambda: draw_energy(run)
    if (run.folder / FIELDS).is_file():
        figures["deformed.png"] = lambda: _deformed(run)
    return [save(draw, folder / name) for name, draw in figures.items()]


def picture_runs(runs: Sequence[Run], folder: Path) -> list[Path]:
    """Overlay angle, slip and drift of several runs; returns the files."""
    return [save(lambda: draw_overlay(runs), folder / "overlay.png")]


def _rigid_answer(run: Run) -> Run | None:
    """The rigid-body answer to the scene of a run; None where there is none, or the run is it."""
    try:
        name = reference_name(run.scene)
        if run.model == name:
            return None
        history = reference_history(run.scene)
    except SceneError:
        return None
    return replace(run, history=history, summary={"model": name})


def _deformed(run: Run) -> Figure:
    """The bodies at a few instants."""
    figure = new_figure(3.4)
    draw_deformed(
        figure,
        run.folder / FIELDS,
        instants(run),
        dimension=run.scene.dimension,
        floor=floor_level(run.scene),
    )
    return figure


def instants(run: Run) -> list[float]:
    """Four times worth a look: start, first impact, the peak after it, end (s).

    Those of the block that leans most, over its slenderness; without an impact evenly spread.
    """
    time = run.history["time_s"]
    first, last = float(time[0]), float(time[-1])
    blocks = run.summary["blocks"]
    most = max(
        run.scene.blocks, key=lambda b: blocks[b.name]["peak_angle_rad"] / b.shape.slenderness
    )
    block = blocks[most.name]
    impact = [i["time_s"] for i in block["impacts"][:1]]
    after = [p["time_s"] for p in block["peaks"] if impact and p["time_s"] > impact[0]][:1]
    if impact and after:
        return [first, *impact, *after, last]
    return [float(t) for t in np.linspace(first, last, 4)]
