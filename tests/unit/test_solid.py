"""Bodies of convex parts: mass, centre and inertia against closed forms, and what is refused."""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as some
from numpy.typing import NDArray

from geometry.block import FACES, Block
from geometry.convex import Convex, hull_of
from geometry.overlap import descent
from geometry.shapes import (
    chord_error,
    cylinder,
    hull,
    of_surface,
    polygon,
    prism,
    regular,
    turned,
    union,
)
from geometry.solid import Solid
from geometry.surface import Surface

Array = NDArray[np.float64]

CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
"""Corners of a unit cube in the order of `geometry.block.FACES`."""
STEEL = 7850.0
"""A density, kg/m3."""


def rotation(seed: int, dimension: int = 3) -> Array:
    """A rotation by chance."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(dimension, dimension)))
    q[:, 0] *= np.linalg.det(q)
    return q


def tetrahedra_sum(apex: Array, triangles: Array) -> tuple[float, Array, Array]:
    """Volume, centre and inertia of tetrahedra between a point and triangles (m, 3, 3).

    By the quadrature with four points that is exact for quadratic functions, about the centre.
    """
    corners = np.concatenate([np.broadcast_to(apex, (len(triangles), 1, 3)), triangles], axis=1)
    sides = corners[:, 1:] - corners[:, :1]
    volumes = np.linalg.det(sides) / 6
    a, b = (5 + 3 * math.sqrt(5)) / 20, (5 - math.sqrt(5)) / 20
    points = np.einsum("qk,nki->nqi", np.full((4, 4), b) + (a - b) * np.eye(4), corners)
    points, weights = points.reshape(-1, 3), np.repeat(volumes / 4, 4)
    centre = weights @ points / weights.sum()
    arms = points - centre
    spread = (weights[:, None] * arms).T @ arms
    return float(weights.sum()), centre, np.trace(spread) * np.eye(3) - spread


def fan(part: Convex) -> Array:
    """The faces of a polyhedron as triangles about the middles of its faces, (m, 3, 3)."""
    found = []
    for face in part.faces:
        ring = part.corners[list(face)]
        middle = ring.mean(axis=0)
        found += [[middle, a, b] for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)]
    return np.array(found)


def assert_polyhedron(part: Convex) -> None:
    """Euler's formula; normals of all faces outwards; all corners below all faces; flat faces."""
    edges = {
        frozenset(pair)
        for face in part.faces
        for pair in zip(face, [*face[1:], face[0]], strict=True)
    }
    assert len(part.corners) - len(edges) + len(part.faces) == 2
    size = np.ptp(part.corners, axis=0).max()
    middle = part.corners.mean(axis=0)
    for face, normal in zip(part.faces, part.normals, strict=True):
        ring = part.corners[list(face)]
        # As the kernels do: by the first three corners (kernels/shape.hpp).
        first = np.cross(ring[1] - ring[0], ring[2] - ring[1])
        assert normal @ (ring[0] - middle) > 0
        assert first @ normal == pytest.approx(np.linalg.norm(first), rel=1e-6)
        assert np.abs((ring - ring[0]) @ normal).max() < 2e-6 * size
        assert ((part.corners - ring[0]) @ normal).max() < 2e-6 * size


# ------------------------------------------------------------------------- closed forms, plane


def test_a_rectangle_is_a_block() -> None:
    block = Block(width=0.4, height=1.1, thickness=0.3, density=2500.0)
    body = polygon(block.corners(), 2500.0, 0.3)
    assert body.mass == pytest.approx(block.mass, rel=1e-14)
    assert body.volume == pytest.approx(block.volume, rel=1e-14)
    assert body.centre == pytest.approx([0.0, 0.55], abs=1e-15)
    assert body.inertia == pytest.approx(block.rotary_inertia, rel=1e-14)
    assert body.parts[0].faces == ((0, 1), (1, 2), (2, 3), (3, 0))
    assert body.dimension == 2 and len(body.bottom) == 2


@pytest.mark.parametrize("sense", [1, -1])
def test_a_triangle(sense: int) -> None:
    """I = m (sum of squared sides) / 36 about the centroid."""
    corners = np.array([[0.1, 0.2], [1.3, 0.4], [0.5, 2.0]])
    body = polygon(corners[::sense], STEEL, 0.5)
    squares = sum(np.sum((corners[k] - corners[k - 1]) ** 2) for k in range(3))
    assert body.mass == pytest.approx(STEEL * 0.5 * 0.5 * (1.2 * 1.8 - 0.4 * 0.2), rel=1e-14)
    assert body.centre == pytest.approx(corners.mean(axis=0), rel=1e-14)
    assert body.inertia == pytest.approx(body.mass * squares / 36, rel=1e-13)


def test_a_trapezoid() -> None:
    """Sides a below and b above: the centre is at h (a + 2 b) / (3 (a + b))."""
    a, b, h = 2.0, 1.0, 1.5
    body = polygon([[0, 0], [a, 0], [1.3, h], [0.3, h]], 1.0, 1.0)
    assert body.mass == pytest.approx((a + b) / 2 * h, rel=1e-14)
    assert body.centre[1] == pytest.approx(h * (a + 2 * b) / (3 * (a + b)), rel=1e-14)


