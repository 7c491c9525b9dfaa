"""A motion from a file of times and accelerations: kind = "table"."""

from __future__ import annotations

import numpy as np

from solver.excitation.layouts.table import read_motion
from solver.excitation.sampled import SampledMotion
from solver.scene.motion import TableSpec


def signal(spec: TableSpec, end: float, where: str) -> SampledMotion:
    """The samples at the times of the file, which need not be equally far apart.

    Raises:
        SceneError: The file cannot be read, or is no such table; names file and line.
    """
    read = read_motion(spec, where)
    # A layout may say only how far apart they are.
    even = np.asarray(np.arange(len(read.values)) * (read.step or 0.0), dtype=np.float64)
    time = even if read.time is None else read.time
    largest = f"line {read.lines[int(np.argmax(np.abs(read.values)))]} of {spec.file}"
    value = read.values * (read.unit * spec.scale)
    return SampledMotion(
        time=time, value=value, step=read.step, largest=largest, source=read.source
    )
