"""Links and applied forces in a step: what they do to bodies.

They act at places of bodies, as impulses like contact: over the change of places in a step they do
exactly the work that springs store and the ledger books.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from solver.bodies.attachment import MeshedPlace, RigidPlace
from solver.bodies.body import Body
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.bodies.rigid_body import DenseBody
from solver.bodies.surface_layer import RowsLayer
from solver.contact.body_points import NodePoints, SummedPoints, SurfaceState
from solver.stepping.body_links import BodyLinks, LinkForces, LinkMemory
from solver.stepping.response import PlacesOfBody
from solver.stepping.system import System
from solver.types import Array, Indices, Mask


class BodyPlace(NamedTuple):
    """A place at which links or forces act.

    Attributes:
        body: Number of the body that has it; None: it stands still, on the ground.
        place: The place as the body has it; on the ground (d,), m.
    """

    body: int | None
    place: MeshedPlace | RigidPlace | Array


class AppliedForce(NamedTuple):
    """A force on a place.

    Attributes:
        place: Its number.
        whole: The force at factor 1, (d,), N.
        mean: Its mean factor over a step, by the start and the length of that, s.
    """

    place: int
    whole: Array
    mean: Callable[[float, float], float]


class PlacesSeen(NamedTuple):
    """All places at an instant.

    Attributes:
        places: (n, d), m.
        states: Those of each body that has any, as it keeps them.
    """

    places: Array
    states: Sequence[SurfaceState]


def points_of(body: Body, places: Sequence[Any]) -> NodePoints | SummedPoints:
    """The places of a body, each of the kind that it has."""
    if isinstance(body, DenseBody):
        points = np.concatenate([place.points for place in places])
        shares = sp.block_diag([place.shares[None] for place in places]).toarray()
        return SummedPoints(body, points, shares)
    assert isinstance(body, ElasticBody | ReducedBody)
    rows = sp.vstack([place.rows for place in places], format="csr")
    layer = RowsLayer(body.comm, rows, body.dimension)
    return NodePoints(body, layer, np.array([place.reference for place in places]))


class Attached:
    """All links and applied forces of a scene, and the places at which they act.

    Attributes:
        links: The links.
        forces: The forces.
        members: The places body by body.
        linked: Those that corrections know as points of bodies: all, or none without links.
        moving: Numbers of those that are not on the ground, body after body.
    """

    def __init__(
        self,
        system: System,
        places: Sequence[BodyPlace],
        links: BodyLinks,
        forces: Sequence[AppliedForce],
    ):
        """Take all places, and links and forces that name them by their numbers."""
        self.links, self.forces = links, tuple(forces)
        self._still: Array = np.zeros((len(places), system.dimension))  # those on the ground
        numbers: dict[int, list[int]] = {}
        for number, (body, place) in enumerate(places):
            if body is None:
                self._still[number] = place
            else:
                numbers.setdefault(body, []).append(number)
        members, first = list[PlacesOfBody](), 0
        for body, own in sorted(numbers.items()):
            found = points_of(system.bodies[body], [places[number].place for number in own])
            members.append(PlacesOfBody(body, system.slices[body], np.array(own), first, found))
            first += found.count
        self.members = tuple(members)
        self.linked = self.members if links.count else ()
        self.moving: Indices = np.concatenate([member.places for member in members])

    def observe(self, u: Array) -> PlacesSeen:
        """All places for all owned unknowns u; collective."""
        found, states = self._still.copy(), []
        for _, own, places, _, points in self.members:
            states.append(points.observe(u[own]))
            found[places] = states[-1].position
        return PlacesSeen(found, states)

    def applied(self, time: float, dt: float) -> Array:
        """Mean forces on all places over a step of dt (s) from a time, (n, d), N."""
        found = np.zeros_like(self._still)
        for force in self.forces:
            found[force.place] += force.mean(time, dt) * force.whole
        return found


class AttachedForces(NamedTuple):
    """What links and forces do at an iterate.

    Attributes:
        seen: All places.
        force: On them, (n, d), N.
        rows: What changes of places do to extensions of links, (extensions, n, d).
        links: The links' own part.
    """

    seen: PlacesSeen
    force: Array
    rows: Array
    links: LinkForces


class AttachedEnd(NamedTuple):
    """What links and forces leave after a step.

    Attributes:
        work: Of applied forces, J.
        lost: In links, by dashpots, flow and fracture, J.
        stored: In links afterwards, J.
        memory: Of links; None: of a scene without links and forces.
    """

    work: float
    lost: float
    stored: float
    memory: LinkMemory | None


UNATTACHED = AttachedEnd(0.0, 0.0, 0.0, None)
"""What a scene without links and forces leaves."""


class StepAttached:
    """Links and forces in one step, or in equilibrium.

    Attributes:
        applied: Mean forces on all places, (n, d), N.
        breaks: Links that break in the step, (links,).
    """

    def __init__(
        self, attached: Attached, start: Array, applied: Array, memory: LinkMemory | None, dt: float
    ):
        """Begin at the unknowns of t_n; in equilibrium dt is infinite, and links stand."""
        self.attached, self.applied, self.memory = attached, applied, memory
        self._before, self._dt = attached.observe(start), dt
        self.breaks: Mask = np.zeros(attached.links.count, dtype=np.bool_)

    def at(self, u: Array) -> AttachedForces:
        """What they do where a step ends at u."""
        return self._at(self.attached.observe(u))

    def _at(self, now: PlacesSeen) -> AttachedForces:
        """What they do where a step ends with these places."""
        links = self.attached.links
        found = self.law(links.measure(now.places))
        rows = links.rows(self._since(now).places, now.places)
        force = self.applied - np.tensordot(found.force, rows, 1)
        return AttachedForces(now, force, rows, found)

    def _since(self, now: PlacesSeen) -> PlacesSeen:
        """The places at the start of a step that ends with others; in equilibrium these."""
        return now if np.isinf(self._dt) else self._before

    def law(self, extension: Array) -> LinkForces:
        """Forces of links at extensions at the end of the step."""
        links = self.attached.links
        if self.memory is None:
            return links.in_equilibrium(extension)
        return links.in_step(self.memory, extension, self._dt, self.breaks)

    def add_forces(self, target: Array, reached: AttachedForces, factor: float) -> None:
        """Add what they do at an iterate, times a factor, to forces on all owned unknowns.

        Their work over the step is exact.
        """
        ends = zip(self._since(reached.seen).states, reached.seen.states, strict=True)
        for (_, own, places, _, points), states in zip(self.attached.members, ends, strict=True):
            points.add_forces(target[own], *states, factor * reached.force[places])

    def with_loads(self, load: Array, weight: float) -> Array:
        """Loads, N, with what links and forces do at the start of the step, `weight` times."""
        found = load.copy()
        self.add_forces(found, self._at(self._before), weight)
        return found

    def round_off(self, bodies: int, weight: float) -> list[float]:
        """Force on each of so many bodies that round-off of places makes in links, N."""
        stiffness = self.attached.links.stiffness(len(self.applied))
        eps, found = float(np.finfo(float).eps), [0.0] * bodies
        each = weight * eps * stiffness * np.linalg.norm(self._before.places, axis=1)
        for member in self.attached.members:
            found[member.body] = float(np.linalg.norm(each[member.places]))
        return found

    def breaks_at(self, reached: AttachedForces) -> bool:
        """Let links that are loaded by more than their strength break; True if any does."""
        assert self.memory is not None
        extension = reached.links.extension
        more = self.attached.links.overloaded(self.memory, extension) & ~self.breaks
        self.breaks = self.breaks | more
        return bool(more.any())

    def end(self, reached: AttachedForces, time: float) -> AttachedEnd:
        """What they leave after a step from a time, s, that ended so."""
        assert self.memory is not None
        links = self.attached.links
        work = float((self.applied * (reached.seen.places - self._before.places)).sum())
        memory, lost = links.after(self.memory, reached.links, time, self._dt, self.breaks)
        return AttachedEnd(work, lost, links.energy(memory), memory)
