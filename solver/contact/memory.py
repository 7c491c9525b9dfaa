"""What an interface remembers from one step to the next, and what a step lost in it."""

from __future__ import annotations

from typing import NamedTuple

from solver.contact.body_points import SurfaceState
from solver.contact.increment import Observed
from solver.contact.projection import ContactKinematics
from solver.law.friction import slipped_before
from solver.types import Array, Indices, Mask


class Memory(NamedTuple):
    """The state of contact of an interface at one instant; its arrays are never written to.

    Attributes:
        surface: Positions of the points, and tractions where they have any.
        kinematics: Their gaps and tangential positions, and the frame that both are given in.
        force: Point forces f = w l on the body of the points, (points, d), N: normal, tangential.
        anchor: Stick memory, (points, d-1), m.
        may_touch: Points that may touch: of the coinciding points of a corner, the one whose face
            opposes the carrier; no point that came round the carrier's edge.
        past: What they remember of their friction (`solver.law.friction.PAST`), (points, PAST).
        compression: Of the bed below them, (points,), m; 0 where there is none.
        rest: Gaps from which points that were below their carrier's surface beyond its edge are not
            pushed out, since that would gain energy; 0 for others, (points,), m.
        clear: How far the points and their carrier may move, together, before anybody has to look
            where they are, m: an interface far from contact. Until then all else stays as it was
            when that was done last. 0 where every step looks.
    """

    surface: SurfaceState
    kinematics: ContactKinematics
    force: Array
    anchor: Array
    may_touch: Mask
    past: Array
    compression: Array
    rest: Array
    clear: float = 0.0

    @property
    def seen(self) -> Observed:
        """The points, and where they are."""
        return self.surface, self.kinematics

    @property
    def slipped(self) -> Mask:
        """Points that slipped in the last step."""
        return slipped_before(self.past)

    def take(self, rows: Indices, other: Memory, others: Indices) -> Memory:
        """This memory, with what another one remembers of some points, there `others`, here `rows`.

        Surface and kinematics stay: they say where points are, and those here are up to date.
        """
        kept = {}
        for name in REMEMBERED:
            values = getattr(self, name).copy()
            values[rows] = getattr(other, name)[others]
            kept[name] = values
        return self._replace(**kept)

    def until(self, clear: float) -> Memory:
        """This memory with another `clear`, m."""
        return self._replace(clear=clear)


KINEMATICS = ("surface", "kinematics", "clear")
"""Fields of a memory that say where points are; all others follow from the past alone."""

REMEMBERED = tuple(name for name in Memory._fields if name not in KINEMATICS)
"""Fields of a memory that hold what only the past tells, one row for each point."""


class Dissipation(NamedTuple):
    """What a step lost in an interface, J; `damping` in the dashpots of its bed."""

    friction: float
    contact: float
    damping: float


NOTHING_LOST = Dissipation(friction=0.0, contact=0.0, damping=0.0)
"""What a step loses where nothing touches."""