def test_an_angle_is_two_rectangles() -> None:
    """By Steiner's theorem, and the same as prisms in space."""
    body = polygon([[0, 0], [2, 0], [2, 1], [1, 1], [1, 3], [0, 3]], 1000.0, 0.5)
    first = 1000.0 * 0.5 * 2.0, np.array([1.0, 0.5]), (2**2 + 1**2) / 12
    second = 1000.0 * 0.5 * 2.0, np.array([0.5, 2.0]), (1**2 + 2**2) / 12
    mass = first[0] + second[0]
    centre = (first[0] * first[1] + second[0] * second[1]) / mass
    inertia = sum(m * (i + np.sum((c - centre) ** 2)) for m, c, i in (first, second))
    assert len(body.parts) == 2
    assert body.mass == pytest.approx(mass, rel=1e-14)
    assert body.centre == pytest.approx(centre, rel=1e-14)
    assert body.inertia == pytest.approx(inertia, rel=1e-14)
    in_space = prism(body, 0.5)
    assert in_space.mass == pytest.approx(mass, rel=1e-14)
    assert in_space.centre == pytest.approx([centre[0], 0.0, centre[1]], abs=1e-14)
    assert np.asarray(in_space.inertia)[1, 1] == pytest.approx(inertia, rel=1e-14)


@pytest.mark.parametrize("count", [3, 4, 5, 6, 8, 12, 101])
def test_a_regular_polygon(count: int) -> None:
    """Area n/2 R^2 sin(2 pi/n), inertia m R^2/6 (2 + cos(2 pi/n)); it stands on a side."""
    width = 0.6
    body = regular(count, width, 800.0, 0.2)
    angle, radius = 2 * math.pi / count, width / 2
    assert body.mass == pytest.approx(
        800 * 0.2 * count / 2 * radius**2 * math.sin(angle), rel=1e-13
    )
    assert body.inertia == pytest.approx(
        body.mass * radius**2 / 6 * (2 + math.cos(angle)), rel=1e-13
    )
    assert body.centre == pytest.approx([0.0, radius * math.cos(angle / 2)], abs=1e-15)
    assert len(body.bottom) == 2 and len(body.parts[0].corners) == count
    assert np.ptp(body.bottom[:, 0]) == pytest.approx(2 * radius * math.sin(angle / 2), rel=1e-13)


COMB = [[0, 0], [9, 0], [9, 3], [8, 3], [8, 1], [7, 1], [7, 3], [6, 3], [6, 1], [5, 1], [5, 3]]
COMB += [[4, 3], [4, 1], [3, 1], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]]
STAR = [
    [(1.0 - 0.6 * (k % 2)) * math.cos(0.2 * math.pi * k + 0.3), (1.0 - 0.6 * (k % 2))
     * math.sin(0.2 * math.pi * k + 0.3)] for k in range(10)
]  # fmt: skip


@pytest.mark.parametrize(
    ("points", "area", "pieces"),
    [
        (COMB, 19.0, 6),
        (STAR, 5 * 0.4 * math.sin(math.pi / 5), 5),  # a pentagon with four points, and one more
        ([[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]], 7.0, 3),
        ([[0, 0], [1, 0], [2, 0], [2, 1], [0, 1]], 2.0, 1),  # a straight corner is none
    ],
)
def test_few_convex_pieces(points: list[list[float]], area: float, pieces: int) -> None:
    body = polygon(points, 1.0, 1.0)
    assert body.volume == pytest.approx(area, rel=1e-13)
    assert len(body.parts) <= pieces


def outline_moments(corners: Array) -> tuple[float, Array, float]:
    """Area, centroid and polar moment about it by the textbook's sums over the outline."""
    (x, y), (u, v) = corners.T, np.roll(corners, -1, axis=0).T
    cross = x * v - u * y
    area = cross.sum() / 2
    centre = np.array([(cross * (x + u)).sum(), (cross * (y + v)).sum()]) / (6 * area)
    polar = (cross * (x * x + x * u + u * u + y * y + y * v + v * v)).sum() / 12
    return area, centre, polar - area * (centre @ centre)


radii = some.lists(some.floats(0.2, 1.0), min_size=4, max_size=40)


@settings(deadline=None, max_examples=60)
@given(radii=radii, seed=some.integers(0, 2**32 - 1))
def test_star_shaped_polygons(radii: list[float], seed: int) -> None:
    """Cut into parts that fill them: all moments as by sums over the outline."""
    gaps = np.random.default_rng(seed).uniform(0.5, 1.0, len(radii))
    angles = 2 * np.pi * np.cumsum(gaps) / gaps.sum()
    corners = np.array(radii)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    body = polygon(corners[:: 1 if seed % 2 else -1], 1.0, 1.0)
    area, centre, polar = outline_moments(corners)
    assert body.mass == pytest.approx(area, rel=1e-8)
    assert body.centre == pytest.approx(centre, abs=1e-8)
    assert body.inertia == pytest.approx(polar, rel=1e-8)
    reflex = len(corners) - len(hull(corners).parts[0].corners)
    assert len(body.parts) <= 2 * max(reflex, 0) + 1


# ------------------------------------------------------------------------- closed forms, space


def test_a_box_is_a_block() -> None:
    block = Block(width=0.4, height=1.1, thickness=0.3, density=2500.0)
    given_faces = Convex(corners=np.array(block.corners(3)), faces=FACES, density=2500.0)
    extruded = prism(polygon(block.corners(), 2500.0, 1.0), 0.3)
    for body in (Solid(parts=(given_faces,)), extruded, hull(block.corners(3), 2500.0)):
        assert body.mass == pytest.approx(block.mass, rel=1e-14)
        assert body.centre == pytest.approx([0.0, 0.0, 0.55], abs=1e-15)
        assert np.asarray(body.inertia) == pytest.approx(
            np.diag(block.principal_inertias), rel=1e-13, abs=1e-12
        )
        assert body.low == pytest.approx([-0.2, -0.15, 0.0])
        assert body.high == pytest.approx([0.2, 0.15, 1.1])
        assert len(body.bottom) == 4
        assert_polyhedron(body.parts[0])


