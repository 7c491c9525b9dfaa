"""The recorder of events, which takes in every step of a run, of all engines alike.

**Impacts.** A block rocks in swings: stays of its angle theta, against what carries it, on one side
of zero (`solver.results.rocking`). An impact ends a swing. Angular velocities before and after it
are those of the block as a rigid body against what carries it.

**Collisions** are all other meetings that the engine tells of, if the bodies come together faster
than a block falls by as little as counts as a lift.

Where neither the block nor what carries it deforms an impact takes no time: they are the slopes of
theta in the steps on both sides, extrapolated to the instant; where the engine tells at which
instant two bodies meet, they are those that it has there.

Where something deforms, an impact lasts from the first touch of the edge that lands to the step in
which the edge that leaves is off and the normal force is back to the weight. Its angular velocities
are angular momenta, about the edge that leaves before it and about the edge that lands after it,
over the rotary inertia about that edge:

    omega = (I_c theta' + m d x (v - v_O)) / I_O,    d from the edge O to the centre.      (1)

Vibration of a block that stands on O does not change them, since the contact forces act at O. What
gravity, ground, carrier and damping proportional to mass do to them is

    I_O omega' = m d x (g - a_O) - lambda I_O omega,                                       (2)

and the angular velocities of the impact are those at theta = 0 of the rigid block that (2) leads to
these steps, or from them:

    omega_0^2 = omega^2 - 2 integral of omega' over theta from 0.                          (3)

It is their mean over a window that ends with the first touch; after the impact that is the last
quarter of the time up to the peak, since an elastic block hops on the edge first.

Velocities are means of steps, (u_{n+1} - u_n)/dt, which generalized-alpha makes the mean of those
at both ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property, reduce
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from geometry.block import Block
from geometry.outline import rolls
from solver.history.columns import Rows
from solver.history.events import Event, Meeting
from solver.history.history import History
from solver.results.endings import beyond_return, fallen, has_ends
from solver.results.motion import (
    CLEAR,
    SMALLEST_LIFT,
    SMALLEST_WAY,
    BlockMotion,
    Columns,
    centres,
    lost_carrier,
    platform_drift,
    upright_axes,
)
from solver.results.rocking import Swing, begins, end_of, swings
from solver.resumable import Resumable
from solver.scene import BlockSpec, Scene
from solver.scene.laws import GROUND
from solver.types import Array, Indices

CHUNK = 2048
"""Steps after which events are looked for."""

MOST_ROWS = 1 << 15
"""Steps that are kept for a swing that does not end."""

LONGEST_SWING = 5.0
"""Time after an impact at which the swing after it needs no end, over the time scale 1/p."""

FIT_STEPS = 4
"""Steps on either side of an impact of rigid bodies, through which a parabola goes."""

IMPACT_FORCE = 3.0
"""Normal force over the weight with which a step belongs to an impact of rigid bodies."""

MOMENTUM_WINDOW = 0.4
"""Time before an impact over which angular momentum is read where something deforms, over 1/p."""

REBOUND_TIME = 1.0
"""Time after it in which an elastic block may hop on the edge that it landed on, over 1/p."""

SETTLED_FRACTION = 0.75
"""Part of that time, or of the time up to the peak, after which it stands on that edge."""

LARGEST_SLIP = 1e-2
"""Slip in that window, over the width, with which what is read is no rotation."""

LARGEST_RESTITUTION = 1.005
"""Largest ratio of angular velocities that may be a restitution, read with an error."""

LARGEST_SIDE_LEAN = 0.01
"""Lean out of the plane of rocking, over the largest angle, with which a block rolls."""

LARGEST_HOP = 0.15
"""Height to which a block hops, over that to which its centre rises in the swings beside: with more
of their energy in it no ratio of rotations is a restitution. Elastic blocks of H/B 3 hop by 0.08
on firm ground and by 0.11 on a plate like themselves, of H/B 2 by 0.2, cubes by 0.5."""

LEAST_KEPT = 0.1
"""Part of the least speed of a collision with which one may still end a swing that counts."""

UPWARDS = 0.5
"""Upward component of the normal with which a body is below the other."""

HOPS = "it hops"
ROLLS = "it rolls over its corners"
FASTER = "faster than before: something else gave it energy"
SLIDES = "it slides, and vibration hides how fast it turns"
ENDS = "the run ends with it"
CROWDED = "the next one follows at once"


class _Motion(BlockMotion):
    """A block in the upright plane in which it leans most, over steps."""

    def _planar(self, place: Array) -> Array:
        """Places along the plane and upwards."""
        return np.stack([place[:, :-1] @ self.direction, place[:, -1]], axis=1)

    def _turned(self, name: str) -> Array:
        """Angle of a block from upright in the plane."""
        if len(self._ways) == 1:
            return self._rows[f"{name}.angle_rad"]
        axes = upright_axes(self._rows, name)
        return np.unwrap(np.arctan2(axes[:, :2] @ self.direction, axes[:, 2]))

    @cached_property
    def from_upright(self) -> Array:
        """Angle from upright in the plane, rad."""
        return self._turned(self._name)

    @cached_property
    def place(self) -> Array:
        """Its centre along the plane and upwards, (rows, 2), m."""
        return self._planar(centres(self._rows, self._name))

    @cached_property
    def pull(self) -> Array:
        """Gravity less the ground's acceleration, (rows, 2), m/s2."""
        rows, gravity = self._rows, np.array(self._scene.gravity_vector)
        pull: Array = np.tile([self.direction @ gravity[:-1], gravity[-1]], (len(self.time), 1))
        for part, way in zip(self.direction, ("", "second_"), strict=False):
            if f"base.{way}acceleration_m_s2" in rows:
                pull[:, 0] -= part * rows[f"base.{way}acceleration_m_s2"]
        if "base.vertical_acceleration_m_s2" in rows:
            pull[:, 1] -= rows["base.vertical_acceleration_m_s2"]
        return pull

    @cached_property
    def below(self) -> Array:
        """Centre of the block that carries it, or drift of the platform, (rows, 2), m."""
        if self._carrier is not None:
            return self._planar(centres(self._rows, self._carrier.name))
        return self._planar(platform_drift(self._rows, self._scene.dimension))

    @cached_property
    def below_turn(self) -> Array:
        """Angle of what carries it, rad; 0 of what rolls, and of the foundation."""
        if self._carrier is None or rolls(self._carrier.shape, self._scene.dimension):
            return np.zeros(len(self.time))
        return self._turned(self._carrier.name)


