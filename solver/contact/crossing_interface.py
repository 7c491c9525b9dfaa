"""The interface of crossing edges: contact points that are places between the nodes of two bodies.

Which pairs of edges cross is settled before each step, and so are the frames. Slip counts from
there, so that the stick memory is 0 at the start of every step.
"""

from __future__ import annotations

import numpy as np

from solver.contact.body_points import Key, SurfaceState
from solver.contact.edge_crossings import Crossings
from solver.contact.interface import Interface
from solver.contact.memory import Memory
from solver.contact.projection import ContactKinematics, spread
from solver.law.friction import new_pasts
from solver.scene import Bed, FrictionSpec
from solver.types import Array, Mask


class CrossingInterface(Interface):
    """Kinematics and forces of the contact between the outlines of two faces."""

    def __init__(
        self,
        carrier: Crossings,
        law: FrictionSpec,
        *,
        bed: Bed | None = None,
        corner_area: float = 0.0,
    ):
        """Take the outlines that may cross; all else as `Interface`."""
        points, count = carrier.upper.points, carrier.count
        super().__init__(points, carrier, law, count=count, bed=bed, corner_area=corner_area)
        self.crossings = carrier

    def _named(self) -> list[Key]:
        """The number of each pair: no face joins an outline."""
        return [(float(k),) for k in range(self.count)]

    def start(self, u: Array | None, carrier_u: Array | None, rotation: Array) -> Memory:
        """The memory of pairs without contact forces."""
        surface, carried = self._observed(u, carrier_u)
        kinematics = self.crossings.meet(
            surface.position, carried, (surface.position, carried.position), np.zeros(self.count)
        )
        return Memory(
            surface=surface,
            kinematics=kinematics,
            force=np.zeros((self.count, 3)),
            anchor=np.zeros((self.count, 2)),
            may_touch=self.crossings.present.copy(),
            past=new_pasts(self.count),
            compression=np.zeros(self.count),
            rest=np.zeros(self.count),
        )

    def _observed(
        self, u: Array | None, carrier_u: Array | None
    ) -> tuple[SurfaceState, SurfaceState]:
        """Where the nodes of both outlines are."""
        return self.points.observe(u), self.crossings.points.observe(carrier_u)

    def prepare(self, memory: Memory, u: Array | None, carrier_u: Array | None) -> Memory:
        """Settle which edges cross in the coming step, and the frames.

        Args:
            memory: Of t_n.
            u: Unknowns of the upper body expected in the middle of the step.
            carrier_u: Those of the lower one.

        Returns:
            The memory that the step starts from.
        """
        assert memory.kinematics.carrier is not None
        upper, lower = self._observed(u, carrier_u)
        kinematics = self.crossings.meet(
            memory.surface.position,
            memory.kinematics.carrier,
            (upper.position, lower.position),
            memory.compression,
        )
        present = self.crossings.present.copy()
        return memory._replace(
            kinematics=kinematics,
            force=np.where(present[:, None], memory.force, 0.0),
            anchor=np.zeros_like(memory.anchor),
            may_touch=present,
            compression=np.where(present, memory.compression, 0.0),
        )

    def apart(self, surface: SurfaceState, kinematics: ContactKinematics) -> float:
        """How far the one outline is within the other, m; negative where it is not."""
        assert kinematics.carrier is not None
        return self.crossings.depth_inside(surface.position, kinematics.carrier.position)

    def inside(self, memory: Memory) -> Mask:
        """Pairs that cross at this instant, not only at some time in its step."""
        assert memory.kinematics.carrier is not None
        return self.crossings.within(memory.surface.position, memory.kinematics.carrier.position)

    def point_forces(
        self, old: ContactKinematics, new: ContactKinematics, force: Array
    ) -> tuple[Array, Array | None]:
        """Point forces as vectors in space on the nodes of both outlines."""
        vectors = self.carrier.vectors(old, new, force)
        first, last = old.own_projection, new.own_projection
        assert first is not None and last is not None
        on_points = spread(first, last, vectors, self.points.count)
        return on_points, self.carrier.reaction(old, new, vectors)
