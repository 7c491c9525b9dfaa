"""Best-fit rotations, lean and unwrapped angles, against scipy and numpy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solver.bodies.kinematics import lean, polar_rotation, unwrap


def positive(rng: np.random.Generator, size: int) -> np.ndarray:
    matrix = rng.standard_normal((size, size))
    return matrix @ matrix.T + 0.1 * np.eye(size)


@pytest.mark.parametrize("angle", [0.0, 0.3, -1.2, np.pi / 2, 3.0, -3.1])
def test_rotation_of_a_stretched_body_in_the_plane(angle):
    """M = R S, S symmetric and positive: the polar factor is R."""
    expected = Rotation.from_euler("z", angle).as_matrix()[:2, :2]
    for seed in range(5):
        stretch = positive(np.random.default_rng(seed), 2)
        found = polar_rotation(expected @ stretch)
        assert found == pytest.approx(expected, abs=1e-12)


def test_rotation_of_a_stretched_body_in_space():
    rng = np.random.default_rng(1)
    for expected in Rotation.random(20, random_state=4).as_matrix():
        assert polar_rotation(expected @ positive(rng, 3)) == pytest.approx(expected, abs=1e-12)


def test_best_fit_in_space_is_kabsch():
    """Also where the best orthogonal matrix would be a reflection, as for noisy points."""
    rng = np.random.default_rng(2)
    determinants = []
    for _ in range(30):
        reference, current = rng.standard_normal((2, 6, 3))
        moment = current.T @ reference
        determinants.append(np.linalg.det(moment))
        found = polar_rotation(moment)
        expected, _ = Rotation.align_vectors(current, reference)
        assert found == pytest.approx(expected.as_matrix(), abs=1e-9)
        assert np.linalg.det(found) == pytest.approx(1)
    assert min(determinants) < 0 < max(determinants)


def test_best_fit_in_the_plane_is_the_best_of_all_angles():
    rng = np.random.default_rng(3)
    angles = np.linspace(-np.pi, np.pi, 20001)
    for moment in rng.standard_normal((20, 2, 2)):
        fit = np.cos(angles) * np.trace(moment) + np.sin(angles) * (moment[1, 0] - moment[0, 1])
        found = polar_rotation(moment)
        assert np.sum(found * moment) >= fit.max()
        assert found @ found.T == pytest.approx(np.eye(2), abs=1e-14)
        assert np.linalg.det(found) == pytest.approx(1)


def test_lean_is_positive_towards_plus_x():
    """The top of a block, (0, 1), moves to (sin, cos) of its lean."""
    for angle in (-2.0, -0.1, 0.0, 0.05, 1.5, 3.0):
        rotation = polar_rotation(
            np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        )
        assert rotation @ (0, 1) == pytest.approx((np.sin(angle), np.cos(angle)))
        assert lean(rotation) == pytest.approx(angle, abs=1e-15)


def test_unwrap_follows_a_turning_block():
    true = np.cumsum(np.random.default_rng(5).uniform(-2.5, 3.1, 400))
    wrapped = np.angle(np.exp(1j * true))
    followed = [unwrap(wrapped[0], true[0])]
    for angle in wrapped[1:]:
        followed.append(unwrap(angle, followed[-1]))
    assert np.abs(true).max() > 4 * np.pi
    assert followed == pytest.approx(true, abs=1e-9)
    assert unwrap(0.1, 0.2) == 0.1
