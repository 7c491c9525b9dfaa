"""Rigid blocks that land, in the plane and in space: rebounds, friction, rest, no gain."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from ledger import completed as run
from rigid import PAPER, UPWARDS, G
from rigid import scene as scene_of

from rockslip import Scene, parse_scene, simulate
from solver.errors import SceneError

GAP = {2: "block.gap_left_m", 3: "block.gap_1_m"}
FALLING = {"static": 0.426, "dynamic": 0.2, "decay": 20.0}

in_both = pytest.mark.parametrize("d", [2, 3])


def scene(d: int, end: float, step: float = 1e-3, friction: float = 0.7, **block: Any) -> Scene:
    """The paper's block on a rigid floor, with changes."""
    return scene_of(d, PAPER | block, end=end, step=step, friction=friction)


@in_both
@pytest.mark.parametrize("restitution", [0.3, 1.0])
def test_a_flat_landing_rebounds(restitution: float, d: int) -> None:
    """Thrown up at 1 m/s it lands with 1 m/s and rises to e^2 of the height, time and again."""
    result = run(scene(d, 0.7, 7e-4, velocity=UPWARDS[d], restitution=restitution))
    height, time = result.history[GAP[d]], result.history["time_s"]
    flight, start = 2 / 9.81, 0.0
    while start + flight < 0.7 and flight > 0.014:
        inside = (time > start) & (time < start + flight)
        since = time[inside] - start
        exact = since * (9.81 * flight / 2 - 9.81 * since / 2)
        assert height[inside] == pytest.approx(exact, abs=1e-6)
        start, flight = start + flight, restitution * flight


@in_both
def test_it_comes_to_rest(d: int) -> None:
    """Rebounds that no step resolves any more end: it stands, and bears its weight."""
    result = run(scene(d, 1.5, velocity=UPWARDS[d], restitution=0.7))
    assert abs(result.history[GAP[d]][-1]) < 1e-9
    assert result.history["block.normal_force_N"][-1] == pytest.approx(503.0 * 9.81, rel=1e-6)


def test_a_sliding_flat_landing_has_coulombs_friction() -> None:
    """Impulses (1 + e) m v upwards and mu times that against the slip."""
    asked = scene(2, 0.3, friction=0.05, velocity=[1.0, 1.0], restitution=0.6, height=0.1)
    result = run(asked)
    speed = np.diff(result.history["block.centre_x_m"]) / 1e-3
    assert speed[240] == pytest.approx(1.0 - 0.05 * 1.6, abs=2e-3)


@in_both
@pytest.mark.parametrize(("restitution", "friction"), [(0.2, 0.7), (0.7, 0.2), (1.0, 0.05)])
def test_nothing_is_gained(restitution: float, friction: float, d: int) -> None:
    """Thrown with a spin, landing on its corners and edges, sliding and rocking."""
    thrown: dict[str, Any] = {"velocity": [0.7, 1.0], "angular_velocity": 1.5}
    if d == 3:
        thrown = {"velocity": [0.7, 0.3, 1.0], "angular_velocity": [0.5, 1.5, 0.4]}
    asked = scene(d, 1.0, friction=friction, restitution=restitution, height=0.4, **thrown)
    result = run(asked)
    energy = result.history["energy.total_J"]
    assert np.diff(energy).max() < 1e-9 * energy[0]


def test_a_platform_takes_the_impulse_too() -> None:
    """Alike in the plane and in space; without loss between block and platform for e = 1."""
    under = {"kind": "oscillator", "mass": 503.0, "period": 0.5}
    for restitution in (0.936, 1.0):
        runs = []
        for d in (2, 3):
            tables = scene(d, 0.6, tilt_deg=3.0, restitution=restitution).to_dict()
            runs.append(run(parse_scene(tables | {"foundation": under})))
            if restitution == 1.0:
                lost = runs[-1].history["energy.contact_J"][-1]
                assert lost < 1e-6 * runs[-1].history["energy.kinetic_J"].max()
        for column in ("block.angle_rad", "platform.drift_m"):
            plane, space = (each.history[column] for each in runs)
            assert np.abs(space - plane).max() < 1e-3 * np.abs(plane).max()


