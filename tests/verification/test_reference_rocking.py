"""The rocking block on ground and platforms: quadrature, momentum, energy, limits, the engine."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from geometry.block import Block
from rockslip import Scene, parse_scene, simulate
from solver.reference.answer import ROCKING_ON_PLATFORM, reference_history, reference_name
from solver.reference.housner import RockingReference, housner
from solver.scene.foundation import Platform
from solver.types import Array

G = 9.81
PAPER = Block(width=0.25, height=1.0, thickness=0.75, density=503.0 / 0.1875)
ALPHA = PAPER.slenderness()
TILT = math.radians(3.0)
SIZE = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "model": "rigid"}


def free(
    tilt: float, restitution: float | None = None, end: float = 2.2, step: float = 0.01
) -> RockingReference:
    """The paper's block on ground at rest."""
    return housner(PAPER, gravity=G, tilt=tilt, end=end, step=step, restitution=restitution)


def forced(acceleration: Callable[[float], float], end: float = 2.0) -> RockingReference:
    return housner(PAPER, gravity=G, end=end, step=2e-3, acceleration=acceleration)


def test_first_quarter_by_quadrature() -> None:
    # w^2 / 2 = p^2 (cos(alpha - theta) - cos(alpha - theta_0)); theta = theta_0 - x^2: no pole
    start = math.radians(3)

    def slowness(x: float) -> float:
        energy = PAPER.frequency(G) ** 2 * (
            math.cos(ALPHA - start + x**2) - math.cos(ALPHA - start)
        )
        return 2 * x / math.sqrt(2 * abs(energy))

    expected, _ = quad(slowness, 0, math.sqrt(start), epsabs=1e-12)
    assert free(start, end=0.3).impacts[0] == pytest.approx(expected, abs=1e-8)


def test_peaks_follow_from_the_energy_at_impacts() -> None:
    found = free(math.radians(3))
    e = PAPER.restitution()
    barrier = math.cos(ALPHA)
    energies = np.cos(ALPHA - np.abs(found.peaks)) - barrier
    np.testing.assert_allclose(energies[1:8] / energies[:7], e**2, rtol=1e-7)


def test_directions_are_mirror_images() -> None:
    one, other = free(math.radians(3)), free(-math.radians(3))
    np.testing.assert_allclose(one.angle, -other.angle, atol=1e-12)
    np.testing.assert_allclose(one.impacts, other.impacts, atol=1e-12)


def test_comes_to_rest() -> None:
    found = free(math.radians(0.5), restitution=0.5, end=3.0)
    assert found.angle[-1] == 0.0
    assert found.angular_velocity[-1] == 0.0
    assert 5 < len(found.impacts) < 60
    assert len(free(math.radians(3), restitution=0.0).impacts) == 1


def test_beyond_slenderness_it_overturns_and_stays() -> None:
    found = free(ALPHA + 0.01, end=4.0)
    assert found.overturned
    assert found.angle[-1] == pytest.approx(math.pi / 2)
    assert found.angular_velocity[-1] == 0.0
    assert not len(found.impacts)
    assert not free(ALPHA - 0.01, end=4.0).overturned


def test_uplift_needs_g_times_width_over_height() -> None:
    assert not forced(lambda time: 0.2499 * G).angle.any()
    pushed = forced(lambda time: 0.2501 * G if time < 0.3 else 0.0)
    # The ground goes to +x, so the block leans to -x.
    assert pushed.angle.min() < 0
    assert pushed.angle[:100].max() == 0


def test_initial_acceleration_after_shenton() -> None:
    a, b, h = 0.6 * G, 0.125, 0.5
    found = housner(PAPER, gravity=G, end=1e-3, step=1e-3, acceleration=lambda time: a)
    expected = 0.75 * (a * h - G * b) / (b**2 + h**2)
    assert -found.angular_velocity[-1] / 1e-3 == pytest.approx(expected, rel=1e-4)


def test_refuses() -> None:
    with pytest.raises(ValueError, match=r"restitution=1\.1"):
        free(0.1, restitution=1.1)
    with pytest.raises(ValueError, match="tilt"):
        free(2.0)


