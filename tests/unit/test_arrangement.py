"""Positions of blocks, and the plane that carries them."""

import math

import numpy as np
import pytest
from planes import TiltedPlane

from geometry.arrangement import (
    initial_position,
    pose_of_top,
)
from geometry.block import Block
from geometry.foundation import level_frame

SHAPE = Block(width=0.25, height=1.0, thickness=0.75, density=2680.0)
CORNERS = np.array([[-0.125, 0.0], [0.125, 0.0], [0.125, 1.0], [-0.125, 1.0]])


def test_upright_with_offset():
    np.testing.assert_allclose(
        initial_position(SHAPE, (0.1,), 0.0)(CORNERS), CORNERS + np.array([0.1, 0.0]), atol=1e-16
    )


def test_positive_tilt_leans_towards_x_about_the_right_corner():
    tilt = math.radians(3.0)
    left, right, _, top_left = initial_position(SHAPE, (0.0,), tilt)(CORNERS)
    assert SHAPE.pivot([1.0]) == (0.125, 0.0)
    np.testing.assert_allclose(right, [0.125, 0.0], atol=1e-16)
    np.testing.assert_allclose(
        left, [0.125 - 0.25 * math.cos(tilt), 0.25 * math.sin(tilt)], atol=1e-16
    )
    np.testing.assert_allclose(top_left - left, [math.sin(tilt), math.cos(tilt)], atol=1e-16)


@pytest.mark.parametrize("degrees", [0.5, 14.0, 60.0, 89.0])
def test_tilts_are_mirror_images_and_touch_the_ground(degrees):
    tilt = math.radians(degrees)
    towards = initial_position(SHAPE, (0.2,), tilt)(CORNERS)
    away = initial_position(SHAPE, (-0.2,), -tilt)(CORNERS * [-1, 1])
    np.testing.assert_allclose(towards, away * [-1, 1], atol=1e-15)
    gaps = TiltedPlane().gap(towards)
    assert gaps.min() == pytest.approx(0.0, abs=1e-16)
    edges = np.linalg.norm(np.diff(towards, axis=0), axis=1)
    np.testing.assert_allclose(edges, [0.25, 1.0, 0.25], rtol=1e-14)


@pytest.mark.parametrize("tilt", [math.pi / 2, -2.0, math.nan])
def test_refuses_lying_blocks(tilt):
    with pytest.raises(ValueError, match="tilt"):
        initial_position(SHAPE, (0.0,), tilt)


