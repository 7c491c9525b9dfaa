"""The ladder of time steps."""

import numpy as np
import pytest

from solver.scheme.step_control import Ladder, Tolerance


def run(ladder: Ladder, fails=lambda time, step: False) -> list[tuple[float, float]]:
    """(time, step) of every accepted step."""
    taken = []
    while not ladder.done:
        start, step = ladder.time, ladder.step
        if fails(start, step):
            assert ladder.reject()
            continue
        ladder.accept()
        assert ladder.time == pytest.approx(start + step, rel=1e-14)
        taken.append((ladder.time, step))
    return taken


def test_steps_without_failure_are_whole_and_gather_no_round_off():
    taken = run(Ladder(0.1, 100.0, 0.1 / 1024))
    times, steps = np.array(taken).T
    assert len(taken) == 1000 and set(steps) == {0.1}
    assert times == pytest.approx(0.1 * np.arange(1, 1001), rel=1e-15)
    assert times[-1] == 100.0


def test_the_end_is_reached_with_shorter_steps():
    """0.7 = 2 * 0.3 + 0.1 within a tick of the smallest step, 0.3/1024."""
    taken = run(Ladder(0.3, 0.7, 0.3 / 1024))
    assert [step for _, step in taken[:2]] == [0.3, 0.3]
    assert taken[-1][0] == pytest.approx(0.7, abs=0.3 / 2048)
    steps = [step for _, step in taken]
    assert steps == sorted(steps, reverse=True)


def test_a_failure_halves_and_the_grid_is_joined_again():
    """Fails around 0.35 with any step over 0.03: down to 0.1/4 at 0.3, one rung up at a time."""
    ladder = Ladder(0.1, 0.8, 0.1 / 64)
    taken = run(ladder, lambda time, step: 0.29 < time < 0.37 and step > 0.03)
    steps = {round(time - step, 10): step for time, step in taken}
    assert steps[0.2] == 0.1
    assert steps[0.3] == steps[0.325] == pytest.approx(0.025)
    assert steps[0.4] == steps[0.45] == pytest.approx(0.05)
    assert steps[0.5] == 0.1
    assert taken[-1][0] == pytest.approx(0.8)
    # After two failures four steps have to succeed before 0.05 is tried again.
    assert steps[0.35] == steps[0.375] == pytest.approx(0.025)
    assert ladder.rejected == 2


def test_steps_that_fail_again_and_again_are_tried_ever_less():
    """Every step above 0.03 fails: tried after 2, 4, 8, ... 64 of 0.025, not after every second."""
    ladder = Ladder(0.1, 100.0, 0.1 / 64)
    taken = run(ladder, lambda time, step: step > 0.03)
    assert {step for _, step in taken} == {0.025}
    assert 4000 / Ladder.LONGEST_WAIT < ladder.rejected < 4000 / Ladder.LONGEST_WAIT + 10


def test_a_longer_step_only_starts_on_its_own_grid():
    rng = np.random.default_rng(0)
    taken = run(Ladder(1.0, 500.0, 1 / 32), lambda time, step: rng.random() < 0.2 and step > 1 / 32)
    for time, step in taken:
        assert (time - step) / step == pytest.approx(round((time - step) / step), abs=1e-12)
    assert len({step for _, step in taken}) == 6


@pytest.mark.parametrize(("smallest", "halvings"), [(1.0, 0), (0.5, 1), (0.3, 1), (0.25, 2)])
def test_the_smallest_step_is_the_last_rung(smallest, halvings):
    ladder = Ladder(1.0, 10.0, smallest)
    for _ in range(halvings):
        assert ladder.reject()
    assert ladder.step == pytest.approx(0.5**halvings)
    assert not ladder.reject()
    assert ladder.time == 0.0


def test_a_smallest_step_above_the_step_allows_no_halving():
    ladder = Ladder(0.1, 1.0, 0.2)
    assert ladder.step == 0.1 and not ladder.reject()


def test_longer_steps_than_the_first_are_reached_by_climbing():
    ladder = Ladder(0.1, 10.0, 0.1 / 4, largest=0.4)
    assert ladder.step == 0.1
    taken = run(ladder)
    assert [step for _, step in taken[:4]] == pytest.approx([0.1, 0.1, 0.2, 0.4])
    assert taken[-1][0] == pytest.approx(10.0)


def test_largest_is_rounded_down_to_the_ladder():
    taken = run(Ladder(0.1, 10.0, 0.1, largest=0.35))
    assert max(step for _, step in taken) == pytest.approx(0.2)


def test_a_step_may_be_accepted_without_climbing():
    ladder = Ladder(0.1, 10.0, 0.1, largest=0.4)
    for _ in range(5):
        assert ladder.step == pytest.approx(0.1)
        ladder.accept(climb=False)


def test_steps_that_are_not_accurate_enough_are_halved_at_once_and_grow_again_at_once():
    ladder = Ladder(0.1, 10.0, 0.1 / 64)
    assert ladder.shorten(3)
    assert ladder.step == pytest.approx(0.1 / 8)
    ladder.accept()
    ladder.accept()
    assert ladder.step == pytest.approx(0.1 / 4)
    assert ladder.shorten(10), "down to the smallest"
    assert ladder.step == pytest.approx(0.1 / 64)
    assert not ladder.shorten()
    assert ladder.rejected == 3


def test_the_bound_on_rigid_motion_is_strict_where_contact_changes():
    tolerance = Tolerance(1e-3)
    strict = 1e-3 * Tolerance.CHANGE
    used = tolerance.used(rigid=strict, vibration=0.0, reversal=0.0, changed=True)
    assert used == pytest.approx(1.0)
    calm = tolerance.used(rigid=strict, vibration=0.0, reversal=0.0, changed=False)
    assert calm == pytest.approx(1.0 / Tolerance.CALM)


def test_vibration_is_judged_by_itself():
    tolerance = Tolerance(1e-3)
    most = 1e-3 * Tolerance.VIBRATION
    for changed in (False, True):
        used = tolerance.used(rigid=0.0, vibration=2 * most, reversal=0.0, changed=changed)
        assert used == pytest.approx(2.0)


def test_the_bound_on_vibration_is_lower_where_more_of_it_is_left_at_the_next_impact():
    """But for what lasts for many impacts: that cannot be followed."""
    error = 1e-3 * Tolerance.VIBRATION
    shares = [
        Tolerance(1e-3, left).used(rigid=0.0, vibration=error, reversal=0.0, changed=False)
        for left in (0.0, 0.2, 0.5, 1.0)
    ]
    assert shares == pytest.approx([1.0, 9.0, 21.0, 1.0])


def test_a_slip_that_turned_round_is_judged_as_a_change_of_contact():
    tolerance = Tolerance(1e-3)
    most = 1e-3 * Tolerance.CHANGE
    used = tolerance.used(rigid=0.0, vibration=0.0, reversal=2 * most, changed=False)
    assert used == pytest.approx(2.0)


def test_steps_grow_only_where_twice_the_step_would_pass():
    """The error grows with the cube of the step, and a little is kept in reserve."""
    tolerance = Tolerance(1e-3)
    most = 1 / (Tolerance.MARGIN * 2**3)
    assert tolerance.climbs(0.99 * most)
    assert not tolerance.climbs(1.01 * most)


def test_a_step_is_halved_as_often_as_its_error_asks_for():
    tolerance = Tolerance(1e-3)
    assert [tolerance.halvings(used) for used in (1.1, 7.0, 63.0, 65.0, 8.1**5)] == [1, 1, 1, 2, 5]
