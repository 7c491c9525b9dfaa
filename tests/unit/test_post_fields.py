"""Fields come back from their files as they went in, on one rank and on several."""

from __future__ import annotations

import os
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from solver.post.paraview import paraview_script

pyvista = pytest.importorskip("pyvista")
pytest.importorskip("dolfinx")

STRETCH, ANGLE, LAME, SHEAR = 1e-3, 0.4, 2.0e9, 3.0e9
ROTATION = np.array([[np.cos(ANGLE), np.sin(ANGLE)], [-np.sin(ANGLE), np.cos(ANGLE)]])
DEFORMATION = ROTATION @ np.diag([1 + STRETCH, 1.0])

# Run on every rank: writes two instants of a turned and stretched block.
WRITE = """
import sys
from pathlib import Path
from mpi4py import MPI
import numpy as np
from dolfinx import fem, mesh
from solver.mechanics.material import Material
from solver.post.fields import FieldWriter

file, degree, cell, plane = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4]
F = np.array([float(f) for f in sys.argv[5].split(",")]).reshape(2, 2)
block = mesh.create_rectangle(
    MPI.COMM_WORLD, [(-0.1, 0.0), (0.1, 1.0)], (3, 7), cell_type=mesh.CellType[cell],
    ghost_mode=mesh.GhostMode.shared_facet)
V = fem.functionspace(block, ("Lagrange", degree, (2,)))
Q = fem.functionspace(block, ("Lagrange", degree))
u, v, p = fem.Function(V), fem.Function(V), fem.Function(Q)
lame, shear = 2.0e9, 3.0e9
material = Material(young=shear * (3 * lame + 2 * shear) / (lame + shear),
                    poisson=lame / (2 * (lame + shear)), density=1.0, plane=plane)
with FieldWriter(file, displacement=u, velocity=v, contact_pressure=p, material=material) as writer:
    writer.write(0.0)
    u.interpolate(lambda x: (F - np.eye(2)) @ x[:2])
    v.interpolate(lambda x: np.array([x[1], -x[0]]))
    p.interpolate(lambda x: 7.0 - x[1])
    writer.write(0.25)
"""


def von_mises(plane: str) -> float:
    """The stress of DEFORMATION: diagonal in the turned frame."""
    strain = STRETCH + STRETCH**2 / 2
    lame = LAME if plane == "strain" else 2 * LAME * SHEAR / (LAME + 2 * SHEAR)
    along = (lame + 2 * SHEAR) * strain * (1 + STRETCH)
    beside = lame * strain / (1 + STRETCH)
    across = beside if plane == "strain" else 0.0
    squares = (along - beside) ** 2 + (beside - across) ** 2 + (across - along) ** 2
    return float(np.sqrt(squares / 2))


def write_fields(file: Path, *, ranks: int, degree: int, cell: str, plane: str) -> None:
    numbers = ",".join(repr(float(value)) for value in DEFORMATION.ravel())
    command = [sys.executable, "-c", WRITE, str(file), str(degree), cell, plane, numbers]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks), *command]
    # not taken for a rank of the run that this test may be part of
    outside = {k: v for k, v in os.environ.items() if not k.startswith(("PMIX_", "OMPI_COMM_"))}
    done = subprocess.run(command, env=outside, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


def read_fields(file: Path, time: float) -> pyvista.UnstructuredGrid:
    reader = pyvista.get_reader(str(file))
    reader.set_active_time_value(time)
    return reader.read().combine()


def assert_fields(grid: pyvista.UnstructuredGrid, plane: str) -> None:
    place: NDArray[np.float64] = np.asarray(grid.points)[:, :2]
    zeros = np.zeros((len(place), 1))
    moved = place @ (DEFORMATION - np.eye(2)).T
    turning = np.stack([place[:, 1], -place[:, 0]], axis=1)
    data = grid.point_data
    np.testing.assert_allclose(data["displacement"], np.hstack([moved, zeros]), atol=1e-14)
    np.testing.assert_allclose(data["velocity"], np.hstack([turning, zeros]), atol=1e-14)
    np.testing.assert_allclose(data["contact_pressure"], 7.0 - place[:, 1], atol=1e-13)
    np.testing.assert_allclose(grid.cell_data["von_mises"], von_mises(plane), rtol=1e-9)


@pytest.mark.serial
@pytest.mark.parametrize(
    ("degree", "cell", "plane"),
    [(1, "quadrilateral", "strain"), (2, "triangle", "stress"), (2, "quadrilateral", "strain")],
)
def test_fields_come_back(tmp_path: Path, degree: int, cell: str, plane: str) -> None:
    file = tmp_path / "fields.pvd"
    write_fields(file, ranks=1, degree=degree, cell=cell, plane=plane)
    assert pyvista.get_reader(str(file)).time_values == [0.0, 0.25]
    still = read_fields(file, 0.0)
    assert not np.any(still.point_data["displacement"])
    assert np.max(np.abs(still.cell_data["von_mises"])) < 1e-6
    assert still.n_cells == 21 * (2 if cell == "triangle" else 1)
    assert_fields(read_fields(file, 0.25), plane)


@pytest.mark.serial
@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3])
def test_fields_come_back_from_several_ranks(tmp_path: Path, ranks: int) -> None:
    file = tmp_path / "fields.pvd"
    write_fields(file, ranks=ranks, degree=1, cell="quadrilateral", plane="strain")
    grid = read_fields(file, 0.25)
    assert_fields(grid, "strain")
    assert np.count_nonzero(grid.cell_data["vtkGhostType"] == 0) == 21


def test_the_paraview_script_runs(tmp_path: Path) -> None:
    """It opens the file beside it and warps true to scale (against a stand-in for ParaView)."""
    seen: dict[str, dict[str, object]] = {}

    class Anything:
        def __getattr__(self, name: str) -> Anything:
            return Anything()

        def __call__(self, *args: object, **kwargs: object) -> Anything:
            return Anything()

    class Simple(types.ModuleType):
        def __getattr__(self, name: str) -> object:
            def call(*args: object, **kwargs: object) -> Anything:
                seen[name] = kwargs
                return Anything()

            return call

    script = tmp_path / "open_in_paraview.py"
    script.write_text(paraview_script(0.75))
    modules = {"paraview": types.ModuleType("paraview"), "paraview.simple": Simple("simple")}
    with pytest.MonkeyPatch.context() as patch:
        for name, module in modules.items():
            module.__path__ = []
            patch.setitem(sys.modules, name, module)
        exec(compile(script.read_text(), script, "exec"), {"__file__": str(script)})
    assert seen["PVDReader"]["FileName"] == str(tmp_path / "fields.pvd")
    assert seen["WarpByVector"]["ScaleFactor"] == 1.0
    assert seen["Line"]["Point1"] == [-0.75, 0.0, 0.0]
