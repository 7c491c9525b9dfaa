"""Contact with Coulomb friction between points of one body and what carries them.

All point quantities are in the frame (normal, tangential) of the carrier. With the gap g, the
tangential position s, the elastic traction T and gamma_h, everything is said in terms of the
augmented position

    y = (g, s) - T/gamma_h:   l_n = [-gamma_h y_n]_+,   l_t = projection of -gamma_h (y_t - anchor)

on |l_t| <= c + mu l_n. The anchor is the stick memory: it stays while a point sticks, follows (y_t
+ l_t/gamma_h) while it slips, and is y_t while it is open. Point forces are f = w l (Chouly, Hild
and Renard; the memory and the merging of points are this program's). Points of rigid bodies have no
traction and no gamma_h: y is (g, s) there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from petsc4py import PETSc

import numpy as np
import scipy.sparse as sp

from solver.contact.body_points import NitschePoints, SurfacePoints, SurfaceState
from solver.contact.facet_target import DEEP, Face
from solver.contact.nitsche_points import NitscheState
from solver.contact.plane_target import Carrier
from solver.contact.projection import ContactKinematics
from solver.law.friction import Bounds, FrictionLaw
from solver.types import Array, Indices, Mask

Key = tuple[float, ...]

EVEN = 1e-9
"""Gaps within this part of a face's length are round-off."""


@dataclass(slots=True)
class Memory:
    """What contact remembers of one instant.

    Attributes:
        surface: Positions of the points, and tractions where they have any.
        seat: Their gaps and tangential positions.
        force: f = w l, (points, d), N: normal, tangential; on the body of the points.
        anchor: Stick memory, (points, d-1), m.
        may_touch: Points that may touch: of the coinciding points of a corner, the one whose face
            opposes the carrier; none that came round the carrier's edge.
        slipped: Points that slipped in the last step.
        broken: Points that have lost their cohesion.
    """

    surface: SurfaceState
    seat: ContactKinematics
    force: Array
    anchor: Array
    may_touch: Mask
    slipped: Mask
    broken: Mask


@dataclass(frozen=True, slots=True)
class Dissipation:
    """What a step lost in an interface, J."""

    friction: float
    contact: float


