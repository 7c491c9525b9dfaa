"""Pictures of stacks, platforms and blocks in space, from made-up runs with files of their own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rockslip import History, Scene, parse_scene
from solver.fields.ground import floor_level, platform_corners
from solver.fields.pvd import PvdIndex
from solver.fields.rigid_writer import RigidFieldWriter
from solver.history.history import scene_columns
from solver.results.motion import rotated
from solver.results.summary import summarise, write_json
from solver.scene import scene_to_toml

pytest.importorskip("matplotlib")
pytest.importorskip("pyvista")

Array = NDArray[np.float64]

BLOCK = "[[block]]\nheight = 1.0\nthickness = 0.3\nmass = 100.0\nmodel = 'rigid'\n"
TIME = "[time]\nend = 2.0\nstep = 0.002\n"
STACK = f"""{BLOCK}name = "lower"\nwidth = 0.5\n{BLOCK}name = "upper"\nwidth = 0.3\non = "lower"
[foundation]\nkind = "oscillator"\nmass = 100.0\nperiod = 0.5\n{TIME}"""
IN_SPACE = f"dimension = 3\n{BLOCK}width = 0.4\n{TIME}"
T = np.linspace(0, 2, 1001)


def leave_run(folder: Path, scene: Scene, values: dict[str, Any]) -> Path:
    """The folder of a run with these columns, the others zero, and its fields."""
    history = History(scene_columns(scene))
    known = {"time_s": T, "step_s": 0.002} | values
    assert set(known) <= set(history.columns)
    table = np.stack([known.get(name, 0.0) + 0 * T for name in history.columns], axis=1)
    folder.mkdir()
    history = History(history.columns, folder / "history.csv")
    history.extend(table)
    history.flush()
    (folder / "scene.toml").write_text(scene_to_toml(scene))
    summary = summarise(
        scene, history, status="completed", cost={}, versions={}, model="rigid blocks"
    )
    write_json(folder / "summary.json", summary)
    index = PvdIndex(folder / "fields.pvd")
    for part, block in enumerate(scene.blocks):
        write_fields(folder, scene, history, block.name, index, part)
    if scene.has_platform:
        corners = platform_corners(scene)
        name, part = folder / "fields_platform.pvd", len(scene.blocks)
        writer = RigidFieldWriter(name, corners, index=index, part=part)
        for row in range(0, len(T), 40):
            drift = history["platform.drift_m"][row] * np.eye(scene.dimension)[0]
            writer.write(float(T[row]), np.tile(drift, (len(corners), 1)), 0 * corners)
    return folder


def write_fields(
    folder: Path, scene: Scene, history: History, name: str, index: PvdIndex, part: int
) -> None:
    """Every 40th row of a block as a body of one cell."""
    block = next(b for b in scene.blocks if b.name == name)
    corners = np.array(block.shape.corners(scene.dimension))
    writer = RigidFieldWriter(folder / f"fields_{name}.pvd", corners, index=index, part=part)
    arms = corners - np.eye(scene.dimension)[-1] * block.height / 2
    for row in range(0, len(T), 40):
        if scene.dimension == 2:
            angle = history[f"{name}.angle_rad"][row]
            c, s = np.cos(angle), np.sin(angle)
            turned = arms @ np.array([[c, s], [-s, c]]).T
        else:
            vector = np.array([history[f"{name}.angle_{axis}_rad"][row] for axis in "xyz"])
            turned = rotated(np.tile(vector, (8, 1)), arms)
        axes = "xyz"[: scene.dimension]
        centre = np.array([history[f"{name}.centre_{axis}_m"][row] for axis in axes])
        writer.write(float(T[row]), centre + turned - corners, 0 * corners)


def stack(folder: Path) -> Path:
    """Two blocks on a platform: the lower one slides, the upper one rocks."""
    angle = 0.1 * np.exp(-T) * np.cos(6 * T)
    drift, slip = 0.05 * np.sin(8 * T), 0.02 * (1 - np.cos(3 * T))
    weight = 9.81 * 100
    values = {
        "lower.slip_m": slip,
        "lower.centre_x_m": slip + drift,
        "lower.centre_y_m": 0.5,
        "lower.normal_force_N": 2 * weight * (1 + 30 * (np.abs(T - 0.5) < 2e-3)),
        "lower.friction_force_N": 0.3 * weight * np.sin(8 * T),
        "upper.angle_rad": angle,
        "upper.angular_velocity_rad_s": np.gradient(angle, T),
        "upper.gap_left_m": 0.3 * np.sin(np.maximum(angle, 0)),
        "upper.gap_right_m": 0.3 * np.sin(np.maximum(-angle, 0)),
        "upper.centre_x_m": slip + drift + 0.4 * angle,
        "upper.centre_y_m": 1.5 + 0.15 * np.abs(angle),
        "upper.normal_force_N": weight,
        "upper.friction_force_N": 0.1 * weight * np.sin(8 * T),
        "platform.drift_m": drift,
        "platform.acceleration_m_s2": -3.2 * np.sin(8 * T),
        "energy.kinetic_J": 5 * np.sin(8 * T) ** 2,
        "energy.gravity_J": weight * (0.5 + 1.5 + 0.15 * np.abs(angle)),
        "energy.spring_J": 10 * np.sin(8 * T) ** 2,
        "energy.total_J": 15 * np.sin(8 * T) ** 2 + weight * (2 + 0.15 * np.abs(angle)),
        "energy.friction_J": 3 * T,
        "energy.input_J": 6 * T,
    }
    return leave_run(folder, parse_scene(STACK), values)


def in_space(folder: Path) -> Path:
    """A block that rocks on its corners and turns on the way."""
    lean, turn = 0.15 * np.exp(-T) * np.cos(5 * T), 0.2 * T
    values = {
        "block.angle_rad": lean,
        "block.angle_x_rad": -0.6 * lean,
        "block.angle_y_rad": lean,
        "block.angle_z_rad": turn,
        "block.angular_velocity_y_rad_s": np.gradient(lean, T),
        "block.gap_1_m": 0.4 * np.abs(np.sin(lean)),
        "block.slip_m": 0.02 * T,
        "block.slip_second_m": -0.01 * T,
        "block.centre_z_m": 0.5 + 0.2 * np.abs(lean),
        "block.normal_force_N": 981.0,
        "block.friction_force_second_N": 100 * np.sin(5 * T),
        "energy.gravity_J": 981 * (0.5 + 0.2 * np.abs(lean)),
        "energy.total_J": 981 * (0.5 + 0.2 * np.abs(lean)),
    }
    return leave_run(folder, parse_scene(IN_SPACE), values)


def assert_pictures(folder: Path, names: list[str]) -> None:
    """These pictures, each with something on it."""
    from matplotlib.image import imread

    from rockslip import read_run
    from solver.pictures.pictures import picture_run

    files = picture_run(read_run(folder))
    assert [file.name for file in files] == names
    for file in files:
        pixels = imread(file)
        assert 0.02 < float(np.mean(np.any(pixels[:, :, :3] < 0.99, axis=2))) < 0.8


def test_pictures_of_a_stack_on_a_platform(tmp_path: Path) -> None:
    names = ["angle", "phase", "platform", "forces", "energy", "deformed"]
    assert_pictures(stack(tmp_path / "stack"), [f"{name}.png" for name in names])


def test_pictures_in_space(tmp_path: Path) -> None:
    names = ["angle", "phase", "forces", "energy", "deformed"]
    assert_pictures(in_space(tmp_path / "space"), [f"{name}.png" for name in names])


def test_what_curves_show(tmp_path: Path) -> None:
    """The numbers on the axes are those of the history, in the units of their labels."""
    from rockslip import read_run
    from solver.pictures.angles import draw_angle, draw_overlay
    from solver.pictures.forces import draw_energy, draw_forces, draw_platform

    run = read_run(stack(tmp_path / "stack"))
    (angles,) = draw_angle(run, None).axes[:1]
    curves = {line.get_label(): line.get_ydata() for line in angles.lines}
    np.testing.assert_allclose(curves["upper"], np.degrees(run.history["upper.angle_rad"]))
    drift, _, acceleration = draw_platform(run, None).axes
    np.testing.assert_allclose(drift.lines[0].get_ydata(), 50 * np.sin(8 * T))
    np.testing.assert_allclose(acceleration.lines[1].get_ydata(), -3.2 / 9.81 * np.sin(8 * T))
    # standing is 1 on both: the lower block carries twice its weight
    low, up, slips = draw_forces(run).axes
    assert np.median(low.lines[0].get_ydata()) == pytest.approx(1)
    assert np.median(up.lines[0].get_ydata()) == pytest.approx(1)
    assert low.get_ylim()[1] < 5
    np.testing.assert_allclose(slips.lines[0].get_ydata(), 20 * (1 - np.cos(3 * T)))
    stored = draw_energy(run).axes[0]
    curves = {line.get_label(): line.get_ydata() for line in stored.lines}
    raised = 981 * 0.15 * np.abs(run.history["upper.angle_rad"])
    np.testing.assert_allclose(curves["gravity above upright"], raised, atol=1e-9)
    # a run without a platform beside it: three panels, the third with one curve
    other = read_run(in_space(tmp_path / "space"))
    panels = draw_overlay([run, other]).axes
    assert [len(axes.lines) for axes in panels] == [3, 3, 2]


def test_instants_are_those_of_the_block_that_rocks(tmp_path: Path) -> None:
    from rockslip import read_run
    from solver.pictures.pictures import instants

    first, impact, peak, last = instants(read_run(stack(tmp_path / "stack")))
    assert (first, last) == (0.0, 2.0)
    assert impact == pytest.approx(np.pi / 12, abs=1e-4)
    assert impact < peak < np.pi / 4


def test_bodies_stand_on_each_other(tmp_path: Path) -> None:
    """Outlines of all parts; the view in space keeps heights and hides what is behind."""
    from solver.pictures.deformed import ABOVE, read_snapshots

    (plane,) = read_snapshots(stack(tmp_path / "stack") / "fields.pvd", [0.0])
    assert len(plane.outlines) == 3
    # the floor is below the platform; the upper block leans by 0.1 on the top of the lower one
    assert plane.low[1] == floor_level(parse_scene(STACK)) < 0
    assert plane.outlines[0][:, 1].min() == pytest.approx(0.0, abs=1e-12)
    assert plane.outlines[1][:, 1].min() == pytest.approx(
        1.5 + 0.015 - 0.5 * np.cos(0.1) - 0.15 * np.sin(0.1)
    )
    (space,) = read_snapshots(in_space(tmp_path / "space") / "fields.pvd", [0.0], dimension=3)
    assert len(space.outlines) == 6
    assert [outline.shape for outline in space.outlines] == [(4, 2)] * 6
    # the front face is drawn last but for the top and the side: three faces are seen
    areas = [_area(outline) for outline in space.outlines]
    assert sum(area > 0 for area in areas) == 3
    assert all(area > 0 for area in areas[3:])
    assert sum(areas) == pytest.approx(0.0, abs=1e-12)
    assert 0 < ABOVE < np.pi / 2


@pytest.mark.parametrize(
    ("foundation", "level"),
    [
        ("kind = 'rigid'", 0.0),
        ("kind = 'elastic'\nwidth = 2\nheight = 0.2\ndensity = 1", -0.2),
        (
            "kind = 'frame'\ndeck = { width = 2, height = 0.2 }\ncolumn = { width = 0.1 }\n"
            "storey = 1.5\ndensity = 1",
            -1.7,
        ),
    ],
)
def test_floor_level(foundation: str, level: float) -> None:
    """At the feet of whatever carries the blocks."""
    meshed = "" if "rigid" in foundation else "young = 1e9\npoisson = 0.2\n"
    scene = parse_scene(f"{BLOCK}width = 0.5\n[foundation]\n{foundation}\n{meshed}{TIME}")
    assert floor_level(scene) == pytest.approx(level)


def _area(outline: Array) -> float:
    """Signed area of a polygon."""
    x, y = outline.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
