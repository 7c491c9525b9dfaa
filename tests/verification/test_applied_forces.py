"""Forces on blocks, rigid and elastic: statics, impulses, and wind on containers."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from ledger import completed as run
from rigid import G, scene

from rockslip import SceneError, parse_scene, simulate

SLENDER = {"model": "rigid", "width": 0.5, "height": 2.0, "thickness": 0.5, "mass": 500.0}
WEIGHT = 500.0 * G
CONTAINER = {"model": "rigid", "container": "20ft", "load": "empty"}


def push(d: int, along: float, up: float, **more: Any) -> dict[str, Any]:
    """A force in the plane of x and upwards."""
    return {"on": "block", "force": [along, *[0.0] * (d - 2), up]} | more


@pytest.mark.parametrize("d", [2, 3])
def test_a_block_at_rest_takes_a_force_to_the_ground(d: int) -> None:
    history = run(scene(d, SLENDER, end=0.2, force=[push(d, 800.0, -500.0)])).history
    assert history["block.normal_force_N"] == pytest.approx(WEIGHT + 500.0, rel=1e-9)
    assert history["block.friction_force_N"] == pytest.approx(-800.0, rel=1e-9)
    assert history["energy.input_J"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("height", "lifts"), [(1.5, 0.25 / 1.5), (2.0, 0.125), (0.5, 0.5)])
def test_a_ramped_force_lifts_the_block_where_its_moment_is_that_of_the_weight(
    height: float, lifts: float
) -> None:
    """At m g B/(2 h), h being the height of the force."""
    force = push(2, 0.6 * WEIGHT, 0.0, at=[0.0, height], ramp=[1.0, 11.0])
    history = run(scene(2, SLENDER, end=11.0, friction=2.0, force=[force])).history
    first = history["time_s"][np.flatnonzero(history["block.gap_left_m"] > 1e-9)[0]]
    assert 0.06 * (first - 1.0) == pytest.approx(lifts, abs=6e-4)


def test_impulses_of_a_table_are_the_momentum() -> None:
    """Of a block without friction; its work is its energy."""
    rows = [[0.1, 0.0], [0.3, 1.0], [0.5, -0.5], [0.6, 0.0]]
    slick = SLENDER | {"friction": 0.0, "height": 0.2}
    result = run(scene(2, slick, end=1.0, friction=0.0, force=[push(2, 300.0, 0.0, table=rows)]))
    history = result.history
    for n in (300, 500, 1000):
        time = history["time_s"][: n + 1]
        impulse = 300.0 * np.trapezoid(np.interp(time, *np.transpose(rows)), time)
        speed = np.diff(history["block.centre_x_m"])[n - 2 : n].mean() / 1e-3
        if n == 1000:
            assert speed == pytest.approx(impulse / 500.0, rel=1e-9)
        else:
            assert speed == pytest.approx(impulse / 500.0, abs=1e-3)
    kinetic = history["energy.kinetic_J"][-1]
    assert history["energy.input_J"][-1] == pytest.approx(kinetic, rel=1e-9)


def test_forces_turn_with_nothing_and_act_where_the_block_takes_them() -> None:
    """A couple on a free block: it spins faster, then slower, and stays where it is."""
    free = SLENDER | {"position": [0.0, 5.0]}
    ends = [
        push(2, sign * 100.0, 0.0, name=name, at=[0.0, height])
        for name, sign, height in (("top", 1.0, 2.0), ("bottom", -1.0, 0.0))
    ]
    history = run(scene(2, free, end=3.0, gravity=0.0, force=ends)).history
    assert np.ptp(history["block.centre_x_m"]) < 1e-12
    inertia = 500.0 * (0.25 + 4.0) / 12
    spin, angle = history["block.angular_velocity_rad_s"], history["block.angle_rad"]
    # A couple 2 F (H/2) cos(theta) about the centre: I theta'^2/2 = F H sin(theta).
    assert 0.5 * inertia * spin**2 == pytest.approx(200.0 * np.sin(angle), abs=1e-3)
    assert angle.max() > 1.5


@pytest.mark.parametrize(
    ("d", "face", "expected"),
    [
        (2, "left", [1.0 * 2.0 * 0.5, 0.0]),
        (2, "right", [-1.0, 0.0]),
        (2, "top", [0.0, -0.25]),
        (3, "front", [0.0, 1.0, 0.0]),
        (3, "back", [0.0, -1.0, 0.0]),
        (3, "bottom", [0.0, 0.0, 0.25]),
        (3, "left", [1.0, 0.0, 0.0]),
    ],
)
def test_a_pressure_pushes_on_its_face(d: int, face: str, expected: list[float]) -> None:
    """By its area: 2 m high, 0.5 m wide and thick."""
    given = SLENDER | {"position": [*[0.0] * (d - 1), 5.0]}
    wind = {"on": "block", "face": face, "pressure": 700.0}
    history = run(scene(d, given, end=0.1, gravity=0.0, force=[wind])).history
    axes = "xyz"[:d]
    moved = [history[f"block.centre_{axis}_m"][-1] for axis in axes]
    start = [history[f"block.centre_{axis}_m"][0] for axis in axes]
    way = 0.5 * 700.0 / 500.0 * 0.1**2
    assert np.subtract(moved, start) == pytest.approx(way * np.array(expected), abs=1e-12)
    assert np.abs(history["block.angle_rad"]).max() < 1e-14


def test_a_pressure_is_normal_to_the_face_of_a_tilted_block() -> None:
    given = SLENDER | {"position": [0.0, 5.0], "tilt_deg": 30.0}
    wind = {"on": "block", "face": "left", "pressure": 700.0}
    history = run(scene(2, given, end=0.1, gravity=0.0, force=[wind])).history
    way = 0.5 * 700.0 / 500.0 * 0.1**2
    x, y = (history[f"block.centre_{axis}_m"][-1] for axis in "xy")
    tilt = math.radians(30.0)
    assert (x, y - 5.0) == pytest.approx((way * math.cos(tilt), -way * math.sin(tilt)), rel=1e-9)


# ------------------------------------------------------------------ wind on containers


def pressure(speed: float) -> float:
    """C rho v²/2 with C = 1.2 and rho = 1.25 kg/m³, Pa."""
    return 1.2 * 1.25 * speed**2 / 2


def locked(count: int) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Empty containers of 20 feet on one another, and the locks between them."""
    names = ["foundation", *(f"box{k}" for k in range(count))]
    boxes = [CONTAINER | {"name": name, "on": below} for below, name in pairwise(names)]
    lock = {"kind": "twist-lock", "stiffness": 1e8, "damping": 1e5}
    locks = [
        lock | {"name": f"{upper}{side}", "between": [lower, upper], "at": [x, 2.591]}
        for lower, upper in pairwise(names[1:])
        for side, x in (("left", -1.219), ("right", 1.219))
    ]
    return boxes, locks


