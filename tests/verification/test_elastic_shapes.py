"""Elastic blocks of all shapes, and rigid ones beside them, in the plane and in space.

Against boxes, statics, the equation of rocking with the numbers of the shape, and rigid shapes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from body_files import boxes, vase, write_by_gmsh, write_stl
from histories import lift_off
from ledger import completed
from processes import runs_on_two_ranks

from rockslip import History, Result, Scene, load_scene, parse_scene, simulate
from solver.cli import main
from solver.errors import RockslipError, SceneError
from solver.reference.housner import housner

pytest.importorskip("dolfinx")

from solver.build.assembly import build

G = 9.81

SPACE: dict[str, Any] = {"dimension": 3}

STONE = {"density": 2400.0, "young": 5e10, "poisson": 0.2}

BOX = [[-0.125, 0.0], [0.125, 0.0], [0.125, 1.0], [-0.125, 1.0]]
TRIANGLE = [[-0.3, 0.0], [0.2, 0.0], [0.05, 0.9]]
TRAPEZOID = [[-0.125, 0.0], [0.125, 0.0], [0.05, 1.0], [-0.1, 1.0]]
PENTAGON = [[-0.2, 0.0], [0.25, 0.0], [0.35, 0.6], [0.0, 1.0], [-0.3, 0.5]]


def polygon(points: list[list[float]], **keys: Any) -> dict[str, Any]:
    """An elastic block with a polygon as its section."""
    return STONE | {"shape": {"polygon": points}} | keys


def scene(
    block: dict[str, Any] | list[dict[str, Any]], end: float, step: float | None, **tables: Any
) -> Scene:
    """Blocks on firm ground; no step: adaptive ones."""
    blocks = block if isinstance(block, list) else [block]
    time = {"end": end} | ({"step": step} if step else {})
    base = {"block": blocks, "contact": {"friction": 2.0}, "time": time}
    return parse_scene(base | {"output": {"fields": "none"}} | tables)


run = partial(completed, gain=1e-6)


def impacts(result: Result) -> list[float]:
    """Times of the impacts of the only block, s."""
    return [impact["time_s"] for impact in result.summary["blocks"]["block"]["impacts"]]


# ---------------------------------------------------------------- in the plane


@pytest.mark.slow
@pytest.mark.parametrize("degree", [1, 2])
def test_a_polygon_that_is_a_box_does_what_the_box_does(degree: int) -> None:
    """To the first impact and over two more, but for the mesh."""
    release = {"tilt_deg": 3.0, "degree": degree}
    box = run(scene(STONE | {"width": 0.25, "height": 1.0} | release, 1.0, None))
    same = run(scene(polygon(BOX) | release, 1.0, None))
    one, other = impacts(box), impacts(same)
    assert len(one) >= 3
    assert other[0] == pytest.approx(one[0], rel=1e-4)
    assert other[1:3] == pytest.approx(one[1:3], rel=1e-2)
    rows = slice(0, None, 20)
    early = box.history["time_s"][rows] < one[0]
    angle = np.interp(
        box.history["time_s"][rows][early], same.history["time_s"], same.history["block.angle_rad"]
    )
    assert angle == pytest.approx(box.history["block.angle_rad"][rows][early], abs=3e-5)


ELL = [[0.0, 0.0], [0.6, 0.0], [0.6, 0.2], [0.2, 0.2], [0.2, 0.9], [0.0, 0.9]]
LEGS = [
    {"polygon": [[0.0, 0.0], [0.2, 0.0], [0.2, 0.9], [0.0, 0.9]]},
    {"polygon": [[0.0, 0.0], [0.4, 0.0], [0.4, 0.2], [0.0, 0.2]], "at": [0.2, 0.0]},
]
FEET = {"width": 0.8, "height": 1.6, "feet": {"inset": 0.1, "size": 0.08, "height": 0.06}}
LIFTED: dict[str, dict[str, Any]] = {
    "triangle": {"shape": {"polygon": TRIANGLE}},
    "pentagon": {"shape": {"polygon": PENTAGON}},
    "trapezoid": {"shape": {"polygon": TRAPEZOID}},
    "L": {"shape": {"polygon": ELL}},
    "union": {"shape": {"union": LEGS}},
    "feet": FEET,
}


@pytest.mark.parametrize(
    ("name", "side"),
    [
        *(("triangle", -1), ("triangle", 1), ("pentagon", -1), ("trapezoid", 1)),
        *(("L", -1), ("L", 1), ("union", 1), ("feet", -1)),
    ],
)
def test_shapes_lift_at_their_own_arm_over_height(name: str, side: int, tmp_path: Path) -> None:
    """As the ground's acceleration grows slowly, to within 1 %: the ends of the bottom differ."""
    block = STONE | LIFTED[name] | {"young": 1e12, "cell_size": 0.15}
    limit = scene(block, 1.0, 2e-3).blocks[0].shape.uplift(side)
    file = tmp_path / "ramp.csv"
    slope, end = limit / 2.0, 2.4
    file.write_text(f"0,0\n{end!r},{-side * slope * end!r}\n")
    motion = {"kind": "table", "file": str(file)}
    history = run(scene(block, end, 2e-3, motion=motion)).history
    angle = history["block.angle_rad"]
    found = slope * lift_off(history["time_s"], angle, 1e-3, 2e-2)
    assert found == pytest.approx(limit, rel=1e-2)
    assert np.sign(angle[np.abs(angle) > 1e-3][0]) == side


