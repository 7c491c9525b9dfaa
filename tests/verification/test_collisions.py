"""Rigid blocks that meet: momenta, and pounding of neighbours on ground that shakes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from ledger import completed as run
from rigid import PAPER, G, scene
from scipy.optimize import brentq

from rockslip import History, Scene
from solver.excitation.motion import read_ground
from solver.rigid.system import RigidSystem
from solver.types import Array

pytestmark = pytest.mark.serial


def test_a_plastic_impact_conserves_momentum() -> None:
    """30 kg at 2 m/s meet 70 kg at rest without friction: both go on with 0.6 m/s."""
    size = {"model": "rigid", "width": 0.5, "height": 0.2}
    one = size | {"name": "one", "mass": 30.0, "velocity": [2.0, 0.0]}
    other = size | {"name": "other", "mass": 70.0, "offset": 0.6}
    system = RigidSystem(scene(2, one, other, end=0.2, friction=0.0))
    assert system.advance(200, 1e-3).failure is None
    for block in (0, 1):
        assert system.velocity(block) == pytest.approx([0.6, 0.0], abs=1e-12)


HOUSNER = 1 - 1.5 * 0.0625 / 1.0625
"""Of its angular velocity the paper's block keeps this much at an impact."""


def kept_by_impacts(history: History, d: int, base: float = 0.0) -> Array:
    """What each of four impacts of the paper's block leaves, by energies a while before and after.

    Args:
        history: Of the run.
        d: Dimensions.
        base: Height on which it rocks, m.
    """
    columns = ("angular_velocity_rad_s", "centre_y_m", "angle_rad")
    if d == 3:
        columns = ("angular_velocity_y_rad_s", "centre_z_m", "angle_y_rad")
    spin, level, angle = (history[f"block.{column}"] for column in columns)
    energy = spin**2 * (0.25**2 + 1) / 6 + G * (level - base - 0.5)
    at = np.flatnonzero(np.diff(np.sign(angle)))[:4]
    return np.asarray(np.sqrt(energy[at + 20] / energy[at - 20]))


@pytest.mark.parametrize("restitution", [None, 0.95, 0.9])
@pytest.mark.parametrize("d", [2, 3])
def test_a_rocking_block_keeps_what_housner_says(d: int, restitution: float | None) -> None:
    """1 - 3/2 sin(alpha)^2 of its angular velocity, or e as given."""
    block = PAPER | {"tilt_deg": 3.0} | ({"restitution": restitution} if restitution else {})
    history = run(scene(d, block, end=1.4, friction=0.8), ledger=1e-12).history
    expected = restitution or HOUSNER
    assert kept_by_impacts(history, d) == pytest.approx([expected] * 4, abs=2e-6)


BRICK = {"model": "rigid", "width": 0.4, "height": 0.2, "thickness": 0.75, "density": 2000.0}


@pytest.mark.parametrize(("count", "courses"), [(14, 1), (8, 3)])
def test_a_block_that_rocks_on_a_wall_keeps_what_housner_says(count: int, courses: int) -> None:
    """As on the ground: its bricks touch each other and are one group, but only the block moves."""
    bricks = [
        BRICK
        | {
            "name": f"c{course}b{k}",
            "position": [0.4 * k + 0.2 * (course % 2), 0.2 * (course + 0.5)],
        }
        for course in range(courses)
        for k in range(count)
    ]
    block = PAPER | {"name": "block", "tilt_deg": 3.0, "on": f"c{courses - 1}b{count // 2}"}
    history = run(scene(2, *bricks, block, end=1.4, friction=0.8), ledger=1e-12).history
    assert kept_by_impacts(history, 2, 0.2 * courses) == pytest.approx([HOUSNER] * 4, abs=2e-6)


TUMBLING = (
    {"name": "one", "mass": 40.0, "width": 0.4, "height": 0.9, "thickness": 0.3},
    {"name": "other", "mass": 70.0, "width": 0.6, "height": 0.5, "thickness": 0.3},
)
STARTS: dict[int, tuple[dict[str, Any], ...]] = {
    2: (
        {"position": [0.0, 0.0], "velocity": [1.5, 0.2], "angular_velocity": 2.0},
        {"position": [1.2, 0.2], "velocity": [-0.5, 0.0], "angular_velocity": -3.0},
    ),
    3: (
        {"position": [0.0, 0.0, 0.0], "velocity": [1.5, 0.1, 0.2]},
        {"position": [1.2, 0.1, 0.2], "velocity": [-0.5, 0.0, 0.0]},
    ),
}
for _start, _spin in zip(STARTS[3], ([1.0, 2.0, -0.5], [-0.7, -3.0, 1.2]), strict=True):
    _start["angular_velocity"] = _spin


