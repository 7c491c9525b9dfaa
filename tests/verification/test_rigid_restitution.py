"""Rigid blocks with a given restitution, in the plane and in space: rocking, landings, energy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.errors import SceneError
from solver.reference.answer import reference_history
from solver.reference.housner import housner, housner_restitution

SIZE = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "model": "rigid"}
UPWARDS = {2: [0.0, 1.0], 3: [0.0, 0.0, 1.0]}
GAP = {2: "block.gap_left_m", 3: "block.gap_1_m"}

in_both = pytest.mark.parametrize("d", [2, 3])


def scene(d: int, end: float, step: float = 1e-3, friction: float = 0.7, **block: Any) -> Scene:
    """The paper's block on a rigid floor, with changes."""
    return parse_scene(
        {
            "dimension": d,
            "block": [SIZE | block],
            "contact": {"friction": friction},
            "time": {"end": end, "step": step},
        }
    )


def nothing_from_nothing(result: Result) -> None:
    """The run completed, gained no energy, and its ledger closes."""
    assert result.status == "completed"
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-9


def reference(asked: Scene, end: float, **keys: Any) -> Any:
    """Housner's equation for the block of a scene, released at 3 degrees."""
    shape = asked.blocks[0].shape
    return housner(shape, gravity=9.81, tilt=math.radians(3.0), end=end, step=1e-3, **keys)


@pytest.mark.parametrize("restitution", [0.90, 0.936])
@pytest.mark.parametrize(("d", "direction"), [(2, 0.0), (3, 0.0), (3, 90.0)])
def test_rocking_is_that_of_the_ode(restitution: float, d: int, direction: float) -> None:
    """Below and above the 0.9118 of the plastic impact; tests/oracles has 0.5, 0.95 and 1."""
    turned = {"tilt_direction_deg": direction} if d == 3 else {}
    if direction:
        turned |= {"width": 0.75, "thickness": 0.25}
    asked = scene(d, 1.21, restitution=restitution, tilt_deg=3.0, **turned)
    result = simulate(asked)
    exact = reference(scene(2, 1.21), 1.21, restitution=restitution)
    block, count = result.summary["blocks"]["block"], min(4, len(exact.impacts))
    times = [impact["time_s"] for impact in block["impacts"]]
    peaks = [abs(peak["angle_rad"]) for peak in block["peaks"][1:]]
    assert times[:count] == pytest.approx(exact.impacts[:count], rel=3e-5 if d == 2 else 2e-4)
    assert peaks[: count - 1] == pytest.approx(np.abs(exact.peaks[1:count]), rel=1e-3)
    if d == 3:
        across = "centre_x_m" if direction else "centre_y_m"
        assert np.abs(result.history[f"block.{across}"]).max() < 1e-9
    nothing_from_nothing(result)


def test_housners_own_value_changes_nothing() -> None:
    """With 1 - 1.5 sin^2 alpha it rocks as without one, whose impacts take a piece of a step."""
    free = scene(2, 1.0, tilt_deg=3.0)
    given = scene(2, 1.0, tilt_deg=3.0, restitution=housner_restitution(free.blocks[0].shape))
    angles = [simulate(asked).history["block.angle_rad"] for asked in (free, given)]
    assert np.abs(angles[0] - angles[1]).max() < 1e-6


@pytest.mark.parametrize("part", np.linspace(-2e-3, 2e-3, 5))
def test_impacts_at_the_very_end_of_a_step_are_not_missed(part: float) -> None:
    """Steps that end so short before or after the impact that the step is not cut there."""
    exact = reference(scene(2, 1.0), 0.6, restitution=0.95)
    step = exact.impacts[0] / (192 + part)
    result = simulate(scene(2, 0.6, step, tilt_deg=3.0, restitution=0.95))
    times = [impact["time_s"] for impact in result.summary["blocks"]["block"]["impacts"]]
    assert times[:2] == pytest.approx(exact.impacts[:2], rel=3e-5)
    landing = 0.25 * 0.47  # B omega at the impact, m/s
    assert result.history["block.penetration_m"].max() < 1e-3 * step * landing
    nothing_from_nothing(result)


@in_both
def test_an_impact_loses_what_the_angular_velocity_loses(d: int) -> None:
    """energy.contact_J falls by (1 - e^2) of the kinetic energy before the impact."""
    asked = scene(d, 0.3, tilt_deg=3.0, restitution=0.936)
    shape, history = asked.blocks[0].shape, simulate(asked).history
    fall = 503.0 * 9.81 * shape.half_diagonal
    fall *= math.cos(shape.slenderness - math.radians(3.0)) - math.cos(shape.slenderness)
    assert history["energy.contact_J"][-1] == pytest.approx((1 - 0.936**2) * fall, rel=1e-6)


def test_the_reference_takes_it() -> None:
    """`rockslip reference` solves Housner's equation with the block's restitution."""
    asked = scene(2, 0.7, tilt_deg=3.0, restitution=0.95)
    angle = simulate(asked).history["block.angle_rad"]
    assert np.abs(angle - reference_history(asked)["block.angle_rad"]).max() < 2e-5


@in_both
@pytest.mark.parametrize("restitution", [0.3, 1.0])
def test_a_flat_landing_rebounds(restitution: float, d: int) -> None:
    """Thrown up at 1 m/s it lands with 1 m/s and rises to e^2 of the height, time and again."""
    result = simulate(scene(d, 0.7, 7e-4, velocity=UPWARDS[d], restitution=restitution))
    height, time = result.history[GAP[d]], result.history["time_s"]
    flight, start = 2 / 9.81, 0.0
    while start + flight < 0.7 and flight > 0.014:
        inside = (time > start) & (time < start + flight)
        since = time[inside] - start
        exact = since * (9.81 * flight / 2 - 9.81 * since / 2)
        assert height[inside] == pytest.approx(exact, abs=1e-6)
        start, flight = start + flight, restitution * flight
    nothing_from_nothing(result)


