"""Answers that many oracles share: closed forms, and numbers of the own programs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from tests.oracles import own
from tests.oracles.oracle import Changes, Numbers, closed, program, today, word

P, ALPHA = own.frequency(0.25, 1.0), own.slenderness(0.25, 1.0)
HALF = math.sqrt(0.5)
#: Slip of a block thrown with 1 m/s, mu 0.3, m.
STOP = 1 / (2 * 0.3 * own.G)
#: The paper's Eq. 2: as a scene has it, and as a function of the speed.
FALLS = {"static": 0.6, "dynamic": 0.3, "decay": 20.0}
FINER: dict[str, Changes] = {"a fourth of the tolerance": {"time.tolerance": 2.5e-4}}
ODE, SLIDER = "Housner's equation, own ODE", "sliding block, own ODE"


def falling(speed: float) -> float:
    """The coefficient of FALLS."""
    return 0.3 * (1 + math.exp(-20 * speed))


def pulse(kind: str, amplitude_g: float, **keys: float) -> dict[str, Any]:
    """The change to a scene that shakes it."""
    return {"motion": {"kind": kind, "amplitude_g": amplitude_g, **keys}}


def vertical(amplitude_g: float, period: float) -> dict[str, Any]:
    """A sine of the ground along the vertical."""
    return {"motion.vertical": {"kind": "sine", "amplitude_g": amplitude_g, "period": period}}


def half_sine_at(times: float) -> dict[str, Any]:
    """Half a sine of omega = 2 p, so many times what overturns the granite block."""
    return pulse("half_sine", times * 1.8015 * 0.25, duration=math.pi / (2 * P))


def quarter(rel: float, block: str = "", height: float = 1.0) -> Numbers:
    """First impact after a release from 3 degrees; width 0.25 m."""
    value = own.quarter(0.25, height, math.radians(3))
    return {f"{block} impact 1 time_s".strip(): closed(value, "integral of the energy", rel=rel)}


def rocks(
    impacts: int,
    peaks: int,
    rel: float,
    *,
    size: tuple[float, float] = (0.25, 1.0),
    tilt: float = 3.0,
    e: float | None = None,
    block: str = "",
    **case: Any,
) -> Callable[[], Numbers]:
    """Times of impacts, peaks after the release, Housner's or the given restitution."""

    def numbers() -> Numbers:
        answer = own.rocking(*size, 3.0, tilt_deg=tilt, e=e, **case)
        of = f"{block} ".lstrip()
        found = {
            f"{of}impact {n + 1} time_s": program(answer.impacts[n], ODE, rel=rel)
            for n in range(impacts)
        }
        for n in range(1, peaks):
            found[f"{of}peak {n + 1}"] = program(answer.peaks[n], ODE, rel=5 * rel)
        if not case:
            ratio = own.housner(*size) if e is None else e
            law = "1 - 3/2 sin2 alpha (Housner 1963)" if e is None else "the key"
            found[f"{of}impact 1 restitution"] = closed(ratio, law, abs=3e-4)
        return found

    return numbers


def first_swing(
    e: float, spread: float, impacts: int = 1, rel: float = 2e-3, **case: Any
) -> Callable[[], Numbers]:
    """Of an elastic block: its restitution of today, and Housner's ODE with it."""

    def numbers() -> Numbers:
        answer = own.rocking(0.25, 1.0, 1.6, tilt_deg=3, e=e, **case)
        found = {} if case else dict(quarter(1e-3))
        for n in range(1, impacts + 1):
            time = answer.impacts[n]
            found[f"impact {n + 1} time_s"] = program(time, f"{ODE}, e {e}", rel=rel)
            if not case:
                found[f"impact {n} restitution"] = today(e, abs=spread)
        return found

    return numbers


def agreed(rel: float, values: dict[str, float]) -> Numbers:
    """Numbers of today that `beside` confirms."""
    return {name: today(value, rel=rel) for name, value in values.items()}


