"""What the row of a step says of one block among meshed bodies, from its points and its motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from solver.history.columns import positions
from solver.run.block_rows import touch, write_block

AT = positions("block", 2)


def touching(force: Any, gap: Any, may_touch: Any, level: float = 1e-9) -> list[int]:
    """Numbers of the points that touch."""
    points = np.column_stack([gap, np.zeros(len(gap))])
    mask = np.empty(len(gap), dtype=bool)
    count = touch(np.column_stack([force, np.zeros(len(gap))]), points, may_touch, level, mask)
    assert count == mask.sum()
    return list(np.flatnonzero(mask))


def test_closed_points_touch() -> None:
    everyone = np.ones(4, dtype=bool)
    assert touching([0.0, 2.0, 0.0, 1.0], [-1.0, 0.0, 0.0, 0.0], everyone) == [1, 3]


def test_where_none_is_closed_the_lowest_do_that_may() -> None:
    may_touch = np.array([False, True, True, True])
    assert touching([0.0] * 4, [0.1, 0.3, 0.2, 0.2 + 1e-10], may_touch) == [2, 3]


def row_of(home: Any, angles: Any, lean: float) -> tuple[bool, Any, Any]:
    """The row of a block of two points in the plane that leans; whether it is known, and slip."""
    row, slip = np.full(len(AT), np.nan), np.zeros(1)
    force = np.array([[10.0, 1.0], [30.0, -4.0], [0.0, 0.0]])
    place = np.array([[-1e-6, 0.10], [-2e-6, 0.22], [-1.0, 0.5]])
    c, s = np.cos(lean), np.sin(lean)
    known = write_block(
        row,
        force,
        place,
        np.ones(3, dtype=bool),
        np.array([True, True, False]),
        home,
        1e-9,
        np.array([0.01, -0.02]),
        np.array([0.1, 0.2]),
        np.array([0.3]),
        np.array([[c, s], [-s, c]]),
        5.0,
        np.array([0.5, 1.0]),
        np.array([2.0]),
        angles,
        slip,
        np.empty(3, dtype=bool),
    )
    return known, row, slip


def test_a_row_in_the_plane() -> None:
    """Slip is the mean over the closed points, depth that of points within the carrier's edges."""
    known, row, slip = row_of(np.array([[0.0], [0.1], [np.nan]]), np.zeros(1), 0.4)
    assert known
    assert row[AT.slip_m] == slip[0] == pytest.approx(0.11)
    assert row[AT.penetration_m] == 2e-6
    assert (row[AT.normal_force_N], row[AT.friction_force_N]) == (40.0, -3.0)
    assert row[AT.angle_rad] == pytest.approx(0.4)
    assert row[AT.angular_velocity_rad_s] == 0.3
    assert (row[AT.centre_x_m], row[AT.centre_y_m]) == pytest.approx((0.51, 0.98))
    assert np.isnan(row[[AT.gap_left_m, AT.gap_right_m]]).all()


def test_the_angle_is_carried_on_beyond_half_a_turn() -> None:
    angles = np.array([3.1])
    row_of(np.zeros((3, 1)), angles, 3.3)
    assert angles[0] == pytest.approx(3.3)


def test_a_home_that_is_not_known_is_asked_for() -> None:
    """Nothing is written then."""
    known, row, _ = row_of(np.array([[0.0], [np.nan], [0.0]]), np.zeros(1), 0.4)
    assert not known
    assert np.isnan(row).all()
