"""Blocks whose mass is not spread evenly: rigid and elastic, in the plane and in space.

Against statics, angular momentum about each edge, the equation of rocking with the numbers of both
edges, closed forms of centre and inertia, and against one another.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from histories import lift_off
from ledger import completed as run

from geometry.block import SIDES, Block
from rockslip import Scene, parse_scene, simulate
from solver.history.pairs import read_pairs
from solver.reference.answer import reference_history
from solver.reference.housner import housner
from solver.results.motion import boxes

G = 9.81

SIZE = {"width": 0.25, "height": 1.0, "thickness": 0.75}

OFF = SIZE | {"mass": 503.0, "centre_of_mass": [0.02, 0.55], "model": "rigid"}
"""The paper's block with its centre of mass off by 20 mm, and 50 mm too high."""

IN_SPACE = OFF | {"centre_of_mass": [0.01, -0.03, 0.55]}

ELASTIC = {"model": "elastic", "young": 5e10, "poisson": 0.2}

HEAVY_BOTTOM = SIZE | {
    "density": 1000.0,
    "parts": [{"from": [-0.125, 0.0], "to": [0.125, 0.25], "density": 7000.0}],
}

PLATE = {
    "kind": "elastic",
    "width": 4.0,
    "height": 0.2,
    "density": 2400.0,
    "young": 1e11,
    "poisson": 0.2,
    "cells": [2, 1],
}
"""Held altogether: the ground of the meshed engine."""


def scene(block: dict[str, Any], end: float, step: float | None = 1e-3, **tables: Any) -> Scene:
    """A block on firm ground, which it does not slide on unless `contact` says so."""
    time = {"end": end} | ({"step": step} if step else {})
    base = {"block": [block], "contact": {"friction": 2.0}, "time": time}
    return parse_scene(base | {"output": {"fields": "none"}} | tables)


def ramp(folder: Path, slope: float, end: float) -> dict[str, Any]:
    """Ground whose acceleration grows evenly, g/s."""
    file = folder / f"ramp{slope:g}.csv"
    file.write_text(f"0,0\n{end!r},{slope * end!r}\n")
    return {"kind": "table", "file": str(file)}


# ---------------------------------------------------------------- rigid, in the plane


@pytest.mark.parametrize("sign", [1, -1])
def test_it_lifts_where_its_own_edge_lets_it(sign: int, tmp_path: Path) -> None:
    """At g (B/2 -+ e)/h: ground that accelerates towards +x lifts it over the edge at -x."""
    given = scene(OFF, 2.0, motion=ramp(tmp_path, sign * 0.2, 2.0))
    history = run(given).history
    angle = history["block.angle_rad"]
    found = 0.2 * lift_off(history["time_s"], angle, 1e-5, 1e-3)
    assert found == pytest.approx((0.125 + sign * 0.02) / 0.55, rel=2e-3)
    assert np.sign(angle[-1]) == -sign
    still = history["time_s"] < (0.125 + sign * 0.02) / 0.55 / 0.2 - 1e-3
    assert np.abs(angle[still]).max() < 1e-12


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("tilt", [3.0, -3.0])
def test_free_rocking_is_that_of_the_equation(tilt: float, dimension: int) -> None:
    """Angles over seven impacts and more, restitutions of both edges, and peaks that alternate."""
    given = scene(OFF | {"tilt_deg": tilt}, 2.5)
    shape = given.blocks[0].shape
    if dimension == 3:
        block = OFF | {"tilt_deg": tilt, "centre_of_mass": [0.02, 0.0, 0.55]}
        given = scene(block, 2.5, dimension=3)
    result = run(given)
    exact = housner(shape, gravity=G, tilt=math.radians(tilt), end=2.5, step=1e-3)
    assert len(exact.impacts) > 6
    assert result.history["block.angle_rad"] == pytest.approx(exact.angle, abs=2e-6)
    impacts = [event for event in result.history.events if event.kind == "impact"]
    assert len(impacts) >= len(exact.impacts) - 1
    right = ("right", "2+3")
    for event in impacts[:6]:
        wanted = shape.restitution(1 if event.where in right else -1)
        assert event.restitution == pytest.approx(wanted, rel=1e-6)
    peaks = exact.peaks
    assert (peaks[1:] * peaks[:-1] < 0).all()


