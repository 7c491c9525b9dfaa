"""Stacks of rigid blocks, in the plane and in space: balances, one block made of two, falls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks import random_columns
from geometry.arrangement import Pose, initial_position_in_space, top_of
from geometry.block import Block
from rockslip import Scene, parse_scene
from solver.excitation.motion import read_ground
from solver.rigid.plane.system import PlaneSystem
from solver.rigid.space.system import SpaceSystem
from solver.rigid.system import RigidBlock, RigidSystem
from solver.scene import FrictionSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha

Array = NDArray[np.float64]

G = 9.81
DENSITY = 2000.0
ENGINES: dict[int, type[RigidSystem]] = {2: PlaneSystem, 3: SpaceSystem}

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


def history_of(asked: Scene) -> dict[str, Array]:
    """Columns of all steps; every step had a solution."""
    system, step = ENGINES[asked.dimension].from_scene(asked), asked.time.step
    count, motion = round(asked.time.end / step), read_ground(asked)
    times = np.arange(count + 1) * step
    return columns(system, count, step, motion.accelerations(times), motion.means(times))


def columns(
    system: RigidSystem, count: int, step: float, ground: Any = None, mean: Any = None
) -> dict[str, Array]:
    """Columns of some steps of a system."""
    outcome = system.advance(count, step, ground, mean=mean)
    assert outcome.failure is None
    return dict(zip(system.columns, outcome.rows.T, strict=True))


def checked(history: dict[str, Array], gain: float = 1e-9) -> dict[str, Array]:
    """Total energy grew no more than the ground gave, and the ledger closes."""
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
    history = checked(history_of(scene(2, sizes, friction, 4.0, changes=placed, shake=0.5)))
    weights = [DENSITY * width * height * 0.5 * G for width, height in sizes]
    for i in range(len(sizes)):
        force = history[f"block{i}.normal_force_N"].mean()
        assert force == pytest.approx(sum(weights[i:]), rel=0.02)
        assert history[f"block{i}.penetration_m"].max() < 1e-9


@in_both
def test_contact_forces_balance_momentum(d: int) -> None:
    """Step by step: m dv/dt = weight + inertia of the ground + what the points carry."""
    step, count = 1e-3, 2000 if d == 2 else 400
    placed = [{}, {"offset": 0.02}, {"offset": -0.03}]
    asked = scene(d, THREE, 0.6, 2.0, shake=0.5, changes=placed)
    system, motion = ENGINES[d].from_scene(asked), read_ground(asked)
    ground = np.array([motion.acceleration(step * k) for k in range(count + 1)])
    mass = np.array([block.shape.mass for block in asked.blocks])
    momentum, rows = np.zeros((count + 1, d)), []
    for k in range(count):
        rows.append(system.advance(1, step, ground[k : k + 2]).rows[0])
        momentum[k + 1] = mass @ np.array([system.velocity(b) for b in range(len(mass))])
    column = dict(zip(system.columns, np.array(rows).T, strict=True))
    weight = mass.sum() * G
    # The lowest block stands on the floor; the others pass their forces on to it.
    excess = np.diff(momentum[:, -1]) / step + weight - column["block0.normal_force_N"]
    assert np.abs(excess).max() < 1e-10 * weight
    # Horizontally the ground counts by its mean over the step, cut at impacts or not.
    mean = 0.5 * (ground[:-1, 0] + ground[1:, 0])
    excess = np.diff(momentum[:, 0]) / step + mass.sum() * mean - column["block0.friction_force_N"]
    assert np.abs(excess).max() < 1e-10 * weight


@in_both
def test_a_glued_stack_is_one_block(d: int) -> None:
    """mu = 100 on a platform, too weak a motion to rock: the platform does not notice the joint."""
    platform = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
    end = 3.0 if d == 2 else 0.5
    given: dict[str, Any] = {"foundation": platform, "shake": 0.1}
    two = checked(history_of(scene(d, [(0.5, 0.5), (0.5, 0.5)], 100.0, end, **given)))
    one = checked(history_of(scene(d, [(0.5, 1.0)], 100.0, end, **given)))
    rel = 1e-9 if d == 2 else 1e-4
    for name in ("platform.drift_m", "block0.friction_force_N"):
        assert np.abs(two[name] - one[name]).max() < rel * np.abs(one[name]).max()
    normal = two["block0.normal_force_N"] - one["block0.normal_force_N"]
    assert np.abs(normal).max() < rel * one["block0.normal_force_N"].max()


def test_a_glued_stack_rocks_as_one_block() -> None:
    """Released at 3 degrees: the joint carries moments, the upper block stands on all of it."""
    tilted = [{"tilt_deg": 3.0}, {}]
    two = checked(history_of(scene(2, [(0.25, 0.5), (0.25, 0.5)], 100.0, 1.5, changes=tilted)))
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
    history = checked(history_of(scene(d, [(0.4, 0.6), (0.2, 0.2)], 0.6, 3.0, changes=thrown)))
    assert history["block1.centre_x_m"][-1] > 1.0
    assert history[f"block1.centre_{'yz'[d - 2]}_m"][-1] == pytest.approx(0.1, abs=1e-6)
    for name, size in (("block1", 0.04), ("block0", 0.24)):
        force = history[f"{name}.normal_force_N"][-1]
        assert force == pytest.approx(DENSITY * size * 0.5 * G, rel=1e-6)


TILE = Block(width=0.6, height=0.3, thickness=0.6, density=DENSITY)


def turned_tiles(count: int, yaw: float) -> list[RigidBlock]:
    """Equal blocks on each other, each turned by `yaw` on the lower one."""
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    flat = initial_position_in_space(TILE, (0.0, 0.0), 0.0)
    poses = [flat]
    for _ in range(count - 1):
        turned = Pose(rotation=turn, about=flat.about, place=flat.place)
        poses.append(top_of(poses[-1], TILE.height).after(turned))
    return [
        RigidBlock(
            name=f"block{k}",
            on=f"block{k - 1}" if k else "foundation",
            shape=TILE,
            friction=FrictionSpec(static=0.3),
            pose=pose,
        )
        for k, pose in enumerate(poses)
    ]


@pytest.mark.parametrize(("count", "yaw"), [(2, 0.0), (3, 0.0), (2, 0.1), (2, math.pi / 4)])
def test_turned_stacks_under_shaking(count: int, yaw: float) -> None:
    """Aligned, slightly turned and across: carried, balanced, and without gain."""
    steps, dt = 600, 1e-3
    time = np.arange(steps + 1) * dt
    along = np.sin(2 * np.pi * time / 0.5), 0.5 * np.sin(2 * np.pi * time / 0.37), 0 * time
    system = SpaceSystem(turned_tiles(count, yaw), GeneralizedAlpha(0.8))
    history = checked(columns(system, steps, dt, 0.4 * G * np.stack(along, axis=1)), gain=1e-5)
    for k in range(count):
        normal = history[f"block{k}.normal_force_N"][1:]
        np.testing.assert_allclose(normal, (count - k) * TILE.weight(G), rtol=1e-5)
        assert history[f"block{k}.centre_z_m"][-1] == pytest.approx(0.15 + 0.3 * k, abs=1e-9)
    # The lowest block slides on the floor; those on it, equally rough, do not slide on it.
    assert np.ptp(history["block0.slip_m"]) > 1e-3
    assert np.ptp(history["block1.slip_m"]) < 1e-6


def test_the_system_is_that_of_the_scene() -> None:
    """Blocks, carriers, tilts and the platform are those of the scene."""
    asked = parse_scene(
        {
            "dimension": 3,
            "block": [
                {
                    **{"name": "top", "on": "lower", "model": "rigid", "mass": 10.0},
                    **{"width": 0.2, "height": 0.5, "thickness": 0.3, "friction": 0.4},
                    **{"tilt_deg": 4.0, "tilt_direction_deg": 90.0, "offset": 0.1},
                },
                {
                    **{"name": "lower", "model": "rigid", "mass": 50.0},
                    **{"width": 1.0, "height": 0.25, "thickness": 1.0},
                },
            ],
            "foundation": {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5},
            "time": {"end": 1.0, "step": 1e-3},
        }
    )
    system = SpaceSystem.from_scene(asked)
    assert system.names == ("top", "lower")
    assert system.unknowns == 14
    # It stands on the edge at y = 0.15 and leans towards +y.
    lean = math.radians(4.0)
    arm = np.array([0.0, -0.15 * math.cos(lean) + 0.25 * math.sin(lean), 0.0])
    arm[2] = 0.15 * math.sin(lean) + 0.25 * math.cos(lean)
    np.testing.assert_allclose(system.centre(0), np.array([0.1, 0.15, 0.25]) + arm, atol=1e-14)
    row = dict(zip(system.columns, system.row(1e-3), strict=True))
    assert row["top.gap_3_m"] == pytest.approx(0.0, abs=1e-14)
    assert row["top.gap_1_m"] == pytest.approx(0.3 * math.sin(lean))
    assert row["lower.normal_force_N"] == pytest.approx(60 * G, rel=0.1)
    assert row["energy.ledger_error_J"] == pytest.approx(0.0, abs=1e-12)
    outcome = system.advance(200, 1e-3)
    assert outcome.failure is None
    assert outcome.rows.shape == (200, len(system.columns))


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
    history = history_of(parse_scene(tables))
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
    history = checked(history_of(parse_scene(drums(3, 2.2, 1e-3))))
    scale = history["energy.kinetic_J"].max()
    assert np.diff(history["energy.friction_J"]).min() > -1e-12 * scale
    assert np.ptp(history["drum2.centre_x_m"][-50:]) < 1e-9


@pytest.mark.parametrize("seed", [1, 4])
def test_random_columns(seed: int) -> None:
    """`benchmarks/random_columns.py` has a hundred; these failed before."""
    found = random_columns.run(parse_scene(random_columns.column(seed)), seed)
    assert found["failure"] is None
    assert found["ledger"] < 1e-8
    assert found["friction"] > -1e-12


@in_both
def test_friction_of_a_stack_that_sticks_never_gives_energy_back(d: int) -> None:
    """Drums that rock without any slip."""
    tables = drums(3, 1.5, 1e-3, dimension=d, contact={"friction": 0.9})
    history = checked(history_of(parse_scene(tables)))
    scale = history["energy.kinetic_J"].max()
    assert np.diff(history["energy.friction_J"]).min() > -1e-12 * scale
    assert history["energy.contact_J"][-1] > 1e-3 * scale