@in_both
def test_it_comes_to_rest(d: int) -> None:
    """Rebounds that no step resolves any more end: it stands, and bears its weight."""
    result = simulate(scene(d, 1.5, velocity=UPWARDS[d], restitution=0.7))
    assert abs(result.history[GAP[d]][-1]) < 1e-9
    assert result.history["block.normal_force_N"][-1] == pytest.approx(503.0 * 9.81, rel=1e-6)
    nothing_from_nothing(result)


def test_a_sliding_flat_landing_has_coulombs_friction() -> None:
    """Impulses (1 + e) m v upwards and mu times that against the slip."""
    asked = scene(2, 0.3, friction=0.05, velocity=[1.0, 1.0], restitution=0.6, height=0.1)
    result = simulate(asked)
    speed = np.diff(result.history["block.centre_x_m"]) / 1e-3
    assert speed[240] == pytest.approx(1.0 - 0.05 * 1.6, abs=2e-3)
    nothing_from_nothing(result)


@in_both
@pytest.mark.parametrize(("restitution", "friction"), [(0.2, 0.7), (0.7, 0.2), (1.0, 0.05)])
def test_nothing_is_gained(restitution: float, friction: float, d: int) -> None:
    """Thrown with a spin, landing on its corners and edges, sliding and rocking."""
    thrown: dict[str, Any] = {"velocity": [0.7, 1.0], "angular_velocity": 1.5}
    if d == 3:
        thrown = {"velocity": [0.7, 0.3, 1.0], "angular_velocity": [0.5, 1.5, 0.4]}
    asked = scene(d, 1.0, friction=friction, restitution=restitution, height=0.4, **thrown)
    result = simulate(asked)
    nothing_from_nothing(result)
    energy = result.history["energy.total_J"]
    assert np.diff(energy).max() < 1e-9 * energy[0]


def test_a_platform_takes_the_impulse_too() -> None:
    """Alike in the plane and in space; without loss between block and platform for e = 1."""
    under = {"kind": "oscillator", "mass": 503.0, "period": 0.5}
    for restitution in (0.936, 1.0):
        runs = []
        for d in (2, 3):
            tables = scene(d, 0.6, tilt_deg=3.0, restitution=restitution).to_dict()
            runs.append(simulate(parse_scene(tables | {"foundation": under})))
            nothing_from_nothing(runs[-1])
            if restitution == 1.0:
                lost = runs[-1].history["energy.contact_J"][-1]
                assert lost < 1e-6 * runs[-1].history["energy.kinetic_J"].max()
        for column in ("block.angle_rad", "platform.drift_m"):
            plane, space = (run.history[column] for run in runs)
            assert np.abs(space - plane).max() < 1e-3 * np.abs(plane).max()


def test_a_stack_rebounds_from_its_foundation() -> None:
    """The lower block of two rebounds; both obey contact, and nothing is gained."""
    upper = {"name": "upper", "on": "lower", "width": 0.2, "height": 0.4, "mass": 100.0}
    lower = {"name": "lower", "restitution": 0.95, "tilt_deg": 3.0}
    tables = scene(2, 1.0).to_dict() | {"block": [SIZE | lower, SIZE | upper]}
    result = simulate(parse_scene(tables))
    nothing_from_nothing(result)
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
    result = simulate(scene(3, 0.25, velocity=UPWARDS[3], restitution=0.9, **tilt))
    gaps = [result.history[f"block.gap_{corner}_m"] for corner in (1, 2, 3, 4)]
    landed = np.min(gaps, axis=0)[round(2 / 9.81 / 1e-3) + 2 :]
    assert np.abs(landed[:10]).max() < 1e-9
    nothing_from_nothing(result)


@pytest.mark.parametrize("direction", [0.0, 1e-6, 90.0])
def test_an_edge_that_lands_alone_does_not_rebound(direction: float) -> None:
    """It is the corner of the plane, also where its ends land nanoseconds after each other."""
    thrown: dict[str, Any] = {"width": 0.5, "thickness": 0.5, "tilt_deg": 10.0, "restitution": 0.8}
    tilt = {"tilt_direction_deg": direction}
    space = simulate(scene(3, 0.5, 2e-4, velocity=UPWARDS[3], **thrown, **tilt))
    plane = simulate(scene(2, 0.5, 2e-4, velocity=UPWARDS[2], **thrown))
    lean = space.history["block.angle_x_rad" if direction == 90.0 else "block.angle_y_rad"]
    expected = plane.history["block.angle_rad"] * (-1 if direction == 90.0 else 1)
    assert lean == pytest.approx(expected, abs=1e-6)
    height = space.history["block.centre_z_m"]
    assert height == pytest.approx(plane.history["block.centre_y_m"], abs=1e-6)
    nothing_from_nothing(space)


@in_both
@pytest.mark.parametrize("seed", range(6))
def test_nothing_is_gained_at_random(seed: int, d: int) -> None:
    """Blocks of all shapes, thrown or tilted, every third with another one on top."""
    random = np.random.default_rng(seed)

    def number(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    thickness = number(0.2, 1.0)

    def block(**more: Any) -> dict[str, Any]:
        """A block of some size and restitution; in the plane they are equally thick."""
        size = {"width": number(0.2, 1.0), "thickness": thickness if d == 2 else number(0.2, 1.0)}
        return SIZE | size | {"restitution": number(0.05, 1.0)} | more

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
    result = simulate(parse_scene(tables))
    nothing_from_nothing(result)
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