class Recorder(Resumable):
    """Finds the events of a run in its steps as they come; the same on all ranks."""

    CARRIED = ("_rows", "_count", "_first", "_noted", "_found", "_met")

    def __init__(self, scene: Scene, names: Sequence[str], *, rigid: bool = False):
        """Begin; `names` are those of the columns of rows, `rigid`: as if nothing deformed."""
        self._scene, self._names = scene, tuple(names)
        self._rows: list[Array] = []
        self._count = 0
        self._first = {block.name: 0 for block in scene.blocks}
        self._noted: dict[str, dict[str, float]] = {block.name: {} for block in scene.blocks}
        self._found: list[Event] = []
        self._firm = {b.name: rigid or scene.is_rigid or _firm(scene, b) for b in scene.blocks}
        self._met = _Meetings(scene)

    @property
    def events(self) -> tuple[Event, ...]:
        """The events so far, by their times."""
        return tuple(sorted(self._found, key=lambda e: (e.time_s, e.block, e.kind, e.meets)))

    def add(self, rows: Array, met: Iterable[Meeting] = (), happened: Iterable[Event] = ()) -> None:
        """The rows of steps that were taken, (n, columns), who met, and what happened in them."""
        self._met.add(met)
        self._found += happened
        while len(rows):
            room = max(1, CHUNK - self._count % CHUNK)
            self._rows.append(rows[:room].copy())
            self._count += len(self._rows[-1])
            rows = rows[room:]
            if self._count % CHUNK == 0:
                self._find(ends=False)

    def finish(self) -> tuple[Event, ...]:
        """All events of a run that ends here."""
        if self._rows:
            self._find(ends=True)
        return self.events

    def _find(self, *, ends: bool) -> None:
        """Find the events that no later step can change, or all, and let go of older steps."""
        table = np.concatenate(self._rows)
        for block in self._scene.blocks:
            first = self._first[block.name]
            rows = Rows(self._names, table[first:])
            search = _Search(self._scene, block, rows, self._noted[block.name], self._met)
            self._found += search.run(firm=self._firm[block.name], ends=ends)
            self._first[block.name] = max(first + search.needed, len(table) - MOST_ROWS)
        if ends:
            self._found += self._met.collisions({})
            return
        time = table[:, self._names.index("time_s")]
        searched = {name: time[max(row - 2 * FIT_STEPS, 0)] for name, row in self._first.items()}
        self._found += self._met.collisions(searched)
        # A whole number of chunks goes, so that the next search begins where it would have begun.
        gone = min(self._first.values()) // CHUNK * CHUNK
        self._rows, self._count = [table[gone:]], len(table) - gone
        self._first = {name: first - gone for name, first in self._first.items()}