def test_a_tetrahedron() -> None:
    """Corners at the origin and at 1 on the axes: I_xx = 3/80 m about the centre, I_xy = m/80."""
    body = hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], 6.0)
    assert body.mass == pytest.approx(1.0, rel=1e-14)
    assert body.centre == pytest.approx([0.25] * 3, rel=1e-14)
    expected = np.full((3, 3), 1 / 80) + np.eye(3) * (6 - 1) / 80
    assert np.asarray(body.inertia) == pytest.approx(expected, rel=1e-13)
    assert_polyhedron(body.parts[0])


@pytest.mark.parametrize("sides", [3, 8, 24, 100])
def test_a_cylinder_of_facets(sides: int) -> None:
    """A prism: I_zz = m R^2/6 (2 + cos(2 pi/n)), I_xx = I_yy = I_zz/2 + m h^2/12."""
    radius, height = 0.3, 0.9
    body = cylinder(2 * radius, height, sides, STEEL)
    angle = 2 * math.pi / sides
    area = sides / 2 * radius**2 * math.sin(angle)
    across = radius**2 / 6 * (2 + math.cos(angle))
    expected = np.diag([across / 2 + height**2 / 12] * 2 + [across]) * body.mass
    assert body.mass == pytest.approx(STEEL * area * height, rel=1e-13)
    assert body.centre == pytest.approx([0.0, 0.0, height / 2], abs=1e-15)
    assert np.asarray(body.inertia) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert len(body.bottom) == sides and len(body.parts[0].faces) == sides + 2
    assert body.parts[0].normals.max(axis=0)[0] == pytest.approx(1.0, abs=1e-15)
    assert chord_error(radius, sides) == pytest.approx(
        radius - radius * math.cos(angle / 2), abs=1e-15
    )
    assert_polyhedron(body.parts[0])


def test_a_round_shape_becomes_round() -> None:
    """Chord error R pi^2 / (2 n^2), and mass to that part."""
    body = cylinder(1.0, 1.0, 1000, 1.0)
    assert body.mass == pytest.approx(math.pi / 4, rel=7e-6)
    assert chord_error(0.5, 1000) == pytest.approx(0.5 * math.pi**2 / 2e6, rel=1e-5)


def frustum(lower: float, upper: float, height: float, sides: int) -> tuple[float, float]:
    """Volume and level of the centre of a frustum of a regular pyramid."""
    a, b = (sides / 2 * r**2 * math.sin(2 * math.pi / sides) for r in (lower, upper))
    volume = height / 3 * (a + b + math.sqrt(a * b))
    level = height / 4 * (a + 2 * math.sqrt(a * b) + 3 * b) / (a + math.sqrt(a * b) + b)
    return volume, level


@pytest.mark.parametrize(("lower", "upper"), [(0.5, 0.2), (0.2, 0.5), (0.5, 0.0), (0.0, 0.5)])
def test_a_cone_and_a_frustum(lower: float, upper: float) -> None:
    profile = [[0, 0], [lower, 0], [upper, 0.8], [0, 0.8]]
    profile = [point for k, point in enumerate(profile) if point not in profile[:k]]
    body = turned(profile, 16, 10.0)
    volume, level = frustum(lower, upper, 0.8, 16)
    assert body.mass == pytest.approx(10 * volume, rel=1e-13)
    assert body.centre == pytest.approx([0.0, 0.0, level], abs=1e-14)
    assert len(body.parts) == 1
    assert_polyhedron(body.parts[0])


@pytest.mark.parametrize("shift", range(8))
@pytest.mark.parametrize("sense", [1, -1])
def test_a_vase(shift: int, sense: int) -> None:
    """Convex below, a neck, a ledge outwards: three parts by two level cuts, wherever it begins."""
    profile = [[0, 0], [0.2, 0], [0.3, 0.4], [0.1, 0.6], [0.1, 0.8], [0.15, 0.8], [0.15, 0.9]]
    profile += [[0, 0.9]]
    body = turned(np.roll(profile, shift, axis=0)[::sense], 12, 1.0)
    rings = [(0.2, 0.3, 0.4), (0.3, 0.1, 0.2), (0.1, 0.1, 0.2), (0.15, 0.15, 0.1)]
    volumes, levels = np.transpose([frustum(*ring, 12) for ring in rings])
    levels = levels + np.array([0.0, 0.4, 0.6, 0.8])
    assert len(body.parts) == 3
    assert body.mass == pytest.approx(volumes.sum(), rel=1e-13)
    assert body.centre == pytest.approx([0, 0, volumes @ levels / volumes.sum()], abs=1e-14)
    for part in body.parts:
        assert_polyhedron(part)


def regular_area(radius: float, sides: int) -> float:
    """Area of a regular polygon."""
    return sides / 2 * radius**2 * math.sin(2 * math.pi / sides)


