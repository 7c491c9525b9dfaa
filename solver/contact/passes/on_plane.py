"""The interface of a meshed body on a plane, endless or with ends: passes in one go."""

from __future__ import annotations

import numpy as np

from solver.contact.body_points import SurfaceState
from solver.contact.held_face import HeldFace
from solver.contact.increment import ContactIncrement, ForceWeights, Observed, Parts
from solver.contact.kernels.nitsche import NitscheState, new_state
from solver.contact.kernels.on_plane import (
    add_forces_on_plane,
    observe_over_plane,
    press_on_plane,
)
from solver.contact.passes.nitsche import NitscheInterface
from solver.contact.plane_target import Plane
from solver.contact.projection import ContactKinematics
from solver.types import Array, Mask

NOTHING: Array = np.empty(0)
"""Room for a sum that nobody asks for."""


class NitscheOnPlane(NitscheInterface):
    """The interface of a meshed body on a plane: one compiled call for each pass."""

    carrier: Plane | HeldFace

    def observe(self, u: Array | None, carrier_u: Array | None) -> Observed:
        """Where the points and the plane are for the unknowns of both bodies."""
        assert u is not None
        points, platform = self.points, self._platform(carrier_u)
        state, seen, beyond = self._room(platform)
        given = *points.rows, points.nodal(u), self.carrier.lies(platform), self.inverse_gamma
        observe_over_plane(*given, state.values, seen.place, beyond, seen.augmented)
        return state, seen

    def _platform(self, carrier_u: Array | None) -> SurfaceState | None:
        """Where the points of the carrier are; None for the ground."""
        points = self.carrier.points
        return None if points is None else points.observe(carrier_u)

    def _room(self, platform: SurfaceState | None) -> tuple[NitscheState, ContactKinematics, Mask]:
        """Room for what is seen over a carrier whose points are there, to be filled in."""
        seen, beyond = self.carrier.room(self.count, platform, tractions=True)
        return new_state(self.points.rows), seen, beyond

    def _sum_for(self, on_carrier: Array | None) -> Array:
        """Room for the sum of the forces, where the carrier takes them."""
        return NOTHING if on_carrier is None else np.empty(self.dimension)

    def press(
        self, before: Observed | None, at: Parts, force: Array, on: Parts, weights: ForceWeights
    ) -> Observed:
        """Look where the points are, and add forces on both bodies, as `Interface.press` does."""
        (u, carrier_u), (on_body, on_carrier) = at, on
        assert u is not None and on_body is not None
        platform = self._platform(carrier_u)
        state, seen, beyond = self._room(platform)
        old, old_seen = before or (state, seen)
        assert isinstance(old, NitscheState)
        points, total = self.points, self._sum_for(on_carrier)
        owned = on_body.reshape(-1, self.dimension)
        nodal = points.layer.room(owned)
        press_on_plane(
            *points.rows,
            points.nodal(u),
            self.carrier.lies(platform),
            self.inverse_gamma,
            old.values,
            force,
            *weights,
            self.theta != 0,
            self.pull_scale,
            state.values,
            seen.place,
            beyond,
            seen.augmented,
            nodal,
            total,
        )
        points.layer.put(owned, nodal)
        if on_carrier is not None:
            self._add_reaction(old_seen, seen, -total[None, :], on_carrier)
        return state, seen

    def add_forces(self, increment: ContactIncrement, on: Parts, weights: ForceWeights) -> None:
        """Add the forces on both bodies, as `Interface.add_forces` does."""
        ((old, old_seen), (new, seen), force), (on_body, on_carrier) = increment, on
        assert on_body is not None
        points, total = self.points, self._sum_for(on_carrier)
        owned = on_body.reshape(-1, self.dimension)
        nodal = points.layer.room(owned)
        given = self.pressed(old, new, force, weights)
        add_forces_on_plane(*given, self.carrier.frame, nodal, total)
        points.layer.put(owned, nodal)
        if on_carrier is not None:
            self._add_reaction(old_seen, seen, -total[None, :], on_carrier)
