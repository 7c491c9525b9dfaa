"""Numbers with which nothing can be computed, refused with the reason wherever a key has them.

They are far beyond anything that rocks; the limits of the method itself are in `limits`.
"""

from __future__ import annotations

from dataclasses import dataclass

from solver.errors import SceneError


@dataclass(frozen=True, slots=True)
class Extremes:
    """The magnitudes that a key may have, and why no others."""

    least: float
    most: float
    reason: str


_LENGTHS = Extremes(1e-6, 1e6, "m, whose fifth powers are moments of inertia")
_PLACES = Extremes(0.0, 1e6, "m, beyond which places lose the digits of gaps")
_MASSES = Extremes(1e-9, 1e15, "beyond which weights lose their digits")
_TIMES = Extremes(1e-9, 1e9, "s, beyond which times lose the digits of steps")

EXTREMES = {
    **dict.fromkeys(("width", "height", "thickness", "storey"), _LENGTHS),
    **dict.fromkeys(("offset", "offset_second"), _PLACES),
    **dict.fromkeys(("mass", "density"), _MASSES),
    **dict.fromkeys(("end", "step", "largest", "period", "duration", "dt", "every"), _TIMES),
    "start": Extremes(0.0, 1e9, _TIMES.reason),
    "young": Extremes(1e-3, 1e20, "Pa; the stiffest material has 1e12"),
    "frequency": Extremes(1e-6, 1e6, "1/s; steps have to see its period"),
    "amplitude_g": Extremes(0.0, 1e4, "g; the strongest records have 4"),
    "scale": Extremes(0.0, 1e6, "times; look at the units"),
    "gravity": Extremes(0.0, 1e6, "m/s2; that of the earth is 9.81"),
}
"""By the name of a field, in whatever table it stands."""


def refuse_extreme(name: str, value: object) -> None:
    """Refuse a number beyond the extremes of its key; 0 is a matter of its range."""
    extremes = EXTREMES.get(name)
    if extremes is None or isinstance(value, bool) or not isinstance(value, int | float):
        return
    least, most = extremes.least, extremes.most
    if value == 0 or least <= abs(value) <= most:
        return
    allowed = f"at most {most:g}" if abs(value) > most else f"at least {least:g}"
    raise SceneError(name, f"{value:g}", f"{allowed} ({extremes.reason})")
