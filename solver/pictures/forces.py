"""Pictures of forces and slip, and of the platform."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from solver.history.pairs import FRICTION
from solver.pictures.style import (
    BLUE,
    DASHES,
    GREEN,
    GREY,
    ORANGE,
    RED,
    colour,
    least_span,
    legend_above,
    new_figure,
    zero_line,
)
from solver.results.motion import ACCELERATIONS, is_spatial
from solver.results.moving import moving_span
from solver.results.runs import Run
from solver.scene import BlockSpec
from solver.scene.motion import G_UNIT
from solver.types import Array

Floats = NDArray[np.floating[Any]]

#: A drawn slip or drift is no smaller than this, mm.
LEAST_LENGTH = 0.1


#: Pairs of neighbours of which forces are drawn, at most: those that press most.
MOST_PAIRS = 6


#: Links of which forces are drawn, at most: those with the largest ones.
MOST_LINKS = 6


def draw_forces(run: Run) -> Figure:
    """Forces on each block from what it stands on, over the weight there, those of links, slips.

    Where the run has told what pairs of bodies do, also those between neighbours.
    """
    blocks, pairs = run.scene.blocks, _neighbours(run)
    count = len(blocks) + len(pairs) + bool(run.scene.links) + 1
    figure = new_figure(1.4 + 1.4 * count)
    *panels, below = figure.subplots(count, 1, sharex=True)
    if run.scene.links:
        _add_links(panels.pop(), run)
    for axes, block in zip(panels, blocks, strict=False):
        _add_forces(axes, run, block)
        if len(blocks) > 1:
            axes.set_title(block.name, loc="left")
    for axes, (names, known) in zip(panels[len(blocks) :], pairs, strict=True):
        _add_neighbours(axes, run, names, known)
    _add_slips(below, run)
    below.set(xlabel="time (s)", xlim=moving_span(run.scene, run.history))
    figure.align_ylabels()
    legend_above(figure)
    return figure


def _add_forces(axes: Axes, run: Run, block: BlockSpec) -> None:
    """Normal force and friction on one block, over the weight that stands there."""
    history, name = run.history, block.name
    weight = run.scene.stacked_mass(block) * run.scene.gravity
    ways = ("", "_second") if is_spatial(history, name) else ("",)
    columns = [f"{name}.normal_force_N", *(f"{name}.friction_force{way}_N" for way in ways)]
    _add_curves(axes, history["time_s"], [history[column] for column in columns], weight)
    if weight:
        axes.axhline(1, color=GREY, linewidth=0.5, linestyle=":", zorder=0)


def _neighbours(run: Run) -> list[tuple[tuple[str, str], dict[str, Array]]]:
    """Blocks of which neither carries the other with what they did, those that press most first."""
    found = list(run.neighbours().items())
    found.sort(key=lambda entry: float(np.sum(entry[1]["normal_N"])), reverse=True)
    return found[:MOST_PAIRS]


def _add_neighbours(axes: Axes, run: Run, names: tuple[str, str], known: dict[str, Array]) -> None:
    """Normal force and friction between two blocks, over the smaller of their weights."""
    masses = [block.shape.mass for block in run.scene.blocks if block.name in names]
    columns = ("normal_N", *(name for name in FRICTION if name in known))
    forces = [known[column] for column in columns]
    _add_curves(axes, known["time_s"], forces, min(masses) * run.scene.gravity)
    axes.set_title(f"between {names[0]} and {names[1]}", loc="left")


def _add_curves(axes: Axes, time: Array, forces: Sequence[Array], weight: float) -> None:
    """A normal force and friction along x, and in space along y, N, over a weight if there is one.

    What lasts a row, an impact, is cut off.
    """
    names = ["normal force", "friction force"]
    if len(forces) > 2:
        names[1:] = ["friction force along x", "friction force along y"]
    normal, *friction = (force / (weight or 1.0) for force in forces)
    for force, hue, name in zip((normal, *friction), (BLUE, RED, ORANGE), names, strict=False):
        axes.plot(time, force, color=hue, linewidth=0.8, label=name)
    cut = _cut_impacts(axes, normal, np.concatenate(friction)) if weight else ""
    axes.set_ylabel(f"force / weight{cut}" if weight else "force (N)")
    zero_line(axes)


def _add_links(axes: Axes, run: Run) -> None:
    """Forces of links, tension positive, dashed across them, and where they broke."""
    history, links = run.history, run.summary["links"]
    most = sorted(links, key=lambda name: float(links[name]["peak_force_N"]), reverse=True)
    chosen = [link for link in run.scene.links if link.name in most[:MOST_LINKS]]
    largest = max(float(links[link.name]["peak_force_N"]) for link in chosen)
    unit, factor = ("kN", 1e-3) if largest >= 1e3 else ("N", 1.0)
    named: dict[str, Line2D] = {}
    for number, link in enumerate(chosen):
        hue, broke = colour(number), links[link.name]["broke_at_s"]
        force = factor * history[f"{link.name}.force_N"]
        (curve,) = axes.plot(history["time_s"], force, color=hue, linewidth=0.8)
        named[link.name] = curve
        ways = [f"{link.name}.shear_force{way}_N" for way in ("", "_second")]
        shear = [history[name] for name in ways if name in history]
        if shear:
            across = factor * np.linalg.norm(shear, axis=0)
            axes.plot(history["time_s"], across, color=hue, linewidth=0.8, linestyle=DASHES)
        if broke is not None:
            strength = factor * (link.strength or 0.0)
            axes.plot([broke], [strength], color=hue, marker="x", linestyle="")
    left = len(run.scene.links) - len(chosen)
    more = f" ({left} more)" if left else ""
    axes.set_title(f"links{more}", loc="left")
    dashed = any(f"{link.name}.shear_force_N" in history for link in chosen)
    axes.set_ylabel(f"tension{', shear dashed' * dashed} ({unit})")
    if any(links[link.name]["broke_at_s"] is not None for link in chosen):
        named["breaks"] = Line2D([], [], color="black", marker="x", linestyle="")
    # Colours have other meanings in the other panels, so that it has a legend of its own.
    look = {"ncols": len(named), "borderpad": 0.1, "columnspacing": 1.2, "handlelength": 1.2}
    axes.legend(named.values(), named.keys(), loc="lower right", bbox_to_anchor=(1.0, 1.0), **look)
    zero_line(axes)


def _cut_impacts(axes: Axes, normal: Floats, friction: Floats) -> str:
    """Show what lies between the impacts, which last a row and may be a hundred weights."""
    known = np.abs(np.concatenate([normal, friction]))
    known = known[np.isfinite(known)]
    if not len(known):
        return ""
    limit = max(2.0, 1.3 * float(np.quantile(known, 0.98)))
    axes.set_ylim(max(-limit, 1.15 * float(np.min(friction, initial=-0.2))), limit)
    return "\n(impacts cut off)" if np.max(known) > limit else ""


def _add_slips(axes: Axes, run: Run) -> None:
    """Slips of all blocks; in space those along y are dashed."""
    time, blocks = run.history["time_s"], run.scene.blocks
    for i, block in enumerate(blocks):
        one = len(blocks) == 1
        hue, label = (GREEN, "slip") if one else (colour(i), f"slip of {block.name}")
        slip = 1e3 * run.history[f"{block.name}.slip_m"]
        spatial = is_spatial(run.history, block.name)
        axes.plot(time, slip, color=hue, label=f"{label} along x" if spatial else label)
        if spatial:
            second = 1e3 * run.history[f"{block.name}.slip_second_m"]
            axes.plot(time, second, color=hue, linestyle=DASHES, label=f"{label} along y")
    axes.set_ylabel("slip (mm)")
    least_span(axes, LEAST_LENGTH)
    zero_line(axes)


def draw_platform(run: Run, rigid: Run | None) -> Figure:
    """Drift and acceleration of the platform, and the slips of the blocks on it."""
    figure = new_figure(5.4)
    above, middle, below = figure.subplots(3, 1, sharex=True)
    if rigid is not None and "platform.drift_m" in rigid.history:
        drift = 1e3 * rigid.history["platform.drift_m"]
        slip = 1e3 * rigid.history[f"{run.scene.blocks[0].name}.slip_m"]
        for axes, values in ((above, drift), (middle, slip)):
            time = rigid.history["time_s"]
            axes.plot(time, values, color=ORANGE, linestyle=DASHES, label=rigid.model)
    history, time = run.history, run.history["time_s"]
    above.plot(time, 1e3 * history["platform.drift_m"], color="black", label="platform")
    if "platform.drift_second_m" in history:
        along_y = 1e3 * history["platform.drift_second_m"]
        above.plot(time, along_y, color="black", linestyle=DASHES, label="platform along y")
    above.set_ylabel("drift (mm)")
    least_span(above, LEAST_LENGTH)
    _add_slips(middle, run)
    for (ground, platform), name, line in zip(
        ACCELERATIONS, ("ground", "ground along y"), ("-", DASHES), strict=True
    ):
        if ground in history and platform in history:
            moved = history[ground] / G_UNIT
            below.plot(time, moved, color=GREY, linestyle=line, linewidth=0.8, label=name)
            together = moved + history[platform] / G_UNIT
            below.plot(time, together, color="black", linestyle=line, linewidth=0.8)
    span = moving_span(run.scene, run.history)
    below.set(xlabel="time (s)", ylabel="acceleration (g)", xlim=span)
    for axes in (above, below):
        zero_line(axes)
    figure.align_ylabels()
    legend_above(figure)
    return figure
