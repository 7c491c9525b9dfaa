"""Surface points of bodies as contact sees them: where they are, and forces put on them.

They are points with Nitsche tractions on a meshed body, nodes of a meshed body, material points of
a rigid one, or points that stand still.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.bodies.rigid_body import DenseBody
from solver.bodies.surface_layer import Layer
from solver.contact.nitsche_points import ContactPoints, NitscheState, TractionPull, new_state
from solver.kernels import meshed
from solver.types import Array, Indices


@dataclass(slots=True)
class PointState:
    """Positions of surface points at one instant.

    Attributes:
        position: x, (points, d), m.
        pose: All unknowns of the rigid body they belong to; None for nodes of a mesh.
    """

    position: Array
    pose: Array | None = None


Key = tuple[float, ...]
"""Identifies a point of a body: its face and its place."""

KEY_DECIMALS = 7
"""Decimals, of the body's size, to which the places in keys of points are rounded."""

SurfaceState = PointState | NitscheState
"""State of surface points at one instant."""


class FixedPoints:
    """Points that stand still: of what is fully restrained."""

    def __init__(self, positions: Array):
        """Take the positions, (n, d)."""
        self.reference = positions
        self.count, self.dimension = positions.shape
        self.size = float(np.max(np.ptp(positions, axis=0)))

    def some(self, chosen: Indices) -> FixedPoints:
        """Some of the points."""
        return FixedPoints(self.reference[chosen])

    def observe(self, u: Array | None) -> PointState:
        """Positions of the points, which never change."""
        return PointState(self.reference)

    def velocity(self, u: Array | None, v: Array | None) -> Array:
        """Zero: they stand still."""
        return np.zeros_like(self.reference)

    def add_forces(self, target: Array, old: SurfaceState, new: SurfaceState, force: Array) -> None:
        """Leave the unknowns alone: reactions of fixed points are not computed."""


class NodePoints:
    """Nodes of a meshed body: those of a layer, in its order."""

    def __init__(self, body: ElasticBody | ReducedBody, layer: Layer, positions: Array):
        """Take the layer, and the undeformed positions of its nodes, (n, d), m."""
        self.body, self.layer, self.reference = body, layer, positions
        self.count, self.dimension = positions.shape
        self.size = float(np.max(np.ptp(positions, axis=0)))

    def some(self, chosen: Indices) -> NodePoints:
        """Some of the points; collective."""
        return NodePoints(self.body, self.layer.part(chosen), self.reference[chosen])

    def _gather(self, values: Array) -> Array:
        """Nodal values, (n, d), from owned unknowns."""
        return self.layer.gather(values.reshape(-1, self.dimension))

    def observe(self, u: Array | None) -> PointState:
        """Positions of the nodes for the owned unknowns u."""
        assert u is not None
        return PointState(self.reference + self._gather(u))

    def velocity(self, u: Array | None, v: Array | None) -> Array:
        """Velocities of the nodes."""
        assert v is not None
        return self._gather(v)

    def add_forces(self, target: Array, old: SurfaceState, new: SurfaceState, force: Array) -> None:
        """Add forces on the nodes, (n, d), N, to the owned unknowns' forces."""
        self.layer.add(target.reshape(-1, self.dimension), force)


class RigidPoints:
    """Material points of a rigid block or of a platform."""

    def __init__(self, body: DenseBody, points: Array, area: Array | None = None):
        """Take the points, (n, d), in the body's own frame, and the area each stands for, m2."""
        self.body, self.reference = body, points
        self.area: Array = np.zeros(len(points)) if area is None else area
        self.count, self.dimension = points.shape
        self.size = float(np.max(np.ptp(points, axis=0)))

    def some(self, chosen: Indices) -> RigidPoints:
        """Some of the points."""
        return RigidPoints(self.body, self.reference[chosen], self.area[chosen])

    def observe(self, u: Array | None) -> PointState:
        """Positions of the points for the owned unknowns u."""
        assert u is not None
        pose = self.body.replicate(u)
        return PointState(self.body.material_positions(self.reference, pose), pose)

    def velocity(self, u: Array | None, v: Array | None) -> Array:
        """Velocities of the points."""
        assert u is not None and v is not None
        return self.rows(self.body.replicate(u)) @ self.body.replicate(v)

    def rows(self, pose: Array) -> Array:
        """Derivatives of the points' positions over all unknowns, (n, d, unknowns)."""
        return self.body.rows(self.reference, pose)

    def add_forces(self, target: Array, old: SurfaceState, new: SurfaceState, force: Array) -> None:
        """Add forces on the points, (n, d), N, to the owned unknowns' forces.

        Their work between the two states, at t_n and at t_{n+1}, is exact.
        """
        assert isinstance(old, PointState) and isinstance(new, PointState)
        assert old.pose is not None and new.pose is not None
        rows = self.body.increment_rows(self.reference, old.pose, new.pose)
        target += (force.ravel() @ rows.reshape(force.size, -1))[self.body.own]