def test_a_stack_rebounds_from_its_foundation() -> None:
    """The lower block of two rebounds; both obey contact, and nothing is gained."""
    upper = {"name": "upper", "on": "lower", "width": 0.2, "height": 0.4, "mass": 100.0}
    lower = {"name": "lower", "restitution": 0.95, "tilt_deg": 3.0}
    tables = scene(2, 1.0).to_dict() | {"block": [PAPER | lower, PAPER | upper]}
    result = run(parse_scene(tables))
    assert result.history["upper.penetration_m"].max() < 1e-9


@pytest.mark.parametrize("skew", [1e-7, 1e-4, 0.05])
def test_an_edge_whose_ends_land_one_after_the_other(skew: float) -> None:
    """Still omega+ = e omega-: what a hair of skewness changes is no more than a hair."""
    tilted = {"tilt_deg": 3.0, "tilt_direction_deg": skew, "restitution": 0.936}
    straight = simulate(scene(3, 0.45, **(tilted | {"tilt_direction_deg": 0.0}))).history
    history = simulate(scene(3, 0.45, **tilted)).history
    peaks = [np.abs(h["block.angle_rad"])[300:].max() for h in (history, straight)]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-5 + 0.2 * skew)


def test_a_corner_that_lands_alone_does_not_rebound() -> None:
    """Dropped on a corner, without spin: that corner stays down, and the block turns about it."""
    tilt = {"tilt_deg": 20.0, "tilt_direction_deg": 30.0, "height": 0.3}
    # thrown up, so that it comes down on the corner on which it stands
    result = run(scene(3, 0.25, velocity=UPWARDS[3], restitution=0.9, **tilt))
    gaps = [result.history[f"block.gap_{corner}_m"] for corner in (1, 2, 3, 4)]
    landed = np.min(gaps, axis=0)[round(2 / 9.81 / 1e-3) + 2 :]
    assert np.abs(landed[:10]).max() < 1e-9


@pytest.mark.parametrize("direction", [0.0, 1e-6, 90.0])
def test_an_edge_that_lands_alone_does_not_rebound(direction: float) -> None:
    """It is the corner of the plane, also where its ends land nanoseconds after each other."""
    thrown: dict[str, Any] = {"width": 0.5, "thickness": 0.5, "tilt_deg": 10.0, "restitution": 0.8}
    tilt = {"tilt_direction_deg": direction}
    space = run(scene(3, 0.5, 2e-4, velocity=UPWARDS[3], **thrown, **tilt))
    plane = simulate(scene(2, 0.5, 2e-4, velocity=UPWARDS[2], **thrown))
    lean = space.history["block.angle_x_rad" if direction == 90.0 else "block.angle_y_rad"]
    expected = plane.history["block.angle_rad"] * (-1 if direction == 90.0 else 1)
    assert lean == pytest.approx(expected, abs=1e-6)
    height = space.history["block.centre_z_m"]
    assert height == pytest.approx(plane.history["block.centre_y_m"], abs=1e-6)


