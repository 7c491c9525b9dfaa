"""Pictures of how the ground moves: beside a run, on its own, and what floors make of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from solver.errors import SceneError
from solver.excitation.motion import GroundMotion, read_ground
from solver.excitation.sampled import SampledMotion
from solver.excitation.spectrum import (
    DAMPING,
    PERIODS,
    accumulated_intensity,
    longest_spacing,
    peak_ground,
    response_spectrum,
    significant_duration,
)
from solver.pictures.style import (
    BLUE,
    DASHES,
    GREY,
    RED,
    colour,
    legend_above,
    new_figure,
    plain_periods,
    zero_line,
)
from solver.results.floor_spectra import ALONG_Y
from solver.results.runs import Run
from solver.scene.motion import G_UNIT
from solver.types import Array

#: Directions of the ground's motion: how their columns begin, what they are called, their colours.
DIRECTIONS = (
    ("", "along x", "black"),
    ("second_", "along y", BLUE),
    ("vertical_", "vertical", RED),
)

#: Kinds of motion that have a picture of their own.
SAMPLED = ("record", "synthetic", "table")


def add_ground(axes: Any, run: Run) -> None:
    """Acceleration of the ground against time, in each direction in which it moves."""
    shown = [d for d in DIRECTIONS if f"base.{d[0]}acceleration_m_s2" in run.history]
    for begins, name, hue in shown:
        ground = run.history[f"base.{begins}acceleration_m_s2"] / G_UNIT
        label = f"ground {name}" if len(shown) > 1 else None
        axes.plot(run.history["time_s"], ground, color=hue, linewidth=0.8, label=label)
    axes.set_ylabel("ground (g)")
    zero_line(axes)


def ground_of(run: Run) -> GroundMotion | None:
    """The motion of the ground in a run; None where its file is no longer there."""
    try:
        return read_ground(run.scene)
    except SceneError:
        return None


def sampled_motions(run: Run) -> list[tuple[str, str, SampledMotion]]:
    """The ground's sampled motions, with their names and colours.

    None where the scene has no such motion, or where its file is no longer there.
    """
    spec = run.scene.motion
    if spec is None or spec.kind not in SAMPLED:
        return []
    ground = ground_of(run)
    if ground is None:
        return []
    parts = ground.parts
    named = [DIRECTIONS[0], DIRECTIONS[2]] if len(parts) == 2 else list(DIRECTIONS)
    return [
        (name, hue, part)
        for (_, name, hue), part in zip(named, parts, strict=True)
        if isinstance(part, SampledMotion)
    ]


def draw_motion(motions: list[tuple[str, str, SampledMotion]]) -> Figure:
    """Accelerograms, their Husid plots, and their response spectra."""
    figure = new_figure(4.2)
    panels = figure.subplot_mosaic([["a", "s"], ["h", "s"]], width_ratios=(3, 2))
    panels["h"].sharex(panels["a"])
    panels["a"].tick_params(labelbottom=False)
    for name, hue, motion in motions:
        samples, step = motion.evenly_spaced(longest_spacing(PERIODS))
        label = _label(name, samples, step)
        panels["a"].plot(motion.time, motion.value / G_UNIT, color=hue, linewidth=0.7, label=label)
        time = np.linspace(motion.time[0], motion.stop, len(samples))
        _add_husid(panels["h"], time, samples, step, hue)
        spectrum = response_spectrum(samples, step, PERIODS) / G_UNIT
        panels["s"].semilogx(PERIODS, spectrum, color=hue)
    panels["a"].set_ylabel("acceleration (g)")
    zero_line(panels["a"])
    panels["h"].set(xlabel="time (s)", ylabel="Arias intensity (%)", ylim=(0, 100))
    panels["h"].margins(x=0)
    label = f"PSA (g), {DAMPING:.0%} of critical"
    plain_periods(panels["s"])
    panels["s"].set(ylabel=label, ylim=(0, None))
    legend_above(figure, columns=1)
    return figure


def _add_husid(axes: Any, time: Array, samples: Array, step: float, hue: str) -> None:
    """The part of the Arias intensity that has come (Husid 1969)."""
    grown = accumulated_intensity(samples, step)
    if grown[-1] == 0 or not math.isfinite(grown[-1]):
        return
    axes.plot(time, 100 * grown / grown[-1], color=hue)
    for level in (5, 95):
        axes.axhline(level, color=GREY, linewidth=0.5, linestyle=":", zorder=0)


def _label(name: str, samples: Array, step: float) -> str:
    """A motion and its measures."""
    peak, _, _ = peak_ground(samples, step)
    arias = accumulated_intensity(samples, step)[-1]
    lasts = significant_duration(samples, step)
    return f"{name}: PGA {peak / G_UNIT:.3g} g, Arias {arias:.3g} m/s, D5-95 {lasts:.3g} s"


def draw_floors(spectra: dict[str, Array]) -> Figure:
    """Spectra of the ground and of all floors."""
    figure = new_figure(3.6)
    axes = figure.subplots()
    floors = list(dict.fromkeys(name.removesuffix(ALONG_Y) for name in spectra))
    for name, spectrum in spectra.items():
        floor = floors.index(name.removesuffix(ALONG_Y))
        hue = "black" if floors[floor] == "ground" else colour(floor - 1)
        line = DASHES if name.endswith(ALONG_Y) else "-"
        axes.semilogx(PERIODS, spectrum / G_UNIT, color=hue, linestyle=line, label=name)
    label = f"PSA (g), {DAMPING:.0%} of critical"
    plain_periods(axes)
    axes.set(ylabel=label, ylim=(0, None))
    legend_above(figure)
    return figure


def write_floors(spectra: dict[str, Array], folder: Path) -> Path:
    """Write `floor_spectra.csv`: periods, and a column for the ground and for each floor."""
    names = ["period_s", *(f"{name.replace(' ', '_')}_m_s2" for name in spectra)]
    table = np.column_stack([PERIODS, *spectra.values()])
    file = folder / "floor_spectra.csv"
    np.savetxt(file, table, fmt="%.9g", delimiter=",", header=",".join(names), comments="")
    return file