@pytest.mark.parametrize("tilt", [3.0, -3.0])
def test_a_trapezoid_rocks_as_the_rigid_one(tilt: float) -> None:
    """To the first impact; after it as a rigid one that keeps as much."""
    given = scene(polygon(TRAPEZOID, tilt_deg=tilt), 0.8, None)
    result, shape = run(given), given.blocks[0].shape
    exact = housner(shape, gravity=G, tilt=math.radians(tilt), end=0.8, step=1e-3)
    rigid = simulate(scene(polygon(TRAPEZOID, tilt_deg=tilt, model="rigid"), 0.8, 1e-3))
    (first, second, *_) = result.summary["blocks"]["block"]["impacts"]
    assert first["time_s"] == pytest.approx(exact.impacts[0], rel=1e-3)
    assert first["time_s"] == pytest.approx(impacts(rigid)[0], rel=2e-3)
    own, plastic = first["restitution"], shape.restitution(-1 if tilt > 0 else 1)
    assert plastic - 0.01 < own < plastic + 0.08
    after = housner(shape, gravity=G, tilt=math.radians(tilt), end=0.8, step=1e-3, restitution=own)
    assert second["time_s"] == pytest.approx(after.impacts[1], rel=1.5e-2)


@pytest.mark.parametrize("count", [6, 8])
def test_a_regular_polygon_rolls_down_an_incline(count: int) -> None:
    """Over its edge, elastic as rigid until its next side lands; then it rolls on.

    Farther over the edge than where it balances: there all that shakes it at the start would grow.
    """
    slope = 180.0 / count + 10.0
    block = STONE | {"shape": {"regular": count}, "width": 0.6}
    tables = {"gravity_tilt_deg": slope}
    rigid = simulate(scene(block | {"model": "rigid"}, 1.0, 1e-3, **tables))
    turn = 2 * math.pi / count
    end = float(np.interp(turn, rigid.history["block.angle_rad"], rigid.history["time_s"]))
    elastic = run(scene(block, 1.3 * end, None, **tables))
    at = np.linspace(0.3, 0.98, 20) * end
    one, other = (
        np.interp(at, each.history["time_s"], each.history["block.angle_rad"])
        for each in (rigid, elastic)
    )
    assert one[-1] > 0.8 * turn
    assert other == pytest.approx(one, rel=1e-2)
    assert elastic.history["block.angle_rad"][-1] > turn


def test_a_rigid_drum_rolls_on_a_plate_without_slip() -> None:
    """As on the ground to its first landing; then over five sides, none of which is slip.

    It hops as its sides land, and what it flies is in that column, too.
    """
    drum = {"model": "rigid", "shape": {"regular": 16}, "width": 0.6, "density": 2400.0}
    drum |= {"offset": -1.0, "friction": 2.0}
    plate = {"kind": "elastic", "support": "bottom", "width": 6.0, "height": 0.2, "cells": [60, 1]}
    plate |= {"density": 2400.0, "young": 3e10, "poisson": 0.2, "damping": {"stiffness": 1e-4}}
    tables = {"gravity_tilt_deg": 20.0}
    rigid = simulate(scene(drum, 1.0, 1e-3, **tables))
    meshed = run(scene(drum, 1.0, None, foundation=plate, **tables)).history
    side = 0.6 * math.sin(math.pi / 16)
    end = float(np.interp(math.pi / 8, rigid.history["block.angle_rad"], rigid.history["time_s"]))
    at = np.linspace(0.3, 0.98, 20) * end
    one, other = (
        np.interp(at, each["time_s"], each["block.angle_rad"]) for each in (rigid.history, meshed)
    )
    assert other == pytest.approx(one, rel=1e-2)
    assert np.ptp(meshed["block.centre_x_m"]) > 5.0 * side
    assert np.abs(meshed["block.slip_m"]).max() < 0.3 * side


@pytest.mark.parametrize("tilt", [0.0, 1e-9, -1e-9])
def test_round_off_does_not_decide_which_sides_face_the_ground(tilt: float) -> None:
    """Those beside the bottom of a hexagon are 60 degrees off, and have their points there."""
    from solver.build.assembly import build, initial_state

    given = scene(STONE | {"shape": {"regular": 6}, "width": 0.6, "tilt_deg": tilt}, 0.01, 1e-3)
    assembly = build(given)
    state, _ = assembly.stepper.advance(initial_state(given, assembly)[0], 1e-3)
    assert len(state.active[0].faces) == 3


