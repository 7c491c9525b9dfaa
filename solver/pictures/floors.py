"""The picture and the table of floor response spectra."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from solver.excitation.spectrum import DAMPING, PERIODS
from solver.pictures.style import DASHES, colour, legend_above, new_figure, plain_periods
from solver.results.floor_spectra import ALONG_Y
from solver.scene.motion import G_UNIT
from solver.types import Array


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
