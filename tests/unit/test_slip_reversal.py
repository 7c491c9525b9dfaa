"""Signs that a slip turned round within a step."""

from __future__ import annotations

import numpy as np
import pytest

from solver.kernels import meshed
from solver.stepping.impulses import largest_reversal
from solver.types import Array


def reversal(friction: Array, velocity: Array) -> float:
    """The slip reversal of points that are pressed, by their tangential parts, (m, d - 1)."""
    normal = np.ones((len(friction), 1))
    return meshed.slip_reversal(np.hstack([normal, friction]), np.hstack([normal, velocity]))


def test_friction_that_opposes_the_slip_at_the_end_is_no_reversal() -> None:
    friction = np.array([[-3.0], [-1.0]])
    assert reversal(friction, np.array([[0.2], [0.1]])) == 0.0
    assert reversal(friction, np.zeros((2, 1))) == 0.0
    assert reversal(np.zeros((0, 1)), np.zeros((0, 1))) == 0.0


def test_friction_that_drives_the_slip_gives_its_speed() -> None:
    """The mean over the friction; points that stick take part without a speed."""
    friction = np.array([[3.0], [1.0], [-4.0]])
    assert reversal(friction, np.array([[0.2], [0.2], [0.0]])) == pytest.approx(0.1)


def test_chatter_of_single_points_is_no_reversal() -> None:
    friction = np.array([[3.0], [1.0]])
    assert reversal(friction, np.array([[-0.2], [0.5]])) == 0.0


def test_in_space_it_is_the_part_along_friction_that_counts() -> None:
    friction = np.array([[3.0, 4.0]])
    assert reversal(friction, np.array([[0.8, -0.6]])) == pytest.approx(0.0, abs=1e-15)
    assert reversal(friction, np.array([[0.6, 0.8]])) == pytest.approx(1.0)


def test_of_several_interfaces_the_largest_counts() -> None:
    """Points 1 of the first, 3 and 4 of the third; the second has none that is closed."""
    closed, first = np.array([1, 3, 4]), np.array([0, 2, 3, 6])
    force, velocity = np.zeros((3, 2)), np.zeros((3, 2))
    force[:, 1], velocity[:, 1] = [2.0, 1.0, 1.0], [0.1, 0.4, 0.2]
    assert largest_reversal(closed, first, force, velocity) == pytest.approx(0.3)