def test_a_wedge_and_a_box_collide() -> None:
    """In the air without gravity: momentum stays, energy is never gained, and they part."""
    wedge = polygon([[-0.3, 0.0], [0.3, 0.0], [-0.3, 0.5]], name="wedge", young=1e9)
    wedge |= {"position": [0.0, 3.0], "velocity": [2.0, 0.0]}
    box = STONE | {"name": "box", "width": 0.4, "height": 0.4, "young": 1e9}
    box |= {"position": [0.75, 3.1]}
    given = scene([wedge, box], 0.4, 5e-4, gravity=0.0)
    result = run(given)
    history = result.history
    masses = {block.name: block.shape.mass for block in given.blocks}
    place = sum(m * history[f"{name}.centre_x_m"] for name, m in masses.items())
    speed = np.gradient(place, history["time_s"]) / masses["wedge"]
    assert speed == pytest.approx(np.full(len(speed), 2.0), abs=1e-6)
    travelled = history["box.centre_x_m"][-1] - history["box.centre_x_m"][0]
    assert travelled > 0.1
    first = history.events[0]
    assert {first.block, first.meets} == {"wedge", "box"}
    # The slope of the wedge passes the place of the box's lower left corner, 0.14 m up.
    corner, level = 0.75 - 0.2, 3.1 - 0.2
    foot, height = -0.3 + 0.2, 3.0 - 0.5 / 3
    reach = foot + 0.6 * (1 - (level - height) / 0.5) - 0.1
    assert first.time_s == pytest.approx((corner - reach) / 2.0, abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("dimension", "sizes", "error"),
    [(2, (0.2, 0.2), 2e-4), (2, (0.2, 0.16), 0.02), (3, (0.25, 0.2), 0.02)],
)
def test_a_column_of_two_shapes_has_the_pressure_of_its_weight(
    dimension: int, sizes: tuple[float, float], error: float
) -> None:
    """Stresses in the middle of cells, beside weight over area, over the pressure between both.

    Where their meshes match it is exact but for strains of 4e-5, else as off as between boxes: it
    has no common refinement.
    """
    import ufl
    from dolfinx import fem
    from dolfinx.mesh import compute_midpoints

    from solver.bodies.elastic_forms import green_strain
    from solver.build.assembly import initial_state

    stone = {"density": 2000.0, "young": 1e9, "poisson": 0.0, "degree": 2}
    if dimension == 2:
        half = {"shape": {"polygon": [[-0.5, 0.0], [0.5, 0.0], [0.5, 1.0], [-0.5, 1.0]]}}
    else:
        half = {"shape": {"cylinder": 1.0, "sides": 6}, "height": 1.0}
    low = stone | half | {"name": "low", "cell_size": sizes[0]}
    top = stone | half | {"name": "top", "on": "low", "cell_size": sizes[1]}
    contact = {"friction": 0.5, "points": "gauss"}
    case = scene([low, top], 0.01, 1e-3, contact=contact, dimension=dimension)
    assembly = build(case)
    state, remark = initial_state(case, assembly)
    assert not remark
    pressure = 2000.0 * G
    for member, own in zip(assembly.members, assembly.stepper.system.slices, strict=False):
        body = member.body
        body.u.x.array[:] = state.u[own]
        strain = green_strain(ufl.grad(body.u))
        cells = fem.functionspace(body.space.mesh, ("DG", 0))
        places = cells.element.interpolation_points
        stress = fem.Function(cells)
        up = 2 * body.material.shear * strain[dimension - 1, dimension - 1]
        given = fem.Expression(up, places() if callable(places) else places)
        stress.interpolate(given)
        count = cells.dofmap.index_map.size_local
        numbers = np.arange(count, dtype=np.int32)
        middle = compute_midpoints(body.space.mesh, dimension, numbers)[:, dimension - 1]
        off = stress.x.array[:count] / body.thickness + pressure * (2.0 - middle)
        assert np.abs(off).max() < error * pressure


# ---------------------------------------------------------------- in space

CYLINDER = {"shape": {"cylinder": 0.5, "sides": 12}, "height": 1.0}
TETRAHEDRON = {"shape": {"profile": [[0.0, 0.0], [0.4, 0.0], [0.0, 0.6]], "sides": 3}}
HEXAGON = {"shape": {"regular": 6}, "width": 0.6, "thickness": 0.5}
WEDGE = {"shape": {"polygon": TRIANGLE}, "thickness": 0.5}


@pytest.mark.parametrize("shape", [CYLINDER, TETRAHEDRON, HEXAGON, WEDGE], ids=str)
def test_shapes_stand_in_space(shape: dict[str, Any]) -> None:
    """With their weight, closed, and at rest."""
    given = scene(STONE | shape, 0.02, 1e-3, dimension=3)
    history = run(given).history
    weight = given.blocks[0].shape.mass * G
    assert history["block.normal_force_N"] == pytest.approx(weight, rel=1e-7)
    gaps = np.array([history[f"block.gap_{k}_m"] for k in (1, 2, 3, 4)])
    assert np.abs(gaps).max() < 1e-8
    assert np.abs(history["block.slip_m"]).max() < 1e-8