def test_constant_vertical_acceleration_is_more_gravity() -> None:
    """Yim, Chopra and Penzien: g becomes g + a_v, for the motion as for the uplift."""
    more = housner(PAPER, gravity=G, tilt=0.05, end=2.0, step=2e-3, vertical=lambda time: 0.3 * G)
    heavy = housner(PAPER, gravity=1.3 * G, tilt=0.05, end=2.0, step=2e-3)
    np.testing.assert_allclose(more.angle, heavy.angle, atol=1e-9)
    for push, lifts in ((0.324 * G, False), (0.326 * G, True)):
        found = housner(
            PAPER,
            gravity=G,
            end=0.5,
            step=2e-3,
            acceleration=lambda time, push=push: push,
            vertical=lambda time: 0.3 * G,
        )
        assert found.angle.any() == lifts


def test_vertical_harmonic_by_another_integration() -> None:
    """The first swing, by the classical Runge-Kutta method."""

    def heave(time: float) -> float:
        return 0.4 * G * math.sin(2 * math.pi * time / 0.13 + 0.4)

    def rate(time: float, state: Array) -> Array:
        pull = 3 / (4 * PAPER.half_diagonal) * (G + heave(time))
        return np.array([state[1], -pull * math.sin(ALPHA - state[0])])

    state, dt = np.array([math.radians(3), 0.0]), 1e-4
    for k in range(1500):
        t = k * dt
        a = rate(t, state)
        b = rate(t + dt / 2, state + dt / 2 * a)
        c = rate(t + dt / 2, state + dt / 2 * b)
        state = state + dt / 6 * (a + 2 * b + 2 * c + rate(t + dt, state + dt * c))
    found = housner(PAPER, gravity=G, tilt=math.radians(3), end=0.15, step=1e-3, vertical=heave)
    assert not len(found.impacts)
    assert found.angle[-1] == pytest.approx(state[0], abs=1e-10)
    assert found.angular_velocity[-1] == pytest.approx(state[1], abs=1e-9)


def platform(ratio: float, damping: float = 0.0, period: float = 0.5) -> Platform:
    """A platform; `ratio`: mass of the block over its own."""
    return Platform.on_spring(503.0 / ratio, period=period, stiffness=None, damping_ratio=damping)


def released(under: Platform, **options: Any) -> RockingReference:
    """The paper's block from 3 degrees."""
    given: dict[str, Any] = {"gravity": G, "tilt": TILT, "end": 2.0, "step": 1e-3} | options
    return housner(PAPER, platform=under, **given)


def arms(found: RockingReference) -> tuple[Array, Array]:
    """Displacement of the centre across and up per radian, m."""
    lean = PAPER.slenderness() - np.abs(found.angle)
    side = np.where(found.angle < 0, -1.0, 1.0)
    return PAPER.half_diagonal * np.cos(lean), side * PAPER.half_diagonal * np.sin(lean)


@pytest.mark.parametrize(("ratio", "known"), [(2.0, 0.8333), (0.5, 0.8846), (1e-9, 0.9118)])
def test_an_impact_by_momentum_alone(ratio: float, known: float) -> None:
    """Velocities and impulses at the new corner from Newton's and Euler's laws, as unknowns."""
    m, b, h = PAPER.mass, PAPER.width / 2, PAPER.height / 2
    own, base = m * (b * b + h * h) / 3, m / ratio
    # Unknown: v_x, v_y of the centre, w, V, impulses P_x, P_y on the block at (-b, -h). Before:
    # w = -1 about the corner at (b, -h), the platform still, so that v = w (h, b). A point at
    # (x, y) from the centre moves with v + w (y, -x).
    equations = np.array(
        [
            [m, 0, 0, 0, -1, 0],
            [0, m, 0, 0, 0, -1],
            [0, 0, own, 0, h, -b],
            [0, 0, 0, base, 1, 0],
            [1, 0, -h, -1, 0, 0],
            [0, 1, b, 0, 0, 0],
        ]
    )
    after = np.linalg.solve(equations, [-m * h, -m * b, -own, 0, 0, 0])
    assert -after[2] == pytest.approx(
        PAPER.restitution(0, PAPER.mass / (PAPER.mass + base)), rel=1e-12
    )
    assert -after[2] == pytest.approx(known, abs=5e-5)
    kappa = m / (m + base)
    assert after[3] == pytest.approx(-kappa * h * (after[2] + 1), rel=1e-9)


