"""Contact with Coulomb friction between points of one body and what carries them.

All point quantities are in the frame (normal, tangential) of the carrier. With the gap g, the
tangential position s, the elastic traction T and gamma_h, everything is said in terms of the
augmented position

    y = (g, s) - T/gamma_h:   l_n = [-gamma_h y_n]_+,   l_t = projection of -gamma_h (y_t - anchor)

on |l_t| <= c + mu l_n. The anchor is the stick memory: it stays while a point sticks, follows
(y_t + l_t/gamma_h) while the point slips, and is y_t while the point is open. Point forces are
f = w l (Chouly, Hild and Renard; the memory and the merging of points are this program's). Points
of rigid bodies have neither a traction nor a gamma_h: y is (g, s) there.
"""

from __future__ import annotations

from petsc4py import PETSc

import numpy as np

from solver.contact.bed import PointBeds
from solver.contact.body_points import (
    Key,
    NitschePoints,
    PointForces,
    RigidPoints,
    SurfacePoints,
    SurfaceState,
    keys_of,
)
from solver.contact.corner_points import CornerPoints
from solver.contact.facet_target import Face
from solver.contact.increment import ContactIncrement, ForceWeights, Observed, Parts
from solver.contact.kernels.apart import least_distance
from solver.contact.kernels.memory import after_step, squared_change, stored_energy
from solver.contact.kernels.nitsche import NitscheState, TractionPull, augment
from solver.contact.memory import Dissipation, Memory
from solver.contact.nitsche_points import theta_matrix
from solver.contact.plane_target import Carrier
from solver.contact.projection import ContactKinematics
from solver.law.friction import (
    Bounds,
    FrictionLaws,
    bounds_by_past,
    bounds_followed,
    new_pasts,
)
from solver.scene import Bed, FrictionSpec
from solver.types import Array, Mask


