"""Rigid blocks that are no boxes: lifting, impacts, rolling; feet; a shape from a file."""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geometry.block import Block
from rockslip import Result, parse_scene, simulate
from solver.types import Array

G = 9.81


def run(
    block: dict[str, Any], *, end: float, step: float = 1e-3, dimension: int = 2, **tables: Any
) -> Result:
    """A run of one rigid block."""
    own = {"model": "rigid", "name": "body", "density": 1000.0, "friction": 5.0} | block
    scene = {"dimension": dimension, "block": [own], "time": {"end": end, "step": step}}
    return simulate(parse_scene(scene | tables))


def ramp(folder: Path, rate: float, end: float) -> dict[str, Any]:
    """A motion of the ground whose acceleration grows evenly, m/s3."""
    file = folder / f"ramp{rate}.txt"
    file.write_text(f"0 0\n{end} {rate * end}\n")
    return {"kind": "table", "file": str(file), "units": "m/s2"}


def lifts_at(result: Result, rate: float) -> float:
    """Acceleration of the ground at which the block begins to turn."""
    angle = np.abs(result.history["body.angle_rad"])
    first = int(np.argmax(angle > 1e-12))
    return float(rate * result.history["time_s"][first])


POLYGONS = {
    "triangle": [[0, 0], [0.9, 0], [0.2, 1.2]],
    "trapezoid": [[0, 0], [0.8, 0], [0.5, 1.5], [0.3, 1.5]],
    "pentagon": [[0, 0], [0.5, 0], [0.8, 0.7], [0.4, 1.4], [-0.2, 0.8]],
    "L": [[0, 0], [1.0, 0], [1.0, 0.3], [0.25, 0.3], [0.25, 1.4], [0, 1.4]],
}


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("name", POLYGONS)
def test_a_polygon_lifts_at_the_arm_of_its_own_side(name: str, side: int, tmp_path: Path) -> None:
    """Ground that accelerates towards -x lets it lean towards +x."""
    points = np.array(POLYGONS[name], dtype=float)
    x, y = centroid(points)
    low = points[points[:, 1] == 0, 0]
    arm = (low.max() - x) if side > 0 else (x - low.min())
    rate = 0.4 * G
    expected = G * arm / y
    end = min(1.3 * expected / rate, 5.0)
    shape = {"polygon": POLYGONS[name]}
    motion = ramp(tmp_path, -side * rate, end)
    found = run({"shape": shape}, end=end, step=2e-4, motion=motion)
    assert found.history["body.angle_rad"][-1] * side > 0
    assert lifts_at(found, rate) == pytest.approx(expected, rel=1e-3)


def centroid(points: Array) -> Array:
    """Centre of the area of a polygon, by a fan of triangles about its first corner."""
    a, b = points[1:-1] - points[0], points[2:] - points[0]
    areas = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    found: Array = points[0] + (areas[:, None] * (a + b) / 3).sum(axis=0) / areas.sum()
    return found


def test_a_polygon_that_is_a_box_is_the_box() -> None:
    """Corners given clockwise and anywhere."""
    box = {"width": 0.4, "height": 1.2, "tilt_deg": 6.0}
    shape = {"polygon": [[3.0, 2.0], [3.0, 3.2], [3.4, 3.2], [3.4, 2.0]]}
    one, other = run(box, end=3.0), run({"shape": shape, "tilt_deg": 6.0}, end=3.0)
    for column in ("angle_rad", "centre_x_m", "gap_left_m", "slip_m", "normal_force_N"):
        difference = one.history[f"body.{column}"] - other.history[f"body.{column}"]
        assert np.abs(difference).max() < 1e-7 * max(np.abs(one.history[f"body.{column}"]).max(), 1)


# ------------------------------------------------------------------ rolling


@pytest.mark.parametrize("count", [8, 12])
def test_a_regular_polygon_rolls_with_what_each_facet_leaves(count: int) -> None:
    """omega+ = omega- (I + m R^2 cos(2 pi/n))/(I + m R^2), and the speed that follows from it.

    From facet to facet it falls by 2 R sin(pi/n) sin(beta), which replaces what an impact takes.
    """
    radius, beta = 0.5, math.radians(12.0)
    spin, half = 2.5, math.pi / count
    pushed = {
        "angular_velocity": spin,
        "velocity": [spin * radius * math.cos(half), spin * radius * math.sin(half)],
    }
    found = run(
        {"shape": {"regular": count}, "width": 2 * radius} | pushed,
        end=8.0,
        step=2e-3,
        gravity_tilt_deg=12.0,
    )
    over_mass = radius**2 / 6 * (2 + math.cos(2 * math.pi / count))  # I/m of a regular polygon
    kept = (over_mass + radius**2 * math.cos(2 * math.pi / count)) / (over_mass + radius**2)
    side = 2 * radius * math.sin(math.pi / count)
    gained = 2 * G * side * math.sin(beta) / (over_mass + radius**2)
    fastest = math.sqrt(gained / (1 - kept**2))
    spin = np.abs(found.history["body.angular_velocity_rad_s"])
    late = spin[found.history["time_s"] > 6.0]
    assert late.max() == pytest.approx(fastest, rel=2e-3)
    assert late.min() < 1.02 * kept * fastest
    assert found.summary["energy"]["largest_gain_fraction"] < 1e-12