class Interface:
    """Kinematics, forces and energy of the contact of one body's points with one carrier."""

    def __init__(
        self,
        points: SurfacePoints,
        carrier: Carrier,
        law: FrictionLaw,
        *,
        theta: int = 1,
        count: int | None = None,
    ):
        """Set up.

        Args:
            points: Of the body that is carried.
            carrier: What carries it.
            law: Friction.
            theta: 1 symmetric, 0 fewest terms, -1 skew Nitsche method.
            count: Of contact points, where they are not the points of the body, but between them.
        """
        self.points, self.carrier, self.law = points, carrier, law
        falls = law.static != law.dynamic and law.decay == 0
        self.jumps = falls or (law.cohesion > 0 and law.cohesion_lost)
        """Whether points that break loose fall to less friction at once."""
        self.count, self.dimension = count or points.count, points.dimension
        self.size = points.size
        """Of the whole body that is carried, m."""
        self._corners: list[Indices] = []
        self.weight: Array
        self.area: Array
        self.inverse_gamma: Array
        self.softness: Array
        if isinstance(points, NitschePoints):
            self.theta, self.weight = theta, points.points.weight
            self.inverse_gamma = np.asarray(1.0 / points.points.gamma_h, dtype=np.float64)
            self.softness = np.asarray(self.inverse_gamma / self.weight, dtype=np.float64)
            self.area = self.weight * points.body.thickness
            places = np.asarray(points.reference / points.size, dtype=np.float64)
            self._corners = self._coinciding(places)
        else:
            none = np.zeros(self.count)
            self.theta, self.weight, self.inverse_gamma, self.softness = 0, none, none, none
            self.area = np.full((self.count,), points.area / self.count)
        self._weight_column, self._gamma_column = self.weight[:, None], self.inverse_gamma[:, None]
        self._soft_column = self.softness[:, None]
        self._pull_column = self.theta * self._gamma_column
        self._constant_bounds = Bounds.uniform(law.dynamic, self.count)
        self._keys = self._named()

    def theta_matrix(self, like: PETSc.Mat) -> PETSc.Mat:
        """(theta/gamma_h) G_T^T w G_T, the part of the theta term that stands in every tangent.

        Args:
            like: A matrix of the body, for sizes and distribution.
        """
        assert isinstance(self.points, NitschePoints)
        d, points = self.dimension, self.points.points
        weight = np.repeat(self.theta * self.weight * self.inverse_gamma, d)
        rows = points.traction_rows()
        local = sp.csr_matrix(rows.T @ sp.diags(weight) @ rows)
        unknowns = (points.layer.nodes[:, None] * d + np.arange(d)).ravel().astype(PETSc.IntType)
        matrix = PETSc.Mat().createAIJ(like.getSizes(), comm=like.comm)
        matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
        start, end = like.getOwnershipRange()
        for row in np.flatnonzero((unknowns >= start) & (unknowns < end)):
            part = slice(local.indptr[row], local.indptr[row + 1])
            matrix.setValues(unknowns[row], unknowns[local.indices[part]], local.data[part])
        matrix.assemble()
        return matrix

    def _named(self) -> list[Key]:
        """What tells the points of a body apart, whatever faces have joined: face and place."""
        if not isinstance(self.points, NitschePoints):
            return [tuple(map(float, row)) for row in self.points.reference]
        points = self.points.points
        # Scaled by the whole body: the layer of nodes grows when a face joins.
        places = np.column_stack([points.tag, np.round(points.reference / points.size, 7) + 0.0])
        return [tuple(map(float, row)) for row in places]

    def keys(self) -> list[Key]:
        """What tells the points of a body apart: face and place."""
        return self._keys

    @staticmethod
    def _coinciding(places: Array) -> list[Indices]:
        """Groups of points of different faces that share a place."""
        _, group = np.unique(np.round(places, 9), axis=0, return_inverse=True)
        members = [np.flatnonzero(group.ravel() == k) for k in range(group.max() + 1)]
        return [m for m in members if len(m) > 1]

    def observe(
        self, u: Array | None, carrier_u: Array | None
    ) -> tuple[SurfaceState, ContactKinematics]:
        """Where the points and their carrier are for the unknowns of both bodies."""
        surface = self.points.observe(u)
        return surface, self._seat(surface, carrier_u)

    def _seat(self, surface: SurfaceState, carrier_u: Array | None) -> ContactKinematics:
        """Gaps and tangential positions; a carrier without unknowns stands still."""
        points = self.carrier.points
        carried = None if points is None else points.observe(carrier_u)
        return self.carrier.seat(surface.position, carried)

    def augmented(self, surface: SurfaceState, seat: ContactKinematics) -> Array:
        """Y = (g, s) - T/gamma_h of all points, (points, d), m."""
        if not isinstance(surface, NitscheState):
            return seat.place
        scaled: Array = self._gamma_column * surface.traction
        return seat.place - scaled @ self.carrier.frame.T

    def start(self, u: Array | None, carrier_u: Array | None, rotation: Array) -> Memory:
        """A memory without contact forces."""
        surface, seat = self.observe(u, carrier_u)
        y = self.augmented(surface, seat)
        none = np.zeros(self.count, dtype=bool)
        may_touch = self.may_touch(rotation, seat)
        return Memory(surface, seat, np.zeros_like(y), y[:, 1:].copy(), may_touch, none, none)

    def may_touch(self, rotation: Array, seat: ContactKinematics) -> Mask:
        """Points that may touch.

        At each corner it is the point whose face looks most against the carrier, and all other
        points; but no point behind a face that came there round its edge.
        """
        mask = np.ones(self.count, dtype=bool)
        if self._corners:
            points: Any = self.points
            facing = points.points.normal @ rotation.T @ self.carrier.frame[0]
            for corner in self._corners:
                mask[corner] = False
                mask[corner[np.argmin(facing[corner])]] = True
        if isinstance(self.carrier, Face):
            mask &= seat.place[:, 0] > -DEEP * self.carrier.length
        return mask

    def _ignored_until_open(self, memory: Memory) -> Mask:
        """Points that sank elsewhere, until they are out again: contact would throw them out.

        Beside a face, or before the face that they are on joined: Gauss points of one face do not
        keep another from sinking in at an edge between them.
        """
        outside = ~memory.may_touch
        for corner in self._corners:
            outside[corner] = not memory.may_touch[corner].any()
        off = self.carrier.beyond_edge(memory.seat)
        if off is not None:
            outside |= off
        return outside & self.penetrating(memory) if outside.any() else outside

    def penetrating(self, memory: Memory) -> Mask:
        """Points deeper in the carrier than closed ones are pressed."""
        length = self.carrier.length if isinstance(self.carrier, Face) else self.size
        pressed = float(np.max(memory.force[:, 0], initial=0.0)) * self.softness
        deeper: Mask = memory.seat.place[:, 0] < -pressed - EVEN * length
        return deeper

    def rotate_frame(
        self, memory: Memory, rotation: Array, carrier_rotation: Array | None
    ) -> float:
        """Before a step: the frame of a carrier that turns, the points of corners chosen anew.

        Anchors and point forces turn with the carrier; a force moves with its place to the other
        face of a corner.

        Returns:
            Interface energy lost by the exchange (weights and tractions differ), J; added to what
            contact dissipates.
        """
        exchanged = 0.0
        if isinstance(self.carrier, Face) and carrier_rotation is not None:
            exchanged = self._turn_face(self.carrier, memory, carrier_rotation)
        may_touch = self.may_touch(rotation, memory.seat) & ~self._ignored_until_open(memory)
        if (may_touch == memory.may_touch).all():
            return exchanged
        before = self.energy(memory)
        y = self.augmented(memory.surface, memory.seat)
        for corner in self._corners:
            new = corner[may_touch[corner]]
            old = corner[memory.may_touch[corner]]
            if len(new) and len(old) and new[0] != old[0]:
                self._move(memory, y, int(old[0]), int(new[0]))
        lost = np.flatnonzero(~may_touch)
        memory.force[lost], memory.anchor[lost] = 0.0, y[lost, 1:]
        memory.may_touch = may_touch
        return exchanged + before - self.energy(memory)

    def _turn_face(self, face: Face, memory: Memory, rotation: Array) -> float:
        """Turn the frame of a face, and forces with it; the energy lost against tractions, J.

        Tractions do not turn. For theta = 1 the energy does not know of angles between the two.
        """
        before = 0.0 if self.theta == 1 else self.energy(memory)
        face.rotate_frame(rotation)
        memory.seat = face.seat(memory.surface.position, memory.seat.carrier)
        apart = memory.force[:, 0] <= 0
        if apart.any():  # the foot of a point that is away from the face moves as the face turns
            memory.anchor[apart] = self.augmented(memory.surface, memory.seat)[apart, 1:]
        return 0.0 if self.theta == 1 else before - self.energy(memory)

    def _move(self, memory: Memory, y: Array, old: int, new: int) -> None:
        """The force at a corner to the point of its other face."""
        memory.force[new], memory.force[old] = memory.force[old], 0.0
        memory.anchor[new] = y[new, 1:] + memory.force[new, 1:] * self.softness[new]
        memory.anchor[old] = y[old, 1:]
        for kept in (memory.slipped, memory.broken):
            kept[new] = kept[old]

    def bounds(self, memory: Memory, slipped: Mask, speed: Array | None) -> Bounds:
        """Bounds of friction at all points.

        Args:
            memory: Of t_n.
            slipped: Points that slipped in the last step or broke loose in this one.
            speed: Slip increment over the step's length, m/s; None counts as zero.
        """
        law = self.law
        if law.constant:
            return self._constant_bounds
        mu = law.coefficient(np.zeros(self.count) if speed is None else speed, slipped)
        return Bounds(mu, law.adhesion(self.area, memory.broken | slipped))

    def inside(self, memory: Memory) -> Mask:
        """Points that may touch and are not beyond an edge of their carrier."""
        off = self.carrier.beyond_edge(memory.seat)
        return memory.may_touch if off is None else memory.may_touch & ~off

    def at_bound(self, force: Array, bounds: Bounds) -> Mask:
        """Closed points whose friction is at its bound."""
        size = np.sqrt((force[:, 1:] ** 2).sum(axis=1))
        limit = bounds.cohesion + bounds.mu * force[:, 0]
        return (force[:, 0] > 0) & (size >= limit * (1 - 1e-9))

    def point_forces(
        self, old: ContactKinematics, new: ContactKinematics, force: Array
    ) -> tuple[Array, Array | None]:
        """Point forces as vectors in space on the body's points, and on the carrier's own."""
        vectors = self.carrier.vectors(old, new, force)
        return vectors, self.carrier.reaction(old, new, vectors)

    def traction_pull(
        self,
        old: SurfaceState,
        new: SurfaceState,
        force: Array,
        traction_weight: float,
        contact_weight: float,
    ) -> Array:
        """Vectors that the discrete gradient of the traction is multiplied by, (points, d).

        Args:
            old: Surface at t_n.
            new: Surface at t_{n+1}.
            force: Point forces f at t_{n+1}.
            traction_weight: 1 - alpha_f for the theta term int (theta/gamma_h) T.DT[v], else 0 to
                leave it out.
            contact_weight: w_c.
        """
        assert isinstance(old, NitscheState) and isinstance(new, NitscheState)
        pull = -contact_weight * (force @ self.carrier.frame)
        if traction_weight:
            averaged = traction_weight * new.traction + (1 - traction_weight) * old.traction
            pull += self._weight_column * averaged
        pull *= self._pull_column
        return pull

    def energy(self, memory: Memory) -> float:
        """Energy of the interface, sum of w (l - T).(l + theta T)/(2 gamma_h), J.

        For theta = 1 all that the law stores; for others all that any energy can: f.dT/gamma_h is
        half the change of f.T/gamma_h but for the circulation (f.dT - T.df)/(2 gamma_h).
        """
        stored = 0.5 * float(np.vdot(memory.force, memory.force * self._soft_column))
        if isinstance(memory.surface, NitscheState):
            scaled = self._gamma_column * memory.surface.traction
            if self.theta:
                pulled = self._weight_column * memory.surface.traction
                stored -= 0.5 * self.theta * float(np.vdot(pulled, scaled))
            if self.theta != 1:
                stored -= 0.5 * (1 - self.theta) * self._work(memory.force, scaled)
        return stored

    def _work(self, force: Array, moved: Array) -> float:
        """Sum of forces in the frame of the carrier times vectors in space, J."""
        return float(np.vdot(force, moved @ self.carrier.frame.T))

    def theta_increment(self, old: Memory, new: Memory) -> float:
        """Theta sum of w |T_{n+1} - T_n|^2/gamma_h, J: its part in the numerical dissipation."""
        if not self.theta:
            return 0.0
        assert isinstance(old.surface, NitscheState) and isinstance(new.surface, NitscheState)
        change = new.surface.traction - old.surface.traction
        return float(np.vdot(self._pull_column * change, self._weight_column * change))

    def remember(
        self,
        old: Memory,
        surface: SurfaceState,
        seat: ContactKinematics,
        force: Array,
        bounds: Bounds,
    ) -> tuple[Memory, Dissipation]:
        """The memory after a step, and what friction, closing and opening of points dissipated.

        Friction is minus the work of the tangential forces on the anchors. What contact takes is
        the work of the point forces against y that is neither stored in the interface nor lost in
        friction; for theta = 1 this is sum w |dl|^2/(2 gamma_h), never negative. For others the
        circulation of `energy` comes in, of either sign.

        Args:
            old: Memory at t_n.
            surface: At t_{n+1}.
            seat: At t_{n+1}.
            force: Point forces at t_{n+1}.
            bounds: Of friction at all points in this step.
        """
        y_old, y = self.augmented(old.surface, old.seat), self.augmented(surface, seat)
        closed = force[:, 0] > 0
        anchor = y[:, 1:] + np.where(closed[:, None], force[:, 1:] * self._soft_column, 0.0)
        friction = -float(np.vdot(force[:, 1:], anchor - old.anchor))
        grown = (force - old.force) * self._soft_column
        stored = 0.5 * float(np.vdot(grown, force + old.force))
        contact = -float(np.vdot(force, y - y_old)) - stored - friction
        contact -= self.carrier.work_defect(old.seat, seat, force)
        if self.theta != 1 and isinstance(surface, NitscheState):
            assert isinstance(old.surface, NitscheState)
            before = self._gamma_column * old.surface.traction
            after = self._gamma_column * surface.traction
            ends = self._work(force, after) + self._work(old.force, before)
            contact -= (1 - self.theta) * (0.5 * ends - self._work(force, before))
        slipped = self.at_bound(force, bounds)
        broken = old.broken if self.law.constant else old.broken | slipped
        memory = Memory(surface, seat, force, anchor, old.may_touch, slipped, broken)
        return memory, Dissipation(friction, contact)


def carry_over(memory: Memory, old: Interface, new: Interface, fresh: Memory) -> Memory:
    """The memory of `old`'s points in a fresh one of `new`, which holds those points and more."""
    place = {key: k for k, key in enumerate(old.keys())}
    joining = np.ones(new.count, dtype=bool)
    for k, key in enumerate(new.keys()):
        if key in place:
            before, joining[k] = place[key], False
            for name in ("force", "anchor", "may_touch", "slipped", "broken"):
                getattr(fresh, name)[k] = getattr(memory, name)[before]
    fresh.may_touch &= ~(joining & new.penetrating(fresh))
    return fresh