class Interface:
    """Kinematics, forces and energy of the contact of one body's points with one carrier.

    Attributes:
        points: Points of the body that is carried.
        carrier: What carries it.
        law: Friction.
        count: Number of contact points.
        dimension: d, 2 or 3.
        size: Of the whole body that is carried, m.
        theta: Variant of Nitsche's method; 0 for points without tractions.
        weight: w of each point on the undeformed body, (points,), m or m2; 0 for rigid bodies.
        area: What cohesion acts on, (points,), m2.
        inverse_gamma: 1/gamma_h, (points,), m/Pa; 0 for points without tractions.
        softness: 1/(gamma_h w), (points,), m/N; likewise.
        pull_scale: The `scale` of a `TractionPull`.
        beds: Springs and dashpots below the points; None where there are none.
        corners: Which of its points share a place; None for points without faces.
    """

    def __init__(
        self,
        points: SurfacePoints,
        carrier: Carrier,
        law: FrictionSpec,
        *,
        theta: int = 1,
        count: int | None = None,
        bed: Bed | None = None,
        corner_area: float = 0.0,
        of_edge: bool = False,
    ):
        """Set up.

        Args:
            points: Points of the body that is carried.
            carrier: What carries it.
            law: Friction.
            theta: 1 symmetric, 0 fewest terms, -1 skew Nitsche method.
            count: Number of contact points where they are not the points of the body, but between
                them.
            bed: Springs and dashpots between points and carrier.
            corner_area: What points without an area count for in it, m2.
            of_edge: Whether the points are the edge of what carries a block, which presses on the
                bottom of that: far from there nobody asks where they are.
        """
        self.points, self.carrier, self.law = points, carrier, law
        self._laws = FrictionLaws.of([law])
        self._of_edge = of_edge
        self.count, self.dimension = count or points.count, points.dimension
        self.size = points.size
        self.weight: Array = np.zeros(self.count)
        self.inverse_gamma: Array = np.zeros(self.count)
        self.softness: Array = np.zeros(self.count)
        self.corners: CornerPoints | None = None
        if isinstance(points, NitschePoints):
            self.theta, self.weight = theta, points.points.weight
            self.inverse_gamma = np.asarray(1.0 / points.points.gamma_h, dtype=np.float64)
            self.softness = np.asarray(self.inverse_gamma / self.weight, dtype=np.float64)
            self.area = self.weight * points.body.thickness
            places: Array = np.asarray(points.reference / points.size, dtype=np.float64)
            self.corners = CornerPoints(places, points.points.normal)
        else:
            self.theta = 0
            self.area = np.zeros(self.count)
            if isinstance(points, RigidPoints) and count is None:
                self.area = points.area
        self._gamma_column = self.inverse_gamma[:, None]
        scale = self.theta * self.inverse_gamma
        self.pull_scale: Array = np.column_stack([scale * self.weight, scale])
        self._pull_weight: Array = self.pull_scale[:, 0].copy()
        self.beds: PointBeds | None = None
        if bed is not None:
            self.beds = PointBeds(bed, np.where(self.area > 0, self.area, corner_area))
        self._constant_bounds = Bounds.uniform(law.dynamic, self.count)
        self._keys = self._named()

    def theta_matrix(self, like: PETSc.Mat) -> PETSc.Mat:
        """(theta/gamma_h) G_T^T w G_T, the part of the theta term that stands in every tangent.

        The matrix `like`, of the body, gives sizes and distribution.
        """
        assert isinstance(self.points, NitschePoints)
        return theta_matrix(self.points.points, self.theta, like)

    def _named(self) -> list[Key]:
        """The key of every point; it stays the same whatever faces join."""
        return keys_of(self.points)

    def keys(self) -> list[Key]:
        """The key of every point: face and place."""
        return self._keys

    def observe(self, u: Array | None, carrier_u: Array | None) -> Observed:
        """Where the points and their carrier are for the unknowns of both bodies."""
        surface, carrier = self.points.observe(u), self.carrier.points
        return surface, self.over(surface, None if carrier is None else carrier.observe(carrier_u))

    def over(self, surface: SurfaceState, carrier: SurfaceState | None) -> ContactKinematics:
        """Where points are over a carrier, of which `carrier` says where its own points are.

        None for the ground.
        """
        kinematics = self.carrier.kinematics(surface.position, carrier)
        if not isinstance(surface, NitscheState):
            return kinematics
        y = np.empty(kinematics.place.shape)
        augment(kinematics.place, surface.traction, self.inverse_gamma, kinematics.frame, y)
        return kinematics._replace(augmented=y)

    def start(self, u: Array | None, carrier_u: Array | None, rotation: Array) -> Memory:
        """The memory of points without contact forces, by the owned unknowns of both bodies.

        They are None for the ground; `rotation` is that of the body of the points, (d, d).
        """
        surface, kinematics = self.observe(u, carrier_u)
        y = kinematics.augmented
        return Memory(
            surface=surface,
            kinematics=kinematics,
            force=np.zeros_like(y),
            anchor=y[:, 1:].copy(),
            may_touch=self.may_touch(rotation, kinematics),
            past=new_pasts(self.count),
            compression=np.zeros(self.count),
            rest=np.zeros(self.count),
        )

    def may_touch(self, rotation: Array, kinematics: ContactKinematics) -> Mask:
        """Points that may touch.

        At each corner it is the point whose face looks most against the carrier, and all other
        points; but no point behind a face that came there round its edge.
        """
        if self.corners is None:
            mask: Mask = np.ones(self.count, dtype=bool)
        else:
            mask = self.corners.chosen(rotation, kinematics.frame[0])
        if isinstance(self.carrier, Face):
            mask &= self.carrier.can_touch(kinematics)
        return mask

    def bounds(self, past: Array) -> Bounds:
        """Bounds of friction at all points, by what they remember of it, (points, PAST)."""
        if self.law.constant:
            return self._constant_bounds
        return bounds_by_past(self._laws, past, self.area)

    def bounds_followed(self, past: Array, mu: Array, speed: Array, slips: Mask) -> Bounds:
        """Bounds of friction at all points in a step, by their speeds (m/s) and slips, (points,).

        `mu` has their coefficients so far; `solver.law.friction.followed` says how they follow.
        """
        if self.law.constant:
            return self._constant_bounds
        return bounds_followed(self._laws, past, self.area, mu, speed, slips)

    def apart(self, surface: SurfaceState, kinematics: ContactKinematics) -> float:
        """At least how far an edge is from the face that it may press on, m; 0 for other points."""
        if not self._of_edge or kinematics.carrier is None:
            return 0.0
        return least_distance(surface.position, kinematics.carrier.position)

    def inside(self, memory: Memory) -> Mask:
        """Points that may touch and are not beyond an edge of their carrier."""
        beyond = self.carrier.beyond_edge(memory.kinematics)
        return memory.may_touch if beyond is None else memory.may_touch & ~beyond

    def point_forces(
        self, old: ContactKinematics, new: ContactKinematics, force: Array
    ) -> tuple[Array, Array | None]:
        """Point forces as vectors in space on the body's points, and on the carrier's own.

        Forces are those at t_{n+1}, (points, d), N; `old` kinematics is in the frame of the step.
        """
        vectors = self.carrier.vectors(old, new, force)
        return vectors, self.carrier.reaction(old, new, vectors)

    def press(
        self, before: Observed | None, at: Parts, force: Array, on: Parts, weights: ForceWeights
    ) -> Observed:
        """Look where the points are, and add forces on both bodies; returns what is seen.

        Args:
            before: The interface at t_n, in the frame of the step; None in equilibrium: what is
                seen counts at both ends.
            at: The unknowns of both bodies.
            force: Point forces f, (points, d), N.
            on: Forces on these unknowns, which are added to.
            weights: How they count.
        """
        seen = self.observe(*at)
        self.add_forces(ContactIncrement(before or seen, seen, force), on, weights)
        return seen

    def add_forces(self, increment: ContactIncrement, on: Parts, weights: ForceWeights) -> None:
        """Add the forces on both bodies to those on their unknowns, in place."""
        (old_surface, old), (surface, new), force = increment
        weighted, (on_body, on_carrier) = weights.points * force, on
        vectors, reaction = self.point_forces(old, new, weighted)
        if on_body is not None:
            pull = self.traction_pull(weighted, weights) if self.theta else None
            self.points.add_forces(on_body, PointForces(old_surface, surface, vectors, pull))
        if on_carrier is not None and reaction is not None:
            self._add_reaction(old, new, reaction, on_carrier)

    def _add_reaction(
        self, old: ContactKinematics, new: ContactKinematics, reaction: Array, target: Array
    ) -> None:
        """Add forces on the carrier's own points to those on its unknowns."""
        points, first, last = self.carrier.points, old.carrier, new.carrier
        assert points is not None and first is not None and last is not None
        points.add_forces(target, PointForces(first, last, reaction))

    def traction_pull(self, force: Array, weights: ForceWeights) -> TractionPull:
        """What the discrete gradient of the traction is multiplied by.

        By weighted point forces w_c f at t_{n+1}, with their sign, (points, d), N.
        """
        return TractionPull(self.pull_scale, force, self.carrier.frame, weights.old, weights.new)

    def energy(self, memory: Memory) -> float:
        """Energy of the interface, sum of w (l - T).(l + theta T)/(2 gamma_h), J.

        For theta = 1 all that the law stores; for others all that any energy can: f.dT/gamma_h is
        half the change of f.T/gamma_h but for the circulation (f.dT - T.df)/(2 gamma_h).
        """
        stored = 0.0 if self.beds is None else self.beds.energy(memory.compression)
        if not isinstance(memory.surface, NitscheState):
            return stored
        force, traction = memory.force, memory.surface.traction
        stored += stored_energy(
            force, traction, self.softness, self.weight, self.inverse_gamma, self.theta
        )
        if self.theta != 1:
            scaled = self._gamma_column * traction
            stored -= 0.5 * (1 - self.theta) * _work(force, scaled, memory.kinematics)
        return stored

    def theta_increment(self, old: Memory, new: Memory) -> float:
        """Theta sum of w |T_{n+1} - T_n|^2/gamma_h, J: its part in the numerical dissipation."""
        if not self.theta:
            return 0.0
        assert isinstance(old.surface, NitscheState) and isinstance(new.surface, NitscheState)
        return squared_change(self._pull_weight, old.surface.traction, new.surface.traction)

    def remember(
        self,
        old: Memory,
        surface: SurfaceState,
        kinematics: ContactKinematics,
        force: Array,
        bounds: Bounds,
        step: float,
    ) -> tuple[Memory, Dissipation]:
        """The memory after a step, and what friction, closing and opening of points dissipated.

        What contact takes is the work of the point forces against y that is neither stored in the
        interface nor lost in friction; for theta = 1 this is sum w |dl|^2/(2 gamma_h), never
        negative. For others the circulation of `energy` comes in, of either sign. Memory `old` is
        that at t_n, in the frame of the step, all else is at t_{n+1}; the step (s) is infinite in
        equilibrium.
        """
        anchor, past = np.empty(old.anchor.shape), np.empty(old.past.shape)
        friction, contact = after_step(
            tuple(self._laws),
            force,
            kinematics.augmented,
            old.force,
            old.kinematics.augmented,
            old.anchor,
            old.past,
            self.softness,
            bounds.mu,
            bounds.cohesion,
            step,
            anchor,
            past,
        )
        contact -= self.carrier.work_defect(old.kinematics, kinematics, force)
        compression, damping = old.compression, 0.0
        if self.beds is not None:
            compression, damping = self.beds.after(old.compression, force[:, 0], step)
            contact -= self.beds.energy(compression) - self.beds.energy(old.compression) + damping
        if self.theta != 1 and isinstance(surface, NitscheState):
            assert isinstance(old.surface, NitscheState)
            before = self._gamma_column * old.surface.traction
            after = self._gamma_column * surface.traction
            ends = _work(force, after, kinematics) + _work(old.force, before, old.kinematics)
            contact -= (1 - self.theta) * (0.5 * ends - _work(force, before, kinematics))
        kept = old.may_touch, past, compression, old.rest
        memory = Memory(surface, kinematics, force, anchor, *kept)
        return memory, Dissipation(friction, contact, damping)


def _work(force: Array, moved: Array, kinematics: ContactKinematics) -> float:
    """Sum of forces in the frame of contact times vectors in space, J."""
    return float(np.vdot(force, moved @ kinematics.frame.T))