def test_a_heavy_platform_is_firm_ground() -> None:
    found = released(platform(1e-12))
    exact = housner(PAPER, gravity=G, tilt=TILT, end=2.0, step=1e-3)
    assert PAPER.restitution(0, PAPER.mass / (PAPER.mass + 1e15)) == pytest.approx(
        PAPER.restitution()
    )
    np.testing.assert_allclose(found.impacts[:7], exact.impacts[:7], rtol=1e-9)
    np.testing.assert_allclose(found.angle, exact.angle, atol=1e-9)


@pytest.mark.parametrize("restitution", [None, 0.9, 1.0])
@pytest.mark.parametrize("ratio", [2.0, 0.5])
def test_energy_is_lost_at_impacts_alone(ratio: float, restitution: float | None) -> None:
    """Without a dashpot; with e = 1 the energy still changes at none."""
    under = platform(ratio)
    found = released(under, restitution=restitution)
    across, _ = arms(found)
    m, turn, speed = PAPER.mass, found.angular_velocity, found.drift_velocity
    energy = PAPER.rotary_inertia_about_corner() * turn**2 / 2 + m * speed * across * turn
    energy += (m + under.mass) * speed**2 / 2 + under.stiffness * found.drift**2 / 2
    energy += m * G * PAPER.half_diagonal * np.cos(PAPER.slenderness() - np.abs(found.angle))
    change = np.diff(energy)
    rows = np.searchsorted(found.time, found.impacts) - 1
    smooth = np.delete(change, rows)
    assert np.abs(smooth).max() < 1e-9 * energy[0]
    if restitution == 1.0:
        assert np.abs(change).max() < 1e-9 * energy[0]
    else:
        assert change[rows][:5].max() < 0


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [None, 0.936])
def test_momentum_is_what_spring_and_dashpot_give(restitution: float | None) -> None:
    """Horizontally, impacts included: an independent integral of the forces."""
    under = platform(2.0, damping=0.05)
    found = released(under, restitution=restitution, step=2e-4)
    across, _ = arms(found)
    total = PAPER.mass + under.mass
    momentum = total * found.drift_velocity + PAPER.mass * across * found.angular_velocity
    force = -under.stiffness * found.drift - under.damping * found.drift_velocity
    gained = np.concatenate([[0.0], np.cumsum((force[1:] + force[:-1]) / 2 * 2e-4)])
    # the rule of trapezes over the kink of an impact: second order in the step
    np.testing.assert_allclose(momentum, gained, atol=2e-4 * np.abs(momentum).max())


def test_it_uplifts_where_the_platform_accelerates_enough() -> None:
    """Before, both are one oscillator; at that time |A| = (g + a_v) B/H, and it leans against A."""
    under = platform(1.0)

    def ground(time: float) -> float:
        return 0.2 * G * math.sin(2 * math.pi * time / 0.5)

    def heave(time: float) -> float:
        return 0.3 * G * math.sin(2 * math.pi * time / 0.15)

    found = released(under, tilt=0.0, acceleration=ground, vertical=heave)
    row = int(np.argmax(found.angle != 0))
    both = -under.stiffness * found.drift / (under.mass + PAPER.mass)
    limit = (G + np.array([heave(float(t)) for t in found.time])) / 4
    assert row > 10
    assert np.all(np.abs(both[:row]) < limit[:row])
    assert abs(both[row]) == pytest.approx(limit[row], rel=2e-2)
    assert found.angle[row] * both[row] < 0


def test_it_lies_down_with_the_platform() -> None:
    """Overturned it moves with the platform: an oscillator of both masses, its momentum kept."""
    under = platform(1.0, period=1.0)
    found = released(under, tilt=PAPER.slenderness() + 0.01, end=4.0)
    assert found.overturned
    lying = found.angular_velocity == 0
    lying[0] = False
    row = int(np.argmax(lying))
    assert lying[row:].all()
    total, before = PAPER.mass + under.mass, found.drift_velocity[row - 1]
    turn = PAPER.mass * PAPER.width / 2 * found.angular_velocity[row - 1]
    assert found.drift_velocity[row] == pytest.approx(before + turn / total, rel=2e-2)
    frequency = math.sqrt(under.stiffness / total)
    swing = found.drift[row:] + 1j * found.drift_velocity[row:] / frequency
    np.testing.assert_allclose(np.abs(swing), np.abs(swing[0]), rtol=1e-9)


