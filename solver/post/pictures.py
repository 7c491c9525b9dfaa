"""Pictures of runs for papers: angle, phase plane, energy, forces, and several runs overlaid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from solver.post.deformed import draw_deformed
from solver.post.history import DISSIPATED_ENERGIES, History
from solver.post.runs import FIELDS, Run
from solver.reference.answer import reference_history, reference_name
from solver.specs import BlockSpec

Array = NDArray[np.float64]

#: Colours that are told apart by everyone (Okabe and Ito 2008).
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY, GREY = "#CC79A7", "#56B4E9", "#666666"
PALETTE = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY)

DASHES = (0, (4, 1.5))

#: Width of a column of text, in.
WIDTH = 6.3

STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.5,
    "hatch.linewidth": 0.4,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "lines.linewidth": 1.1,
    "savefig.dpi": 200,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
}

LOSS_LABELS = {
    "friction": "friction",
    "damping": "damping",
    "contact": "impact",
    "numerical": "time integration",
}


def picture_run(run: Run) -> list[Path]:
    """Draw everything about one run into its folder; returns the files."""
    housner = reference_history(run.scene)
    figures: dict[str, Callable[[], Figure]] = {
        "angle.png": lambda: _angle(run, housner),
        "phase.png": lambda: _phase(run, housner),
        "forces.png": lambda: _forces(run),
    }
    if np.all(np.isfinite(run.history["energy.ledger_error_J"])):
        figures["energy.png"] = lambda: _energy(run)
    if (run.folder / FIELDS).is_file():
        figures["deformed.png"] = lambda: _deformed(run)
    return [_save(draw, run.folder / name) for name, draw in figures.items()]


def picture_runs(runs: Sequence[Run], folder: Path) -> list[Path]:
    """Overlay angle and slip of the first blocks of several runs; returns the files."""
    return [_save(lambda: _overlay(runs), folder / "overlay.png")]


def _overlay(runs: Sequence[Run]) -> Figure:
    """Angle and slip of several runs."""
    figure = _figure(4.2)
    above, below = figure.subplots(2, 1, sharex=True)
    for i, run in enumerate(runs):
        time, name, colour = run.history["time_s"], _block(run).name, PALETTE[i % len(PALETTE)]
        angle = np.degrees(run.history[f"{name}.angle_rad"])
        above.plot(time, angle, color=colour, label=run.label)
        below.plot(time, 1e3 * run.history[f"{name}.slip_m"], color=colour)
    above.set_ylabel("rocking angle (°)")
    below.set(xlabel="time (s)", ylabel="slip (mm)")
    for axes in (above, below):
        _zero_line(axes)
    figure.legend(loc="outside upper center", ncols=min(4, len(runs)))
    return figure


def _angle(run: Run, housner: History) -> Figure:
    """Angle against time, with the rigid block's."""
    figure = _figure(2.8)
    axes = figure.subplots()
    block = _block(run)
    column = f"{block.name}.angle_rad"
    time, angle = run.history["time_s"], np.degrees(run.history[column])
    if _model(run) != reference_name(run.scene):
        rigid = np.degrees(housner[column])
        label = reference_name(run.scene)
        axes.plot(housner["time_s"], rigid, color=ORANGE, linestyle=DASHES, label=label)
    axes.plot(time, angle, color=BLUE, label=_model(run))
    impacts = np.array([i["time_s"] for i in run.summary["blocks"][block.name]["impacts"]])
    if 0 < len(impacts) <= 30:
        zeros = np.zeros(len(impacts))
        axes.plot(impacts, zeros, "o", color=BLUE, markersize=2.5, label="impacts")
    axes.set(xlabel="time (s)", ylabel="rocking angle θ (°)", xlim=(time[0], time[-1]))
    alpha = np.degrees(block.shape.slenderness)
    right = axes.secondary_yaxis("right", functions=(lambda y: y / alpha, lambda y: y * alpha))
    right.set_ylabel("θ/α")
    _zero_line(axes)
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def _phase(run: Run, housner: History) -> Figure:
    """Angular velocity against angle, both over those of the rigid block."""
    figure = _figure(3.6, width=4.2)
    axes = figure.subplots()
    block = _block(run)
    alpha, p = block.shape.slenderness, block.shape.frequency(run.scene.gravity)
    curves = [
        (housner, ORANGE, DASHES, reference_name(run.scene)),
        (run.history, BLUE, "-", _model(run)),
    ]
    for history, colour, line, label in curves[_model(run) == reference_name(run.scene) :]:
        angle = history[f"{block.name}.angle_rad"] / alpha
        velocity = history[f"{block.name}.angular_velocity_rad_s"] / (p * alpha)
        axes.plot(angle, velocity, color=colour, linestyle=line, label=label, linewidth=0.9)
    axes.set(xlabel="angle θ/α", ylabel=r"angular velocity $\dot\theta/(p\,\alpha)$")
    axes.locator_params(axis="x", nbins=6)
    _zero_line(axes)
    axes.axvline(0, color=GREY, linewidth=0.5, zorder=0)
    figure.legend(loc="outside upper center", ncols=2)
    return figure


