"""Contact points of rigid blocks in the plane: gaps, rows, which points are near."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry.arrangement import initial_position
from geometry.block import Block
from solver.rigid.plane.contact import (
    area,
    change,
    compliance,
    distance,
    find_points,
    local_place,
    nearest_face,
    push,
    tangential_velocity,
    write_rows,
)
from solver.rigid.plane.model import (
    PlaneMemory,
    PlaneModel,
    PlaneState,
    PlaneWork,
    new_memory,
    new_work,
    state_of,
    system_of,
)
from solver.rigid.plane.step import definite_compliance
from solver.rigid.system import RigidBlock, RigidPlatform
from solver.scene import FrictionSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha

Array = NDArray[np.float64]


def parts(*, platform: bool = True) -> tuple[PlaneModel, PlaneState, PlaneMemory, PlaneWork]:
    """A block of 0.4 x 0.6 m with another one, 0.3 x 0.5 m, near its top."""
    law = FrictionSpec(static=0.5)
    lower = Block(width=0.4, height=0.6, thickness=1.0, density=1000.0)
    upper = Block(width=0.3, height=0.5, thickness=1.0, density=1000.0)
    blocks = [
        RigidBlock(name="lower", shape=lower, friction=law, pose=initial_position(lower, 0.0, 0.0)),
        RigidBlock(
            name="upper",
            on="lower",
            shape=upper,
            friction=law,
            pose=initial_position(upper, 0.05, 0.0),
        ),
    ]
    base = RigidPlatform(mass=100.0, stiffness=1e4) if platform else None
    scheme = GeneralizedAlpha(0.8)
    system, state = (
        system_of(blocks, base, np.array([0.0, -9.81]), scheme, True),
        state_of(blocks, base),
    )
    state.q[4] += 0.6
    points = len(system.corner_of)
    return system, state, new_memory(points), new_work(points, len(state.q), 2)


def listed(
    system: PlaneModel, state: PlaneState, memory: PlaneMemory, work: PlaneWork
) -> list[tuple[int, int]]:
    """Corner and face of the near points, as (block, block or -1)."""
    find_points(system, state, memory, work, 1e-3, 9.81)
    near = work.points[: work.counts[0]]
    return [(int(system.corner_of[k]), int(system.face_of[k])) for k in near]


@pytest.mark.parametrize("size", [1e-3, 0.3])
@pytest.mark.parametrize("face", range(4))
def test_rows_give_the_change_of_gap_and_place_exactly(face: int, size: float) -> None:
    """For large increments of both blocks and the platform, to round-off."""
    system, state, _, work = parts()
    random = np.random.default_rng(face)
    state.q[:] += 0.2 * random.normal(size=len(state.q))
    increment = size * random.normal(size=len(state.q))
    count = len(system.corner_of)
    work.counts[0], work.points[:], work.face[:] = count, np.arange(count), face
    work.face[system.face_of < 0] = 2
    write_rows(system, state.q, increment, work)
    moved = (work.rows @ increment).reshape(count, 2)
    for k in range(count):
        before, after = (
            places(system, state.q, k, face),
            places(system, state.q + increment, k, face),
        )
        assert moved[k] == pytest.approx(after - before, abs=1e-14)


def places(system: PlaneModel, q: Array, k: int, face: int) -> Array:
    """Gap and tangential place of a point, the tangent being the normal turned clockwise."""
    x, y = local_place(system, q, k)
    c = int(system.face_of[k])
    gap = distance(system, c, face, x, y)[0]
    if c < 0:
        return np.array([y, x - q[-1]])
    return np.array([gap, (-x, -y, x, y)[face]])


def test_forces_between_two_blocks_are_equal_and_opposite() -> None:
    """Rows push both alike, and the moments about any point cancel for small turns."""
    system, state, memory, work = parts()
    listed(system, state, memory, work)
    write_rows(system, state.q, np.zeros(len(state.q)), work)
    for i in range(work.counts[0]):
        if system.face_of[work.points[i]] < 0:
            continue
        for row in work.rows[2 * i : 2 * i + 2]:
            assert row[0] == -row[3] and row[1] == -row[4] and row[6] == 0.0
            # Clockwise moment about the origin: of the forces and of the couples.
            moments = [
                row[3 * b + 2] + state.q[3 * b + 1] * row[3 * b] - state.q[3 * b] * row[3 * b + 1]
                for b in (0, 1)
            ]
            assert sum(moments) == pytest.approx(0.0, abs=1e-15)


def test_velocity_along_a_face_is_that_of_the_rows() -> None:
    """Both come from their own formulas."""
    system, state, memory, work = parts()
    state.q[5] = 0.1
    state.q[4] += 0.02
    state.v[:] = np.random.default_rng(2).normal(size=len(state.v))
    listed(system, state, memory, work)
    write_rows(system, state.q, np.zeros(len(state.q)), work)
    for i in range(work.counts[0]):
        exact = work.rows[2 * i + 1] @ state.v
        assert tangential_velocity(system, state, work, i) == pytest.approx(exact, abs=1e-14)


def test_a_standing_stack_touches_with_its_corners() -> None:
    """The lower block's bottom corners on the floor, the upper one's on the top below."""
    assert listed(*parts()) == [(0, -1), (0, -1), (1, 0), (1, 0)]


def test_beyond_the_edge_the_corner_of_the_carrier_counts() -> None:
    """Moved out by 0.1 m: a corner of the upper block on the carrier, one of the carrier on it."""
    system, state, memory, work = parts()
    state.q[3] += 0.1
    assert listed(system, state, memory, work)[2:] == [(1, 0), (0, 1)]


def test_on_equal_outlines_a_corner_counts_once() -> None:
    """Not the carrier's corner in the same place besides."""
    system, state, memory, work = parts()
    state.q[3] = 0.05  # its right corner stands on the corner of the carrier
    assert listed(system, state, memory, work)[2:] == [(1, 0), (1, 0)]