@pytest.mark.parametrize("sides", [3, 12, 1000])
@pytest.mark.parametrize("shift", range(4))
def test_a_hollow_cylinder(sides: int, shift: int) -> None:
    """m = rho h (A_R - A_r) of regular polygons, J = A R^2 (2 + cos(2 pi/n))/6 each; closed to
    contact."""
    outer, inner, height = 0.5, 0.4, 0.8
    ring = [[inner, 0], [outer, 0], [outer, height], [inner, height]]
    body = turned(np.roll(ring, shift, axis=0), sides, 10.0)
    areas = np.array([regular_area(radius, sides) for radius in (outer, inner)])
    polar = areas * np.array([outer, inner]) ** 2 / 6 * (2 + math.cos(2 * math.pi / sides))
    mass = 10 * height * (areas[0] - areas[1])
    about = 10 * height * (polar[0] - polar[1])
    across = about / 2 + mass * height**2 / 12
    assert body.mass == pytest.approx(mass, rel=1e-12)
    assert body.centre == pytest.approx([0, 0, height / 2], abs=1e-13)
    assert np.asarray(body.inertia) == pytest.approx(np.diag([across, across, about]), abs=1e-11)
    assert body.hull_excess == pytest.approx(areas[0] / (areas[0] - areas[1]) - 1, rel=1e-11)
    (part,) = body.parts
    assert_polyhedron(part)
    assert len(part.faces) == sides + 2 and not body.is_convex
    if sides == 1000:  # as good as round
        assert about == pytest.approx(mass * (outer**2 + inner**2) / 2, rel=2e-5)


def difference(outer: Solid, inner: Solid) -> tuple[float, Array, Array]:
    """Mass, centre and inertia about it of a body from which another is taken."""
    mass = outer.mass - inner.mass
    centre = (outer.mass * outer.centre - inner.mass * inner.centre) / mass
    inertia = np.zeros((3, 3))
    for sign, one in ((1, outer), (-1, inner)):
        arm = one.centre - centre
        own = one.inertia + one.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        inertia += sign * np.asarray(own)
    return mass, centre, inertia


VASE = [[0, 0], [0.2, 0], [0.3, 0.4], [0.1, 0.6], [0.1, 0.8], [0.15, 0.9]]
"""The outside of a vase with a neck and a flared rim."""
WITHIN = [[0.12, 0.9], [0.07, 0.8], [0.07, 0.6], [0.26, 0.4], [0.17, 0.03], [0, 0.03]]
"""Its inside, downwards."""


@pytest.mark.parametrize("sense", [1, -1])
def test_a_vase_with_a_wall(sense: int) -> None:
    """It weighs what is between both sides; contact has the outside, necks and all, and no more."""
    body = turned([*VASE, *WITHIN][::sense], 12, 3.0)
    outer, inner = turned([*VASE, [0, 0.9]], 12, 3.0), turned([[0, 0.9], *WITHIN], 12, 3.0)
    mass, centre, inertia = difference(outer, inner)
    assert body.mass == pytest.approx(mass, rel=1e-12)
    assert body.centre == pytest.approx(centre, abs=1e-12)
    assert np.asarray(body.inertia) == pytest.approx(inertia, rel=1e-10, abs=1e-13)
    assert body.hull_excess == pytest.approx(inner.mass / mass, rel=1e-10)
    assert len(body.parts) == len(outer.parts) == 3
    for part, other in zip(body.parts, outer.parts, strict=True):
        assert part.corners == pytest.approx(other.corners)
        assert_polyhedron(part)


def test_a_cavity_that_is_closed() -> None:
    outside = [[0, 0], [1, 0], [1, 2], [0, 2]]
    body = turned([*outside, [0, 1.5], [0.5, 1.5], [0.5, 0.5], [0, 0.5]], 24, 2.0)
    mass, centre, inertia = difference(
        turned(outside, 24, 2.0), cylinder(1.0, 1.0, 24, 2.0).moved([0, 0, 0.5])
    )
    assert body.mass == pytest.approx(mass, rel=1e-12)
    assert body.centre == pytest.approx(centre, abs=1e-12)
    assert np.asarray(body.inertia) == pytest.approx(inertia, abs=1e-11)
    assert body.is_convex is False and len(body.parts) == 1


def test_an_undercut_outside_is_filled_by_level() -> None:
    """A mushroom whose cap hangs down: the parts are a stem, and the cap with what it covers."""
    cap = [[0, 0], [0.1, 0], [0.1, 0.8], [0.3, 0.5], [0.4, 0.9], [0, 1.2]]
    body = turned(cap, 8, 1.0)
    filled = turned([[0, 0], [0.1, 0], [0.1, 0.5], [0.3, 0.5], [0.4, 0.9], [0, 1.2]], 8, 1.0)
    covered = turned([[0.1, 0.5], [0.3, 0.5], [0.1, 0.8]], 8, 1.0)
    assert body.mass == pytest.approx(filled.mass - covered.mass, rel=1e-12)
    assert body.parts_volume == pytest.approx(filled.volume, rel=1e-12)
    assert filled.surface is None and len(body.parts) == len(filled.parts) == 2


def test_a_ring_and_a_dish_with_one_point_on_the_axis() -> None:
    """By the theorems of Pappus for the circle, which many facets come to."""
    triangle = [[1.0, 0.0], [2.0, 0.0], [1.5, 1.0]]
    assert turned(triangle, 1000, 1.0).volume == pytest.approx(2 * math.pi * 1.5 * 0.5, rel=1e-5)
    dish = [[0.0, 0.5], [1.0, 0.0], [1.0, 1.0]]
    assert turned(dish, 1000, 1.0).volume == pytest.approx(2 * math.pi * (2 / 3) * 0.5, rel=1e-5)


def test_more_parts_and_edges_than_contacts_have_numbers_for() -> None:
    square = polygon([[0, 0], [1, 0], [1, 1], [0, 1]], 1.0, 1.0).parts
    with pytest.raises(ValueError, match="parts: got 513, allowed at most 512"):
        Solid(parts=square * 513)
    bulge = [[math.sin(a), 1 - math.cos(a)] for a in np.linspace(0, math.pi, 41)]
    bulge[0][0] = bulge[-1][0] = 0.0
    with pytest.raises(ValueError, match="got one of 79000 edges, allowed at most 65536"):
        turned(bulge, 1000, 1.0)


