"""The rigid-body numbers of a block."""

import math

import numpy as np
import pytest

from geometry.block import Block

# Pena et al. (2007), specimens 1 to 3: B, H, t (m), mass (kg); alpha (rad), R (m), p (1/s), e
SPECIMENS = [
    (0.25, 1.0, 0.75, 503.0, 0.24498, 0.5154, 3.7783, 0.9118),
    (0.17, 1.0, 0.502, 228.0, 0.16839, 0.5072, 3.8088, 0.9579),
    (0.12, 1.0, 0.375, 120.0, 0.11943, 0.5036, 3.8223, 0.9787),
]


@pytest.mark.parametrize(
    ("width", "height", "thickness", "mass", "alpha", "R", "p", "e"), SPECIMENS
)
def test_specimens(width, height, thickness, mass, alpha, R, p, e):
    density = mass / (width * height * thickness)
    block = Block(width=width, height=height, thickness=thickness, density=density)
    assert block.mass == pytest.approx(mass, rel=1e-14)
    assert block.slenderness() == pytest.approx(alpha, abs=6e-6)
    assert block.half_diagonal == pytest.approx(R, abs=6e-5)
    assert block.frequency(9.81) == pytest.approx(p, abs=6e-5)
    assert block.restitution() == pytest.approx(e, abs=6e-5)
    assert block.weight(9.81) == pytest.approx(mass * 9.81)


def test_inertia_by_quadrature():
    block = Block(width=0.3, height=0.7, thickness=0.2, density=1500.0)
    points, weights = np.polynomial.legendre.leggauss(3)
    x, y = np.meshgrid(0.15 * points, 0.35 + 0.35 * points)
    w = np.outer(weights, weights) * 0.15 * 0.35 * 0.2 * 1500.0
    assert block.mass == pytest.approx(w.sum())
    assert block.rotary_inertia == pytest.approx(np.sum(w * (x**2 + (y - 0.35) ** 2)))
    about_corner = np.sum(w * ((x - 0.15) ** 2 + y**2))
    assert block.rotary_inertia_about_corner() == pytest.approx(about_corner)


def test_principal_inertias_by_quadrature():
    block = Block(width=0.3, height=0.7, thickness=0.2, density=1500.0)
    points, weights = np.polynomial.legendre.leggauss(2)
    half = np.array([0.15, 0.1, 0.35])
    grid = np.stack(np.meshgrid(*(h * points for h in half), indexing="ij"), axis=-1).reshape(-1, 3)
    weight = 1500.0 * half.prod() * np.einsum("i,j,k", weights, weights, weights).ravel()
    squares = weight @ grid**2
    np.testing.assert_allclose(block.principal_inertias, squares.sum() - squares, rtol=1e-14)
    assert block.principal_inertias[1] == pytest.approx(block.rotary_inertia)
    assert block.volume == pytest.approx(0.3 * 0.7 * 0.2)


def test_corners():
    block = Block(width=0.3, height=0.7, thickness=0.2, density=1500.0)
    flat, solid = np.array(block.corners()), np.array(block.corners(3))
    assert flat.tolist() == [[-0.15, 0.0], [0.15, 0.0], [0.15, 0.7], [-0.15, 0.7]]
    assert solid.shape == (8, 3) and len(np.unique(solid, axis=0)) == 8
    np.testing.assert_array_equal(solid.min(axis=0), [-0.15, -0.1, 0.0])
    np.testing.assert_array_equal(solid.max(axis=0), [0.15, 0.1, 0.7])
    assert np.all(solid[:4, 2] == 0.0)
    middle = [0.0, 0.0, 0.35]
    np.testing.assert_allclose(np.linalg.norm(solid - middle, axis=1), math.hypot(0.15, 0.1, 0.35))


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize("name", ["width", "height", "thickness", "density"])
def test_refuses(name, value):
    sizes = {"width": 1.0, "height": 1.0, "thickness": 1.0, "density": 1.0, name: value}
    with pytest.raises(ValueError, match=rf"Block.{name}: got {value}"):
        Block(**sizes)
