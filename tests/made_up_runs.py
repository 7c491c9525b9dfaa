"""Folders of runs that were not computed: histories and fields made from formulas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rockslip import History, Scene, parse_scene
from solver.fields.ground import platform_corners
from solver.fields.part import one_cell, rigid_fields
from solver.fields.vtu import FieldsBefore, PvdFiles
from solver.history.history import scene_columns
from solver.results.motion import rotated
from solver.results.summary import summarise, write_json
from solver.scene import scene_to_toml

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
    files = PvdFiles(folder, FieldsBefore(), writes=True)
    files.begin()
    for block in scene.blocks:
        write_fields(files, scene, history, block.name)
    if scene.has_platform:
        corners = platform_corners(scene)
        writer = files.body("platform", one_cell(corners))
        for row in range(0, len(T), 40):
            drift = history["platform.drift_m"][row] * np.eye(scene.dimension)[0]
            moved = np.tile(drift, (len(corners), 1))
            writer.write(float(T[row]), rigid_fields(moved, 0 * corners), {})
    return folder


def write_fields(files: PvdFiles, scene: Scene, history: History, name: str) -> None:
    """Every 40th row of a block as a body of one cell."""
    block = next(b for b in scene.blocks if b.name == name)
    corners = np.array(block.shape.corners(scene.dimension))
    writer = files.body(name, one_cell(corners))
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
        writer.write(float(T[row]), rigid_fields(centre + turned - corners, 0 * corners), {})


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
