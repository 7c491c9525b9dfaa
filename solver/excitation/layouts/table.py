"""The table of layouts, and the reader of a file with a recorded motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import ModuleType

from solver.errors import SceneError, missing_key
from solver.excitation.layouts import (
    afad,
    asa,
    columns,
    cosmos,
    csmip,
    esm,
    geonet,
    knet,
    peer,
    seismic,
    usc,
)
from solver.excitation.layouts.header import OTHERS, mentions_units, units_hinted
from solver.excitation.layouts.text import (
    CLOSE,
    Component,
    Stated,
    TextFile,
    is_binary,
    read_lines,
    split_header,
)
from solver.scene.checking import shown
from solver.scene.motion import UNITS, FileSpec
from solver.types import Array

LAYOUTS: dict[str, ModuleType] = {
    "knet": knet,
    "esm": esm,
    "afad": afad,
    "asa": asa,
    "cosmos": cosmos,
    "csmip": csmip,
    "usc": usc,
    "geonet": geonet,
    "peer": peer,
    "columns": columns,
}
"""The layouts of text by their names, in the order in which a file is held against them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Accelerogram:
    """The chosen component of a file."""

    values: Array
    """As they stand in the file, counts apart, (n,)."""
    lines: list[int]
    """The number of the line of each, or of the sample where there are no lines."""
    unit: float
    """Their unit, m/s^2."""
    step: float | None
    """The time between samples, s; None: not the same for all."""
    time: Array | None
    """Their times as the file has them, s."""
    source: str
    """The source of each number, in words."""


def read_motion(spec: FileSpec, where: str) -> Accelerogram:
    """The accelerogram of a file, read by the layout that recognises it or that the scene names.

    `where` is the path of the table in the scene, for errors.

    Raises:
        SceneError: The file cannot be read, does not say all that is needed, or contradicts the
            scene or itself; names file and line.
    """
    text = None
    if spec.format == "obspy" or (spec.format is None and is_binary(spec.file)):
        title, read = seismic.TITLE, seismic.components(spec.file)
    else:
        text = TextFile(spec.file, read_lines(spec.file, f"{where}.file", columns.EXPECTED))
        layout = LAYOUTS[_format(spec, where, text)]
        title, read = layout.TITLE, layout.components(text, spec)
    found = [replace(each, number=each.number or k) for k, each in enumerate(read, start=1)]
    chosen = _chosen(spec, where, found, text)
    unit, unit_at = _unit(spec, where, chosen, text)
    step, step_at = _step(spec, where, chosen)
    parts = [f"{len(chosen.values)} samples"]
    if step is not None:
        parts.append(f"{step:.6g} s apart ({step_at})")
    if chosen.name or len(found) > 1:
        parts.append(f"component {chosen.name or f'in column {chosen.number}'}")
    parts += [*chosen.notes, f"in {unit} ({unit_at})"]
    if spec.scale != 1.0:
        parts.append(f"times {spec.scale:g} (scale)")
    return Accelerogram(
        values=chosen.values,
        lines=chosen.lines,
        unit=UNITS[unit],
        step=step,
        time=chosen.time,
        source=f"{title}: {', '.join(parts)}",
    )


def _format(spec: FileSpec, where: str, text: TextFile) -> str:
    """The name of the layout; plain columns may be chosen where a header looks like PEER's."""
    known = next(name for name, layout in LAYOUTS.items() if layout.recognised(text))
    if spec.format in (None, known) or known == "columns":
        return spec.format or known
    if (known, spec.format) == ("peer", "columns"):
        return "columns"
    raise SceneError(f"{where}.format", shown(spec.format), f'"{known}", which {text.path} is')