@settings(deadline=None, max_examples=40)
@given(count=some.integers(4, 60), seed=some.integers(0, 2**32 - 1))
def test_hulls_of_points(count: int, seed: int) -> None:
    """Against a sum over tetrahedra by quadrature; moved and turned by the laws of both."""
    chance = np.random.default_rng(seed)
    points = chance.normal(size=(count, 3)) * chance.uniform(0.1, 2.0, 3) + chance.normal(size=3)
    body = hull(points, 3.0)
    assume(body.volume > 1e-3)
    part = body.parts[0]
    assert_polyhedron(part)
    volume, centre, inertia = tetrahedra_sum(points.mean(axis=0), fan(part))
    scale = np.abs(inertia).max()
    assert body.mass == pytest.approx(3 * volume, rel=1e-12)
    assert body.centre == pytest.approx(centre, abs=1e-11)
    assert np.asarray(body.inertia) == pytest.approx(3 * inertia, abs=1e-11 * scale)
    turn, by = rotation(seed), chance.normal(size=3) * 10
    other = body.rotated(turn).moved(by)
    anew = Convex(corners=other.corners, faces=part.faces, density=3.0)
    fresh = Solid(parts=(anew,))  # checked and integrated again
    assert other.masses.spread == pytest.approx(fresh.masses.spread, abs=1e-9 * scale)
    assert other.centre == pytest.approx(fresh.centre, abs=1e-10)
    assert other.mass == pytest.approx(fresh.mass, rel=1e-11)
    assert other.centre == pytest.approx(turn @ body.centre + by, abs=1e-10)
    assert np.asarray(other.inertia) == pytest.approx(
        turn @ np.asarray(body.inertia) @ turn.T, abs=1e-9 * scale
    )


@settings(deadline=None, max_examples=40)
@given(count=some.integers(3, 40), seed=some.integers(0, 2**32 - 1))
def test_hulls_in_the_plane(count: int, seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(count, 2)) + 5.0
    body = hull(points, 2.0, 0.5)
    assume(body.volume > 1e-3)
    area, centre, polar = outline_moments(body.parts[0].corners - 5.0)
    assert body.mass == pytest.approx(area, rel=1e-12)
    assert body.centre == pytest.approx(centre + 5.0, abs=1e-12)
    assert body.inertia == pytest.approx(polar, rel=1e-10)


def test_far_from_the_origin_nothing_is_lost() -> None:
    near = cylinder(0.4, 1.0, 12, STEEL)
    moved = near.moved([1e4, -1e4, 1e4])
    part = Convex(corners=moved.corners, faces=near.parts[0].faces, density=STEEL)
    far = Solid(parts=(part,))  # integrated there
    assert np.asarray(far.inertia) == pytest.approx(np.asarray(near.inertia), rel=1e-9, abs=1e-8)


def test_coplanar_triangles_are_one_face() -> None:
    """A cube with points in the midst of its faces and edges, turned, in single precision."""
    grid = np.linspace(0, 1, 11)
    points = np.array([[x, y, z] for x in grid for y in grid for z in grid])
    exact = np.add(points @ rotation(7).T, [3.0, -2.0, 1.0])
    for cloud, tolerance in ((exact, 1e-9), (exact.astype(np.float32), 1e-6)):
        corners, faces = hull_of(cloud, tolerance)
        assert sorted(len(face) for face in faces) == [4] * 6
        assert len(corners) == 8
        part = Convex(corners=corners, faces=faces, density=1.0)
        assert_polyhedron(part)
        assert part.moments.volume == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("thin", [1e-2, 1e-4, 1e-6])
def test_thin_plates_keep_both_sides(thin: float) -> None:
    body = hull((CUBE * [1.0, 1.0, thin]) @ rotation(3).T)
    assert len(body.parts[0].faces) == 6
    assert body.volume == pytest.approx(thin, rel=1e-8)


# ------------------------------------------------------------------------------------- laws


def test_unions_add() -> None:
    """A heavy foot below a light column: mass, centre and inertia by Steiner's theorem."""
    foot = prism(polygon([[-0.5, 0], [0.5, 0], [0.5, 0.2], [-0.5, 0.2]], 7850.0, 1.0), 0.8)
    column = cylinder(0.4, 1.0, 16, 500.0).moved([0.1, 0.0, 0.2])
    body = union([foot, column])
    centre = (foot.mass * foot.centre + column.mass * column.centre) / (foot.mass + column.mass)
    inertia = np.zeros((3, 3))
    for one in (foot, column):
        arm = one.centre - centre
        inertia += one.inertia + one.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    assert body.mass == pytest.approx(foot.mass + column.mass, rel=1e-14)
    assert body.centre == pytest.approx(centre, rel=1e-13)
    assert np.asarray(body.inertia) == pytest.approx(inertia, rel=1e-13, abs=1e-10)
    assert len(body.parts) == 2 and body.hull_excess == 0
    assert {part.density for part in body.parts} == {7850.0, 500.0}


def test_mass_and_density_scale_all_parts() -> None:
    light = polygon([[0, 0], [1, 0], [1, 1], [0, 1]], 100.0, 0.5)
    body = union([light, light.with_mass(300.0 * light.volume).moved([1.0, 0.0])])
    assert body.mass == pytest.approx(200.0)
    heavy = body.with_mass(50.0)
    assert [part.density for part in heavy.parts] == pytest.approx([25.0, 75.0])
    assert heavy.inertia == pytest.approx(body.inertia / 4)
    assert heavy.centre == pytest.approx(body.centre)


