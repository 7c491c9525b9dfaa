"""The friction law by hand, and the velocity-level contact solve: law, energy, what it leaves."""

import numpy as np
import pytest

from solver.kernels import meshed
from solver.law.friction import (
    SLIPPED,
    TOUCHING_SLOPE,
    Bounds,
    FrictionLaw,
    slipping_points,
)
from solver.law.local_problem import LocalProblem, image
from solver.law.velocity import impulse_correction
from solver.scene import FrictionSpec


def mask(*values: int) -> np.ndarray:
    return np.array(values, dtype=bool)


def pasts(*rows: tuple[float, int, int]) -> np.ndarray:
    """Pasts of points: slip rate, slipped, broken."""
    return np.array(rows, dtype=float)


def test_the_coefficient_falls_from_static_to_dynamic_with_speed():
    law = FrictionLaw.of(FrictionSpec(static=0.6, dynamic=0.2, decay=3.0))
    speed = (0.0, np.log(2) / 3, np.log(4) / 3, 1e3)
    # the jump by memory has no say where there is a decay
    for slipped in (0, 1):
        bounds = law.bounds_by_past(pasts(*((v, slipped, 0) for v in speed)), np.ones(4))
        assert bounds.mu == pytest.approx([0.6, 0.4, 0.3, 0.2])


def test_without_decay_the_coefficient_jumps_where_a_point_slipped():
    law = FrictionLaw.of(FrictionSpec(static=0.6, dynamic=0.2))
    bounds = law.bounds_by_past(pasts((0.0, 0, 0), (5.0, 1, 0)), np.ones(2))
    assert bounds.mu.tolist() == [0.6, 0.2]
    smooth = FrictionLaw.of(FrictionSpec(static=0.5, dynamic=0.0, decay=2.0))
    bounds = smooth.bounds_by_past(pasts((0.5, 1, 1)), np.ones(1))
    assert bounds.mu == pytest.approx([0.5 * np.exp(-1)])


def test_cohesion_is_a_force_per_point_and_can_be_lost():
    area, past = np.array([0.1, 0.2]), pasts((0.0, 0, 0), (0.0, 0, 1))
    for lost, expected in ((False, [3e3, 6e3]), (True, [3e3, 0.0])):
        spec = FrictionSpec(static=0.5, cohesion=3e4, cohesion_lost=lost)
        bounds = FrictionLaw.of(spec).bounds_by_past(past, area)
        assert bounds.cohesion == pytest.approx(expected)


def test_what_the_bound_of_a_law_depends_on():
    assert FrictionSpec(static=0.4).constant
    for table in ({"dynamic": 0.3}, {"cohesion": 1.0}):
        assert not FrictionSpec(static=0.4, **table).constant
    assert FrictionSpec(static=0.5, dynamic=0.4, decay=2.0).decays
    assert FrictionSpec(static=0.5, dynamic=0.4).jumps
    assert FrictionSpec(static=0.5, cohesion=1.0, cohesion_lost=True).jumps
    assert not FrictionSpec(static=0.5, dynamic=0.4, decay=2.0).jumps
    assert not FrictionSpec(static=0.5, cohesion=1.0).jumps


def test_within_a_step_a_jump_only_falls_and_a_decay_follows_the_speed():
    tables = {"dynamic": 0.2}, {"dynamic": 0.2, "decay": 3.0}
    jump, decay = (FrictionLaw.of(FrictionSpec(static=0.6, **table)) for table in tables)
    points = np.zeros((3, 3)), np.ones(3), np.array([0.6, 0.6, 0.2])
    speed, slips = np.array([1.0, 1.0, 0.0]), mask(0, 1, 0)
    assert jump.bounds_followed(*points, speed, slips).mu.tolist() == [0.6, 0.2, 0.2]
    speed = np.array([np.log(2) / 3, np.log(2) / 3, 0.0])
    assert decay.bounds_followed(*points, speed, slips).mu == pytest.approx([0.4, 0.4, 0.6])


@pytest.mark.parametrize("decay", [0.0, 3.0])
def test_cohesion_that_is_lost_is_lost_in_the_step_in_which_a_point_slips(decay):
    """It acts on the areas of the points; the second one broke loose before, the third one now."""
    area, slips, past = (
        np.array([0.1, 0.2, 0.3]),
        mask(0, 0, 1),
        pasts(*[(0, 0, k) for k in (0, 1, 0)]),
    )
    for lost, expected in ((False, [1e3, 2e3, 3e3]), (True, [1e3, 0.0, 0.0])):
        spec = FrictionSpec(static=0.6, dynamic=0.2, decay=decay, cohesion=1e4, cohesion_lost=lost)
        law = FrictionLaw.of(spec)
        bounds = law.bounds_followed(past, area, np.full(3, 0.6), np.zeros(3), slips)
        assert bounds.cohesion == pytest.approx(expected)