def test_a_drum_of_many_facets_rolls_as_a_round_one() -> None:
    """Two thirds of g sin(beta), less what facets take: 1 % with 600."""
    beta = math.radians(20.0)
    found = run(
        {"shape": {"regular": 600}, "width": 1.0, "friction": 1.0},
        end=2.0,
        step=2e-3,
        gravity_tilt_deg=20.0,
    )
    moved = float(np.ptp(found.history["body.centre_x_m"]))
    assert moved == pytest.approx(0.5 * 2 / 3 * G * math.sin(beta) * 2.0**2, rel=0.01)


def disc_on_its_edge(sides: int, degrees: float, rounds: float) -> tuple[Result, float]:
    """A thin disc let go with the angular velocity of Euler's disc; and that of its contact.

    Omega^2 sin(alpha) = 4 g/R: the disc turns by Omega sin(alpha) about its diameter through the
    contact, which goes round by Omega about the vertical while the centre stays where it is.
    """
    radius, alpha = 0.5, math.radians(degrees)
    speed = math.sqrt(4 * G / (radius * math.sin(alpha)))
    towards = np.array([math.cos(alpha), 0.0, -math.sin(alpha)])
    block = {
        "shape": {"cylinder": 2 * radius, "sides": sides},
        "height": 0.004,
        "tilt_deg": degrees,
        "angular_velocity": (-speed * math.sin(alpha) * towards).tolist(),
        "friction": 50.0,
    }
    end = rounds * 2 * math.pi / speed
    return run(block, end=end, step=end / (4000 * rounds), dimension=3), speed


def test_a_disc_on_its_edge_goes_round_with_the_speed_of_its_lean() -> None:
    """In the first quarter of a round; facets, which take energy, then let it sink and speed up."""
    found, speed = disc_on_its_edge(300, 20.0, 0.25)
    history = found.history
    turns = np.stack([history[f"body.angle_{axis}_rad"] for axis in "xyz"], axis=1)
    up = Rotation.from_rotvec(turns).as_matrix()[:, :, 2]
    azimuth = np.unwrap(np.arctan2(up[:, 1], up[:, 0]))
    assert azimuth[-1] - azimuth[0] == pytest.approx(math.pi / 2, rel=0.01)
    assert azimuth[-1] / history["time_s"][-1] == pytest.approx(speed, rel=0.01)
    for axis in "xy":
        assert np.ptp(history[f"body.centre_{axis}_m"]) < 0.005


def test_a_disc_that_sinks_loses_energy_all_the_way() -> None:
    found, _ = disc_on_its_edge(100, 12.0, 3.0)
    total = found.history["energy.total_J"]
    scale = found.summary["energy"]["scale_J"]
    assert np.diff(total).max() < 1e-12 * scale
    assert total[-1] < 0.8 * total[0]
    assert np.abs(found.history["energy.ledger_error_J"]).max() < 1e-9 * scale


# ------------------------------------------------------------------ feet


def test_a_box_on_feet_lifts_and_lands_about_their_edges(tmp_path: Path) -> None:
    width, height, inset, high = 0.6, 2.0, 0.08, 0.1
    feet = {"inset": inset, "size": 0.04, "height": high}
    box = {"width": width, "height": height, "feet": feet}
    arm, centre = width / 2 - inset, height / 2 + high
    expected, rate = G * arm / centre, 0.4 * G
    found = run(box, end=1.0, step=2e-4, motion=ramp(tmp_path, rate, 1.0))
    assert lifts_at(found, rate) == pytest.approx(expected, rel=1e-3)
    rocking = run(box | {"tilt_deg": 4.0}, end=2.0, step=5e-4)
    over_mass = (width**2 + height**2) / 12
    kept = (over_mass + centre**2 - arm**2) / (over_mass + centre**2 + arm**2)
    told = [impact["restitution"] for impact in rocking.summary["blocks"]["body"]["impacts"]]
    assert told[:3] == pytest.approx([kept] * 3, rel=1e-6)


def test_a_short_foot_lets_a_table_rock_between_its_feet() -> None:
    """It comes to rest where both feet touch, the short one 1 mm below the long one's level."""
    feet = [
        {"at": [-0.3], "size": 0.02, "height": 0.1},
        {"at": [0.3], "size": 0.02, "height": 0.099},
    ]
    # The centre is beyond the long foot, on the side of the short one.
    found = run({"width": 0.8, "height": 0.4, "feet": feet}, end=3.0)
    angle = found.history["body.angle_rad"][-1]
    assert math.sin(angle) == pytest.approx(0.001 / math.hypot(0.6, 0.001), rel=1e-4)
    assert abs(found.history["body.angular_velocity_rad_s"][-1]) < 1e-9


