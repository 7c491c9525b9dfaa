"""Forces on blocks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from solver.errors import SceneError, missing_key
from solver.scene.checking import Checked, exactly_one, only_where, shown
from solver.scene.names import refuse_name
from solver.scene.quantities import Course, Dimension, Forces, Instant, Position, Pressure

NORMALS = {
    "left": (0, 1.0),
    "right": (0, -1.0),
    "front": (1, 1.0),
    "back": (1, -1.0),
    "bottom": (-1, 1.0),
    "top": (-1, -1.0),
}
"""Of each face the axis along which a pressure on it pushes, and the sense."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceSpec(Checked):
    """A force on a block: `[[force]]`."""

    name: str = "force"
    """Its name, as that of a block, and different from those of all blocks, links and forces."""
    on: str
    """Name of the block."""
    at: Position | None = None
    """Place on the block at which it acts, m, from the middle of its bottom as it stands upright;
    not with `pressure`. Default: its centre of mass; on an elastic block all of its mass."""
    force: Forces | None = None
    """Along x and y, in 3-D along x, y and z, N. Default: this or `pressure`."""
    pressure: Pressure | None = None
    """On a `face`, Pa, such as C rho v²/2 of wind; below 0 it sucks. Default: this or `force`."""
    face: Literal["left", "right", "front", "back", "top", "bottom"] | None = None
    """Face, in 2-D not `"front"` and `"back"`: left at -x, right at +x, front at -y, back at +y.
    Default: with `pressure` required."""
    ramp: tuple[Instant, Instant] | None = None
    """It is 0 up to the first time, then grows linearly up to the second, s. Default: constant from
    the start."""
    table: Course | None = None
    """Rows of a time, s, and a factor on it: linear between the rows, constant before the first and
    after the last. Not with `ramp`. Default: -."""

    def check(self) -> None:
        """Refuse values that do not go together."""
        refuse_name(self.name)
        exactly_one(self, "force", "pressure")
        if self.pressure is not None and self.face is None:
            raise missing_key("face", "beside pressure")
        only_where(self, self.force is None, "pressure, not to force", "face")
        what = "force; a pressure acts in the middle of its face"
        only_where(self, self.pressure is None, what, "at")
        if self.ramp is not None and self.table is not None:
            raise SceneError("table", "both ramp and table", "at most one of ramp and table")
        if self.ramp is not None and not self.ramp[0] < self.ramp[1]:
            raise SceneError("ramp", shown(self.ramp), "two times, the later one second")
        if self.table is not None:
            times = [time for time, _ in self.table]
            if not times or any(late <= early for early, late in pairwise(times)):
                raise SceneError("table", shown(self.table), "one row or more, of growing times")

    def refuse_elsewhere(self, dimension: Dimension) -> None:
        """Refuse a face that is not of the scene's dimension."""
        if dimension == 2 and self.face in ("front", "back"):
            raise SceneError("face", shown(self.face), '"left", "right", "top" or "bottom" in 2-D')

    @property
    def settled(self) -> float:
        """Time from which on it stays as it is, s."""
        if self.ramp is not None:
            return self.ramp[1]
        return self.table[-1][0] if self.table is not None else 0.0
