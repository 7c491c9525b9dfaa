"""What is seen of bodies: outlines without seams, edges that bend, surfaces of files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geometry.shapes import cylinder, polygon, prism, regular, turned, union
from geometry.skin import Skin, faces_of, skin_of, skin_of_parts
from rockslip import parse_scene
from solver.scene import Scene

L = [[0.0, 0.0], [0.8, 0.0], [0.8, 0.3], [0.3, 0.3], [0.3, 1.2], [0.0, 1.2]]

STATUE = Path(__file__).parents[2] / "demos" / "museum" / "statue.stl"


def lengths(skin: Skin) -> np.ndarray:
    """Of the edges, m."""
    return np.linalg.norm(skin.edges[:, 1] - skin.edges[:, 0], axis=1)


def bends(skin: Skin) -> np.ndarray:
    """Angles between the faces at the edges, rad."""
    cosines = np.einsum("mi,mi->m", skin.normals[:, 0], skin.normals[:, 1])
    return np.arccos(np.clip(cosines, -1.0, 1.0))


def sharp(skin: Skin, degrees: float = 28.0) -> np.ndarray:
    """Lengths of the edges at which faces bend, m."""
    return lengths(skin)[bends(skin) > np.radians(degrees)]


def scene_of(text: str, dimension: int = 3) -> Scene:
    """A rigid block with some keys."""
    keys = f"dimension = {dimension}\n[[block]]\nmodel = 'rigid'\ndensity = 2000.0\n{text}\n"
    return parse_scene(f"{keys}[time]\nend = 1.0\n")


def test_an_outline_in_the_plane_has_no_seams() -> None:
    """Two parts, and the sides of the polygon alone, each of them outwards."""
    solid = polygon(L, 1.0, 1.0)
    skin = skin_of_parts(solid.parts)
    assert len(solid.parts) > 1 and len(skin.faces) == len(solid.parts)
    ring = np.array(L)
    around = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum()
    assert lengths(skin).sum() == pytest.approx(around, rel=1e-12)
    along = skin.edges[:, 1] - skin.edges[:, 0]
    np.testing.assert_allclose(np.einsum("mi,mi->m", skin.normals[:, 0], along), 0, atol=1e-12)
    left = np.stack([-along[:, 1], along[:, 0]], axis=1)
    assert np.einsum("mi,mi->m", skin.normals[:, 0], left).max() < 0  # where the body is


def test_a_part_on_the_midst_of_another() -> None:
    """A post on a foot takes its width from the foot's top."""
    foot = polygon([[-0.5, 0], [0.5, 0], [0.5, 0.2], [-0.5, 0.2]], 1.0, 1.0)
    post = polygon([[-0.1, 0.2], [0.1, 0.2], [0.1, 1.5], [-0.1, 1.5]], 1.0, 1.0)
    skin = skin_of_parts(union([foot, post]).parts)
    assert lengths(skin).sum() == pytest.approx(2 * 1.2 + 2 * 1.5 - 2 * 0.2, rel=1e-12)
    inside = (np.abs(skin.edges[..., 1] - 0.2) < 1e-9) & (np.abs(skin.edges[..., 0]) < 0.09)
    assert not inside.any()


def test_a_prism_has_no_seams_in_its_faces() -> None:
    """The L in space: its outline twice, and an edge along y at each corner."""
    skin = skin_of_parts(prism(polygon(L, 1.0, 1.0), 0.4).parts)
    ring = np.array(L)
    around = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum()
    assert lengths(skin).sum() == pytest.approx(2 * around + 6 * 0.4, rel=1e-9)
    np.testing.assert_allclose(bends(skin), np.pi / 2, atol=1e-6)


def test_normals_of_a_hollow_edge() -> None:
    """At the inner corner of the L the faces look towards each other's side."""
    skin = skin_of_parts(prism(polygon(L, 1.0, 1.0), 0.4).parts)
    middle = skin.edges.mean(axis=1)
    inner = (np.abs(middle[:, [0, 2]] - 0.3) < 1e-9).all(axis=1)
    (normals,) = skin.normals[inner]
    found = sorted(tuple(row) for row in normals.round(9) + 0.0)
    assert found == [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)]


def test_round_shapes_are_round() -> None:
    """Only the rims of a cylinder bend; two equal ones on one another are one."""
    sides, radius = 48, 0.3
    rim = 2 * sides * radius * np.sin(np.pi / sides)
    one = cylinder(2 * radius, 0.5, sides, 1.0)
    assert sharp(skin_of_parts(one.parts)).sum() == pytest.approx(2 * rim)
    both = union([one, one.moved((0, 0, 0.5))])
    skin = skin_of_parts(both.parts)
    assert sharp(skin).sum() == pytest.approx(2 * rim)
    # their sides go on: no edge is level in the midst
    level = np.ptp(skin.edges[..., 2], axis=1) < 1e-9
    assert not (level & (np.abs(skin.edges[:, 0, 2] - 0.5) < 1e-9)).any()


def test_a_profile_keeps_its_rings() -> None:
    """At a re-entrant corner, where it is cut, both rings are one edge."""
    bottle = turned([[0, 0], [0.2, 0], [0.2, 0.5], [0.1, 0.5], [0.1, 1.0], [0, 1.0]], 24, 1.0)
    skin = skin_of_parts(bottle.parts)
    ring = 2 * 24 * np.sin(np.pi / 24)
    assert sharp(skin).sum() == pytest.approx(ring * (0.2 + 0.2 + 0.1 + 0.1), rel=1e-6)


def test_a_hexagon_keeps_its_edges() -> None:
    skin = skin_of_parts(prism(regular(6, 0.4, 1.0, 1.0), 0.3).parts)
    assert sharp(skin).sum() == pytest.approx(12 * 0.2 + 6 * 0.3)


def test_boxes_and_boxes_on_feet() -> None:
    size = "width = 1.0\nthickness = 0.5\nheight = 2.0\n"
    (block,) = scene_of(size).blocks
    assert len(skin_of(block.shape, 3).edges) == 12
    (flat,) = scene_of(size, 2).blocks
    assert lengths(skin_of(flat.shape, 2)).sum() == pytest.approx(6.0)
    feet = "feet = { inset = 0.0, size = 0.1, height = 0.2 }"
    (block,) = scene_of(size + feet).blocks
    skin = skin_of(block.shape, 3)
    # A foot is flush with two sides, and goes on where the corner of the box was.
    assert lengths(skin).sum() == pytest.approx(4 * 3.5 + 4 * (4 * 0.1 + 4 * 0.2))


def test_a_file_is_seen_as_it_is() -> None:
    """Its triangles, not its hull."""
    (block,) = scene_of(f"shape = {{ file = '{STATUE}' }}").blocks
    corners, faces = faces_of(block.shape, 3)
    solid = block.shape.solid
    assert solid is not None and solid.surface is not None
    assert len(faces) == len(solid.surface.triangles) == 3648
    skin = skin_of(block.shape, 3)
    assert len(skin.edges) == 3 * len(faces) // 2
    assert len(sharp(skin, 45.0)) < len(skin.edges) / 8
    np.testing.assert_allclose(corners[:, 2].min(), 0, atol=1e-9)
