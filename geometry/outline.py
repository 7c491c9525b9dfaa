"""Outlines of bodies, seen along the axis about which they turn: whether they roll or overturn.

A body that turns on level ground stands on its outline, the convex hull of what is seen of it. At a
lean theta its centre of mass is at a height h(theta) over the ground: lowest on the faces on which
the body can rest, and highest between two of these, where it balances on a corner.

A body **rolls** from one such face to the next where that costs no more than it does a regular
hexagon: the faces are at most 60 degrees apart, and on the way its centre rises by at most
2/sqrt(3) - 1, 15 % of its height on the lower one. All faces to which it rolls from the one on
which it stands are its base. It overturns where it goes beyond the balance at an end of that base.
A drum, whose base goes all the way round, and a body that has no other base do not overturn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometry.block import Block
from geometry.convex import hull_of
from geometry.polygon import NEAR
from solver.types import Array

FARTHEST = math.pi / 3
"""Turn from one face to the next up to which a body rolls, rad: that of a regular hexagon."""

HIGHEST = 2 / math.sqrt(3)
"""Height of the centre between them, over that on the lower one, up to which it does, likewise."""

LYING = math.radians(1)
"""A body lies on its next base within this lean, rad."""

BISECTIONS = 60


class Limits(NamedTuple):
    """How far a body leans to one side without overturning, rad."""

    next_face: float
    """The balance beyond which it rolls to another face of its base; infinite where it has none."""
    balance: float
    """The one at the end of its base, beyond which it goes over; infinite where it rolls on."""
    no_return: float
    """Not before that: where it has no more energy than upright, or lies on its next base."""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A convex outline about the centre of mass; leans are positive towards +x."""

    corners: Array
    """Anticlockwise from the face that looks most downwards on, along x and up, (n, 2), m."""

    @classmethod
    def of(cls, places: ArrayLike, centre: ArrayLike) -> Outline:
        """The outline of places, (n, 2), m, about the centre of mass (2,), m."""
        found = hull_of(places, NEAR)[0] - np.asarray(centre)
        lowest = int(np.argmin(np.abs(_directions(found))))
        return cls(corners=np.roll(found, -lowest, axis=0))

    def height(self, lean: float) -> float:
        """Height h of the centre of mass over the ground at a lean (rad), m."""
        return float((self.corners @ [math.sin(lean), -math.cos(lean)]).max())

    def rests(self) -> Array:
        """Leans with which it can rest, rad, rising: its centre is over the face on the ground."""
        sides = np.roll(self.corners, -1, axis=0) - self.corners
        length = np.linalg.norm(sides, axis=1)
        begins = np.einsum("ni,ni->n", self.corners, sides) / length
        tiny = NEAR * length.max()
        turns = _directions(self.corners)
        leans = turns[0] + np.append(0.0, np.cumsum(np.diff(turns) % (2 * np.pi)))
        return np.asarray(leans[(begins < -tiny) & (begins + length > tiny)])

    def limits(self) -> Limits:
        """How far it leans towards +x from where it stands, at a lean of 0."""
        own, other = _Side(self), _Side(Outline.of(self.corners * [-1.0, 1.0], (0.0, 0.0)))
        next_face = own.balances[0] if own.faces > 1 else math.inf
        if own.beyond > 2 * np.pi - other.last - NEAR:  # what comes next is its own base
            return Limits(next_face, math.inf, math.inf)
        balance, lies = own.balances[-1], own.beyond - LYING
        return Limits(next_face, balance, max(balance, min(self._back(balance, own.beyond), lies)))

    def _back(self, first: float, last: float) -> float:
        """Where between two leans the centre, which only falls there, is as low as upright, rad."""
        upright = self.height(0.0)
        if self.height(last) >= upright:
            return last
        for _ in range(BISECTIONS):
            middle = 0.5 * (first + last)
            first, last = (middle, last) if self.height(middle) > upright else (first, middle)
        return last


class _Side:
    """The base of an outline towards +x."""

    def __init__(self, outline: Outline):
        """Go from face to face."""
        corners, rests = outline.corners, outline.rests()
        # It balances on a corner that is below the centre, which then is as high as it is far.
        over = np.arctan2(corners[:, 0], -corners[:, 1]) % (2 * np.pi)
        far = np.hypot(corners[:, 0], corners[:, 1])
        self.last, self.beyond, self.faces = 0.0, math.inf, 1
        self.balances: list[float] = []
        """Leans at which it balances after each of its faces, rad."""
        for rest in (*rests[rests > NEAR], 2 * np.pi):
            between = (over >= self.last) & (over < rest)
            top = int(np.argmax(np.where(between, far, 0.0)))
            self.balances.append(float(over[top]) if between.any() else self.last)
            lower = min(outline.height(self.last), outline.height(rest))
            if rest - self.last > FARTHEST + NEAR or far[top] > (HIGHEST + NEAR) * lower:
                self.beyond = float(rest)
                return
            self.last, self.faces = float(rest), self.faces + 1


def _directions(corners: Array) -> Array:
    """Angles of the sides of a polygon from +x, rad, from -pi to pi."""
    sides = np.roll(corners, -1, axis=0) - corners
    return np.arctan2(sides[:, 1], sides[:, 0])


@lru_cache(maxsize=1 << 14)
def limits_towards(block: Block, direction: tuple[float, ...]) -> Limits:
    """How far a block that is no box leans in a horizontal direction of its own axes.

    The direction is a unit vector, (1,) in the plane, (2,) in space.
    """
    d = len(direction) + 1
    places = [_seen(corner, direction) for corner in block.corners(d)]
    return Outline.of(places, _seen(block.centre_of_mass(d), direction)).limits()


@lru_cache(maxsize=256)
def rolls(block: Block, dimension: int) -> bool:
    """True if a block rolls from the face on which it stands to others, along x or y."""
    if block.solid is None:
        return False
    ways = np.concatenate([np.eye(dimension - 1), -np.eye(dimension - 1)])
    found = [limits_towards(block, tuple(map(float, way))).next_face for way in ways]
    return min(found) < math.inf


def _seen(place: Sequence[float], direction: Sequence[float]) -> tuple[float, float]:
    """A place along a horizontal direction and upwards."""
    return sum(x * along for x, along in zip(place, direction, strict=False)), place[-1]
