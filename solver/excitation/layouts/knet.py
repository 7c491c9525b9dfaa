"""K-NET and KiK-net (NIED, Japan): counts of a digitizer and their scale in gal."""

from __future__ import annotations

from solver.excitation.layouts.text import NUMBER, Component, Stated, TextFile
from solver.scene.motion import FileSpec

TITLE = "K-NET, KiK-net"

_SCALE = rf"^Scale Factor\s+({NUMBER})\s*\(gal\)\s*/\s*({NUMBER})"


def recognised(text: TextFile) -> bool:
    """The line of the scale."""
    return text.optional(_SCALE, _header(text)) is not None


def components(text: TextFile, spec: FileSpec) -> list[Component]:
    """Counts times the scale, less their mean: they stand around the offset of the digitizer."""
    among = _header(text)
    scale = text.required(_SCALE, "Scale Factor a(gal)/b", among)
    a, b = (float(scale.value[i]) for i in (1, 2))
    if a <= 0 or b <= 0:
        raise text.error(scale.line, scale.value[0], "Scale Factor a(gal)/b, a and b above 0")
    memo = text.optional(r"^Memo\.", among)
    last = memo.line if memo else scale.line
    rate, direction = (
        text.optional(r"^Sampling Freq\(Hz\)", among),
        text.optional(r"^Dir\.\s+(\S+)", among),
    )
    steps: tuple[Stated[float], ...] = ()
    if rate:
        hertz = text.positive(
            rf"^Sampling Freq\(Hz\)\s+({NUMBER})\s*Hz", "Sampling Freq(Hz)", among
        )
        steps = (Stated(1 / hertz.value, hertz.line),)
    if steps:
        duration = text.positive(rf"^Duration Time\(s\)\s+({NUMBER})", "Duration Time(s)", among)
        count = Stated(round(duration.value / steps[0].value), duration.line)
    else:  # only a part of a header
        rows = [len(text.row(line)) for line in range(last + 1, len(text.lines) + 1)]
        count = Stated(sum(rows), last)
    if count.value < 2:
        raise text.error(count.line, f"{count.value} samples", "2 or more")
    counts, lines = text.block(last, count)
    text.nothing_after(lines[-1], count)
    factor = a / b
    mean = float(counts.mean())
    text.similar(
        text.optional(rf"^Max\. Acc\. \(gal\)\s+({NUMBER})", among), (counts - mean) * factor
    )
    return [
        Component(
            name=direction.value[1] if direction else "",
            values=(counts - mean) * factor,
            lines=lines,
            units=(Stated("cm/s2", scale.line),),
            steps=steps,
            notes=(f"counts times {a:g}/{b:.12g}", f"mean of {mean * factor:.4g} cm/s2 removed"),
        )
    ]


def _header(text: TextFile) -> range:
    """The numbers of the lines that may belong to the header."""
    return range(1, min(len(text.lines), 25) + 1)
