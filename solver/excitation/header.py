"""What the header of a file of accelerations says of their unit, and what the scene says of it."""

from __future__ import annotations

from pathlib import Path

from solver.errors import SceneError
from solver.scene.checking import shown
from solver.scene.units import MOVED, UNITS, units_named


def unit_said(file: Path, header: list[str], units: str | None, where: str) -> str | None:
    """The unit of a file's values: that of the scene, else that of the header; None: none is named.

    `units` is what the scene says under the path `where`.

    Raises:
        SceneError: The two do not agree, or the header names no unit of acceleration.
    """
    line, named = units_named(header)
    if named is not None and (named in MOVED or (named not in UNITS and units is None)):
        allowed = f"accelerations in {', '.join(UNITS)}"
        raise SceneError(f"{file}: line {line}", f"units of {named}", allowed)
    if units is not None and named in UNITS and units != named:
        allowed = f"{shown(named)}, as line {line} of {file} says"
        raise SceneError(f"{where}.units", shown(units), allowed)
    return units or named
