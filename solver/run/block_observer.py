"""What is worth writing down of one block in a step of meshed bodies: its part of a row."""

from __future__ import annotations

from typing import Any

import numpy as np

from solver.bodies.kinematics import lean, rotation_vector, unwrap
from solver.bodies.rigid_box import RigidBox
from solver.build.assembly import BlockBody
from solver.contact.body_points import NitschePoints
from solver.contact.facet_target import Face
from solver.contact.interface import Key
from solver.contact.memory import Memory
from solver.contact.projection import in_space
from solver.history.block_columns import (
    MovingBlock,
    lean_in_space,
    write_plane_motion,
    write_space_motion,
)
from solver.history.columns import positions
from solver.stepping.state import State
from solver.stepping.stepper import Stepper
from solver.stepping.system import Link
from solver.types import Array, Indices

LEVEL = 1e-9
"""Points are equally low within this part of a block's size: which of them counts is not chance."""


class BlockObserver:
    """Angle, slip, gaps and forces of one block."""

    def __init__(
        self, member: BlockBody, stepper: Stepper, state: State, carrier: BlockBody | None
    ):
        """Start at a state; `carrier` is the block below, None where the foundation carries it."""
        self._member, self._stepper, self._carrier = member, stepper, carrier
        self._own, self._shape = stepper.system.slices[member.number], member.spec.shape
        self._angles = np.zeros(1 if stepper.system.dimension == 2 else 4)
        self._slip = np.zeros(stepper.system.dimension - 1)
        plane, shape = stepper.system.dimension == 2, self._shape
        self._inertia = np.array([shape.rotary_inertia] if plane else shape.principal_inertias)
        self._interface = self._link.interface
        self._home = self._first_home(state)
        self._homes: tuple[bytes, Array] | None = None
        self._corners = self._bottom()

    @property
    def _link(self) -> Link:
        """The interface of the block's own points; another one after a face has joined."""
        return self._stepper.links[self._member.contacts[0]]

    def saved(self) -> tuple[Any, ...]:
        """What is carried on from step to step, for `resume`."""
        return self._angles, self._slip, self._home, self._homes

    def resume(self, saved: tuple[Any, ...]) -> None:
        """Go on from the steps that another observer of the block has seen."""
        self._angles, self._slip, self._home, self._homes = saved
        self._interface = self._link.interface
        self._corners = self._bottom()

    def _bottom(self) -> Array | tuple[Indices, Array]:
        """The bottom corners: of a rigid block where they are in it, of a mesh which nodes."""
        if isinstance(self._member.body, RigidBox):
            return self._member.body.bottom
        points = self._link.interface.points
        assert isinstance(points, NitschePoints)
        places = points.points.node_positions
        scale = 1e-9 * points.size
        row = np.flatnonzero(places[:, -1] < places[:, -1].min() + scale)
        level = places[row]
        if places.shape[1] == 2:
            ends = [np.argmin(level[:, 0]), np.argmax(level[:, 0])]
        else:
            x, y = level[:, 0], level[:, 1]
            ends = [np.argmin(x + y), np.argmax(x - y), np.argmax(x + y), np.argmax(y - x)]
        corners = row[ends]
        return corners, places[corners]

    def _corner_positions(self, state: State) -> Array:
        """Where the bottom corners are."""
        u = state.u[self._own]
        body = self._member.body
        if isinstance(body, RigidBox):
            assert isinstance(self._corners, np.ndarray)
            return body.material_positions(self._corners, body.replicate(u))
        points = self._link.interface.points
        assert isinstance(points, NitschePoints) and isinstance(self._corners, tuple)
        nodes, places = self._corners
        return places + points.points.layer.gather(u.reshape(-1, body.dimension))[nodes]

    def write(self, state: State, row: Array) -> None:
        """Fill in the columns of the block, all of `row`."""
        link, memory = self._link, state.contacts[self._member.contacts[0]]
        if link.interface is not self._interface:
            self._interface = link.interface
            self._homes = None
            self._corners = self._bottom()
        self._slip = self._slipped(memory)
        lost = self._lost_its_carrier(state)
        corners = self._corner_positions(state)
        height = corners[:, -1]
        if not lost:
            carrier = link.interface.carrier
            height = carrier.kinematics(corners, memory.kinematics.carrier).place[:, 0]
        self._write_motion(state, row)
        at = positions("block", corners.shape[1])
        row[at.penetration_m] = self._penetration(state)
        if corners.shape[1] == 2:
            row[at.slip_m] = self._slip[0]
            row[[at.gap_left_m, at.gap_right_m]] = height
            row[[at.normal_force_N, at.friction_force_N]] = self._force(state, lost)
            return
        row[[at.slip_m, at.slip_second_m]] = self._slip
        row[[at.gap_1_m, at.gap_2_m, at.gap_3_m, at.gap_4_m]] = height
        forces = [at.normal_force_N, at.friction_force_N, at.friction_force_second_N]
        row[forces] = self._force(state, lost)

    def _lost_its_carrier(self, state: State) -> bool:
        """Whether the centre of the block is below the top of the block that carried it."""
        if self._carrier is None:
            return False
        system = self._stepper.system
        own = state.rigid_motion(system, self._member.number)
        below = state.rigid_motion(system, self._carrier.number)
        centre = self._member.body.centre + own.moved
        shift = centre - self._carrier.body.centre - below.moved
        return float(shift @ below.rotation[:, -1]) <= self._carrier.spec.height / 2

    def _penetration(self, state: State) -> float:
        """How deep a point of the block or of what carries it is in the other, at most."""
        deepest = 0.0
        for number in self._member.contacts:
            interface, memory = self._stepper.links[number].interface, state.contacts[number]
            gap = memory.kinematics.place[:, 0]
            if float(gap.min()) < deepest:
                inside = gap[interface.inside(memory)]
                deepest = min(deepest, float(np.min(inside, initial=0.0)))
        return max(0.0, -deepest)

    def _write_motion(self, state: State, row: Array) -> None:
        """The columns that follow from the motion of the block as a whole."""
        body, shape, angles = self._member.body, self._shape, self._angles
        moved, velocity, spin, rotation = state.rigid_motion(
            self._stepper.system, self._member.number
        )
        mass, centre = shape.mass, body.centre + moved
        if body.dimension == 2:
            angles[0] = unwrap(lean(rotation), angles[0])
            write_plane_motion(
                MovingBlock(mass, self._inertia, centre, velocity, angles, spin, spin), row
            )
            return
        angles[0] = lean_in_space(rotation, angles[0])
        angles[1:] = rotation_vector(rotation)
        moving = mass, self._inertia, centre, velocity, angles, spin, rotation.T @ spin
        write_space_motion(MovingBlock(*moving), row)

    def _force(self, state: State, lost: bool) -> Array:
        """Normal and tangential force on the block, in the frame of what carries it, N.

        Where it has lost its carrier the foundation is level.
        """
        own, *edges = self._member.contacts
        force = np.asarray(state.contacts[own].force.sum(axis=0), dtype=np.float64)
        carrier = self._stepper.links[own].interface.carrier
        frame = carrier.frame
        if lost:
            assert isinstance(carrier, Face)
            frame = carrier.reference_frame
            force = frame @ (force @ carrier.frame)
        for number in edges:
            link = self._stepper.links[number]
            pushed = in_space(state.contacts[number].force, link.interface.carrier.frame)
            sign = 1.0 if link.body == self._member.number else -1.0
            force = force + sign * pushed.sum(axis=0) @ frame.T
        return force

    def _first_home(self, state: State) -> dict[Key, Array]:
        """Where the points of the face that stands on the carrier belong along it, m.

        As far from those that touch as in the block: a tilted block has its base foreshortened.
        """
        interface = self._interface
        memory = state.contacts[self._member.contacts[0]]
        carrier, points = interface.carrier, interface.points
        level = carrier.reference_frame if isinstance(carrier, Face) else carrier.frame
        along = points.reference @ level[1:].T
        touching = self._touching(memory)
        home = along + (memory.kinematics.place[touching, 1:] - along[touching]).mean(axis=0)
        keys = interface.keys()
        tag = points.points.tag if isinstance(points, NitschePoints) else np.zeros(points.count)
        same = np.flatnonzero(tag == tag[touching[0]])
        return {keys[q]: home[q] for q in same}

    def _touching(self, memory: Memory) -> Indices:
        """The closed points; where there are none the lowest, and all as low as it is."""
        closed = (memory.force[:, 0] > 0).nonzero()[0]
        if len(closed):
            return closed
        height = np.where(memory.may_touch, memory.kinematics.place[:, 0], np.inf)
        return np.flatnonzero(height <= height.min() + LEVEL * self._interface.size)

    def _slipped(self, memory: Memory) -> Array:
        """Mean displacement of the touching points along the carrier since they were at home.

        Home is where a point belongs at the start, for points of other faces where it has
        to be for the slip not to jump when they first touch.
        """
        place, touching = memory.kinematics.place, self._touching(memory)
        which = touching.tobytes()
        if self._homes is None or self._homes[0] != which:
            self._settle(place, touching)
            keys = self._interface.keys()
            self._homes = which, np.array([self._home[keys[q]] for q in touching])
        return np.asarray((place[touching, 1:] - self._homes[1]).sum(axis=0) / len(touching))

    def _settle(self, place: Array, touching: Indices) -> None:
        """Find homes for points that touch for the first time."""
        keys = self._interface.keys()
        known = [place[q, 1:] - self._home[keys[q]] for q in touching if keys[q] in self._home]
        slip = sum(known) / len(known) if known else self._slip
        for q in touching:
            self._home.setdefault(keys[q], place[q, 1:] - slip)