@pytest.mark.parametrize(
    ("count", "speed", "mode"),
    [(1, 27.6, "rest"), (1, 27.8, "slide"), (4, 21.1, "rest"), (4, 21.4, "overturned")],
)
def test_wind_moves_empty_containers(count: int, speed: float, mode: str) -> None:
    """One slides at 27.7 m/s with friction 0.4; four that are locked topple at 21.2 m/s."""
    boxes, locks = locked(count)
    wind = {"face": "left", "pressure": pressure(speed), "ramp": [0.0, 10.0]}
    forces = [wind | {"name": f"wind{k}", "on": box["name"]} for k, box in enumerate(boxes)]
    time = {"end": 40.0, "step": 4e-3, "stop": "overturned"}
    given = scene(2, *boxes, end=40.0, friction=0.4, force=forces, link=locks, time=time)
    result = run(given)
    assert result.summary["blocks"]["box0"]["mode"] == mode


def test_the_speeds_are_those_of_statics() -> None:
    side, weight = 6.058 * 2.591, 2300.0 * G
    slides = math.sqrt(0.4 * weight / (0.5 * 1.2 * 1.25 * side))
    topples = math.sqrt(weight * 2.438 / 2 / (2 * 2.591) / (0.5 * 1.2 * 1.25 * side))
    assert slides == pytest.approx(27.7, abs=0.05)
    assert topples == pytest.approx(21.2, abs=0.05)


@pytest.mark.parametrize("model", ["rigid", "elastic"])
def test_wind_on_a_box_with_feet_acts_in_the_middle_of_the_box(model: str) -> None:
    """The face of the box alone, 0.1 m higher than without feet: F (h/2 + 0.1) tips m g b.

    An elastic block has a little less arm, as it bends; its feet have a thousandth of its density.
    """
    if model == "elastic":
        pytest.importorskip("dolfinx")
    width, height, foot, mass = 0.6, 2.0, 0.1, 300.0
    area, arm = height * 1.0, height / 2 + foot
    limit = mass * 9.81 * width / 2 / (area * arm)
    for factor, falls in ((0.995, False), (1.005, True)):
        tables = {
            "block": [
                {
                    "name": "cabinet",
                    "model": model,
                    "young": 1e10,
                    "poisson": 0.2,
                    "width": width,
                    "height": height,
                    "mass": mass,
                    "friction": 2.0,
                    "feet": {"size": 0.05, "height": foot},
                }
            ],
            "force": [{"on": "cabinet", "pressure": factor * limit, "face": "left"}],
            "time": {"end": 2.0, "step": 2e-3},
        }
        result = simulate(parse_scene(tables))
        assert bool(np.abs(result.history["cabinet.angle_rad"]).max() > 0.01) == falls