@pytest.mark.parametrize("direction", [0.0, 40.0])
def test_a_cylinder_leans_as_the_rigid_one(direction: float) -> None:
    """Released over an edge and over a corner of its bottom, up to its first impact."""
    lean = {"tilt_deg": 5.0, "tilt_direction_deg": direction}
    rigid = simulate(scene(STONE | CYLINDER | lean | {"model": "rigid"}, 0.3, 1e-3, dimension=3))
    elastic = run(scene(STONE | CYLINDER | lean, 0.3, 5e-4, dimension=3)).history
    assert_lean_alike(rigid, elastic, start=0.2, degrees=5.0)


def assert_lean_alike(rigid: Result, elastic: History, *, start: float, degrees: float) -> None:
    """Within 1 % of the release, from a part of the time of the first impact up to it."""
    at = np.linspace(start, 0.95, 20) * impacts(rigid)[0]
    for key in ("angle_x_rad", "angle_y_rad"):
        one, other = (
            np.interp(at, each["time_s"], each[f"block.{key}"]) for each in (rigid.history, elastic)
        )
        assert other == pytest.approx(one, abs=1e-2 * math.radians(degrees))


def test_a_tetrahedron_slides() -> None:
    """Obliquely, and slowed by friction alone: v t - mu g t^2/2."""
    keys = {"velocity": [0.6, 0.8, 0.0]}
    contact = {"friction": 0.1}
    history = run(
        scene(STONE | TETRAHEDRON | keys, 0.3, 1e-3, dimension=3, contact=contact)
    ).history
    time = history["time_s"]
    way = np.hypot(
        *(history[f"block.centre_{x}_m"] - history[f"block.centre_{x}_m"][0] for x in "xy")
    )
    assert way == pytest.approx(time - 0.1 * G * time**2 / 2, abs=3e-4)


@pytest.mark.parametrize(
    ("below", "above", "off"),
    [
        (CYLINDER, CYLINDER, 1e-5),
        (CYLINDER, CYLINDER | {"model": "rigid"}, 1e-3),  # more points than nodes below
        (CYLINDER | {"model": "rigid"}, CYLINDER, 1e-5),
        ({"width": 0.6, "height": 0.3, "thickness": 0.6, "cells": [3, 3, 2]}, HEXAGON, 1e-5),
        (CYLINDER, {"width": 0.7, "height": 0.3, "thickness": 0.2, "cells": [6, 2, 2]}, 1e-5),
    ],
    ids=["equal", "rigid on elastic", "elastic on rigid", "prism on box", "box across"],
)
def test_shapes_stand_on_one_another(
    below: dict[str, Any], above: dict[str, Any], off: float
) -> None:
    """The edges of their faces cross; both weights arrive."""
    blocks = [
        STONE | {"name": "low", "young": 1e9} | below,
        STONE | {"name": "top", "on": "low", "young": 1e9, "offset": 0.05} | above,
    ]
    given = scene(blocks, 0.02, 1e-3, dimension=3)
    history = run(given).history
    low, top = (block.shape.mass * G for block in given.blocks)
    assert history["top.normal_force_N"] == pytest.approx(top, rel=off)
    assert history["low.normal_force_N"] == pytest.approx(low + top, rel=off)
    assert np.abs(history["top.slip_m"]).max() < 1e-6


BOX_OF_THREE = {"width": 0.6, "height": 0.6, "cells": [3, 3]}
CUBE_OF_THREE = {"width": 0.6, "height": 0.6, "thickness": 0.6, "cells": [3, 3, 3]}


@pytest.mark.parametrize(
    ("dimension", "below", "above"),
    [
        (2, {"shape": {"regular": 12}, "width": 0.6}, {"shape": {"regular": 12}, "width": 0.8}),
        (2, BOX_OF_THREE, {"width": 0.8, "height": 0.3}),
        (3, CUBE_OF_THREE, {"width": 0.8, "height": 0.3, "thickness": 0.8}),
    ],
    ids=["twelve corners", "box", "box in space"],
)
def test_forces_at_more_points_than_nodes_stay(
    dimension: int, below: dict[str, Any], above: dict[str, Any]
) -> None:
    """A rigid block on an elastic one that ends under it: its grid, and the outline of that.

    Nothing tells these forces from one another: as they drifted, those of a block at rest changed.
    """
    low = STONE | {"name": "low"} | below
    top = STONE | {"name": "top", "on": "low", "model": "rigid"} | above
    contact = {"friction": 0.5}
    given = scene([low, top], 0.02, 1e-3, dimension=dimension, contact=contact)
    history = run(given).history
    weight = given.blocks[1].shape.mass * G
    assert history["top.normal_force_N"] == pytest.approx(weight, rel=1e-7)
    assert history["newton_iterations"].max() <= 2


def test_light_block_hits_a_meshed_one_in_short_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """What keeps forces from round-off takes nothing of an impact, however short its steps.

    It was 4 % of what a force moves the block by in such a step: the force was 0.3 % too small.
    """
    low = STONE | {"name": "low", "width": 10.0, "height": 2.0, "cells": [5, 2], "young": 1e10}
    light = {"name": "light", "on": "low", "model": "rigid", "density": 1.0, "width": 4.0}
    leans = {"height": 1.0, "tilt_deg": 0.001, "angular_velocity": -0.3}
    given = scene([low, light | leans], 2e-4, 1e-5)
    force = simulate(given).history["light.normal_force_N"].max()
    monkeypatch.setattr("solver.stepping.delassus.WEIGHT_OVER_ROUND_OFF", 0.0)
    free = simulate(given).history["light.normal_force_N"].max()
    assert force > 500 * given.blocks[1].shape.mass * G
    assert force == pytest.approx(free, rel=5e-5)


