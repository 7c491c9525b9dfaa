"""Fields in one file, `output.fields = "vtkhdf"`: those of the other format, whatever happens."""

from __future__ import annotations

import errno
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from processes import on_ranks, outside_mpirun, python
from scenes import BLOCK, UPPER

from rockslip import parse_scene, simulate
from solver.cli import main
from solver.errors import OutputTrouble
from solver.fields.part import Part
from solver.fields.vtkhdf import NAME, HdfFile
from solver.run.checkpoint import Schedule
from solver.scene import scene_to_toml

h5py = pytest.importorskip("h5py")
pyvista = pytest.importorskip("pyvista")

pytestmark = pytest.mark.serial

RIGID = BLOCK.replace("[[block]]", '[[block]]\nmodel = "rigid"') + "\ntilt_deg = 1.0\n"
#: Named like a group that files of VTK have.
STEPS = UPPER.replace("upper", "Steps")
MIXED = BLOCK + "\ncells = [3, 6]\n" + STEPS
TIME = "[time]\nend = 0.1\nstep = 0.002\n[output]\n"


def grids(folder: Path) -> list[tuple[float, dict[str, Any]]]:
    """Times and bodies of a run, whatever its format."""
    from solver.pictures.meshes import HdfGrids, PvdGrids

    one = folder / NAME
    files = HdfGrids(one) if one.is_file() else PvdGrids(folder / "fields.pvd")
    return [
        (float(at), dict(zip(files.names, files.read(k), strict=True)))
        for k, at in enumerate(files.times)
    ]


def by_place(grid: Any) -> tuple[Any, Any]:
    """The order of nodes and of cells by where they are, those of other ranks once."""
    places = np.asarray(grid.points).round(9)
    centres = np.asarray(grid.cell_centers().points).round(9)
    own = np.asarray(grid.cell_data.get("vtkGhostType", np.zeros(grid.n_cells))) == 0
    _, nodes = np.unique(places, axis=0, return_index=True)
    cells = np.lexsort(centres.T)
    return nodes, cells[own[cells]]


def assert_same(one: Any, other: Any) -> None:
    """The same fields at the same places."""
    orders = by_place(one), by_place(other)
    for kind in ("point_data", "cell_data"):  # what VTK and dolfinx add is no field
        found = {name for name in getattr(one, kind).keys() if not name.startswith("vtk")}
        assert found == set(getattr(other, kind).keys())
    for name in other.point_data:
        values = [np.asarray(g.point_data[name])[o[0]] for g, o in zip((one, other), orders)]  # noqa: B905
        np.testing.assert_allclose(values[0], values[1], rtol=1e-12, atol=1e-12)
    for name in other.cell_data:
        values = [np.asarray(g.cell_data[name])[o[1]] for g, o in zip((one, other), orders)]  # noqa: B905
        np.testing.assert_allclose(values[0], values[1], rtol=1e-9, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "ranks"),
    [(RIGID + STEPS, 1), pytest.param(MIXED, 2, marks=pytest.mark.mpi)],
    ids=["rigid", "mixed, two ranks"],
)
def test_the_same_fields(tmp_path: Path, text: str, ranks: int) -> None:
    if text == MIXED:
        pytest.importorskip("dolfinx")
    (tmp_path / "scene.toml").write_text(text + TIME)
    for fields in ("vtk", "vtkhdf"):
        words = "-q", "-o", fields, "--set", f'output.fields="{fields}"'
        assert on_ranks(ranks, tmp_path, "run", "scene.toml", *words).returncode == 0
    assert not (tmp_path / "vtkhdf" / "fields").exists()
    pieces, file = grids(tmp_path / "vtk"), grids(tmp_path / "vtkhdf")
    assert [at for at, _ in file] == [at for at, _ in pieces]
    assert len(file) == 11
    for (_, many), (_, one) in zip(pieces, file, strict=True):
        assert list(one) == ["block", "Steps"]
        for name, grid in one.items():
            assert_same(many[name], grid)
    if ranks == 1:
        assert main(["plot", str(tmp_path / "vtkhdf")]) == 0
        assert (tmp_path / "vtkhdf" / "deformed.png").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("text", [RIGID, MIXED], ids=["rigid", "mixed"])
def test_a_run_that_goes_on_holds_each_time_once(tmp_path: Path, text: str) -> None:
    if text == MIXED:
        pytest.importorskip("dolfinx")
    scene = parse_scene(text + TIME + 'fields = "vtkhdf"\ncheckpoint = { steps = 30 }\n')
    folder = tmp_path / "out"
    simulate(scene, folder=folder)
    before = grids(folder)
    assert [at for at, _ in before] == pytest.approx([0.01 * k for k in range(11)])
    simulate(scene, folder=folder, resume=True)
    after = grids(folder)
    assert [at for at, _ in after] == [at for at, _ in before]
    for (_, one), (_, other) in zip(before, after, strict=True):
        for name, grid in one.items():
            assert_same(grid, other[name])


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    scene = parse_scene(RIGID + TIME + 'fields = "vtkhdf"\ncheckpoint = { steps = 30 }\n')
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Schedule, "wanted", False)  # no checkpoint at the end
        simulate(scene, folder=tmp_path)
    (tmp_path / NAME).write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    with pytest.raises(OutputTrouble, match="is damaged; without it the run goes on"):
        simulate(scene, folder=tmp_path, resume=True)
    (tmp_path / NAME).unlink()
    simulate(scene, folder=tmp_path, resume=True)
    assert [at for at, _ in grids(tmp_path)] == pytest.approx([0.01 * k for k in range(7, 11)])


