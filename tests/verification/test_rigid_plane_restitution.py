"""Rigid blocks with a given restitution: rocking as in Housner's equation, and flat landings."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.errors import SceneError
from solver.reference.answer import reference_history
from solver.reference.housner import housner, housner_restitution

#: Impacts (s) and peaks (degrees) of Housner's equation for the paper's block, by restitution.
KNOWN = {
    0.90: ((0.1916, 0.5249, 0.8173, 1.0754), (2.371, 1.886, 1.506)),
    0.936: ((0.1916, 0.5423, 0.8644, 1.1612, 1.4353), (2.586, 2.235, 1.936)),
    0.95: ((0.1916, 0.5492, 0.8837, 1.1972), (2.673, 2.386, 2.133)),
}
SIZE = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "model": "rigid"}


def scene(end: float, step: float = 1e-3, friction: float = 0.7, **block: Any) -> Scene:
    """The paper's block on a rigid floor, with changes."""
    return parse_scene(
        {
            "block": [SIZE | block],
            "contact": {"friction": friction},
            "time": {"end": end, "step": step},
        }
    )


def nothing_from_nothing(result: Result, energy: float = 1e-9) -> None:
    """The run completed, gained no energy, and its ledger closes."""
    assert result.status == "completed"
    assert result.summary["energy"]["largest_gain_fraction"] < energy
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10


def timed(result: Result) -> tuple[list[float], list[float]]:
    """Times of the impacts (s) and sizes of the peaks after the release (rad)."""
    block = result.summary["blocks"]["block"]
    times = [impact["time_s"] for impact in block["impacts"]]
    return times, [abs(peak["angle_rad"]) for peak in block["peaks"][1:]]


@pytest.mark.parametrize("step", [1e-3, 2e-4])
@pytest.mark.parametrize("restitution", [0.5, 0.90, 0.936, 0.95, 1.0])
def test_rocking_is_that_of_the_ode(restitution: float, step: float) -> None:
    """Below and above the 0.9118 of the plastic impact, with the times and peaks of the ODE."""
    asked = scene(1.5, step, tilt_deg=3.0, restitution=restitution)
    result = simulate(asked)
    times, peaks = timed(result)
    exact = housner(
        asked.blocks[0].shape,
        gravity=9.81,
        tilt=math.radians(3.0),
        end=1.5,
        step=step,
        restitution=restitution,
    )
    count = min(4, len(exact.impacts))
    assert times[:count] == pytest.approx(exact.impacts[:count], rel=3e-5)
    assert peaks[: count - 1] == pytest.approx(np.abs(exact.peaks[1:count]), rel=3e-4)
    if restitution in KNOWN:
        impacts, turns = KNOWN[restitution]
        assert times[: len(impacts)] == pytest.approx(impacts, rel=3e-4)
        assert np.degrees(peaks[:3]) == pytest.approx(turns, rel=1e-3)
    assert abs(result.history["block.slip_m"]).max() < 1e-9
    nothing_from_nothing(result)


def test_housners_own_value_changes_nothing() -> None:
    """With 1 - 1.5 sin^2 alpha it rocks as without one, whose impacts take a piece of a step."""
    free = scene(1.0, tilt_deg=3.0)
    given = scene(1.0, tilt_deg=3.0, restitution=housner_restitution(free.blocks[0].shape))
    angles = [simulate(asked).history["block.angle_rad"] for asked in (free, given)]
    assert np.abs(angles[0] - angles[1]).max() < 1e-6


@pytest.mark.parametrize("part", np.linspace(-2e-3, 2e-3, 9))
def test_impacts_at_the_very_end_of_a_step_are_not_missed(part: float) -> None:
    """Steps that end so short before or after the impact that the step is not cut there."""
    exact = housner(
        scene(1.0).blocks[0].shape,
        gravity=9.81,
        tilt=math.radians(3.0),
        end=0.6,
        step=1e-3,
        restitution=0.95,
    )
    step = exact.impacts[0] / (192 + part)
    result = simulate(scene(0.6, step, tilt_deg=3.0, restitution=0.95))
    assert timed(result)[0][:2] == pytest.approx(exact.impacts[:2], rel=3e-5)
    landing = 0.25 * 0.47  # B omega at the impact, m/s
    assert result.history["block.penetration_m"].max() < 1e-3 * step * landing
    nothing_from_nothing(result)


def test_an_impact_loses_what_the_angular_velocity_loses() -> None:
    """energy.contact_J falls by (1 - e^2) of the kinetic energy before the impact."""
    asked = scene(0.3, tilt_deg=3.0, restitution=0.936)
    shape, history = asked.blocks[0].shape, simulate(asked).history
    fall = 503.0 * 9.81 * shape.half_diagonal
    fall *= math.cos(shape.slenderness - math.radians(3.0)) - math.cos(shape.slenderness)
    assert history["energy.contact_J"][-1] == pytest.approx((1 - 0.936**2) * fall, rel=1e-6)


def test_the_reference_takes_it() -> None:
    """`rockslip reference` solves Housner's equation with the block's restitution."""
    asked = scene(0.7, tilt_deg=3.0, restitution=0.95)
    angle = simulate(asked).history["block.angle_rad"]
    assert np.abs(angle - reference_history(asked)["block.angle_rad"]).max() < 2e-5


