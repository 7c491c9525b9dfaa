"""What pairs of bodies do to one another in a run with meshed bodies: collisions, `pairs.csv`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from solver.build.assembly import Assembly
from solver.contact.hull import gaps
from solver.history.events import Meeting
from solver.history.pairs import pair_tangents
from solver.results.meetings import Contacts
from solver.resumable import Resumable
from solver.run.observer import mean_of_top
from solver.scene import BlockSpec, Scene
from solver.scene.laws import GROUND
from solver.stepping.state import Exchange, Push, State
from solver.types import Array

QUIET = 2.0
"""Time without force after which a collision is over, over that in which sound crosses both."""

LONGEST, LONGEST_STEPS = 8.0, 4.0
"""Time after which what still presses does so for good, likewise, and over a step: rigid bodies
part, or go on together, within two or three."""


@dataclass(slots=True)
class Collision:
    """A collision that goes on.

    Attributes:
        begins: Time of the first touch, s.
        approach: Normal velocity with which the bodies came together, m/s.
        brought: Part of it that the first brought, m/s.
        spin: Angular velocity of the first against the second before, in space, or anticlockwise.
        impulse: On the first, (d,), N s.
        normal: Its normal part times the normals, (d,), N s.
        last: Time until which they pressed, s.
        departure: Normal velocity with which they parted, m/s.
        later_spin: As `spin`, after it.
        is_told: True if it has been told of, since they still press.
    """

    begins: float
    approach: float
    brought: float
    spin: Array
    impulse: Array
    normal: Array
    last: float
    departure: float
    later_spin: Array
    is_told: bool = False


class PairObserver(Resumable):
    """Collisions of all bodies but those of blocks with what carries them, and rows of pairs."""

    CARRIED = ("_open", "_slips", "_gaps", "_deepest")

    def __init__(self, scene: Scene, assembly: Assembly):
        """Begin where nothing has touched."""
        self._system = assembly.stepper.system
        self._d, self._tells_rows = scene.dimension, scene.output.pairs
        members = assembly.members
        self.names = (*(member.spec.name for member in members), GROUND)
        self._surfaces = [member.surface for member in members]
        self._parts = [member.parts for member in members]
        self._floor = assembly.floor
        self._support = assembly.support
        self._ground = len(members)
        self._times = [_crossing_time(member.spec, scene) for member in members]
        numbers = {name: k for k, name in enumerate(self.names)}
        self._homes = {(k, numbers[member.spec.carrier]) for k, member in enumerate(members)}
        self._homes |= {(other, one) for one, other in self._homes}
        self._open: dict[tuple[int, int], Collision] = {}
        self._slips: dict[tuple[int, int], Array] = {}
        self._gaps: dict[tuple[int, int], float] = {}
        self._deepest: tuple[float, float, str, str] | None = None

    @property
    def contacts(self) -> Contacts:
        """The deepest overlap of bodies that neither carries the other."""
        return Contacts(self._deepest, 0, 0.0)

    def step(self, before: State, after: State, exchange: Exchange) -> list[Meeting]:
        """The collisions that ended in a step."""
        for pair, whole in self._by_pair(exchange, homes=self._tells_rows).items():
            first, second = (self.names[k] for k in pair)
            if pair not in self._homes and -whole.gap > (self._deepest or (0.0,))[0]:
                self._deepest = (-whole.gap, after.time, first, second)
            gap, self._gaps[pair] = self._gaps.get(pair, 0.0), whole.gap
            if whole.pressed <= 0.0:
                continue
            slip = whole.slip / whole.pressed
            self._slips[pair] = self._slips.get(pair, np.zeros(self._d)) + slip
            if pair in self._homes:
                continue
            place = whole.place
            if pair not in self._open:
                begun = self._open[pair] = self._begun(pair, before, place, whole.normal)
                if 0.0 < gap < begun.approach * (after.time - before.time):
                    begun.begins += gap / begun.approach
            own = self._open[pair]
            own.impulse = own.impulse + whole.impulse
            own.normal = own.normal + whole.normal
            own.last = after.time
            seen = self._relative(pair, after, place, own.normal)
            own.departure, _, own.later_spin = seen
        return list(self._ended(after.time, after.time - before.time))

    def rest(self) -> list[Meeting]:
        """The collisions that go on where the run ends."""
        found = [self._meeting(pair, own) for pair, own in self._open.items() if not own.is_told]
        self._open.clear()
        return found

    def _by_pair(self, exchange: Exchange, *, homes: bool) -> dict[tuple[int, int], Push]:
        """What interfaces did, added up by pairs: to the first body of each.

        With that between blocks and what carries them, `homes`, or without.
        """
        found: dict[tuple[int, int], Push] = {}
        for push in exchange.pushes(homes=homes):
            one, other = (self._number(body) for body in (push.body, push.carrier))
            pair, own = ((one, other), push) if one < other else ((other, one), push.reversed())
            found[pair] = found[pair].plus(own) if pair in found else own
        return found

    def _number(self, body: int | None) -> int:
        """The number of a body among the names."""
        return self._ground if body is None or body >= self._ground else body

    def _begun(
        self, pair: tuple[int, int], before: State, place: Array, normal: Array
    ) -> Collision:
        """A collision that begins in the step after a state."""
        speed, brought, spin = self._relative(pair, before, place, normal)
        return Collision(
            begins=before.time,
            approach=-speed,
            brought=-brought,
            spin=spin,
            impulse=np.zeros(self._d),
            normal=np.zeros(self._d),
            last=before.time,
            departure=0.0,
            later_spin=spin,
        )

    def _relative(
        self, pair: tuple[int, int], state: State, place: Array, normal: Array
    ) -> tuple[float, float, Array]:
        """Speed of the first body along a normal and its spin, against the second, m/s and rad/s.

        Between them the part of that speed which the first brings.
        """
        n = normal / np.linalg.norm(normal)
        (own, spin), (other, spin_other) = (self._velocity(k, state, place) for k in pair)
        return float((own - other) @ n), float(own @ n), spin - spin_other

    def _ended(self, time: float, dt: float) -> Iterator[Meeting]:
        """The collisions that are over by a time (s), after a step, or that go on for good."""
        for pair, own in list(self._open.items()):
            crossing = sum(self._times[k] for k in pair if k != self._ground)
            over = time - own.last > QUIET * crossing
            lasts = time - own.begins > max(LONGEST * crossing, LONGEST_STEPS * dt)
            if (over or lasts) and not own.is_told:
                own.is_told = True
                yield self._meeting(pair, own)
            if over:
                del self._open[pair]

    def _velocity(self, number: int, state: State, place: Array) -> tuple[Array, Array]:
        """Velocity of a rigid body at a place, m/s, and its spin, anticlockwise or (3,), rad/s."""
        d = self._d
        if number == self._ground:
            return self._top_velocity(state), np.zeros(1 if d == 2 else 3)
        motion = state.rigid_motion(self._system, number)
        arm = place - self._surfaces[number].body.centre - motion.moved
        if d == 2:
            turned = motion.spin[0] * np.array([arm[1], -arm[0]])
            return motion.velocity + turned, -motion.spin
        return motion.velocity + np.cross(motion.spin, arm), motion.spin

    def _top_velocity(self, state: State) -> Array:
        """Mean velocity of the top of the foundation, m/s."""
        if self._support.number is None:
            return np.zeros(self._d)
        return mean_of_top(self._support, state.v[self._system.slices[self._support.number]])

    def _meeting(self, pair: tuple[int, int], own: Collision) -> Meeting:
        """A collision as the recorder takes it."""
        return Meeting.of(
            own.begins,
            (self.names[pair[0]], self.names[pair[1]]),
            own.normal,
            own.impulse,
            speeds=(own.approach, own.departure, own.brought),
            spins=(own.spin, own.later_spin),
        )

    def rows(self, state: State, exchange: Exchange, dt: float) -> Array:
        """The rows of all pairs that have touched, as `World.pairs` has them.

        Without `output.pairs` of those that press now, at least; slips are not known then.
        """
        d, found, known = self._d, [], self._by_pair(exchange, homes=True)
        press = {pair for pair, whole in known.items() if whole.pressed > 0.0}
        for pair in sorted(press | self._slips.keys()):
            n: Array = np.zeros(d)
            place: Array = np.full(d, np.nan)
            impulse: Array = np.zeros(d)
            slip, points = self._slips.get(pair, np.zeros(d)), 0
            if pair in press:
                whole = known[pair]
                n, place = whole.normal / np.linalg.norm(whole.normal), whole.place
                impulse, points = whole.impulse, whole.points
            else:
                slip = self._slips[pair] = np.zeros(d)
            along = pair_tangents(n[None])[0]
            numbers = (0.0, *pair, points, impulse @ n / dt, *(along @ impulse / dt))
            apart = self._distance(pair, state)
            found.append([*numbers, apart, *(along @ slip), *place, *n])
        return np.array(found) if found else np.empty((0, 4 + 4 * d))

    def _distance(self, pair: tuple[int, int], state: State) -> float:
        """How far two bodies are apart along the axis that separates their nearest parts best, m.

        Over the ground by their hulls.
        """
        if self._ground in pair:
            all_of = [[self._floor if k == self._ground else self._surfaces[k]] for k in pair]
        else:
            all_of = [list(self._parts[k]) for k in pair]
        one, other = (
            [each.hull.placed(self._system.part(state.u, each.number)) for each in some]
            for some in all_of
        )
        return min(float(gaps(a, b).max()) for a in one for b in other)


def _crossing_time(spec: BlockSpec, scene: Scene) -> float:
    """Time in which sound crosses a block, s; none in a rigid one."""
    if spec.model == "rigid":
        return 0.0
    return 2 * spec.shape.half_diagonal / spec.material(scene.material_plane).wave_speed