def momenta(system: RigidSystem) -> tuple[Array, Array]:
    """Linear momentum, and angular momentum about the centre of both, in three components."""
    d = system.dimension
    masses = np.array([block["mass"] for block in TUMBLING])
    centres, velocities = np.zeros((2, 2, 3))
    for k in (0, 1):
        centres[k, [0, 2] if d == 2 else slice(3)] = system.centre(k)
        velocities[k, [0, 2] if d == 2 else slice(3)] = system.velocity(k)
    middle = masses @ centres / masses.sum()
    angular = (masses[:, None] * np.cross(centres - middle, velocities)).sum(axis=0)
    for k, block in enumerate(TUMBLING):
        squares = np.array([block[edge] ** 2 for edge in ("width", "thickness", "height")])
        own, spin = masses[k] / 12 * (squares.sum() - squares), system.angular_velocity(k)
        if d == 2:  # clockwise is about y
            angular[1] += own[1] * spin[0]
        else:
            turn = system.rotation(k)
            angular += turn @ (own * (turn.T @ spin))
    return masses @ velocities, angular


@pytest.mark.parametrize(("gravity", "level"), [(0.0, 2.0), (G, 20.0)], ids=["floating", "falling"])
@pytest.mark.parametrize(("d", "within"), [(2, 1e-12), (3, 1e-6)])
def test_two_tumbling_boxes_keep_their_momenta(
    d: int, within: float, gravity: float, level: float
) -> None:
    """Linear ones to 1e-12; falling, they get what gravity gives.

    The level in m is one from which they do not reach the ground: the round-off of places grows
    with it, and the moments of momenta by that.
    """
    blocks = [{"model": "rigid"} | a | b for a, b in zip(TUMBLING, STARTS[d], strict=True)]
    for block in blocks:
        block["position"] = [*block["position"][:-1], block["position"][-1] + level]
    system = RigidSystem(scene(d, *blocks, end=1.5, friction=0.4, gravity=gravity))
    before, thrown = momenta(system), system.velocity(0)
    for _ in range(1500):
        assert system.advance(1, 1e-3).failure is None
        linear, angular = momenta(system)
        given = 110 * gravity * system.time
        linear[2] += given
        scale = np.abs(before[0]).max() + given
        assert np.abs(linear - before[0]).max() < 1e-12 * scale
        assert np.abs(angular - before[1]).max() < within * np.abs(before[1]).max()
    assert abs(system.velocity(0)[0] - thrown[0]) > 0.3  # they have met


@dataclass(slots=True)
class Slider:
    """A block that stays flat: place and velocity at a time, and its friction."""

    mass: float
    friction: float
    time: float
    place: float
    velocity: float