def test_a_pressure_needs_the_face_of_a_box() -> None:
    tables = {
        "block": [
            {
                "name": "drum",
                "model": "rigid",
                "shape": {"regular": 12},
                "width": 1.0,
                "mass": 1.0,
            }
        ],
        "force": [{"on": "drum", "pressure": 100.0, "face": "left"}],
        "time": {"end": 1.0, "step": 1e-2},
    }
    with pytest.raises(SceneError, match=r"pressure applies to boxes; drum has a shape"):
        parse_scene(tables)


@pytest.mark.parametrize("step", [2e-3, 0.03, 0.3])
def test_no_impulse_of_a_force_goes_missing_between_steps(step: float) -> None:
    """Two pulses of 0.04 N s in all, one shorter than a step: v = J/m to round-off, and the work of
    the input is the kinetic energy."""
    course = [[0.0, 0.0], [0.1013, 0.0], [0.1021, 20.0], [0.1029, 0.0]]
    course += [[0.3307, 0.0], [0.3507, 1.0], [0.3557, 3.0], [0.3659, 0.0]]
    impulse = sum((b - a) * (f + g) / 2 for (a, f), (b, g) in pairwise(course))
    push = {"name": "push", "on": "block", "force": [5.0, 0.0], "table": course}
    block = {"model": "rigid", "width": 1.0, "height": 1.0, "mass": 2.0, "position": [0.0, 5.0]}
    tables = {"block": [block], "force": [push], "gravity": 0.0}
    result = simulate(parse_scene(tables | {"time": {"end": 0.9, "step": step}}))
    history = result.history
    speed = (history["block.centre_x_m"][-1] - history["block.centre_x_m"][-2]) / step
    assert speed == pytest.approx(5.0 * impulse / 2.0, rel=1e-12)
    assert history["energy.input_J"][-1] == pytest.approx(speed**2, rel=1e-12)


# ------------------------------------------------------------------ elastic blocks

STONE = {"young": 5e10, "poisson": 0.2, "damping": {"stiffness": 0.0}}
CELLS = {2: [2, 4], 3: [2, 2, 3]}


def elastic(d: int, block: dict[str, Any]) -> dict[str, Any]:
    """A rigid block as an elastic one."""
    return {"cells": CELLS[d]} | STONE | block | {"model": "elastic"}


@pytest.mark.parametrize("d", [2, 3])
def test_an_elastic_block_starts_in_equilibrium_with_what_pushes_it(d: int) -> None:
    """As on an incline, the start finds the directions of friction to 1e-5."""
    pytest.importorskip("dolfinx")
    given = scene(d, elastic(d, SLENDER), end=0.05, force=[push(d, 800.0, -500.0)])
    history = run(given, gain=1e-8).history
    assert history["block.normal_force_N"] == pytest.approx(WEIGHT + 500.0, rel=1e-5)
    assert history["block.friction_force_N"] == pytest.approx(-800.0, rel=1e-5)
    assert history["energy.input_J"] == pytest.approx(0.0, abs=1e-8)
    assert history["energy.kinetic_J"] == pytest.approx(0.0, abs=1e-10)


def test_an_elastic_block_that_is_pushed_too_hard_slides_from_the_start() -> None:
    pytest.importorskip("dolfinx")
    block = elastic(2, SLENDER)
    given = scene(2, block, end=0.5, step=4e-3, friction=0.1, force=[push(2, 800.0, 0.0)])
    slip = run(given).history["block.slip_m"][-1]
    assert slip == pytest.approx(0.5 * (800.0 - 0.1 * WEIGHT) / 500.0 * 0.5**2, rel=1e-3)


@pytest.mark.parametrize("at", [None, [0.0, 1.0], [0.25, 0.7]])
def test_impulses_on_an_elastic_block_are_its_momentum(at: list[float] | None) -> None:
    """Whose centre moves as that of a rigid one; work is the change of all energy."""
    pytest.importorskip("dolfinx")
    rows = [[0.1, 0.0], [0.13, 1.0], [0.2, -0.5], [0.31, 0.0]]
    free = elastic(2, SLENDER) | {"position": [0.0, 5.0], "young": 1e9}
    force = push(2, 3000.0, 700.0, table=rows) | ({} if at is None else {"at": at})
    result = run(scene(2, free, end=0.5, step=4e-3, gravity=0.0, force=[force]))
    history = result.history
    impulse = np.trapezoid([factor for _, factor in rows], [time for time, _ in rows])
    for axis, whole in (("x", 3000.0), ("y", 700.0)):
        speed = np.diff(history[f"block.centre_{axis}_m"])[-10:] / 4e-3
        assert speed == pytest.approx(whole * impulse / 500.0, rel=1e-7)
    total = history["energy.total_J"] - history["energy.total_J"][0]
    lost = history["energy.numerical_J"]
    assert total + lost == pytest.approx(history["energy.input_J"], abs=1e-9 * total.max())
    if at is None:
        assert np.abs(history["block.angle_rad"]).max() < 1e-10