# ---------------------------------------------------------------- hollow ones, and feet


def test_arms_of_an_l_and_of_feet_are_those_of_statics() -> None:
    """Of two rectangles, 0.2 x 0.9 and 0.4 x 0.2; of a box between its pads, g c/h_c."""
    block = scene(polygon(ELL), 0.1, 1e-3).blocks[0].shape
    first, second = 0.18, 0.08
    x, y = (first * 0.1 + second * 0.4) / 0.26, (first * 0.45 + second * 0.1) / 0.26
    assert block.uplift(-1) == pytest.approx(x / y, rel=1e-12)
    assert block.uplift(1) == pytest.approx((0.6 - x) / y, rel=1e-12)
    feet = scene(STONE | FEET, 0.1, 1e-3).blocks[0].shape
    assert feet.uplift(1) == pytest.approx((0.4 - 0.1) / (0.8 + 0.06), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "tilt"), [("L", 3.0), ("L", -3.0), ("union", -3.0), ("feet", 3.0)]
)
def test_hollow_shapes_rock_as_rigid_ones(name: str, tilt: float) -> None:
    """Up to the first impact."""
    block = STONE | LIFTED[name] | {"tilt_deg": tilt}
    rigid = simulate(scene(block | {"model": "rigid"}, 0.4, 1e-3))
    elastic = run(scene(block, 0.4, None))
    end = impacts(rigid)[0]
    assert impacts(elastic)[0] == pytest.approx(end, rel=2e-3)
    at = np.linspace(0.1, 0.98, 20) * end
    one, other = (
        np.interp(at, each.history["time_s"], each.history["block.angle_rad"])
        for each in (rigid, elastic)
    )
    assert other == pytest.approx(one, abs=1e-2 * math.radians(3.0))


def test_a_toppled_l_lies_on_the_corners_that_span_its_notch() -> None:
    """On the tips of both legs, its centre as high over the line between them as geometry says."""
    block = polygon(ELL, young=1e9, tilt_deg=80.0, angular_velocity=4.0)
    given = scene(block, 1.0, 1e-3)
    history = run(given).history
    slant = math.degrees(math.atan2(0.7, -0.4))
    angle = np.degrees(history["block.angle_rad"])
    assert angle[-1] == pytest.approx(slant, abs=0.01)
    assert history["block.penetration_m"].max() < 1e-4
    centre = np.array(given.blocks[0].shape.centre_of_mass(2)) + np.array([0.3, 0.0])
    way, off = np.array([-0.4, 0.7]), centre - [0.6, 0.2]
    height = abs(way[0] * off[1] - way[1] * off[0]) / math.hypot(*way)
    assert history["block.centre_y_m"][-1] == pytest.approx(height, abs=1e-4)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("model", ["elastic", "rigid"])
@pytest.mark.parametrize("carrier", ["ground", "slab"])
def test_pads_bear_what_statics_says(dimension: int, model: str, carrier: str) -> None:
    """Each its share where the weight is in the middle; off it by moments, but for their width."""
    count, size = 2 ** (dimension - 1), 0.04
    feet = {"inset": 0.08, "size": size, "height": 0.06}
    block = STONE | {"width": 0.8, "height": 1.0, "model": model, "feet": feet}
    blocks = [{"name": "slab", "width": 1.2, "height": 0.3, "model": "elastic"}]
    if dimension == 3:
        block |= {"thickness": 0.6, "cell_size": 0.25}
        blocks[0] |= {"thickness": 1.2, "cells": [6, 6, 2]}
    block |= {"name": "block"} | ({"on": "slab"} if carrier == "slab" else {})
    under = [STONE | blocks[0]] if carrier == "slab" else []
    for e in (0.0, 0.06):
        off = {"centre_of_mass": [e, *[0.0] * (dimension - 2), 0.5]} if e else {}
        given = scene([*under, block | off], 0.004, 1e-3, dimension=dimension)
        if given.is_rigid:
            continue
        history = run(given).history
        weight = given.blocks[-1].shape.mass * G
        found = [history[f"block.foot_{k + 1}.normal_force_N"][-1] for k in range(count)]
        assert sum(found) == pytest.approx(history["block.normal_force_N"][-1], rel=1e-9)
        assert sum(found) == pytest.approx(weight, rel=1e-5)
        right = found[1] if dimension == 2 else found[1] + found[2]
        reach = 0.8 / 2 - 0.08 - size / 2
        share = 0.5 * (1 + e / reach)
        if not e:
            # In space the mesh is not its own mirror image.
            assert found == pytest.approx([weight / count] * count, rel=10.0 ** (-5 + dimension))
        assert right / weight == pytest.approx(share, abs=0.5 * size / (2 * reach))


