"""CSMIP V1 and V2 (California): headers, a line about the values, and the values."""

from __future__ import annotations

from collections.abc import Iterator

from solver.excitation.layouts.header import unit_of
from solver.excitation.layouts.text import NUMBER, Component, Stated, TextFile, width_of
from solver.scene.motion import FileSpec

TITLE = "CSMIP"

_BLOCK = (
    rf"^\s*(\d+)\s+(?:points of accel data equally spaced at\s+({NUMBER})\s*sec"
    rf"|Accelerogram points at\s+({NUMBER})\s*pts/sec)"
    r"\b.*?\bin\s+(?:units of\s+)?([^\s(]+?)[.,]?(?:\s.*?)?\(([^)]*)\)"
)
_RATE = rf"at\s+({NUMBER})\s*Samples/sec"
_INTERVAL = rf"equally-spaced intervals of\s+({NUMBER})\s*sec"


def recognised(text: TextFile) -> bool:
    """The title, and a line that announces values."""
    return (
        text.optional(r"corrected accelerogram", [1]) is not None
        and text.optional(_BLOCK) is not None
    )


def components(text: TextFile, spec: FileSpec) -> Iterator[Component]:
    """All channels; velocities and displacements are passed over."""
    begin = 1
    while block := text.optional(_BLOCK, range(begin, len(text.lines) + 1)):
        count = Stated(int(block.value[1]), block.line)
        interval, rate, unit, form = block.value.groups()[1:]
        step = float(interval) if interval else 1 / float(rate) if float(rate) > 0 else 0.0
        if step <= 0 or count.value < 2:
            raise text.error(block.line, block.value[0].strip(), "an interval above 0, 2 points")
        among = range(begin, block.line)
        for pattern, power in ((_INTERVAL, 1), (_RATE, -1)):
            other = text.optional(pattern, among)
            if other:
                text.agree(
                    Stated(step**power, block.line),
                    Stated(float(other.value[1]), other.line),
                    "interval",
                )
        channel = text.optional(r"\bChan\s+\d+:\s*(.*?)(?:\s{2,}|$)", reversed(among))
        values, lines = text.block(block.line, count, width=width_of(form))
        text.nothing_after(lines[-1], count, whole=False)
        yield Component(
            name=channel.value[1] if channel else "",
            values=values,
            lines=lines,
            units=(Stated(unit_of(unit), block.line),),
            steps=(Stated(step, block.line),),
        )
        begin = lines[-1] + 1
