"""All fields of a run in one file, `fields.vtkhdf`: VTK's layout of HDF5, a body a block of it.

Meshes stand in it once, fields once for each time. A time counts when all of it is on the disk:
its values are written first, the list of times last. A run that is killed leaves a file with the
times before, unless it was killed within the milliseconds in which HDF5 writes one.
"""

from __future__ import annotations

import errno
import os
import re
import resource
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np

from solver.errors import Statement, of_file
from solver.fields.part import Part, Values
from solver.scene import Scene

#: Name of the file.
NAME = "fields.vtkhdf"

#: Version of the layout: the first with several bodies.
VERSION = (2, 1)

#: What the layout itself calls so beside the bodies.
TAKEN = ("Assembly", "Steps")

#: Numbers in a piece of the file that is read or written at once, if there are as many.
AT_ONCE = 4096

#: Room that a body needs besides its values, bytes: what pieces are rounded up to.
ROOM = 1 << 20


def refuse_without_h5py(scene: Scene) -> None:
    """Refuse a scene whose fields go into one file where nothing is there to write it."""
    if scene.output.fields == "vtkhdf" and find_spec("h5py") is None:
        raise Statement(
            "output.fields", 'is "vtkhdf", for which h5py has to be installed; "vtk" does without'
        )


class HdfFile:
    """The file, which the first rank writes with what it gathers from all."""

    def __init__(self, file: Path, *, writes: bool = True, until: float | None = None):
        """Take the path; of an old file the times up to one, s, stay."""
        self.path, self.writes, self._until, self.times = file, writes, until, 0
        """Number of times in the file."""
        self.root: Any = None
        """The group of all that VTK reads."""
        self._file: Any = None
        self._bodies: list[HdfBody] = []

    def begin(self) -> None:
        """Begin the file, or go on in it."""
        if not self.writes:
            return
        try:
            import h5py
        except (ImportError, RuntimeError, ValueError) as error:  # a wheel beside another HDF5
            said = "h5py does not work here: is it of the same distribution as dolfinx?"
            raise OSError(errno.ELIBBAD, said, str(self.path)) from error
        goes_on = self._until is not None and self.path.is_file()
        with _system_errors(self.path, "is damaged; without it the run goes on" if goes_on else ""):
            # Without a lock: a run that goes on can be looked at before its end.
            self._file = h5py.File(self.path, "r+" if goes_on else "w", locking=False)
            if goes_on:
                self.root = self._file["VTKHDF"]
                self.times = self._kept(self._until or 0.0)
            else:
                self.root = self._group(self._file, "VTKHDF", "MultiBlockDataSet")
                self.root.create_group("Assembly", track_order=True)

    def _kept(self, until: float) -> int:
        """Number of the first times that stay."""
        found = [body["Steps"] for body in self.root["Assembly"].values()]
        times = [np.asarray(s["Values"][: s.attrs["NSteps"]]) for s in found]
        return min((int(np.count_nonzero(t <= until)) for t in times), default=0)

    def _group(self, parent: Any, name: str, kind: str) -> Any:
        """A new group that holds a data set of VTK."""
        group = parent.create_group(name, track_order=True)
        group.attrs["Version"] = np.array(VERSION)
        group.attrs.create("Type", np.bytes_(kind))
        return group

    def check_room(self, size: int) -> None:
        """Raise the system's error where so many bytes more have no room.

        HDF5 does not survive that: it ends the process when it closes the file.
        """
        limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
        if limit != resource.RLIM_INFINITY and self.path.stat().st_size + size > limit:
            raise OSError(errno.EFBIG, os.strerror(errno.EFBIG), str(self.path))
        try:
            with TemporaryFile(dir=self.path.parent) as tried:
                os.posix_fallocate(tried.fileno(), 0, size)
        except OSError as error:
            raise of_file(error, self.path) from error

    def body(self, name: str, part: Part) -> HdfBody:
        """The next body; it is written with its first fields."""
        body = HdfBody(self, len(self._bodies), name, part)
        self._bodies.append(body)
        return body

    def new_group(self, number: int, name: str) -> Any:
        """The group of a body, which the assembly of all bodies names."""
        import h5py

        place = f"{name}_" if name in TAKEN else name
        group = self._group(self.root, place, "UnstructuredGrid")
        group.attrs["Index"] = number
        self.root["Assembly"][name] = h5py.SoftLink(f"/VTKHDF/{place}")
        return group

    def end_time(self, time: float) -> None:
        """Let the fields that all bodies have written count, as those at a time, s."""
        if not self.writes:
            return
        with _system_errors(self.path):
            for body in self._bodies:
                body.extend(self.times)
            self._file.flush()
            for body in self._bodies:
                body.count(self.times, time)
            self._file.flush()
        self.times += 1

    def close(self) -> None:
        """Close the file; what was written stays where there is no room for more."""
        if self._file is not None:
            with suppress(OSError, RuntimeError, ValueError):
                self._file.close()


