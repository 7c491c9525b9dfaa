"""Pictures of energy: where it is, and where it went."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.history.columns import DISSIPATED_ENERGIES
from solver.pictures.style import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    largest,
    legend_over,
    new_figure,
    zero_line,
)
from solver.results.energy import gravity_above_upright
from solver.results.moving import moving_span
from solver.results.report import CAUSES
from solver.results.runs import Run

#: A fall is cut off where the picture would be so many times as high.
DWARFED = 1.5


def draw_energy(run: Run) -> Figure:
    """Above: where the energy is. Below: where it went, and how far the ledger is from closing."""
    figure = new_figure(5.2)
    above, below = figure.subplots(2, 1, sharex=True)
    _add_stored(above, run)
    _add_lost(below, run)
    fraction = run.summary["energy"]["ledger_error_fraction"]
    span = moving_span(run.scene, run.history)
    below.set(xlabel="time (s)", xlim=span)
    cut = "\n(fall cut off)" if _cut_fall((above, below), run) else ""
    above.set_ylabel(f"energy (J){cut}")
    below.set_ylabel(f"work (J){cut}")
    if fraction is not None:
        figure.supxlabel(f"ledger closes to {fraction:.1e} of the energy scale", fontsize="small")
    for axes in (above, below):
        zero_line(axes)
        legend_over(axes, columns=3)
    figure.align_ylabels()
    return figure


def _cut_fall(panels: Sequence[Axes], run: Run) -> bool:
    """Show the energies of blocks that stand where those of a fall would dwarf them.

    Returns whether something is cut off.
    """
    entries = run.summary["blocks"].values()
    lost = [entry[key] for entry in entries for key in ("overturned_at_s", "fell_at_s")]
    until = min((time for time in lost if time is not None), default=math.inf)
    stands = run.history["time_s"] <= until
    if math.isinf(until) or stands.sum() < 2:
        return False
    cut = False
    for axes in panels:
        curves = [np.asarray(line.get_ydata()) for line in axes.lines]
        shown = np.concatenate([values[stands] for values in curves if len(values) == len(stands)])
        low, high = float(np.nanmin(shown)), float(np.nanmax(shown))
        margin = 0.15 * (high - low)
        bottom, top = axes.get_ylim()
        if margin > 0 and top - bottom > DWARFED * (high - low):
            axes.set_ylim(low - margin, high + margin)
            cut = True
    return cut


def _add_stored(axes: Axes, run: Run) -> None:
    """The stored energies; that of gravity above the blocks standing upright."""
    history, time = run.history, run.history["time_s"]
    gravity, total = history["energy.gravity_J"], history["energy.total_J"]
    upright = gravity[0] - gravity_above_upright(run.scene, history)[0]
    parts: dict[str, tuple[Any, str]] = {
        "kinetic": (history["energy.kinetic_J"], BLUE),
        "gravity above upright": (gravity - upright, GREEN),
        "strain": (history["energy.strain_J"], RED),
        "platform spring": (history["energy.spring_J"], PURPLE),
        "interface": (history["energy.interface_J"], SKY),
    }
    most = max(largest(values) for values, _ in parts.values())
    for label, (values, hue) in parts.items():
        if largest(values) > 1e-3 * most:
            axes.plot(time, values, color=hue, linewidth=0.9, label=label)
    axes.plot(time, total - upright, color="black", linewidth=1.2, label="total")


def _add_lost(axes: Axes, run: Run) -> None:
    """Dissipated energies by cause, and the work of the ground."""
    history, time = run.history, run.history["time_s"]
    work, total = history["energy.input_J"], history["energy.total_J"]
    lost = {name: history[f"energy.{name}_J"] for name in DISSIPATED_ENERGIES}
    axes.plot(time, work - total + total[0], color="#c0c0c0", linewidth=3.5, label="energy lost")
    for (name, values), hue in zip(lost.items(), (RED, SKY, GREEN, BLUE, ORANGE), strict=True):
        if np.any(values != 0):
            axes.plot(time, values, color=hue, linewidth=0.9, label=CAUSES[name])
    together = np.sum(list(lost.values()), axis=0)
    axes.plot(time, together, "k", linewidth=0.9, label="sum of the causes")
    if np.any(work != 0):
        axes.plot(time, work, color=PURPLE, linewidth=0.9, label="work of the ground")