def moved(kind: str, level: float, end: float, rel: float = 5e-5, **keys: float) -> Numbers:
    """The granite block from rest under a pulse: peak, impacts, or that it overturns."""
    duration = keys.get("duration", keys.get("period", 0.0))
    ground = {
        "half_sine": lambda: own.sine(level, 2 * duration, 0.5),
        "one_sine": lambda: own.sine(level, duration, 1),
        "rectangular": lambda: own.rectangle(level, duration),
        "ricker": lambda: own.ricker(level, keys["frequency"]),
        "sine": lambda: own.sine(level, duration),
    }[kind]()
    answer = own.rocking(0.25, 1.0, end, ground=ground)
    if answer.overturned < end:
        time = program(answer.overturned, ODE, rel=5e-4)
        found = {"block.mode": word("overturned", ODE), "block.overturned_at_s": time}
    else:
        found = {"block.peak_angle_rad": program(max(answer.peaks), ODE, rel=4 * rel)}
    for n, time in enumerate(answer.impacts[:2], 1):
        found[f"impact {n} time_s"] = program(time, ODE, rel=rel * n)
    return found


def slides(rel: float, friction: Any, end: float, **case: Any) -> Callable[[], Numbers]:
    """Peak and residual slip of a squat block."""

    def numbers() -> Numbers:
        answer = own.sliding(friction, end, **case)
        return {
            "block.peak_slip_m": program(answer.peak_slip, SLIDER, rel=rel),
            "last block.slip_m": program(answer.slip, SLIDER, abs=rel * answer.peak_slip),
        }

    return numbers


def driven(
    rel: float, friction: Any, *, level: float = 0.4, end: float = 3.0, **case: Any
) -> Callable[[], Numbers]:
    """Drift, base shear and slip of a block of 1 t on the paper's platform, three cycles."""

    def numbers() -> Numbers:
        ground = own.sine(level, 0.5, 3)
        answer = own.sliding(friction, end, ground=ground, platform=(2.0, 0.5, 0.05), **case)
        name, slip = "block on a platform, own ODE", answer.peak_slip
        return {
            "platform.peak_drift_m": program(answer.drift, name, rel=rel),
            "platform.peak_base_shear_N": program(500 * answer.shear, name, rel=rel),
            "block.peak_slip_m": program(slip, name, abs=3 * rel * max(slip, 0.01)),
        }

    return numbers


def stops(rel: float, share: float = 1.0, column: str = "slip_m") -> Numbers:
    """A block thrown with 1 m/s, or a component of its slip."""
    return {f"last block.{column}": closed(share * STOP, "v2/(2 mu g)", rel=rel)}


def newmark(
    rel: float, friction: float, level: float, duration: float, block: str = "block"
) -> Numbers:
    """Slip under a rectangular pulse of so many g."""
    slip = (level * own.G * duration) ** 2 / (2 * friction * own.G) * (1 - friction / level)
    return {f"{block}.peak_slip_m": closed(slip, "V2/(2 mu g) (1 - mu g/a)", rel=rel)}


def downhill(rel: float, end: float = 1.0) -> Numbers:
    """Slip on an incline of 20 degrees, mu 0.3."""
    b = math.radians(20)
    slip = own.G / 2 * (math.sin(b) - 0.3 * math.cos(b)) * end**2
    return {"last block.slip_m": closed(slip, "g (sin b - mu cos b) t2/2", rel=rel)}


def holds(why: str, within: float = 1e-9, block: str = "block") -> Numbers:
    """A block that does not slip."""
    return {f"{block}.peak_slip_m": closed(0.0, why, abs=within)}


def flown(speed: float, time: float) -> float:
    """Height after a time of flight, m."""
    return speed * time - own.G * time**2 / 2


