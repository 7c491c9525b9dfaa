"""Rigid blocks in space on a platform and on each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry.arrangement import Pose, initial_position_in_space, on_top
from geometry.block import Block
from rockslip import parse_scene
from solver.rigid.space.system import SpaceSystem
from solver.rigid.system import RigidBlock
from solver.scene import FrictionSpec
from solver.scheme.generalized_alpha import GeneralizedAlpha

Array = NDArray[np.float64]

G = 9.81
TILE = Block(width=0.6, height=0.3, thickness=0.6, density=2000.0)


def stack(
    shape: Block,
    count: int,
    friction: float,
    *,
    yaw: float = 0.0,
    velocity: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> list[RigidBlock]:
    """Equal blocks on each other, each turned by `yaw` on the lower one; the top one is thrown."""
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    flat = initial_position_in_space(shape, (0.0, 0.0), 0.0)
    poses = [flat]
    for _ in range(count - 1):
        turned = Pose(rotation=turn, about=flat.about, place=flat.place)
        poses.append(on_top(poses[-1], shape.height, turned))
    return [
        RigidBlock(
            name=f"block{k}",
            on=f"block{k - 1}" if k else "foundation",
            shape=shape,
            friction=FrictionSpec(static=friction),
            pose=pose,
            velocity=velocity if k == count - 1 else (0.0, 0.0, 0.0),
        )
        for k, pose in enumerate(poses)
    ]


def run(
    system: SpaceSystem, steps: int, dt: float, ground: Array | None = None
) -> dict[str, Array]:
    """Columns of the history by their names."""
    outcome = system.advance(steps, dt, ground)
    assert outcome.failure is None
    return dict(zip(system.columns, outcome.rows.T, strict=True))


def shaking(steps: int, dt: float, size: float) -> Array:
    """Ground that moves along x and y with different periods."""
    time = np.arange(steps + 1) * dt
    along = np.sin(2 * np.pi * time / 0.5), 0.5 * np.sin(2 * np.pi * time / 0.37), 0 * time
    return size * G * np.stack(along, axis=1)


@pytest.mark.parametrize(("count", "yaw"), [(2, 0.0), (3, 0.0), (2, 0.1), (2, math.pi / 4)])
def test_stacks_under_shaking(count: int, yaw: float) -> None:
    """Aligned, slightly turned and across: carried, balanced, and without gain."""
    dt, steps = 1e-3, 600
    system = SpaceSystem(stack(TILE, count, 0.3, yaw=yaw), GeneralizedAlpha(0.8))
    ground = shaking(steps, dt, 0.4)
    history = run(system, steps, dt, ground)
    work = history["energy.input_J"]
    scale = np.abs(np.diff(work)).sum()
    total = history["energy.total_J"]
    assert (total - work - total[0] + work[0]).max() < 1e-5 * scale
    assert np.abs(history["energy.ledger_error_J"]).max() < 1e-9 * scale
    for k in range(count):
        weight = (count - k) * TILE.weight(G)
        normal = history[f"block{k}.normal_force_N"][1:]
        np.testing.assert_allclose(normal, weight, rtol=1e-5)
        assert history[f"block{k}.centre_z_m"][-1] == pytest.approx(0.15 + 0.3 * k, abs=1e-9)
    # The lowest block slides on the floor; those on it, equally rough, do not slide on it.
    assert np.ptp(history["block0.slip_m"]) > 1e-3
    assert np.ptp(history["block1.slip_m"]) < 1e-6


def test_forces_balance_momentum() -> None:
    """Of a sliding stack as a whole: the floor's mean force of a step is m times (dv/dt + a_g)."""
    dt, steps = 1e-3, 300
    system = SpaceSystem(stack(TILE, 2, 0.3, velocity=(0.5, 0.3, 0.0)), GeneralizedAlpha(0.8))
    history = run(system, steps, dt, shaking(steps, dt, 0.0))
    for axis, force in (("x", "friction_force_N"), ("y", "friction_force_second_N")):
        places = np.mean([history[f"block{k}.centre_{axis}_m"] for k in (0, 1)], axis=0)
        # While both slide the same way, forces are constant and velocities differ by them.
        gained = 2 * TILE.mass * np.diff(places, 2)[20:100] / dt**2
        np.testing.assert_allclose(
            history[f"block0.{force}"][21:101], gained, atol=1e-6 * TILE.weight(G)
        )


def test_a_glued_stack_is_one_block() -> None:
    half = Block(width=0.4, height=0.5, thickness=0.5, density=2000.0)
    whole = Block(width=0.4, height=1.0, thickness=0.5, density=2000.0)
    ground = shaking(500, 1e-3, 0.12)
    two = run(SpaceSystem(stack(half, 2, 100.0), GeneralizedAlpha(0.8)), 500, 1e-3, ground)
    one = run(SpaceSystem(stack(whole, 1, 100.0), GeneralizedAlpha(0.8)), 500, 1e-3, ground)
    for name in ("normal_force_N", "friction_force_N", "friction_force_second_N"):
        difference = two[f"block0.{name}"] - one[f"block0.{name}"]
        assert np.abs(difference).max() < 1e-4 * whole.weight(G)
    assert np.abs(two["block1.centre_x_m"]).max() < 1e-10


def test_it_falls_off_its_carrier_and_lands_on_the_floor() -> None:
    tiles = stack(TILE, 2, 0.05, yaw=0.3, velocity=(2.0, 0.5, 0.0))
    system = SpaceSystem(tiles, GeneralizedAlpha(0.8))
    history = run(system, 1500, 1e-3)
    assert history["block1.centre_x_m"][-1] > 1.0
    assert history["block1.centre_z_m"][-1] == pytest.approx(0.15, abs=1e-6)
    assert np.diff(history["energy.total_J"]).max() < 1e-9 * TILE.weight(G)
    assert np.abs(history["energy.ledger_error_J"]).max() < 1e-9 * TILE.weight(G)


def test_from_a_scene() -> None:
    """Blocks, carriers, tilts and the platform are those of the scene."""
    scene = parse_scene(
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
    system = SpaceSystem.from_scene(scene)
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
    """Where its edges cross them, and where it meets the side: contact only takes energy."""
    lower = {"name": "lower", "width": 1.0, "thickness": 1.0, "height": 0.5}
    cube = {"name": "cube", "on": "lower", "width": 0.4, "thickness": 0.4, "height": 0.4}
    placed = {"offset": offsets[0], "offset_second": offsets[1]}
    common = {"model": "rigid", "density": 2400.0}
    scene = {
        "dimension": 3,
        "block": [lower | common, cube | common | placed],
        "contact": {"friction": 0.5},
        "time": {"end": 1.2, "step": 1e-3},
    }
    system = SpaceSystem.from_scene(parse_scene(scene))
    history = run(system, 1200, 1e-3)
    scale = 1e-3 * 2400.0 * 0.4**3 * G * 0.4
    assert np.diff(history["energy.contact_J"]).min() > -1e-6 * scale
    assert np.abs(history["energy.ledger_error_J"]).max() < 1e-8 * scale
    assert history["cube.centre_z_m"][-1] < 0.5
