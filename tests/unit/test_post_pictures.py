"""Pictures are drawn from the files of a run; where that can be told by numbers, it is."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scenes import BLOCK

from solver.cli import main

pytest.importorskip("matplotlib")
pyvista = pytest.importorskip("pyvista")

SCENE = f"""
{BLOCK}
tilt_deg = 3.0
[time]
end = 0.6
step = 0.002
"""


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """The folder of a rigid-body answer."""
    (tmp_path / "scene.toml").write_text(SCENE)
    folder = tmp_path / "one"
    assert main(["reference", str(tmp_path / "scene.toml"), "-o", str(folder), "-q"]) == 0
    return folder


def complete(folder: Path) -> None:
    """Make a run of it that looks like finite elements: with a ledger and fields."""
    from rockslip import History

    known = History.read(folder / "history.csv")
    values = {name: known[name] for name in known.columns}
    total = values["energy.total_J"]
    values["energy.contact_J"] = 0.8 * (total[0] - total)
    values["energy.numerical_J"] = 0.2 * (total[0] - total)
    values["energy.ledger_error_J"] = 0 * total
    history = History(known.columns, folder / "history.csv")
    for row in np.stack(list(values.values()), axis=1):
        history.append(row)
    history.flush()
    summary = json.loads((folder / "summary.json").read_text())
    summary["model"] = "finite elements"
    summary["energy"]["ledger_error_fraction"] = 1e-12
    (folder / "summary.json").write_text(json.dumps(summary))
    write_fields(folder, values["time_s"][::30], values["block.angle_rad"][::30])


def write_fields(folder: Path, times: np.ndarray, angles: np.ndarray) -> None:
    """A turning block of 2 x 4 quadratic cells, its files made without dolfinx."""
    entries = []
    for i, (time, angle) in enumerate(zip(times, angles, strict=True)):
        grid = quadratic_block()
        place = np.asarray(grid.points)
        pivot = np.array([math.copysign(0.125, angle), 0.0, 0.0])
        c, s = math.cos(angle), math.sin(angle)
        turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        grid.point_data["displacement"] = (place - pivot) @ turn.T + pivot - place
        grid.cell_data["von_mises"] = 1e6 * np.arange(grid.n_cells)
        grid.save(folder / f"fields{i}.vtu")
        entries.append(f'<DataSet timestep="{time}" part="0" file="fields{i}.vtu"/>')
    text = '<VTKFile type="Collection" version="0.1"><Collection>'
    (folder / "fields.pvd").write_text(f"{text}{''.join(entries)}</Collection></VTKFile>")


def quadratic_block() -> pyvista.UnstructuredGrid:
    x, y = np.meshgrid(np.linspace(-0.125, 0.125, 5), np.linspace(0, 1, 9))
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    cells = []
    for row in range(4):
        for column in range(2):
            at = 10 * row + 2 * column
            corners, middles = [at, at + 2, at + 12, at + 10], [at + 1, at + 7, at + 11, at + 5]
            cells.append([9, *corners, *middles, at + 6])
    return pyvista.UnstructuredGrid(np.array(cells).ravel(), np.full(8, 70), points)


def assert_picture(file: Path) -> None:
    """A picture with something on it."""
    from matplotlib.image import imread

    pixels = imread(file)
    assert pixels.shape[1] > 800
    assert 0.02 < float(np.mean(np.any(pixels[:, :, :3] < 0.99, axis=2))) < 0.8


def test_pictures_of_a_run(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    complete(run)
    assert main(["plot", str(run)]) == 0
    files = [Path(line) for line in capsys.readouterr().out.splitlines()]
    wanted = ["angle.png", "phase.png", "forces.png", "energy.png", "deformed.png"]
    assert [file.name for file in files] == wanted
    for file in files:
        assert file.parent == run
        assert_picture(file)


def test_pictures_for_papers(run: Path, tmp_path: Path) -> None:
    """As PDF and SVG, which are what their names say; a new run takes them away."""
    assert main(["plot", str(run), "--format", "pdf", "svg"]) == 0
    for name in ("angle", "forces", "phase"):
        assert (run / f"{name}.pdf").read_bytes().startswith(b"%PDF")
        assert "<svg" in (run / f"{name}.svg").read_text()
    assert list(run.glob("*.png")) == []
    scene = str(tmp_path / "scene.toml")
    assert main(["reference", scene, "-q", "-o", str(run), "--force"]) == 0
    assert {file.suffix for file in run.iterdir()} == {".csv", ".json", ".toml"}


def test_a_rigid_body_answer_has_no_fields_and_no_ledger(run: Path) -> None:
    assert main(["plot", str(run)]) == 0
    names = sorted(file.name for file in run.glob("*.png"))
    assert names == ["angle.png", "forces.png", "phase.png"]


def test_runs_overlaid(run: Path, tmp_path: Path) -> None:
    scene, other = str(tmp_path / "scene.toml"), str(tmp_path / "two")
    assert main(["reference", scene, "-q", "-o", other, "--set", "block.tilt_deg=-2.0"]) == 0
    assert main(["plot", str(run), other]) == 0
    assert_picture(run / "overlay.png")
    assert main(["plot", str(run), other, "-o", str(tmp_path)]) == 0
    assert_picture(tmp_path / "overlay.png")


def test_what_is_no_run_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", str(tmp_path)]) == 2
    assert "no scene.toml" in capsys.readouterr().err


def test_instants(run: Path) -> None:
    """Start, first impact (Housner: 0.1916 s), the peak after it, end."""
    from rockslip import read_run
    from solver.pictures.instants import instants

    chosen = instants(read_run(run))
    assert [instant.name for instant in chosen] == ["release", "landing", "next peak", "end"]
    first, impact, peak, last = (instant.time_s for instant in chosen)
    assert (first, last) == (0.0, pytest.approx(0.6))
    assert impact == pytest.approx(0.1916, abs=1e-4)
    assert peak == pytest.approx((0.1916 + 0.5305) / 2, abs=1e-3)


def test_snapshots_are_the_block_as_it_stands(run: Path) -> None:
    """Area and lowest point of the outlines; the snapshot nearest to the time asked for."""
    from solver.pictures.deformed import read_snapshots

    complete(run)
    start, later = read_snapshots(run / "fields.pvd", [0.0, 0.07, 0.001])
    assert start.time_s == 0.0
    assert later.time_s == pytest.approx(0.06)
    assert len(start.outlines) == 8
    area = 0.0
    for outline in start.outlines:
        assert outline.shape == (8, 2)
        x, y = outline.T
        area += 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert area == pytest.approx(0.25)
    corners = np.concatenate(start.outlines)
    assert corners[:, 1].min() == pytest.approx(0.0, abs=1e-12)
    assert corners[:, 1].max() == pytest.approx(
        math.cos(math.radians(3)) + 0.25 * math.sin(math.radians(3))
    )
    np.testing.assert_array_equal(start.von_mises, 1e6 * np.arange(8))
