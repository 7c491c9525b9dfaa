"""What answers a case of a suite: rigid blocks, elastic ones, or Housner's equation."""

from __future__ import annotations

import time
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from solver.errors import SceneError

if TYPE_CHECKING:
    from solver.excitation.motion import GroundMotion
    from solver.reference.rocking_peaks import RockingPeaks
    from solver.scene import Scene

RIGID, ELASTIC, ODE = ENGINES = ("rigid", "elastic", "ode")

LATER = 8.0
"""Time after the end in which a block beyond its point of balance falls, times p."""


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


def _mode(found: RockingPeaks, slenderness: float) -> str:
    """The mode of a block that rocks or stands, as summaries name it."""
    from solver.results.rocking import SMALLEST_SWING

    if found.overturned_at is not None:
        return "overturned"
    return "rock" if found.angle > SMALLEST_SWING * slenderness else "rest"


def equation(scene: Scene, ground: GroundMotion) -> dict[str, Any]:
    """The row of a case by Housner's equation, which knows no slip.

    Raises:
        SceneError: The ground does not move along x alone, by samples.
    """
    from solver.excitation.sampled import SampledMotion
    from solver.reference.rocking_peaks import sampled_rocking
    from solver.results.cautions import cautions_of_input
    from solver.scene.motion import G_UNIT

    along = ground.along
    if not isinstance(along, SampledMotion) or any(ground.parts[1:]):
        got = "more directions" if isinstance(along, SampledMotion) else "no samples"
        raise SceneError("motion", got, "samples along x alone for Housner's equation (ode)")
    block, began = scene.blocks[0], time.perf_counter()
    end, alpha = scene.time.end, block.shape.slenderness

    def until(time: float) -> RockingPeaks:
        return sampled_rocking(
            block.shape, along, gravity=scene.gravity, end=time, restitution=block.restitution
        )

    found = until(end)
    if found.overturned_at is None and found.angle > alpha:
        # As in runs: it has overturned if it ends beyond its point of balance, and falls later.
        fallen = until(end + LATER / block.shape.frequency(scene.gravity)).overturned_at is not None
        found = replace(found, overturned_at=end if fallen else None)
    return {
        "status": "completed",
        "reason": "",
        "end_s": scene.time.end if found.overturned_at is None else found.overturned_at,
        "pga_g": along.peak / G_UNIT,
        f"{block.name}.peak_angle_rad": found.angle,
        f"{block.name}.peak_angle_while_standing_rad": found.angle,
        f"{block.name}.peak_angle_over_alpha": found.angle / alpha,
        f"{block.name}.peak_angle_over_alpha_while_standing": found.angle / alpha,
        f"{block.name}.mode": _mode(found, alpha),
        f"{block.name}.overturned_at_s": found.overturned_at,
        "wall_s": time.perf_counter() - began,
        "cautions": "; ".join(cautions_of_input(scene, ground)),
    }
