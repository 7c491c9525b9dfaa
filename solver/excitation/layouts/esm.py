"""ESM, ITACA and AFAD's TADAS: a header of KEY: VALUE (DYNA 1.2), then one value to a line."""

from __future__ import annotations

from solver.excitation.layouts.header import unit_of
from solver.excitation.layouts.text import NUMBER, Component, Stated, TextFile
from solver.scene.checking import shown
from solver.scene.motion import FileSpec

TITLE = "ESM, ITACA (DYNA)"

_STEP = rf"^SAMPLING_INTERVAL_S:\s*({NUMBER})"


def recognised(text: TextFile) -> bool:
    """The first key, and that of the sampling interval."""
    return text.lines[0].startswith("EVENT_NAME:") and text.optional(_STEP) is not None


def components(text: TextFile, spec: FileSpec) -> list[Component]:
    """The one component of the file, with the unit of UNITS."""
    last = max(line for line, content in enumerate(text.lines, start=1) if _key(content))
    among = range(1, last + 1)
    kind = text.optional(r"^DATA_TYPE:\s*(\S+)", among)
    if kind and kind.value[1].upper() != "ACCELERATION":
        raise text.error(kind.line, f"data of {shown(kind.value[1])}", "ACCELERATION")
    count = text.count(r"^NDATA:\s*(\d+)", "NDATA: number of values", among)
    step = text.positive(_STEP, "SAMPLING_INTERVAL_S", among)
    duration = text.optional(rf"^DURATION_S:\s*({NUMBER})", among)
    if duration and abs(float(duration.value[1]) / step.value - count.value) > 1.5:
        got = f"{duration.value[1]} s of {count.value} values {step.value:g} s apart"
        raise text.error(duration.line, got, f"{count.value * step.value:g} s")
    units = text.required(r"^UNITS:\s*(\S+)", "UNITS: of the values", among)
    unit = Stated(unit_of(units.value[1]), units.line)
    stream = text.optional(r"^STREAM:\s*(\S+)", among)
    values, lines = text.block(last, count, columns=1)
    text.nothing_after(lines[-1], count)
    if unit.value == "cm/s2":
        text.similar(text.optional(rf"^PGA_CM/S\^2:\s*({NUMBER})", among), values)
    name = stream.value[1] if stream else ""
    return [Component(name=name, values=values[:, 0], lines=lines, units=(unit,), steps=(step,))]


def _key(line: str) -> bool:
    """True if a line is one of the header."""
    return line.partition(":")[0].replace("_", "").replace("/", "").replace("^", "").isalnum() and (
        ":" in line
    )
