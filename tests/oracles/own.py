"""Small independent programs: rigid blocks that rock or slide, by scipy's integrators and events.

They share no line with the program, and stand on the equations in docs/reference.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

G = 9.81
Acceleration = Callable[[float], float]
EXACT = {"rtol": 1e-10, "atol": 1e-13, "max_step": 2e-3}


def still(time: float) -> float:
    return 0.0


def sine(amplitude_g: float, period: float, cycles: float = math.inf) -> Acceleration:
    """Sine, one sine (1 cycle) and half sine (half a cycle), m/s2."""
    end = cycles * period
    return lambda t: amplitude_g * G * math.sin(2 * math.pi * t / period) if t < end else 0.0


def rectangle(amplitude_g: float, duration: float) -> Acceleration:
    return lambda t: amplitude_g * G if t < duration else 0.0


def ricker(amplitude_g: float, frequency: float) -> Acceleration:
    """Ricker's wavelet from 0 to 3/f."""

    def acceleration(t: float) -> float:
        x = (math.pi * frequency * (t - 1.5 / frequency)) ** 2
        return amplitude_g * G * (1 - 2 * x) * math.exp(-x) if t < 3 / frequency else 0.0

    return acceleration


def sampled(times: Any, values: Any) -> Acceleration:
    """Straight between samples (m/s2), zero before and after."""
    return lambda t: float(np.interp(t, times, values, left=0.0, right=0.0))


def event(function: Callable[..., float], direction: float, *, ends: bool = True) -> Any:
    """A function whose zero ends a phase of `solve_ivp`, passed upwards or downwards."""
    function.direction, function.terminal = direction, ends  # type: ignore[attr-defined]
    return function


@dataclass
class Answer:
    """Answer of an independent program; angles and slips with their signs."""

    impacts: list[float] = field(default_factory=list)
    peaks: list[float] = field(default_factory=list)
    overturned: float = math.inf
    """Time at which it passes 2 alpha, s."""
    slip: float = 0.0
    peak_slip: float = 0.0
    drift: float = 0.0
    shear: float = 0.0
    """Largest force of spring and dashpot over the platform's mass, m/s2."""


def slenderness(width: float, height: float) -> float:
    return math.atan(width / height)


def frequency(width: float, height: float) -> float:
    """p of Housner's block, 1/s."""
    return math.sqrt(3 * G / (2 * math.hypot(width, height)))


def housner(width: float, height: float) -> float:
    """Restitution of a plastic impact, 1 - 3/2 sin2 alpha."""
    return 1 - 1.5 * math.sin(slenderness(width, height)) ** 2


def on_platform(width: float, height: float, kappa: float) -> float:
    """Restitution on a platform that is free to move; kappa = m/(m + M)."""
    b2, h2 = width**2 / 4, height**2 / 4
    return (h2 * (4 / 3 - kappa) - b2 * 2 / 3) / (h2 * (4 / 3 - kappa) + b2 * 4 / 3)


def quarter(width: float, height: float, tilt: float) -> float:
    """First impact of a block released from a tilt (rad), by the integral of its energy."""
    p, alpha = frequency(width, height), slenderness(width, height)

    def slope(x: float) -> float:  # theta = tilt (1 - x2) takes the root out of the integrand
        theta = tilt * (1 - x * x)
        return 2 * tilt * x / math.sqrt(2 * (math.cos(alpha - tilt) - math.cos(alpha - theta)))

    points, weights = np.polynomial.legendre.leggauss(200)
    total = sum(w * slope((x + 1) / 2) / 2 for x, w in zip(points, weights, strict=True))
    return total / p if math.isfinite(total) else math.nan


