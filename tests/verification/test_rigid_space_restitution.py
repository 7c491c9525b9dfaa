"""Rigid blocks in space with a given restitution: rocking on an edge, flat landings, corners."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.reference.housner import housner

SIZE = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "model": "rigid"}


def scene(end: float, step: float = 1e-3, friction: float = 0.7, **block: Any) -> Scene:
    """The paper's block in space on a rigid floor, with changes."""
    return parse_scene(
        {
            "dimension": 3,
            "block": [SIZE | block],
            "contact": {"friction": friction},
            "time": {"end": end, "step": step},
        }
    )


def nothing_from_nothing(result: Result, energy: float = 1e-9) -> None:
    """The run completed, gained no energy, and its ledger closes."""
    assert result.status == "completed"
    assert result.summary["energy"]["largest_gain_fraction"] < energy
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-9


@pytest.mark.parametrize("direction", [0.0, 90.0])
@pytest.mark.parametrize("restitution", [0.5, 0.90, 0.936, 1.0])
def test_rocking_on_an_edge_is_that_of_the_ode(restitution: float, direction: float) -> None:
    """About either edge; below and above the restitution of the plastic impact."""
    tilt = {"tilt_deg": 3.0, "tilt_direction_deg": direction}
    asked = scene(1.21, restitution=restitution, **tilt)
    result = simulate(asked)
    block = result.summary["blocks"]["block"]
    shape = asked.blocks[0].shape
    if direction:
        shape = type(shape)(
            width=shape.thickness, height=1.0, thickness=0.25, density=shape.density
        )
    given = {"gravity": 9.81, "tilt": math.radians(3.0), "end": 1.21, "step": 1e-3}
    exact = housner(shape, restitution=restitution, **given)
    count = min(4, len(exact.impacts))
    times = [impact["time_s"] for impact in block["impacts"]]
    peaks = [abs(peak["angle_rad"]) for peak in block["peaks"][1:]]
    assert times[:count] == pytest.approx(exact.impacts[:count], rel=2e-4)
    assert peaks[: count - 1] == pytest.approx(np.abs(exact.peaks[1:count]), rel=1e-3)
    across = "centre_x_m" if direction else "centre_y_m"
    assert np.abs(result.history[f"block.{across}"]).max() < 1e-9
    nothing_from_nothing(result)


@pytest.mark.parametrize("restitution", [0.3, 0.8, 1.0])
def test_a_flat_landing_rebounds(restitution: float) -> None:
    """Thrown up at 1 m/s it lands with 1 m/s and rises to e^2 of the height, time and again."""
    result = simulate(scene(0.7, 7e-4, velocity=[0.0, 0.0, 1.0], restitution=restitution))
    height, time = result.history["block.gap_1_m"], result.history["time_s"]
    flight, start = 2 / 9.81, 0.0
    while start + flight < 0.7 and flight > 0.014:
        inside = (time > start) & (time < start + flight)
        since = time[inside] - start
        exact = since * (9.81 * flight / 2 - 9.81 * since / 2)
        assert height[inside] == pytest.approx(exact, abs=1e-6)
        start, flight = start + flight, restitution * flight
    nothing_from_nothing(result)


def test_it_comes_to_rest() -> None:
    """Rebounds that no step resolves any more end: it stands, and bears its weight."""
    result = simulate(scene(1.5, velocity=[0.0, 0.0, 1.0], restitution=0.7))
    assert abs(result.history["block.gap_1_m"][-1]) < 1e-9
    assert result.history["block.normal_force_N"][-1] == pytest.approx(503.0 * 9.81, rel=1e-6)
    nothing_from_nothing(result)


def test_an_impact_loses_what_the_angular_velocity_loses() -> None:
    """energy.contact_J falls by (1 - e^2) of the kinetic energy before the impact."""
    asked = scene(0.3, tilt_deg=3.0, restitution=0.936)
    shape, history = asked.blocks[0].shape, simulate(asked).history
    fall = 503.0 * 9.81 * shape.half_diagonal
    fall *= math.cos(shape.slenderness - math.radians(3.0)) - math.cos(shape.slenderness)
    assert history["energy.contact_J"][-1] == pytest.approx((1 - 0.936**2) * fall, rel=1e-6)


@pytest.mark.parametrize("skew", [1e-7, 1e-4, 0.05])
def test_an_edge_whose_ends_land_one_after_the_other(skew: float) -> None:
    """Still omega+ = e omega-: what a hair of skewness changes is no more than a hair."""
    tilted = {"tilt_deg": 3.0, "tilt_direction_deg": skew, "restitution": 0.936}
    straight = simulate(scene(0.45, **(tilted | {"tilt_direction_deg": 0.0}))).history
    history = simulate(scene(0.45, **tilted)).history
    peaks = [np.abs(h["block.angle_rad"])[300:].max() for h in (history, straight)]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-5 + 0.2 * skew)


