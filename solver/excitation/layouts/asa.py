"""Mexico's standard file of acceleration, ASA 2.0 (UNAM, CIRES): a column for each channel."""

from __future__ import annotations

from collections.abc import Iterator

from solver.excitation.layouts.header import unit_of
from solver.excitation.layouts.text import Component, Stated, TextFile, number_in, width_of
from solver.scene.checking import shown
from solver.scene.motion import FileSpec

TITLE = "ASA 2.0 (Mexico)"

_SIGNATURE = r"^\s*ARCHIVO ESTANDAR DE ACELERACION"


def recognised(text: TextFile) -> bool:
    """The title of the format, in one of the first lines."""
    return text.optional(_SIGNATURE, range(1, min(len(text.lines), 20) + 1)) is not None


def components(text: TextFile, spec: FileSpec) -> Iterator[Component]:
    """All channels, named by their orientations."""
    title = text.required(r"^\s*DATOS DE ACELERACION", "DATOS DE ACELERACION")
    rules = [
        line
        for line in range(title.line + 1, min(title.line + 8, len(text.lines)) + 1)
        if text.lines[line - 1].startswith("---")
    ]
    if not rules:
        raise text.error(title.line, "no rule ---+---", "one above the values")
    among = range(1, title.line)
    counts = _each(text, r"NUM\. TOTAL DE MUESTRAS, C1", "NUM. TOTAL DE MUESTRAS", among)
    steps = _each(text, r"INTERVALO DE MUESTREO, C1", "INTERVALO DE MUESTREO", among)
    names = text.required(r"^ORIENTACION C1[^:]*:\s*/(.+)", "ORIENTACION C1-C6", among)
    orientations = [name.strip() for name in names.value[1].strip(" /").split("/")]
    said = text.optional(r"^NUMERO DE CANALES\s*:\s*(\d+)", among)
    channels = int(said.value[1]) if said else len(orientations)
    for what, line, found in (
        ("samples", counts[0].line, len(counts)),
        ("intervals", steps[0].line, len(steps)),
        ("orientations", names.line, len(orientations)),
    ):
        if found != channels:
            raise text.error(line, f"{what} of {found} channels", f"{channels} channels")
    if len({count.value for count in counts}) > 1 or counts[0].value != int(counts[0].value):
        got = f"samples {', '.join(f'{count.value:g}' for count in counts)}"
        raise text.error(counts[0].line, got, "as many of each channel")
    factor = text.optional(r"^FACTOR DE DECIMACION\s*:\s*(\S+)", among)
    if factor and number_in(factor.value[1]) != 1.0:
        raise text.error(factor.line, f"decimation by {factor.value[1]}", "1")
    units = text.required(r"^UNIDADES DE LOS DATOS\s*:\s*(\S+)", "UNIDADES DE LOS DATOS", among)
    unit = Stated(unit_of(units.value[1]), units.line)
    form = text.optional(r"^FORMATO DATOS[^:]*:\s*(\S+)", among)
    count = Stated(int(counts[0].value), counts[0].line)
    width = width_of(form.value[1]) if form else None
    values, lines = text.block(rules[-1], count, width=width, columns=channels)
    text.nothing_after(lines[-1], count)
    for i, (name, step) in enumerate(zip(orientations, steps, strict=True)):
        yield Component(name=name, values=values[:, i], lines=lines, units=(unit,), steps=(step,))


def _each(text: TextFile, key: str, what: str, among: range) -> list[Stated[float]]:
    """The positive numbers of the channels: /0.01/0.01/0.01."""
    found = text.required(rf"^{key}[^:]*:\s*/(.+)", what, among)
    numbers = [number_in(word.strip()) for word in found.value[1].strip(" /").split("/")]
    if not all(number is not None and 0 < number < 1e9 for number in numbers):
        raise text.error(found.line, shown(found.value[0]), f"{what}, above 0")
    return [Stated(number, found.line) for number in numbers if number is not None]