def test_what_flies_away_is_not_near() -> None:
    """One that comes near within the step is."""
    system, state, memory, work = parts(platform=False)
    state.q[4] += 0.05
    assert listed(system, state, memory, work) == [(0, -1), (0, -1)]
    state.v[4] = -30.0
    assert len(listed(system, state, memory, work)) == 4


@pytest.mark.parametrize(
    ("place", "face"),
    [((0.0, 0.31), 2), ((0.21, 0.0), 1), ((-0.21, 0.0), 3), ((0.0, -0.31), 0), ((0.2, 0.3), 2)],
)
def test_nearest_face(place: tuple[float, float], face: int) -> None:
    """Bottom 0, right 1, top 2, left 3; at a corner the top."""
    system, *_ = parts()
    assert nearest_face(system, 0, *place) == face


def test_rows_act_on_two_bodies_only() -> None:
    """Changes, motions by forces and compliance are those of the whole rows."""
    system, state, memory, work = parts()
    random = np.random.default_rng(4)
    state.q[:] += 1e-3 * random.normal(size=len(state.q))
    listed(system, state, memory, work)
    write_rows(system, state.q, 1e-3 * random.normal(size=len(state.q)), work)
    count = 2 * work.counts[0]
    rows, flexibility = work.rows[:count], random.uniform(size=len(state.q))
    motion, force = random.normal(size=len(state.q)), random.normal(size=count)
    found = [change(system, work, row, motion) for row in range(count)]
    assert np.allclose(found, rows @ motion, rtol=0, atol=1e-14)
    pushed = motion.copy()
    push(system, work, force, flexibility, pushed)
    assert np.allclose(pushed, motion + flexibility * (rows.T @ force), rtol=0, atol=1e-14)
    W = compliance(system, work, flexibility)
    assert np.allclose(W, rows @ np.diag(flexibility) @ rows.T, rtol=0, atol=1e-14)


def test_compliance_of_two_sticking_corners_is_definite() -> None:
    """Four rows on three unknowns, made definite by a relative diagonal of 1e-9."""
    system, state, memory, work = parts(platform=False)
    assert listed(system, state, memory, work)[:2] == [(0, -1), (0, -1)]
    work.counts[0] = 2
    write_rows(system, state.q, np.zeros(len(state.q)), work)
    work.flexibility[:3] = 1.0, 1.0, 12.0
    W = definite_compliance(system, work)
    assert np.array_equal(W, W.T)
    assert np.linalg.eigvalsh(W)[0] > 1e-10
    rows = work.rows[:4]
    exact: Any = rows @ np.diag(work.flexibility) @ rows.T
    assert np.linalg.matrix_rank(exact) == 3
    assert np.abs(W - exact).max() < 2e-9 * np.abs(exact).max()
    assert math.isclose(W[0, 2], exact[0, 2])


@pytest.mark.parametrize(("lower", "upper"), [(0.2, 0.7), (0.7, 0.2)])
@pytest.mark.parametrize(("shift", "shared"), [(0.0, 0.3), (0.1, 0.2), (-0.3, 0.1)])
def test_cohesion_holds_the_face_that_both_blocks_share(
    lower: float, upper: float, shift: float, shared: float
) -> None:
    """Half of it at each corner; 0.3 m on 0.4 m of width, their middles 0.05 m + shift apart."""
    system, state, memory, work = parts(platform=False)
    system = system._replace(thickness=np.array([lower, upper]))
    state.q[3] += shift
    near = listed(system, state, memory, work)
    found = [area(system, work, state, i) for i, pair in enumerate(near) if set(pair) == {0, 1}]
    assert len(found) == 2
    assert found == pytest.approx([shared / 2 * 0.2] * 2)
    floor = [area(system, work, state, i) for i, pair in enumerate(near) if pair == (0, -1)]
    assert floor == pytest.approx([0.2 * lower] * 2)