def memory_after(
    force: np.ndarray, way: np.ndarray, own: np.ndarray, bounds: Bounds, before: np.ndarray
) -> np.ndarray:
    """Pasts of points after a step of 1 ms in which each slid a way, m; own: compliances, m/N."""
    still = np.zeros_like(force)
    y, anchor, past = still - own[:, None] * force, still[:, 1:].copy(), np.empty_like(before)
    y[:, 1] += way
    old = still, still, anchor.copy(), before
    meshed.after_step(force, y, *old, own, own, bounds.mu, bounds.cohesion, 1e-3, anchor, past)
    return past


def test_a_point_remembers_that_it_slipped_while_it_is_closed_and_for_ever_that_it_broke_loose():
    force, own = np.array([[1.0, 0.5], [1.0, 0.0], [0.0, 0.0]]), np.full(3, 1e-5)
    before = pasts((0.0, 0, 0), (0.3, 1, 1), (0.3, 1, 1))
    way = np.array([2e-4, 1e-4, 1e-4])
    after = memory_after(force, way, own, Bounds.uniform(0.5, 3), before)
    assert after == pytest.approx(pasts((0.2, 1, 1), (0.0, 0, 1), (0.0, 0, 1)))
    assert before[2].tolist() == [0.3, 1.0, 1.0]


def test_a_force_is_at_its_bound_up_to_round_off():
    force = np.array([[2.0, 1.2], [2.0, 1.2 * (1 - 1e-10)], [2.0, 1.19], [0.0, 0.0]])
    bounds = Bounds(np.full(4, 0.5), np.full(4, 0.2))
    found = slipping_points(force, np.full((4, 1), 1e-4), np.zeros(4), bounds)
    assert found.tolist() == [True, True, False, False]


@pytest.mark.parametrize("d", [2, 3])
def test_which_points_slip(d):
    """At the bound and moved; at the bound and not moved; moved below the bound; open.

    Their force of 2 N moves them by 6 m: what is less than a hundred thousandth of it is no slip.
    """
    force = np.zeros((4, d))
    force[:, 0], force[:, 1] = (2.0, 2.0, 2.0, 0.0), (-1.2, 1.2, 1.1, 0.0)
    bounds = Bounds(np.full(4, 0.5), np.full(4, 0.2))
    way, own = np.array([1e-4, 5e-5, 1e-4, 1e-4]), np.full(4, 3.0)
    slip = np.zeros((4, d - 1))
    slip[:, 0] = way
    assert slipping_points(force, slip, own, bounds).tolist() == [True, False, False, False]
    past = memory_after(force, way, own, bounds, np.zeros((4, 3)))
    assert past[:, SLIPPED].tolist() == [1.0, 0.0, 0.0, 0.0]


# ---------------------------------------------------------------- velocity level


