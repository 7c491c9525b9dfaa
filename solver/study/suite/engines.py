"""What answers a case of a suite: rigid blocks, elastic ones, or Housner's equation."""

from __future__ import annotations

import time
from collections.abc import Mapping
from copy import deepcopy
from typing import TYPE_CHECKING, Any

from solver.errors import SceneError

if TYPE_CHECKING:
    from solver.excitation.motion import GroundMotion
    from solver.scene import Scene

RIGID, ELASTIC, ODE = ENGINES = ("rigid", "elastic", "ode")

STEP, LONGEST, TOLERANCE = 0.01, 0.04, 1e-6
"""Steps between rows of the equation, and of its integration, times p; its relative tolerance."""


def with_model(tables: Mapping[str, Any], engine: str | None) -> dict[str, Any]:
    """The tables of a scene for an engine; without one they stay as they are.

    A restitution is of rigid blocks alone: elastic ones have their own.
    """
    made = deepcopy(dict(tables))
    for block in made["block"] if engine else ():
        block["model"] = ELASTIC if engine == ELASTIC else RIGID
        if engine == ELASTIC:
            block.pop("restitution", None)
    return made


def equation(scene: Scene, ground: GroundMotion) -> dict[str, Any]:
    """The summary of a case by Housner's equation, which knows no slip.

    Raises:
        SceneError: The ground does not move along x alone, by samples.
    """
    from solver.excitation.sampled import SampledMotion
    from solver.reference.answer import as_history, rock
    from solver.results.doubtful_input import cautions_of_input
    from solver.results.summary import summarise

    along = ground.along
    if not isinstance(along, SampledMotion) or any(ground.parts[1:]):
        got = "more directions" if isinstance(along, SampledMotion) else "no samples"
        raise SceneError("motion", got, "samples along x alone for Housner's equation (ode)")
    began, p = time.perf_counter(), scene.blocks[0].shape.frequency(scene.gravity)
    known = rock(scene, ground, step=STEP / p, longest=LONGEST / p, tolerance=TOLERANCE)
    history, _ = as_history(scene, known)
    found = summarise(scene, history, status="completed", cost={}, versions={}, ground=ground)
    cost = {"wall_s": time.perf_counter() - began}
    return found | {"cost": cost, "cautions": cautions_of_input(scene, ground)}
