"""Stacks of rigid blocks, in the plane and in space: balances, one block made of two, falls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from rigid import G

from rockslip import History, Scene, parse_scene, simulate

Array = NDArray[np.float64]

DENSITY = 2000.0

Size = tuple[float, float]
TWO: list[Size] = [(0.4, 0.6), (0.35, 0.5)]
EQUAL: list[Size] = [(0.4, 0.6), (0.4, 0.6)]
THREE: list[Size] = [(0.4, 0.6), (0.3, 0.5), (0.3, 0.4)]
WIDE: list[Size] = [(0.4, 0.4), (0.6, 0.3)]

in_both = pytest.mark.parametrize("d", [2, 3])


def scene(d: int, sizes: list[Size], friction: float, end: float, **tables: Any) -> Scene:
    """Blocks on one another, in steps of 1 ms; `changes` of each, shaken by `shake` g at 2 Hz."""
    changes = tables.pop("changes", [{}] * len(sizes))
    if shake := tables.pop("shake", 0.0):
        tables["motion"] = {"kind": "sine", "amplitude_g": shake, "period": 0.5, "cycles": 6}
    blocks = [
        {
            "name": f"block{i}",
            "on": f"block{i - 1}" if i else "foundation",
            "width": width,
            "height": height,
            "thickness": 0.5,
            "density": DENSITY,
            "model": "rigid",
        }
        | change
        for i, ((width, height), change) in enumerate(zip(sizes, changes, strict=True))
    ]
    time = {"end": end, "step": 1e-3}
    contact = {"friction": friction}
    given = {"block": blocks[::-1], "contact": contact, "time": time}  # in any order
    return parse_scene({"dimension": d} | given | tables)


def history_of(given: Scene, gain: float = 1e-9) -> History:
    """History of a run: no more energy than the ground gave, and the ledger closes."""
    result = simulate(given)
    assert result.status == "completed", result.summary["reason"]
    history = result.history
    moved = np.abs(np.diff(history["energy.input_J"])).sum()
    scale = moved + np.ptp(history["energy.gravity_J"]) + history["energy.kinetic_J"].max()
    own = history["energy.total_J"] - history["energy.input_J"]
    assert np.diff(own).max() < gain * scale
    assert np.abs(history["energy.ledger_error_J"]).max() < 1e-8 * scale
    return history


@pytest.mark.parametrize("friction", [0.15, 0.6, 10.0])
@pytest.mark.parametrize(
    ("sizes", "offsets"),
    [(TWO, [0, 0]), (EQUAL, [0, 0]), (THREE, [0, 0.02, -0.03]), (WIDE, [0, 0.05])],
    ids=["two", "equal", "three", "wide"],
)
def test_energy_does_not_rise(sizes: list[Size], offsets: list[float], friction: float) -> None:
    """Rocking, sliding and both, under 0.5 g; on average the weight is where it should be."""
    placed = [{"offset": offset} for offset in offsets]
    history = history_of(scene(2, sizes, friction, 4.0, changes=placed, shake=0.5))
    weights = [DENSITY * width * height * 0.5 * G for width, height in sizes]
    for i in range(len(sizes)):
        force = history[f"block{i}.normal_force_N"].mean()
        assert force == pytest.approx(sum(weights[i:]), rel=0.02)
        assert history[f"block{i}.penetration_m"].max() < 1e-9


@in_both
def test_impulses_of_contact_balance_momentum(d: int) -> None:
    """Shaken, then at rest again: impulses of weight, ground and floor cancel to round-off.

    A force in a row is the mean over its step, cut at impacts or not.
    """
    given = scene(d, WIDE, 0.8, 1.5, changes=[{}, {"offset": 0.05}]).to_dict()
    given["motion"] = {"kind": "half_sine", "amplitude_g": 1.2, "duration": 0.15}
    history = history_of(parse_scene(given))
    assert history["energy.kinetic_J"][-1] < 1e-12
    assert history["energy.contact_J"][-1] > 0.1
    mass = sum(DENSITY * width * height * 0.5 for width, height in WIDE)
    assert history["block0.normal_force_N"][1:].mean() == pytest.approx(mass * G, rel=1e-9)
    pushed = history["block0.friction_force_N"][1:].sum() * 1e-3
    assert pushed == pytest.approx(mass * 1.2 * G * 0.15 * 2 / math.pi, rel=1e-4)


@in_both
def test_a_glued_stack_is_one_block(d: int) -> None:
    """mu = 100 on a platform, too weak a motion to rock: the platform does not notice the joint."""
    platform = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
    end = 3.0 if d == 2 else 0.5
    given: dict[str, Any] = {"foundation": platform, "shake": 0.1}
    two = history_of(scene(d, [(0.5, 0.5), (0.5, 0.5)], 100.0, end, **given))
    one = history_of(scene(d, [(0.5, 1.0)], 100.0, end, **given))
    rel = 1e-9 if d == 2 else 1e-4
    for name in ("platform.drift_m", "block0.friction_force_N"):
        assert np.abs(two[name] - one[name]).max() < rel * np.abs(one[name]).max()
    normal = two["block0.normal_force_N"] - one["block0.normal_force_N"]
    assert np.abs(normal).max() < rel * one["block0.normal_force_N"].max()


def test_a_glued_stack_rocks_as_one_block() -> None:
    """Released at 3 degrees: the joint carries moments, the upper block stands on all of it."""
    tilted = [{"tilt_deg": 3.0}, {}]
    two = history_of(scene(2, [(0.25, 0.5), (0.25, 0.5)], 100.0, 1.5, changes=tilted))
    one = history_of(scene(2, [(0.25, 1.0)], 100.0, 1.5, changes=tilted[:1]))
    first = one["time_s"] < 0.5
    for name in ("block0.angle_rad", "block1.angle_rad"):
        difference = two[name] - one["block0.angle_rad"]
        assert np.abs(difference[first]).max() < 1e-7
        assert np.abs(difference).max() < 1e-4


@in_both
def test_a_block_slides_off_its_carrier_and_comes_to_rest_on_the_floor(d: int) -> None:
    """It leaves with 2 m/s, tips over the edge, and lies on the floor in the end."""
    velocity = [2.0, 0.0] if d == 2 else [2.0, 0.3, 0.0]
    thrown = [{}, {"velocity": velocity, "friction": 0.2, "offset": 0.1, "thickness": 0.5}]
    history = history_of(scene(d, [(0.4, 0.6), (0.2, 0.2)], 0.6, 3.0, changes=thrown))
    assert history["block1.centre_x_m"][-1] > 1.0
    assert history[f"block1.centre_{'yz'[d - 2]}_m"][-1] == pytest.approx(0.1, abs=1e-6)
    for name, size in (("block1", 0.04), ("block0", 0.24)):
        force = history[f"{name}.normal_force_N"][-1]
        assert force == pytest.approx(DENSITY * size * 0.5 * G, rel=1e-6)


@in_both
@pytest.mark.parametrize("share", [0.99, 1.01])
@pytest.mark.parametrize(("offset", "shared"), [(0.05, 0.3), (0.15, 0.2)])
def test_cohesion_holds_the_face_that_both_blocks_share(
    offset: float, shared: float, share: float, d: int
) -> None:
    """On an incline without friction: the upper block stays up to c A, and slides above it."""
    down = DENSITY * 0.3 * 0.02 * 0.5 * G * math.sin(math.radians(10.0))
    law = {"static": 0.0, "cohesion": down / (share * shared * 0.5)}
    changes = [{"friction": 10.0}, {"offset": offset, "friction": law}]
    sizes = [(0.4, 0.6), (0.3, 0.02)]
    slip = simulate(scene(d, sizes, 0.0, 0.1, changes=changes, gravity_tilt_deg=10.0)).history
    assert (abs(slip["block1.slip_m"][-1]) > 1e-5) == (share > 1.0)


TILE = {"model": "rigid", "width": 0.6, "thickness": 0.6, "height": 0.3, "density": DENSITY}
TILES = [TILE | {"name": f"tile{k}"} | ({"on": f"tile{k - 1}"} if k else {}) for k in range(3)]


def tiles(count: int, spin: float, end: float) -> History:
    """Equal tiles on each other, of which the highest turns at first, shaken both ways."""
    blocks = [*TILES[: count - 1], TILES[count - 1] | {"angular_velocity": [0.0, 0.0, spin]}]
    second = {"kind": "sine", "amplitude_g": 0.2, "period": 0.37, "start": 0.2}
    motion = {"kind": "sine", "amplitude_g": 0.4, "period": 0.5, "start": 0.2, "second": second}
    return history_of(
        parse_scene(
            {"dimension": 3, "block": blocks, "contact": {"friction": 0.3}, "motion": motion}
            | {"time": {"end": end, "step": 1e-3}}
        ),
        gain=1e-5,
    )


@pytest.mark.parametrize(("count", "spin"), [(3, 0.0), (2, 2.0), (2, 8.0)])
def test_turned_stacks_under_shaking(count: int, spin: float) -> None:
    """Aligned, slightly turned and across: carried, balanced, and without gain."""
    history, last = tiles(count, spin, 0.9), count - 1
    assert (abs(history[f"tile{last}.angle_z_rad"][-1]) > 0.01 * spin) or spin == 0.0
    for k in range(count):
        normal = history[f"tile{k}.normal_force_N"][1:]
        weight = DENSITY * 0.6 * 0.6 * 0.3 * G
        np.testing.assert_allclose(normal, (count - k) * weight, rtol=1e-5)
        assert history[f"tile{k}.centre_z_m"][-1] == pytest.approx(0.15 + 0.3 * k, abs=1e-9)
    # The lowest slides on the floor; those on it, equally rough, do not slide on it.
    assert np.ptp(history["tile0.slip_m"]) > 1e-3
    if not spin:
        assert np.ptp(history["tile1.slip_m"]) < 1e-6


@pytest.mark.parametrize("offsets", [(0.52, 0.5), (0.503, 0.35), (0.51, 0.45)])
def test_a_cube_tips_over_the_edges_of_what_carries_it(offsets: tuple[float, float]) -> None:
    """Its edges cross them, and it meets the side: contact only takes energy."""
    lower = {"name": "lower", "width": 1.0, "thickness": 1.0, "height": 0.5}
    cube = {"name": "cube", "on": "lower", "width": 0.4, "thickness": 0.4, "height": 0.4}
    placed = {"offset": offsets[0], "offset_second": offsets[1]}
    common = {"model": "rigid", "density": 2400.0}
    tables = {
        "dimension": 3,
        "block": [lower | common, cube | common | placed],
        "contact": {"friction": 0.5},
        "time": {"end": 1.2, "step": 1e-3},
    }
    history = simulate(parse_scene(tables)).history
    scale = 1e-3 * 2400.0 * 0.4**3 * G * 0.4
    assert np.diff(history["energy.contact_J"]).min() > -1e-6 * scale
    assert np.abs(history["energy.ledger_error_J"]).max() < 1e-8 * scale
    assert history["cube.centre_z_m"][-1] < 0.5


def drums(count: int, end: float, step: float, **changes: Any) -> dict[str, Any]:
    """Drums of stone on each other that a Ricker wavelet rocks; they come to rest after 2 s."""
    shape = {"model": "rigid", "width": 0.5, "thickness": 0.5, "height": 0.414, "density": 2600.0}
    blocks = [{"name": f"drum{k}", **shape} for k in range(count)]
    for k in range(1, count):
        blocks[k]["on"] = f"drum{k - 1}"
    return {
        "dimension": 3,
        "block": blocks,
        "contact": {"friction": 0.6},
        "motion": {"kind": "ricker", "amplitude_g": 0.57, "frequency": 1.96},
        "time": {"end": end, "step": step},
    } | changes


def test_drums_rock_to_rest() -> None:
    """A step is cut at an impact; what points hold of each other stays what it was."""
    history = history_of(parse_scene(drums(3, 2.2, 1e-3)))
    scale = history["energy.kinetic_J"].max()
    assert np.diff(history["energy.friction_J"]).min() > -1e-12 * scale
    assert np.ptp(history["drum2.centre_x_m"][-50:]) < 1e-9


def test_a_column_of_unequal_drums_in_long_steps() -> None:
    """Two wavelets aslant to each other, steps of 5 ms; one of many random columns: it failed."""
    unequal = {
        "width": (0.92316, 0.80954, 0.95557, 0.93970, 0.87513),
        "height": (0.91572, 0.81621, 0.76290, 0.59446, 1.26559),
        "density": (1974.53, 2702.22, 2588.95, 2768.93, 2408.85),
    }
    tables = drums(5, 3.0, 5e-3, contact={"friction": 0.43426})
    for k, block in enumerate(tables["block"]):
        block |= {"thickness": 0.86527} | {key: values[k] for key, values in unequal.items()}
    wavelet = {"kind": "ricker", "amplitude_g": 0.66596, "frequency": 1.09347}
    second = {"kind": "ricker", "amplitude_g": 0.55016, "frequency": 2.90888}
    history = history_of(parse_scene(tables | {"motion": wavelet | {"second": second}}))
    scale = history["energy.kinetic_J"].max()
    assert np.diff(history["energy.friction_J"]).min() > -1e-12 * scale


@in_both
def test_friction_of_a_stack_that_sticks_never_gives_energy_back(d: int) -> None:
    """Drums that rock without any slip."""
    tables = drums(3, 1.5, 1e-3, dimension=d, contact={"friction": 0.9})
    history = history_of(parse_scene(tables))
    scale = history["energy.kinetic_J"].max()
    assert np.diff(history["energy.friction_J"]).min() > -1e-12 * scale
    assert history["energy.contact_J"][-1] > 1e-3 * scale
