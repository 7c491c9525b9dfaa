"""Fields come back from their files as they went in, on one rank and on several."""

from __future__ import annotations

import sys
import types
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from processes import python

from rockslip import parse_scene
from solver.fields.ground import floor_level, half_floor
from solver.fields.paraview import write_script

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
from solver.bodies.elastic_forms import Moduli
from solver.scene.material import Material
from solver.fields.functions import BodyFunctions, part_of
from solver.fields.vtu import FieldsBefore, PvdFiles

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
nodal = {"displacement": u, "velocity": v, "contact_pressure": p}
files = PvdFiles(file.parent, FieldsBefore(), writes=MPI.COMM_WORLD.rank == 0)
files.begin()
functions = BodyFunctions(nodal, Moduli.of(block, material))
writer = files.body("stone", part_of(V))
write = lambda time: writer.write(time, *functions.arrays())
write(0.0)
u.interpolate(lambda x: (F - np.eye(2)) @ x[:2])
v.interpolate(lambda x: np.array([x[1], -x[0]]))
p.interpolate(lambda x: 7.0 - x[1])
write(0.25)
"""


def principal(plane: str) -> list[float]:
    """The stresses of DEFORMATION: along and beside the stretch, and across the plane."""
    strain = STRETCH + STRETCH**2 / 2
    lame = LAME if plane == "strain" else 2 * LAME * SHEAR / (LAME + 2 * SHEAR)
    along = (lame + 2 * SHEAR) * strain * (1 + STRETCH)
    beside = lame * strain / (1 + STRETCH)
    return [along, beside, beside if plane == "strain" else 0.0]


def von_mises(plane: str) -> float:
    """Of the principal stresses."""
    along, beside, across = principal(plane)
    squares = (along - beside) ** 2 + (beside - across) ** 2 + (across - along) ** 2
    return float(np.sqrt(squares / 2))


def cauchy(plane: str) -> NDArray[np.float64]:
    """Diagonal in the turned frame, and across the plane."""
    turned = np.eye(3)
    turned[:2, :2] = ROTATION
    return np.asarray(turned @ np.diag(principal(plane)) @ turned.T)


def said_by(code: str, *arguments: object, ranks: int) -> str:
    """Run a script on some ranks; returns what it says."""
    done = python("-c", code, *map(str, arguments), ranks=ranks)
    assert done.returncode == 0, done.stderr
    return done.stdout


def write_fields(file: Path, *, ranks: int, degree: int, cell: str, plane: str) -> None:
    numbers = ",".join(repr(float(value)) for value in DEFORMATION.ravel())
    said_by(WRITE, file, degree, cell, plane, numbers, ranks=ranks)


def read_fields(file: Path, time: float | None) -> pyvista.UnstructuredGrid:
    reader = pyvista.get_reader(str(file))
    if time is None:
        return reader.read()
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
    stress = np.tile(cauchy(plane).ravel(), (grid.n_cells, 1))
    np.testing.assert_allclose(grid.cell_data["stress"], stress, atol=1e-9 * np.abs(stress).max())


# An elastic block (part 0) and a rigid one (part 1), at two instants, and the end of a killed run.
WRITE_PARTS = """
import os, sys
from pathlib import Path
from mpi4py import MPI
import numpy as np
from dolfinx import fem, mesh
from geometry.block import Block
from solver.bodies.elastic_forms import Moduli
from solver.scene.material import Material
from solver.fields.functions import BodyFunctions, part_of
from solver.fields.part import one_cell, rigid_fields
from solver.fields.vtu import FieldsBefore, PvdFiles

folder, dimension, degree, first = Path(sys.argv[1]), *map(int, sys.argv[2:5])
comm = MPI.COMM_WORLD
low = [(-0.1, 0.0), (-0.1, -0.2, 0.0)][dimension - 2]
high = [(0.1, 1.0), (0.1, 0.2, 1.0)][dimension - 2]
create = [mesh.create_rectangle, mesh.create_box][dimension - 2]
kind = [mesh.CellType.quadrilateral, mesh.CellType.hexahedron][dimension - 2]
domain = create(comm, [low, high], (2, 2, 3)[3 - dimension :], cell_type=kind)
V = fem.functionspace(domain, ("Lagrange", degree, (dimension,)))
u, v = fem.Function(V), fem.Function(V)
p = fem.Function(fem.functionspace(domain, ("Lagrange", degree)))
plane = ["strain", "solid"][dimension - 2]
material = Material(young=8e9, poisson=0.2, density=1.0, plane=plane)
files = PvdFiles(folder, FieldsBefore(), writes=comm.rank == 0)
files.begin()
corners = np.array(Block(width=0.4, height=0.1, thickness=0.4, density=1.0).corners(dimension))
nodal = {"displacement": u, "velocity": v, "contact_pressure": p}
functions = BodyFunctions(nodal, Moduli.of(domain, material))
bodies = {"stone": part_of(V), "lid": one_cell(corners)}
names = list(bodies) if first == 0 else list(bodies)[::-1]
writers = {name: files.body(name, bodies[name]) for name in names}
for time in (0.0, 0.1):
    u.interpolate(lambda x: time * np.stack([x[0], 0 * x[0], 0 * x[0]][:dimension]))
    fields = {"stone": functions.arrays()}
    fields["lid"] = rigid_fields(corners * 0.0 + np.eye(dimension)[-1], 2 * time * corners), {}
    for name in names:
        writers[name].write(time, *fields[name])
