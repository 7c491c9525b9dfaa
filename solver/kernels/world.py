"""The compiled world of rigid bodies and its steps (`stepper.hpp`), as Python calls them.

Lengths in m, masses in kg, times in s, angles in rad; the angle of a body in the plane counts
anticlockwise. Places and velocities are relative to the ground.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from solver.kernels.library import library
from solver.types import Array, Indices, Mask

FALLBACKS = {
    "proximal": "softened",
    "velocity solve left out": "rung_4",
}
"""Methods behind Newton's with full steps, by the counts that have them."""


def _turns(d: int) -> int:
    """Number of rotations of a body."""
    return 1 if d == 2 else 3


def _body_widths(d: int) -> dict[str, int]:
    """Widths of what `write_state` of `world_functions.cpp` writes of a body; 0: a number."""
    turns = _turns(d)
    places = {"centre": d, "rotation": 1 if d == 2 else 4, "velocity": d}
    return places | {"spin": turns, "turned": turns, "slip": d, "impulse": d, "penetration": 0}


def _step_widths(d: int) -> dict[str, int]:
    """Widths of what it writes of a step."""
    energies = {"stored": 3, "exchanged": 5}
    return energies | {"ground_impulse": d, "closed": 0, "iterations": 0, "halved": 0}


def _link_widths(d: int) -> dict[str, int]:
    """Widths of what it writes of a link."""
    return {"extension": d, "force": d, "plastic": d, "broken": 0, "broken_at": 0, "lost": 0}


def _collision_widths(d: int) -> dict[str, int]:
    """Widths of what it writes of a collision."""
    numbers = dict.fromkeys(("time", "first", "second", "points"), 0)
    speeds = dict.fromkeys(("approach", "departure", "brought"), 0)
    turns = {"spin": _turns(d), "later_spin": _turns(d)}
    return numbers | {"place": d, "normal": d} | speeds | turns | {"impulse": d, "energy": 0}


def _room(widths: dict[str, int]) -> int:
    """Numbers that some widths take together."""
    return sum(width or 1 for width in widths.values())


def _parted(numbers: Array, widths: dict[str, int]) -> dict[str, Any]:
    """Numbers cut along their last axis into parts of some widths, by their names."""
    found, first = {}, 0
    for name, width in widths.items():
        found[name] = numbers[..., first : first + width] if width else numbers[..., first]
        first += width or 1
    return found