class Pounding:
    """Two blocks that slide on a shaken incline and rebound from each other, event by event.

    The ground has the acceleration A sin(omega t) along itself: between events places and
    velocities have closed forms. A block that sticks begins to slide once the ground and gravity
    pull more than mu g cos beta.
    """

    def __init__(self, slope: float, amplitude: float, period: float, restitution: float):
        """Set up the incline (rad, towards +x), the ground (m/s2, s), and e."""
        self.a, self.omega, self.e = amplitude, 2 * math.pi / period, restitution
        self.along, self.normal = G * math.sin(slope), G * math.cos(slope)

    def pull(self, time: float) -> float:
        """What ground and gravity accelerate a block by that does not stick, m/s2."""
        return self.along - self.a * math.sin(self.omega * time)

    def moved(self, block: Slider, way: float, time: float) -> tuple[float, float]:
        """Place and velocity at a later time of a block that slides in a direction, +1 or -1."""
        a, w, t0, dt = self.a, self.omega, block.time, time - block.time
        pull = way * block.friction * self.normal - self.along
        velocity = block.velocity + a / w * (math.cos(w * time) - math.cos(w * t0)) - pull * dt
        place = block.place + (block.velocity - a / w * math.cos(w * t0)) * dt - pull * dt**2 / 2
        return place + a / w**2 * (math.sin(w * time) - math.sin(w * t0)), velocity

    def direction(self, block: Slider) -> float:
        """+1 or -1; 0: it sticks."""
        if abs(block.velocity) > 1e-13:
            return math.copysign(1.0, block.velocity)
        pull = self.pull(block.time + 1e-9)
        return math.copysign(1.0, pull) if abs(pull) > block.friction * self.normal else 0.0

    def impacts(self, left: Slider, right: Slider, end: float) -> Iterator[tuple[float, ...]]:
        """Time of each impact, and velocities of both before and after it."""
        step = 2e-3
        while left.time < end:
            ways = self.direction(left), self.direction(right)
            pair = list(zip((left, right), ways, strict=True))

            def at(time: float) -> list[tuple[float, float]]:
                return [self.moved(b, w, time) if w else (b.place, 0.0) for b, w in pair]

            def events(time: float) -> list[float]:
                found = at(time)
                limits = [
                    w * velocity if w else b.friction * self.normal - abs(self.pull(time))
                    for (b, w), (_, velocity) in zip(pair, found, strict=True)
                ]
                return [found[1][0] - found[0][0], *limits]

            time = left.time + step
            # What has just begun is no event: sliding starts at zero velocity, an impact at no gap.
            started = events(left.time + 1e-9)
            now = events(time)
            crossed = [k for k, (x, y) in enumerate(zip(started, now, strict=True)) if x > 0 >= y]
            first, when = -1, time
            for k in crossed:
                root = brentq(lambda t, k=k: events(t)[k], left.time + 1e-9, time, xtol=1e-14)
                if root <= when:
                    first, when = k, root
            for block, (place, velocity) in zip((left, right), at(when), strict=True):
                block.time, block.place, block.velocity = when, place, velocity
            if first > 0:
                (left, right)[first - 1].velocity = 0.0
            if first == 0:
                before = left.velocity, right.velocity
                total = left.mass + right.mass
                mean = (left.mass * before[0] + right.mass * before[1]) / total
                jump = self.e * (before[0] - before[1])
                left.velocity = mean - right.mass * jump / total
                right.velocity = mean + left.mass * jump / total
                yield when, *before, left.velocity, right.velocity


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.5, 0.8])
def test_neighbours_pound_as_their_equation_says(restitution: float) -> None:
    """0.1 m apart, e from their pair: first five impacts within 0.2 % in time and velocities.

    An incline of four degrees brings the right one, which slides more, back to the left one.
    """
    size = {"model": "rigid", "width": 1.0, "height": 0.5}
    left = size | {"name": "left", "mass": 500.0, "friction": 0.25}
    right = size | {"name": "right", "mass": 800.0, "friction": 0.1, "offset": 1.1}
    pair = {"between": ["left", "right"], "friction": 0.3, "restitution": restitution}
    motion = {"kind": "sine", "amplitude_g": 0.5, "period": 1.0, "cycles": 12}
    more = {"gravity_tilt_deg": -4.0, "pair": [pair], "motion": motion}
    exact = Pounding(math.radians(-4.0), 0.5 * G, 1.0, restitution).impacts(
        Slider(500.0, 0.25, 0.0, 0.0, 0.0), Slider(800.0, 0.1, 0.0, 0.1, 0.0), 6.0
    )
    impacts = pounded(scene(2, left, right, end=6.0, **more), 1.1)
    for (when, *found), (time, *velocities) in zip(impacts[:5], exact, strict=False):
        assert when == pytest.approx(time, rel=2e-3)
        # Of the largest one: a block may be nearly at rest.
        assert found == pytest.approx(velocities, abs=2e-3 * np.abs(velocities).max())
    assert len(impacts) >= 5


def pounded(given: Scene, apart: float, dt: float = 1e-3) -> list[Array]:
    """Impacts: time, velocities of both before and after, from the steps beside them.

    `apart`: the distance of the centres at the start, m, for 0.1 m of gap.
    """
    system, motion = RigidSystem(given), read_ground(given)
    rows = []
    for _ in range(round(given.time.end / dt)):
        places, velocities = ([f(k)[0] for k in (0, 1)] for f in (system.centre, system.velocity))
        rows.append([system.time, *places, *velocities])
        times = system.time + np.array([0.0, dt])
        ground, mean = motion.acceleration(times), motion.means(times)
        assert system.advance(1, dt, ground, mean=mean).failure is None
    found, steps = [], np.array(rows)
    speed = steps[:, 4] - steps[:, 3]
    for k in np.flatnonzero(np.diff(speed) > 0.03):
        earlier, before, after, later = steps[k - 1 : k + 3]
        when = before[0] + (before[2] - before[1] - apart + 0.1) / (before[3] - before[4])
        part = (when - before[0]) / dt
        into = before[3:] + part * (before[3:] - earlier[3:])
        out = after[3:] - (1 - part) * (later[3:] - after[3:])
        found.append(np.array([when, *into, *out]))
    return found
