"""The interface of a meshed body on the facets of another one: passes in one go."""

from __future__ import annotations

from typing import Any

import numpy as np

from solver.contact.body_points import NitschePoints, NodePoints, PointState
from solver.contact.facet_target import Face, feet_of, stand_arrays
from solver.contact.increment import ContactIncrement, ForceWeights, Observed, Parts
from solver.contact.interface import Interface
from solver.contact.kernels.nitsche import NitscheState, new_state
from solver.contact.kernels.on_face import (
    add_forces_on_face,
    observe_over_chain,
    observe_over_facets,
)
from solver.types import Array


class NitscheOnFace(Interface):
    """The interface of a meshed body on a face of another one: one compiled call for each pass.

    These call the functions that an `Interface` of any points and carrier calls one by one.
    """

    points: NitschePoints
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
        given: Any = bodies, self.inverse_gamma, face.frame, state.values, carrier.position
        given = *given, seen.place, feet_of(seen), seen.augmented
        if face.chain is not None:
            observe_over_chain(face.chain, *given)
        else:
            observe_over_facets(face.shapes, *given)
        return state, seen

    def add_forces(self, increment: ContactIncrement, on: Parts, weights: ForceWeights) -> None:
        """Add the forces on both bodies, as `Interface.add_forces` does."""
        ((old, old_seen), (new, seen), force), (on_body, on_carrier) = increment, on
        points, face = self.points, self.carrier
        if not isinstance(face.points, NodePoints):
            super().add_forces(increment, on, weights)
            return
        assert isinstance(old, NitscheState) and isinstance(new, NitscheState)
        assert on_body is not None and on_carrier is not None
        bodies = points.layer, face.points.layer
        owned = [each.reshape(-1, self.dimension) for each in (on_body, on_carrier)]
        nodal, on_face = (layer.room(each) for layer, each in zip(bodies, owned, strict=True))
        add_forces_on_face(
            points.rows.numbers,
            points.rows.table,
            old.values,
            new.values,
            force,
            *weights,
            self.theta != 0,
            self.pull_scale,
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