def test_a_corner_that_lands_alone_does_not_rebound() -> None:
    """Dropped on a corner, without spin: that corner stays down, and the block turns about it."""
    tilt = {"tilt_deg": 20.0, "tilt_direction_deg": 30.0, "height": 0.3}
    # thrown up, so that it comes down on the corner on which it stands
    result = simulate(scene(0.25, velocity=[0.0, 0.0, 1.0], restitution=0.9, **tilt))
    gaps = [result.history[f"block.gap_{corner}_m"] for corner in (1, 2, 3, 4)]
    landed = np.min(gaps, axis=0)[round(2 / 9.81 / 1e-3) + 2 :]
    assert np.abs(landed[:10]).max() < 1e-9
    nothing_from_nothing(result)


@pytest.mark.parametrize("direction", [0.0, 1e-6, 90.0])
def test_an_edge_that_lands_alone_does_not_rebound(direction: float) -> None:
    """It is the corner of the plane, also where its ends land nanoseconds after each other."""
    thrown: dict[str, Any] = {"width": 0.5, "thickness": 0.5, "tilt_deg": 10.0, "restitution": 0.8}
    tilt = {"tilt_direction_deg": direction}
    space = simulate(scene(0.5, 2e-4, velocity=[0.0, 0.0, 1.0], **thrown, **tilt))
    asked = {"block": [SIZE | thrown | {"velocity": [0.0, 1.0]}], "contact": {"friction": 0.7}}
    plane = simulate(parse_scene(asked | {"time": {"end": 0.5, "step": 2e-4}}))
    lean = space.history["block.angle_x_rad" if direction == 90.0 else "block.angle_y_rad"]
    expected = plane.history["block.angle_rad"] * (-1 if direction == 90.0 else 1)
    assert lean == pytest.approx(expected, abs=1e-6)
    height = space.history["block.centre_z_m"]
    assert height == pytest.approx(plane.history["block.centre_y_m"], abs=1e-6)
    nothing_from_nothing(space)


@pytest.mark.parametrize("friction", [0.05, 0.7])
@pytest.mark.parametrize("restitution", [0.2, 0.7, 1.0])
def test_nothing_is_gained(restitution: float, friction: float) -> None:
    """Thrown with a spin, landing on its corners and edges, sliding and rocking."""
    thrown = {"velocity": [0.7, 0.3, 1.0], "angular_velocity": [0.5, 1.5, 0.4], "height": 0.4}
    result = simulate(scene(1.0, friction=friction, restitution=restitution, **thrown))
    nothing_from_nothing(result)
    energy = result.history["energy.total_J"]
    assert np.diff(energy).max() < 1e-9 * energy[0]


def test_a_platform_takes_the_impulse_too() -> None:
    """As in the plane; without loss between block and platform for e = 1."""
    under = {"kind": "oscillator", "mass": 503.0, "period": 0.5}
    for restitution in (0.936, 1.0):
        tables = scene(0.6, tilt_deg=3.0, restitution=restitution).to_dict()
        flat = {"dimension": 2, "block": [SIZE | {"tilt_deg": 3.0, "restitution": restitution}]}
        both = [tables, {key: tables[key] for key in ("contact", "time")} | flat]
        space, plane = (simulate(parse_scene(t | {"foundation": under})) for t in both)
        nothing_from_nothing(space)
        for column in ("block.angle_rad", "platform.drift_m"):
            difference = np.abs(space.history[column] - plane.history[column]).max()
            assert difference < 1e-3 * np.abs(plane.history[column]).max()
        if restitution == 1.0:
            lost = space.history["energy.contact_J"][-1]
            assert lost < 1e-6 * space.history["energy.kinetic_J"].max()


@pytest.mark.parametrize("seed", range(9))
def test_nothing_is_gained_at_random(seed: int) -> None:
    """Blocks of all shapes, thrown or tilted, every third with another one on top."""
    random = np.random.default_rng(seed)

    def number(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    def block(**more: Any) -> dict[str, Any]:
        """A block of some size and restitution."""
        size = {"width": number(0.2, 1.0), "thickness": number(0.2, 1.0)}
        return SIZE | size | {"restitution": number(0.05, 1.0)} | more

    thrown = {"velocity": [number(-1.0, 1.0), number(-1.0, 1.0), number(0.2, 1.0)]}
    tilted = {"tilt_deg": number(0.5, 4.0), "tilt_direction_deg": number(0.0, 360.0)}
    blocks = [block(height=number(0.2, 1.2), **(thrown if seed % 2 else tilted))]
    if seed % 3 == 0:
        blocks.append(block(name="upper", on="block", height=0.4, mass=number(20.0, 2000.0)))
    friction = {"friction": float(random.choice([0.0, 0.05, 0.3, 0.8]))}
    tables = scene(0.99).to_dict() | {"block": blocks, "contact": friction}
    result = simulate(parse_scene(tables))
    nothing_from_nothing(result)
    for name in {"block", blocks[-1].get("name", "block")}:
        assert result.history[f"{name}.penetration_m"].max() < 1e-5