@pytest.mark.parametrize(("width", "offset"), [(0.2, 0.25), (0.2, -0.25), (0.7, 0.0)])
@pytest.mark.parametrize("models", [("elastic", "elastic"), ("elastic", "rigid")])
def test_a_box_stands_on_prongs(models: tuple[str, str], width: float, offset: float) -> None:
    """On one of two whose edges are flush with its own, or on both: it is carried and upright."""
    prongs = [[0.0, 0.0], [0.7, 0.0], [0.7, 0.6], [0.5, 0.6], [0.5, 0.2], [0.2, 0.2], [0.2, 0.6]]
    low = polygon([*prongs, [0.0, 0.6]], name="low", model=models[0], young=1e9)
    top = STONE | {"name": "top", "on": "low", "width": width, "height": 0.3, "offset": offset}
    given = scene([low, top | {"model": models[1]}], 0.03, 1e-3)
    history = run(given).history
    weight = given.blocks[1].shape.mass * G
    assert history["top.normal_force_N"] == pytest.approx(weight, rel=1e-6)
    assert np.abs(history["top.angle_rad"]).max() < 2e-5


@pytest.mark.parametrize("models", [("elastic", "elastic"), ("elastic", "rigid")])
def test_a_box_stands_between_prongs(models: tuple[str, str]) -> None:
    """On the floor between two, which the hull spans: carried and upright from the start."""
    prongs = [[0.0, 0.0], [0.7, 0.0], [0.7, 0.6], [0.5, 0.6], [0.5, 0.5], [0.2, 0.5], [0.2, 0.6]]
    low = polygon([*prongs, [0.0, 0.6]], name="low", model=models[0], young=1e9)
    top = STONE | {"name": "top", "on": "low", "width": 0.2, "height": 0.4, "offset": 0.03}
    given = scene([low, top | {"model": models[1]}], 0.03, 1e-3)
    history = run(given).history
    assert history["top.centre_y_m"] == pytest.approx(0.5 + 0.2, abs=2e-5)
    weight = given.blocks[1].shape.mass * G
    assert history["top.normal_force_N"] == pytest.approx(weight, rel=1e-6)
    assert np.abs(history["top.angle_rad"]).max() < 2e-5
    with pytest.raises(SceneError, match=r"top\.on names low, beside whose top it stands"):
        scene([low, top | {"height": 0.1}], 0.03, 1e-3)


@pytest.mark.parametrize("model", ["elastic", "rigid"])
def test_a_box_flies_into_the_notch_of_an_l(model: str) -> None:
    """Without gravity: it touches the leg, not the hull, and momentum stays."""
    ell = polygon(ELL, name="ell", model=model, young=1e9) | {"position": [0.0, 2.0]}
    box = STONE | {"name": "box", "width": 0.2, "height": 0.2, "young": 1e9}
    corner = np.array([0.0, 2.0]) - scene(ell, 0.1, 1e-3).blocks[0].shape.centre_of_mass(2)
    leg = corner[0] - 0.3 + 0.2  # its right side; the foot's top is 0.2 above the bottom
    box |= {"position": [leg + 0.1 + 0.05, corner[1] + 0.2 + 0.1 + 0.03], "velocity": [-1.0, 0.0]}
    given = scene([ell, box], 0.15, 5e-4, gravity=0.0)
    history = run(given).history
    masses = {block.name: block.shape.mass for block in given.blocks}
    place = sum(m * history[f"{name}.centre_x_m"] for name, m in masses.items())
    speed = np.gradient(place, history["time_s"]) / masses["box"]
    assert speed == pytest.approx(np.full(len(speed), -1.0), abs=1e-6)
    assert history.events[0].time_s == pytest.approx(0.05, abs=1e-3)
    assert history["ell.centre_x_m"][-1] < -0.005


def assert_stands_with_all_of_its_mass(given: Scene) -> None:
    """A block whose surface is far from its hull: mass and centre of its mesh, and its weight."""
    solid = given.blocks[0].shape.solid
    assert solid is not None and solid.hull_excess > 0.1
    member = build(given).members[0].body
    assert member.mass == pytest.approx(solid.mass, rel=1e-12)
    assert member.centre == pytest.approx(solid.centre, abs=5e-3 * solid.size)
    history = run(given).history
    assert history["block.normal_force_N"] == pytest.approx(solid.mass * G, rel=1e-6)
    gaps = np.array([history[f"block.gap_{k}_m"] for k in (1, 2, 3, 4)])
    assert np.abs(gaps).max() < 1e-9


@pytest.mark.slow
def test_a_vase_is_meshed_by_its_true_surface(tmp_path: Path) -> None:
    """All of its mass, its centre but for the chords of cells; it stands, and leans as if rigid.

    In the direction of a side of its foot.
    """
    shape = {"shape": {"file": str(write_stl(tmp_path / "vase.stl", *vase(48, 20)))}}
    given = scene(STONE | shape, 0.01, 1e-3, dimension=3)
    assert_stands_with_all_of_its_mass(given)
    lean = {"tilt_deg": 4.0, "tilt_direction_deg": 33.75}
    rigid = simulate(scene(STONE | shape | lean | {"model": "rigid"}, 0.12, 2e-4, dimension=3))
    elastic = run(scene(STONE | shape | lean, 0.12, None, dimension=3)).history
    assert_lean_alike(rigid, elastic, start=0.1, degrees=4.0)


