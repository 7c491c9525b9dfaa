"""The narrow phase beside every separating axis, on random pairs of convex bodies.

Two convex bodies are apart by the largest distance along the normals of their faces and, in space,
the products of their edges (separating axes); the narrow phase has to find that distance, and a
feature that shows each overlap.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from solver.kernels.library import library
from solver.kernels.world import World
from solver.types import Array

MARGIN, INSET, ACCURACY = 1e-3, 1e-6, 1e-9
PAIRS = 1500
"""Of each kind in the plane, a third in space; 18750, which make 1e5 in all, pass too, in 100 s."""
CLOSEST = (0.0, 1e-12, 1e-9, 1e-8, 1e-7, 1e-5, 1e-3, 1e-2)
CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


@dataclass(frozen=True)
class Solid:
    """A convex body: vertices (n, d) and, in space, the loops of its faces."""

    vertices: Array
    loops: list[list[int]]

    def turned(self, turn: Array) -> Solid:
        """The same body, turned."""
        return Solid(self.vertices @ turn.T, self.loops)

    def normals(self) -> Array:
        """Normals of its faces, (faces, d)."""
        v = self.vertices
        if v.shape[1] == 2:
            side = np.roll(v, -1, 0) - v
            across = np.column_stack([side[:, 1], -side[:, 0]])
        else:
            across = np.array([np.cross(v[b] - v[a], v[c] - v[b]) for a, b, c, *_ in self.loops])
        return across / np.linalg.norm(across, axis=1)[:, None]

    def edges(self) -> Array:
        """Its edges in space, (edges, 3)."""
        ends = {
            (a, b)
            for loop in self.loops
            for a, b in zip(loop, loop[1:] + loop[:1], strict=True)
            if a < b
        }
        return np.array([self.vertices[b] - self.vertices[a] for a, b in sorted(ends)])


def axes(a: Solid, b: Solid) -> Array:
    """All directions along which two bodies may be parted, (axes, d)."""
    of_faces = np.vstack([a.normals(), b.normals()])
    if of_faces.shape[1] == 2:
        return of_faces
    across = np.cross(a.edges()[:, None], b.edges()[None]).reshape(-1, 3)
    length = np.linalg.norm(across, axis=1)
    keep = length > 1e-9
    return np.vstack([of_faces, across[keep] / length[keep, None]])


def distance(a: Array, b: Array, along: Array) -> float:
    """Largest distance of two sets of points along some axes; below 0 they overlap."""
    of_a, of_b = a @ along.T, b @ along.T
    return float(np.maximum(of_b.min(0) - of_a.max(0), of_a.min(0) - of_b.max(0)).max())


def some_polygon(random: np.random.Generator) -> Solid:
    """A box or a polygon of 3 to 8 corners."""
    if random.random() < 0.5:
        box = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
        return Solid(box * random.uniform(0.2, 1, 2), [])
    while True:
        angle = np.sort(random.uniform(0, 2 * np.pi, random.integers(3, 9)))
        gap = np.diff(np.append(angle, angle[0] + 2 * np.pi))
        if 0.05 < gap.min() and gap.max() < np.pi - 0.1:
            corners = np.column_stack([np.cos(angle), np.sin(angle)])
            return Solid(corners * [1, random.uniform(0.4, 1)], [])


def some_polyhedron(random: np.random.Generator) -> Solid:
    """A box or a polyhedron of 4 to 13 corners."""
    if random.random() < 0.6:
        return Solid(CORNERS * random.uniform(0.2, 1, 3), SIDES)
    corners = random.normal(size=(random.integers(4, 14), 3))
    corners *= random.uniform(0.3, 1, 3) / np.linalg.norm(corners, axis=1)[:, None]
    hull = ConvexHull(corners)
    loops = []
    for three, plane in zip(hull.simplices.tolist(), hull.equations, strict=True):
        a, b, c = corners[three]
        loops.append(three if np.cross(b - a, c - b) @ plane[:3] > 0 else three[::-1])
    return Solid(corners, loops)


def some_turn(random: np.random.Generator, d: int, size: float = np.inf) -> Array:
    """A rotation; a small one has about a size."""
    if size < np.inf:
        skew = random.normal(size=(d, d)) * size
        skew -= skew.T
        return np.linalg.solve(np.eye(d) - skew / 4, np.eye(d) + skew / 4)
    turn = np.linalg.qr(random.normal(size=(d, d)))[0]
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    return turn


def look(world: World, shapes: list[int], places: list[tuple[Array, Array]]) -> tuple[float, Array]:
    """Distance of two bodies by the narrow phase, and the gaps of its features."""
    numbers = np.concatenate([np.append(centre, turn) for centre, turn in places])
    apart, found = library().world_look(world._held, *shapes, numbers, MARGIN, INSET)
    return apart, np.frombuffer(found).reshape(-1, 4)[:, 1]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["any", "nearly parallel", "flush", "corner on corner"])
@pytest.mark.parametrize(("d", "some"), [(2, some_polygon), (3, some_polyhedron)])
def test_every_overlap_is_shown_and_no_other(
    d: int, some: Callable[[np.random.Generator], Solid], kind: str
) -> None:
    """Bodies placed within a hair of touching: the distance is right, and so are the features."""
    random = np.random.default_rng(48)
    world = World(d, np.zeros(d), (0.0, 0.5, 0.5), True)
    for _ in range(PAIRS if d == 2 else PAIRS // 3):
        bodies, turns = [some(random), some(random)], [some_turn(random, d), some_turn(random, d)]
        if kind == "flush":
            turns[1] = turns[0]
        if kind == "nearly parallel":
            turns[1] = some_turn(random, d, 10 ** -random.uniform(0, 12)) @ turns[0]
        a, b = (body.turned(turn) for body, turn in zip(bodies, turns, strict=True))
        along = axes(a, b)
        way, aside = random.normal(size=d), random.normal(size=d) * 0.3
        way /= np.linalg.norm(way)
        if kind == "corner on corner":
            one, other = random.choice(a.vertices), random.choice(b.vertices)
            place = one - other + way * 10 ** -random.uniform(4, 10)
        else:
            if kind != "any" and random.random() < 0.7:
                way = random.choice(a.normals())
            low, high = 0.0, 6.0
            for _ in range(60):
                middle = (low + high) / 2
                apart = distance(a.vertices, b.vertices + aside + middle * way, along)
                low, high = (low, middle) if apart > 0 else (middle, high)
            place = aside + (high + random.choice(CLOSEST) * random.choice([-1, 1])) * way
        true = distance(a.vertices, b.vertices + place, along)
        shapes = [
            world.polygon(body.vertices) if d == 2 else world.polyhedron(body.vertices, body.loops)
            for body in bodies
        ]
        found, gaps = look(world, shapes, list(zip([np.zeros(d), place], turns, strict=True)))
        least = gaps.min() if len(gaps) else np.inf
        if -0.05 < true < 0:
            assert found == pytest.approx(true, abs=ACCURACY)
            assert least < true + ACCURACY
        if true > 0:
            # Bodies that are apart are so along many axes, and the best of these need not be found.
            assert -ACCURACY < found <= true + ACCURACY or found > MARGIN
            assert least > -ACCURACY
        if true > ACCURACY:
            assert found > 0


@pytest.mark.parametrize(("d", "some"), [(2, some_polygon), (3, some_polyhedron)])
def test_all_corners_below_the_ground_are_shown(
    d: int, some: Callable[[np.random.Generator], Solid]
) -> None:
    """However deep they are: what has sunk in is held."""
    random = np.random.default_rng(49)
    world = World(d, np.zeros(d), (0.0, 0.5, 0.5), True)
    ground = world.half_space()
    for depth in (1e-12, 1e-7, 1e-3, 0.1):
        body, turn = some(random), some_turn(random, d)
        heights = body.turned(turn).vertices[:, -1]
        place = np.zeros(d)
        place[-1] = -heights.min() - depth
        shape = (
            world.polygon(body.vertices) if d == 2 else world.polyhedron(body.vertices, body.loops)
        )
        found, gaps = look(world, [shape, ground], [(place, turn), (np.zeros(d), np.eye(d))])
        assert found == pytest.approx(-depth, abs=ACCURACY)
        near = heights - heights.min() - depth
        np.testing.assert_allclose(np.sort(gaps), np.sort(near[near < MARGIN]), atol=ACCURACY)
