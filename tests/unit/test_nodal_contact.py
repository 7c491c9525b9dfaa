"""States of the nodes of a contact surface, by made-up points around them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from solver.fields.nodal_contact import NodeState, nodal_contact


def state_of(slipped: list[bool], pressed: list[bool] | None = None) -> float:
    """State of one node with four points of the same weight around it."""
    points: Any = SimpleNamespace(values_T=np.full((1, 4), 0.25), weight=np.ones(4))
    force = np.zeros((4, 2))
    force[:, 0] = 5.0 * np.array(pressed or [True] * 4)
    memory: Any = SimpleNamespace(
        force=force,
        slipped=np.array(slipped),
        may_touch=np.ones(4),
        kinematics=SimpleNamespace(frame=np.eye(2)[::-1]),
    )
    return float(nodal_contact(points, memory, 0.3).state[0])


@pytest.mark.parametrize(("slipping", "state"), [(0, 3), (1, 3), (2, 2), (3, 2), (4, 2)])
def test_a_node_slips_where_half_of_the_points_around_it_do(slipping: int, state: int) -> None:
    assert state_of([k < slipping for k in range(4)]) == state == NodeState(state)


def test_only_points_that_are_pressed_are_asked_whether_they_slip() -> None:
    pressed = [True, True, False, False]
    assert state_of([True, False, False, False], pressed) == NodeState.SLIPS
    assert state_of([False, False, True, True], pressed) == NodeState.STICKS
    assert state_of([True] * 4, [False] * 4) == NodeState.OPEN
