"""Impacts of rigid blocks that have a restitution, at an instant, in the plane and in space.

Where a point lands, the velocities v_n of the touching points along their normals obey a law with
the impulses P and the rebounds r,

    0 <= P_n  complementary to  v_n+ - r >= 0,      r = e [-v_n-(2 c - x)]_+,

x being the place of the point and c the centre of the touching points of the same two bodies: the
middle of the two that are farthest apart. A point takes the rebound of the place opposite. A block
that stands on one edge, or in the plane on one corner, and lands on the opposite one leaves the
first with e times the speed of the landing: omega+ = e omega- about the new one, as in Housner's
equation. One that lands flat rebounds with e times its speed, as in Newton's law. A point that
lands alone has no rebound, and neither has in space an edge: of points on one line the speed at
which both ends land is not given back. (A matrix of restitution with e off the diagonal: see
Glocker, An introduction to impacts, 2006.)

Below Housner's e, less than what friction and pressure leave, the old pivots have to be held back:
there alone an impulse may pull.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import Bounds
from solver.law.local_problem import solve
from solver.law.velocity import ENERGY_ROUND_OFF, REGULAR, friction_share
from solver.types import Array, Indices, Mask

#: Rounds in which the diagonal that makes W definite acts on what the last one changed only.
ROUNDS = 3
#: A point that moves by less than this part of the speed of the landing is a pivot, and one that
#: is less than this part of a line's length beside it is on it.
PIVOT = 1e-6
#: Tries to find an impulse, ten times as large each, that pulling impulses stay below.
TRIES = 8


class Rebounds(NamedTuple):
    """Rebound speeds of m touching points, and which of them are pivots."""

    speed: Array
    """r of each point, m/s."""
    pivots: Mask
    """The points about which a block turns that lands."""


class Impact(NamedTuple):
    """Impulses of the touching points, and the energy that they take."""

    impulse: Array
    """Flat, (d m,), N s."""
    contact: float
    """Energy taken in the normal directions, J."""
    friction: float
    """Energy taken in the tangential directions, J."""


@compiled
def _on_a_line(place: Array, pair: Indices, i: int, start: Array, way: Array) -> bool:
    """True if all points of the pair of point i lie on the line through `start` along `way`."""
    length = np.sum(way * way)
    for j in range(len(pair)):
        if pair[j] == pair[i]:
            aside = place[j] - start
            aside = aside - np.sum(aside * way) / length * way
            if np.sum(aside * aside) > PIVOT**2 * length:
                return False
    return True


@compiled
def rebounds(
    restitution: Array, pair: Indices, place: Array, slope: Array, velocity: Array
) -> Rebounds:
    """The rebound of each point, which is that of the place opposite.

    Args:
        restitution: e of each point, (m,).
        pair: Number of the two bodies that touch there, (m,).
        place: Of the points, in coordinates of which v_n of a pair is a linear function, (m, k), m;
            k is 1 in the plane.
        slope: Of that function, (m, k), 1/s.
        velocity: v_n before the impact, (m,), m/s.
    """
    count = len(velocity)
    speed, pivots = np.zeros(count), np.zeros(count, dtype=np.bool_)
    for i in range(count):
        a, b, farthest = -1, -1, 0.0
        for j in range(count):
            for k in range(j):
                if pair[j] == pair[i] and pair[k] == pair[i]:
                    apart = np.sum((place[j] - place[k]) ** 2)
                    if apart > farthest:
                        a, b, farthest = j, k, apart
        if a >= 0:
            way = place[a] + place[b] - 2.0 * place[i]
            opposite = velocity[i] + np.sum(slope[i] * way)
            together = 0.0
            if place.shape[1] > 1 and _on_a_line(place, pair, i, place[a], place[b] - place[a]):
                together = max(min(-velocity[a], -velocity[b]), 0.0)
            speed[i] = restitution[i] * max(-opposite - together, 0.0)
            pivots[i] = opposite < 0.0 and abs(velocity[i]) < PIVOT * abs(opposite)
    return Rebounds(speed, pivots)


@compiled
def impact(
    d: int, W: Array, velocity: Array, asked: Rebounds, friction: Array, counts: Indices
) -> Impact:
    """The impulses of an impact; those of no rebound where none were found with one.

    Args:
        d: Rows of a point.
        W: Of the touching points, (d m, d m), 1/kg.
        velocity: Before the impact, (d m,), m/s.
        asked: The rebounds.
        friction: mu of each point, (m,).
        counts: Of outcomes of local problems.
    """
    impulse = _impulses(d, W, velocity, asked, friction.copy(), counts)
    spent = impulse * (velocity + 0.5 * (W @ impulse))
    lost, normal = -np.sum(spent), -np.sum(spent[::d])
    rubbed = friction_share(lost - normal, lost, 0.0)
    return Impact(impulse, lost - rubbed, rubbed)


@compiled
def _impulses(
    d: int, W: Array, velocity: Array, asked: Rebounds, mu: Array, counts: Indices
) -> Array:
    """Impulses of the touching points, flat, N s."""
    rebound, count, none = asked.speed, len(mu), np.zeros(len(mu))
    plastic, solved = _settle(d, W, velocity, none, mu, none, counts)
    if not solved:
        return np.zeros(d * count)
    found, solved = _settle(d, W, velocity, rebound, mu, none, counts)
    if not solved:
        return plastic
    after, pull = velocity + W @ found, none.copy()
    for i in range(count):
        if asked.pivots[i] and after[d * i] > rebound[i] * (1.0 + PIVOT):
            pull[i], mu[i] = np.sum(plastic[::d]), 0.0
    for _ in range(TRIES):
        if not np.any(pull > 0.0):
            break
        held, solved = _settle(d, W, velocity, rebound, mu, pull, counts)
        if solved and np.all((pull == 0.0) | (held[::d] > -0.5 * pull)):
            found = held
            break
        pull *= 10.0
    return _without_gain(W, velocity, plastic, found)


@compiled
def _settle(
    d: int, W: Array, velocity: Array, rebound: Array, mu: Array, pull: Array, counts: Indices
) -> tuple[Array, bool]:
    """Solve the law of impact; `pull`: by how much impulses may fall below 0, N s."""
    count = len(rebound)
    diagonal, regular = np.zeros(d * count), W.copy()
    shift, total = np.zeros(d * count), np.zeros(d * count)
    for k in range(d * count):
        diagonal[k] = REGULAR * W[k, k]
        regular[k, k] += diagonal[k]
    shift[::d] = pull
    aim = velocity - W @ shift
    aim[::d] -= rebound
    states, bounds = np.empty(count, np.int64), Bounds(mu, np.zeros(count), np.inf)
    for _ in range(ROUNDS):
        free = aim - diagonal * total
        if not solve(d, regular, free, bounds, total, states, counts):
            return total, False
    return total - shift, True


@compiled
def _without_gain(W: Array, velocity: Array, plastic: Array, found: Array) -> Array:
    """The impulses, on the way from those without rebound as far as no energy is gained.

    Newton's law of impact and friction together may give more than there was. What is lost on the
    way is a parabola that begins with what the plastic impact loses.
    """
    way = found - plastic
    lost = -np.sum(plastic * (velocity + 0.5 * (W @ plastic)))
    slope = -np.sum(way * (velocity + W @ plastic))
    curve = 0.5 * np.sum(way * (W @ way))
    if lost + slope - curve >= -ENERGY_ROUND_OFF * np.sum(np.abs(found * velocity)):
        return found
    part = (slope + math.sqrt(slope * slope + 4.0 * curve * max(lost, 0.0))) / (2.0 * curve)
    return plastic + min(max(part, 0.0), 1.0) * way
