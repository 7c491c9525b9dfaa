"""The interface of a meshed body on a plane, the ground's or a platform's: passes in one go."""

from __future__ import annotations

import numpy as np

from solver.contact.body_points import NitschePoints, SurfaceState
from solver.contact.increment import ContactIncrement
from solver.contact.interface import Interface
from solver.contact.kernels.nitsche import NitscheState, new_state, pull_weights
from solver.contact.kernels.nitsche_on_plane import add_forces_on_plane, observe_over_plane
from solver.contact.plane_target import Plane
from solver.contact.projection import ContactKinematics
from solver.types import Array


class NitscheOnPlane(Interface):
    """What `Interface` is for any points and any carrier, with one compiled call each.

    The compiled functions call those that an `Interface` calls one by one.
    """

    points: NitschePoints
    carrier: Plane

    def observe(
        self, u: Array | None, carrier_u: Array | None
    ) -> tuple[SurfaceState, ContactKinematics]:
        """Where the points and the plane are for the unknowns of both bodies."""
        assert u is not None
        points, plane = self.points, self.carrier
        platform = None if plane.points is None else plane.points.observe(carrier_u)
        state = new_state(points.rows)
        place, y = np.empty(points.reference.shape), np.empty(points.reference.shape)
        observe_over_plane(
            *points.rows,
            points.nodal(u),
            plane.origin,
            plane.shift(platform),
            plane.frame,
            self.inverse_gamma,
            state.values,
            place,
            y,
        )
        return state, ContactKinematics(place, y, plane.frame, platform)

    def add_forces(
        self,
        increment: ContactIncrement,
        on_body: Array | None,
        on_carrier: Array | None,
        *,
        contact_weight: float,
        traction_weight: float,
        sign: float,
    ) -> None:
        """Add the forces on both bodies, as `Interface.add_forces` does."""
        assert on_body is not None
        old, new = increment.before.surface, increment.surface
        assert isinstance(old, NitscheState) and isinstance(new, NitscheState)
        points, total = self.points, np.empty(self.dimension)
        owned = on_body.reshape(-1, self.dimension)
        nodal = points.layer.room(owned)
        add_forces_on_plane(
            points.rows.numbers,
            points.rows.table,
            old.values,
            new.values,
            increment.force,
            sign * contact_weight,
            self.carrier.frame,
            self.theta != 0,
            self.pull_scale,
            *pull_weights(traction_weight, sign),
            nodal,
            total,
        )
        points.layer.put(owned, nodal)
        if on_carrier is not None:
            self._add_reaction(increment, -total[None, :], on_carrier)