def test_standing_on_feet() -> None:
    """Its bottom is what is lowest, not what is widest."""
    table = [[0, 1], [0, 0], [1, 0], [1, 1], [4, 1], [4, 0], [5, 0], [5, 1], [7, 2], [0, 2]]
    body = polygon(np.add(table, [3.0, 4.0]), 1.0, 1.0).standing()
    assert body.low == pytest.approx([-2.5, 0.0])
    assert body.high == pytest.approx([4.5, 2.0])
    assert body.bottom == pytest.approx(np.array([[-2.5, 0], [-1.5, 0], [1.5, 0], [2.5, 0]]))
    again = prism(body, 2.0).moved([1.0, 2.0, -3.0]).standing()
    assert again.low == pytest.approx([-2.5, -1.0, 0.0])
    tip = hull([[1, 1, 1], [2, 1, 2], [1, 2, 2], [0, 0, 3.0]]).standing()
    assert tip.bottom == pytest.approx(np.zeros((1, 3)))


# --------------------------------------------------------------------- bodies with a surface


def surface_of(body: Solid) -> Surface:
    """The skin of a body of one part."""
    faces = body.parts[0].faces
    fans = [(face[0], face[k - 1], face[k]) for face in faces for k in range(2, len(face))]
    return Surface(points=body.corners, triangles=np.array(fans))


def angle_surface() -> Surface:
    """The skin of an L-shaped body, 3 m3 in a hull of 3.5."""
    ring = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    front = np.column_stack([ring[:, 0], np.zeros(6), ring[:, 1]])
    flat = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    sides = [(k, k + 6, (k + 1) % 6) for k in range(6)]
    sides += [((k + 1) % 6, k + 6, (k + 1) % 6 + 6) for k in range(6)]
    back = [(a + 6, c + 6, b + 6) for a, b, c in flat]
    return Surface(
        points=np.concatenate([front, np.add(front, [0, 1, 0])]),
        triangles=np.array([*flat, *back, *sides]),
    )


def test_a_hull_around_a_surface() -> None:
    """Mass from the surface, corners from the hull; the excess is said."""
    body = of_surface(angle_surface(), 2.0)
    expected = prism(polygon([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], 2.0, 1.0), 1.0)
    expected = expected.moved([0.0, 0.5, 0.0])
    assert body.volume == pytest.approx(3.0) and body.mass == pytest.approx(6.0)
    assert body.centre == pytest.approx(expected.centre)
    assert np.asarray(body.inertia) == pytest.approx(np.asarray(expected.inertia), abs=1e-13)
    assert body.hull_excess == pytest.approx(3.5 / 3 - 1)
    assert len(body.parts[0].faces) == 7 and len(body.corners) == 10
    turn = rotation(4)
    other = body.with_mass(12.0).rotated(turn).standing()
    assert other.density == pytest.approx(4.0) and other.mass == pytest.approx(12.0)
    assert np.asarray(other.inertia) == pytest.approx(
        2 * turn @ np.asarray(body.inertia) @ turn.T, abs=1e-12
    )
    assert other.low[2] == pytest.approx(0.0, abs=1e-15)