class Mobility(IntEnum):
    """How a body moves."""

    FREE = 0
    FIXED = 1
    PLATFORM = 2
    """Along the horizontal directions alone, on a spring and a dashpot."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Body:
    """A rigid body and how it starts."""

    shape: int | Sequence[int]
    """Number of its shape, or of those of its parts, each of which no other body has."""
    mobility: Mobility = Mobility.FREE
    mass: float = 1.0
    thickness: float = 1.0
    """Thickness of a body in the plane, m."""
    inertia: ArrayLike = 1.0
    """Inertia about the centre, kg m2: a number in the plane; in space its tensor in the body's own
    axes, (3, 3), or three principal moments where these are the axes."""
    stiffness: float = 0.0
    """Stiffness of a platform's spring, N/m."""
    damping: float = 0.0
    """Coefficient of a platform's dashpot, N s/m."""
    spring_force: ArrayLike = 0.0
    """Inertia force of a platform against its spring, N, (d,)."""
    centre: ArrayLike = 0.0
    rotation: ArrayLike = 0.0
    """An angle in the plane, a unit quaternion (w, x, y, z) in space."""
    velocity: ArrayLike = 0.0
    spin: ArrayLike = 0.0
    """Angular velocity about the body's own axes, rad/s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkLaw:
    """The law of a link along one direction."""

    stiffness: float = 0.0
    """k, N/m."""
    damping: float = 0.0
    """Coefficient of the dashpot, which acts where the spring does, N s/m."""
    gap: float = 0.0
    """Extension before it resists, m; negative: the preload over the stiffness."""
    compression: bool = True
    """True if it resists shortening, too."""
    yields: float = math.inf
    """Force at which it flows, N."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Link:
    """A link between two bodies: axial, or along axes that turn with the first one."""

    first: int
    second: int
    ends: tuple[ArrayLike, ArrayLike]
    """Places of its ends on the first and the second body, about their centres, (d,), m."""
    axes: Array | None = None
    """Rows of directions in the frame of the first body, (d, d); None: it is axial."""
    length: ArrayLike = 0.0
    """Distance of its ends at which it is not extended, m; along axes its components, (d,)."""
    laws: Sequence[LinkLaw] = ()
    """One for an axial link, else d."""
    strength: float = math.inf
    """Force at which it breaks, N."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinkStates:
    """States of links at the ends of steps, (steps, links, ...).

    Axial ones have the first direction alone.
    """

    extension: Array
    """m, (..., d)."""
    force: Array
    """Mean over the step, in tension, N, (..., d)."""
    plastic: Array
    """Plastic part of the extension, m, (..., d)."""
    broken: Mask
    broken_at: Array
    """When it broke, s."""
    lost: Array
    """Energy that it had then, J."""

    @classmethod
    def split(cls, d: int, numbers: Array) -> LinkStates:
        """The fields, by the numbers as the library writes them."""
        found = _parted(numbers, _link_widths(d))
        return cls(**found | {"broken": found["broken"] > 0})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Steps:
    """Steps that were taken: places and forces of all bodies, and sums.

    Fields have shapes (steps, bodies, ...) and (steps, ...).
    """

    centre: Array
    rotation: Array
    """Angles (..., 1), or quaternions (..., 4)."""
    velocity: Array
    spin: Array
    """Angular velocity in space."""
    turned: Array
    """Angle or rotation vector, carried on over whole turns."""
    slip: Array
    """Over what carries it, along the axes of that body, (..., d)."""
    impulse: Array
    """Impulse on the body in the step from what it stands on, N s, (..., d)."""
    penetration: Array
    stored: Array
    """Kinetic, gravity and spring energy, J, (steps, 3)."""
    exchanged: Array
    """Energy taken in; lost by friction, damping, contact and time stepping, J, (steps, 5)."""
    ground_impulse: Array
    """Impulse of a platform on the ground in the step, N s, (steps, d)."""
    closed: Array
    """Number of closed contacts."""
    iterations: Array
    """Newton iterations since the start."""
    halved: Array
    """Steps halved since the start."""
    links: Array
    """Numbers of the links (`LinkStates.split`), (steps, links, 3 d + 3)."""
    parts: Array
    """Impulses of contacts in the step on the parts of bodies that have several, one body after
    another, N s, (steps, parts, d)."""

    @classmethod
    def split(
        cls, d: int, of_bodies: Array, of_steps: Array, of_links: Array, of_parts: Array
    ) -> Steps:
        """The fields, by the numbers as the library writes them."""
        found = _parted(of_bodies, _body_widths(d)) | _parted(of_steps, _step_widths(d))
        return cls(**found, links=of_links, parts=of_parts)

    def followed_by(self, later: Steps) -> Steps:
        """These steps and later ones."""
        parts = {
            field.name: np.concatenate([getattr(self, field.name), getattr(later, field.name)])
            for field in fields(self)
        }
        return Steps(**parts)

    def last(self) -> Steps:
        """The last one of them."""
        return Steps(**{field.name: getattr(self, field.name)[-1:] for field in fields(self)})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Collision:
    """Two bodies that met at an instant, over all points at which they did."""

    time: float
    first: int
    second: int
    """Numbers of the bodies, the lower one first."""
    points: int
    place: Array
    """Where, relative to the ground, m."""
    normal: Array
    """From the second to the first."""
    approach: float
    """Largest normal velocity of a point before, m/s."""
    departure: float
    """And after."""
    brought: float
    """Part of the approach that the first brings."""
    spin: Array
    """Angular velocity of the first against the second before, in space, rad/s."""
    later_spin: Array
    """And after; nan where the step was not cut at the instant."""
    impulse: Array
    """On the first, N s."""
    energy: float
    """Lost by the impulses between the two, J."""

    @classmethod
    def read(cls, d: int, row: Array) -> Collision:
        """A collision by the numbers as the library writes them."""
        widths = _collision_widths(d)
        found = _parted(row, widths)
        found |= {name: float(found[name]) for name, width in widths.items() if not width}
        return cls(**found | {name: int(found[name]) for name in ("first", "second", "points")})


class World:
    """Rigid bodies of which every one meets every other."""

    def __init__(self, dimension: int, gravity: ArrayLike, scheme: ArrayLike, velocity_level: bool):
        """Begin without bodies.

        Args:
            dimension: Of space, d.
            gravity: (d,), m/s2.
            scheme: alpha_m, alpha_f and beta of generalized-alpha, for platforms.
            velocity_level: True if contact is also solved at velocity level after each step.
        """
        self._library, self._d = library(), dimension
        self._bodies = self._links = self._forces = self._parts = 0
        self._pairs = np.empty((0, 4 + 4 * dimension))
        self._held = self._library.world_new(
            dimension, _numbers(gravity), _numbers(scheme), bool(velocity_level)
        )

    def half_space(self) -> int:
        """Number of the shape that lies below level 0."""
        return int(self._library.world_half_space(self._held))

    def polygon(self, corners: ArrayLike) -> int:
        """Number of a new convex polygon by its corners (n, 2), anticlockwise."""
        return int(self._library.world_polygon(self._held, _numbers(corners)))

    def polyhedron(self, vertices: ArrayLike, loops: Sequence[Sequence[int]]) -> int:
        """Number of a new convex polyhedron.

        Args:
            vertices: (n, 3).
            loops: Numbers of the vertices around each face, anticlockwise seen from outside.
        """
        return int(self._library.world_polyhedron(self._held, _numbers(vertices), *_lists(loops)))

    def add(self, body: Body) -> None:
        """Add a body; bodies are numbered in the order in which they are added."""
        d, turns = self._d, _turns(self._d)
        at_rest = 0.0 if d == 2 else (1.0, 0.0, 0.0, 0.0)
        turned = body.rotation if np.any(body.rotation) else at_rest
        parts = [
            np.array([body.mass, body.thickness, body.stiffness, body.damping]),
            _tensor(body.inertia, turns).ravel(),
            np.broadcast_to(body.spring_force, d),
            np.broadcast_to(body.centre, d),
            np.ravel(turned),
            np.broadcast_to(body.velocity, d),
            np.broadcast_to(body.spin, turns),
        ]
        shapes = np.atleast_1d(body.shape)
        self._parts += len(shapes) if len(shapes) > 1 else 0
        self._library.world_body(
            self._held, _integers(shapes), body.mobility, np.concatenate(parts, dtype=np.float64)
        )
        self._bodies += 1

    def link(self, link: Link) -> None:
        """Add a link; both of its bodies are there."""
        d = self._d
        axes = np.eye(d) if link.axes is None else link.axes
        laws = [*link.laws, *[LinkLaw()] * (d - len(link.laws))]
        parts = [
            np.broadcast_to(link.ends[0], d),
            np.broadcast_to(link.ends[1], d),
            np.ravel(axes),
            np.broadcast_to(link.length, d),
            np.array([link.strength]),
            *(np.array([x.stiffness, x.damping, x.gap, x.compression, x.yields]) for x in laws),
        ]
        numbers = np.concatenate(parts, dtype=np.float64)
        self._library.world_link(self._held, link.first, link.second, link.axes is None, numbers)
        self._links += 1

    def force(self, body: int, arm: ArrayLike) -> None:
        """Add a force on a point of a body, by its place about the centre, (d,), m.

        Its values are given to `run`.
        """
        self._library.world_force(self._held, body, _numbers(arm))
        self._forces += 1

    def begin(self, laws: ArrayLike, law_of: ArrayLike, carriers: Sequence[Sequence[int]]) -> None:
        """Begin, all bodies being there.

        Args:
            laws: mu_s, mu_d, DC, c, 1 where cohesion is lost by slip, e of each law, (laws, 6).
            law_of: Number of the law of each pair of bodies, (n, n).
            carriers: Numbers of the bodies that each body stands on.
        """
        self._library.world_begin(self._held, _numbers(laws), _integers(law_of), *_lists(carriers))

    def run(
        self,
        count: int,
        dt: float,
        smallest: float,
        ground: Array,
        shift: Array,
        forces: Array | None = None,
    ) -> Steps:
        """Take steps; fewer than `count` where one was not solved.

        Args:
            count: Number of steps.
            dt: Their length.
            smallest: Length below which none is divided.
            ground: Accelerations of the ground at the ends of the steps, (count + 1, d), m/s2.
            shift: By how much the mean over each step exceeds that of its ends, (count, d), m/s2.
            forces: Applied forces at both ends of each step, (count, 2, forces, d), N; None: 0.
        """
        rooms = self._rooms(count)
        if forces is None:
            forces = np.zeros((count, 2, self._forces, self._d))
        given = (_numbers(each) for each in (ground, shift, forces))
        done, pairs = self._library.world_run(self._held, dt, smallest, *given, *rooms)
        self._pairs = np.frombuffer(pairs).reshape(-1, self._pairs.shape[1])
        return Steps.split(self._d, *(each[:done] for each in rooms))

    def now(self) -> Steps:
        """The state at the moment, as that of one step."""
        rooms = self._rooms(1)
        self._library.world_state(self._held, *rooms)
        return Steps.split(self._d, *rooms)

    def _rooms(self, count: int) -> tuple[Array, Array, Array, Array]:
        """Room for what the library writes of bodies, steps, links and parts."""
        d = self._d
        return (
            np.empty((count, self._bodies, _room(_body_widths(d)))),
            np.empty((count, _room(_step_widths(d)))),
            np.empty((count, self._links, _room(_link_widths(d)))),
            np.empty((count, self._parts, d)),
        )

    def collisions(self) -> list[Collision]:
        """The collisions since the last call."""
        told = np.frombuffer(self._library.world_collisions(self._held))
        width = _room(_collision_widths(self._d))
        return [Collision.read(self._d, row) for row in told.reshape(-1, width)]

    def tell_pairs(self, *, every: bool) -> None:
        """Tell from here on what pairs of bodies do in every step of a run, or in its last one.

        Slips are those of the steps that are told.
        """
        self._library.world_tell_pairs(self._held, every)

    def pairs(self) -> Array:
        """The pairs that have ever touched, after the steps of the last run that tell them.

        Rows of the number of the step, both bodies (the lower number first), points that touch,
        normal force and friction on the first (N; d - 1 numbers), gap (m), what the first has
        slipped over the second (m; d - 1 numbers), place (m), normal from the second to the first.
        """
        return self._pairs

    def counts(self) -> dict[str, float]:
        """What the steps so far needed, and the deepest overlap in them."""
        return dict(self._library.world_counts(self._held))

    def reset_deepest(self) -> None:
        """Forget the deepest overlap so far."""
        self._library.world_reset_deepest(self._held)

    def fallbacks(self) -> dict[str, int]:
        """How often contact problems were left to which method after Newton's."""
        found = self.counts()
        return {name: int(found[key]) for name, key in FALLBACKS.items()}

    def saved(self) -> Array:
        """All that steps change, for `restore`."""
        return np.frombuffer(self._library.world_save(self._held))

    def restore(self, saved: Array) -> None:
        """Go back to where all stood when it was saved."""
        self._library.world_restore(self._held, _numbers(saved))


def _tensor(inertia: ArrayLike, turns: int) -> Array:
    """The inertia of a body as a matrix, from its diagonal where that is given."""
    given = np.asarray(inertia, dtype=np.float64)
    return given if given.ndim == 2 else np.diag(np.broadcast_to(given, turns))


def _numbers(values: ArrayLike) -> Array:
    """Numbers as the library reads them."""
    return np.ascontiguousarray(values, dtype=np.float64)


def _integers(values: ArrayLike) -> Indices:
    """Integers as the library reads them."""
    return np.ascontiguousarray(values, dtype=np.int64)


def _lists(lists: Sequence[Sequence[int]]) -> tuple[Indices, Indices]:
    """Lists of integers, one after another, and how long each is."""
    flat = [number for each in lists for number in each]
    return _integers(flat), _integers([len(each) for each in lists])