def rocking(
    width: float,
    height: float,
    end: float,
    *,
    tilt_deg: float = 0.0,
    spin: float = 0.0,
    e: float | None = None,
    ground: Acceleration = still,
    vertical: Acceleration = still,
    slope_deg: float = 0.0,
    gravity: float = G,
    drag: float = 0.0,
    platform: tuple[float, float, float] | None = None,
) -> Answer:
    """Rocking without slip (Housner 1963), on ground or on a platform (mass ratio, T, xi).

    From rest it begins when the ground passes B/H; on platforms it begins tilted. `drag` is mass-
    proportional damping lambda_R, 1/s, of which angles and velocities against the ground die.
    """
    alpha, half = slenderness(width, height), math.hypot(width, height) / 2
    b = math.radians(slope_deg)
    ratio, period, xi = platform or (0.0, 1.0, 0.0)
    omega = 2 * math.pi / period
    kappa = ratio / (1 + ratio)
    if e is None:
        e = on_platform(width, height, kappa) if platform else housner(width, height)

    def rates(t: float, y: Any, side: float) -> list[float]:
        theta, rate, drift, velocity = y
        phi = alpha - side * theta
        down = gravity * math.cos(b) + vertical(t)
        along = ground(t) - gravity * math.sin(b)
        weight = -side * down * math.sin(phi)
        if platform is None:
            turning = 0.75 / half * (weight - along * math.cos(phi)) - drag * rate
            return [rate, turning, 0.0, 0.0]
        spring = -(2 * xi * omega * velocity + omega**2 * drift) / ratio  # over the block's mass
        left = [[4 / 3 * half, math.cos(phi)], [half * math.cos(phi), 1 + 1 / ratio]]
        right = [weight, spring - half * side * math.sin(phi) * rate**2]
        turning, total = np.linalg.solve(left, right)
        return [rate, turning, velocity, total - along]

    answer, time = Answer(), 0.0
    state = np.array([math.radians(tilt_deg), spin, 0.0, 0.0])
    while time < end - 1e-12:
        if abs(state[0]) < 1e-12 and abs(state[1]) < 1e-6:  # stands until the ground lifts it
            grid = np.arange(time, end, 1e-5)
            lifts = [abs(ground(t)) > (gravity + vertical(t)) * width / height for t in grid]
            if not any(lifts):
                break
            time = float(grid[int(np.argmax(lifts))])
            side = -math.copysign(1.0, ground(time))
            state[:2] = 0.0
        else:
            side = math.copysign(1.0, state[0] if abs(state[0]) > 1e-12 else state[1])

        events = (
            event(lambda t, y, side: side * y[0] + (1e-15 if t == time else 0.0), -1.0),
            event(lambda t, y, side: side * y[1], -1.0, ends=False),
            event(lambda t, y, side: side * y[0] - 2 * alpha, 1.0),
        )
        phase = solve_ivp(rates, (time, end), state, args=(side,), events=events, **EXACT)
        answer.drift = max(answer.drift, float(np.abs(phase.y[2]).max()))
        answer.peaks += [abs(y[0]) for y in phase.y_events[1]]
        time, state = float(phase.t[-1]), phase.y[:, -1].copy()
        if phase.t_events[2].size:
            answer.overturned = time
            break
        if phase.t_events[0].size:
            answer.impacts.append(time)
            if platform:  # horizontal momentum stays
                state[3] += kappa * height / 2 * state[1] * (1 - e)
            state[:2] = 0.0, e * state[1]
    return answer


def sliding(
    friction: float | Callable[[float], float],
    end: float,
    *,
    ground: Acceleration = still,
    vertical: Acceleration = still,
    thrown: float = 0.0,
    slope_deg: float = 0.0,
    static: float | None = None,
    cohesion: float = 0.0,
    platform: tuple[float, float, float] | None = None,
) -> Answer:
    """Sliding of a block that stays flat, on ground or on a platform (mass ratio, T, xi).

    Args:
        friction: mu, or mu(v).
        end: s.
        ground: Acceleration of the ground, m/s2.
        vertical: The same upwards.
        thrown: Speed at the start, m/s.
        slope_deg: Incline.
        static: mu at rest where it jumps.
        cohesion: Cohesive force over mass, m/s2.
        platform: Mass ratio block over platform, period, ratio of damping.
    """
    law = friction if callable(friction) else lambda v: friction
    b = math.radians(slope_deg)
    ratio, period, xi = platform or (0.0, 1.0, 0.0)
    omega = 2 * math.pi / period

    def hold(t: float, mu: float) -> float:
        """Friction over mass, m/s2."""
        return mu * (G * math.cos(b) + vertical(t)) + cohesion

    def spring(y: Any) -> float:
        return -(omega**2 * y[0] + 2 * xi * omega * y[1])

    def felt(t: float, y: Any) -> float:
        """Absolute acceleration along the slope that sticking needs, less gravity's."""
        moved = spring(y) / (1 + ratio) if platform else ground(t)
        return moved - G * math.sin(b)

    def sticks(t: float, y: Any, side: float) -> list[float]:
        return [y[1], spring(y) / (1 + ratio) - ground(t), 0.0, 0.0] if platform else [0.0] * 4

    def slips(t: float, y: Any, side: float) -> list[float]:
        force = hold(t, law(abs(y[3]))) * side
        base = spring(y) + ratio * force if platform else ground(t)
        return [y[1], base - ground(t), y[3], G * math.sin(b) - force - base]

    most = law(0.0) if static is None else static
    answer, time, state, side = Answer(), 0.0, np.array([0.0, 0.0, 0.0, thrown]), 0.0
    side = math.copysign(1.0, thrown) if thrown else 0.0
    while time < end - 1e-12:
        if side == 0.0 and abs(felt(time, state)) > hold(time, most):
            side = -math.copysign(1.0, felt(time, state))

        stops = event(lambda t, y, side: side * y[3] + (1e-14 if t == time else 0.0), -1.0)
        breaks = event(lambda t, y, side: abs(felt(t, y)) - hold(t, most), 1.0)
        rates, ends = (slips, stops) if side else (sticks, breaks)
        phase = solve_ivp(rates, (time, end), state, args=(side,), events=ends, **EXACT)
        answer.drift = max(answer.drift, float(np.abs(phase.y[0]).max()))
        shears = np.abs(omega**2 * phase.y[0] + 2 * xi * omega * phase.y[1])
        answer.shear = max(answer.shear, float(shears.max()))
        answer.peak_slip = max(answer.peak_slip, float(np.abs(phase.y[2]).max()))
        ended = phase.t[-1] < end - 1e-12
        time, state = float(phase.t[-1]), phase.y[:, -1].copy()
        if side and ended:
            state[3], side = 0.0, 0.0
        elif ended:
            side = -math.copysign(1.0, felt(time, state))
    answer.slip = float(state[2])
    return answer