@in_both
@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_gained_at_random(seed: int, d: int) -> None:
    """Blocks of all shapes, thrown or tilted, every third with another one on top."""
    random = np.random.default_rng(seed)

    def number(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    thickness = number(0.2, 1.0)

    def block(**more: Any) -> dict[str, Any]:
        """A block of some size and restitution; in the plane they are equally thick."""
        size = {"width": number(0.2, 1.0), "thickness": thickness if d == 2 else number(0.2, 1.0)}
        return PAPER | size | {"restitution": number(0.05, 1.0)} | more

    start: dict[str, Any] = {"tilt_deg": number(0.5, 4.0)}
    if d == 3:
        start["tilt_direction_deg"] = number(0.0, 360.0)
    if seed % 2:
        start = {"velocity": [*(number(-1.0, 1.0) for _ in range(d - 1)), number(0.2, 1.0)]}
    blocks = [block(height=number(0.2, 1.2), **start)]
    if seed % 3 == 0:
        blocks.append(block(name="upper", on="block", height=0.4, mass=number(20.0, 2000.0)))
    friction = {"friction": float(random.choice([0.0, 0.05, 0.3, 0.8]))}
    tables = scene(d, 0.99).to_dict() | {"block": blocks, "contact": friction}
    result = run(parse_scene(tables))
    for name in {"block", blocks[-1].get("name", "block")}:
        assert result.history[f"{name}.penetration_m"].max() < 1e-5


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"model": "elastic", "young": 5e10, "poisson": 0.2}, 'model = "rigid" only'),
        ({"restitution": 1.1}, "0 < restitution <= 1"),
        ({"restitution": 0.0}, "0 < restitution <= 1"),
    ],
)
def test_refused_blocks(changes: dict[str, Any], message: str) -> None:
    """One line that names the key."""
    with pytest.raises(SceneError, match=r"^block\.restitution") as caught:
        scene(2, 1.0, **({"restitution": 0.9} | changes))
    assert message in str(caught.value)


def test_refused_scenes() -> None:
    """Beside a mesh."""
    tables = scene(2, 1.0, restitution=0.9).to_dict()
    plate = {"kind": "elastic", "width": 1.0, "height": 0.2, "density": 2.7e3, "young": 5e10}
    words = r"^block\.restitution applies to scenes in which nothing is meshed"
    with pytest.raises(SceneError, match=words):
        parse_scene(tables | {"foundation": plate | {"poisson": 0.2, "support": "bottom"}})


def side_by_side(widths: list[float], step: float) -> Scene:
    """Blocks that rock beside each other from 5 degrees on."""
    size = {"model": "rigid", "height": 1.0, "density": 1000.0, "tilt_deg": 5.0}
    blocks = [size | {"name": f"b{k}", "width": w, "offset": 2.0 * k} for k, w in enumerate(widths)]
    return scene_of(2, *blocks, end=0.5, step=step, friction=0.65)


def test_blocks_that_land_in_one_step_land_one_by_one() -> None:
    """Of 40 blocks 28 were wrong: a step was cut five times at most. Here 15 land in one step."""
    widths = np.random.default_rng(3).uniform(0.49, 0.51, 15).tolist()
    found = simulate(side_by_side(widths, 5e-3))
    for k, width in enumerate(widths):
        alpha = math.atan(width)
        kept = (1 - 1.5 * math.sin(alpha) ** 2) ** 2
        fall = math.cos(alpha - math.radians(5.0)) - math.cos(alpha)
        exact = alpha - math.acos(math.cos(alpha) + kept * fall)
        peak = abs(found.summary["blocks"][f"b{k}"]["peaks"][1]["angle_rad"])
        assert peak == pytest.approx(exact, rel=1e-3)
        assert np.abs(found.history[f"b{k}.slip_m"]).max() < 1e-9


def tilted_stack(random: np.random.Generator) -> Scene:
    """Two to four blocks on each other, of which the highest is let go at a tilt."""
    blocks: list[dict[str, Any]] = []
    width = 0.8
    for k in range(int(random.integers(2, 5))):
        on = {"on": f"block{k - 1}", "offset": random.uniform(-0.1, 0.1) * width} if k else {}
        size = {"width": width, "height": random.uniform(0.2, 0.7) * width, "density": 2500.0}
        blocks.append({"name": f"block{k}", "model": "rigid", "friction": FALLING} | size | on)
        width *= random.uniform(0.7, 1.0)
    blocks[-1]["tilt_deg"] = random.uniform(0.3, 2.0)
    return scene_of(2, *blocks, end=0.15, step=2e-4)