@pytest.mark.parametrize("restitution", [0.3, 0.8, 1.0])
@pytest.mark.parametrize("step", [1e-3, 7e-4])
def test_a_flat_landing_rebounds(restitution: float, step: float) -> None:
    """Thrown up at 1 m/s it lands with 1 m/s and rises to e^2 of the height, time and again."""
    asked = scene(0.7, step, velocity=[0.0, 1.0], restitution=restitution)
    result = simulate(asked)
    height, time = result.history["block.gap_left_m"], result.history["time_s"]
    flight, start, top = 2 / 9.81, 0.0, 0.5 / 9.81
    while start + flight < 0.7 and flight > 20 * step:
        inside = (time > start) & (time < start + flight)
        assert height[inside].max() == pytest.approx(top, rel=1e-2, abs=9.81 * step**2)
        since = time[inside] - start
        exact = since * (9.81 * flight / 2 - 9.81 * since / 2)
        assert height[inside] == pytest.approx(exact, abs=1e-6)
        start, flight, top = start + flight, restitution * flight, restitution**2 * top
    assert np.abs(result.history["block.angle_rad"]).max() < 1e-12
    nothing_from_nothing(result)


def test_it_comes_to_rest() -> None:
    """Rebounds that no step resolves any more end: it stands, and bears its weight."""
    result = simulate(scene(1.5, velocity=[0.0, 1.0], restitution=0.7))
    assert abs(result.history["block.gap_left_m"][-1]) < 1e-9
    assert result.history["block.normal_force_N"][-1] == pytest.approx(503.0 * 9.81, rel=1e-9)
    nothing_from_nothing(result)


def test_a_sliding_flat_landing_has_coulombs_friction() -> None:
    """Impulses (1 + e) m v upwards and mu times that against the slip."""
    asked = scene(0.3, friction=0.05, velocity=[1.0, 1.0], restitution=0.6, height=0.1)
    result = simulate(asked)
    history = result.history
    speed = np.diff(history["block.centre_x_m"]) / 1e-3
    assert speed[240] == pytest.approx(1.0 - 0.05 * 1.6, abs=2e-3)
    nothing_from_nothing(result)


@pytest.mark.parametrize("friction", [0.05, 0.2, 0.7])
@pytest.mark.parametrize("restitution", [0.2, 0.7, 1.0])
def test_nothing_is_gained(restitution: float, friction: float) -> None:
    """Thrown with a spin, landing on its corners, sliding and rocking."""
    thrown = {"velocity": [0.7, 1.0], "angular_velocity": 1.5, "height": 0.4}
    result = simulate(scene(1.0, friction=friction, restitution=restitution, **thrown))
    nothing_from_nothing(result)
    energy = result.history["energy.total_J"]
    assert np.diff(energy).max() < 1e-9 * energy[0]


def on_a_platform(restitution: float) -> Result:
    """A rocking block on a platform of its own mass."""
    tables = scene(0.6, tilt_deg=3.0, restitution=restitution).to_dict()
    tables["foundation"] = {"kind": "oscillator", "mass": 503.0, "period": 0.5}
    return simulate(parse_scene(tables))


def test_a_platform_takes_the_impulse_too() -> None:
    """The ledger closes; without loss between block and platform for e = 1."""
    nothing_from_nothing(on_a_platform(0.936))
    elastic = on_a_platform(1.0)
    nothing_from_nothing(elastic)
    history = elastic.history
    assert history["energy.contact_J"][-1] < 1e-6 * history["energy.kinetic_J"].max()


def test_a_stack_rebounds_from_its_foundation() -> None:
    """The lower block of two rebounds; both obey contact, and nothing is gained."""
    upper = {"name": "upper", "on": "lower", "width": 0.2, "height": 0.4, "mass": 100.0}
    lower = {"name": "lower", "restitution": 0.95, "tilt_deg": 3.0}
    tables = scene(1.0).to_dict() | {"block": [SIZE | lower, SIZE | upper]}
    result = simulate(parse_scene(tables))
    nothing_from_nothing(result)
    assert result.history["upper.penetration_m"].max() < 1e-9


@pytest.mark.parametrize("seed", range(12))
def test_nothing_is_gained_at_random(seed: int) -> None:
    """Blocks of all shapes, thrown or tilted, every third with another one on top."""
    random = np.random.default_rng(seed)

    def block(**more: Any) -> dict[str, Any]:
        """A block of some width and restitution."""
        width, ratio = (float(random.uniform(*ends)) for ends in ((0.2, 1.0), (0.05, 1.0)))
        return SIZE | {"width": width, "restitution": ratio} | more

    thrown = {"velocity": [float(random.uniform(-1, 1)), float(random.uniform(0.2, 1))]}
    start = thrown if seed % 2 else {"tilt_deg": float(random.uniform(0.5, 4))}
    blocks = [block(height=float(random.uniform(0.2, 1.2)), **start)]
    if seed % 3 == 0:
        mass = float(random.uniform(20, 2000))
        blocks.append(block(name="upper", on="block", height=0.4, mass=mass))
    friction = {"friction": float(random.choice([0.0, 0.05, 0.3, 0.8]))}
    tables = scene(0.99).to_dict() | {"block": blocks, "contact": friction}
    result = simulate(parse_scene(tables))
    nothing_from_nothing(result)
    assert result.history["block.penetration_m"].max() < 1e-6


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
        scene(1.0, **({"restitution": 0.9} | changes))
    assert message in str(caught.value)


def test_refused_scenes() -> None:
    """Beside a mesh."""
    tables = scene(1.0, restitution=0.9).to_dict()
    plate = {"kind": "elastic", "width": 1.0, "height": 0.2, "density": 2.7e3, "young": 5e10}
    words = r"^block\.restitution applies to scenes in which nothing is meshed"
    with pytest.raises(SceneError, match=words):
        parse_scene(tables | {"foundation": plate | {"poisson": 0.2, "support": "bottom"}})
