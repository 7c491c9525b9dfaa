"""Pictures of the study: lambda over the map, base shear, and where the roots come from."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.pictures.style import (
    DASHES,
    GREY,
    colour,
    legend_above,
    new_figure,
    zero_line,
)
from solver.study.inertia.cells import AXES
from solver.study.inertia.numbers import SLIDING, Finding, Line, mean_curve, number
from solver.study.tables import groups

MOST_LINES = 6
"""Structures whose curves of drift are drawn."""

DARK = 0.55
"""Above it the numbers of a map are white."""

NAMES = {"period": "T =", "friction": "μ =", "friction_over_pga": "μ g/PGA =", "aspect": "H/B =",
         "mass_ratio": "mass ratio", "damping_ratio": "ξ ="}  # fmt: skip
"""Names of the axes in legends."""

UNITS = {"period": " s"}

CODE_VALUES = {0.25: "storage live load", 0.67: "storage racks"}
"""Portions of the live load that codes count; docs/inertia.md has their clauses."""

Value = Callable[[Finding], tuple[float, float, float] | None]
"""A value of a cell and the ends of its interval; None: there is none."""


def lambda_picture(findings: Sequence[Finding]) -> Figure:
    """Lambda against the last axis, with the values of codes."""
    figure = curves_picture(findings, of_lambda, "portion of live load λ")
    (axes,) = figure.axes
    _code_lines(axes)
    zero_line(axes)
    return figure


def shear_picture(findings: Sequence[Finding]) -> Figure:
    """Base shear over that with the whole live load fixed against the last axis."""
    label = "base shear / that of the fixed live load"
    return curves_picture(findings, lambda f: (f.means["base_shear_over_fixed"],) * 3, label)


def of_lambda(finding: Finding) -> tuple[float, float, float] | None:
    """Lambda by the mean of peaks."""
    portion = finding.arithmetic
    if portion.value is None or portion.low is None or portion.high is None:
        return None
    return portion.value, min(portion.low, portion.value), max(portion.high, portion.value)


def curves_picture(findings: Sequence[Finding], value: Value, label: str) -> Figure:
    """A value against the last axis, a curve for each value of the one before."""
    figure = new_figure(3.8)
    axes = figure.subplots()
    axes.set_title(_named(findings[0].cell.values[:-2]), loc="left")
    families = groups(findings, lambda finding: finding.cell.values[-2:-1])
    for place, (height, family) in enumerate(families.items()):
        beside = place - (len(families) - 1) / 2
        for by, chosen in groups(family, lambda finding: finding.by).items():
            named = by == SLIDING or not height
            word = _named(height) or by
            _curve(axes, chosen, value, colour(place), beside, word if named else None)
    axes.set(xlabel=AXES[findings[0].cell.values[-1][0]], ylabel=label)
    others = dict.fromkeys(f.by for f in findings if f.by != SLIDING)
    if others:
        words = " and ".join(others)
        axes.plot([], [], "o", markerfacecolor="none", color=GREY, label=words)
    legend_above(figure, columns=4)
    return figure


def _named(values: Sequence[tuple[str, float]]) -> str:
    """Values of axes in words."""
    return ", ".join(f"{NAMES[name]} {v:g}{UNITS.get(name, '')}" for name, v in values)


def _curve(
    axes: Axes,
    chosen: Sequence[Finding],
    value: Value,
    tint: str,
    beside: float,
    label: str | None,
) -> None:
    """One curve with its intervals; those of engines are rings.

    Bars of several curves stand side by side: `beside` numbers them from the middle.
    """
    known = [(f.cell.values[-1][1], found) for f in chosen if (found := value(f)) is not None]
    if not known:
        return
    at = np.array([x for x, _ in known])
    middle, low, high = np.array([found for _, found in known]).T
    closed = chosen[0].by == SLIDING
    at = at * (1 + 0.006 * beside)
    axes.errorbar(
        at, middle, yerr=np.array([middle - low, high - middle]), color=tint,
        linestyle="-" if closed else "none", marker="o", markersize=3 if closed else 7,
        markerfacecolor=tint if closed else "none",
        capsize=2 if closed and np.any(high > low) else 0, elinewidth=0.7 if closed else 0,
        linewidth=1.0, label=label,
    )  # fmt: skip


def _code_lines(axes: Axes) -> None:
    """The values of codes, named at the right."""
    for portion, name in CODE_VALUES.items():
        axes.axhline(portion, color=GREY, linewidth=0.8, linestyle=DASHES, zorder=1)
        axes.annotate(
            f"{portion:g} {name}", (1.0, portion),
            xycoords=("axes fraction", "data"), xytext=(0, 2), textcoords="offset points",
            ha="right", va="bottom", fontsize="small", color=GREY,
        )  # fmt: skip


def map_picture(findings: Sequence[Finding]) -> Figure:
    """A map of lambda by one way, with a number and half its interval in each cell."""
    across, up = (name for name, _ in findings[0].cell.values[-2:])
    columns = sorted({f.cell.values[-2][1] for f in findings})
    rows = sorted({f.cell.values[-1][1] for f in findings})
    shade = np.full((len(rows), len(columns)), np.nan)
    figure = new_figure(1.2 + 0.34 * len(rows))
    axes = figure.subplots()
    for f in findings:
        i, j = rows.index(f.cell.values[-1][1]), columns.index(f.cell.values[-2][1])
        value = f.arithmetic.value
        shade[i, j] = np.nan if value is None else value
        half = f.arithmetic.half_width
        text = number(value) if value is None else f"{number(value)} ±{half:.2f}"
        dark = value is not None and value > DARK
        axes.text(j, i, text, ha="center", va="center", fontsize=7, color="w" if dark else "k")
    image = axes.imshow(shade, origin="lower", aspect="auto", cmap="Blues", vmin=0, vmax=1)
    axes.set_xticks(range(len(columns)), [f"{value:g}" for value in columns])
    axes.set_yticks(range(len(rows)), [f"{value:g}" for value in rows])
    axes.grid(visible=False)
    others = _named(findings[0].cell.values[:-2])
    axes.set_title(", ".join(filter(None, (findings[0].by, others))), loc="left")
    axes.set(xlabel=AXES[across], ylabel=AXES[up])
    figure.colorbar(image, ax=axes, label="λ", fraction=0.05, pad=0.02)
    return figure


def roots_picture(lines: Sequence[Line], findings: Sequence[Finding]) -> Figure:
    """Mean drift against lambda, a curve for each structure, with the drifts of cells met on it.

    Dots are the roots reported, rings the others.
    """
    figure = new_figure(3.8)
    axes = figure.subplots()
    for place, line in enumerate(lines[:MOST_LINES]):
        curve = mean_curve(line.drifts)
        fixed = float(line.peaks[:, 0, 0].mean())
        structure = line.structure
        name = f"T {structure.period:g} s, mass ratio {structure.mass_ratio:g}"
        axes.plot(curve.portions, curve.drifts / fixed, color=colour(place), label=name)
        for f in findings:
            if f.cell.structure != structure or f.by != SLIDING:
                continue
            for root in f.arithmetic.roots:
                reported = f.arithmetic.value is not None and abs(root - f.arithmetic.value) < 1e-9
                axes.plot(
                    root, f.means["drift_over_fixed"], "o", color=colour(place),
                    markersize=4 if reported else 6,
                    markerfacecolor=colour(place) if reported else "none",
                )  # fmt: skip
    axes.set(
        xlabel="portion of the live load that is fixed, λ", ylabel="mean drift / that of λ = 1"
    )
    axes.set_ylim(0, None)
    axes.set_title("dots: roots reported, rings: further roots", loc="left")
    legend_above(figure, columns=3)
    return figure