CUP = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.5], [0.15, 0.5], [0.15, 0.1], [0.0, 0.1]]
TUBE = [[0.1, 0.0], [0.2, 0.0], [0.25, 0.5], [0.12, 0.5]]


@pytest.mark.parametrize("profile", [CUP, TUBE], ids=["cup", "tube"])
def test_a_hollow_profile_is_meshed_by_its_true_surface(profile: list[list[float]]) -> None:
    """All of its mass, and its centre; it stands."""
    keys = {"shape": {"profile": profile, "sides": 24}, "cell_size": 0.05}
    assert_stands_with_all_of_its_mass(scene(STONE | keys, 0.01, 1e-3, **SPACE))


def test_a_union_with_a_hollow_profile_is_refused_where_it_is_elastic() -> None:
    shape = {"profile": TUBE, "sides": 12}
    both = {"union": [shape, {"cylinder": 0.1, "height": 0.1, "at": [0.0, 0.0, 0.5]}]}
    with pytest.raises(SceneError, match=r"shape: got a union with a file or a hollow profile"):
        scene(STONE | {"shape": both}, 0.01, 1e-3, dimension=3)


@pytest.mark.slow
def test_a_vase_lifts_at_its_own_arm_over_height(tmp_path: Path) -> None:
    """As the ground's acceleration grows slowly, to within 1 %."""
    shape = {"shape": {"file": str(write_stl(tmp_path / "vase.stl", *vase(48, 20)))}}
    limit = scene(STONE | shape, 1.0, 2e-3, **SPACE).blocks[0].shape.uplift(1)
    file, slope, end = tmp_path / "ramp.csv", limit / 2.0, 2.4
    file.write_text(f"0,0\n{end!r},{-slope * end!r}\n")
    motion = {"kind": "table", "file": str(file)}
    history = run(scene(STONE | shape, end, 2e-3, motion=motion, **SPACE)).history
    found = slope * lift_off(history["time_s"], history["block.angle_rad"], 1e-3, 2e-2)
    assert found == pytest.approx(limit, rel=1e-2)


SIDES = {"width": 0.3, "thickness": 0.4, "height": 0.8}
GRID = [np.linspace(-0.15, 0.15, 4), np.linspace(-0.2, 0.2, 5), np.linspace(0.0, 0.8, 7)]


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_a_mesh_is_taken_as_it_is(cell: str, tmp_path: Path) -> None:
    """That of a box, with and without groups, away from the origin, does what the box does."""
    import gmsh

    from geometry.gmsh_model import box as gridded

    def make() -> None:
        x, y, z = GRID
        gridded(x + 3.0, y, z - 1.0, tetrahedra=cell == "tetrahedron")
        if cell == "tetrahedron":
            gmsh.model.removePhysicalGroups()

    version = 4.1 if cell == "hexahedron" else 2.2
    file = write_by_gmsh(tmp_path / "box.msh", make, version)
    lean = {"tilt_deg": 4.0, "tilt_direction_deg": 20.0}
    box = run(scene(STONE | SIDES | lean | {"cells": [3, 4, 6], "cell": cell}, 0.1, 5e-4, **SPACE))
    same = run(scene(STONE | lean | {"shape": {"file": str(file)}}, 0.1, 5e-4, **SPACE))
    for key in ("angle_x_rad", "angle_y_rad", "centre_x_m", "slip_m"):
        one, other = (each.history[f"block.{key}"] for each in (box, same))
        offset = other[0] - one[0]
        assert other - offset == pytest.approx(one, abs=1e-11), key


def test_a_step_file_is_meshed_in_its_own_units(tmp_path: Path) -> None:
    """A box in millimetres rocks as the box."""
    make = partial(boxes, (-150.0, -200.0, 0.0, 300.0, 400.0, 800.0))
    shape = {"shape": {"file": str(write_by_gmsh(tmp_path / "box.step", make))}}
    box = run(scene(STONE | SIDES | {"tilt_deg": 4.0}, 0.15, 5e-4, **SPACE))
    given = scene(STONE | shape | {"tilt_deg": 4.0}, 0.15, 5e-4, **SPACE)
    assert given.blocks[0].shape.mass == pytest.approx(2400.0 * 0.3 * 0.4 * 0.8, rel=1e-12)
    same = run(given)
    for key, off in (("angle_x_rad", 1e-6), ("angle_y_rad", 1e-6)):
        one, other = (each.history[f"block.{key}"] for each in (box, same))
        assert other == pytest.approx(one, abs=off), key


