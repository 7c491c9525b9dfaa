"""What is worth writing down of each step: one row of the history."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.kinematics import lean, rotation_vector, unwrap
from solver.bodies.oscillator import Oscillator
from solver.bodies.rigid_box import RigidBox
from solver.build.assembly import Assembly, BlockBody
from solver.contact.body_points import NitschePoints
from solver.contact.facet_target import Face
from solver.contact.interface import Key
from solver.contact.memory import Memory
from solver.contact.projection import in_space
from solver.history.columns import DISSIPATED_ENERGIES, ordered
from solver.parallel import global_sum
from solver.stepping.state import Exchange, State
from solver.stepping.stepper import Stepper
from solver.stepping.system import Link
from solver.types import Array, Indices

EXCHANGED = ("input", *DISSIPATED_ENERGIES)
"""What a step takes in and dissipates: the fields of an `Exchange`."""

LEVEL = 1e-9
"""Points are equally low within this part of a block's size: which of them counts is not chance."""


class Observer:
    """Motion of all blocks and of the platform, and the energy ledger.

    Slip and the dissipated energies are carried on from step to step, so every step has to be seen.
    """

    def __init__(self, assembly: Assembly, state: State, names: Sequence[str]):
        """Start at a state.

        Args:
            assembly: Bodies, interfaces, loads.
            state: Where the run starts.
            names: Columns that are written down.
        """
        self._stepper, self._names = assembly.stepper, tuple(names)
        members = {member.spec.name: member for member in assembly.members}
        self._blocks = {
            name: BlockObserver(member, self._stepper, state, members.get(member.spec.on))
            for name, member in members.items()
        }
        self._platform = None
        if "platform.drift_m" in self._names:
            self._platform = PlatformObserver(assembly)
        # The datum of what carries the blocks is where it stands without load.
        self._at_rest = sum(
            member.body.mass * float(self._stepper.gravity @ member.body.centre)
            for member in assembly.members
        )
        self._exchanged = dict.fromkeys(EXCHANGED, 0.0)
        self._start: float | None = None

    def row(self, state: State, exchange: Exchange, step: float) -> list[float]:
        """The values of a history row, in the order of the columns."""
        closed = sum(int((memory.force[:, 0] > 0).sum()) for memory in state.contacts)
        ground = self._stepper.base(state.time)
        values = {
            "time_s": state.time,
            "step_s": step,
            "newton_iterations": float(exchange.iterations),
            "contact_points_closed": float(closed),
            "base.acceleration_m_s2": float(ground[0]),
            "base.second_acceleration_m_s2": float(ground[1]),
            "base.vertical_acceleration_m_s2": float(ground[-1]),
        }
        for name, block in self._blocks.items():
            values |= _named(name, block.columns(state))
        if self._platform is not None:
            values |= _named("platform", self._platform.columns(state, step))
        return ordered(self._names, values | _named("energy", self._energies(state, exchange)))

    def _energies(self, state: State, exchange: Exchange) -> dict[str, float]:
        """Stored, taken in and dissipated energy, J."""
        stepper = self._stepper
        system = stepper.system
        moved = global_sum(system.comm, system.directional_mass @ state.u)
        stored = {
            "kinetic_J": state.kinetic,
            "strain_J": state.strain,
            "gravity_J": -self._at_rest - float(stepper.gravity @ moved),
            "spring_J": state.spring,
            "interface_J": stepper.interface_energy(state),
        }
        for name in EXCHANGED:
            self._exchanged[name] += getattr(exchange, name)
        taken, lost = self._exchanged["input"], [self._exchanged[name] for name in EXCHANGED[1:]]
        total = sum(stored.values())
        if self._start is None:
            self._start = total
        return {
            **stored,
            **{f"{name}_J": value for name, value in self._exchanged.items()},
            "total_J": total,
            "ledger_error_J": total - self._start - taken + sum(lost),
        }


def _named(owner: str, values: Mapping[str, float]) -> dict[str, float]:
    """Values by the full names of their columns."""
    return {f"{owner}.{field}": value for field, value in values.items()}


