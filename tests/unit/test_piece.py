"""Pieces of the fields, read back by VTK."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from solver.fields.cells import Cells, in_space
from solver.fields.piece import COPIES, PieceWriter, write_parts

pyvista = pytest.importorskip("pyvista")

SQUARES = Cells(
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
    PieceWriter(SQUARES).write(
        file, {"displacement": numbers, "pressure": numbers[:, 0]}, {"stress": stress}
    )
    assert ET.parse(file).getroot().attrib["type"] == "UnstructuredGrid"
    grid = pyvista.read(file)
    np.testing.assert_array_equal(grid.points, SQUARES.points)
    np.testing.assert_array_equal(grid.cells_dict[9], SQUARES.nodes)
    assert grid.point_data["displacement"].tobytes() == numbers.tobytes()
    assert grid.point_data["pressure"].tobytes() == numbers[:, 0].tobytes()
    assert grid.cell_data["stress"].tobytes() == stress.tobytes()


def test_parts_are_opened_together(tmp_path: Path) -> None:
    """Copies are told from what they are copies of; a rank may have no cell at all."""
    nothing = Cells(points=np.empty((0, 3)), nodes=np.empty((0, 4), dtype=np.int64), kind=0)
    parts = ["piece_p0.vtu", "piece_p1.vtu"]
    for part, cells in zip(parts, (SQUARES, nothing), strict=True):
        nodal = {
            "pressure": cells.points[:, 0].copy(),
            COPIES: np.zeros(len(cells.points), np.uint8),
        }
        means = {COPIES: np.ones(len(cells.nodes), dtype=np.uint8)}
        PieceWriter(cells).write(tmp_path / part, nodal, means)
    write_parts(tmp_path / "piece.pvtu", parts, nodal, means)
    grid = pyvista.read(tmp_path / "piece.pvtu")
    assert grid.n_cells == 2
    np.testing.assert_array_equal(grid.point_data["pressure"], SQUARES.points[:, 0])
    np.testing.assert_array_equal(grid.cell_data[COPIES], [1, 1])
