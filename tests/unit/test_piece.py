"""Pieces of the fields and their index, read back by VTK."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from solver.fields.part import Part, in_space, one_cell, rigid_fields
from solver.fields.vtu import FieldsBefore, PieceWriter, PvdFiles

pyvista = pytest.importorskip("pyvista")

SQUARES = Part(
    points=in_space(np.array([(x, y) for y in (0.0, 1.0) for x in (0.0, 1.0, 1.0 / 3.0)])),
    nodes=np.array([(0, 2, 5, 3), (2, 1, 4, 5)]),
    kind=9,
)


def test_numbers_come_back_to_the_last_bit(tmp_path: Path) -> None:
    """Those at the ends of what numbers may be, too; the file is well-formed XML."""
    numbers = np.random.default_rng(1).normal(size=(6, 3))
    numbers[0] = 5e-324, -0.0, np.finfo(float).max
    stress = np.random.default_rng(2).normal(size=(2, 9))
    file = tmp_path / "piece.vtu"
    PieceWriter(SQUARES.points, SQUARES.nodes, SQUARES.kind).write(
        file, {"displacement": numbers, "pressure": numbers[:, 0]}, {"stress": stress}
    )
    assert ET.parse(file).getroot().attrib["type"] == "UnstructuredGrid"
    grid = pyvista.read(file)
    np.testing.assert_array_equal(grid.points, SQUARES.points)
    np.testing.assert_array_equal(grid.cells_dict[9], SQUARES.nodes)
    assert grid.point_data["displacement"].tobytes() == numbers.tobytes()
    assert grid.point_data["pressure"].tobytes() == numbers[:, 0].tobytes()
    assert grid.cell_data["stress"].tobytes() == stress.tobytes()


def test_an_index_is_complete_after_every_piece(tmp_path: Path) -> None:
    """Bodies of one time stand at the same time; on other ranks nothing is written."""
    corners = np.array([(-1.0, 0.0), (1.0, 0.0), (1.0, 3.0), (-1.0, 3.0)])
    third = np.full((4, 2), 1 / 3)
    for writes in (False, True):
        files = PvdFiles(tmp_path, FieldsBefore(), writes=writes)
        bodies = [files.body(name, one_cell(corners)) for name in ("lid", "block")]
        files.begin()
        for k in range(3):
            for body in bodies:
                body.write(0.1 * k, rigid_fields(k * third, -third), {})
            if writes:
                entries = list(ET.parse(tmp_path / "fields.pvd").getroot()[0])
                assert len(entries) == 2 * (k + 1)
                assert [float(entry.attrib["timestep"]) for entry in entries[-2:]] == [0.1 * k] * 2
                assert [entry.attrib["part"] for entry in entries[-2:]] == ["0", "1"]
                assert entries[-1].attrib["file"] == f"fields/fields_block{k:06d}.vtu"
        assert writes or not list(tmp_path.iterdir())
    reader = pyvista.get_reader(str(tmp_path / "fields.pvd"))
    assert reader.time_values == [0.0, 0.1, 0.2]
    reader.set_active_time_value(0.1)
    grid = reader.read()[1]
    np.testing.assert_array_equal(np.asarray(grid.points)[:, :2], corners)
    np.testing.assert_array_equal(grid.point_data["displacement"][:, :2], third)
    np.testing.assert_array_equal(grid.point_data["velocity"], [[-1 / 3, -1 / 3, 0]] * 4)


@pytest.mark.serial
def test_rigid_fields_import_neither_dolfinx_nor_vtk() -> None:
    """They are slow to import, and runs of rigid blocks take less time than that."""
    code = "import solver.fields.rigid_snapshots, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"dolfinx", "vtk", "pyvista", "vtkmodules", "matplotlib"} & set(done.stdout.split())