def test_the_restitutions_are_those_of_angular_momentum() -> None:
    """About the new edge, from velocities of the centre of mass before and after."""
    shape = scene(OFF, 1.0).blocks[0].shape
    m, inertia, high = shape.mass, shape.rotary_inertia, 0.55
    for side in SIDES:
        new, old = 0.125 - side * 0.02, 0.125 + side * 0.02
        # Clockwise with 1 rad/s about the old edge: the centre is at -side*new from the new one.
        arm = np.array([-side * new, high])
        before = np.array([high, -side * old])
        after = np.array([high, side * new])
        momentum = inertia + m * (arm[1] * before[0] - arm[0] * before[1])
        kept = inertia + m * (arm[1] * after[0] - arm[0] * after[1])
        assert shape.restitution(side) == pytest.approx(momentum / kept, rel=1e-14)


def test_energy_of_an_impact_in_the_events() -> None:
    """What is lost is the difference of the energies of turning about the two edges."""
    given = scene(OFF | {"tilt_deg": 3.0}, 0.6)
    shape, result = given.blocks[0].shape, run(given)
    (first, *_) = [event for event in result.history.events if event.kind == "impact"]
    drop = math.cos(shape.slenderness(1) - math.radians(3.0)) - math.cos(shape.slenderness(1))
    fallen = shape.weight(G) * shape.radius(1) * drop
    kept = shape.restitution(-1) ** 2 * shape.rotary_inertia_about_corner(-1)
    kept /= shape.rotary_inertia_about_corner(1)
    assert first.energy_lost_J == pytest.approx(fallen * (1 - kept), rel=1e-6)
    assert result.summary["energy"]["loss"]["contact_J"] == pytest.approx(
        sum(e.energy_lost_J for e in result.history.events if e.kind == "impact"), rel=1e-4
    )


def test_a_restitution_that_is_given_holds_for_both_edges() -> None:
    given = scene(OFF | {"tilt_deg": 3.0, "restitution": 0.97}, 2.0)
    exact = housner(
        given.blocks[0].shape,
        gravity=G,
        tilt=math.radians(3.0),
        end=2.0,
        step=1e-3,
        restitution=0.97,
    )
    assert run(given).history["block.angle_rad"] == pytest.approx(exact.angle, abs=5e-6)


@pytest.mark.slow
def test_shaken_on_an_incline_and_on_a_platform() -> None:
    """The engine and the equation, also where the ground moves and where a spring carries it."""
    pulse = {"kind": "one_sine", "amplitude_g": -0.35, "duration": 0.5}
    for tables, tolerance in (
        ({"motion": pulse | {"amplitude_g": 0.3}, "gravity_tilt_deg": 2.0}, 1e-5),
        ({"motion": pulse}, 1e-5),
        (
            {
                "motion": pulse | {"amplitude_g": -0.45},
                "foundation": {"kind": "oscillator", "mass_ratio": 1.0, "period": 0.5},
            },
            1e-4,
        ),
    ):
        given = scene(OFF, 1.6, 2e-4, **tables)
        own, other = run(given).history, reference_history(given)
        assert np.abs(own["block.angle_rad"]).max() > 0.02
        for column in ("block.angle_rad", "block.centre_x_m", "block.centre_y_m"):
            assert own[column] == pytest.approx(other[column], abs=tolerance), column
        if "foundation" in tables:
            drift = "platform.drift_m"
            assert own[drift] == pytest.approx(other[drift], abs=tolerance)


def test_the_restitution_on_a_platform() -> None:
    """An impact on a platform that is light: the ratio of the closed form, on each edge."""
    base = {"kind": "oscillator", "mass_ratio": 1.0, "period": 0.5}
    given = scene(OFF | {"tilt_deg": 3.0}, 0.8, 2e-4, foundation=base)
    shape = given.blocks[0].shape
    exact = reference_history(given)
    assert run(given).history["block.angle_rad"] == pytest.approx(
        exact["block.angle_rad"], abs=2e-5
    )
    share = shape.mass / (shape.mass + given.platform().mass)
    assert shape.restitution(-1, share) < shape.restitution(-1)


