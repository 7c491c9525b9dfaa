"""COSMOS V1 and V2 (Format v01.20): headers of text, integers and reals, then the values."""

from __future__ import annotations

from collections.abc import Iterator

from solver.excitation.layouts.header import unit_of
from solver.excitation.layouts.text import Component, Stated, TextFile, width_of
from solver.scene.checking import shown
from solver.scene.motion import FileSpec

TITLE = "COSMOS"

CODES = {2: "g", 4: "cm/s2", 7: "in/s2", 10: "cm/s2", 11: "mg", 50: "counts"}
"""Codes of physical units, table 2 of the format."""

INTERVAL, LENGTH = 61, 62
"""Places among the reals of the time between samples (ms) and of the length (s), from 0."""

UNKNOWN = -999.0

_BLOCK = (
    r"^\s*(\d+)\s+acceleration pts,.*units\s*=\s*([^,(]+?)\s*(?:\(\s*(\d+)\s*\))?\s*,"
    r"\s*Format\s*=\s*\(?([^)]*)"
)
_REALS = r"^\s*(\d+)\s+Real-header values.*Format\s*=\s*\(([^)]*)"
_CHANNEL = r"^\s*Sta Cha\w*\s*:?\s*(.*?)\s*(?:\(Rcrdr|Location|$)"


def recognised(text: TextFile) -> bool:
    """The number of the format, in the first line."""
    return text.optional(r"acceleration.*\(Format v", [1]) is not None


def components(text: TextFile, spec: FileSpec) -> Iterator[Component]:
    """All blocks of accelerations; those of velocities and displacements are passed over."""
    begin = 1
    while block := text.optional(_BLOCK, range(begin, len(text.lines) + 1)):
        count = Stated(int(block.value[1]), block.line)
        values, lines = text.block(block.line, count, width=width_of(block.value[4]))
        text.nothing_after(lines[-1], count, whole=False)
        among = range(begin, block.line)
        channel = text.optional(_CHANNEL, reversed(among))
        yield Component(
            name=" ".join(channel.value[1].split()) if channel else "",
            values=values,
            lines=lines,
            units=(_unit(text, block.value[2], block.value[3], block.line),),
            steps=_step(text, among, count),
        )
        begin = lines[-1] + 1
    if begin == 1:
        raise text.error(
            1, "no line `acceleration pts, ... units=..., Format=...`", "accelerations"
        )


def _unit(text: TextFile, name: str, code: str | None, line: int) -> Stated[str]:
    """The unit, by its name and its code, which have to be the same."""
    unit = unit_of(name)
    by_code = CODES.get(int(code)) if code else unit
    if by_code != unit:
        raise text.error(line, f"units of {name} with code {code}", f"{shown(by_code)} by the code")
    return Stated(unit, line)


def _step(text: TextFile, among: range, count: Stated[int]) -> tuple[Stated[float], ...]:
    """The time between samples, from the reals; none where they do not know it."""
    head = text.required(_REALS, "Real-header values follow on ... lines", reversed(among))
    reals, lines = text.block(
        head.line, Stated(int(head.value[1]), head.line), width=width_of(head.value[2])
    )
    if len(reals) <= LENGTH or reals[INTERVAL] == UNKNOWN:
        return ()
    step, length = float(reals[INTERVAL]) / 1000, float(reals[LENGTH])
    if step <= 0:
        raise text.error(lines[INTERVAL], f"{step * 1000:g} ms between samples", "more than 0")
    if length != UNKNOWN and abs(length / step - count.value) > 1.5:
        got = f"{length:g} s of samples {step:g} s apart"
        raise text.error(lines[LENGTH], got, f"{count.value} samples as in line {count.line}")
    return (Stated(step, lines[INTERVAL]),)