comm.Barrier()
MPI.Finalize()
os._exit(0)  # as if killed
"""


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
    assert (grid.n_cells, grid.n_points) == (21, 4 * 8)
    assert grid.compute_cell_sizes()["Area"] == pytest.approx(0.2 / 21)


@pytest.mark.serial
@pytest.mark.parametrize(
    ("ranks", "dimension", "degree", "first"),
    [
        (1, 2, 2, 0),
        (1, 3, 1, 1),
        (1, 3, 2, 0),
        pytest.param(2, 3, 1, 0, marks=pytest.mark.mpi),
    ],
)
def test_several_bodies_of_a_killed_run(
    tmp_path: Path, ranks: int, dimension: int, degree: int, first: int
) -> None:
    """All parts of an instant are read together, with all their fields."""
    said_by(WRITE_PARTS, tmp_path, dimension, degree, first, ranks=ranks)
    reader = pyvista.get_reader(str(tmp_path / "fields.pvd"))
    assert reader.time_values == [0.0, 0.1]
    assert [dataset.part for dataset in reader.datasets] == [0, 1, 0, 1]
    reader.set_active_time_value(0.1)
    parts = reader.read()
    assert len(parts) == 2
    stone, lid = parts[first], parts[1 - first]
    assert stone.n_cells == (2 * 3 if dimension == 2 else 2 * 2 * 3)
    stretch = np.asarray(stone.point_data["displacement"])
    np.testing.assert_allclose(stretch[:, 0], 0.1 * np.asarray(stone.points)[:, 0], atol=1e-15)
    assert lid.n_cells == 1
    size = 0.4 * 0.1 * (1 if dimension == 2 else 0.4)
    sizes = lid.compute_cell_sizes()
    assert sizes["Area" if dimension == 2 else "Volume"][0] == pytest.approx(size)
    up = np.eye(3)[dimension - 1]
    np.testing.assert_array_equal(lid.point_data["displacement"], np.tile(up, (lid.n_points, 1)))
    np.testing.assert_allclose(lid.point_data["velocity"], 0.2 * np.asarray(lid.points))
    assert not np.any(lid.point_data["contact_pressure"])
    assert "von_mises" not in lid.cell_data
    assert_drawn(tmp_path / "fields.pvd", dimension)


def assert_drawn(file: Path, dimension: int) -> None:
    """Each cell, or each face of the surface, once, whatever the ranks."""
    from solver.pictures.meshes import FieldFiles

    surfaces = FieldFiles(file).read(1)
    faces = 2 * 3 if dimension == 2 else 2 * (2 * 2 + 2 * 3 + 2 * 3)
    counts = {"von_mises" in surface.cell_data: surface.n_cells for surface in surfaces}
    assert counts == {True: faces, False: 1 if dimension == 2 else 6}


@pytest.mark.serial
def test_stress_in_space(tmp_path: Path) -> None:
    """Uniaxial strain in 3-D: the von Mises stress is that of plane strain, closed form."""
    said_by(WRITE_PARTS, tmp_path, 3, 1, 0, ranks=1)
    grid = read_fields(tmp_path / "fields" / "fields_stone000001.vtu", None)
    shear, lame = 8e9 / 2.4, 8e9 * 0.2 / (1.2 * 0.6)
    strain = 0.1 + 0.1**2 / 2
    along = (lame + 2 * shear) * strain * 1.1
    beside = lame * strain / 1.1
    np.testing.assert_allclose(grid.cell_data["von_mises"], along - beside, rtol=1e-9)
    stress = np.tile(np.diag([along, beside, beside]).ravel(), (grid.n_cells, 1))
    np.testing.assert_allclose(grid.cell_data["stress"], stress, atol=1e-9 * along)


@pytest.mark.parametrize(
    ("dimension", "stress", "floor"),
    [(2, True, "Line"), (2, False, "Line"), (3, True, "Plane"), (3, False, "Plane")],
)
def test_the_paraview_script_runs(tmp_path: Path, dimension: int, stress: bool, floor: str) -> None:
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
                seen[name] = kwargs | {"args": args}
                return Anything()

            return call

    script = tmp_path / "open_in_paraview.py"
    block = {"width": 0.3, "height": 1.0, "thickness": 0.3, "mass": 100.0, "model": "rigid"}
    ground = {"kind": "oscillator", "mass": 100.0, "period": 0.5}
    time = {"end": 1.0, "step": 0.1}
    scene = parse_scene(
        {"dimension": dimension, "block": [block], "foundation": ground, "time": time}
    )
    write_script(tmp_path, scene, stress=stress)
    modules = {"paraview": types.ModuleType("paraview"), "paraview.simple": Simple("simple")}
    with pytest.MonkeyPatch.context() as patch:
        for name, module in modules.items():
            module.__path__ = []
            patch.setitem(sys.modules, name, module)
        exec(compile(script.read_text(), script, "exec"), {"__file__": str(script)})
    assert seen["OpenDataFile"]["args"] == (str(tmp_path / "fields.pvd"),)
    assert seen["WarpByVector"]["ScaleFactor"] == 1.0
    assert seen["Glyph"]["ScaleFactor"] == pytest.approx(0.3 / (100.0 * scene.gravity))
    half, level = half_floor(scene), floor_level(scene)
    assert half > 1 and level < 0
    corner = [-half, level, 0.0] if dimension == 2 else [half, -half, level]
    assert seen[floor]["Point1"] == corner
    assert len({"Line", "Plane"} & set(seen)) == 1
    assert ("GetColorTransferFunction" in seen) is stress
    colour = ("CELLS", "von_mises") if stress else ("FIELD", "vtkBlockColors")
    assert seen["ColorBy"]["args"][1] == colour  # type: ignore[index]
    assert "SaveAnimation" not in seen
    assert "{time:.3f} s" in str(seen["AnnotateTime"]["Format"])


# The index cannot be written, which rank 0 finds out before meshed bodies are begun together.
TAKEN = """
import sys
from pathlib import Path
from mpi4py import MPI
from rockslip import parse_scene, simulate
from solver.errors import OutputTrouble