def test_it_slides_as_any_block() -> None:
    """Friction knows no centre of mass, as long as the block stays flat."""
    given = scene(OFF | {"velocity": [1.0, 0.0]}, 1.0, contact={"friction": 0.15}, gravity=G)
    own, other = run(given).history, reference_history(given)
    for column in ("slip_m", "centre_x_m", "centre_y_m", "friction_force_N"):
        scale = 1.0 if column.endswith("_m") else 503.0 * G
        found = np.abs(own[f"block.{column}"] - other[f"block.{column}"])[1:-1] / scale
        assert np.sort(found)[-3] < 1e-4, column


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_block_thrown_along_the_ground_trips_by_its_own_edge(direction: float) -> None:
    """Friction between b/h of both edges: it slides flat one way and trips the other."""
    given = scene(OFF | {"velocity": [direction, 0.0]}, 0.3, contact={"friction": 0.22})
    rocks = np.abs(run(given).history["block.angle_rad"]).max() > 1e-4
    assert rocks == (direction > 0)


# ---------------------------------------------------------------- parts, and inertia by hand


def by_hand() -> dict[str, Any]:
    """The block with a heavy bottom by its mass, centre and inertia, from two boxes."""
    masses, heights, edges = (1750 * 0.1875, 1000 * 0.140625), (0.125, 0.625), (0.25, 0.75)
    masses = 7000 * 0.25 * 0.75 * 0.25, 1000 * 0.25 * 0.75 * 0.75
    total = sum(masses)
    middle = sum(m * y for m, y in zip(masses, heights, strict=True)) / total
    inertia = sum(
        m * ((0.25**2 + edge**2) / 12 + (y - middle) ** 2)
        for m, y, edge in zip(masses, heights, edges, strict=True)
    )
    return SIZE | {
        "model": "rigid",
        "mass": total,
        "centre_of_mass": [0.0, middle],
        "inertia": inertia,
    }


def test_a_heavy_bottom_by_hand() -> None:
    """Mass, centre and inertia of two boxes, and their rocking: parts, and the same by hand."""
    parts, hand = HEAVY_BOTTOM | {"model": "rigid"}, by_hand()
    one, other = (scene(block, 1.0).blocks[0].shape for block in (parts, hand))
    assert one.mass == pytest.approx(7000 * 0.046875 + 1000 * 0.140625, rel=1e-14)
    assert one.centre_height == pytest.approx(0.275, rel=1e-14)
    for name in ("mass", "rotary_inertia", "centre_height"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-13)
    first, second = (run(scene(b | {"tilt_deg": 5.0}, 1.0)).history for b in (parts, hand))
    for column in ("block.angle_rad", "block.centre_x_m", "energy.total_J"):
        assert first[column] == pytest.approx(second[column], abs=1e-9 * np.ptp(second[column]))


def test_parts_that_are_as_the_rest_make_no_difference() -> None:
    same = [{"from": [-0.1, 0.2], "to": [0.05, 0.9], "density": 2682.0}]
    block = SIZE | {"model": "rigid", "density": 2682.0, "tilt_deg": 4.0}
    plain, parted = (run(scene(b, 1.0)).history for b in (block, block | {"parts": same}))
    assert parted["block.angle_rad"] == pytest.approx(plain["block.angle_rad"], abs=1e-10)