def test_forces_of_feet_are_those_of_statics() -> None:
    """Quarters of a weight in the middle; else more below the nearer foot, the weight in all."""
    feet = {"inset": 0.05, "size": 0.04, "height": 0.1}
    box = {"width": 0.6, "height": 1.0, "thickness": 0.5, "feet": feet}
    history = run(box, end=0.05, dimension=3).history
    weight = 1000.0 * 0.6 * 0.5 * G
    forces = [history[f"body.foot_{k}.normal_force_N"][-1] for k in (1, 2, 3, 4)]
    assert forces == pytest.approx([weight / 4] * 4, rel=1e-9)
    uneven = run(box | {"centre_of_mass": [0.04, 0.03, 0.5]}, end=0.05, dimension=3).history
    forces = [uneven[f"body.foot_{k}.normal_force_N"][-1] for k in (1, 2, 3, 4)]
    assert sum(forces) == pytest.approx(weight, rel=1e-10)
    assert forces[2] == max(forces) and forces[0] == min(forces) and forces[0] > 0


# ------------------------------------------------------------------ a file


def statue(folder: Path, count: int = 40) -> tuple[Path, Array, Array]:
    """A made-up bust as a binary STL file: points about an axis, some thousand facets."""
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    levels = np.linspace(0, 1, count)
    radius = 0.30 - 0.16 * levels + 0.05 * np.cos(6 * levels)
    rings = []
    for level, r in zip(levels, radius, strict=True):
        own = r * (1 + 0.15 * level * np.cos(angles - 0.4) + 0.1 * level * np.cos(3 * angles))
        ring = np.stack([own * np.cos(angles), 0.8 * own * np.sin(angles)], axis=1)
        rings.append(np.column_stack([ring, np.full(count, 1.1 * level)]))
    points = np.concatenate([*rings, [[0, 0, 0]], [[0, 0, 1.1]]])
    triangles = []
    for k in range(count - 1):
        for j in range(count):
            a, b = k * count + j, k * count + (j + 1) % count
            triangles += [[a, b, b + count], [a, b + count, a + count]]
    for j in range(count):
        top = (count - 1) * count
        triangles.append([count * count, (j + 1) % count, j])
        triangles.append([count * count + 1, top + j, top + (j + 1) % count])
    facets = np.array(triangles)
    corners = points[facets].astype(np.float32)
    file = folder / "bust.stl"
    with file.open("wb") as out:
        out.write(b" " * 80 + struct.pack("<I", len(facets)))
        for ring in corners:
            out.write(struct.pack("<12fH", 0, 0, 0, *ring.ravel(), 0))
    return file, points, facets


def test_a_statue_from_a_file_has_its_mass_stands_and_lifts(tmp_path: Path) -> None:
    file, points, facets = statue(tmp_path)
    assert len(facets) > 3000
    scene = {
        "dimension": 3,
        "block": [
            {
                "model": "rigid",
                "name": "body",
                "density": 2000.0,
                "friction": 5.0,
                "shape": {"file": str(file)},
            }
        ],
        "time": {"end": 0.3, "step": 1e-3},
    }
    shape: Block = parse_scene(scene).blocks[0].shape
    mass, centre, inertia = tetrahedra(points, facets, 2000.0)
    assert shape.mass == pytest.approx(mass, rel=1e-6)
    bottom = points[points[:, 2] == 0]
    middle = (bottom.min(axis=0) + bottom.max(axis=0)) / 2
    assert np.array(shape.centre_of_mass(3)) == pytest.approx(centre - middle, abs=1e-6)
    assert np.array(shape.inertia_tensor) == pytest.approx(inertia, rel=1e-6, abs=1e-6 * mass)
    rest = simulate(parse_scene(scene)).history
    assert rest["body.normal_force_N"][-1] == pytest.approx(shape.mass * G, rel=1e-9)
    for side in (1, -1):
        ends = (bottom - centre)[:, 0]
        arm = ends.max() if side > 0 else -ends.min()
        expected, rate = G * arm / centre[2], 0.5 * G
        end = 1.25 * expected / rate
        motion = ramp(tmp_path, -side * rate, end)
        time = {"end": end, "step": 5e-4}
        history = simulate(parse_scene(scene | {"motion": motion, "time": time})).history
        lean = np.abs(history["body.angle_rad"])
        lifted = rate * history["time_s"][int(np.argmax(lean > 1e-8))]
        assert lifted == pytest.approx(expected, rel=5e-3)


def tetrahedra(points: Array, facets: Array, density: float) -> tuple[float, Array, Array]:
    """Mass, centre and inertia of what a surface encloses, by tetrahedra with the origin."""
    ring = points[facets]
    volumes = np.einsum("ni,ni->n", ring[:, 0], np.cross(ring[:, 1], ring[:, 2])) / 6
    mass = density * volumes.sum()
    sums = ring.sum(axis=1)
    centre = (volumes[:, None] * sums).sum(axis=0) / 4 / volumes.sum()
    # Second moments of a tetrahedron with corners 0, a, b, c: V/20 (sum x x^T + s s^T).
    outer = np.einsum("nki,nkj->nij", ring, ring) + np.einsum("ni,nj->nij", sums, sums)
    moments = density * np.einsum("n,nij->ij", volumes / 20, outer)
    moments -= mass * np.outer(centre, centre)
    return float(mass), centre, np.trace(moments) * np.eye(3) - moments