def recorded(scene: Scene, history: History) -> tuple[Event, ...]:
    """The events of a history: those that its run recorded, else those found in its rows."""
    if history.events is not None:
        return history.events
    recorder = Recorder(scene, history.columns)
    recorder.add(np.stack([history[name] for name in history.columns], axis=1))
    return recorder.finish()


def _firm(scene: Scene, block: BlockSpec) -> bool:
    """True if neither a block nor anything below it deforms."""
    if block.model == "elastic" or scene.contact.has_bed:
        return False
    carrier = scene.carrier_of(block)
    return not scene.foundation.is_meshed if carrier is None else _firm(scene, carrier)


class _Meetings(Resumable):
    """Meetings of bodies that no event tells of so far."""

    CARRIED = ("_waiting", "_taken")

    def __init__(self, scene: Scene):
        """Begin with none."""
        self._gravity = scene.gravity
        self._widths = {block.name: block.width for block in scene.blocks}
        self._waiting: list[Meeting] = []
        self._taken: set[Meeting] = set()

    def add(self, met: Iterable[Meeting]) -> None:
        """Take in those that may matter."""
        self._waiting += [m for m in met if m.approach_m_s >= LEAST_KEPT * self._least_speed(m)]

    def _least_speed(self, met: Meeting) -> float:
        """Speed of a fall by as little as counts as a lift of the narrower of two blocks, m/s."""
        widths = [self._widths[n] for n in (met.first, met.second) if n in self._widths]
        return math.sqrt(2 * self._gravity * SMALLEST_LIFT * min(widths))

    def take(self, block: BlockSpec, time: float, begin: float, end: float) -> Meeting | None:
        """The meeting of a block with what is below it that is nearest to a time, between two, s.

        All with the same body from the beginning to the end are one. It is an event from here on.
        """
        found = [
            m
            for m in self._waiting
            if begin < m.time_s <= end
            and block.name in (m.first, m.second)
            and self._is_above(block, m)
            and m not in self._taken
        ]
        if not found:
            return None
        nearest = min(found, key=lambda m: abs(m.time_s - time))
        same = [m for m in found if (m.first, m.second) == (nearest.first, nearest.second)]
        self._taken.update(same)
        return reduce(Meeting.joined, same)

    @staticmethod
    def _is_above(block: BlockSpec, met: Meeting) -> bool:
        """True if a block meets what carries it, or any body from above."""
        other, up = (met.second, met.up) if met.first == block.name else (met.first, -met.up)
        return other in block.carriers or up > UPWARDS

    def collisions(self, searched: dict[str, float]) -> Iterator[Event]:
        """Meetings that are no other event up to the times to which blocks were searched, s."""
        waiting = []
        for met in self._waiting:
            names = (met.first, met.second)
            if met.time_s >= min((searched[n] for n in names if n in searched), default=math.inf):
                waiting.append(met)
                continue
            if met not in self._taken and met.approach_m_s >= self._least_speed(met):
                yield _collision(met)
        self._waiting = waiting
        self._taken &= set(waiting)


