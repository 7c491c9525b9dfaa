"""A run and its twin, which starts or is shaken a millionth more: up to when both are the same.

Where steps are adaptive the twin of a run also has a fourth of its tolerance.

Rocking is sensitive: an impact of a block that comes a little later meets another ground. What two
runs so close do not share is not a matter of the scene any more, but of its last digits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from solver.errors import RockslipError, SceneError, Statement
from solver.history.history import History
from solver.results.motion import is_spatial, slenderness, total_lean
from solver.scene import Scene
from solver.types import Array

PERTURBATION = 1e-6
"""Relative difference between both."""

FINER = 4.0
"""Tolerance of adaptive steps in a run, over that in its twin."""

APART = 1e-2
"""Difference of two angles, over alpha, from which on they are not the same."""

ANGLES = {False: ("angle_rad",), True: ("angle_x_rad", "angle_y_rad")}
"""Columns that are compared of a block in the plane, and of one in space."""


def twin_of(scene: Scene, perturbation: float = PERTURBATION) -> Scene:
    """The scene with other amplitudes of the ground's motion; where it is still, another start."""
    output, factor = replace(scene.output, twin=False), 1 + perturbation
    if scene.motion is not None:
        return replace(scene, motion=scene.motion.times(factor), output=output)
    blocks = tuple(
        replace(
            block,
            tilt_deg=factor * block.tilt_deg,
            velocity=_times(block.velocity, factor),
            angular_velocity=_times(block.angular_velocity, factor),
        )
        for block in scene.blocks
    )
    return replace(scene, blocks=blocks, output=output)


def finer_twin_of(scene: Scene) -> Scene:
    """The twin of a scene, in adaptive steps of a smaller tolerance.

    A millionth makes no difference to a history that its tolerance decides.
    """
    twin = twin_of(scene)
    if twin.time.tolerance is None:
        return twin
    return replace(twin, time=replace(twin.time, tolerance=twin.time.tolerance / FINER))


def refuse_without_twin(scene: Scene, where: str = "output.twin") -> None:
    """Refuse a scene that has nothing to perturb, or whose perturbed twin is no valid scene.

    Raises:
        Statement: Before the scene itself is run; it names the key that requests a twin.
    """
    if scene.motion is None and all(block.begins_at_rest for block in scene.blocks):
        raise Statement(where, "needs something to perturb: a motion, a tilt or a velocity")
    try:
        twin_of(scene)
    except SceneError as error:
        raise Statement(
            where,
            f"needs a twin, and the scene perturbed by a millionth is no valid one: {error}",
        ) from None


def _times(rate: Any, factor: float) -> Any:
    """One number, or several, times a factor."""
    if isinstance(rate, tuple):
        return tuple(factor * value for value in rate)
    return factor * rate


def difference(scene: Scene, history: History, twin: History) -> tuple[Array, Array]:
    """Times up to which both go, and the largest difference of an angle of a block over its alpha.

    That in the direction of its largest lean. The steps of both may differ: the twin is read
    between its rows.
    """
    own, other = history["time_s"], twin["time_s"]
    time = own[own <= other[-1] * (1 + 1e-12)]
    apart: Array = np.zeros(len(time))
    for block in scene.blocks:
        most = np.argmax(np.abs(total_lean(history, block.name)))
        alpha = slenderness(history, block)[most]
        for name in ANGLES[is_spatial(history, block.name)]:
            column = f"{block.name}.{name}"
            beside = np.interp(time, other, twin[column])
            turned = np.abs(history[column][: len(time)] - beside)
            apart = np.maximum(apart, turned / alpha)
    return time, apart


def horizon(scene: Scene, history: History, twin: History) -> float | None:
    """The time up to which a history means something, s; None: to its end."""
    time, apart = difference(scene, history, twin)
    beyond = np.flatnonzero(apart > APART)
    if len(beyond):
        return float(time[beyond[0]])
    # One of both has ended before: it overturned, or fell.
    return None if len(time) == len(history["time_s"]) else float(time[-1])


def horizon_beside(
    scene: Scene, history: History, run_twin: Callable[[Scene], tuple[str, History]]
) -> dict[str, Any]:
    """Entry of a summary on the time up to which a run and its twin, run now, are the same.

    `run_twin` gives status and history of the run of a scene.
    """
    twin = finer_twin_of(scene)
    perturbed = "start" if scene.motion is None else "motion"
    known: dict[str, Any] = {"perturbed": perturbed, "perturbation": PERTURBATION, "apart": APART}
    known["tolerance"] = twin.time.tolerance
    try:
        status, beside = run_twin(twin)
    except RockslipError as error:  # the run itself is done
        return known | {"status": f"refused: {error}", "time_s": None}
    return known | {"status": status, "time_s": horizon(scene, history, beside)}