class BlockObserver:
    """Angle, slip, gaps and forces of one block."""

    def __init__(
        self, member: BlockBody, stepper: Stepper, state: State, carrier: BlockBody | None
    ):
        """Start at a state.

        Args:
            member: The block.
            stepper: What steps it.
            state: Where the run starts.
            carrier: The block that carries it; None: the foundation does.
        """
        self._member, self._stepper, self._carrier = member, stepper, carrier
        self._own = stepper.system.slices[member.number]
        self._angle = 0.0
        self._slip = np.zeros(stepper.system.dimension - 1)
        self._interface = self._link.interface
        self._home = self._first_home(state)
        self._homes: tuple[bytes, Array] | None = None
        self._corners = self._bottom()

    @property
    def _link(self) -> Link:
        """The interface of the block's own points; another one after a face has joined."""
        return self._stepper.links[self._member.contacts[0]]

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

    def columns(self, state: State) -> dict[str, float]:
        """Values of the columns of a block."""
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
        spatial = corners.shape[1] == 3
        ends = ("1", "2", "3", "4") if spatial else ("left", "right")
        along = ("", "_second") if spatial else ("",)
        normal, *tangential = self._force(state, lost)
        return {
            **self._motion(state),
            **{f"slip{way}_m": float(slip) for way, slip in zip(along, self._slip, strict=True)},
            **{f"gap_{end}_m": float(gap) for end, gap in zip(ends, height, strict=True)},
            "penetration_m": self._penetration(state),
            "normal_force_N": float(normal),
            **{
                f"friction_force{way}_N": float(force)
                for way, force in zip(along, tangential, strict=True)
            },
        }

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
            gap = memory.kinematics.place[interface.inside(memory), 0]
            deepest = min(deepest, float(np.min(gap, initial=0.0)))
        return max(0.0, -deepest)

    def _motion(self, state: State) -> dict[str, float]:
        """Angles, angular velocities and centre."""
        body = self._member.body
        moved, _, spin, rotation = state.rigid_motion(self._stepper.system, self._member.number)
        if body.dimension == 2:
            self._angle = unwrap(lean(rotation), self._angle)
        else:
            self._angle = unwrap(float(np.arctan2(rotation[0, 2], rotation[2, 2])), self._angle)
        values = {"angle_rad": self._angle}
        if body.dimension == 2:
            values["angular_velocity_rad_s"] = float(spin[0])
        else:
            for axis, angle, rate in zip("xyz", rotation_vector(rotation), spin, strict=True):
                values[f"angle_{axis}_rad"] = float(angle)
                values[f"angular_velocity_{axis}_rad_s"] = float(rate)
        centre = body.centre + moved
        return values | {f"centre_{x}_m": float(c) for x, c in zip("xyz", centre, strict=False)}

    def _force(self, state: State, lost: bool) -> Array:
        """Normal and tangential force on the block, in the frame of what carries it, N.

        Args:
            state: At the end of a step.
            lost: Whether the block has lost its carrier: the foundation is level.
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


class PlatformObserver:
    """Drift, velocity and acceleration of what carries the blocks, where it moves as a whole."""

    def __init__(self, assembly: Assembly):
        """Start at rest."""
        self._support, system = assembly.support, assembly.stepper.system
        assert assembly.support.number is not None
        self._own = system.slices[assembly.support.number]
        self._velocity: Array | None = None

    def columns(self, state: State, step: float) -> dict[str, float]:
        """Drift, velocity, acceleration along x; in space the same along y.

        The acceleration is the increment of velocity over the step, impulses of contact counted in.
        """
        drift, velocity = (self._mean(vector[self._own]) for vector in (state.u, state.v))
        before = velocity if self._velocity is None else self._velocity
        self._velocity = velocity
        values = {}
        for k, way in enumerate(("", "_second")[: len(drift)]):
            values[f"drift{way}_m"] = float(drift[k])
            values[f"velocity{way}_m_s"] = float(velocity[k])
            values[f"acceleration{way}_m_s2"] = float((velocity[k] - before[k]) / step)
        return values

    def _mean(self, vector: Array) -> Array:
        """Horizontal components of the platform's motion: of a meshed one, the mean of its top."""
        body, surface = self._support.body, self._support.surface
        if isinstance(body, Oscillator):
            return body.replicate(vector)
        assert isinstance(body, ElasticBody) and surface is not None
        nodes = surface.layer.gather(vector.reshape(-1, body.dimension))
        return np.asarray(nodes.mean(axis=0)[:-1])