def _collision(met: Meeting) -> Event:
    """The event of two bodies that meet: the faster one strikes the other."""
    first, second = met.first, met.second
    strikes = 2 * met.brought_m_s >= met.approach_m_s
    if second == GROUND or (first != GROUND and strikes):
        striking, struck = first, second
    else:
        striking, struck = second, first
    return Event(time_s=met.time_s, kind="collision", block=striking, meets=struck, **met.measures)


class _Search:
    """The search for the events of one block in some rows."""

    def __init__(
        self,
        scene: Scene,
        block: BlockSpec,
        rows: Columns,
        noted: dict[str, float],
        met: _Meetings,
    ):
        """Rows that begin at rest, with a swing or right after an impact; `noted` is changed."""
        self._scene, self._block, self._rows, self._noted = scene, block, rows, noted
        self._met = met
        self._carrier = scene.carrier_of(block)
        self.needed = max(0, len(rows["time_s"]) - 2 * FIT_STEPS)
        """First row that the next search needs."""

    def run(self, *, firm: bool, ends: bool) -> Iterator[Event]:
        """The events that are certain; all where the run ends here."""
        self._motion = motion = _Motion(self._scene, self._rows, self._block)
        self._off = (motion.normal <= 0) & (motion.low > CLEAR * self._block.width)
        # What carries the block and all on it at rest, N.
        self._weight = -self._scene.stacked_mass(self._block) * motion.pull[:, 1]
        yield from self._endings()
        if len(motion.time) > 2:
            yield from self._flights(ends=ends)
            yield from self._swings(firm=firm, ends=ends)

    def _once(self, key: str, time: float) -> bool:
        """True if nothing of a kind was found up to a time (s); it is noted."""
        new = time > self._noted.get(key, -np.inf)
        if new:
            self._noted[key] = time
        return new

    def _event(self, time: float, kind: str, **values: Any) -> Event:
        """An event of the block."""
        return Event(
            time_s=float(time),
            kind=kind,
            block=self._block.name,
            meets=self._block.carrier,
            **values,
        )

    def _endings(self) -> Iterator[Event]:
        """The first row in which it has lost its carrier, overturned or fallen, each once."""
        block, rows, carrier = self._block, self._rows, self._carrier
        masks = {"overturned": beyond_return(rows, block)}
        if carrier is not None:
            masks["carrier lost"] = lost_carrier(rows, block, carrier)
        if has_ends(self._scene, block):
            masks["fell"] = fallen(self._scene, rows, block)
        for kind, mask in masks.items():
            if mask.any() and kind not in self._noted:
                self._noted[kind] = time = float(rows["time_s"][int(np.argmax(mask))])
                yield self._event(time, kind)

    def _flights(self, *, ends: bool) -> Iterator[Event]:
        """Events at which it leaves what carries it, and at which it lands again.

        A flight is told as soon as it counts for certain, so that a long one needs no old rows.
        """
        m, off, width = self._motion, self._off, self._block.width
        counts, on = m.flies.copy(), np.flatnonzero(~off)
        told = self._noted.pop("aloft", None) is not None and bool(off[0])
        if told:
            counts[: on[0] + 1 if len(on) else None] = True
        if off[-1] and not ends:
            begun = int(on[-1]) + 1 if len(on) else 0
            if m.low[begun:].max() > SMALLEST_WAY * width or (told and not begun):
                self._noted["aloft"] = float(m.time[-1])
            else:
                counts[begun:] = False
                self.needed = min(self.needed, max(begun - 3, 0))
        mask = np.r_[False, counts, False]
        for first, end in np.flatnonzero(np.diff(mask)).reshape(-1, 2):
            lands = int(end) - 1
            if first and self._once("flight", m.time[first]):
                every = np.arange(m.gaps.shape[1])
                yield self._beside(m.time[first], "flight", every, m.low, after=first - 1)
            if not off[lands] and self._once("landing", m.time[lands]):
                down = np.flatnonzero(m.gaps[lands] <= CLEAR * width)
                found = self._beside(m.time[lands], "landing", down, m.low, lands - 2, lands + 1)
                met = self._meeting(float(m.time[lands]), max(lands - 1, 0))
                yield found if met is None else self._exact(found, met)

    def _beside(
        self,
        time: float,
        kind: str,
        corners: Indices,
        height: Array,
        before: int | None = None,
        after: int | None = None,
    ) -> Event:
        """An event of some corners with their height, by the steps that begin in two rows."""
        m, known = self._motion, {}
        for when, row in (("before", before), ("after", after)):
            if row is not None:
                known[f"velocity_{when}_m_s"] = _slope(m.time, height, row)
                known[f"angular_velocity_{when}_rad_s"] = _slope(m.time, m.angle, row)
        return self._event(time, kind, where=self._named(corners), **known)

    def _swings(self, *, firm: bool, ends: bool) -> Iterator[Event]:
        """Lift-offs and impacts; none of a swing that is in the air from beginning to end."""
        m, last = self._motion, len(self._motion.time) - 1
        told = self._noted.get("impact", -np.inf)
        free = int(np.searchsorted(m.time, told, side="right"))
        found = [s for s in swings(m.time, m.angle, m.shape.slenderness()) if s.first >= free]
        for swing, after in zip_longest(found, found[1:]):
            row, at = end_of(swing, m.time, m.angle)
            if swing.last < last and self._off[max(swing.first - 1, 0) : row + 2].all():
                free = row + 1
                continue
            start = begins(swing, m.angle, m.shape.slenderness(), free)
            rests = (
                m.time[start] - self._noted.get("impact", -np.inf)
                > MOMENTUM_WINDOW * self._time_scale
            )
            stood = start > free and not self._off[start - 1 : swing.first + 1].all()
            if stood and rests and self._once("lift-off", m.time[start]):
                lifted = self._lifted(swing.first)
                height = m.gaps[:, lifted].mean(axis=1)
                yield self._beside(m.time[start], "lift-off", lifted, height, after=swing.first - 1)
            over = after is not None and after.last < last
            late = m.time[-1] - at > LONGEST_SWING * self._time_scale
            if swing.last == last or not (ends or over or late):
                self.needed = min(self.needed, max(start - 2, free))
                return
            yield self._impact(swing, after, _Span(free, row, at), firm=firm)
            self._noted["impact"] = at
            free = row + 1

    @property
    def _time_scale(self) -> float:
        """1/p of the block, s; infinite without gravity."""
        gravity = self._scene.gravity
        return 1 / self._motion.shape.frequency(gravity) if gravity > 0 else np.inf

    def _named(self, corners: Indices) -> str:
        """Names of bottom corners."""
        names = ("left", "right") if self._motion.gaps.shape[1] == 2 else ("1", "2", "3", "4")
        return "+".join(names[k] for k in corners)

    def _lifted(self, row: int) -> Indices:
        """The corners that are higher over what carries it in a row."""
        gaps = self._motion.gaps[row]
        return np.flatnonzero(gaps >= 0.5 * (gaps.max() + gaps.min()))

    def _impact(self, swing: Swing, after: Swing | None, span: _Span, *, firm: bool) -> Event:
        """The end of a swing."""
        m, side = self._motion, 1.0 if swing.peak_rad > 0 else -1.0
        rows = slice(swing.first, swing.last + 1)
        lands = self._lifted(swing.first + int(np.argmax(np.abs(m.angle[rows]))))
        later = -side if after is None else (1.0 if after.peak_rad > 0 else -1.0)
        last = len(m.time) - 1 if after is None else after.last
        met = self._meeting(span.time, span.row) if firm else None
        if firm:
            read = self._rates(span, last, met)
        else:
            read = self._momenta(swing, after, span, (side, later), lands)
        (before, kept), n, r = read.velocities, span.row, read.end
        ratio = abs(kept / before) if before else math.nan
        reason = self._reason(swing, after) or read.reason
        if not reason and not ratio <= LARGEST_RESTITUTION:
            reason = ENDS if math.isnan(ratio) else FASTER
        height, weight = m.gaps[:, lands].mean(axis=1), self._weight[n + 1 : r + 1]
        found = self._event(
            span.time,
            "impact",
            where=self._named(lands),
            velocity_before_m_s=_slope(m.time, height, n - 1),
            velocity_after_m_s=_slope(m.time, height, r),
            angular_velocity_before_rad_s=before,
            angular_velocity_after_rad_s=kept,
            impulse_Ns=float((m.normal[n + 1 : r + 1] - weight) @ np.diff(m.time[n : r + 1])),
            energy_lost_J=_lost(m.shape, (side, before), (later, kept)),
            restitution=math.nan if reason == ROLLS else ratio,
            reason=reason,
        )
        return found if met is None else self._exact(found, met)

    def _meeting(self, time: float, row: int) -> Meeting | None:
        """The meeting with what is below it in the step after a row, or in those beside it."""
        steps, last = self._motion.time, len(self._motion.time) - 1
        for aside in (0, 1):
            ends = steps[max(row - aside, 0)], steps[min(row + 1 + aside, last)]
            # Times of rows and of meetings have round-off of their own.
            tiny = 1e-9 * (ends[1] - ends[0])
            begin = ends[0] + (tiny if row else -tiny)
            met = self._met.take(self._block, time, begin, ends[1] + tiny)
            if met is not None:
                return met
        return None

    def _exact(self, event: Event, met: Meeting) -> Event:
        """An event at the instant and with the velocities and impulses that the engine has."""
        turning: dict[str, Any] = {
            "angular_velocity_before_rad_s": self._turning(met, met.spin_rad_s),
            "angular_velocity_after_rad_s": self._turning(met, met.later_spin_rad_s),
        }
        return replace(
            event,
            time_s=met.time_s,
            meets=met.second if met.first == self._block.name else met.first,
            **met.measures,
            **{name: spin for name, spin in turning.items() if not math.isnan(spin)},
        )

    def _turning(self, met: Meeting, spin: tuple[float, ...]) -> float:
        """Angular velocity of the block in its plane against what it meets, rad/s."""
        sign = 1.0 if met.first == self._block.name else -1.0
        if len(spin) == 1:
            return -sign * spin[0]
        x, y = self._motion.direction
        return float(sign * (x * spin[1] - y * spin[0]))

    def _reason(self, before: Swing, after: Swing | None) -> str:
        """Reason why no ratio of rotations is a restitution by the swings beside it; or ""."""
        m = self._motion
        rows = slice(before.first, (after or before).last + 1)
        if m.aside[rows].max() > LARGEST_SIDE_LEAN * np.abs(m.angle[rows]).max():
            return ROLLS
        rises = [_rise(m.shape, s.peak_rad) for s in (before, after or before)]
        begin = np.searchsorted(m.time, before.peak_s)
        end = np.searchsorted(m.time, after.peak_s, side="right") if after else None
        hop = np.max(m.low[begin:end], initial=0.0)
        return HOPS if hop > LARGEST_HOP * max(rises) else ""

    def _rates(self, span: _Span, last: int, met: Meeting | None) -> _Read:
        """The angular velocities of a meeting, or the slopes of the angle beside the impact."""
        if met is not None and not math.isnan(sum(met.later_spin_rad_s)):
            exact = self._turning(met, met.spin_rad_s), self._turning(met, met.later_spin_rad_s)
            return _Read(exact, span.row, "")
        m, n, end = self._motion, span.row, min(span.row + 2, len(self._motion.time) - 1)
        pushes = m.normal > IMPACT_FORCE * self._weight
        while end < last and self._weight[end] > 0 and pushes[end]:
            end += 1
        found: list[float] = []
        for first, final in (
            (max(span.first, n - FIT_STEPS), n),
            (end, min(end + FIT_STEPS, last)),
        ):
            if final - first < 2:
                known = found[0] if found else math.nan
                over = bool(found) and last == len(m.time) - 1
                return _Read((known, math.nan), end, ENDS if over else CROWDED)
            rows: Indices = np.arange(first, final + 1)
            rows = rows[np.diff(m.time[rows], prepend=-np.inf) > 0]
            time, angle = m.time[rows], m.angle[rows]
            middle, rate = 0.5 * (time[1:] + time[:-1]) - span.time, np.diff(angle) / np.diff(time)
            line = np.polynomial.Polynomial.fit(middle, rate, min(2, len(rate) - 1))
            found.append(float(line(0.0)))
        return _Read((found[0], found[1]), end, "")

    def _momenta(
        self,
        swing: Swing,
        after: Swing | None,
        span: _Span,
        sides: tuple[float, float],
        lands: Indices,
    ) -> _Read:
        """The angular velocities beside an impact that takes some time, by (1) to (3)."""
        m, tiny, width = self._motion, CLEAR * self._block.width, MOMENTUM_WINDOW * self._time_scale
        first, end, last = span.row, self._exchange_ends(span, sides, lands), len(m.time) - 1
        height = m.gaps[:, lands].max(axis=1)
        while first > swing.first and height[first] <= tiny:
            first -= 1
        begin = int(np.searchsorted(m.time, max(swing.peak_s, m.time[first] - width)))
        until = min(
            span.time + REBOUND_TIME * self._time_scale, np.inf if after is None else after.peak_s
        )
        over = min(int(np.searchsorted(m.time, until)), last)
        settled = m.time[end] + SETTLED_FRACTION * (m.time[over] - m.time[end])
        before = self._at_zero(sides[0], max(begin, span.first), first, last=False)
        kept = self._at_zero(sides[1], end, over, start=int(np.searchsorted(m.time, settled)))
        near = m.displacement[begin : int(np.searchsorted(m.time, span.time + width)) + 1]
        slides = np.ptp(near, axis=0).max() > LARGEST_SLIP * self._block.width
        return _Read((before, kept), end, SLIDES if slides else "")

    def _exchange_ends(self, span: _Span, sides: tuple[float, float], lands: Indices) -> int:
        """The row in which the edge that leaves is off, and the force is back to the weight."""
        m, after = self._motion, slice(span.row + 1, None)
        others = np.setdiff1d(np.arange(m.gaps.shape[1]), lands)
        leaves = others if len(others) and sides[0] != sides[1] else lands
        over = m.gaps[after][:, leaves].max(axis=1) > CLEAR * self._block.width
        over &= (m.normal[after] <= self._weight[after]) & (
            m.time[after] < span.time + MOMENTUM_WINDOW * self._time_scale
        )
        row = span.row + 1 + int(np.argmax(over)) if over.any() else span.row + 2
        return min(row, len(m.time) - 1)

    def _at_zero(
        self, side: float, low: int, high: int, *, start: int = 0, last: bool = True
    ) -> float:
        """The angular velocity at angle zero that leads to (1), or comes of it, by (3), rad/s.

        Args:
            side: On which side the edge is, towards positive angles.
            low: First row.
            high: Last row.
            start: First row that counts.
            last: False where the impact is at the end of these rows.
        """
        if high - low < 1:
            return np.nan
        m, own = self._motion, slice(low, high + 1)
        shape, time, carried = m.shape, m.time[own], self._carrier is not None
        dt = np.diff(time)
        angle, turn, place, below, pull = (
            0.5 * (values[own][1:] + values[own][:-1])
            for values in (m.angle, m.from_upright, m.place, m.below, m.pull)
        )
        own_side = 1 if side > 0 else -1
        x, y = -side * shape.arm(own_side), shape.centre_height
        arm = np.stack([np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x])
        spin_below = np.diff(m.below_turn[own]) / dt
        reach = place - arm.T - below
        edge = np.diff(m.below[own], axis=0) / dt[:, None]
        if carried:
            edge = edge + spin_below[:, None] * np.stack([reach[:, 1], -reach[:, 0]], axis=1)
        speed = np.diff(m.place[own], axis=0) / dt[:, None] - edge
        inertia = shape.rotary_inertia_about_corner(own_side)
        share = shape.mass / inertia
        spin = shape.rotary_inertia / inertia * np.diff(m.from_upright[own]) / dt
        spin += share * (speed[:, 0] * arm[1] - speed[:, 1] * arm[0])
        gain = share * (pull[:, 0] * arm[1] - pull[:, 1] * arm[0])
        nearest = 0 if last else len(gain) - 1
        lead = gain[nearest] * angle[nearest]  # a_O swings within the impact
        if len(dt) > 1:
            swings = np.gradient(edge, 0.5 * (time[1:] + time[:-1]), axis=0)
            gain -= share * (swings[:, 0] * arm[1] - swings[:, 1] * arm[0])
        damping = self._scene.damping_of(self._block) if self._block.model == "elastic" else None
        if damping is not None:
            gain -= damping.mass * spin
        work = np.append(0.0, np.cumsum(0.5 * (gain[1:] + gain[:-1]) * np.diff(angle)))
        work += lead - work[nearest]
        chosen = slice(min(max(start - low, 0), len(dt) - 1), None)
        spin -= spin_below
        square = float(((spin**2 - 2 * work) * dt)[chosen].sum() / dt[chosen].sum())
        return math.copysign(math.sqrt(max(square, 0.0)), spin[nearest])


