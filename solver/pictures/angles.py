"""Pictures of how blocks rock: angle against time, phase plane, several runs overlaid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from solver.history.history import History
from solver.pictures.forces import LEAST_LENGTH
from solver.pictures.ground import add_ground
from solver.pictures.style import (
    BLUE,
    DASHES,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    colour,
    largest,
    least_span,
    legend_above,
    new_figure,
    zero_line,
)
from solver.results.motion import angular_velocity, is_spatial, leaning, of_side, total_lean
from solver.results.moving import moving_span
from solver.results.runs import Run, labels
from solver.scene import BlockSpec

#: A drawn angle is no smaller than this, degrees.
LEAST_ANGLE = 1e-3

#: Nor are coordinates of the phase plane.
LEAST_PHASE = 0.01

#: More impacts than this are not marked.
MARKED = 30


def draw_angle(run: Run, rigid: Run | None) -> Figure:
    """Angle of all blocks against time, below the acceleration of the ground where it moves.

    Of one block with its impacts and the rigid one's angle.
    """
    moves = run.scene.motion is not None
    figure = new_figure(3.9 if moves else 2.8)
    ratios = (1, 2) if moves else (1,)
    *above, axes = figure.subplots(
        len(ratios), 1, sharex=True, squeeze=False, height_ratios=ratios
    )[:, 0]
    for panel in above:
        add_ground(panel, run)
    blocks, time = run.scene.blocks, run.history["time_s"]
    if rigid is not None:
        angle = np.degrees(rigid.history[f"{blocks[0].name}.angle_rad"])
        rigid_time = rigid.history["time_s"]
        # Above the run's own, which may hide it.
        look: dict[str, Any] = {"color": ORANGE, "linestyle": DASHES, "zorder": 3}
        axes.plot(rigid_time, angle, label=rigid.model, **look)
    for i, block in enumerate(blocks):
        angle = np.degrees(run.history[f"{block.name}.angle_rad"])
        label = run.model if len(blocks) == 1 else block.name
        axes.plot(time, angle, color=colour(i), label=label)
    span = moving_span(run.scene, run.history)
    axes.set(xlabel="time (s)", ylabel="rocking angle θ (°)", xlim=span)
    if len(blocks) == 1:
        _add_to_one_block(axes, run, blocks[0])
    least_span(axes, LEAST_ANGLE)
    zero_line(axes)
    figure.align_ylabels()
    legend_above(figure)
    return figure


def _add_to_one_block(axes: Any, run: Run, block: BlockSpec) -> None:
    """Details for a single block: impacts, its other angles, the angle over alpha."""
    if is_spatial(run.history, block.name):
        _add_other_angles(axes, run.history, block.name)
    else:
        impacts = np.array([i["time_s"] for i in run.summary["blocks"][block.name]["impacts"]])
        if 0 < len(impacts) <= MARKED:
            zeros = np.zeros(len(impacts))
            axes.plot(impacts, zeros, "o", color=BLUE, markersize=2.5, label="impacts")
    shape = leaning(run.history, block).shape

    def alpha(angle: Any) -> Any:
        """On the side of an angle, which both may be uneven: degrees."""
        return np.degrees(of_side(shape.slenderness, np.asarray(angle)))

    right = axes.secondary_yaxis(
        "right", functions=(lambda y: y / alpha(y), lambda y: y * alpha(y))
    )
    right.set_ylabel("θ/α")


def _add_other_angles(axes: Axes, history: History, name: str) -> None:
    """Lean in any direction, and turn about the vertical, where they are not too small to see."""
    time, lean = history["time_s"], np.degrees(total_lean(history, name))
    turn = np.degrees(history[f"{name}.angle_z_rad"])
    beside = lean - np.abs(np.degrees(history[f"{name}.angle_rad"]))
    visible = 1e-2 * largest(np.concatenate([lean, turn]))
    if largest(beside) > visible:
        axes.plot(time, lean, color=GREEN, linewidth=0.8, label="lean in any direction")
    if largest(turn) > visible:
        axes.plot(time, turn, color=PURPLE, linewidth=0.8, label="about the vertical")


def draw_phase(run: Run, rigid: Run | None) -> Figure:
    """Angular velocity against angle of all blocks, over those of the rigid blocks.

    In space in the upright plane of the largest lean.
    """
    figure = new_figure(3.6, width=4.2)
    axes = figure.subplots()
    blocks = run.scene.blocks
    if rigid is not None:
        _add_phase(axes, rigid, blocks[0], color=ORANGE, linestyle=DASHES, label=rigid.model)
    for i, block in enumerate(blocks):
        label = run.model if len(blocks) == 1 else block.name
        _add_phase(axes, run, block, color=colour(i), label=label)
    axes.set(xlabel="angle θ/α", ylabel=r"angular velocity $\dot\theta/(p\,\alpha)$")
    axes.locator_params(axis="x", nbins=6)
    least_span(axes, LEAST_PHASE)
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, -LEAST_PHASE), max(high, LEAST_PHASE))
    zero_line(axes)
    axes.axvline(0, color=GREY, linewidth=0.5, zorder=0)
    legend_above(figure, columns=2)
    return figure


def _add_phase(axes: Axes, run: Run, block: BlockSpec, **look: Any) -> None:
    """The curve of one block."""
    found = leaning(run.history, block)
    shape, gravity = found.shape, run.scene.gravity
    alpha = of_side(shape.slenderness, found.angle)
    p = of_side(lambda side: shape.frequency(gravity, side), found.angle)
    velocity = angular_velocity(run.history, block.name, found.direction)
    axes.plot(found.angle / alpha, velocity / (p * alpha), linewidth=0.9, **look)


def draw_overlay(runs: Sequence[Run]) -> Figure:
    """Angle and slip of the last block of each of several runs, and drift where a platform is.

    It is the block that films show the angle of. Above them the acceleration of the ground, where
    it moves in all runs alike.
    """
    drifts = any("platform.drift_m" in run.history for run in runs)
    ground = runs[0].scene.motion is not None and _same_ground(runs)
    rows = 2 + drifts + ground
    figure = new_figure(1.4 + 1.4 * rows)
    panels = list(figure.subplots(rows, 1, sharex=True))
    if ground:
        add_ground(panels.pop(0), runs[0])
    for i, (run, label) in enumerate(zip(runs, labels(runs), strict=True)):
        time, name = run.history["time_s"], run.scene.blocks[-1].name
        label = f"{label}, {name}" if len(run.scene.blocks) > 1 else label
        angle = np.degrees(run.history[f"{name}.angle_rad"])
        panels[0].plot(time, angle, color=colour(i), label=label)
        panels[1].plot(time, 1e3 * run.history[f"{name}.slip_m"], color=colour(i))
        if "platform.drift_m" in run.history:
            panels[2].plot(time, 1e3 * run.history["platform.drift_m"], color=colour(i))
    panels[0].set_ylabel("rocking angle (°)")
    least_span(panels[0], LEAST_ANGLE)
    panels[1].set_ylabel("slip (mm)")
    least_span(panels[1], LEAST_LENGTH)
    if drifts:
        panels[2].set_ylabel("drift (mm)")
    spans = [moving_span(run.scene, run.history) for run in runs]
    span = min(begin for begin, _ in spans), max(end for _, end in spans)
    panels[-1].set(xlabel="time (s)", xlim=span)
    for axes in panels:
        zero_line(axes)
    figure.align_ylabels()
    legend_above(figure)
    return figure


def _same_ground(runs: Sequence[Run]) -> bool:
    """True if the ground moves alike in all runs."""
    return all(run.scene.motion == runs[0].scene.motion for run in runs)
