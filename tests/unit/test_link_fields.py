"""Links in the files of the fields, as lines with tension, extension and state."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene, read_run, simulate
from solver.errors import SceneError
from solver.pictures.links import links_of
from solver.pictures.meshes import FieldFiles

pyvista = pytest.importorskip("pyvista")

SCENE = """
dimension = {dimension}
[[block]]
model = "rigid"
width = 0.3
height = 1.0
thickness = 0.4
mass = 100.0
tilt_deg = 3.0
[[link]]
name = "stay"
kind = "lashing"
between = ["block", "foundation"]
at = {left}
to = {far}
stiffness = 1e4
preload = 50.0
[[link]]
name = "wax"
kind = "wax"
between = ["foundation", "block"]
at = {right}
stiffness = 1e5
strength = 200.0
[foundation]
kind = "oscillator"
mass = 300.0
period = 0.4
[motion]
kind = "sine"
amplitude_g = 0.5
period = 0.5
cycles = 2
[time]
end = 0.5
step = 1e-3
[output]
every = 0.05
"""

PLACES = {
    2: {"left": [-0.15, 1.0], "far": [-0.6, 0.0], "right": [0.15, 0.0]},
    3: {"left": [-0.15, 0.1, 1.0], "far": [-0.6, 0.3, 0.0], "right": [0.15, 0.1, 0.0]},
}


def text_of(dimension: int) -> str:
    return SCENE.format(dimension=dimension, **PLACES[dimension])


def lines_in(file: Path) -> Iterator[tuple[float, Any]]:
    """The links, which are the last body, and their times."""
    reader = pyvista.get_reader(str(file))
    assert "fields_links" in reader.datasets[-1].path
    for time in reader.time_values:
        reader.set_active_time_value(time)
        yield time, reader.read()[-1]


@pytest.mark.parametrize("dimension", [2, 3])
def test_lines_are_where_links_are_and_have_the_numbers_of_the_history(
    dimension: int, tmp_path: Path
) -> None:
    """In every snapshot, the first one with the preload included; the wax breaks in the run."""
    simulate(parse_scene(text_of(dimension)), folder=tmp_path)
    run = read_run(tmp_path)
    assert run.fields is not None
    times = run.history["time_s"]
    assert len(list(lines_in(run.fields))) == 11
    assert run.history["wax.state"][0] < 3 and run.history["wax.state"][-1] == 3
    assert run.history["stay.force_N"][0] == pytest.approx(50.0, rel=1e-3)
    for time, lines in lines_in(run.fields):
        row = int(np.argmin(np.abs(times - time)))
        assert times[row] == pytest.approx(time, abs=1e-9)
        placed = np.asarray(lines.points) + lines.point_data["displacement"]
        for k, link in enumerate(links_of(run, times[[row]])):
            first, second = link.ends[0]
            part = 0.2 if link.states[0] == 3 else 0.5
            expected = [first, first + part * (second - first)]
            expected += [second, second - part * (second - first)]
            np.testing.assert_allclose(placed[4 * k : 4 * k + 4, :dimension], expected, atol=1e-6)
            name = run.scene.links[k].name
            for field, column in (
                ("tension", "force_N"), ("extension", "extension_m"), ("state", "state")
            ):  # fmt: skip
                told = run.history[f"{name}.{column}"][row]
                assert lines.cell_data[field][2 * k : 2 * k + 2] == pytest.approx(told, abs=1e-9)
            ways = [f"{name}.shear_force{way}_N" for way in ("", "_second")]
            shear = [run.history[column][row] for column in ways if column in run.history]
            across = float(np.linalg.norm(shear)) if shear else 0.0
            assert lines.cell_data["shear_force"][2 * k] == pytest.approx(across, abs=1e-9)
    assert FieldFiles(run.fields).names == ["block", "platform"]
    assert "LineWidth = 3.0" in (tmp_path / "open_in_paraview.py").read_text()


def test_no_block_is_called_as_the_lines_are() -> None:
    with pytest.raises(SceneError, match="links"):
        parse_scene(text_of(2).replace('model = "rigid"', 'model = "rigid"\nname = "links"'))


@pytest.mark.parametrize("dimension", [2, 3])
def test_links_of_an_elastic_block_end_where_it_is_bent_to(dimension: int, tmp_path: Path) -> None:
    """The distance of the ends of the lashing changes by its extension, to round-off."""
    pytest.importorskip("dolfinx")
    cells = "cells = [2, 4]" if dimension == 2 else "cells = [2, 2, 4]"
    text = text_of(dimension).replace("tilt_deg = 3.0\n", f"young = 1e7\n{cells}\n")
    text = text.replace('model = "rigid"', "poisson = 0.2").replace("end = 0.5", "end = 0.2")
    simulate(parse_scene(text), folder=tmp_path)
    run = read_run(tmp_path)
    assert run.fields is not None
    times = run.history["time_s"]
    lengths = []
    for time, lines in lines_in(run.fields):
        placed = np.asarray(lines.points, float) + lines.point_data["displacement"]
        row = int(np.argmin(np.abs(times - time)))
        lengths.append(np.linalg.norm(placed[2] - placed[0]) - run.history["stay.extension_m"][row])
        for field, column in (("tension", "force_N"), ("state", "state")):
            told = run.history[f"stay.{column}"][row]
            assert lines.cell_data[field][0] == pytest.approx(told, rel=1e-9)
    assert np.ptp(run.history["stay.extension_m"]) > 1e-4
    assert np.ptp(lengths) < 1e-9