def bad_files(folder: Path) -> Iterator[tuple[Path, str]]:
    """Files of which no elastic block can be made, and what is said of them."""
    cube = (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    two = cube, (2.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    large = (0.0, 0.0, 0.0, 900.0, 900.0, 900.0)
    points, triangles = vase(12, 6)
    kinds: list[tuple[str, Callable[[], None], str]] = [
        ("two.step", partial(boxes, *two), "got 2 solids, allowed one"),
        ("two.msh", partial(boxes, *two, size=0.5), "got 2 pieces that have no facet in common"),
        ("shell.msh", partial(boxes, cube, size=0.5, dimension=2), "got no cells in space"),
        ("large.msh", partial(boxes, large, size=400.0), "looks like millimetres: scale = 0.001"),
    ]
    for name, make, said in kinds:
        yield write_by_gmsh(folder / name, make), said
    yield write_stl(folder / "open.stl", points, triangles[3:]), "open edge"
    both = np.concatenate([triangles, triangles + len(points)])
    apart = np.concatenate([points, points + np.array([1.0, 0.0, 0.0])])
    yield write_stl(folder / "two.stl", apart, both), "got 2 bodies apart, allowed one"
    for name, text, said in (
        ("junk.step", b"solid", "does not begin with ISO-10303-21"),
        ("empty.msh", b"", "got an empty file"),
    ):
        (folder / name).write_bytes(text)
        yield folder / name, said


def test_bad_files_are_refused_in_a_line(tmp_path: Path) -> None:
    """With the name of the key and of the file."""
    for file, said in bad_files(tmp_path):
        with pytest.raises(RockslipError) as error:
            build(scene(STONE | {"shape": {"file": str(file)}}, 0.1, 1e-3, **SPACE))
        assert error.value.exit_code == 2
        assert str(error.value).startswith("block.shape"), file
        assert said in str(error.value), str(error.value)
        assert "\n" not in str(error.value)


def test_parts_that_do_not_touch_are_no_elastic_body() -> None:
    """In one line, when it is meshed."""
    apart = {"union": [LEGS[0], LEGS[1] | {"at": [0.5, 0.0]}]}
    with pytest.raises(RockslipError, match="got 2 pieces that have no face in common"):
        build(scene(STONE | {"shape": apart}, 0.1, 1e-3))


# ---------------------------------------------------------------- runs

SHAKEN = """
[[block]]
shape = { polygon = [[-0.2, 0.0], [0.2, 0.0], [0.1, 1.0], [-0.15, 1.0]] }
density = 2400.0
young = 5.0e9
poisson = 0.2
tilt_deg = 2.0
[contact]
friction = 0.5
[time]
end = 0.3
step = 1.0e-3
[output]
fields = "none"
"""

HOLLOW = SHAKEN.replace("[[-0.2, 0.0], [0.2, 0.0], [0.1, 1.0], [-0.15, 1.0]]", f"{ELL}")
ON_FEET = HOLLOW.replace(
    HOLLOW[HOLLOW.index("shape") : HOLLOW.index("density")],
    "width = 0.6\nheight = 1.0\nfeet = { inset = 0.05, size = 0.1, height = 0.05 }\n",
)
IN_SPACE = SHAKEN.replace("[[block]]", "dimension = 3\n[[block]]\nthickness = 0.4").replace(
    "end = 0.3", "end = 0.1"
)


VASE = IN_SPACE.replace(
    IN_SPACE[IN_SPACE.index("thickness") : IN_SPACE.index("density")],
    'shape = { file = "vase.stl" }\n',
)
ON_RANKS = {"plane": SHAKEN, "space": IN_SPACE, "L": HOLLOW, "feet": ON_FEET, "vase": VASE}


@pytest.fixture(scope="module")
def on_two_ranks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds the scenes and their runs on two ranks."""
    folder = tmp_path_factory.mktemp("ranks")
    write_stl(folder / "vase.stl", *vase(24, 12))
    for name, text in ON_RANKS.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    runs_on_two_ranks(folder, *ON_RANKS)
    return folder


@pytest.mark.mpi
@pytest.mark.parametrize("name", ON_RANKS)
def test_ranks_agree(name: str, on_two_ranks: Path) -> None:
    """One and two ranks, to 1e-8 of the angle and of lengths."""
    one = simulate(load_scene(on_two_ranks / f"{name}.toml")).history
    two = History.read(on_two_ranks / name / "history.csv")
    for key, size in (("angle_rad", 0.035), ("slip_m", 0.4), ("centre_x_m", 0.4)):
        column = f"block.{key}"
        assert two[column] == pytest.approx(one[column], abs=1e-8 * size), column


def test_a_run_goes_on_from_a_checkpoint(tmp_path: Path) -> None:
    """To the digit, as one that was not interrupted."""
    text = SHAKEN + "checkpoint = { steps = 100 }\n"
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    simulate(parse_scene(text), folder=whole)
    simulate(parse_scene(text.replace("end = 0.3", "end = 0.1")), folder=parts)
    assert main(["run", "-q", "--resume", str(parts), "--set", "time.end=0.3"]) == 0
    one, other = (History.read(folder / "history.csv") for folder in (whole, parts))
    for key in ("angle_rad", "slip_m", "normal_force_N"):
        assert np.array_equal(one[f"block.{key}"], other[f"block.{key}"]), key
