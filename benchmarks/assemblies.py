"""Random assemblies of rigid blocks, driven far.

    ./in-env python3 -m benchmarks.assemblies [COUNT] [FIRST SEED] [MOST IN SPACE]

Heaps, rows and walls of 2 to 30 convex blocks in the plane, in space of 2 to 15 or so many, with
masses up to 1e4 times as large as others, on ground that rests or shakes. No step may fail; no
energy may be gained; at the end blocks overlap by less than 1e-6 of the smallest edge. Writes one
line for each that breaks a limit, and the worst numbers. Takes five minutes; walls in space take
most of it.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from solver.kernels.world import Body, Mobility, World
from solver.rigid.rows import rotation_matrices
from solver.types import Array

GRAVITY = 9.81
STEP = 1e-3
GAIN = 1e-10
"""Largest gain, and error of the ledger, over the energy that is there."""
OVERLAP = 1e-6
"""Largest overlap at the end over the smallest edge."""
MOST, MOST_IN_SPACE = 30, 15
"""Largest numbers of blocks in the plane, and in space where nothing else is asked for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What became of an assembly."""

    name: str
    completed: bool
    gain: float
    ledger: float
    overlap: float
    unsettled: int
    """Steps taken at the accuracy there was."""

    @property
    def holds(self) -> bool:
        """True if it went to its end within the limits."""
        return self.completed and max(self.gain, self.ledger) < GAIN and self.overlap < OVERLAP


def _corners(half: Array) -> Array:
    """Corners of a box about its centre, by half its edges."""
    signs = np.array(np.meshgrid(*[(-1, 1)] * len(half))).reshape(len(half), -1).T
    return np.asarray(signs * half)


def _box(d: int, random: np.random.Generator) -> Array:
    """Corners of a box of random size."""
    return _corners(random.uniform(0.1, 0.3, d))


def _hull(d: int, random: np.random.Generator) -> Array:
    """Corners of a convex body about some centre."""
    points = random.normal(size=(random.integers(d + 1, 12), d))
    return np.asarray(0.25 * points / np.linalg.norm(points, axis=1)[:, None])


class Assembly:
    """Blocks on level ground, and how it shakes."""

    def __init__(self, seed: int, most_in_space: int = MOST_IN_SPACE):
        """Draw all of it."""
        self._random = random = np.random.default_rng([48, seed])
        self.d = d = int(random.integers(2, 4))
        self.kind = str(random.choice(["heap", "row", "wall"]))
        count = int(random.integers(2, (MOST if d == 2 else most_in_space) + 1))
        self.name = f"{self.kind} of {count} in {d} dimensions, seed {seed}"
        scheme = 0.0, 0.5, 0.5
        self.world = World(d, [*(0.0,) * (d - 1), -GRAVITY], scheme, True)
        self.smallest, self.bodies = np.inf, count + 1
        place = {"heap": self._heap, "row": self._row, "wall": self._wall}[self.kind]
        for number in range(count):
            place(number)
        self.world.add(Body(shape=self.world.half_space(), mobility=Mobility.FIXED))
        laws = [[mu, mu, 0.0, 0.0, 0.0, e] for mu, e in random.uniform([0, 0], [1, 0.8], (4, 2))]
        if self.kind == "wall":
            laws = [[mu, mu, 0.0, 0.0, 0.0, 0.0] for mu in random.uniform(0.2, 0.8, 4)]
        law_of = random.integers(0, 4, (count + 1, count + 1))
        law_of = np.triu(law_of) + np.triu(law_of, 1).T
        self.world.begin(laws, law_of, [*([count],) * count, []])
        self.amplitude = float(random.choice([0.0, 0.3, 1.0])) * GRAVITY
        self.frequency = float(random.uniform(1.0, 6.0))

    def ground(self, count: int) -> Array:
        """Acceleration of the ground at the ends of so many steps, m/s2, (count + 1, d)."""
        ground = np.zeros((count + 1, self.d))
        turns = 2 * np.pi * self.frequency * STEP * np.arange(count + 1)
        ground[:, 0] = self.amplitude * np.sin(turns)
        return ground

    def _add(self, corners: Array, lowest: Array, velocity: Array | float, turned: bool) -> None:
        """Add a convex body of uniform density whose lowest point is at a height."""
        d, random = self.d, self._random
        hull = ConvexHull(corners)
        corners = corners[hull.vertices] if d == 2 else corners
        loops = [] if d == 2 else _faces(corners)
        mass, centre, inertia, axes = _mass_properties(corners, loops)
        corners = (corners - centre) @ axes
        edges = np.linalg.norm(corners[:, None] - corners, axis=2)
        self.smallest = min(self.smallest, float(edges[edges > 1e-9].min()))
        density = 2000.0 * 10 ** float(random.uniform(-2, 2))
        angle = float(random.uniform(0, 2 * np.pi)) if turned else 0.0
        rotation: Array = np.array([angle])
        if d == 3:
            four = random.normal(size=4) if turned else np.array([1.0, 0.0, 0.0, 0.0])
            rotation = four / np.linalg.norm(four)
        turn = rotation_matrices(rotation)
        place = lowest.copy()
        place[-1] -= float((corners @ turn.T)[:, -1].min())
        world = self.world
        shape = world.polygon(corners) if d == 2 else world.polyhedron(corners, loops)
        spin = 2.0 * random.normal(size=1 if d == 2 else 3) if turned else 0.0
        world.add(
            Body(
                shape=shape,
                mass=density * mass,
                inertia=density * inertia,
                centre=place,
                rotation=rotation,
                velocity=velocity,
                spin=spin,
            )
        )

    def _heap(self, number: int) -> None:
        """Bodies of all shapes, one above another, that fall."""
        draw = _box if self._random.random() < 0.5 else _hull
        low = np.append(self._random.uniform(-0.3, 0.3, self.d - 1), 0.05 + 1.1 * number)
        self._add(draw(self.d, self._random), low, self._random.normal(size=self.d), True)

    def _row(self, number: int) -> None:
        """Boxes side by side that run into each other."""
        low = np.zeros(self.d)
        low[0] = 0.65 * number
        velocity = np.zeros(self.d)
        velocity[0] = self._random.uniform(-2, 2)
        self._add(_box(self.d, self._random), low, velocity, False)

    def _wall(self, number: int) -> None:
        """Bricks in running bond, three a course."""
        course, place = divmod(number, 3)
        size = np.array([0.4, 0.2]) if self.d == 2 else np.array([0.4, 0.2, 0.2])
        low = np.zeros(self.d)
        low[0], low[-1] = 0.402 * place + 0.201 * (course % 2), 0.2 * course
        self._add(_corners(size / 2), low, 0.0, False)


def _faces(corners: Array) -> list[list[int]]:
    """Loops around the faces of a polyhedron, anticlockwise from outside; flat triangles joined."""
    hull, found = ConvexHull(corners), {}
    for equation, simplex in zip(hull.equations, hull.simplices, strict=True):
        key = tuple(np.round(equation, 9) + 0.0)
        found.setdefault(key, set()).update(map(int, simplex))
    loops = []
    for key, members in found.items():
        normal, numbers = np.array(key[:3]), np.array(sorted(members))
        arms = corners[numbers] - corners[numbers].mean(axis=0)
        first = arms[0] / np.linalg.norm(arms[0])
        angles = np.arctan2(arms @ np.cross(normal, first), arms @ first)
        loops.append([int(k) for k in numbers[np.argsort(angles)]])
    return loops


def _mass_properties(corners: Array, loops: list[list[int]]) -> tuple[float, Array, Array, Array]:
    """Area or volume, centre, principal moments and their axes (columns), by simplices."""
    d = corners.shape[1]
    inner = corners.mean(axis=0)
    edges = [[k, (k + 1) % len(corners)] for k in range(len(corners))]
    triangles = [[own[0], own[k], own[k + 1]] for own in loops for k in range(1, len(own) - 1)]
    parts = [np.vstack([inner, corners[part]]) for part in (edges if d == 2 else triangles)]
    sizes = np.array([abs(np.linalg.det(p[1:] - p[0])) for p in parts]) / (2 if d == 2 else 6)
    middles = np.array([p.mean(axis=0) for p in parts])
    centre = sizes @ middles / sizes.sum()
    second = np.zeros((d, d))
    for size, p, middle in zip(sizes, parts, middles, strict=True):
        arms = p - centre
        sums = arms.T @ arms + (d + 1) ** 2 * np.outer(middle - centre, middle - centre)
        second += size / ((d + 1) * (d + 2)) * sums
    if d == 2:
        return float(sizes.sum()), centre, np.array([np.trace(second)]), np.eye(2)
    values, axes = np.linalg.eigh(np.trace(second) * np.eye(3) - second)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return float(sizes.sum()), centre, values, axes


def run(seed: int, most_in_space: int = MOST_IN_SPACE, end: float = 2.0) -> Outcome:
    """Build an assembly and run it."""
    assembly = Assembly(seed, most_in_space)
    world, d, count = assembly.world, assembly.d, round(end / STEP)
    ground, shift = assembly.ground(count), np.zeros((count, d))
    start = world.now()
    steps = start.followed_by(world.run(count, STEP, STEP / 4096, ground, shift))
    stored, exchanged = steps.stored.sum(axis=1), steps.exchanged
    scale = float(np.abs(steps.stored).sum(axis=1).max() + np.abs(np.diff(exchanged[:, 0])).sum())
    left = stored - exchanged[:, 0]
    gain = float(np.max(left - np.minimum.accumulate(left))) / scale
    ledger = float(np.abs(left + exchanged[:, 1:].sum(axis=1) - left[0]).max()) / scale
    # The overlap at the start of a step that goes nowhere is that at the end.
    world.reset_deepest()
    world.run(1, 1e-9, 1e-12, np.zeros((2, d)), np.zeros((1, d)))
    counts = world.counts()
    return Outcome(
        name=assembly.name,
        completed=len(steps.closed) == count + 1,
        gain=gain,
        ledger=ledger,
        overlap=counts["deepest"] / assembly.smallest,
        unsettled=int(counts["unsettled"]),
    )


def main(words: list[str]) -> int:
    """Run some assemblies from a seed on; 0 where all hold."""
    given = [*words, *("300", "0", str(MOST_IN_SPACE))[len(words) :]]
    count, first, most_in_space = (int(word) for word in given)
    outcomes = [run(seed, most_in_space) for seed in range(first, first + count)]
    for outcome in outcomes:
        if not outcome.holds or outcome.unsettled:
            sys.stdout.write(f"{outcome}\n")
    worst = {key: max(getattr(o, key) for o in outcomes) for key in ("gain", "ledger", "overlap")}
    sys.stdout.write(f"{sum(o.holds for o in outcomes)} of {count} hold; worst {worst}\n")
    return int(not all(o.holds for o in outcomes))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
