"""The links of a run as lines, for ParaView."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from geometry.arrangement import Pose, level
from solver.fields.part import Part, in_space
from solver.history.link_columns import BROKEN, LinkRows
from solver.scene import Scene
from solver.scene.laws import GROUND
from solver.scene.names import LINKS
from solver.scene.places import own_ends
from solver.types import Array

if TYPE_CHECKING:
    from solver.fields.vtu import PvdFiles

LINE = 3
"""VTK's number of a line."""

LEFT = 0.2
"""Part of the distance between the ends of a broken link that is drawn at each of them."""

COLUMNS = ("extension_m", "state", "force_N", "shear_force_N", "shear_force_second_N")
"""Columns of a link in a history; those of shear are of links along axes."""


class LinkFields:
    """Writer of all links.

    Each is two lines, from its ends to its middle; of one that is broken each is a fifth of the
    distance between its ends.
    """

    def __init__(self, scene: Scene, files: PvdFiles):
        """Where the ends are on bodies that stand upright, as those do in the files."""
        self._scene = scene
        upright = {GROUND: level(np.zeros(scene.dimension))} | scene.poses(upright=True)
        self._own_ends = [own_ends(link, scene.poses()) for link in scene.links]
        """Both ends of each link in the own frames of its bodies, (d,), m."""
        self._mesh = _lines(self.ends_by(upright), np.zeros(len(scene.links)))
        numbers = np.arange(4 * len(scene.links)).reshape(-1, 2)
        part = Part(points=in_space(self._mesh), nodes=numbers, kind=LINE)
        self._writer = files.body(LINKS, part)
        columns = COLUMNS[: 2 + scene.dimension]
        self._names = [[f"{link.name}.{name}" for link in scene.links] for name in columns]
        self._rows = LinkRows(scene.links, scene.dimension)

    def ends_by(self, frames: Mapping[str, Pose]) -> Array:
        """Where the ends of all links are, (links, 2, d), m.

        By the motions from the own frames of blocks, and from that of the foundation, by names.
        """
        pairs = zip(self._scene.links, self._own_ends, strict=True)
        return np.array(
            [
                [frames[name](end[None])[0] for name, end in zip(link.between, own, strict=True)]
                for link, own in pairs
            ]
        )

    def write(self, time: float, ends: Array, numbers: Array) -> None:
        """Write the links at a time, s.

        Args:
            time: s.
            ends: Where their ends are, (links, 2, d), m.
            numbers: Of all links, as `LinkStates.split` takes them apart.
        """
        known, none = self._rows.columns(numbers[None]), [0.0]
        extension, state, tension, *shear = (
            np.array([known.get(name, none)[0] for name in names]) for names in self._names
        )
        means = {
            "tension": tension,
            "shear_force": np.linalg.norm(shear, axis=0),
            "extension": extension,
            "state": state,
        }
        twice = {name: np.repeat(values, 2) for name, values in means.items()}
        moved = _lines(ends, state) - self._mesh
        self._writer.write(time, {"displacement": in_space(moved)}, twice)


def _lines(ends: Array, states: Array) -> Array:
    """Ends of both lines of links by their states, (4 links, d), m."""
    first, second = ends[:, 0], ends[:, 1]
    part = np.where(states == BROKEN, LEFT, 0.5)[:, None] * (second - first)
    lines = np.stack([first, first + part, second, second - part], axis=1)
    return lines.reshape(-1, ends.shape[2])
