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
    RigidPoints,
    SurfacePoints,
    SurfaceState,
    keys_of,
)
from solver.contact.carriers import Carrier, Face
from solver.contact.kinematics import (
    ContactIncrement,
    ContactKinematics,
    ForceWeights,
    Observed,
    Parts,
    spread,
)
from solver.contact.memory import CornerPoints, Dissipation, Memory
from solver.contact.nitsche_points import NitscheState, TractionPull, theta_matrix
from solver.kernels import meshed
from solver.law.friction import Bounds, FrictionLaw, new_pasts
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
        keys: Of every point, by its face and place; they stay the same whatever faces join.
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
        shared: frozenset[int] = frozenset(),
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
            shared: Tags of faces whose tractions stand in the theta term of another interface: it
                is there once, whatever faces look at.
        """
        self.points, self.carrier, self.law = points, carrier, law
        self._friction = FrictionLaw.of(law)
        self.count, self.dimension = count or points.count, points.dimension
        self.size = points.size
        self.weight: Array = np.zeros(self.count)
        self.inverse_gamma: Array = np.zeros(self.count)
        self.softness: Array = np.zeros(self.count)
        self.corners: CornerPoints | None = None
        self._theta_weight: Array = self.weight
        if isinstance(points, NitschePoints):
            self.theta, self.weight = theta, points.points.weight
            elsewhere = np.isin(points.points.tag, list(shared))
            self._theta_weight = np.asarray(np.where(elsewhere, 0.0, self.weight), dtype=float)
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
        self.pull_scale: Array = np.column_stack([scale * self._theta_weight, scale])
        self._pull_weight: Array = self.pull_scale[:, 0].copy()
        self.beds: PointBeds | None = None
        if bed is not None:
            self.beds = PointBeds(bed, np.where(self.area > 0, self.area, corner_area))
        self._constant_bounds = Bounds.uniform(law.dynamic, self.count)
        self.keys: list[Key] = keys_of(points)

    def theta_matrix(self, like: PETSc.Mat) -> PETSc.Mat:
        """(theta/gamma_h) G_T^T w G_T, the part of the theta term that stands in every tangent.

        The matrix `like`, of the body, gives sizes and distribution.
        """
        assert isinstance(self.points, NitschePoints)
        return theta_matrix(self.points.points, self._pull_weight, like)

    def observe(self, u: Array | None, carrier_u: Array | None, since: Memory) -> Observed:
        """The points, and their kinematics over the carrier, for the unknowns of both bodies.

        In a step since a memory, in the frame of that.
        """
        surface, carrier = self._placed(u, carrier_u)
        return surface, self.over(surface, carrier, since.kinematics.frame)

    def _placed(
        self, u: Array | None, carrier_u: Array | None
    ) -> tuple[SurfaceState, SurfaceState | None]:
        """The body's points and those of the carrier, for the unknowns of both."""
        carrier = self.carrier.points
        return self.points.observe(u), None if carrier is None else carrier.observe(carrier_u)

    def over(
        self, surface: SurfaceState, carrier: SurfaceState | None, frame: Array
    ) -> ContactKinematics:
        """Kinematics of points over a carrier whose own points are at `carrier`, in its frame.

        None for the ground.
        """
        kinematics = self.carrier.kinematics(surface.position, carrier, frame)
        if not isinstance(surface, NitscheState):
            return kinematics
        y = np.empty(kinematics.place.shape)
        meshed.augment(kinematics.place, surface.traction, self.inverse_gamma, kinematics.frame, y)
        return kinematics._replace(augmented=y)

    def start(
        self, u: Array | None, carrier_u: Array | None, rotation: Array, carrier_rotation: Array
    ) -> Memory:
        """The memory of points without contact forces, by the owned unknowns of both bodies.

        They are None for the ground; the rotations of both are (d, d).
        """
        surface, carrier = self._placed(u, carrier_u)
        kinematics = self.over(surface, carrier, self.carrier.frame(carrier_rotation))
        return self._begun(surface, kinematics, self.may_touch(rotation, kinematics))

    def _begun(
        self, surface: SurfaceState, kinematics: ContactKinematics, may_touch: Mask
    ) -> Memory:
        """The memory of points that have touched nothing yet."""
        y = kinematics.augmented
        return Memory(
            surface=surface,
            kinematics=kinematics,
            force=np.zeros_like(y),
            anchor=y[:, 1:].copy(),
            may_touch=may_touch,
            past=new_pasts(self.count),
            compression=np.zeros(self.count),
        )

    def may_touch(self, rotation: Array, kinematics: ContactKinematics) -> Mask:
        """Points that may touch.

        At each corner it is the point whose face is most opposed to the carrier, and all other
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
        return self._friction.bounds_by_past(past, self.area)

    def bounds_followed(self, past: Array, mu: Array, speed: Array, slips: Mask) -> Bounds:
        """Bounds of friction at all points in a step, by their speeds (m/s) and slips, (points,).

        `mu` has their coefficients so far; `FrictionLaw.bounds_followed` says how they follow.
        """
        if self.law.constant:
            return self._constant_bounds
        return self._friction.bounds_followed(past, self.area, mu, speed, slips)

    def inside(self, memory: Memory) -> Mask:
        """Points that may touch and are not beyond an edge of their carrier."""
        beyond = self.carrier.beyond_edge(memory.kinematics)
        return memory.may_touch if beyond is None else memory.may_touch & ~beyond

    def rest(self, memory: Memory) -> Array | None:
        """Gaps from which points are not pushed out in a step, (points,), m; None: all are 0.

        Beyond an edge of the carrier nothing keeps a point from going below the surface, by a block
        that leans a little. Once back it is held where it is: to push it out would gain energy.
        Points with tractions are pressed in, too; `turned` tells these apart.
        """
        if self.corners is not None:
            return None
        level = memory.kinematics.place[:, 0] + memory.compression
        sunk = level < -PENETRATION_TOLERANCE * _length(self)
        return np.where(sunk, level, 0.0) if np.count_nonzero(sunk) else None

    def point_forces(
        self, old: ContactKinematics, new: ContactKinematics, force: Array
    ) -> tuple[Array, Array | None]:
        """Point forces as vectors in space on the body's points, and on the carrier's own.

        Forces are those at t_{n+1}, (points, d), N; `old` kinematics is in the frame of the step.
        """
        vectors = on_points = self.carrier.vectors(old, new, force)
        if old.own_projection is not None and new.own_projection is not None:
            places = old.own_projection, new.own_projection
            on_points = spread(*places, vectors, self.points.count)
        return on_points, self.carrier.reaction(old, new, vectors)

    def add_forces(self, increment: ContactIncrement, on: Parts, weights: ForceWeights) -> None:
        """Add the forces on both bodies to those on their unknowns, in place."""
        (old_surface, old), (surface, new), force = increment
        if not (self.theta or force.any()):
            return
        weighted, (on_body, on_carrier) = weights.points * force, on
        vectors, reaction = self.point_forces(old, new, weighted)
        if on_body is not None and isinstance(self.points, NitschePoints):
            pull = self.traction_pull(weighted, new.frame, weights) if self.theta else None
            self.points.add_forces(on_body, old_surface, surface, vectors, pull)
        elif on_body is not None:
            self.points.add_forces(on_body, old_surface, surface, vectors)
        if on_carrier is not None and reaction is not None:
            assert self.carrier.points is not None and old.carrier is not None
            assert new.carrier is not None
            self.carrier.points.add_forces(on_carrier, old.carrier, new.carrier, reaction)

    def traction_pull(self, force: Array, frame: Array, weights: ForceWeights) -> TractionPull:
        """The factor of the discrete gradient of the traction in the theta term.

        By weighted point forces w_c f at t_{n+1}, with their sign, (points, d), N, in a frame.
        """
        return TractionPull(self.pull_scale, force, frame, weights.old, weights.new)

    def energy(self, memory: Memory) -> float:
        """Energy of the interface, sum of w (l - T).(l + theta T)/(2 gamma_h), J.

        For theta = 1 all that the law stores; for others all that any energy can: f.dT/gamma_h is
        half the change of f.T/gamma_h but for the circulation (f.dT - T.df)/(2 gamma_h).
        """
        stored = 0.0 if self.beds is None else self.beds.energy(memory.compression)
        if not isinstance(memory.surface, NitscheState):
            return stored
        force, traction = memory.force, memory.surface.traction
        stored += meshed.stored_energy(
            force, traction, self.softness, self._theta_weight, self.inverse_gamma, self.theta
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
        return meshed.squared_change(self._pull_weight, old.surface.traction, new.surface.traction)

    def remember(
        self,
        old: Memory,
        surface: SurfaceState,
        kinematics: ContactKinematics,
        force: Array,
        bounds: Bounds,
        own: Array,
        step: float,
    ) -> tuple[Memory, Dissipation]:
        """The memory after a step, and what friction, closing and opening of points dissipated.

        What contact takes is the work of the point forces against y that is neither stored in the
        interface nor lost in friction; for theta = 1 this is sum w |dl|^2/(2 gamma_h), never
        negative. For others the circulation of `energy` comes in, of either sign. Memory `old` is
        that at t_n, in the frame of the step, all else is at t_{n+1}; the step (s) is infinite in
        equilibrium. `own` is what the force at a point moves it by, (points,), m/N.
        """
        anchor, past = np.empty(old.anchor.shape), np.empty(old.past.shape)
        friction, contact = meshed.after_step(
            force,
            kinematics.augmented,
            old.force,
            old.kinematics.augmented,
            old.anchor,
            old.past,
            self.softness,
            own,
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
        memory = Memory(surface, kinematics, force, anchor, old.may_touch, past, compression)
        return memory, Dissipation(friction, contact, damping)


def _work(force: Array, moved: Array, kinematics: ContactKinematics) -> float:
    """Sum of forces in the frame of contact times vectors in space, J."""
    return float(np.vdot(force, moved @ kinematics.frame.T))


PENETRATION_TOLERANCE = 1e-9
"""Part of a face's length: points deeper than closed ones by more have sunk in."""