def test_convex_parts_by_coacd(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only where they are asked for, and of surfaces that are not convex."""
    calls = []

    def run(mesh: SimpleNamespace, seed: int) -> list[tuple[Array, None]]:
        calls.append(len(mesh.triangles))
        low, beside = CUBE * [2, 1, 1], np.add(CUBE, [0, 0, 1])
        return [(low, None), (beside, None)]

    coacd = SimpleNamespace(
        set_log_level=lambda level: None,
        Mesh=lambda points, triangles: SimpleNamespace(triangles=triangles),
        run_coacd=run,
    )
    monkeypatch.setitem(sys.modules, "coacd", coacd)
    body = of_surface(angle_surface(), 2.0, "coacd")
    assert calls == [20] and len(body.parts) == 2
    assert body.hull_excess == pytest.approx(0.0, abs=1e-14)
    assert len(of_surface(surface_of(hull(CUBE)), 1.0, "coacd").parts) == 1
    assert len(of_surface(angle_surface(), 2.0).parts) == 1
    assert len(calls) == 1


def test_coacd_where_it_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """No other parts in its place: a scene means the same everywhere."""
    monkeypatch.setitem(sys.modules, "coacd", None)
    with pytest.raises(ValueError, match="not installed, allowed after `pip install coacd`"):
        of_surface(angle_surface(), 2.0, "coacd")
    assert len(of_surface(angle_surface(), 2.0).parts) == 1


def ellipsoid(around: int, dent: float) -> Surface:
    """A fine surface with a flat bottom of 2 m by 1.6 m, with waves where it is dented."""
    u = np.linspace(0, 2 * np.pi, around, endpoint=False)
    v = np.linspace(0, np.pi / 2, around // 4)[:-1]
    along, up = np.meshgrid(u, v)
    out = np.cos(up) * (1 + dent * np.cos(5 * along) * np.cos(up) ** 4)
    sides = np.stack([out * np.cos(along), 0.8 * out * np.sin(along), np.sin(up)], axis=2)
    points = np.vstack([sides.reshape(-1, 3), [[0, 0, 1], [0, 0, 0]]])
    a = np.arange(sides[..., 0].size).reshape(len(v), around)
    b, top, below = np.roll(a, -1, axis=1), len(points) - 2, len(points) - 1
    strips = [(a[:-1], b[:-1], a[1:]), (b[:-1], b[1:], a[1:])]
    strips += [(a[-1], b[-1], np.full(around, top)), (b[0], a[0], np.full(around, below))]
    triangles = [np.stack(strip, axis=-1).reshape(-1, 3) for strip in strips]
    return Surface(points=points, triangles=np.concatenate(triangles))


@pytest.mark.parametrize("dent", [0.0, 0.2])
def test_the_hull_of_a_fine_surface_is_coarse(dent: float) -> None:
    """Each corner of the exact hull is within what is said; base and mass stay as they are."""
    surface = ellipsoid(160, dent)
    body, exact = of_surface(surface, 2.0), hull(surface.points)
    size = body.size
    assert body.coarse == pytest.approx(1e-4 * size, rel=1e-3)
    assert len(body.corners) < 0.9 * len(exact.corners)
    normals, first = body.parts[0].normals, [face[0] for face in body.parts[0].faces]
    levels = np.sum(body.corners[first] * normals, axis=1)
    off = np.array([(normals @ corner - levels).max() for corner in exact.corners])
    assert 0.5 * body.coarse < off.max() <= body.coarse * (1 + 1e-6)
    assert body.mass == pytest.approx(2.0 * surface.volume, rel=1e-14)
    assert -1e-3 < body.hull_excess < 0 or dent
    # The bottom is one face, as far as it reached.
    low = body.bottom
    assert low[:, 2] == pytest.approx(np.zeros(len(low)), abs=0)
    assert body.parts[0].normals[body.parts[0].lowest_face] == pytest.approx([0, 0, -1])
    reach, known = np.ptp(low, axis=0)[:2], np.ptp(exact.bottom, axis=0)[:2]
    assert reach == pytest.approx(known, abs=2 * body.coarse)
    assert body.is_convex == (not dent)


def test_a_surface_of_few_points_keeps_all_corners() -> None:
    surface = ellipsoid(100, 0.0)
    body = of_surface(surface, 2.0)
    assert body.coarse == 0 and len(body.corners) == len(hull(surface.points).corners)


def test_unions_with_a_surface() -> None:
    """One density: the surfaces of all together. Two: refused, as one surface has one density."""
    statue = of_surface(angle_surface(), 2.0)
    plinth = prism(polygon([[0, -1], [2, -1], [2, 0], [0, 0]], 2.0, 1.0), 1.0).moved([0, 0.5, 0])
    body = union([statue, plinth])
    assert body.volume == pytest.approx(5.0) and body.mass == pytest.approx(10.0)
    assert len(body.parts) == 2
    assert body.hull_excess == pytest.approx(5.5 / 5 - 1)
    with pytest.raises(ValueError, match="densities from 2 to 3 kg/m3, allowed one where"):
        union([statue, plinth.with_mass(3.0 * plinth.volume)])


# ---------------------------------------------------------------------------------- refusals

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([[0, 0], [1, 1], [1, 0], [0, 1]], "sides 0 and 2 that cross or touch"),
        ([*SQUARE, [0, 0]], r"got \[0, 0\] as points 0 and 4, allowed each point once"),
        ([[0, 0], [1, 0], [1, 0], [0, 1]], "as points 1 and 2"),
        ([[0, 0], [1, 1], [2, 2], [3, 3]], "points on one line"),
        ([[0, 0], [1, 0]], "got 2 points, allowed 3 or more"),
        ([[0, 0], [2, 0], [1, 0], [1, 1]], "cross or touch|on one another"),
        ([[0, 0], [2, 0], [2, 2], [1, 0], [0, 2]], "cross or touch"),
        ([[0, 0], [4, 0], [4, 1], [2, 1], [2, 3], [2, 1.5], [0, 1]], "cross or touch|on one"),
        ([[0, 0], [1, math.nan], [1, 1]], r"got \[1, nan\] as point 1, allowed numbers"),
        ([[0, 0], [1, math.inf], [1, 1]], "inf"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0]], r"array \(3, 3\), allowed points \(n, 2\)"),
        ([[0, 0], [1], [1, 1]], "no table of numbers"),
        ("square", "no table of numbers"),
        (np.zeros((3000, 2)), "got 3000 points, allowed at most 2000"),
    ],
)
def test_no_polygon(points: list[list[float]], said: str) -> None:
    with pytest.raises(ValueError, match=said) as refused:
        polygon(points, 1.0, 1.0)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("profile", "said"),
    [
        ([[0, 0], [-0.2, 0], [-0.2, 1], [0, 1]], r"\[-0.2, \d\], allowed \[r, z\] with r >= 0"),
        ([[0, 0], [1, 0], [0, 1], [1, 2], [0, 2]], "cross or touch"),
        ([[0, 0], [0.2, math.nan], [0, 1]], "nan"),
        ([[0, 0], [0, 1]], "got 2 points"),
    ],
)
def test_no_profile(profile: list[list[float]], said: str) -> None:
    with pytest.raises(ValueError, match=rf"profile.*({said})"):
        turned(profile, 12, 1.0)


def square(**changes: object) -> Convex:
    """A square of one part, with changes."""
    ring = ((0, 1), (1, 2), (2, 3), (3, 0))
    return Convex(**{"corners": np.array(SQUARE), "faces": ring, "density": 1.0, **changes})  # type: ignore[arg-type]


def cube(**changes: object) -> Convex:
    """A cube of one part, with changes."""
    return Convex(**{"corners": CUBE, "faces": FACES, "density": 1.0, **changes})  # type: ignore[arg-type]


BENT = CUBE + 0.2 * np.outer(np.arange(8) == 6, [0.0, 0.0, 1.0])
TURNED = (FACES[0][::-1], *FACES[1:])


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: square(density=-1.0), "Convex.density: got -1.0, allowed a number > 0"),
        (lambda: square(corners=np.array(SQUARE)[::-1]), "m off the plane of a face"),
        (lambda: square(corners=[[0, 0], [1, 0], [0.1, 0.1], [0, 1]]), "m off the plane of a face"),
        (lambda: square(faces=((0, 1), (1, 2), (3, 0))), "allowed a closed body"),
        (lambda: square(corners=np.zeros((4, 2))), "one place"),
        (lambda: cube(corners=CUBE * np.nan), "nan"),
        (lambda: cube(faces=FACES[1:]), "allowed a closed body"),
        (lambda: cube(faces=TURNED), "allowed a closed body"),
        (lambda: cube(faces=tuple(f[::-1] for f in FACES)), "m off the plane of a face"),
        (lambda: cube(corners=BENT), "m off the plane of a face"),
        (lambda: cube(corners=[*CUBE, [0.5, 0.5, 0.5]]), "allowed a closed body"),
        (lambda: cube(faces=((0, 1, 2), *FACES)), "allowed a closed body"),
        (lambda: Solid(parts=()), "got none, allowed one or more"),
        (lambda: Solid(parts=(square(), cube())), "polygons and polyhedra"),
        (lambda: Solid(parts=(square(),), thickness=0.0), "Solid.thickness: got 0.0"),
        (lambda: Solid(parts=(square(),), density=1.0), "allowed None without a surface"),
        (lambda: Solid(parts=(cube(),), surface=angle_surface()), "Solid.density: got None"),
        (
            lambda: Solid(parts=(square(),), surface=angle_surface(), density=1.0),
            "allowed None in the plane",
        ),
        (lambda: regular(2, 1.0, 1.0, 1.0), "count: got 2, allowed a whole number from 3"),
        (lambda: regular(5, 0.0, 1.0, 1.0), "width: got 0.0"),
        (lambda: cylinder(1.0, 1.0, 2000, 1.0), "sides: got 2000"),
        (lambda: cylinder(1.0, math.nan, 20, 1.0), "height: got nan"),
        (lambda: cylinder(-1.0, 1.0, 20, 1.0), "diameter: got -1.0"),
        (lambda: chord_error(1.0, 2), "sides: got 2"),
        (lambda: prism(Solid(parts=(cube(),)), 1.0), "outline: got a solid in space"),
        (lambda: prism(Solid(parts=(square(),)), -1.0), "thickness: got -1.0"),
        (lambda: hull([[0, 0], [1, 1], [2, 2]]), "got 3 points, all in one line"),
        (lambda: hull([[0, 0, 1], [1, 1, 1], [2, 3, 1], [4, 0, 1]]), "4 points, all in one plane"),
        (lambda: hull([[0.0, 0, 0]] * 5), "all in one plane"),
        (lambda: hull([[0.0, 0, np.nan]] * 5), "nan"),
        (lambda: Solid(parts=(cube(),)).with_mass(0.0), "mass: got 0.0"),
        (lambda: Solid(parts=(cube(),)).rotated(np.diag([1, 1, -1])), "allowed a rotation matrix"),
        (lambda: union([]), "got no solids"),
        (lambda: union([Solid(parts=(cube(),)), Solid(parts=(square(),))]), "of the plane and of"),
        (
            lambda: union([polygon(SQUARE, 1.0, t) for t in (1.0, 2.0)]),
            r"thicknesses \[1.0, 2.0\] m, allowed one",
        ),
        (
            lambda: union([polygon(SQUARE, 1.0, 1.0), polygon(SQUARE, 1.0, 1.0).moved([0.9, 0])]),
            "overlap by 0.1 m at",
        ),
        (
            lambda: union([Solid(parts=(cube(),)), Solid(parts=(cube(),)).moved([0.5, 0.5, 0.75])]),
            "overlap by 0.25 m at",
        ),
    ],
)
def test_refused_in_one_line(make: object, said: str) -> None:
    assert callable(make)
    with pytest.raises(ValueError, match=said) as refused:
        make()
    assert "\n" not in str(refused.value) and len(str(refused.value)) <= 200


def test_a_body_goes_down_to_what_it_touches_first() -> None:
    """On a roof with a slope of 45 degrees: at its ridge, beside it, past it; not along a wall."""
    roof = polygon([[0.0, 0.0], [2.0, 0.0], [1.0, 1.0]], 1.0, 1.0).parts
    for middle, level in ((1.0, 1.0), (1.5, 0.7), (0.4, 0.6), (2.3, -np.inf), (2.2, -np.inf)):
        box = hull([[middle - 0.2, 3.0], [middle + 0.2, 3.0], [middle, 4.0]]).parts
        assert descent(box, roof) == pytest.approx(3.0 - level, abs=1e-9)
    low = hull([[1.2, -2.0], [1.6, -2.0], [1.4, -1.5]]).parts
    assert descent(low, roof) < 0
    stair = union(
        [
            polygon([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]], 1.0, 1.0),
            polygon([[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]], 1.0, 1.0),
        ]
    ).parts
    for left, level in ((1.0, 1.0), (0.9, 2.0), (1.8, 1.0)):
        box = hull([[left, 3.0], [left + 0.5, 3.0], [left + 0.5, 3.5], [left, 3.5]]).parts
        assert descent(box, stair) == pytest.approx(3.0 - level, abs=1e-9)
