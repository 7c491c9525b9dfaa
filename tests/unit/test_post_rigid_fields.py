"""The index of the fields and the fields of rigid bodies, read back by others."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from solver.fields.pvd import PvdIndex
from solver.fields.rigid_writer import RigidFieldWriter


def test_an_index_is_complete_after_every_piece(tmp_path: Path) -> None:
    """Parts of one time stand at the same time; on other ranks nothing is written."""
    file = tmp_path / "fields.pvd"
    index = PvdIndex(file)
    assert not file.exists()
    index.begin()
    assert list(ET.parse(file).getroot()[0]) == []
    for k in range(3):
        index.add(0.1 * k, f"a{k}.vtu")
        index.add(0.1 * k, f"b{k}.vtu", part=1)
        entries = list(ET.parse(file).getroot()[0])
        assert len(entries) == 2 * (k + 1)
        assert [float(entry.attrib["timestep"]) for entry in entries[-2:]] == [0.1 * k] * 2
        assert [entry.attrib["part"] for entry in entries[-2:]] == ["0", "1"]
        assert entries[-1].attrib["file"] == f"b{k}.vtu"
    other = PvdIndex(tmp_path / "other.pvd", writes=False)
    other.begin()
    other.add(0.0, "a.vtu")
    assert not (tmp_path / "other.pvd").exists()


@pytest.mark.parametrize("writes", [True, False])
def test_a_rigid_block_alone(tmp_path: Path, writes: bool) -> None:
    """The index lists its pieces; on other ranks nothing is written."""
    corners = np.array([(-1.0, 0.0), (1.0, 0.0), (1.0, 3.0), (-1.0, 3.0)])
    index = PvdIndex(tmp_path / "fields.pvd", writes=writes)
    index.begin()
    writer = RigidFieldWriter(tmp_path / "fields_lid.pvd", corners, index=index, writes=writes)
    third = np.full((4, 2), 1 / 3)
    writer.write(0.5, third, -third)
    if not writes:
        assert not list(tmp_path.iterdir())
        return
    pyvista = pytest.importorskip("pyvista")
    reader = pyvista.get_reader(str(tmp_path / "fields.pvd"))
    assert reader.time_values == [0.5]
    grid = reader.read().combine()
    np.testing.assert_array_equal(np.asarray(grid.points)[:, :2], corners)
    np.testing.assert_array_equal(grid.point_data["displacement"][:, :2], third)
    np.testing.assert_array_equal(grid.point_data["velocity"], [[-1 / 3, -1 / 3, 0]] * 4)


@pytest.mark.serial
def test_rigid_fields_import_neither_dolfinx_nor_vtk() -> None:
    """They are slow to import, and runs of rigid blocks take less time than that."""
    code = "import solver.fields.rigid_writer, solver.fields.ground, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"dolfinx", "vtk", "pyvista", "vtkmodules", "matplotlib"} & set(done.stdout.split())