def _sunk_in(interface: Interface, memory: Memory) -> Mask | None:
    """Points that sank in elsewhere: until they are out again contact would throw them out.

    They did so beside a face, or before the face that they are on joined: Gauss points of one face
    do not keep another from sinking in at an edge between them. None where there are none; points
    without tractions are held at their depth instead (`Interface.rest`).
    """
    if interface.corners is None:
        return None
    outside = interface.corners.closed_to_all(memory.may_touch)
    beyond = interface.carrier.beyond_edge(memory.kinematics)
    if beyond is not None:
        outside = beyond if outside is None else outside | beyond
    if outside is None or not np.count_nonzero(outside):
        return None
    return outside & penetrating(interface, memory)


def _length(interface: Interface) -> float:
    """Length of what carries an interface's points, or their body's size on a plane, m."""
    return interface.carrier.length if isinstance(interface.carrier, Face) else interface.size


def penetrating(interface: Interface, memory: Memory) -> Mask:
    """Points deeper in the carrier than closed ones are pressed."""
    pressed = float(np.max(memory.force[:, 0], initial=0.0)) * interface.softness
    pressed += float(np.max(memory.compression, initial=0.0))
    limit = pressed + PENETRATION_TOLERANCE * _length(interface)
    deeper: Mask = memory.kinematics.place[:, 0] < -limit
    return deeper


