"""Links as the compiled world of rigid bodies has them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from geometry.arrangement import Pose
from solver.kernels.world import Link
from solver.law.links import axes_of, laws_of, sense_of
from solver.scene.link import LinkSpec
from solver.scene.places import link_ends
from solver.types import Array


def link_of(
    spec: LinkSpec,
    placed: Mapping[str, Pose],
    centres: Mapping[str, Array],
    numbers: Mapping[str, int],
) -> Link:
    """A link as the compiled world has it.

    Args:
        spec: The link.
        placed: From the frame of each body to where it stands at the start, by its name.
        centres: Where its centre is then, m.
        numbers: And its number.
    """
    ends = link_ends(spec, placed)
    between = ends[1] - ends[0]
    arms = [
        placed[name].rotation.T @ (end - centres[name])
        for name, end in zip(spec.between, ends, strict=True)
    ]
    axes, length = None, np.asarray(spec.length or float(np.linalg.norm(between)))
    if not spec.is_axial:
        axes = axes_of(spec, placed)
        length = between * np.array([*[1.0] * (len(between) - 1), sense_of(spec, placed)])
    first, second = (numbers[name] for name in spec.between)
    return Link(
        first=first,
        second=second,
        ends=(arms[0], arms[1]),
        axes=axes,
        length=length,
        laws=laws_of(spec, len(between)),
        strength=math.inf if spec.strength is None else spec.strength,
    )
