"""The interface of a meshed body on the facets of another one: passes in one go."""

from __future__ import annotations

import numpy as np

from solver.contact.body_points import NodePoints, PointState
from solver.contact.facet_target import Face, feet_of, stand_arrays
from solver.contact.increment import ContactIncrement, ForceWeights, Observed, Parts
from solver.contact.kernels.nitsche import new_state
from solver.contact.kernels.on_face import add_forces_on_face, observe_over_face
from solver.contact.passes.nitsche import NitscheInterface
from solver.types import Array


class NitscheOnFace(NitscheInterface):
    """The interface of a meshed body on a face of another one: one compiled call for each pass."""

    carrier: Face

    def observe(self, u: Array | None, carrier_u: Array | None) -> Observed:
        """Where the points and the nodes of the face are for the unknowns of both bodies."""
        points, face, nodes = self.points, self.carrier, self.carrier.points
        if not isinstance(nodes, NodePoints):
            return super().observe(u, carrier_u)
        assert u is not None and carrier_u is not None
        carrier_moved = nodes.layer.reached(carrier_u.reshape(-1, self.dimension))
        bodies = *points.rows, points.nodal(u), nodes.numbers, nodes.reference, carrier_moved
        state, carrier = new_state(points.rows), PointState(np.empty(nodes.reference.shape))
        seen = face.unfilled(self.count, carrier, tractions=True)
        filled = state.values, carrier.position, seen.place, feet_of(seen), seen.augmented
        chain, facets = face.shape
        observe_over_face(chain, facets, bodies, self.inverse_gamma, face.frame, *filled)
        return state, seen

    def add_forces(self, increment: ContactIncrement, on: Parts, weights: ForceWeights) -> None:
        """Add the forces on both bodies, as `Interface.add_forces` does."""
        ((old, old_seen), (new, seen), force), (on_body, on_carrier) = increment, on
        points, face = self.points, self.carrier
        if not isinstance(face.points, NodePoints):
            super().add_forces(increment, on, weights)
            return
        assert on_body is not None and on_carrier is not None
        bodies = points.layer, face.points.layer
        owned = [each.reshape(-1, self.dimension) for each in (on_body, on_carrier)]
        nodal, on_face = (layer.room(each) for layer, each in zip(bodies, owned, strict=True))
        add_forces_on_face(
            *self.pressed(old, new, force, weights),
            stand_arrays(old_seen),
            stand_arrays(seen),
            face.frame,
            face.facet,
            nodal,
            face.points.numbers,
            on_face,
        )
        for layer, target, forces in zip(bodies, owned, (nodal, on_face), strict=True):
            layer.put(target, forces)
