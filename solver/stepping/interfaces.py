"""The interfaces of a scene, as faces join them, and the memories that a step starts from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from solver.bodies.kinematics import RigidMotion
from solver.contact.edge_crossings import CrossingInterface
from solver.contact.interface import carry_over, turned
from solver.contact.memory import Memory
from solver.contact.pairs import TURN, ContactPair, Link, PairSearch
from solver.stepping.state import State
from solver.stepping.system import System
from solver.types import Array, Mask

Active = tuple[Any, ...]
"""What is active of each pair of a scene."""


class StepStart(NamedTuple):
    """Contact as a step sees it at its start.

    Attributes:
        active: What is active of each pair.
        contacts: Memory of each interface, in the frame of the step.
        exchanged: Interface energy lost by choosing other contact points, J; it is added to what
            contact dissipates.
    """

    active: Active
    contacts: Sequence[Memory]
    exchanged: float


class BodiesInStep:
    """The bodies of a system at the start of a step, as pairs see them."""

    def __init__(self, system: System, state: State, step: float):
        """Take the state that the step starts from, and its length, s."""
        self._system, self._state, self._step = system, state, step
        self._expected: Array | None = None

    def unknowns(self, body: int | None) -> Array | None:
        """Owned unknowns of a body; None for the ground."""
        return self._system.part(self._state.u, body)

    def expected(self, body: int | None) -> Array | None:
        """Owned unknowns of a body expected at the end of the step; None for the ground."""
        if self._expected is None:
            self._expected = self._state.u + self._step * self._state.v
        return self._system.part(self._expected, body)

    def rotation(self, body: int | None) -> Array:
        """Rotation of a body, (d, d); the identity for the ground."""
        if body is None:
            return self._system.rotation(self._state.u, None)
        return self.motion(body).rotation

    def motion(self, body: int) -> RigidMotion:
        """Motion of a body as a whole."""
        return self._state.rigid_motion(self._system, body)


class PairWatch:
    """Which pairs have to be looked at again since bodies have moved.

    What it says depends on when pairs were looked at; what is found active does not, since nothing
    else can be before.
    """

    def __init__(self, system: System, pairs: Sequence[ContactPair]):
        """Watch the pairs."""
        self._system = system
        d, still = system.dimension, len(system.bodies)
        self._ends = np.array(
            [(pair.body, still if pair.on is None else pair.on) for pair in pairs]
        )
        # Of each body its displacement, rotation, velocity and spin; the last one stands still.
        sizes = d, d * d, d, 1 if d == 2 else 3
        self._placed = d + d * d
        self._now: Array = np.zeros((still + 1, sum(sizes)))
        self._looked = np.zeros((len(pairs), 2, sum(sizes)))
        # Of both bodies of each pair: way, turn, speed, spin.
        self._change: Array = np.zeros((4, len(pairs)))
        self._reach, self._slack = np.zeros((2, len(pairs)))
        self._sums = np.tile(np.repeat(np.eye(4), sizes, axis=0), (2, 1))
        self._state: State | None = None

    def may_change(self, state: State, step: float) -> Mask:
        """Pairs that have to be looked at in a step of a length (s) from a state, (pairs,)."""
        if state is not self._state:
            for body in range(len(self._now) - 1):
                moved, velocity, spin, rotation = state.rigid_motion(self._system, body)
                own = np.concatenate([moved, rotation.ravel(), velocity, spin])
                self._now[body, : len(own)] = own  # what cannot turn has no spin
            change = np.abs(self._now.take(self._ends, axis=0) - self._looked)
            self._change = (change.reshape(len(change), -1) @ self._sums).T
            self._state = state
        moved, turned, speed, spin = self._change
        turn = turned + step * spin
        way = moved + step * speed + self._reach * turn
        return np.asarray((way >= self._slack) | (turn >= TURN))

    def looked(self, number: int, found: PairSearch) -> None:
        """Watch a pair, by its number, from where it has been looked at."""
        self._looked[number, :, : self._placed] = self._now[self._ends[number], : self._placed]
        self._change[:2, number] = 0.0
        self._reach[number], self._slack[number] = found.reach, found.slack


class Interfaces:
    """Pairs that may touch and what is active of them."""

    def __init__(self, system: System, pairs: Sequence[ContactPair]):
        """Take the bodies and the pairs that may touch."""
        self._system, self._pairs = system, tuple(pairs)
        self._watch = PairWatch(system, self._pairs)
        self._found: list[PairSearch | None] = [None] * len(self._pairs)  # when looked at last
        self._last: Active | None = None
        self._links: tuple[Link, ...] = ()  # of what was active last

    def links(self, active: Active) -> tuple[Link, ...]:
        """The active interfaces, pair after pair; collective."""
        if self._last is active or (self._last is not None and self._last == active):
            return self._links
        found: list[Link] = []
        owned: dict[int, frozenset[int]] = {}
        for pair, own in zip(self._pairs, active, strict=True):
            faces, taken = pair.faces(own), owned.get(pair.body, frozenset())
            found += pair.links(own, faces & taken)
            owned[pair.body] = taken | faces
        self._last, self._links = active, tuple(found)
        return self._links

    def active(self, state: State, step: float, before: Active | None) -> Active:
        """What is active in a step of a length (s) from a state, by what was before."""
        bodies = BodiesInStep(self._system, state, step)
        found = list(before or [None] * len(self._pairs))
        may_change = self._watch.may_change(state, step)
        for number, pair in enumerate(self._pairs):
            last = self._found[number]
            if may_change[number] or last is None or last.active != found[number]:
                last = self._found[number] = pair.search(bodies, found[number])
                found[number] = last.active
                self._watch.looked(number, last)
        return before if before is not None and tuple(found) == before else tuple(found)

    def overlap(self, state: State) -> bool:
        """True if bodies have come to overlap in the step that led to a state, unawares.

        What strikes them in a step may send them farther than their velocities told.
        """
        bodies = BodiesInStep(self._system, state, 0.0)
        return any(
            self._pairs[number].is_missed(bodies, state.active[number])
            for number in self._watch.may_change(state, 0.0).nonzero()[0]
        )

    def fresh(self, active: Active, state: State) -> list[Memory]:
        """Memories without contact forces in a state."""
        return [self._fresh(link, state) for link in self.links(active)]

    def _fresh(self, link: Link, state: State) -> Memory:
        """The memory of an interface without contact forces in a state."""
        bodies = BodiesInStep(self._system, state, 0.0)
        own, carrier = bodies.unknowns(link.body), bodies.unknowns(link.carrier)
        rotations = bodies.rotation(link.body), bodies.rotation(link.carrier)
        return link.interface.start(own, carrier, *rotations)

    def energy(self, active: Active, contacts: Sequence[Memory]) -> float:
        """Energy stored in all interfaces, J."""
        pairs = zip(self.links(active), contacts, strict=True)
        return sum(link.interface.energy(memory) for link, memory in pairs)

    def start(self, state: State, active: Active, dt: float) -> StepStart:
        """Contact at the start of a step of length `dt` (s); the state is left as it is.

        Frames are those of the middle of the step, and points of corners are chosen anew.
        """
        contacts, exchanged = state.contacts, 0.0
        if active is not state.active and active != state.active:
            before = self.energy(state.active, contacts)
            contacts = self._joined(state, active)
            exchanged = before - self.energy(active, contacts)
        links, part = self.links(active), self._system.part
        ahead = state.u
        if any(link.interface.carrier.turns for link in links):
            ahead = state.u + 0.5 * dt * state.v
        bodies = BodiesInStep(self._system, state, dt)
        found: list[Memory] = []
        for number, (link, memory) in enumerate(zip(links, contacts, strict=True)):
            if isinstance(link.interface, CrossingInterface):
                u, carrier_u = part(ahead, link.body), part(ahead, link.carrier)
                prepared = link.interface.prepare(memory, u, carrier_u)
                exchanged += link.interface.energy(memory) - link.interface.energy(prepared)
                outline = links[number - 1].interface
                before = outline.energy(found[-1])
                prepared, found[-1] = link.interface.without_corners(prepared, outline, found[-1])
                exchanged += before - outline.energy(found[-1])
                found.append(prepared)
                continue
            carrier = None
            if link.carrier is not None and link.interface.carrier.turns:
                carrier = self._system.rotation(ahead, link.carrier)
            own = bodies.rotation(link.body)
            memory, lost = turned(link.interface, memory, own, carrier)
            exchanged += lost
            found.append(memory)
        return StepStart(active, found, exchanged)

    def _joined(self, state: State, active: Active) -> list[Memory]:
        """Memories of the interfaces when more or others are active than in a state."""
        known = dict(zip(self.links(state.active), state.contacts, strict=True))
        found = []
        for link in self.links(active):
            memory = known.get(link)
            if memory is None:
                memory = self._fresh(link, state)
                for old, before in known.items():
                    if follows(old, link):
                        memory = carry_over(before, old.interface, link.interface, memory)
            found.append(memory)
        return found


def follows(old: Link, new: Link) -> bool:
    """True if points of one interface are points of another one, over the same face."""
    same = old.body == new.body and old.interface.carrier is new.interface.carrier
    return same and old.interface.corners is not None and new.interface.corners is not None