def on_bed(ratio: float, end: float) -> Numbers:
    """Gap of a block of 1 t thrown up with 0.5 m/s from a bed of 40 MN/m, and back."""
    stiffness, dashpot = 4e4, 2 * ratio * math.sqrt(4e4)  # over the mass

    def rates(t: float, y: Any) -> list[float]:
        force = -stiffness * y[0] - dashpot * y[1] if y[0] < 0 else 0.0
        return [y[1], max(force, 0.0) - own.G]

    start = [-own.G / stiffness, 0.5]
    run = solve_ivp(rates, (0, end), start, max_step=2e-5, rtol=1e-9, atol=1e-12)
    words = "spring and dashpot that never pull, own ODE"
    return {"last block.gap_left_m": program(run.y[0, -1], words, abs=2e-4)}


def about_corner(width: float, height: float) -> tuple[float, float]:
    """Slenderness, and p2 of rocking about a corner of a square base in the diagonal plane."""
    arm = math.hypot(height / 2, width * HALF)
    p2 = own.G * arm / ((width**2 + height**2) / 12 + arm**2)
    return math.atan(width * math.sqrt(2) / height), p2


def on_corner(width: float, height: float, rel: float = 1e-3) -> Numbers:
    """First landing of a block with a square base, released from 3 degrees on one corner."""
    (alpha, p2), tilt = about_corner(width, height), math.radians(3)
    points, weights = np.polynomial.legendre.leggauss(200)
    x = (points + 1) / 2
    speed = np.sqrt(2 * p2 * (np.cos(alpha - tilt) - np.cos(alpha - tilt * (1 - x**2))))
    time = float(weights / 2 @ (2 * tilt * x / speed))
    return {"impact 1 time_s": closed(time, "integral of the energy about a corner", rel=rel)}


def onto_corner(width: float, height: float, peak: float, duration: float) -> Numbers:
    """Lean at the end of half a sine of the ground along the diagonal, to a peak in g."""
    (alpha, p2), omega = about_corner(width, height), math.pi / duration

    def rates(t: float, y: Any) -> list[float]:
        lean = alpha - y[0]
        return [y[1], -p2 * (math.sin(lean) - peak * math.sin(omega * t) * math.cos(lean))]

    start = math.asin(math.tan(alpha) / peak) / omega
    lean = solve_ivp(rates, (start, duration), [0.0, 0.0], rtol=1e-11, atol=1e-13).y[0, -1]
    return {
        f"last block.angle_{axis}_rad": program(part * lean, "Housner's equation there", rel=1e-3)
        for axis, part in (("x", -HALF), ("y", HALF))
    }


def tumbles(spin: list[float], sides: list[float], end: float) -> Numbers:
    """Angular velocity, about the ground's axes, of a box that turns freely."""
    squares = np.array(sides) ** 2
    inertia = squares.sum() - squares

    def rates(t: float, y: Any) -> Any:
        turn, w = y[:9].reshape(3, 3), y[9:]
        hat = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return np.concatenate([(turn @ hat).ravel(), -np.cross(w, inertia * w) / inertia])

    start = np.concatenate([np.eye(3).ravel(), spin])
    last = solve_ivp(rates, (0, end), start, rtol=1e-10, atol=1e-12).y[:, -1]
    return {
        f"last block.angular_velocity_{axis}_rad_s": program(rate, "Euler's equations", abs=1e-4)
        for axis, rate in zip("xyz", last[:9].reshape(3, 3) @ last[9:], strict=True)
    }


def curves(friction: float, level: float, thrown: float, end: float) -> Numbers:
    """Slip (x, y) of a block thrown along y on ground that accelerates along x, up to its stop."""

    def rates(t: float, y: Any) -> Any:
        speed = max(math.hypot(y[2], y[3]), 1e-9)
        push = friction * own.G / speed
        return [y[2], y[3], -push * y[2] - level * own.G, -push * y[3]]

    stop = own.event(lambda t, y: math.hypot(y[2], y[3]) - 1e-5, -1.0)
    last = solve_ivp(rates, (0, end), [0, 0, 0, thrown], events=stop, **own.EXACT).y[:, -1]
    words = "friction in two directions, own ODE"
    names = ("last block.slip_m", "last block.slip_second_m")
    return {name: program(x, words, abs=1e-3) for name, x in zip(names, last[:2], strict=True)}
