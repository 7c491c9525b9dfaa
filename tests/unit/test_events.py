"""Which changes of contact are events: what carries nothing shakes nothing."""

import numpy as np
import pytest

from solver.contact.kinematics import ContactKinematics
from solver.contact.memory import Memory, contact_changed
from solver.law.friction import PAST, SLIPPED


def memory(*points: tuple[float, float, bool]) -> Memory:
    """Points in the plane: normal force, friction, whether they slip."""
    force = np.array([point[:2] for point in points])
    slipped = np.array([point[2] for point in points])
    none, yes = np.zeros((len(points), 1)), np.ones(len(points), dtype=bool)
    kinematics = ContactKinematics(*np.zeros((2, len(points), 2)), np.eye(2))
    past = np.zeros((len(force), PAST))
    past[:, SLIPPED] = slipped
    bed = np.zeros(len(points))
    return Memory(None, kinematics, force, none, yes, past, bed)  # type: ignore[arg-type]


STICKS, SLIPS, OPEN = (10.0, 1.0, False), (10.0, 3.0, True), (0.0, 0.0, False)


@pytest.mark.parametrize(
    ("before", "after", "changed"),
    [
        (STICKS, (12.0, -1.0, False), False),
        (SLIPS, (12.0, 3.6, True), False),
        (OPEN, OPEN, False),
        (STICKS, OPEN, True),
        (OPEN, STICKS, True),
        (STICKS, SLIPS, True),
        (SLIPS, STICKS, True),
        (SLIPS, (10.0, -3.0, True), True),
    ],
)
def test_states(before, after, changed):
    """Of one point, and of one that another one beside it does not hide."""
    one, two = (memory(before), memory(after)), (memory(STICKS, before), memory(STICKS, after))
    still = memory(STICKS)
    for rigid in (False, True):
        assert contact_changed([one[0]], [one[1]], [rigid]) is changed
        assert contact_changed([still, one[0]], [still, one[1]], [True, rigid]) is changed
    assert contact_changed([two[0]], [two[1]], [False]) is changed


def test_friction_of_two_rigid_bodies_is_one():
    """Which of their points has reached its bound is chance, until all of them have."""
    none, some, every = memory(STICKS, STICKS), memory(STICKS, SLIPS), memory(SLIPS, SLIPS, OPEN)
    assert not contact_changed([none], [some], [True])
    assert contact_changed([none], [some], [False])
    assert contact_changed([memory(STICKS, SLIPS, OPEN)], [every], [True])
    assert not contact_changed([every], [every], [True])


def test_points_that_carry_next_to_nothing():
    light = memory(STICKS, OPEN)._replace(force=np.array([[10.0, 0.0], [1e-4, 0.0]]))
    assert not contact_changed([memory(STICKS, OPEN)], [light], [False])
    assert not contact_changed([light], [memory(STICKS, OPEN)], [False])
    alone = light._replace(force=light.force * [[0], [1]])
    assert contact_changed([memory(OPEN, OPEN)], [alone], [False])


def test_an_interface_that_grazes_shakes_nothing():
    """All of its force changes, but it is next to none beside that of the others."""
    heavy, open_, grazing = memory(STICKS), memory(OPEN), memory((1e-6, 0.0, False))
    assert not contact_changed([heavy, open_], [heavy, grazing], [False, False])
    assert contact_changed([heavy, open_], [heavy, memory((0.1, 0.0, False))], [False, False])
    assert contact_changed([open_], [grazing], [False])
