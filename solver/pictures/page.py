"""The page of a run: what the program says of it, film, pictures and scene, how to repeat it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from solver.errors import EnvironmentTrouble, SceneError
from solver.pictures.encode import default_ending
from solver.pictures.film import FilmOptions, film
from solver.pictures.html import (
    cautions,
    document,
    figure,
    heading,
    items,
    paragraphs,
    table,
    verbatim,
)
from solver.pictures.pictures import picture_run
from solver.results.moving import moving_span
from solver.results.report import residual_slip, result_lines, told_lines
from solver.results.runs import Run
from solver.run.describe import describe
from solver.scene import scene_to_toml

CAPTIONS = {
    "angle": "Angle of the blocks against time, below the acceleration of the ground if it moves",
    "phase": "Angular velocity against angle",
    "platform": "Drift of the platform, slips, and acceleration of platform and ground",
    "floors": "Response spectra of ground and floors",
    "forces": "Normal force and friction over the weight, and slips",
    "energy": "Where the energy is, and where it went",
    "motion": "The motion of the ground: acceleration, Husid plot, response spectrum",
    "deformed": "The bodies as they stand",
}
"""Captions of the pictures, by their names."""

HEADING = (
    *("block", "peak angle (°)", "over alpha", "peak slip (mm)", "residual slip (mm)"),
    *("peak displacement (mm)", "turn (°)", "impacts", "mean restitution", "mode"),
)

LONGEST_FILM = 20.0
"""A film on a page lasts no longer than this, s: a long run goes by faster."""

FILMS = ("film.mp4", "film.gif")

ROUND_OFF = 1e-12
"""Angles (rad) and slips (m) below this are shown as nought."""


def run_page(run: Run, folder: Path, *, filmed: bool) -> str:
    """The page of a run; its pictures are drawn into a folder, and where `filmed` the film, too."""
    pictures, summary = picture_run(run, folder), run.summary
    parts = [
        verbatim("\n".join([run.model, *result_lines(summary)])),
        *cautions([*summary.get("cautions", []), *told_lines(summary)]),
        heading("Blocks"),
        table(_blocks(run)),
    ]
    if filmed:
        parts += [heading("Film"), _film_part(run, folder)]
    parts += [heading("Pictures")]
    parts += [figure(CAPTIONS[file.stem], file) for file in pictures]
    parts += [heading("Scene"), *_derived(run), verbatim(scene_to_toml(run.scene))]
    parts += _repetition(run)
    return document(run.scene.title or run.label, parts)


def _film_part(run: Run, folder: Path) -> str:
    """The film, or why there is none."""
    try:
        return figure("The run, with the forces on the blocks", _film(run, folder))
    except EnvironmentTrouble as error:
        return "".join(paragraphs([f"No film: {escape(str(error))}"]))


def _film(run: Run, folder: Path) -> Path:
    """The film in the folder of the run if it is newer than the run, or one that is made now."""
    made = (run.folder / "history.csv").stat().st_mtime
    for name in FILMS:
        file = run.folder / name
        if file.is_file() and file.stat().st_mtime >= made:
            return file
    file = folder / f"film{default_ending()}"
    begin, end = moving_span(run.scene, run.history)
    slow = LONGEST_FILM / (end - begin) if end - begin > LONGEST_FILM else None
    film([run], file, FilmOptions(width=640, slow=slow))
    return file


def _why_none(impacts: Sequence[Mapping[str, Any]]) -> str:
    """Reasons why no impact has a restitution."""
    reasons = dict.fromkeys(impact["reason"] for impact in impacts if impact.get("reason"))
    return f"none: {'; '.join(reasons)}" if reasons else _number(None)


def _blocks(run: Run) -> list[list[str]]:
    """A row for each block."""
    rows = [list(HEADING)]
    for block in run.scene.blocks:
        entry = run.summary["blocks"][block.name]
        known = [i["restitution"] for i in entry["impacts"] if i.get("restitution") is not None]
        peak = entry["peak_angle_rad"]
        over, fell = entry["overturned_at_s"], entry["fell_at_s"]
        mode = str(entry.get("mode", ""))
        mode += f" at {over:.4g} s" if over is not None else ""
        mode += f" at {fell:.4g} s" if fell is not None and over is None else ""
        rows.append(
            [
                block.name,
                _number(math.degrees(peak)),
                _number(entry["peak_angle_over_alpha"]),
                _number(entry.get("peak_slip_m"), 1e3),
                _number(residual_slip(entry), 1e3),
                _number(entry.get("peak_displacement_m"), 1e3),
                _number(entry.get("peak_turn_rad"), math.degrees(1.0)),
                str(len(entry["impacts"])),
                _number(sum(known) / len(known)) if known else _why_none(entry["impacts"]),
                mode,
            ]
        )
    return rows


def _derived(run: Run) -> list[str]:
    """Derived numbers of the scene, or the error where they cannot be found."""
    try:
        return [verbatim(describe(run.scene))]
    except SceneError as error:
        return paragraphs([escape(str(error))])


def _repetition(run: Run) -> list[str]:
    """The command that does it again, and with which programs."""
    rigid_answer = run.model not in ("finite elements", "rigid blocks")
    command = "reference" if rigid_answer else "run"
    scene = run.folder / "scene.toml"
    parts = [
        heading("How to repeat"),
        *paragraphs(["The scene above is <code>scene.toml</code> beside this page:"]),
        verbatim(f"rockslip {command} {scene} -o again\nrockslip report again"),
    ]
    versions = run.summary.get("versions", {})
    if versions:
        parts += [heading("Versions"), items(f"{name} {text}" for name, text in versions.items())]
    return parts


def _number(value: float | None, factor: float = 1.0) -> str:
    """A number, or a dash where it is not known."""
    if value is None or math.isnan(value):
        return "-"
    return f"{factor * value:.4g}" if abs(value) > ROUND_OFF else "0"