def scene(ratio: float, block: dict[str, Any], **tables: Any) -> Scene:
    """The paper's block on an oscillator."""
    under = {"kind": "oscillator", "mass_ratio": ratio, "period": 0.5, "damping_ratio": 0.05}
    content = {
        "block": [SIZE | block],
        "contact": {"friction": 0.7},
        "foundation": under,
        "time": {"end": 1.2, "step": 2e-4},
    }
    return parse_scene(content | tables)


PUSH = {"kind": "sine", "amplitude_g": 0.2, "period": 0.6, "cycles": 2}
HEAVE = {"vertical": {"kind": "sine", "amplitude_g": 0.3, "period": 0.23, "cycles": 5}}


@pytest.mark.parametrize(
    ("ratio", "block", "tables"),
    [
        (2.0, {"tilt_deg": 3.0}, {}),
        (0.5, {"tilt_deg": -3.0}, {}),
        (2.0, {"tilt_deg": 3.0, "restitution": 0.936}, {}),
        (0.5, {"tilt_deg": 3.0, "restitution": 0.8}, {}),
        (0.5, {"offset": 0.2}, {"motion": PUSH}),
        (0.5, {}, {"motion": PUSH | HEAVE}),
        (0.5, {}, {"motion": PUSH, "gravity_tilt_deg": 2.0}),
    ],
)
def test_the_rigid_engine_does_the_same(
    ratio: float, block: dict[str, Any], tables: dict[str, Any]
) -> None:
    """Angles, drifts and energies, column by column."""
    asked = scene(ratio, block, **tables)
    assert reference_name(asked) == ROCKING_ON_PLATFORM
    result, exact = simulate(asked), reference_history(asked)
    history = result.history
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9
    assert np.abs(exact["block.angle_rad"]).max() > 5e-3
    assert np.abs(history["block.slip_m"]).max() < 1e-9
    close = {"block.angle_rad": 5e-6, "block.centre_x_m": 2e-6, "block.centre_y_m": 1e-6}
    for column, error in (close | {"platform.drift_m": 2e-6}).items():
        np.testing.assert_allclose(history[column], exact[column], atol=error, err_msg=column)
    scale = exact["energy.total_J"].max() - exact["energy.total_J"].min()
    for column in ("kinetic", "gravity", "spring", "input", "damping", "total"):
        name = f"energy.{column}_J"
        np.testing.assert_allclose(history[name], exact[name], atol=5e-4 * scale, err_msg=name)


def test_an_elastic_block_keeps_more() -> None:
    """With beta_R 1e-3 s about 0.88 instead of 0.833; the equations with that e are its motion."""
    tilted = {"tilt_deg": 3.0}
    under = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
    elastic = {key: value for key, value in SIZE.items() if key != "model"} | tilted
    content = {
        "block": [elastic | {"young": 5e10, "poisson": 0.2}],
        "contact": {"friction": 0.7},
        "damping": {"stiffness": 1e-3},
        "foundation": under,
        "time": {"end": 0.45},
        "output": {"fields": "none"},
    }
    block = simulate(parse_scene(content)).summary["blocks"]["block"]
    exact = housner(
        PAPER,
        platform=platform(2.0, damping=0.05),
        gravity=G,
        tilt=TILT,
        end=0.45,
        step=1e-3,
        restitution=0.879,
    )
    assert block["impacts"][0]["restitution"] == pytest.approx(0.873, abs=0.005)
    times = [impact["time_s"] for impact in block["impacts"][:3]]
    assert times == pytest.approx(exact.impacts[:3], rel=1e-3)
    peaks = [peak["angle_rad"] for peak in block["peaks"][1:3]]
    assert peaks == pytest.approx(np.abs(exact.peaks[1:3]), rel=1e-2)
