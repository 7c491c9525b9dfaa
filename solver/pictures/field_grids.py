"""The bodies in the files of the fields, as they are written: undeformed and upright."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from solver.types import Array


class PvdGrids:
    """Grids of the bodies in the files that `fields.pvd` lists."""

    def __init__(self, file: Path):
        """Read the index."""
        import pyvista

        self._reader = pyvista.get_reader(str(file))
        self.times: Array = np.array(self._reader.time_values)
        """s."""
        entries = list(ET.parse(file).iter("DataSet"))
        first = entries[0].get("timestep")
        self.names = [e.get("name", "") for e in entries if e.get("timestep") == first]
        """What the bodies are called, in their order; empty where the file does not say."""

    def read(self, index: int) -> list[Any]:
        """The bodies at one of the times; None for one without a file."""
        self._reader.set_active_time_value(self.times[index])
        return list(self._reader.read())


class HdfGrids:
    """Grids of the bodies in `fields.vtkhdf`, read by h5py.

    The VTK of Debian 13 does not read several bodies with time.
    """

    def __init__(self, file: Path):
        """Read the times and the names."""
        import h5py

        self._file = h5py.File(file, "r", locking=False)
        self._bodies = dict(self._file["VTKHDF/Assembly"])
        self.names = list(self._bodies)
        """What the bodies are called, in their order."""
        steps = [body["Steps"] for body in self._bodies.values()]
        count = min(int(each.attrs["NSteps"]) for each in steps)
        self.times: Array = np.asarray(steps[0]["Values"][:count])
        """s."""

    def read(self, index: int) -> list[Any]:
        """The bodies at one of the times."""
        return [_grid(body, index) for body in self._bodies.values()]


def _grid(body: Any, index: int) -> Any:
    """A body of the one file at one of its times."""
    import pyvista

    ends = np.asarray(body["Offsets"])
    counts = np.diff(ends)
    cells = np.insert(np.asarray(body["Connectivity"]), ends[:-1], counts)
    grid = pyvista.UnstructuredGrid(cells, np.asarray(body["Types"]), np.asarray(body["Points"]))
    for kind, data in (("PointData", grid.point_data), ("CellData", grid.cell_data)):
        for name, values in body[kind].items():
            start = int(body[f"Steps/{kind}Offsets/{name}"][index])
            size = grid.n_points if kind == "PointData" else grid.n_cells
            data[name] = np.asarray(values[start : start + size])
    return grid
