"""The links of a run as lines, for ParaView."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from geometry.arrangement import Pose, level
from solver.fields.part import Part, in_space
from solver.rigid.links import BROKEN, LinkRows
from solver.scene import Scene
from solver.scene.laws import GROUND
from solver.scene.names import LINKS
from solver.scene.places import own_ends
from solver.types import Array

if TYPE_CHECKING:
    from solver.fields.files import FieldFiles

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

    def __init__(self, scene: Scene, files: FieldFiles):
        """Where the ends are on bodies that stand upright, as those do in the files."""
        self._scene = scene
        upright, placed = scene.poses(upright=True), scene.poses()
        self._own = [own_ends(link, placed) for link in scene.links]
        dimension = scene.dimension
        here = {GROUND: level(np.zeros(dimension))} | dict(upright)
        self._mesh = self._lines(here, np.zeros(len(scene.links)))
        numbers = np.arange(4 * len(scene.links)).reshape(-1, 2)
        part = Part(points=in_space(self._mesh), nodes=numbers, kind=LINE)
        self._writer = files.body(LINKS, part)
        columns = COLUMNS[: 2 + dimension]
        names = [f"{link.name}.{name}" for link in scene.links for name in columns]
        self._rows, self._names = LinkRows(scene.links, names, dimension), names

    def write(self, time: float, frames: Mapping[str, Pose], numbers: Array) -> None:
        """Write the links at a time, s.

        Args:
            time: s.
            frames: From the own frame of each block, and from that of the foundation, by names, to
                where it is.
            numbers: Of all links, as `LinkStates.split` takes them apart.
        """
        row: Array = np.zeros((1, len(self._names)))
        self._rows.write(row, numbers[None])
        known = dict(zip(self._names, row[0], strict=True))
        extension, state, tension = (
            np.array([known[f"{link.name}.{name}"] for link in self._scene.links])
            for name in COLUMNS[:3]
        )
        shear = [
            [known[f"{link.name}.{name}"] for name in COLUMNS[3 : 2 + self._scene.dimension]]
            for link in self._scene.links
        ]
        moved = self._lines(frames, state) - self._mesh
        means = {
            "tension": tension,
            "shear_force": np.linalg.norm(shear, axis=1),
            "extension": extension,
            "state": state,
        }
        twice = {name: np.repeat(values, 2) for name, values in means.items()}
        self._writer.write(time, {"displacement": in_space(moved)}, twice)

    def _lines(self, frames: Mapping[str, Pose], state: Array) -> Array:
        """Ends of both lines of each link, by its state, (4 links, d), m."""
        found = []
        for link, own, number in zip(self._scene.links, self._own, state, strict=True):
            first, second = (
                frames[name](end[None])[0] for name, end in zip(link.between, own, strict=True)
            )
            part = (LEFT if number == BROKEN else 0.5) * (second - first)
            found += [first, first + part, second, second - part]
        return np.array(found)

    def close(self) -> None:
        """Finish the files."""
        self._writer.close()
