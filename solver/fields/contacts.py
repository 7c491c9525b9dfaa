"""The forces between bodies that touch as points, for ParaView."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from solver.fields.part import Part, in_space
from solver.history.pairs import FRICTION, force_on_first, pair_columns
from solver.scene import Scene
from solver.scene.laws import GROUND
from solver.scene.names import CONTACTS
from solver.types import Array

if TYPE_CHECKING:
    from solver.fields.vtu import PvdFiles

VERTEX = 1
"""VTK's number of a point."""

LONGEST = 3.0
"""An arrow is drawn no longer than this, over the one of the largest weight: impacts are."""


class ContactFields:
    """Writer of what pairs of bodies do: a point for each pair that presses, where it does."""

    def __init__(self, scene: Scene, files: PvdFiles):
        """Begin without points; bodies have the numbers of the blocks, the ground the next one."""
        numbers = {block.name: number for number, block in enumerate(scene.blocks)}
        numbers[GROUND] = len(scene.blocks)
        self._carried = {
            (numbers[name], number)
            for number, block in enumerate(scene.blocks)
            for name in block.carriers
        }
        """Blocks on others: the numbers of the lower and the upper one."""
        self._columns = pair_columns(scene.dimension)[3:-1]
        self._writer = files.body(CONTACTS, _points(np.empty((0, scene.dimension))))

    def write(self, time: float, pairs: Array) -> None:
        """Write pairs as `World.pairs` has them after one step, which ends at a time, s."""
        known = {name: pairs[:, 4 + k] for k, name in enumerate(self._columns)}
        force, normal_force = force_on_first(known), known["normal_N"]
        friction = [known[name] for name in FRICTION if name in known]
        acts = np.any(force != 0, axis=1)
        force, normal_force, both = force[acts], normal_force[acts], pairs[acts, 1:3].astype(int)
        for number, pair in enumerate(both):
            if tuple(pair) in self._carried:  # the force on the upper one, as in films
                both[number], force[number] = pair[::-1], -force[number]
        axes = "xyz"[: force.shape[1]]
        places = np.stack([known[f"{axis}_m"][acts] for axis in axes], axis=1)
        fields = {
            "displacement": np.zeros((len(both), 3)),
            "force": in_space(force),
            "normal_force": normal_force,
            "friction_force": np.linalg.norm(friction, axis=0)[acts],
            "body": both[:, 0],
            "other": both[:, 1],
        }
        self._writer.renew(_points(places))
        self._writer.write(time, fields, {})


def _points(places: Array) -> Part:
    """Points as cells, by their places, m, (n, d)."""
    return Part(points=in_space(places), nodes=np.arange(len(places))[:, None], kind=VERTEX)


def arrow_of_weight(scene: Scene) -> float:
    """Length of an arrow that stands for the largest weight, m."""
    return 0.3 * max(block.shape.height for block in scene.blocks)


def largest_weight(scene: Scene) -> float:
    """The largest weight that stands on anything, N; 1 without gravity."""
    return max(scene.stacked_masses.values()) * scene.gravity or 1.0
