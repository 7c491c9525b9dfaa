"""The interfaces of a scene, as faces join them, and the memories that a step starts from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from solver.contact.carriers import Face
from solver.contact.edge_crossings import CrossingInterface, Crossings
from solver.contact.interface import carry_over, rotate_frame
from solver.contact.memory import Memory
from solver.contact.pairs import ContactPair
from solver.stepping.state import State
from solver.stepping.system import Link, System
from solver.types import Array

Faces = tuple[frozenset[int], ...]
"""Tags of the faces that have joined, for each contact of a scene."""


class StepStart(NamedTuple):
    """Contact as a step sees it at its start.

    Attributes:
        faces: Tags of the faces that have joined by now.
        contacts: Memory of each interface, in the frame of the step.
        exchanged: Interface energy lost by choosing other contact points, J; it is added to what
            contact dissipates.
    """

    faces: Faces
    contacts: Sequence[Memory]
    exchanged: float


class InterfaceState(NamedTuple):
    """Frames of carriers and crossings of edges in a step.

    Attributes:
        faces: Tags of the active faces.
        settled: For each interface the frame of its carrier, or the contacts of its edges.
    """

    faces: Faces
    settled: tuple[Any, ...]

    @classmethod
    def of(cls, faces: Faces, links: Sequence[Link]) -> InterfaceState:
        """The state of these interfaces now."""
        carriers = [link.interface.carrier for link in links]
        return cls(
            faces, tuple(c.detected if isinstance(c, Crossings) else c.frame for c in carriers)
        )

    def restore(self, links: Sequence[Link]) -> None:
        """Set the interfaces of the same faces to this state."""
        for link, settled in zip(links, self.settled, strict=True):
            carrier = link.interface.carrier
            if isinstance(carrier, Crossings):
                carrier.detected = settled
            elif isinstance(carrier, Face):
                carrier.frame = settled


class Interfaces:
    """Candidate pairs and their active faces; each interface is made once and kept."""

    def __init__(self, system: System, contacts: Sequence[ContactPair]):
        """Take the bodies and the pairs that may touch."""
        self._system, self._contacts = system, tuple(contacts)
        self._links: dict[tuple[int, frozenset[int]], Link] = {}
        self._last: tuple[Faces, tuple[Link, ...]] | None = None

    def links(self, faces: Faces) -> tuple[Link, ...]:
        """The interfaces of these faces; collective."""
        if self._last is not None and (self._last[0] is faces or self._last[0] == faces):
            return self._last[1]
        for number, contact in enumerate(self._contacts):
            key = number, faces[number]
            if key not in self._links:
                joined = contact.join(faces[number])
                self._links[key] = Link(joined, contact.body, contact.carrier)
        self._last = faces, tuple(self._links[key] for key in enumerate(faces))
        return self._last[1]

    def facing(self, rotations: Sequence[Array]) -> Faces:
        """Faces that are turned towards their carriers by the rotations of all contacts' bodies."""
        return tuple(
            contact.facing(rotation)
            for contact, rotation in zip(self._contacts, rotations, strict=True)
        )

    def joined_by(self, faces: Faces, rotations: Sequence[Array]) -> Faces:
        """These faces, and those that the rotations turn towards their carriers."""
        turned = self.facing(rotations)
        if all(new <= old for old, new in zip(faces, turned, strict=True)):
            return faces
        return tuple(old | new for old, new in zip(faces, turned, strict=True))

    def rotations(self, u: Array) -> list[Array]:
        """Rotations of the bodies of all contacts' points at a displacement, (d, d) each."""
        return [self._system.rotation(u, contact.body) for contact in self._contacts]

    def rotations_of(self, state: State) -> list[Array]:
        """Rotations of these bodies in a state, from its rigid motions, (d, d) each."""
        system = self._system
        return [
            system.rotation(state.u, None)
            if contact.body is None
            else state.rigid_motion(system, contact.body).rotation
            for contact in self._contacts
        ]

    def turn_carriers(self, u: Array) -> None:
        """Let the frames of all carriers be those at a displacement."""
        for contact in self._contacts:
            if contact.carrier is not None:
                contact.surface.rotate_frame(self._system.rotation(u, contact.carrier))

    def fresh(self, faces: Faces, u: Array) -> list[Memory]:
        """Memories without contact forces at a displacement."""
        part = self._system.part
        return [
            link.interface.start(part(u, link.body), part(u, link.carrier), rotation)
            for link, rotation in zip(self.links(faces), self.rotations(u), strict=True)
        ]

    def energy(self, faces: Faces, contacts: Sequence[Memory]) -> float:
        """Energy stored in all interfaces, J."""
        pairs = zip(self.links(faces), contacts, strict=True)
        return sum(link.interface.energy(memory) for link, memory in pairs)

    def start(self, state: State, faces: Faces, dt: float) -> StepStart:
        """Contact at the start of a step of length `dt` (s); the state is left as it is.

        Faces that have joined by now are active from now on, frames are those of the middle of the
        step, and points of corners are chosen anew.
        """
        contacts, exchanged = state.contacts, 0.0
        if faces is not state.faces and faces != state.faces:
            before = self.energy(state.faces, contacts)
            contacts = self._joined(state, faces)
            exchanged = before - self.energy(faces, contacts)
        links, part = self.links(faces), self._system.part
        ahead = state.u
        if any(
            link.interface.carrier.turns and not memory.clear
            for link, memory in zip(links, contacts, strict=True)
        ):
            ahead = state.u + 0.5 * dt * state.v
        found = []
        for link, memory, rotation in zip(links, contacts, self.rotations_of(state), strict=True):
            if memory.clear:
                found.append(memory)
                continue
            if isinstance(link.interface, CrossingInterface):
                u, carrier_u = part(ahead, link.body), part(ahead, link.carrier)
                prepared = link.interface.prepare(memory, u, carrier_u)
                exchanged += link.interface.energy(memory) - link.interface.energy(prepared)
                found.append(prepared)
                continue
            carrier = None
            if link.carrier is not None and link.interface.carrier.turns:
                carrier = self._system.rotation(ahead, link.carrier)
            memory, lost = rotate_frame(link.interface, memory, rotation, carrier)
            exchanged += lost
            found.append(memory)
        return StepStart(faces, found, exchanged)

    def _joined(self, state: State, faces: Faces) -> list[Memory]:
        """Memories of the interfaces of more faces than a state has."""
        return [
            carry_over(memory, old.interface, new.interface, fresh)
            for memory, old, new, fresh in zip(
                state.contacts,
                self.links(state.faces),
                self.links(faces),
                self.fresh(faces, state.u),
                strict=True,
            )
        ]