def _chosen(spec: FileSpec, where: str, found: list[Component], text: TextFile | None) -> Component:
    """The component that the scene names, or the only one."""
    wanted = spec.column
    if wanted is None and len(found) == 1:
        return found[0]
    many = ", ".join(each.name or str(each.number) for each in found)
    if wanted is None:
        place = f"{spec.file}: line {found[0].lines[0]}" if text else str(spec.file)
        noun = "columns" if found[0].time is None else "columns beside that of time"
        named = all(each.name for each in found)
        got = f"{len(found)} {noun} ({many})" if named else f"{len(found)} {noun}"
        numbers = f"{found[0].number} to {found[-1].number}"
        allowed = f"one accelerogram: {where}.column, {numbers}{' or a name' if named else ''}"
        if text and found[0].time is None and not named and len(found) > 3:
            allowed += "; values in reading order go one to a line"
        raise SceneError(place, got, allowed)
    same = [
        each
        for each in found
        if each.number == wanted
        or (isinstance(wanted, str) and each.name.casefold() == wanted.strip().casefold())
    ]
    if len(same) != 1:
        numbers = ", ".join(str(each.number) for each in found)
        names = f" or {many}" if any(each.name for each in found) else ""
        raise SceneError(f"{where}.column", shown(wanted), f"{numbers}{names}, of {spec.file}")
    return same[0]


def _unit(spec: FileSpec, where: str, chosen: Component, text: TextFile | None) -> tuple[str, str]:
    """The unit of the samples, from scene or header, and its place there."""
    stated: dict[str, int] = {}
    for said in chosen.units:
        if said.value in UNITS:
            stated.setdefault(said.value, said.line)
    for said in chosen.units:
        unknown = said.value not in UNITS and not stated and spec.units is None
        if said.value in OTHERS or unknown:
            allowed = f"accelerations in {', '.join(UNITS)}"
            raise SceneError(f"{spec.file}: line {said.line}", f"units of {said.value}", allowed)
    header = split_header(text.lines)[0] if text else []
    if spec.units is not None:
        held = stated or {said.value: said.line for said in units_hinted(header)}
        if held and spec.units not in held:
            unit, line = next(iter(held.items()))
            allowed = f"{shown(unit)}, as line {line} of {spec.file} says"
            raise SceneError(f"{where}.units", shown(spec.units), allowed)
        return spec.units, f"{where}.units"
    if len(stated) > 1:
        both = " and ".join(f"{unit} in line {line}" for unit, line in stated.items())
        raise SceneError(str(spec.file), both, f"one unit, or {where}.units")
    if stated:
        unit, line = next(iter(stated.items()))
        return unit, f"line {line}"
    if spec.kind == "record" or mentions_units(header):
        reason = f'("g", "m/s2", "cm/s2", ...): {spec.file} does not say it'
        raise missing_key(f"{where}.units", reason)
    return "g", "default of tables"


def _step(spec: FileSpec, where: str, chosen: Component) -> tuple[float | None, str]:
    """The time between samples, s, and its place; None: they are not equally far apart."""
    asked = spec.dt if spec.kind == "record" else None
    if chosen.time is not None and chosen.even is None:
        if spec.kind == "record":
            allowed = 'samples equally far apart, or kind = "table"'
            raise SceneError(str(spec.file), "samples at uneven times", allowed)
        return None, ""
    own = [Stated(chosen.even, 0)] if chosen.even is not None else []
    for one in chosen.steps:
        reference = own[0] if own else chosen.steps[0]
        if not _close(one.value, reference.value) and (own or asked is None):
            got = f"{one.value:g} s between samples"
            allowed = f"{reference.value:g} s as in {_place(reference)}"
            raise SceneError(f"{spec.file}: line {one.line}", got, allowed)
    said = own or list(chosen.steps)
    if asked is not None:
        same = [each for each in said if _close(asked, each.value)]
        if said and not same:
            allowed = f"{said[0].value:g}, as {_place(said[0])} of {spec.file} says"
            raise SceneError(f"{where}.dt", f"{asked:g}", allowed)
        said = same or [Stated(asked, -1)]
    if not said:
        reason = f"(dt > 0, s): {spec.file} does not say the time between its values"
        raise missing_key(f"{where}.dt", reason)
    place = _place(said[0]) if said[0].line >= 0 else f"{where}.dt"
    return said[0].value, place


def _place(said: Stated[float]) -> str:
    """Place of an interval in the file, in words."""
    return f"line {said.line}" if said.line else "its times"


def _close(one: float, other: float) -> bool:
    """True if two printed intervals are the same."""
    return math.isclose(one, other, rel_tol=CLOSE)