def turned(
    interface: Interface, memory: Memory, rotation: Array, carrier_rotation: Array | None
) -> tuple[Memory, float]:
    """The memory in the frame of a coming step, with the points of corners chosen anew.

    Anchors and point forces turn with the carrier; a force moves with its place to the other
    face of a corner.

    Args:
        interface: The interface.
        memory: Memory of t_n.
        rotation: Of the body of the points at t_n, (d, d).
        carrier_rotation: Of a carrier that turns, in the middle of the step; None for others.

    Returns:
        The memory that the step starts from, and the interface energy lost by the exchange
        (weights and tractions differ), J; it is added to what contact dissipates.
    """
    exchanged = 0.0
    if carrier_rotation is not None:
        memory, exchanged = _with_carrier(interface, memory, carrier_rotation)
    may_touch = interface.may_touch(rotation, memory.kinematics)
    ignored = _sunk_in(interface, memory)
    if ignored is not None:
        may_touch &= ~ignored
    if may_touch.tobytes() == memory.may_touch.tobytes():
        return memory, exchanged
    before = interface.energy(memory)
    after = _at_other_faces(interface, memory, may_touch).touching(may_touch)
    return after, exchanged + before - interface.energy(after)


def _with_carrier(interface: Interface, memory: Memory, rotation: Array) -> tuple[Memory, float]:
    """Forces in the frame of a carrier that has turned; also the energy lost against tractions, J.

    Tractions do not turn. For theta = 1 the energy does not know of angles between the two.
    """
    frame = interface.carrier.frame(rotation)
    if frame.tobytes() == memory.kinematics.frame.tobytes():  # on what stands on the ground
        return memory, 0.0
    kinematics = interface.over(memory.surface, memory.kinematics.carrier, frame)
    apart, anchor = memory.force[:, 0] <= 0, memory.anchor
    if apart.any():  # closest points of open points move as the face turns
        anchor = np.where(apart[:, None], kinematics.augmented[:, 1:], anchor)
    after = memory._replace(kinematics=kinematics, anchor=anchor)
    if interface.theta == 1:
        return after, 0.0
    return after, interface.energy(memory) - interface.energy(after)


def _at_other_faces(interface: Interface, memory: Memory, may_touch: Mask) -> Memory:
    """Forces at corners moved to the points of their other faces."""
    y = memory.kinematics.augmented
    moves = (
        [] if interface.corners is None else interface.corners.moves(memory.may_touch, may_touch)
    )
    for old, new in moves:
        memory = memory.take(np.array([new]), memory, np.array([old]))
        memory.force[old] = memory.compression[old] = 0.0
        memory.anchor[new] = y[new, 1:] + memory.force[new, 1:] * interface.softness[new]
        memory.anchor[old] = y[old, 1:]
    return memory


def carry_over(memory: Memory, old: Interface, new: Interface, fresh: Memory) -> Memory:
    """The memory of `old`'s points in a fresh one of `new`, which holds those points and more.

    Points that join under the carrier's surface may not touch before they are out of it.
    """
    place = {key: k for k, key in enumerate(old.keys)}
    staying = np.array([key in place for key in new.keys])
    before = np.array([place[key] for key in new.keys if key in place], dtype=np.int64)
    carried = fresh.take(np.flatnonzero(staying), memory, before)
    sunk = ~staying & penetrating(new, carried)
    return carried._replace(may_touch=carried.may_touch & ~sunk)
