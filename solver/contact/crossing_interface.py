"""The interface of crossing edges: contact points that are places between the nodes of two bodies.

Which pairs of edges cross is settled before each step, and so are the frames. Slip counts from
there, so that the stick memory is 0 at the start of every step.
"""

from __future__ import annotations

import numpy as np

from solver.contact.body_points import SurfaceState
from solver.contact.edge_crossings import Crossings
from solver.contact.interface import Interface, Key, Memory
from solver.contact.projection import ContactKinematics, spread
from solver.law.friction import FrictionLaw
from solver.types import Array, Mask


class CrossingInterface(Interface):
    """Kinematics and forces of the contact between the outlines of two faces."""

    def __init__(self, carrier: Crossings, law: FrictionLaw):
        """Take the outlines that may cross, and the law of friction."""
        super().__init__(carrier.upper.points, carrier, law, count=carrier.count)
        self.crossings = carrier

    def _named(self) -> list[Key]:
        """Numbers: no face joins an outline."""
        return [(float(k),) for k in range(self.count)]

    def start(self, u: Array | None, carrier_u: Array | None, rotation: Array) -> Memory:
        """A memory without contact forces."""
        surface, carried = self._seen(u, carrier_u)
        none = np.zeros(self.count, dtype=bool)
        seat = self.crossings.meet(surface.position, carried, (surface.position, carried.position))
        may_touch = self.crossings.present.copy()
        force, anchor = np.zeros((self.count, 3)), np.zeros((self.count, 2))
        return Memory(surface, seat, force, anchor, may_touch, none, none)

    def _seen(self, u: Array | None, carrier_u: Array | None) -> tuple[SurfaceState, SurfaceState]:
        """Where the nodes of both outlines are."""
        return self.points.observe(u), self.crossings.points.observe(carrier_u)

    def prepare(self, memory: Memory, u: Array | None, carrier_u: Array | None) -> None:
        """Settle which edges cross in the coming step, and the frames.

        Args:
            memory: Changed in place.
            u: Unknowns of the upper body expected in the middle of the step.
            carrier_u: Those of the lower one.
        """
        assert memory.seat.carrier is not None
        middle = self._seen(u, carrier_u)
        memory.seat = self.crossings.meet(
            memory.surface.position, memory.seat.carrier, (middle[0].position, middle[1].position)
        )
        memory.may_touch = self.crossings.present.copy()
        memory.force[~memory.may_touch] = 0.0
        memory.anchor[:] = 0.0

    def rotate_frame(
        self, memory: Memory, rotation: Array, carrier_rotation: Array | None
    ) -> float:
        """Nothing is left to do after `prepare`, and no energy is stored."""
        return 0.0

    def augmented(self, surface: SurfaceState, seat: ContactKinematics) -> Array:
        """Y = (g - rest, s) of all pairs, (16, 3), m."""
        y = seat.place.copy()
        y[:, 0] -= self.crossings.rest
        return y

    def inside(self, memory: Memory) -> Mask:
        """Pairs that cross at this instant, not only at some time in its step."""
        assert memory.seat.carrier is not None
        return self.crossings.within(memory.surface.position, memory.seat.carrier.position)

    def point_forces(
        self, old: ContactKinematics, new: ContactKinematics, force: Array
    ) -> tuple[Array, Array | None]:
        """Point forces as vectors in space on the nodes of both outlines."""
        vectors = self.carrier.vectors(old, new, force)
        assert old.tip is not None and new.tip is not None
        on_points = spread(old.tip, new.tip, vectors, self.points.count)
        return on_points, self.carrier.reaction(old, new, vectors)