def test_an_elastic_block_turns_by_a_couple_as_a_rigid_one() -> None:
    pytest.importorskip("dolfinx")
    ends = [
        push(2, sign * 100.0, 0.0, name=name, at=[0.0, height])
        for name, sign, height in (("top", 1.0, 2.0), ("bottom", -1.0, 0.0))
    ]
    free = SLENDER | {"position": [0.0, 5.0]}
    turned = [
        run(scene(2, block, end=2.0, step=4e-3, gravity=0.0, force=ends)).history["block.angle_rad"]
        for block in (free, elastic(2, free))
    ]
    assert turned[0].max() > 1.5
    assert np.abs(turned[1] - turned[0]).max() < 1e-3 * turned[0].max()


@pytest.mark.parametrize(("d", "face"), [(2, "left"), (2, "top"), (3, "back"), (3, "right")])
def test_a_pressure_pushes_an_elastic_block_by_the_area_of_its_face(d: int, face: str) -> None:
    """It moves as a rigid one does, and does not turn."""
    pytest.importorskip("dolfinx")
    air = {"position": [*[0.0] * (d - 1), 5.0]}
    wind = {"on": "block", "face": face, "pressure": 700.0}
    moved = []
    for block in (SLENDER, elastic(d, SLENDER)):
        given = scene(d, block | air, end=0.1, step=4e-3, gravity=0.0, force=[wind])
        history = run(given).history
        moved.append([np.ptp(history[f"block.centre_{axis}_m"]) for axis in "xyz"[:d]])
        assert np.abs(history["block.angle_rad"]).max() < 1e-9
    assert max(moved[0]) > 0.0
    assert moved[1] == pytest.approx(moved[0], abs=1e-9 * max(moved[0]))


@pytest.mark.parametrize(("d", "face"), [(2, "right"), (3, "left"), (3, "top")])
def test_a_pressure_pushes_an_elastic_block_on_feet_on_its_box(d: int, face: str) -> None:
    """As a rigid one: in the middle of the face above the feet, where its centre of mass is."""
    pytest.importorskip("dolfinx")
    feet = {"position": [*[0.0] * (d - 1), 5.0], "feet": {"size": 0.1, "height": 0.1}}
    wind = {"on": "block", "face": face, "pressure": 700.0}
    moved = []
    meshed = STONE | SLENDER | {"model": "elastic", "cell_size": 0.25}
    for block in (SLENDER, meshed):
        given = scene(d, block | feet, end=0.1, step=4e-3, gravity=0.0, force=[wind])
        history = run(given).history
        moved.append([np.ptp(history[f"block.centre_{axis}_m"]) for axis in "xyz"[:d]])
        # Elastic feet weigh a thousandth of the box, which puts its centre of mass off that middle.
        assert np.abs(history["block.angle_rad"]).max() < 1e-6
    assert max(moved[0]) > 0.0
    assert moved[1] == pytest.approx(moved[0], abs=1e-5 * max(moved[0]))


def test_a_pressure_squeezes_an_elastic_block() -> None:
    """Between two faces: energy of strain p²/(2 E) V, with poisson 0, and no motion."""
    pytest.importorskip("dolfinx")
    block = elastic(2, SLENDER) | {"damping": {"stiffness": 1e-3}, "young": 1e8}
    winds = [
        {"name": face, "on": "block", "face": face, "pressure": 1e4, "ramp": [0.0, 0.3]}
        for face in ("left", "right")
    ]
    air = {"position": [0.0, 5.0], "poisson": 0.0}
    given = scene(2, block | air, end=0.4, step=4e-3, gravity=0.0, force=winds)
    history = run(given).history
    strain = 1e4 / 1e8
    assert history["energy.strain_J"][-1] == pytest.approx(1e4 * strain / 2 * 0.5, rel=1e-3)
    assert np.abs(history["block.centre_x_m"]).max() < 1e-9


@pytest.mark.parametrize(("speed", "mode"), [(27.6, "rest"), (27.8, "slide")])
def test_wind_slides_an_elastic_container(speed: float, mode: str) -> None:
    pytest.importorskip("dolfinx")
    sizes = {"width": 2.438, "height": 2.591, "thickness": 6.058, "mass": 2300.0}
    box = {"young": 5e8, "poisson": 0.2, "cells": CELLS[2]} | sizes
    wind = {"on": "block", "face": "left", "pressure": pressure(speed), "ramp": [0.0, 2.0]}
    result = run(scene(2, box, end=5.0, step=4e-3, friction=0.4, force=[wind]))
    assert result.summary["blocks"]["block"]["mode"] == mode
