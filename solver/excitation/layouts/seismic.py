"""Files that obspy reads where it is installed: MiniSEED, SAC and others."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from solver.errors import SceneError
from solver.excitation.layouts.text import Component, Stated

TITLE = "by obspy"

REMEDY = "a text, or obspy installed (pip install obspy), which reads MiniSEED, SAC and others"


def components(path: Path) -> Iterator[Component]:
    """The traces of a file; they do not say their unit.

    Raises:
        SceneError: obspy is not installed, does not read the file, or finds gaps in it.
    """
    try:
        import obspy
    except ImportError:
        raise SceneError(str(path), "binary data", REMEDY) from None
    try:
        traces: list[Any] = list(obspy.read(str(path)))
    except Exception as error:  # whatever its readers raise
        said = " ".join(str(error).split()) or type(error).__name__
        raise SceneError(str(path), f"what obspy does not read ({said})", REMEDY) from None
    names: set[str] = set()
    for trace in traces:
        values = np.asarray(trace.data, dtype=float)
        step, calib = float(trace.stats.delta), float(getattr(trace.stats, "calib", 1.0))
        name = str(trace.id)
        if name in names:
            raise SceneError(str(path), f"several traces of {name}", "one without gaps")
        names.add(name)
        if len(values) < 2 or not np.isfinite(values).all() or not 0 < step < np.inf:
            got = f"{name}: {len(values)} samples {step:g} s apart"
            raise SceneError(str(path), got, "2 finite samples or more")
        if calib != 1.0:
            raise SceneError(str(path), f"{name} with a factor {calib:g} of its own", "1")
        lines = list(range(1, len(values) + 1))
        yield Component(name=name, values=values, lines=lines, steps=(Stated(step, 0),))
