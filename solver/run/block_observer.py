"""Part of a row of the history that describes one block, in a run with meshed bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geometry.foundation import level_frame
from geometry.outline import rolls
from geometry.top import STEEPEST_TOP, top_over_centre
from solver.bodies.kinematics import RigidMotion
from solver.build.block_body import BlockBody
from solver.contact.body_points import Key, NitschePoints, SurfaceState
from solver.contact.kinematics import in_space
from solver.contact.memory import Memory
from solver.contact.pairs import Link
from solver.history.block_columns import (
    contact_columns,
    force_columns,
    has_lost_carrier,
    lean_in_space,
    plane_motion,
    space_motion,
)
from solver.history.engine_rows import of_owner
from solver.kernels import meshed
from solver.resumable import Resumable
from solver.stepping.state import State
from solver.stepping.stepper import Stepper
from solver.types import Array, Indices, Mask

ON_FOOT = 1e-3
"""Part of a block's size: points no farther from an undeformed foot are on it."""

LEVEL = 1e-9
"""Points are equally low within this part of a block's size: which of them counts is not chance."""


def touching(force: Array, place: Array, may_touch: Mask, level: float) -> Indices:
    """The closed points, or else the lowest one and all that are within `level` of it (m).

    Where no point may touch, these are all. Points are given by their forces and places, (n, d).
    """
    touch = np.empty(len(force), dtype=np.bool_)
    meshed.touching(force, place, may_touch, level, touch)
    return touch.nonzero()[0]


