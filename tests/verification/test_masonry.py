"""Dry masonry in the plane: a lintel, tilted walls, a trilith that rocks."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest
from rigid import G, run
from scipy.optimize import linprog

from benchmarks.rigid_world import scenes
from benchmarks.rigid_world.trilith import Frame, outcome
from rockslip import parse_scene
from solver.rigid.system import RigidSystem

pytestmark = pytest.mark.serial


def test_a_lintel_with_an_eccentric_load() -> None:
    """Reactions sum to the weight; thin posts take the shares that moments give them."""
    post = {"model": "rigid", "width": 0.02, "height": 0.2, "mass": 20.0}
    blocks = [
        post | {"name": "left", "offset": -1.0},
        post | {"name": "right", "offset": 1.0},
        post | {"name": "lintel", "on": ["left", "right"], "width": 2.4, "mass": 900.0},
        post | {"name": "load", "on": "lintel", "width": 0.2, "mass": 300.0, "offset": -0.6},
    ]
    tables = {"block": blocks, "contact": {"friction": 0.6}, "time": {"end": 0.5, "step": 1e-3}}
    history = run(parse_scene(tables)).history
    left, right, lintel = (history[f"{k}.normal_force_N"] for k in ("left", "right", "lintel"))
    assert np.abs(lintel - 1200 * G).max() < 1e-12 * 1200 * G
    assert np.abs(left + right - 1240 * G).max() < 1e-12 * 1240 * G
    share = left / G - 20
    # About the middle: each reaction acts within 0.01 m of the axis of its post.
    assert np.abs((2 * share - 1200) * 1.0 - 300 * 0.6).max() < 1200 * 0.01
    for name in ("left", "right", "lintel", "load"):
        assert np.ptp(history[f"{name}.angle_rad"]) < 1e-12
        assert np.ptp(history[f"{name}.centre_x_m"]) < 1e-12


def steepest(tables: dict[str, Any], friction: float) -> float:
    """Tangent of the largest slope for which forces in the bed joints balance the bricks.

    The static theorem as a linear programme: forces at both ends of each joint, n >= 0 and
    |t| <= mu n, against weights along (tan beta, -1). It is exact for a mechanism without sliding,
    and an upper bound otherwise, as Coulomb's friction is not associated.
    """
    bricks = tables["block"]
    weight = [scenes.weight(brick) for brick in bricks]
    ends = []  # place, brick above, brick below (-1: the ground)
    for above, brick in enumerate(bricks):
        x, z = brick["position"]
        half, bottom = brick["width"] / 2, z - brick["height"] / 2
        if bottom < 1e-9:
            ends += [(x - half, bottom, above, -1), (x + half, bottom, above, -1)]
        for below, other in enumerate(bricks):
            left = max(x - half, other["position"][0] - other["width"] / 2)
            right = min(x + half, other["position"][0] + other["width"] / 2)
            if abs(other["position"][1] + other["height"] / 2 - bottom) < 1e-9 and left < right:
                ends += [(left, bottom, above, below), (right, bottom, above, below)]
    count = 2 * len(ends) + 1
    balance, given = np.zeros((3 * len(bricks), count)), np.zeros(3 * len(bricks))
    for b, heavy in enumerate(weight):
        balance[3 * b, -1], given[3 * b + 1] = heavy, heavy
    for k, (x, z, above, below) in enumerate(ends):
        for b, sign in ((above, 1.0), (below, -1.0)):
            if b < 0:
                continue
            arm = np.array([x, z]) - bricks[b]["position"]
            balance[3 * b + 1, 2 * k], balance[3 * b, 2 * k + 1] = sign, sign
            balance[3 * b + 2, 2 * k : 2 * k + 2] = sign * arm[0], -sign * arm[1]
    cone = np.zeros((2 * len(ends), count))
    for k in range(len(ends)):
        cone[2 * k : 2 * k + 2, 2 * k] = -friction
        cone[2 * k : 2 * k + 2, 2 * k + 1] = 1.0, -1.0
    cost = np.zeros(count)
    cost[-1] = -1.0
    bounds = [(0, None), (None, None)] * len(ends) + [(0, None)]
    scale = max(weight)
    found = linprog(
        cost, cone, np.zeros(len(cone)), balance / scale, given / scale, bounds, method="highs"
    )
    assert found.success
    return float(-found.fun)


def moved(tables: dict[str, Any], slope: float, end: float = 0.5) -> float:
    """How far a wall on an incline moves from rest, m."""
    system = RigidSystem(parse_scene(tables | {"gravity_tilt_deg": slope}))
    places = [system.centre(k) for k in range(len(system.names))]
    done = system.advance(round(end / 1e-3), 1e-3)
    assert done.failure is None
    return max(float(np.abs(system.centre(k) - place).max()) for k, place in enumerate(places))


@pytest.mark.parametrize(
    ("brick", "friction", "slides"), [((0.4, 0.2), 0.3, True), ((0.3, 0.2), 0.6, False)]
)
def test_tilted_walls(brick: tuple[float, float], friction: float, slides: bool) -> None:
    """4 x 5 bricks: one that slides as a whole, one that topples without any sliding."""
    tables = scenes.wall(4, 5, brick=brick, friction=friction)
    tangent = steepest(tables, friction)
    if slides:
        assert tangent == pytest.approx(friction, rel=1e-9)
    else:
        # Friction has no part in it.
        assert tangent == pytest.approx(steepest(tables, 1.1 * friction), rel=1e-9)
    angle = math.degrees(math.atan(tangent))
    assert moved(tables, angle - 0.05) < 1e-9
    assert moved(tables, angle + 0.05) > 1e-4


@functools.cache
def frame() -> Frame:
    """The demo's trilith."""
    return Frame.of(scenes.trilith())


def test_a_trilith_rocks_as_one_block() -> None:
    """Columns under a lintel rock as one larger block of their slenderness.

    Makris and Vassiliou (2013): p^2 (1 + 2 gamma)/(1 + 3 gamma), gamma the mass of the lintel over
    those of both columns, before the first impact.
    """
    given, amplitude, duration = frame(), 0.5, 0.6
    assert amplitude > math.tan(given.alpha)
    motion = {"kind": "half_sine", "amplitude_g": amplitude, "duration": duration}
    time = {"end": 0.9, "step": 1e-3}
    history = run(parse_scene(scenes.trilith(friction=3.0, motion=motion, time=time))).history
    exact = given.angle(amplitude, duration, history["time_s"])
    # Negative: the ground goes to the right, and the frame leans to the left.
    for name in ("left", "right"):
        error = np.abs(history[f"{name}.angle_rad"] - exact).max()
        assert error < 1e-4 * np.abs(exact).max()
    assert np.abs(history["lintel.angle_rad"]).max() < 1e-9


@pytest.mark.parametrize("gamma_of_lintel", [0.4, 1.2])
def test_a_trilith_rests_moves_or_falls(gamma_of_lintel: float) -> None:
    """It moves above g tan alpha, whatever the lintel, and falls where the large block does."""
    lintel = (3.0, gamma_of_lintel)
    given = Frame.of(scenes.trilith(lintel=lintel))
    least, duration = math.tan(given.alpha), 0.5
    assert outcome(0.99 * least, duration, lintel=lintel, friction=3.0) == "rest"
    assert outcome(1.05 * least, duration, lintel=lintel, friction=3.0) == "motion"
    falls = given.overturning(duration)
    assert outcome(0.995 * falls, duration, lintel=lintel, friction=3.0) == "motion"
    assert outcome(1.005 * falls, duration, lintel=lintel, friction=3.0) == "collapse"
