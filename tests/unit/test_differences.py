"""Differences of the motion over three steps, of which the error of a step is told."""

from __future__ import annotations

import numpy as np
import pytest

from solver.stepping.differences import third_differences


def test_motion_of_constant_jerk() -> None:
    """u = t^3 in steps of one length: its third difference, and for velocities 3 t^2 their jerk."""
    dt, jerk = 0.1, 6.0
    u = np.array([(k * dt) ** 3 for k in range(4)])
    mean = np.diff(u) / dt
    change = np.diff(mean) / dt
    rigid = np.array([3 * (k * dt) ** 2 for k in range(4)])
    found, rigid_change = np.empty((3, 1)), np.empty(1)
    largest = third_differences(
        u[3:],
        u[2:3],
        mean[1:2],
        change[:1],
        rigid[3:],
        rigid[2:3],
        np.diff(rigid)[1:2] / dt,
        dt,
        dt,
        dt,
        found,
        rigid_change,
    )
    assert found[:, 0] == pytest.approx([mean[2], change[1], jerk])
    assert largest == pytest.approx(jerk)
    assert rigid_change[0] == pytest.approx(np.diff(rigid)[2] / dt)