folder = Path(sys.argv[1])
block = {"width": 0.5, "height": 0.4, "mass": 100.0, "young": 1e9, "poisson": 0.2, "cells": [2, 2]}
try:
    simulate(parse_scene({"block": [block], "time": {"end": 0.01, "step": 1e-3}}), folder=folder)
except OutputTrouble as trouble:
    print(trouble)
"""


@pytest.mark.mpi
def test_no_rank_waits_where_the_index_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "run" / "fields.pvd").mkdir(parents=True)
    said = said_by(TAKEN, tmp_path / "run", ranks=2)
    assert said.splitlines() == ["fields.pvd: is a directory"] * 2


# There is no room for the first piece.
FULL = """
from solver.fields.vtu import PieceWriter

def full(writer, file, *what, usual=PieceWriter.write):
    if file.name.endswith("000000.vtu"):
        raise OSError(28, "No space left on device", str(file))
    usual(writer, file, *what)

PieceWriter.write = full
"""
FULL = WRITE.replace("\nfile, degree", FULL + "\nfile, degree").replace(
    "write(0.0)\n",
    """try:
    write(0.0)
except OSError as error:
    print(MPI.COMM_WORLD.rank, Path(error.filename).name)
""",
)


@pytest.mark.mpi
def test_a_piece_without_room_is_not_listed(tmp_path: Path) -> None:
    """The first rank says so, after what ranks do together; the next piece is."""
    file = tmp_path / "fields.pvd"
    said = said_by(FULL, file, 1, "triangle", "strain", "1,0,0,1", ranks=2)
    assert said.split() == ["0", "fields_stone000000.vtu"]
    assert pyvista.get_reader(str(file)).time_values == [0.25]


def test_the_stress_of_a_thin_body_does_not_depend_on_its_thickness() -> None:
    """Squeezed by 1 % along y in plane strain: E_yy = -e + e^2/2, sigma = F S F^T/det F."""
    from mpi4py import MPI

    from dolfinx import fem, mesh

    from solver.bodies.elastic_forms import Moduli
    from solver.fields.functions import BodyFunctions
    from solver.scene.material import Material

    squeeze = 0.01
    strain = -squeeze + squeeze**2 / 2
    young = SHEAR * (3 * LAME + 2 * SHEAR) / (LAME + SHEAR)
    poisson = LAME / (2 * (LAME + SHEAR))
    material = Material(young=young, poisson=poisson, density=1.0, plane="strain").times(0.3)
    block = mesh.create_rectangle(
        MPI.COMM_SELF, [(-0.1, 0.0), (0.1, 1.0)], (2, 3), cell_type=mesh.CellType.quadrilateral
    )
    u = fem.Function(fem.functionspace(block, ("Lagrange", 1, (2,))))
    u.interpolate(lambda x: np.stack([0 * x[0], -squeeze * x[1]]))
    functions = BodyFunctions({"displacement": u}, Moduli.of(block, material), 0.3)
    cells = functions.arrays()[1]
    across = LAME * strain / (1 - squeeze)
    along = (1 - squeeze) * (LAME + 2 * SHEAR) * strain
    stress = np.diag([across, along, across]).ravel()
    found = np.asarray(cells["stress"]).reshape(-1, 9)
    np.testing.assert_allclose(found, np.tile(stress, (6, 1)), atol=1e-9 * abs(along))
    np.testing.assert_allclose(np.asarray(cells["von_mises"]).ravel(), across - along, rtol=1e-9)
