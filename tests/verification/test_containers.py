"""Freight containers by name: dimensions, mass, corner castings that carry, locks and scale."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ledger import completed as run
from rigid import G, scene, table

from rockslip import Result, SceneError, parse_scene
from solver.scene.scaling import Scale, scaled_tables
from solver.types import Array

WIDTH, GROSS = 2.438, 30480.0
SIZES = {
    "20ft": (6.058, 2.591, 2300.0),
    "40ft": (12.192, 2.591, 3750.0),
    "40ft high cube": (12.192, 2.896, 3940.0),
    "45ft high cube": (13.716, 2.896, 4820.0),
}
"""Length and height (m) by ISO 668, and an empty mass, kg."""

EMPTY = {"model": "rigid", "container": "20ft", "load": "empty"}
WEIGHT = 2300.0 * G


def stack(*boxes: dict[str, Any], **more: Any) -> list[dict[str, Any]]:
    """Containers on one another, box1 below."""
    names = ["foundation", *(f"box{k + 1}" for k in range(len(boxes)))]
    return [
        EMPTY | box | {"name": names[k + 1], "on": names[k]} | more for k, box in enumerate(boxes)
    ]


@pytest.mark.parametrize("load", ["empty", "full"])
@pytest.mark.parametrize("name", SIZES)
@pytest.mark.parametrize("d", [2, 3])
def test_mass_and_inertia_are_those_of_an_even_box_of_the_outer_dimensions(
    d: int, name: str, load: str
) -> None:
    length, height, tare = SIZES[name]
    (block,) = scene(d, EMPTY | {"container": name, "load": load}, end=1.0).blocks
    shape, mass = block.shape, tare if load == "empty" else GROSS
    assert (shape.width, shape.height, shape.thickness) == (WIDTH, height, length)
    assert shape.mass == pytest.approx(mass, rel=1e-12)
    assert shape.centre_of_mass(d) == (*[0.0] * (d - 1), height / 2)
    squares = length**2 + height**2, WIDTH**2 + height**2, WIDTH**2 + length**2
    assert np.diag(shape.inertia_tensor) == pytest.approx(np.array(squares) * mass / 12, rel=1e-12)
    assert shape.rotary_inertia == pytest.approx(mass * squares[1] / 12, rel=1e-12)
    solid = shape.solid
    assert solid is not None
    # Underside 12.5 mm above the lowest faces, roof 6 mm below the highest ones.
    body = solid.parts[0]
    ends = float(body.corners[:, -1].min()), float(body.corners[:, -1].max())
    assert ends == pytest.approx((0.0125, height - 0.006), rel=1e-12)
    assert np.array([solid.low[-1], solid.high[-1]]) == pytest.approx([0.0, height], abs=1e-12)


@pytest.mark.parametrize("name", SIZES)
def test_castings_are_flush_with_ends_and_sides(name: str) -> None:
    """178 mm along the length, 162 mm across; one of 45 feet has those of one of 40 feet, too."""
    length, height, _ = SIZES[name]
    (block,) = scene(3, EMPTY | {"container": name}, end=1.0).blocks
    solid = block.shape.solid
    assert solid is not None
    lengths = [length, 12.192] if length > 12.192 else [length]
    count = 4 * len(lengths)
    assert block.shape.feet == count and len(solid.parts) == 1 + 2 * count
    for face, parts in ((height, solid.parts[1 : 1 + count]), (0.0, solid.parts[1 + count :])):
        ends = [np.abs(part.corners[:, :2]) for part in parts]
        assert all(face in part.corners[:, 2] for part in parts)
        for number, inner in enumerate(ends):
            far = lengths[number // 4] / 2
            assert inner.min(axis=0) == pytest.approx((WIDTH / 2 - 0.162, far - 0.178), rel=1e-12)
            assert inner.max(axis=0) == pytest.approx((WIDTH / 2, far), rel=1e-12)


def lifts_at(result: Result, rate: float) -> float:
    """Acceleration of the ground at which the block begins to turn."""
    angle = np.abs(result.history["block.angle_rad"])
    return float(rate * result.history["time_s"][int(np.argmax(angle > 1e-12))])


@pytest.mark.parametrize(
    ("more", "centre"),
    [
        ({}, 2.591 / 2),
        ({"load": "full"}, 2.591 / 2),
        ({"centre_of_mass": [0.0, 1.0]}, 1.0),
        ({"container": "40ft high cube"}, 2.896 / 2),
    ],
)
def test_it_lifts_about_the_outer_edges_of_its_castings(
    more: dict[str, Any], centre: float, tmp_path: Path
) -> None:
    """At g (B/2)/h, h being the height of the centre over the faces that it stands on."""
    rate = 0.6 * G
    file = table(tmp_path, [(0.0, 0.0), (2.5, 2.5 * rate)])
    ground = {"kind": "table", "file": file, "units": "m/s2"}
    given = scene(2, EMPTY | more, end=2.5, friction=5.0, motion=ground)
    assert lifts_at(run(given), rate) == pytest.approx(G * WIDTH / 2 / centre, rel=1e-3)


@pytest.mark.parametrize("d", [2, 3])
def test_impacts_keep_what_angular_momentum_says(d: int) -> None:
    """(I + m (h² - c²))/(I + m (h² + c²)) of the spin."""
    given = scene(d, EMPTY | {"tilt_deg": 3.0}, end=1.0, step=5e-4, friction=5.0)
    told = run(given).summary["blocks"]["block"]["impacts"]
    c, h = WIDTH / 2, 2.591 / 2
    over_mass = (WIDTH**2 + 2.591**2) / 12
    kept = (over_mass + h**2 - c**2) / (over_mass + h**2 + c**2)
    assert told[0]["restitution"] == pytest.approx(kept, rel=1e-6)


@pytest.mark.parametrize("name", ["20ft", "40ft high cube"])
def test_each_corner_of_a_container_in_space_carries_a_quarter(name: str) -> None:
    given = scene(3, EMPTY | {"container": name, "load": "full"}, end=0.1)
    history = run(given).history
    forces = [history[f"block.foot_{k}.normal_force_N"][-1] for k in (1, 2, 3, 4)]
    assert forces == pytest.approx([GROSS * G / 4] * 4, rel=1e-9)


@pytest.mark.parametrize("d", [2, 3])
def test_containers_stand_casting_on_casting(d: int) -> None:
    """Nothing falls or moves; corners carry all that is above them."""
    kinds = ["20ft"] * 4 if d == 2 else ["40ft", "40ft high cube", "45ft high cube", "40ft"]
    given = scene(d, *stack(*({"container": kind} for kind in kinds)), end=0.5)
    history = run(given).history
    level, above = 0.0, sum(SIZES[kind][2] for kind in kinds)
    for k, kind in enumerate(kinds, 1):
        length, height, tare = SIZES[kind]
        centre = history[f"box{k}.centre_{'xyz'[d - 1]}_m"]
        assert centre == pytest.approx(level + height / 2, abs=1e-12)
        count = (2 if d == 2 else 4) * (2 if length > 12.192 and d == 3 else 1)
        forces = [history[f"box{k}.foot_{n + 1}.normal_force_N"][-1] for n in range(count)]
        assert sum(forces) == pytest.approx(above * G, rel=1e-9)
        bearing = forces[-2 * (d - 1) :]
        assert bearing == pytest.approx([above * G / (2 * d - 2)] * (2 * d - 2), rel=1e-8)
        assert forces[: count - len(bearing)] == pytest.approx([0.0] * (count - len(bearing)))
        level, above = level + height, above - tare


def test_one_of_40_feet_stands_on_two_of_20() -> None:
    """76 mm apart, castings at its ends on theirs."""
    lower = [
        EMPTY | {"name": side, "offset_second": y} for side, y in (("a", -3.067), ("b", 3.067))
    ]
    upper = EMPTY | {"name": "upper", "container": "40ft", "on": ["a", "b"]}
    history = run(scene(3, *lower, upper, end=0.1)).history
    assert history["upper.centre_z_m"] == pytest.approx(1.5 * 2.591, abs=1e-12)
    forces = [history[f"upper.foot_{k}.normal_force_N"][-1] for k in (1, 2, 3, 4)]
    assert forces == pytest.approx([3750.0 * G / 4] * 4, rel=1e-9)
    for name in ("a", "b"):
        forces = [history[f"{name}.foot_{k}.normal_force_N"][-1] for k in (1, 2, 3, 4)]
        assert sum(forces) == pytest.approx(WEIGHT + 3750.0 * G / 2, rel=1e-12)


def test_a_container_that_misses_the_castings_below_sinks_to_the_roof() -> None:
    """One side sinks by 6 mm, to the roof; the other by 12.5 mm, with its underside on a casting.

    Shifted by s = 0.2 m: castings bear at their inner edges, B/2 - 0.162 from the middle, and the
    underside on the outer edge of the other casting, B/2 - s from it.
    """
    lower, upper = stack({}, {})
    given = scene(2, lower, upper | {"offset": 0.2}, end=2.0, friction=2.0)
    history = run(given).history
    lean = 6.5e-3 / (WIDTH / 2 - 0.2 + WIDTH / 2 - 0.162)
    assert math.tan(history["box2.angle_rad"][-1]) == pytest.approx(lean, rel=2e-3)
    assert abs(history["box2.angular_velocity_rad_s"][-1]) < 1e-9
    left, right = (history[f"box2.foot_{k}.normal_force_N"][-1] for k in (1, 2))
    assert right == 0.0 and 0.4 * WEIGHT < left < 0.6 * WEIGHT


@pytest.mark.parametrize("d", [2, 3])
def test_containers_that_tumble_gain_nothing(d: int) -> None:
    """Three fall onto one that stands, and meet it and one another."""
    falling = [
        {
            "name": f"falling{k}",
            "position": [0.7 * k - 0.7, *[0.4 * k] * (d - 2), 7.0 + 4.5 * k],
            "tilt_deg": 35.0 * k - 20.0,
            "load": "full" if k == 1 else "empty",
        }
        for k in range(3)
    ]
    boxes = [EMPTY, *(EMPTY | each for each in falling)]
    result = run(scene(d, *boxes, end=4.0, step=4e-3, friction=0.5), ledger=1e-8)
    history = result.history
    assert max(history[f"falling{k}.penetration_m"].max() for k in range(3)) < 1e-4
    assert history["energy.total_J"][-1] < 0.7 * history["energy.total_J"][0]


# ------------------------------------------------------------------ locks


def locks(count: int, d: int, **more: Any) -> list[dict[str, Any]]:
    """Twist-locks in the apertures of the castings of 20 feet: 2.259 m and 5.853 m apart."""
    names = ["foundation", *(f"box{k + 1}" for k in range(count))]
    found = []
    for k in range(count):
        for i, x in enumerate((-1.1295, 1.1295)):
            for j, y in enumerate([0.0] if d == 2 else [-2.9265, 2.9265]):
                level = 0.0 if k == 0 else 2.591
                lock = {"name": f"lock{k + 1}{i}{j}", "kind": "twist-lock"}
                at = [x, level] if d == 2 else [x, y, level]
                lock |= {"between": [names[k], names[k + 1]], "at": at}
                found.append(lock | {"stiffness": 1e9 / (d - 1)} | more)
    return found


@pytest.mark.parametrize("d", [2, 3])
def test_twist_locks_pull_where_what_is_above_would_uplift(tmp_path: Path, d: int) -> None:
    """At g B/(n h) with n containers above: 0.941, 0.470, 0.314 and 0.235 g; then by moments.

    Levers are from the locks to the outer edge of the castings at +x, about which all above turns:
    those at +x are within that edge, and pull a little, too.
    """
    strongest, end = 1.1 * G, 20.0
    file = table(tmp_path, [(0.0, 0.0), (end, -strongest)])
    given = scene(
        d,
        *stack({}, {}, {}, {}),
        end=end,
        step=4e-3,
        friction=2.0,
        link=locks(4, d, damping=1e7 / (d - 1)),
        motion={"kind": "table", "file": file, "units": "m/s2"},
        output={"fields": "none"},
    )
    history = run(given).history
    shaking = -history["base.acceleration_m_s2"]
    levers = WIDTH / 2 + np.array([1.1295, -1.1295])
    for k in range(4):
        above = 4 - k
        pulls = np.zeros((2, len(shaking)))
        for i, j in product((0, 1), range(d - 1)):
            pulls[i] += history[f"lock{k + 1}{i}{j}.force_N"]
        moment = above * 2300.0 * (shaking * above * 2.591 - G * WIDTH) / 2
        expected = np.maximum(moment, 0.0) * levers[:, None] / (levers @ levers)
        assert np.abs(pulls - expected)[:, 100:].max() < 1e-3 * above * WEIGHT
        onset = shaking[np.flatnonzero(pulls[0] > 2e-3 * above * WEIGHT)[0]] / G
        assert onset == pytest.approx(WIDTH / (above * 2.591), abs=5e-3)


# ------------------------------------------------------------------ keys


def test_the_page_of_the_scene_has_these_numbers() -> None:
    page = (Path(__file__).parents[2] / "docs" / "scene.md").read_text(encoding="utf-8")
    for name, (length, height, tare) in SIZES.items():
        sizes = f"{WIDTH}, {height}, {length} m"
        assert f'| `"{name}"` | {sizes} | {tare:.0f} kg | {GROSS:.0f} kg |' in page


def test_a_scene_of_containers_says_the_same_when_it_is_written_out() -> None:
    given = scene(3, *stack({}, {"load": "full", "container": "20ft"}), end=1.0)
    again = parse_scene(given.to_dict())
    assert again == given
    assert [block.mass for block in again.blocks] == [2300.0, GROSS]


@pytest.mark.parametrize("keeps", ["density", "young"])
def test_a_model_of_a_container_is_one_at_its_scale(keeps: Any) -> None:
    given = scene(3, EMPTY | {"tilt_deg": 2.0}, end=1.0)
    model = parse_scene(scaled_tables(given, Scale(0.05, keeps), {}))
    large, small = given.blocks[0].shape, model.blocks[0].shape
    assert model.blocks[0].container == "20ft" and model.blocks[0].scale == 0.05
    density = 1.0 if keeps == "density" else 20.0
    assert small.mass == pytest.approx(density * 0.05**3 * large.mass, rel=1e-12)
    expected = density * 0.05**5 * np.array(large.inertia_tensor)
    assert np.array(small.inertia_tensor) == pytest.approx(expected, rel=1e-12)
    assert large.solid is not None and small.solid is not None
    assert small.solid.corners == pytest.approx(0.05 * large.solid.corners, rel=1e-9)
    angles: list[Array] = [run(each).history["block.angle_rad"] for each in (given, model)]
    assert angles[1] == pytest.approx(angles[0], abs=1e-9)


def test_parts_and_inertia_are_those_of_any_block() -> None:
    """A floor of steel below a light rest; and a centre of mass with its inertia."""
    floor = {"from": [-WIDTH / 2, 0.0], "to": [WIDTH / 2, 0.2], "density": 600.0}
    own = {"model": "rigid", "container": "20ft", "density": 50.0, "parts": [floor]}
    (block,) = scene(2, own, end=1.0).blocks
    area = WIDTH * 6.058
    masses = np.array([600.0 * 0.2 * area, 50.0 * 2.391 * area])
    assert block.shape.mass == pytest.approx(masses.sum(), rel=1e-12)
    assert block.shape.centre_height == pytest.approx(
        masses @ [0.1, 0.2 + 2.391 / 2] / masses.sum(), rel=1e-12
    )
    uneven = EMPTY | {"centre_of_mass": [0.2, 1.0], "inertia": 3000.0}
    (block,) = scene(2, uneven, end=1.0).blocks
    assert block.shape.rotary_inertia == 3000.0
    assert (block.shape.arm(1), block.shape.arm(-1)) == pytest.approx((1.019, 1.419))


@pytest.mark.parametrize("d", [2, 3])
def test_a_container_stands_on_what_is_meshed(d: int) -> None:
    """On an elastic plate: each casting bears its part of the weight."""
    pytest.importorskip("dolfinx")
    plate = {"kind": "elastic", "support": "bottom", "width": 4.0, "height": 0.2, "young": 3e10}
    plate |= {"cells": [8, 2]} if d == 2 else {"thickness": 8.0, "cells": [8, 8, 2]}
    given = scene(
        d, EMPTY, end=0.02, step=2e-3, foundation=plate | {"density": 2500.0, "poisson": 0.2}
    )
    history, feet = run(given).history, 2 ** (d - 1)
    forces = [history[f"block.foot_{k}.normal_force_N"][-1] for k in range(1, feet + 1)]
    assert forces == pytest.approx([2300.0 * G / feet] * feet, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "length", "height"), [("20ft high cube", 6.058, 2.896), ("45ft", 13.716, 2.591)]
)
def test_rare_ones_have_no_usual_mass(name: str, length: float, height: float) -> None:
    box = EMPTY | {"container": name}
    with pytest.raises(SceneError, match=r'^block\.load: got "empty", allowed "full", or its mass'):
        scene(3, box, end=1.0)
    for load in ({"load": "full"}, {"load": None, "mass": 2500.0}):
        given = {key: value for key, value in (box | load).items() if value is not None}
        (block,) = scene(3, given, end=1.0).blocks
        assert (block.thickness, block.height) == (length, height)
        assert block.shape.mass == pytest.approx(load.get("mass", 30480.0), rel=1e-12)


def test_a_container_is_rigid() -> None:
    with pytest.raises(SceneError, match=r"^block\.container applies to blocks with model = "):
        scene(2, EMPTY | {"model": "elastic", "young": 1e9, "poisson": 0.2}, end=1.0)


PLATE = {
    "kind": "elastic",
    "support": "bottom",
    "width": 8.0,
    "height": 0.5,
    "density": 2400.0,
    "young": 3e10,
    "poisson": 0.2,
    "cells": [16, 2],
}
CRATE = {"name": "crate", "on": "box1", "model": "rigid", "width": 1.0, "thickness": 6.058}


@pytest.mark.parametrize("offset", [0.0, 0.3])
@pytest.mark.parametrize(("d", "ground"), [(2, None), (3, None), (2, PLATE)])
def test_a_crate_between_the_castings_stands_on_the_roof(
    d: int, ground: dict[str, Any] | None, offset: float
) -> None:
    """6 mm below the castings, at rest from the start, and it rocks there at g B/H."""
    size = {"height": 2.0, "density": 50.0, "offset": offset}
    (box,) = stack({"load": "full"})
    crate = CRATE | size | ({"thickness": 3.0} if d == 3 else {})
    more = {"foundation": ground} if ground else {}
    if ground:
        pytest.importorskip("dolfinx")
    motion = {"kind": "half_sine", "amplitude_g": -1.0, "duration": 0.3}
    given = scene(d, box, crate, end=0.5, step=1e-3, friction=2.0, motion=motion, **more)
    history = run(given).history
    up = "y" if d == 2 else "z"
    roof = given.poses()["crate"](np.zeros((1, d)))[0, -1]
    assert roof == pytest.approx(2.591 - 0.006, abs=1e-9)
    assert history[f"crate.centre_{up}_m"][0] == pytest.approx(roof + 1.0, abs=1e-6)
    weight = given.blocks[1].shape.mass * G
    assert history["crate.normal_force_N"][:20] == pytest.approx(weight, rel=1e-3)
    lifts = history["time_s"][np.argmax(np.abs(history["crate.angle_rad"]) > 1e-5)]
    # From g B/H on the moment grows with the ground's acceleration, and the angle as t³/6.
    radius = math.hypot(0.5, 1.0)
    growth = 0.75 * G / radius**2 * math.pi / 0.3 * math.cos(math.asin(0.5))
    expected = 0.3 / math.pi * math.asin(0.5) + (6e-5 / growth) ** (1 / 3)
    assert lifts == pytest.approx(expected, abs=1.5e-3)


# ------------------------------------------------------------------ feet of boxes


def test_feet_may_be_longer_than_wide_and_on_top() -> None:
    """Of a box with pads of 0.1 x 0.3 m below and above, that carries another box."""
    feet = {"inset": 0.02, "size": [0.1, 0.3], "height": 0.05, "top": 0.03}
    box = {"model": "rigid", "width": 1.0, "height": 0.6, "thickness": 1.4, "density": 500.0}
    given = scene(3, box | {"name": "low", "feet": feet}, box | {"on": "low"}, end=0.1)
    low = given.blocks[0].shape
    assert low.height == pytest.approx(0.68) and low.mass == pytest.approx(500.0 * 0.84)
    assert low.centre_height == pytest.approx(0.35)
    corners = np.abs(np.array(low.standing_corners(3)))
    assert corners.min(axis=0) == pytest.approx([0.38, 0.38, 0.0])
    assert corners.max(axis=0) == pytest.approx([0.48, 0.68, 0.0])
    history = run(given).history
    assert history["block.centre_z_m"] == pytest.approx(0.68 + 0.3, abs=1e-12)
    forces = [history[f"low.foot_{k}.normal_force_N"][-1] for k in (1, 2, 3, 4)]
    assert forces == pytest.approx([2 * 420.0 * G / 4] * 4, rel=1e-9)


def test_a_box_with_pads_on_top_alone_stands_on_its_bottom() -> None:
    feet = [{"at": [x], "size": 0.1, "height": 0.02, "face": "top"} for x in (-0.3, 0.3)]
    box = {"model": "rigid", "width": 1.0, "height": 0.6, "density": 500.0}
    given = scene(2, box | {"name": "low", "feet": feet}, box | {"on": "low"}, end=0.1)
    low = given.blocks[0].shape
    assert (low.height, low.base, low.feet) == (pytest.approx(0.62), (-0.5, 0.5), 0)
    history = run(given).history
    assert history["block.centre_y_m"] == pytest.approx(0.62 + 0.3, abs=1e-12)
    assert not [name for name in history.columns if "foot" in name]