class HdfBody:
    """A body in the file; every rank that shares it calls every method.

    Nodes and cells stand in the order of their numbers among those of all ranks.
    """

    def __init__(self, file: HdfFile, number: int, name: str, part: Part):
        """Gather the mesh."""
        self._file, self._number, self._name, self._comm = file, number, name, part.comm
        self._own_points, self._own_cells = part.own_points, part.own_cells
        nodes = part.nodes[: part.own_cells]
        nodes = nodes if part.numbers is None else part.numbers[nodes]
        self._points_at, self._nodes = (
            self._whole(part.points[: part.own_points]),
            self._whole(nodes),
        )
        self._kind = int(np.max(self._whole(np.array([part.kind]))))
        self._group: Any = None
        self._points: list[str] = []
        self._means: list[str] = []

    def _whole(self, own: Values) -> Values:
        """An array of all ranks on the first one, one behind the other; its own on others."""
        if self._comm.size == 1:
            return own
        parts = self._comm.gather(own, root=0)  # type: ignore[union-attr]
        return own if parts is None else np.concatenate(parts)

    def write(self, time: float, nodal: Mapping[str, Values], means: Mapping[str, Values]) -> None:
        """Write the fields at the nodes, (n,) or (n, k), and in the cells, at the next time."""
        nodal = {name: self._whole(known[: self._own_points]) for name, known in nodal.items()}
        means = {name: self._whole(known[: self._own_cells]) for name, known in means.items()}
        if not self._file.writes:
            return
        size = sum(values.nbytes for values in (*nodal.values(), *means.values()))
        if self._group is None:
            size += 2 * (self._points_at.nbytes + self._nodes.nbytes)
        self._file.check_room(size + ROOM)
        with _system_errors(self._file.path):
            if self._group is None:
                self._open(list(nodal), list(means))
            for kind, fields in (("PointData", nodal), ("CellData", means)):
                for name, values in fields.items():
                    _put(self._group[kind], name, self._file.times * len(values), values)

    def _open(self, nodal: list[str], means: list[str]) -> None:
        """The group of the body: that of an earlier part of the run, or a new one.

        Raises:
            ValueError: The earlier part has another mesh.
        """
        self._points, self._means = nodal, means
        if self._name in self._file.root["Assembly"]:
            self._group = self._file.root["Assembly"][self._name]
            if not np.array_equal(self._group["Points"][:], self._points_at):
                raise ValueError("places of another mesh")
            return
        group = self._file.new_group(self._number, self._name)
        count, per_cell = self._nodes.shape
        group["Points"] = self._points_at
        group["Connectivity"] = self._nodes.ravel()
        group["Offsets"] = np.arange(count + 1) * per_cell
        group["Types"] = np.full(count, self._kind, np.uint8)
        group["NumberOfPoints"] = np.array([len(self._points_at)])
        group["NumberOfCells"] = np.array([count])
        group["NumberOfConnectivityIds"] = np.array([count * per_cell])
        for name in ("PointData", "CellData", "Steps"):
            group.create_group(name, track_order=True)
        group["Steps"].attrs["NSteps"] = 0
        _put(group["Steps"], "Values", 0, np.empty(0))
        self._group = group

    def extend(self, before: int) -> None:
        """Say where the fields of the next time stand; `before` are the times before it."""
        steps, next_time = self._group["Steps"], np.array([before])
        same = np.zeros(1, dtype=np.int64)
        for name in ("PartOffsets", "PointOffsets"):
            _put(steps, name, before, same)
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            _put(steps, name, before, same[:, None])
        _put(steps, "NumberOfParts", before, same + 1)
        for kind, names, size in (
            ("PointDataOffsets", self._points, len(self._points_at)),
            ("CellDataOffsets", self._means, len(self._nodes)),
        ):
            for name in names:
                _put(steps.require_group(kind), name, before, next_time * size)

    def count(self, before: int, time: float) -> None:
        """Add a time, s, to those before."""
        steps = self._group["Steps"]
        _put(steps, "Values", before, np.array([time]))
        steps.attrs["NSteps"] = before + 1


def _put(group: Any, name: str, start: int, values: Values) -> None:
    """Write values from a row of a data set on, which then ends with them."""
    if name not in group:
        width = values[:1].size
        rows = len(values) * max(1, AT_ONCE // max(1, len(values) * width))
        group.create_dataset(
            name,
            shape=(0, *values.shape[1:]),
            maxshape=(None, *values.shape[1:]),
            chunks=(max(1, rows), *values.shape[1:]),
            dtype=values.dtype,
        )
    data = group[name]
    data.resize(start + len(values), axis=0)
    data[start:] = values


@contextmanager
def _system_errors(file: Path, said: str = "") -> Iterator[None]:
    """Let errors of HDF5, which are of many types, be those of the system, or what is said."""
    try:
        yield
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        found = re.search(r"errno = (\d+)", str(error))
        if found is None:
            raise OSError(errno.EIO, said or "HDF5 cannot write it", str(file)) from error
        number = int(found[1])
        raise OSError(number, os.strerror(number), str(file)) from error
