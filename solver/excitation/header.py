"""What the header of a file of accelerations says of units, and what the scene says of them."""

from __future__ import annotations

from pathlib import Path

from solver.errors import SceneError
from solver.scene.checking import shown
from solver.scene.units import OTHERS, UNITS, names_milliseconds, units_named


def unit_said(file: Path, header: list[str], units: str | None, where: str) -> str | None:
    """The unit of a file's values: that of the scene, else that of the header; None: none is named.

    `units` is what the scene says under the path `where`.

    Raises:
        SceneError: The two do not agree, the header names several units of acceleration and the
            scene none, or other units than those of accelerations.
    """
    named = list(units_named(header))
    found = {each.unit: each.line for each in reversed(named) if each.unit in UNITS}
    for line, unit, stated in named:
        other = unit in OTHERS and (stated or (unit == "%g" and not found))
        unknown = stated and unit not in UNITS and not found and units is None
        if other or unknown:
            allowed = f"accelerations in {', '.join(UNITS)}"
            raise SceneError(f"{file}: line {line}", f"units of {unit}", allowed)
    if units is None and len(found) > 1:
        both = " and ".join(f"{unit} in line {line}" for unit, line in reversed(found.items()))
        raise SceneError(str(file), both, f"one unit, or {where}.units")
    if units is not None and found and units not in found:
        unit, line = next(iter(found.items()))
        allowed = f"{shown(unit)}, as line {line} of {file} says"
        raise SceneError(f"{where}.units", shown(units), allowed)
    return units or next(iter(found), None)


def refuse_milliseconds(file: Path, header: list[str]) -> None:
    """Refuse a column of times that the header gives in ms."""
    line = names_milliseconds(header)
    if line:
        raise SceneError(f"{file}: line {line}", "times in ms", "times in s")
