"""The laws of links: springs with gaps and dashpots, which may yield, one for each direction."""

from __future__ import annotations

import math
from collections.abc import Mapping

from geometry.arrangement import Pose
from solver.kernels.world import LinkLaw
from solver.scene.link import LinkSpec
from solver.scene.places import second_is_above
from solver.types import Array


def sense_of(spec: LinkSpec, placed: Mapping[str, Pose]) -> float:
    """Factor on the vertical axis that makes extensions positive where the two bodies part."""
    return 1.0 if second_is_above(spec, placed) else -1.0


def axes_of(spec: LinkSpec, placed: Mapping[str, Pose]) -> Array:
    """Axes of a link that is not axial, in the own frame of its first body, (d, d).

    At the start they are those of space, and turn with the body from there.
    """
    axes = placed[spec.between[0]].rotation.copy()
    axes[-1] *= sense_of(spec, placed)
    return axes


def laws_of(spec: LinkSpec, d: int) -> list[LinkLaw]:
    """The law along the link, or those along its axes, the vertical one last."""
    bound = math.inf if spec.yields is None else spec.yields
    gap = spec.gap or 0.0
    along = LinkLaw(
        stiffness=spec.stiffness,
        damping=spec.damping,
        gap=gap if spec.preload is None else -spec.preload / spec.stiffness,
        compression=not spec.pulls,
        yields=bound,
    )
    if spec.is_axial:
        return [along]
    across = LinkLaw(
        stiffness=spec.shear_stiffness,
        damping=spec.damping,
        gap=spec.shear_gap or 0.0,
        yields=bound,
    )
    return [*[across] * (d - 1), along]