class _Span(NamedTuple):
    """Rows of an impact."""

    first: int
    """First row after the impact before it."""
    row: int
    """Last row before it."""
    time: float
    """s."""


class _Read(NamedTuple):
    """Values read of an impact."""

    velocities: tuple[float, float]
    """Angular velocities before and after, rad/s."""
    end: int
    """The row at which it is over."""
    reason: str
    """Reason why nothing is known, or ""."""


def _rise(shape: Block, peak: float) -> float:
    """What the centre of mass of a block rises to a peak (rad) over its edge, m."""
    side = -1 if peak < 0 else 1
    alpha = shape.slenderness(side)
    return shape.radius(side) * (math.cos(alpha - abs(peak)) - math.cos(alpha))


def _lost(shape: Block, before: tuple[float, float], kept: tuple[float, float]) -> float:
    """Kinetic energy that a block loses from one edge to another, by sides and spins, J."""
    if shape.is_even:
        return 0.5 * shape.rotary_inertia_about_corner() * (before[1] ** 2 - kept[1] ** 2)
    first, second = (
        0.5 * shape.rotary_inertia_about_corner(1 if side > 0 else -1) * spin**2
        for side, spin in (before, kept)
    )
    return first - second


def _slope(time: Array, value: Array, row: int) -> float:
    """Slope in the step that begins in a row; nan where it is missing."""
    if row < 0 or row + 1 >= len(time):
        return math.nan
    return float((value[row + 1] - value[row]) / (time[row + 1] - time[row]))