class BlockObserver(Resumable):
    """Angle, slip, gaps and forces of one block."""

    CARRIED = ("_lean", "_slip", "_known")

    def __init__(
        self, member: BlockBody, stepper: Stepper, state: State, carrier: BlockBody | None
    ):
        """Start at a state; `carrier` is the block below, None where the foundation carries it."""
        self._member, self._stepper, self._carrier = member, stepper, carrier
        self._links: Sequence[Link] = ()
        self._number, self._others = 0, list[int]()
        self._take(stepper.links)
        self._home = self._face(state)
        self._home_carrier = stepper.links[self._number].interface.carrier
        self._own = stepper.system.slices[member.number]
        d = stepper.system.dimension
        self._lean, self._slip = 0.0, np.zeros(d - 1)
        self._set_interface()
        self._known = self._first_reference(state)
        self._order_reference()
        count = member.spec.shape.feet
        feet = [foot.hull.points.reference for foot in member.parts[len(member.parts) - count :]]
        near = ON_FOOT * member.spec.shape.half_diagonal
        self._feet = [(foot.min(axis=0) - near, foot.max(axis=0) + near) for foot in feet]

    def _take(self, links: Sequence[Link]) -> None:
        """Take the interfaces that are active now."""
        if links is self._links:
            return
        self._links, own = links, self._member.number
        self._number = next(k for k, link in enumerate(links) if link.stands and link.body == own)
        below = links[self._number].carrier
        self._others = [
            number
            for number, link in enumerate(links)
            if own in (link.body, link.carrier)
            and number != self._number
            and not (link.stands and {link.body, link.carrier} != {own, below})
        ]

    def _face(self, state: State) -> int:
        """The face of what carries the block that it meets."""
        face: int = state.active[self._member.number].second
        return face

    def resume(self, saved: Mapping[str, Any]) -> None:
        """Go on from the steps that another observer of the block has seen."""
        super().resume(saved)
        self._take(self._stepper.links)
        self._set_interface()
        self._order_reference()

    def _set_interface(self) -> None:
        """Set the points that the block has now."""
        self._interface = self._links[self._number].interface
        self._level = LEVEL * self._interface.size

    def _order_reference(self) -> None:
        """Order the reference positions of its points; nan where one is not known yet."""
        unknown = np.full(self._interface.dimension - 1, np.nan)
        self._reference = np.array([self._known.get(key, unknown) for key in self._interface.keys])

    def _corner_positions(self, state: State) -> Array:
        """Positions of the bottom corners."""
        surface = self._member.surface
        corners = surface.hull.points.observe(state.u[self._own]).position
        return corners[surface.below]

    def columns(self, state: State, links: Sequence[Link]) -> dict[str, Any]:
        """The columns of the block and of its feet; memories of the state are of `links`."""
        self._take(links)
        memory = state.contacts[self._number]
        if links[self._number].interface is not self._interface:
            self._set_interface()
            self._order_reference()
        system, number = self._stepper.system, self._member.number
        known = self._motion(state.rigid_motion(system, number))
        carrier, place = self._interface.carrier, memory.kinematics.carrier
        frame = memory.kinematics.frame
        if self._face(state) != self._home:  # it meets another face of what carried it
            carrier, (place, frame) = self._home_carrier, self._home_place(state)
        elif not self._take_slip(memory):
            self._set_reference(memory)
            self._take_slip(memory)
        lost = self._carrier is not None and self._lost_its_carrier(state)
        corners = self._corner_positions(state)
        height = corners[:, -1] if lost else carrier.kinematics(corners, place, frame).place[:, 0]
        numbers = self._number, *self._others
        depth = max(self._penetration(state, n) for n in numbers)
        force = np.add.reduce(memory.force)
        if self._others or lost or carrier is not self._interface.carrier:
            frame = level_frame(len(force)) if lost else frame
            force = self._force(state, frame)
        known |= contact_columns(self._slip, height, depth, force)
        name = self._member.spec.name
        for foot, pushed in enumerate(self._feet_forces(state, frame), start=1):
            known |= of_owner(f"foot_{foot}", force_columns(pushed))
        return of_owner(name, known)

    def _feet_forces(self, state: State, frame: Array) -> list[Array]:
        """The forces on the feet, (d,), in the frame of those on the block, N."""
        forces: list[Array] = [np.zeros(len(frame)) for _ in self._feet]
        if not forces:
            return forces
        own = self._member.number
        motion = state.rigid_motion(self._stepper.system, own)
        centre = self._member.body.centre
        for number in (self._number, *self._others):
            link, memory = self._links[number], state.contacts[number]
            place = memory.surface.position
            if memory.kinematics.own_projection is not None:
                place = memory.kinematics.own_projection.carried(place)
            place = centre + (place - centre - motion.moved) @ motion.rotation
            sign = 1.0 if link.body == own else -1.0
            force = sign * in_space(memory.force, memory.kinematics.frame) @ frame.T
            for pushed, (low, high) in zip(forces, self._feet, strict=True):
                pushed += force[((place >= low) & (place <= high)).all(axis=1)].sum(axis=0)
        return forces

    def _home_place(self, state: State) -> tuple[SurfaceState | None, Array]:
        """Where the face is that carries the block at the start, and its frame."""
        link, face, system = self._links[self._number], self._home_carrier, self._stepper.system
        frame = face.reference_frame
        if link.carrier is not None:
            frame = face.frame(state.rigid_motion(system, link.carrier).rotation)
        part = system.part(state.u, link.carrier)
        return None if face.points is None else face.points.observe(part), frame

    def _take_slip(self, memory: Memory) -> bool:
        """Take the slip of the block's own points; False where a reference is unknown."""
        slip = np.empty(self._reference.shape[1])
        meshed.mean_slip(*self._points(memory), self._reference, slip)
        if math.isnan(slip[0]):
            return False
        self._slip = slip
        return True

    def _points(self, memory: Memory) -> tuple[Array, Array, Mask, float]:
        """Forces and places of the block's own points and what else `touching` takes of them."""
        return memory.force, memory.kinematics.place, memory.may_touch, self._level

    def _motion(self, motion: RigidMotion) -> dict[str, Any]:
        """The columns that follow from the motion of the block, whose lean is carried on."""
        turn, centre = motion.rotation, self._member.body.centre + motion.moved
        if len(turn) == 2:
            lean, before = math.atan2(-turn[1, 0], turn[0, 0]), self._lean
            self._lean = lean + 2 * math.pi * round((before - lean) / (2 * math.pi))
            return plane_motion(self._lean, motion.spin[0], centre)
        self._lean, vector = lean_in_space(turn, self._lean), np.empty(3)
        meshed.vector_of(turn, vector)
        return space_motion(self._lean, vector, motion.spin, centre)

    def _lost_its_carrier(self, state: State) -> bool:
        """True if the block has lost the block that carried it (`has_lost_carrier`)."""
        assert self._carrier is not None
        system = self._stepper.system
        own = state.rigid_motion(system, self._member.number)
        below, carrier = state.rigid_motion(system, self._carrier.number), self._carrier.spec
        centre = self._member.body.centre + own.moved
        shift = centre - self._carrier.body.centre - below.moved
        up = np.eye(len(shift))[-1] if rolls(carrier.shape, len(shift)) else below.rotation[:, -1]
        top = top_over_centre(carrier.shape, len(centre))
        return has_lost_carrier(up[-1], float(shift @ up), top)

    def _penetration(self, state: State, number: int) -> float:
        """Largest penetration of a point in an interface, m; 0 if none penetrates."""
        memory = state.contacts[number]
        inside = self._links[number].interface.inside(memory)
        return meshed.penetration(memory.kinematics.place, inside)

    def _force(self, state: State, frame: Array) -> Array:
        """Normal and tangential force on the block in a frame, N.

        By its own interface and those others that bear it. Where it has lost its carrier the
        foundation is level.
        """
        memory = state.contacts[self._number]
        force, given = np.add.reduce(memory.force), memory.kinematics.frame
        if given is not frame:
            force = frame @ (force @ given)
        for number in self._others:
            link = self._links[number]
            sign = 1.0 if link.body == self._member.number else -1.0
            if not (link.stands or self._bears(link, state.contacts[number], sign)):
                continue
            pushed = in_space(state.contacts[number].force, state.contacts[number].kinematics.frame)
            force = force + sign * pushed.sum(axis=0) @ frame.T
        return force

    def _bears(self, link: Link, memory: Memory, sign: float) -> bool:
        """True if the block stands on the other body: by name, or by a normal that points up."""
        other = link.carrier if sign > 0 else link.body
        if other in self._member.carriers:
            return True
        frame = memory.kinematics.frame
        up = frame[:, 0, -1].max() if frame.ndim == 3 else frame[0, -1]
        return bool(sign * up > STEEPEST_TOP)

    def _first_reference(self, state: State) -> dict[Key, Array]:
        """Reference positions along the carrier of the points of the face that stands on it, m.

        As far from those that touch as in the block: a tilted block has its base foreshortened.
        """
        interface = self._interface
        memory = state.contacts[self._number]
        carrier, points = interface.carrier, interface.points
        along = points.reference @ carrier.reference_frame[1:].T
        place = memory.kinematics.place
        lowest = touching(*self._points(memory))
        reference = along + (place[lowest, 1:] - along[lowest]).mean(axis=0)
        keys = interface.keys
        if isinstance(points, NitschePoints):
            same = np.flatnonzero(points.points.tag == points.points.tag[lowest[0]])
        else:  # all corners of a rigid body
            heights = points.reference[:, -1]
            same = np.flatnonzero(heights <= heights.min() + self._level)
        return {keys[q]: reference[q] for q in same}

    def _set_reference(self, memory: Memory) -> None:
        """Set the reference positions of points that touch for the first time.

        That is the position of a point at the start; for points of other faces it is the one with
        which the slip does not jump when they first touch.
        """
        place, keys = memory.kinematics.place, self._interface.keys
        chosen = touching(*self._points(memory))
        known = [place[q, 1:] - self._known[keys[q]] for q in chosen if keys[q] in self._known]
        slip = sum(known) / len(known) if known else self._slip
        for q in chosen:
            self._known.setdefault(keys[q], place[q, 1:] - slip)
        self._order_reference()