def test_friction_that_falls_with_speed_has_a_solution() -> None:
    """An impact that slides changes friction as it is found: 2 of these 60 had none at any step."""
    random = np.random.default_rng(9)
    rejected = [run(tilted_stack(random)).summary["cost"]["rejected_steps"] for _ in range(60)]
    assert sum(rejected) <= 2


def test_friction_of_an_impact_is_that_of_its_slip() -> None:
    """A block lands flat and sliding: dv = -mu(v) dp/m over the impulse p (Routh), own ODE."""
    thrown = {"position": [0.0, 0.1 + 1e-4], "velocity": [0.1, -0.2], "friction": FALLING}
    block = {"model": "rigid", "density": 2500.0, "width": 1.0, "height": 0.2, **thrown}
    slip = run(scene_of(2, block, end=1e-3, step=1e-4)).history["block.slip_m"]

    def slower(speed: float, impulse: float) -> float:
        """Speed after an impulse over the mass, m/s."""
        for _ in range(1000):
            fall = (FALLING["static"] - FALLING["dynamic"]) * math.exp(-FALLING["decay"] * speed)
            speed -= (FALLING["dynamic"] + fall) * impulse / 1000
        return speed

    falls = (math.sqrt(0.2**2 + 2 * G * 1e-4) - 0.2) / G  # for so long, s
    expected = slower(slower(0.1, 0.2 + G * falls), G * (7.5e-4 - falls))
    assert (slip[8] - slip[7]) / 1e-4 == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("step", [1e-3, 2e-4])
def test_a_slide_at_an_impact_does_not_depend_on_the_step(step: float) -> None:
    """Of an upper block that lands and slides, whose friction falls; no step had a solution."""
    lower = {"name": "lower", "model": "rigid", "width": 0.8, "height": 0.2, "density": 2500.0}
    upper = lower | {"name": "upper", "on": "lower", "height": 0.5, "offset": 0.1, "tilt_deg": 1.0}
    found = run(scene_of(2, lower, upper | {"friction": FALLING}, end=0.2, step=step))
    assert found.history["upper.slip_m"][-1] == pytest.approx(2.4955e-3, rel=1e-3)


@in_both
def test_a_vertical_pulse_above_1_g_throws_it_up(d: int) -> None:
    """Half a sine of 3 g downwards: the block is left behind, flies, and lands where it stood."""
    pulse = {"kind": "half_sine", "amplitude_g": -3.0, "duration": 0.1}
    motion = {"kind": "none", "vertical": pulse}
    history = run(scene_of(d, end=1.0, motion=motion), gain=1e-5).history
    # Free from where 3 g sin(pi t/T) = g on: twice integrated over the ground's motion.
    rate = math.pi / 0.1
    start = math.asin(1 / 3) / rate
    since = 0.08 - start
    ground = 3 * G * (math.sin(rate * 0.08) - math.sin(rate * start)) / rate**2
    exact = 3 * G * math.cos(rate * start) / rate * since - ground - G * since**2 / 2
    gap = history[GAP[d]]
    assert np.interp(0.08, history["time_s"], gap) == pytest.approx(exact, rel=2e-3)
    assert gap.max() > 0.09
    assert abs(gap[-1]) < 1e-9 and abs(history["block.slip_m"][-1]) < 1e-9
    assert history["block.normal_force_N"][-1] == pytest.approx(503.0 * G, rel=1e-9)


def test_thrown_with_a_spin_it_comes_to_rest_on_a_face() -> None:
    size = {"model": "rigid", "width": 0.3, "height": 0.5, "thickness": 0.4, "density": 2000.0}
    thrown = {"velocity": [1.0, 0.5, 3.1], "angular_velocity": [3.0, -4.0, 6.0]}
    history = run(scene_of(3, size | thrown, end=3.0, friction=0.5)).history
    assert history["energy.kinetic_J"][-1] < 1e-15
    heights = np.array([0.3, 0.4, 0.5]) / 2
    assert np.abs(heights - history["block.centre_z_m"][-1]).min() < 1e-9
    assert history["block.penetration_m"].max() < 1e-9