class SummedPoints(RigidPoints):
    """Sums of material points of a rigid body, each of which counts with a share."""

    def __init__(self, body: DenseBody, points: Array, shares: Array):
        """Take the points, (n, d), in the body's own frame, and their shares, (sums, n)."""
        super().__init__(body, points)
        self.count, self._shares = len(shares), shares

    def observe(self, u: Array | None) -> PointState:
        """The sums for the owned unknowns u."""
        state = super().observe(u)
        return PointState(self._shares @ state.position, state.pose)

    def rows(self, pose: Array) -> Array:
        """Derivatives of the sums over all unknowns, (sums, d, unknowns)."""
        return np.asarray(np.tensordot(self._shares, super().rows(pose), 1), dtype=np.float64)

    def add_forces(self, target: Array, old: SurfaceState, new: SurfaceState, force: Array) -> None:
        """Add forces on the sums, (sums, d), N; as of points."""
        super().add_forces(target, old, new, self._shares.T @ force)


class NitschePoints:
    """Contact points of a meshed body, which know the traction of the body there.

    Attributes:
        rows: What turns displacements of the nodes that `nodal` gives into positions and tractions.
        layer: The nodes of the cells there.
    """

    def __init__(self, body: ElasticBody, points: ContactPoints):
        """Take the points."""
        self.body, self.points = body, points
        self.count, self.dimension = points.count, points.dimension
        self.reference, self.size = points.reference, points.size
        self.layer = points.layer
        numbers = points.rows.numbers.copy()
        numbers[:, 1:] = points.layer.numbers(numbers[:, 1:])
        self.rows = points.rows._replace(numbers=numbers)
        self._index, self._table, _ = self.rows

    def nodal(self, u: Array) -> Array:
        """Values of the nodes that the rows reach, (n, d), from those of the owned unknowns."""
        return self.layer.reached(u.reshape(-1, self.dimension))

    def observe(self, u: Array | None) -> NitscheState:
        """Positions and tractions for the owned unknowns u."""
        assert u is not None
        state = new_state(self.rows)
        meshed.evaluate(*self.rows, self.nodal(u), state.values)
        return state

    def velocity(self, u: Array | None, v: Array | None) -> Array:
        """Velocities of the points."""
        assert u is not None and v is not None
        velocity = np.empty_like(self.reference)
        meshed.point_values(self._index, self._table, self.nodal(v), velocity)
        return velocity

    def add_forces(
        self,
        target: Array,
        old: SurfaceState,
        new: SurfaceState,
        force: Array,
        pull: TractionPull | None = None,
    ) -> None:
        """Add forces on the points, and `pull` times the traction's derivative, to the forces."""
        owned = target.reshape(-1, self.dimension)
        nodal = self.layer.room(owned)
        if pull is None:
            meshed.add_point_forces(self._index, self._table, force, nodal)
        else:
            assert isinstance(old, NitscheState) and isinstance(new, NitscheState)
            scale, pulled, frame, before, after = pull
            states, weights = (old.values, new.values), (before, after)
            given = self._index, self._table, *states, force, scale, pulled, frame, *weights
            meshed.add_contact_forces(*given, nodal)
        self.layer.put(owned, nodal)


FacePoints = NodePoints | RigidPoints | FixedPoints
"""Points on which forces act, and no more."""

SurfacePoints = NitschePoints | FacePoints


def keys_of(points: SurfacePoints) -> list[Key]:
    """The key of every point; it stays the same whatever faces join."""
    if not isinstance(points, NitschePoints):
        return [tuple(map(float, row)) for row in points.reference]
    own = points.points
    # Scaled by the whole body: the layer of nodes grows when a face joins.
    places = np.round(own.reference / own.size, KEY_DECIMALS) + 0.0
    return [tuple(map(float, row)) for row in np.column_stack([own.tag, places])]
