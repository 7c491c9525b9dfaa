"""Where blocks stand, and the plane that carries them."""

import math

import numpy as np
import pytest

from geometry.arrangement import initial_position, pivot
from geometry.block import Block
from geometry.foundation import RigidFoundation

SHAPE = Block(width=0.25, height=1.0, thickness=0.75, density=2680.0)
CORNERS = np.array([[-0.125, 0.0], [0.125, 0.0], [0.125, 1.0], [-0.125, 1.0]])


def test_upright_with_offset():
    np.testing.assert_allclose(
        initial_position(SHAPE, 0.1, 0.0)(CORNERS), CORNERS + np.array([0.1, 0.0]), atol=1e-16
    )


def test_positive_tilt_leans_towards_x_about_the_right_corner():
    tilt = math.radians(3.0)
    left, right, _, top_left = initial_position(SHAPE, 0.0, tilt)(CORNERS)
    assert pivot(SHAPE, tilt) == (0.125, 0.0)
    np.testing.assert_allclose(right, [0.125, 0.0], atol=1e-16)
    np.testing.assert_allclose(
        left, [0.125 - 0.25 * math.cos(tilt), 0.25 * math.sin(tilt)], atol=1e-16
    )
    np.testing.assert_allclose(top_left - left, [math.sin(tilt), math.cos(tilt)], atol=1e-16)


@pytest.mark.parametrize("degrees", [0.5, 14.0, 60.0, 89.0])
def test_tilts_are_mirror_images_and_touch_the_ground(degrees):
    tilt = math.radians(degrees)
    towards = initial_position(SHAPE, 0.2, tilt)(CORNERS)
    away = initial_position(SHAPE, -0.2, -tilt)(CORNERS * [-1, 1])
    np.testing.assert_allclose(towards, away * [-1, 1], atol=1e-15)
    gaps = RigidFoundation().gap(towards)
    assert gaps.min() == pytest.approx(0.0, abs=1e-16)
    edges = np.linalg.norm(np.diff(towards, axis=0), axis=1)
    np.testing.assert_allclose(edges, [0.25, 1.0, 0.25], rtol=1e-14)


@pytest.mark.parametrize("tilt", [math.pi / 2, -2.0, math.nan])
def test_refuses_lying_blocks(tilt):
    with pytest.raises(ValueError, match="tilt"):
        initial_position(SHAPE, 0.0, tilt)


def test_foundation():
    plane = RigidFoundation(point=(1.0, 2.0), normal=(0.6, 0.8))
    assert plane.tangent == (0.8, -0.6)
    points = np.array([[1.0, 2.0], [1.6, 2.8], [1.8, 1.4]])
    np.testing.assert_allclose(plane.gap(points), [0.0, 1.0, 0.0], atol=1e-15)
    assert RigidFoundation().tangent == (1.0, 0.0)
    with pytest.raises(ValueError, match="normal"):
        RigidFoundation(normal=(1.0, 1.0))