def _forces(run: Run) -> Figure:
    """Forces from the foundation over the weight, and slip."""
    figure = _figure(4.2)
    above, below = figure.subplots(2, 1, sharex=True)
    block, time = _block(run), run.history["time_s"]
    weight = block.shape.weight(run.scene.gravity)
    normal = run.history[f"{block.name}.normal_force_N"] / weight
    friction = run.history[f"{block.name}.friction_force_N"] / weight
    above.plot(time, normal, color=BLUE, linewidth=0.8, label="normal force")
    above.plot(time, friction, color=RED, linewidth=0.8, label="friction force")
    above.axhline(1, color=GREY, linewidth=0.5, linestyle=":", zorder=0)
    known = np.abs(np.concatenate([normal, friction]))
    known = known[np.isfinite(known)]
    if len(known):
        # Impacts last one row and may be a hundred weights: this is for what lies between them.
        limit = max(2.0, 1.3 * float(np.quantile(known, 0.98)))
        cut = " (impacts cut off)" if np.max(known) > limit else ""
        above.set_ylim(max(-limit, 1.15 * float(np.min(friction, initial=-0.2))), limit)
        above.set_ylabel(f"force / weight{cut}")
    slip = 1e3 * run.history[f"{block.name}.slip_m"]
    below.plot(time, slip, color=GREEN, label="slip")
    # A block that keeps its place to a hundredth of a millimetre shall look like it.
    span = (min(-0.1, 1.1 * np.min(slip)), max(0.1, 1.1 * np.max(slip)))
    below.set(xlabel="time (s)", ylabel="slip (mm)", xlim=(time[0], time[-1]), ylim=span)
    for axes in (above, below):
        _zero_line(axes)
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def _energy(run: Run) -> Figure:
    """Above: where the energy is. Below: where it went, and how far the ledger is from closing."""
    figure = _figure(5.0)
    above, below = figure.subplots(2, 1, sharex=True)
    history, time = run.history, run.history["time_s"]
    upright = sum(b.shape.weight(run.scene.gravity) * b.height / 2 for b in run.scene.blocks)
    parts = {
        "kinetic": (history["energy.kinetic_J"], BLUE),
        "gravity above upright": (history["energy.gravity_J"] - upright, GREEN),
        "strain": (history["energy.strain_J"], RED),
        "platform spring": (history["energy.spring_J"], PURPLE),
        "interface": (history["energy.interface_J"], SKY),
    }
    largest = max(float(np.max(np.abs(values))) for values, _ in parts.values())
    for label, (values, colour) in parts.items():
        if np.max(np.abs(values)) > 1e-3 * largest:
            above.plot(time, values, color=colour, linewidth=0.9, label=label)
    total = history["energy.total_J"]
    above.plot(time, total - upright, color="black", linewidth=1.2, label="total")
    above.set_ylabel("energy (J)")
    above.legend(loc="upper right", ncols=2)

    lost = {name: history[f"energy.{name}_J"] for name in DISSIPATED_ENERGIES}
    work = history["energy.input_J"]
    below.plot(time, work - total + total[0], color="#c0c0c0", linewidth=3.5, label="energy lost")
    for (name, values), colour in zip(lost.items(), (RED, SKY, BLUE, ORANGE), strict=True):
        if np.any(values != 0):
            below.plot(time, values, color=colour, linewidth=0.9, label=LOSS_LABELS[name])
    together = np.sum(list(lost.values()), axis=0)
    below.plot(time, together, "k", linewidth=0.9, label="sum of the causes")
    if np.any(work != 0):
        below.plot(time, work, color=PURPLE, linewidth=0.9, label="work of the ground")
    fraction = run.summary["energy"]["ledger_error_fraction"]
    below.set(xlabel="time (s)", ylabel="dissipated (J)", xlim=(time[0], time[-1]))
    below.set_title(f"ledger closes to {fraction:.1e} of the energy scale", loc="left")
    below.legend(loc="best", ncols=2)
    for axes in (above, below):
        _zero_line(axes)
    return figure


def _deformed(run: Run) -> Figure:
    """The block at a few instants."""
    figure = _figure(3.4)
    draw_deformed(figure, run.folder / FIELDS, instants(run))
    return figure


def instants(run: Run) -> list[float]:
    """Four times worth a look: start, first impact, the peak after it, end (s)."""
    time = run.history["time_s"]
    first, last = float(time[0]), float(time[-1])
    block = run.summary["blocks"][_block(run).name]
    impact = [i["time_s"] for i in block["impacts"][:1]]
    after = [p["time_s"] for p in block["peaks"] if impact and p["time_s"] > impact[0]][:1]
    if impact and after:
        return [first, *impact, *after, last]
    return [float(t) for t in np.linspace(first, last, 4)]


def _model(run: Run) -> str:
    """What made the run."""
    return str(run.summary["model"])


def _block(run: Run) -> BlockSpec:
    """The block that pictures show."""
    return run.scene.blocks[0]


def _zero_line(axes: Axes) -> None:
    """A thin line at zero, behind the curves."""
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=0)


def _figure(height: float, width: float = WIDTH) -> Any:
    """A figure of that size (in) that needs no screen and leaves no global state behind."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _save(draw: Callable[[], Figure], file: Path) -> Path:
    """Draw a figure in the style of all, and write it."""
    with mpl.rc_context(STYLE):
        draw().savefig(file)
    return file
