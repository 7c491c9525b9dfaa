"""Pictures of runs for papers: angle, phase plane, energy, forces, and several runs overlaid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from solver.errors import SceneError
from solver.pictures.angles import draw_angle, draw_overlay, draw_phase
from solver.pictures.deformed import deformed_figure
from solver.pictures.energy import draw_energy
from solver.pictures.forces import draw_forces, draw_platform
from solver.pictures.ground import (
    draw_floors,
    draw_motion,
    ground_of,
    sampled_motions,
    write_floors,
)
from solver.pictures.style import save_as
from solver.reference.answer import reference_history, reference_name
from solver.results.floor_spectra import floor_spectra, has_floors
from solver.results.runs import Run
from solver.types import Array


def picture_run(
    run: Run, folder: Path | None = None, formats: Sequence[str] = ("png",)
) -> list[Path]:
    """Draw everything about one run into a folder, its own unless given; returns the files.

    Formats are "png", "pdf" and "svg".
    """
    folder = folder or run.folder
    rigid = _rigid_answer(run)
    figures: dict[str, Callable[[], Figure]] = {"angle": lambda: draw_angle(run, rigid)}
    if run.scene.gravity > 0:
        figures["phase"] = lambda: draw_phase(run, rigid)
    if "platform.drift_m" in run.history:
        figures["platform"] = lambda: draw_platform(run, rigid)
    figures["forces"] = lambda: draw_forces(run)
    if np.all(np.isfinite(run.history["energy.ledger_error_J"])):
        figures["energy"] = lambda: draw_energy(run)
    spectra = _floor_spectra(run)
    if spectra:
        figures["floors"] = lambda: draw_floors(spectra)
    motions = sampled_motions(run)
    if motions:
        figures["motion"] = lambda: draw_motion(motions)
    if run.fields is not None:
        figures["deformed"] = lambda: deformed_figure(run)
    files = []
    for name, draw in figures.items():
        files += save_as(draw, folder / name, formats)
    return files


def tables_of_run(run: Run, folder: Path | None = None) -> list[Path]:
    """Write what pictures of a run show and its history does not have, as tables."""
    spectra = _floor_spectra(run)
    return [write_floors(spectra, folder or run.folder)] if spectra else []


def _floor_spectra(run: Run) -> dict[str, Array]:
    """Spectra of the floors of a run; its motion is read only where there are some."""
    return floor_spectra(run.history, ground_of(run)) if has_floors(run.history) else {}


def picture_runs(
    runs: Sequence[Run], folder: Path, formats: Sequence[str] = ("png",)
) -> list[Path]:
    """Overlay angle, slip and drift of several runs; returns the files."""
    return save_as(lambda: draw_overlay(runs), folder / "overlay", formats)


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
