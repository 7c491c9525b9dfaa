"""A block in space that rocks along y: angles over alpha are over that of its thickness."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from rockslip import Result, parse_scene, read_run, simulate
from solver.pictures.angles import draw_angle, draw_phase
from solver.pictures.page import HEADING, _blocks
from solver.run.twin import difference, twin_of
from solver.study.suite.cases import KEPT

SCENE = """
dimension = 3
[[block]]
name = "a"
model = "rigid"
width = 1.0
thickness = 0.2
height = 1.0
density = 2000.0
[contact]
friction = 0.9
[motion]
kind = "none"
[motion.second]
kind = "sine"
amplitude_g = 0.4
period = 0.5
cycles = 3
[time]
end = {end}
step = 1e-3
[output]
fields = "none"
"""
ALPHA = math.atan(0.2)


@pytest.fixture(scope="module")
def rocked(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    folder = tmp_path_factory.mktemp("along_y")
    return folder, simulate(parse_scene(SCENE.format(end=2.0)), folder=folder)


def leans(result: Result) -> np.ndarray:
    """By a turn about x alone, as a positive one leans towards -y."""
    assert np.abs(result.history["a.angle_y_rad"]).max() < 1e-9
    return -result.history["a.angle_x_rad"]


def test_the_summary_and_the_page_tell_the_lean_over_the_alpha_of_its_direction(
    rocked: tuple[Path, Result],
) -> None:
    folder, result = rocked
    block, expected = result.summary["blocks"]["a"], np.abs(leans(result)).max() / ALPHA
    assert 0.9 < expected < 1.0
    assert block["peak_angle_over_alpha"] == pytest.approx(expected, rel=1e-9)
    assert block["peak_angle_over_alpha_while_standing"] == block["peak_angle_over_alpha"]
    assert "peak_angle_over_alpha_while_standing" in KEPT
    row = _blocks(read_run(folder))[1]
    assert float(row[HEADING.index("over alpha")]) == pytest.approx(expected, rel=1e-3)


def test_pictures_show_the_plane_in_which_it_leans(rocked: tuple[Path, Result]) -> None:
    folder, result = rocked
    run = read_run(folder)
    (line, *_) = draw_phase(run, None).axes[0].lines
    velocity = -result.history["a.angular_velocity_x_rad_s"]
    p = math.sqrt(3 * 9.81 / (4 * math.hypot(0.5, 0.1)))
    assert line.get_xdata() == pytest.approx(leans(result) / ALPHA, rel=1e-9, abs=1e-12)
    assert line.get_ydata() == pytest.approx(velocity / (p * ALPHA), rel=1e-9, abs=1e-12)
    axes = draw_angle(run, None).axes[-1]
    (beside,) = axes.child_axes
    beside.draw(axes.figure.canvas.get_renderer())
    assert beside.get_ylim()[1] == pytest.approx(axes.get_ylim()[1] / math.degrees(ALPHA))


def test_a_twin_is_compared_over_the_alpha_of_that_direction(
    rocked: tuple[Path, Result],
) -> None:
    scene, (_, first) = parse_scene(SCENE.format(end=2.0)), rocked
    twin = simulate(twin_of(scene, 1e-3))
    _, apart = difference(scene, first.history, twin.history)
    expected = np.abs(leans(first) - leans(twin)) / ALPHA
    assert apart.max() == pytest.approx(expected.max(), rel=1e-9)
    assert apart.max() > 1e-3


def test_a_residual_slip_in_space_is_told_as_a_whole() -> None:
    from solver.results.report import residual_slip

    assert residual_slip({"residual_slip_m": -0.3, "residual_slip_second_m": 0.4}) == 0.5
    assert residual_slip({"residual_slip_m": -0.3}) == -0.3