def system(seed: int, points: int, d: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Velocities, G M^-1 G^T and impulses, half of them at the bound for mu = 0.5, c = 0.1."""
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((d * points, d * points + 2))
    W = (matrix @ matrix.T / (d * points)).reshape(points, d, points, d)
    impulse = np.abs(rng.standard_normal((points, d)))
    direction = rng.standard_normal((points, d - 1))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    share = np.where(rng.random(points) < 0.5, 1.0, rng.uniform(0, 0.9, points))
    impulse[:, 1:] = direction * (share * (0.5 * impulse[:, 0] + 0.1))[:, None]
    return 0.3 * rng.standard_normal((points, d)), W, impulse


@pytest.mark.parametrize("d", [2, 3])
def test_the_velocities_obey_the_law_and_energy_falls_by_what_is_booked(d):
    stuck = slid = followed = 0
    for seed in range(80):
        points = 1 + seed % 5
        velocity, W, impulse = system(seed, points, d)
        given = W.copy()
        bounds = Bounds(np.full(points, 0.5), np.full(points, 0.1))
        size = np.linalg.norm(impulse[:, 1:], axis=1)
        slipping = size >= (0.5 * impulse[:, 0] + 0.1) * (1 - 1e-9)
        mean = velocity - 0.5 * image(W, impulse)
        taken = max(-float((impulse * mean)[slipping, 1:].sum()), 0.0)
        correction = impulse_correction(LocalProblem(), velocity, W, impulse, bounds, taken)
        assert correction is not None
        assert np.array_equal(W, given)
        q, total, after = correction.q, impulse + correction.q, velocity + image(W, correction.q)
        assert total[:, 0].min() >= 0 and after[:, 0].min() > -1e-6
        assert np.abs(total[:, 0] * after[:, 0]).max() < 1e-6
        # W = G M^-1 G^T: the kinetic energy changes by q.v + q.W q/2
        change = float((q * velocity).sum() + 0.5 * (q * image(W, q)).sum())
        booked = correction.contact + correction.friction
        held = np.abs(q[:, 1:]).max(axis=1) == 0
        # Friction gives back no more than it took in the step.
        assert correction.friction >= -taken and correction.contact >= -1e-12
        assert change == pytest.approx(-booked, rel=1e-9, abs=1e-12)
        if held.all():
            continue
        # Points that slipped are at their bound, in the same direction, or, where that would add
        # energy, keep their friction; the others obey the law.
        if not held[slipping].all():
            followed += slipping.sum()
            ratio = (0.5 * total[:, 0] + 0.1) / size
            assert total[slipping, 1:] == pytest.approx((ratio[:, None] * impulse[:, 1:])[slipping])
        free = ~slipping & (total[:, 0] > 0.1 / TOUCHING_SLOPE)  # with all of their cohesion
        bound = 0.5 * total[:, 0] + 0.1
        inside = free & (np.linalg.norm(total[:, 1:], axis=1) < bound * (1 - 1e-6))
        assert np.abs(after[inside, 1:]).max(initial=0) < 1e-6
        against = np.sum(total[:, 1:] * after[:, 1:], axis=1)
        assert against[free].max(initial=-1) < 1e-6  # friction opposes what is left of the slip
        stuck, slid = stuck + inside.sum(), slid + (free & ~inside).sum()
    assert stuck >= 5 and slid >= 5 and followed >= 5


@pytest.mark.parametrize("d", [2, 3])
def test_a_mass_point_by_hand(d):
    """Mass 2: approaching at 3 and sliding at 0.4; all of it is taken, E = 2 (9 + .16)/2."""
    W = (np.eye(d) / 2).reshape(1, d, 1, d)
    velocity = np.array([[-3.0, 0.4, 0.0]])[:, :d]
    impulse = np.zeros((1, d))
    impulse[0, 0] = 1.0
    local = LocalProblem()
    correction = impulse_correction(local, velocity, W, impulse, Bounds.uniform(0.7, 1), 0.0)
    assert correction.q == pytest.approx(-2 * velocity, rel=1e-7)
    assert (correction.contact, correction.friction) == pytest.approx((9.0, 0.16), rel=1e-6)
    smooth = impulse_correction(local, velocity, W, impulse, Bounds.uniform(0.0, 1), 0.0)
    assert smooth.q == pytest.approx(np.array([[6.0, 0.0, 0.0]])[:, :d], rel=1e-7)
    assert (smooth.contact, smooth.friction) == pytest.approx((9.0, 0.0), rel=1e-6)


@pytest.mark.parametrize("speed", [0.5, 20.0])
@pytest.mark.parametrize("d", [2, 3])
def test_a_mass_point_that_lands_while_it_slides(d, speed):
    """Unit mass, 1 m/s down, mu = 0.1: the step took P_n = 2, half of it and of friction goes.

    Friction took 0.2 (speed - 0.1) in the step, and 0.1 (speed - 0.05) in the whole landing.
    """
    along = np.array([0.6, 0.8])[: d - 1] / (0.6 if d == 2 else 1.0)
    velocity = np.concatenate([[1.0], (speed - 0.2) * along])[None]
    impulse = np.concatenate([[2.0], -0.2 * along])[None]
    W = np.eye(d).reshape(1, d, 1, d)
    bounds, taken = Bounds.uniform(0.1, 1), 0.2 * (speed - 0.1)
    found = impulse_correction(LocalProblem(), velocity, W, impulse, bounds, taken)
    assert found.q == pytest.approx(-impulse / 2, rel=1e-6)
    returned = taken - 0.1 * (speed - 0.05)
    assert (found.contact, found.friction) == pytest.approx((0.5, -returned), rel=1e-6)


def test_cohesion_holds_what_friction_alone_does_not():
    """Unit mass, P_n = 1 that stays, 0.5 m/s of sliding: mu = 0.1 takes 0.1, c = 0.45 the rest."""
    W, velocity = np.eye(2).reshape(1, 2, 1, 2), np.array([[0.0, 0.5]])
    impulse = np.array([[1.0, 0.0]])
    local = LocalProblem()
    sliding = impulse_correction(local, velocity, W, impulse, Bounds.uniform(0.1, 1), 0.0)
    held = impulse_correction(
        local, velocity, W, impulse, Bounds(np.array([0.1]), np.array([0.45])), 0.0
    )
    assert sliding.q[0, 1] == pytest.approx(-0.1, rel=1e-6)
    assert held.q[0, 1] == pytest.approx(-0.5, rel=1e-6)


def test_no_closed_point_no_correction():
    local = LocalProblem()
    empty = np.zeros((0, 2))
    nothing = impulse_correction(
        local, empty, np.zeros((0, 2, 0, 2)), empty, Bounds.uniform(0.5, 0), 0.0
    )
    assert nothing is None and not local.fallbacks


def test_a_correction_that_would_add_energy_is_left_out():
    """W is that of no mass: a negative one, in the normal direction, which impulses speed up."""
    local = LocalProblem()
    velocity, W = np.array([[-1.0, 0.0]]), np.diag([-1.0, 1.0]).reshape(1, 2, 1, 2)
    impulse = np.array([[1.0, 0.0]])
    result = impulse_correction(local, velocity, W, impulse, Bounds.uniform(5.0, 1), 0.0)
    assert result is None
    assert local.fallbacks["velocity solve left out"] == 1