def test_without_h5py(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line, and an earlier run is left alone."""
    scene = parse_scene(RIGID + TIME + 'fields = "vtkhdf"\n')
    (tmp_path / "scene.toml").write_text(scene_to_toml(scene))
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "history.csv").touch()
    monkeypatch.setattr("solver.fields.vtkhdf.find_spec", lambda name: None)
    words = ["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out"), "--force"]
    assert main(words) == 2
    assert capsys.readouterr().err == (
        'rockslip: output.fields is "vtkhdf", for which h5py has to be installed; '
        '"vtk" does without\n'
    )
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["history.csv"]


FILLS = """
import resource, sys
from pathlib import Path
import numpy as np
from solver.fields.part import Part
from solver.fields.vtkhdf import HdfFile
file = HdfFile(Path(sys.argv[1]))
cells = Part(points=np.zeros((4000, 3)), nodes=np.arange(4000).reshape(1000, 4), kind=9)
body = file.body("stone", cells)
file.begin()
resource.setrlimit(resource.RLIMIT_FSIZE, (4_000_000, 4_000_000))
try:
    for k in range(100):
        nodal = {"displacement": np.full((4000, 3), float(k))}
        body.write(float(k), nodal, {"von_mises": np.zeros(1000)})
        file.end_time(float(k))
except OSError as error:
    print(k, error.errno, error.filename)
file.close()
"""


def test_no_room(tmp_path: Path) -> None:
    """Nothing is written that has no room, and the times before can be read."""
    file = tmp_path / NAME
    done = python("-c", FILLS, file)
    assert (done.returncode, done.stderr) == (0, "")
    reached, number, name = done.stdout.split()
    assert (int(number), name) == (errno.EFBIG, str(file))
    times, bodies = zip(*grids_of(file), strict=True)
    assert 10 < len(times) == int(reached)
    for k, grid in zip(times, bodies, strict=True):
        assert np.all(grid.point_data["displacement"] == k)


WRITES = """
import sys
from pathlib import Path
import numpy as np
from solver.fields.part import Part
from solver.fields.vtkhdf import HdfFile
file = HdfFile(Path(sys.argv[1]))
cells = Part(points=np.zeros((40, 3)), nodes=np.arange(40).reshape(10, 4), kind=9)
body = file.body("stone", cells)
file.begin()
for k in range(100000):
    nodal = {"displacement": np.full((40, 3), float(k))}
    body.write(float(k), nodal, {"von_mises": np.full(10, float(k))})
    file.end_time(float(k))
    if k == 0:
        print("begun", flush=True)
    sys.stdin.readline()
"""


@pytest.mark.slow
def test_a_killed_run_leaves_its_times(tmp_path: Path) -> None:
    """Between two times; whoever is killed within a write of HDF5 may leave no file at all."""
    chance = random.Random(3)
    for count in (1, 2, 30):
        file = tmp_path / f"{count}.vtkhdf"
        with subprocess.Popen(
            [sys.executable, "-c", WRITES, file],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=outside_mpirun(),
        ) as process:
            assert process.stdin is not None and process.stdout is not None
            process.stdout.readline()
            process.stdin.write(b"\n" * (count - 1))
            process.stdin.flush()
            time.sleep(chance.uniform(1.0, 1.5))
            process.send_signal(signal.SIGKILL)
        times, bodies = zip(*grids_of(file), strict=True)
        assert list(times) == [float(k) for k in range(count)]
        for k, grid in zip(times, bodies, strict=True):
            assert np.all(grid.point_data["displacement"] == k)
            assert np.all(grid.cell_data["von_mises"] == k)


def grids_of(file: Path) -> list[tuple[float, Any]]:
    """Times and the one body of a file."""
    from solver.pictures.meshes import HdfGrids

    files = HdfGrids(file)
    return [(float(at), files.read(k)[0]) for k, at in enumerate(files.times)]


def test_what_vtk_itself_reads(tmp_path: Path) -> None:
    """The grid of a body alone is one of VTK's, by the reader of VTK."""
    file = HdfFile(tmp_path / NAME)
    points = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 2.0, 0.0), (0.0, 2.0, 0.0)])
    body = file.body("stone", Part(points=points, nodes=np.arange(4)[None], kind=9))
    file.begin()
    for k in range(3):
        body.write(
            float(k),
            {"displacement": np.full((4, 3), float(k))},
            {"von_mises": np.array([5.0 * k])},
        )
        file.end_time(0.5 * k)
    file.close()
    alone = tmp_path / "stone.vtkhdf"
    with h5py.File(tmp_path / NAME) as whole, h5py.File(alone, "w") as part:
        whole.copy("VTKHDF/stone", part, name="VTKHDF")
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(alone))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    for k in range(3):
        reader.SetStep(k)
        reader.Update()
        grid = pyvista.wrap(reader.GetOutput())
        np.testing.assert_array_equal(grid.points, points)
        np.testing.assert_array_equal(grid.point_data["displacement"], np.full((4, 3), float(k)))
        assert grid.cell_data["von_mises"] == [5.0 * k]