def test_a_mass_in_space_by_hand() -> None:
    """Three boxes: centre, moments and products of inertia from points on a fine grid."""
    parts = [
        {"from": [-0.1, -0.3, 0.1], "to": [0.1, 0.2, 0.4], "density": 5000.0},
        {"from": [0.05, 0.2, 0.5], "to": [0.125, 0.375, 1.0], "density": 200.0},
    ]
    block = SIZE | {"model": "rigid", "density": 1000.0, "parts": parts}
    shape = scene(block, 1.0, dimension=3).blocks[0].shape
    axes = [
        (np.arange(count) + 0.5) / count * length - shift
        for count, length, shift in ((40, 0.25, 0.125), (60, 0.75, 0.375), (40, 1.0, 0.0))
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    density = np.full(len(grid), 1000.0)
    for part in parts:
        inside = np.all((grid > part["from"]) & (grid < part["to"]), axis=1)
        density[inside] = part["density"]
    masses = density * 0.1875 / len(grid)
    centre = masses @ grid / masses.sum()
    arms = grid - centre
    moment = np.einsum("n,ni,nj->ij", masses, arms, arms)
    cell = np.array([0.25 / 40, 0.75 / 60, 1.0 / 40]) ** 2 / 12
    moment += masses.sum() * np.diag(cell)
    tensor = np.trace(moment) * np.eye(3) - moment
    assert shape.mass == pytest.approx(masses.sum(), rel=1e-12)
    assert shape.centre_of_mass(3) == pytest.approx(centre, rel=1e-12)
    assert np.array(shape.inertia_tensor) == pytest.approx(tensor, abs=1e-10 * tensor.max())


# ---------------------------------------------------------------- in space


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_in_space_each_edge_has_its_own_limit(axis: str, sign: int, tmp_path: Path) -> None:
    """The centre off along x and y: it lifts about the right edge at its own b/h."""
    still = {"kind": "half_sine", "amplitude_g": 1e-12, "duration": 1.0}
    moves = ramp(tmp_path, sign * 0.4, 2.2)
    motion = moves if axis == "x" else still | {"second": moves}
    history = run(scene(IN_SPACE, 2.2, dimension=3, motion=motion)).history
    half, off = (0.125, 0.01) if axis == "x" else (0.375, -0.03)
    wanted = (half + sign * off) / 0.55
    turn = np.hypot(history["block.angle_x_rad"], history["block.angle_y_rad"])
    found = 0.4 * lift_off(history["time_s"], turn, 1e-5, 1e-3)
    assert found == pytest.approx(wanted, rel=2e-3)
    row = int(np.flatnonzero(turn > 1e-3)[0])
    gaps = np.array([history[f"block.gap_{k}_m"][row] for k in (1, 2, 3, 4)])
    lifted = {("x", 1): (1, 2), ("x", -1): (0, 3), ("y", 1): (2, 3), ("y", -1): (0, 1)}
    assert tuple(np.flatnonzero(gaps > 1e-5)) == lifted[axis, sign]


def thrown(block: dict[str, Any], **tables: Any) -> Scene:
    """A block that spins in the air without gravity."""
    keys = {"position": [0.0, 0.0, 5.0], "angular_velocity": [2.0, -3.0, 4.0]}
    return scene(block | keys, 1.0, 1e-3, dimension=3, gravity=0.0, **tables)


TENSOR = [[62.0, 5.0, -8.0], [5.0, 46.0, 3.0], [-8.0, 3.0, 28.0]]

HELD = {"thickness": 4.0, "cells": [2, 2, 1], "kind": "elastic", "width": 4.0, "height": 0.2}


@pytest.mark.parametrize("engine", ["rigid", "meshed", "elastic"])
def test_without_a_moment_energy_and_angular_momentum_stay(engine: str) -> None:
    """About axes that are not its own: products of inertia, which a spin about no axis leaves."""
    block, tables = IN_SPACE | {"inertia": TENSOR}, {}
    if engine == "meshed":
        pytest.importorskip("dolfinx")
        tables["foundation"] = PLATE | HELD
    if engine == "elastic":
        pytest.importorskip("dolfinx")
        block = IN_SPACE | ELASTIC | {"cells": [1, 1, 2]}
        tables["damping"] = {"stiffness": 0.0}
    given = thrown(block, **tables)
    result, shape = run(given), given.blocks[0].shape
    history = result.history
    frames = boxes(history, given.blocks[0]).frames
    spin = np.stack([history[f"block.angular_velocity_{a}_rad_s"] for a in "xyz"], axis=1)
    tensor = np.array(shape.inertia_tensor)
    momentum = np.einsum("nij,jk,nlk,nl->ni", frames, tensor, frames, spin)
    size, tolerance = np.linalg.norm(momentum[0]), 1e-9 if engine != "elastic" else 1e-4
    assert np.abs(momentum - momentum[0]).max() < tolerance * size
    kinetic = history["energy.kinetic_J"]
    assert np.ptp(kinetic) < tolerance * kinetic[0]
    assert kinetic[0] == pytest.approx(0.5 * momentum[0] @ spin[0], rel=1e-6)
    assert np.ptp(spin, axis=0).min() > 0.1  # it does tumble
    place = np.stack([history[f"block.centre_{a}_m"] for a in "xyz"], axis=1)
    assert np.ptp(place, axis=0).max() < 1e-9


def test_both_rigid_engines_tumble_alike() -> None:
    """The tensor in the compiled engine, and principal axes in the one of meshed scenes."""
    pytest.importorskip("dolfinx")
    block = IN_SPACE | {"inertia": TENSOR}
    one = run(thrown(block)).history
    other = run(thrown(block, foundation=PLATE | HELD)).history
    for axis in "xyz":
        column = f"block.angular_velocity_{axis}_rad_s"
        assert other[column] == pytest.approx(one[column], abs=1e-6)


def test_a_turned_block_leans_as_the_same_block_unturned() -> None:
    """A block that is off along y rocks along y as one that is off along x rocks along x."""
    size = {"width": 0.75, "thickness": 0.25, "height": 1.0, "mass": 503.0, "model": "rigid"}
    turned = size | {"centre_of_mass": [0.0, 0.02, 0.55], "tilt_direction_deg": 90.0}
    given = scene(turned | {"tilt_deg": 3.0}, 1.0, dimension=3)
    plane = run(scene(OFF | {"tilt_deg": 3.0}, 1.0)).history
    space = run(given)
    assert -space.history["block.angle_x_rad"] == pytest.approx(plane["block.angle_rad"], abs=1e-5)
    own, other = (
        [e for e in history.events if e.kind == "impact"] for history in (space.history, plane)
    )
    assert [e.restitution for e in own] == pytest.approx([e.restitution for e in other], rel=1e-4)
    alpha = space.summary["blocks"]["block"]["peak_angle_over_alpha"]
    assert alpha == pytest.approx(math.radians(3.0) / math.atan2(0.105, 0.55), rel=1e-9)


# ---------------------------------------------------------------- places


def test_places_are_those_of_the_centre_of_mass(tmp_path: Path) -> None:
    """`position` and the columns of the centre; a block `on` another is placed by its middle."""
    air = scene(OFF | {"position": [0.3, 2.0], "tilt_deg": 20.0}, 0.01)
    history = run(air).history
    assert history["block.centre_x_m"][0] == pytest.approx(0.3, abs=1e-14)
    assert history["block.centre_y_m"][0] == pytest.approx(2.0, abs=1e-14)
    fall = history["time_s"] ** 2 * G / 2
    assert history["block.centre_y_m"] == pytest.approx(2.0 - fall, abs=1e-9)
    low = OFF | {"name": "low", "offset": 0.1}
    high = SIZE | {"name": "high", "mass": 100.0, "on": "low", "model": "rigid"}
    stack = scene(low, 0.01)
    tables = stack.to_dict()
    tables["block"].append(high)
    tables.pop("source", None)
    both = run(parse_scene(tables)).history
    assert both["low.centre_x_m"][0] == pytest.approx(0.12, abs=1e-14)
    assert both["high.centre_x_m"][0] == pytest.approx(0.1, abs=1e-14)
    assert both["high.gap_left_m"][-1] == pytest.approx(0.0, abs=1e-9)
    assert both["high.gap_right_m"][-1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("engine", ["rigid", "meshed", "elastic"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_at_rest_by_statics(engine: str, dimension: int, tmp_path: Path) -> None:
    """They carry the weight, and act below the centre of mass: so do both corners."""
    block, tables = (OFF if dimension == 2 else IN_SPACE), {}
    if engine != "rigid":
        pytest.importorskip("dolfinx")
    if engine == "meshed":
        tables["foundation"] = PLATE if dimension == 2 else PLATE | HELD
    if engine == "elastic":
        block = block | ELASTIC | {"cells": [2, 2, 4][3 - dimension :]}
    output = {"fields": "none", "pairs": True}
    given = scene(block, 0.02, dimension=dimension, output=output, **tables)
    result = run(given, folder=tmp_path / "run")
    assert result.history["block.normal_force_N"][-1] == pytest.approx(503.0 * G, rel=1e-6)
    ((_, known),) = read_pairs(tmp_path / "run" / "pairs.csv").items()
    centre = given.blocks[0].shape.centre_of_mass(dimension)
    for axis, wanted in zip("xy", centre[:-1], strict=False):
        assert known[f"{axis}_m"][-1] == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize("side", SIDES)
def test_a_carrier_that_is_uneven_is_lost_at_its_own_top(side: int) -> None:
    """A block on one whose centre is low falls off it, and lands on the ground beside it."""
    low = OFF | {"name": "low", "centre_of_mass": [0.0, 0.2], "inertia": 40.0}
    upper = {"name": "up", "on": "low", "width": 0.2, "height": 0.2, "thickness": 0.75}
    upper |= {"mass": 50.0, "model": "rigid", "velocity": [side * 1.5, 0.0], "friction": 0.05}
    tables = scene(low, 1.5).to_dict()
    tables["block"].append(upper)
    result = run(parse_scene(tables))
    lost = [e for e in result.history.events if e.kind == "carrier lost"]
    assert [e.block for e in lost] == ["up"]
    time, height = result.history["time_s"], result.history["up.centre_y_m"]
    level = np.interp(lost[0].time_s, time, height)
    assert level == pytest.approx(1.0, abs=0.02)


# ---------------------------------------------------------------- elastic


CELLS = {
    2: [{}, {"cell": "triangle"}, {"degree": 2}, {"refinement": 4.0}],
    3: [{}, {"cell": "tetrahedron"}, {"refinement": 3.0}],
}


@pytest.mark.parametrize("dimension", [2, 3])
def test_mass_centre_and_inertia_of_the_mesh(dimension: int) -> None:
    """A density that varies linearly is exact on any mesh."""
    pytest.importorskip("dolfinx")
    from solver.build.assembly import build

    for keys in CELLS[dimension]:
        block = (OFF if dimension == 2 else IN_SPACE) | ELASTIC | keys
        given = scene(block, 1.0, dimension=dimension)
        body, shape = build(given).members[0].body, given.blocks[0].shape
        assert body.mass == pytest.approx(shape.mass, rel=1e-13)
        assert body.centre == pytest.approx(shape.centre_of_mass(dimension), abs=1e-13)
        tensor = body._properties.tensor
        wanted = shape.rotary_inertia if dimension == 2 else np.array(shape.inertia_tensor)
        assert tensor == pytest.approx(np.broadcast_to(wanted, tensor.shape), abs=1e-11)


def test_mass_of_parts_of_the_mesh() -> None:
    """The mass is exact wherever their faces are; centre and inertia where cells end there."""
    pytest.importorskip("dolfinx")
    from solver.build.assembly import build

    fits = HEAVY_BOTTOM["parts"]
    cuts = [{"from": [-0.07, 0.11], "to": [0.111, 0.83], "density": 300.0}]
    for dimension, parts, exact in ((2, fits, True), (2, cuts, False), (3, cuts, False)):
        spread = [
            part
            | {
                key: [part[key][0], deep, part[key][1]]
                for key, deep in (("from", -0.3), ("to", 0.2))
            }
            for part in parts
        ]
        for keys in CELLS[dimension][:2]:
            block = HEAVY_BOTTOM | ELASTIC | keys
            block["parts"] = parts if dimension == 2 else spread
            given = scene(block, 1.0, dimension=dimension)
            body, shape = build(given).members[0].body, given.blocks[0].shape
            assert body.mass == pytest.approx(shape.mass, rel=1e-13)
            tolerance = 1e-13 if exact else 2e-3
            assert body.centre == pytest.approx(shape.centre_of_mass(dimension), abs=tolerance)


@pytest.mark.parametrize("sign", [1, -1])
def test_an_elastic_block_lifts_as_the_rigid_one(sign: int, tmp_path: Path) -> None:
    """The same scene with one word changed: within 1 % of the acceleration."""
    pytest.importorskip("dolfinx")
    moves = ramp(tmp_path, sign * 0.06, 5.0)
    block = OFF | ELASTIC | {"young": 1e12, "cells": [4, 8]}
    elastic = run(scene(block, 4.8, 2e-3, motion=moves)).history
    found = 0.06 * lift_off(elastic["time_s"], elastic["block.angle_rad"], 1e-3, 2e-2)
    assert found == pytest.approx((0.125 + sign * 0.02) / 0.55, rel=1e-2)


@pytest.mark.parametrize("block", [OFF, HEAVY_BOTTOM], ids=["centre of mass", "parts"])
def test_an_elastic_block_rocks_as_the_rigid_one(block: dict[str, Any]) -> None:
    """Up to the first impact within 1 %; after it, by its own restitution."""
    pytest.importorskip("dolfinx")
    given = scene(block | ELASTIC | {"tilt_deg": 3.0}, 0.6, None)
    result, shape = run(given), given.blocks[0].shape
    exact = housner(shape, gravity=G, tilt=math.radians(3.0), end=0.6, step=1e-3)
    (first, *_) = result.summary["blocks"]["block"]["impacts"]
    assert first["time_s"] == pytest.approx(exact.impacts[0], rel=1e-3)
    own, plastic = first["restitution"], shape.restitution(-1)
    assert plastic < own < plastic + 0.08  # elastic blocks keep more, squat ones most
    after = housner(shape, gravity=G, tilt=math.radians(3.0), end=0.6, step=1e-3, restitution=own)
    peak = result.summary["blocks"]["block"]["peaks"][1]
    assert peak["angle_rad"] == pytest.approx(abs(after.peaks[1]), rel=1e-2)
    assert peak["time_s"] == pytest.approx(float(after.time[np.argmin(after.angle)]), rel=1e-2)


# ---------------------------------------------------------------- engines


@pytest.mark.parametrize("name", ["rocking", "sliding", "stack"])
def test_rigid_blocks_in_a_meshed_scene(name: str) -> None:
    """The engine of meshed scenes, on a plate that is held, against that of rigid blocks."""
    pytest.importorskip("dolfinx")
    push = {"kind": "half_sine", "amplitude_g": 0.4, "duration": 0.3}
    tables: dict[str, Any] = {"damping": {"stiffness": 0.0}}
    blocks = [OFF | {"tilt_deg": 3.0}]
    if name != "rocking":
        flat = OFF | {"width": 0.6, "height": 0.3, "centre_of_mass": [-0.04, 0.16]}
        blocks, tables["motion"] = [flat], push
        tables["contact"] = {"friction": 0.3}
    if name == "stack":
        blocks.append(flat | {"name": "up", "on": "block", "width": 0.4, "friction": 0.2})
    made = scene(blocks[0], 0.35, **tables).to_dict()
    made["block"] = blocks
    one = run(parse_scene(made)).history
    other = simulate(parse_scene(made | {"foundation": PLATE}))
    assert other.status == "completed"
    for block in blocks:
        own = block.get("name", "block")
        for column in ("angle_rad", "centre_x_m", "centre_y_m", "slip_m"):
            whole = f"{own}.{column}"
            assert other.history[whole] == pytest.approx(one[whole], abs=1e-3), whole


def test_block_is_what_it_was_where_it_is_even() -> None:
    """A centre that is given in the middle changes nothing, to the bit."""
    plain = scene({k: v for k, v in OFF.items() if k != "centre_of_mass"}, 1.0).blocks[0].shape
    given = scene(OFF | {"centre_of_mass": [0.0, 0.5]}, 1.0).blocks[0].shape
    assert given == plain and plain.is_even
    tensor = np.diag(plain.principal_inertias).tolist()
    rows = tuple((a, b, c) for a, b, c in tensor)
    spelt = Block(**SIZE, density=plain.density, centre=(0.0, 0.0, 0.5), inertia=rows)
    for side in (0, *SIDES):
        for name in (
            "slenderness",
            "radius",
            "uplift",
            "restitution",
            "rotary_inertia_about_corner",
        ):
            own, other = (getattr(shape, name)(side) for shape in (plain, spelt))
            assert own == pytest.approx(other, rel=1e-14)
        assert plain.frequency(G, side) == pytest.approx(spelt.frequency(G, side), rel=1e-14)