@pytest.mark.parametrize("tilt", [0.2, -0.2])
@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0, -90.0, 35.0, 200.0])
def test_blocks_in_space_lean_to_the_azimuth_over_their_lowest_point(degrees, tilt):
    azimuth = math.radians(degrees)
    corners = np.array(SHAPE.corners(3))
    pose = initial_position(SHAPE, (0.3, -0.2), tilt, azimuth)
    np.testing.assert_allclose(pose.rotation @ pose.rotation.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(pose.rotation) == pytest.approx(1.0)
    up = pose.rotation @ [0.0, 0.0, 1.0]
    towards = [math.cos(azimuth), math.sin(azimuth), 0.0]
    np.testing.assert_allclose(
        up, math.cos(tilt) * np.eye(3)[2] + math.sin(tilt) * np.array(towards), atol=1e-15
    )
    across = np.cross([0.0, 0.0, 1.0], towards)
    np.testing.assert_allclose(pose.rotation @ across, across, atol=1e-15)
    lean = np.sign(tilt) * np.where(np.abs(towards[:2]) < 1e-12, 0.0, towards[:2])
    point = np.array(SHAPE.pivot(lean))
    np.testing.assert_allclose(pose(point[None])[0] - point, [0.3, -0.2, 0.0], rtol=1e-14)
    levels = pose(corners)[:, 2]
    assert levels.min() == pytest.approx(0.0, abs=1e-15)
    along_an_axis = degrees % 90.0 == 0.0
    assert np.isclose(levels, 0.0, atol=1e-14).sum() == (2 if along_an_axis else 1)


def test_leaning_towards_x_in_space_is_that_of_the_plane():
    flat = initial_position(SHAPE, (0.1,), 0.2)(CORNERS)
    solid = initial_position(SHAPE, (0.1, 0.4), 0.2)(
        np.column_stack([CORNERS[:, 0], np.zeros(4), CORNERS[:, 1]])
    )
    np.testing.assert_allclose(solid[:, [0, 2]], flat, atol=1e-15)
    np.testing.assert_array_equal(solid[:, 1], 0.4)


def test_a_stack_turns_together():
    carrier = initial_position(SHAPE, (0.1,), 0.2)
    upper = Block(width=0.1, height=0.3, thickness=0.75, density=2000.0)
    on = pose_of_top(carrier, SHAPE.height).after(initial_position(upper, (0.05,), 0.0))
    middle = carrier(np.array([[0.05, 1.0]]))
    np.testing.assert_allclose(on(np.array([[0.0, 0.0]])), middle, atol=1e-15)
    np.testing.assert_allclose(on.rotation, carrier.rotation, atol=1e-15)
    # A tilt of its own adds: the upper block stands on its corner on the tilted top.
    leaning = pose_of_top(carrier, SHAPE.height).after(initial_position(upper, (0.05,), 0.1))
    assert math.atan2(leaning.rotation[0, 1], leaning.rotation[0, 0]) == pytest.approx(0.3)
    top = TiltedPlane(
        point=tuple(carrier(np.array([[0.0, 1.0]]))[0]), normal=tuple(carrier.rotation[:, 1])
    )
    gaps = top.gap(leaning(np.array(upper.corners())))
    np.testing.assert_allclose(gaps.min(), 0.0, atol=1e-15)
    assert (np.abs(gaps) < 1e-14).sum() == 1


def test_a_stack_in_space():
    carrier = initial_position(SHAPE, (0.0, 0.0), 0.2, 1.0)
    upper = Block(width=0.1, height=0.3, thickness=0.2, density=2000.0)
    third = pose_of_top(carrier, 1.0).after(initial_position(upper, (0.02, 0.03), 0.0))
    third = pose_of_top(third, 0.3).after(initial_position(upper, (0.01, 0.0), 0.0))
    np.testing.assert_allclose(
        third(np.array([[0.0, 0.0, 0.1]])), carrier(np.array([[0.03, 0.03, 1.4]])), atol=1e-15
    )


@pytest.mark.parametrize(
    "normal", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.36, -0.48, 0.8), (0.6, 0.0, -0.8)]
)
def test_frame_in_space(normal):
    plane = TiltedPlane(point=(1.0, 2.0, 3.0), normal=normal)
    n, t1, t2 = plane.frame
    np.testing.assert_allclose(plane.frame @ plane.frame.T, np.eye(3), atol=1e-15)
    np.testing.assert_array_equal(n, normal)
    if normal[2] > 0:  # right-handed, and t1, t2 are +x, +y turned as little as possible
        np.testing.assert_allclose(np.cross(t1, t2), n, atol=1e-15)
        np.testing.assert_allclose(
            np.array([t1, t2])[:, :2], np.array([t1, t2])[:, :2].T, atol=1e-15
        )
    assert plane.gap(
        np.array([[1.0, 2.0, 3.0], [1.0 + normal[0], 2.0 + normal[1], 3.0 + normal[2]]])
    ) == pytest.approx([0.0, 1.0])


def test_level_foundations():
    np.testing.assert_array_equal(TiltedPlane.level(2).frame, [[0, 1], [1, 0]])
    np.testing.assert_array_equal(TiltedPlane.level(3).frame, [[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    for dimension, up in [(2, 1.0), (2, -1.0), (3, 1.0), (3, -1.0)]:
        frame = TiltedPlane.level(dimension, up).frame
        np.testing.assert_array_equal(level_frame(dimension, up), frame)
    with pytest.raises(ValueError, match="two or three"):
        TiltedPlane(point=(0.0, 0.0), normal=(0.0, 0.0, 1.0))


def test_foundation():
    plane = TiltedPlane(point=(1.0, 2.0), normal=(0.6, 0.8))
    assert plane.tangent == (0.8, -0.6)
    points = np.array([[1.0, 2.0], [1.6, 2.8], [1.8, 1.4]])
    np.testing.assert_allclose(plane.gap(points), [0.0, 1.0, 0.0], atol=1e-15)
    assert TiltedPlane().tangent == (1.0, 0.0)
    with pytest.raises(ValueError, match="normal"):
        TiltedPlane(normal=(1.0, 1.0))
