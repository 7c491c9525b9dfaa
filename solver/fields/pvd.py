"""The index of the fields, `fields.pvd`: which piece shows which part at which time."""

from __future__ import annotations

from pathlib import Path

HEAD = b'<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0">\n  <Collection>\n'
TAIL = b"  </Collection>\n</VTKFile>\n"


class PvdIndex:
    """A .pvd file that is complete after every piece, so that a killed run can be looked at.

    Bodies are the parts of a time: ParaView and pyvista show those of one time together.
    """

    def __init__(self, file: Path, *, writes: bool = True):
        """Start an empty index over an old file; `writes` is False on all ranks but one."""
        self._file, self._writes = file, writes
        self._end = len(HEAD)
        if writes:
            file.write_bytes(HEAD + TAIL)

    def add(self, time: float, piece: str, part: int = 0) -> None:
        """List a piece by its name in the folder of the index; `part` is the number of the body.

        The time (s) is the same number for all parts.
        """
        if not self._writes:
            return
        entry = f'    <DataSet timestep="{time:.17g}" part="{part}" file="{piece}" />\n'.encode()
        with self._file.open("r+b") as stream:
            stream.seek(self._end)
            stream.write(entry + TAIL)
        self._end += len(entry)
