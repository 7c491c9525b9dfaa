"""Quantities of a scene: the range of a number, magnitudes beyond all use, and how it scales."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeAlias, get_args, get_origin

from solver.errors import SceneError


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """The range of a number; never infinite, never NaN."""

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    least: float = 0.0
    """Smallest magnitude but zero; with less, and with more than `most`, nothing can be computed.
    They are far beyond anything that rocks: the limits of the method are in `limits`."""
    most: float = sys.float_info.max
    """Largest magnitude."""
    reason: str = ""
    """Unit, and the reason for `least` and `most`."""
    powers: tuple[float, float] = 0.0, 0.0
    """How it scales: powers of the scales of density and of length. Accelerations stay, so that
    times go with the square root of lengths."""

    def holds(self, value: Any) -> bool:
        """True if a number lies in the range."""
        return bool(
            abs(value) <= sys.float_info.max  # false for NaN and for integers beyond any float
            and (self.above is None or value > self.above)
            and (self.at_least is None or value >= self.at_least)
            and (self.below is None or value < self.below)
            and (self.at_most is None or value <= self.at_most)
        )

    def refuse_extreme(self, name: str, value: float) -> None:
        """Refuse a number with which nothing can be computed; 0 is a matter of the range.

        Raises:
            SceneError: With the reason.
        """
        if value != 0 and not self.least <= abs(value) <= self.most:
            large = abs(value) > self.most
            allowed = f"at most {self.most:g}" if large else f"at least {self.least:g}"
            raise SceneError(name, f"{value:g}", f"{allowed} ({self.reason})")

    def words(self, name: str) -> str:
        """The range in symbols, such as `0 <= poisson < 0.5`."""
        low, high = self.above, self.below
        left = f"{low:g} < " if low is not None else ""
        right = f" < {high:g}" if high is not None else ""
        if self.at_least is not None:
            left = f"{self.at_least:g} <= "
        if self.at_most is not None:
            right = f" <= {self.at_most:g}"
        if left and not right:
            return f"{name} {'>=' if '=' in left else '>'} {left.split()[0]}"
        return f"{left}{name}{right}" if left or right else "a finite number"


def number_of(hint: Any) -> Number | None:
    """The range in the type of a field, of a union the first; None: it is no number."""
    if get_origin(hint) is Annotated:
        return next((part for part in get_args(hint) if isinstance(part, Number)), None)
    return next(filter(None, map(number_of, get_args(hint))), None)


_TIME, _RATE, _LENGTH = (0.0, 0.5), (0.0, -0.5), (0.0, 1.0)
_MASS, _STRESS = (1.0, 3.0), (1.0, 1.0)
_DIGITS_OF_STEPS = "s, beyond which times lose the digits of steps"
_MASSES: dict[str, Any] = {
    **{"above": 0, "least": 1e-9, "most": 1e15},
    "reason": "beyond which weights lose their digits",
}

Finite = Annotated[float, Number()]
Positive = Annotated[float, Number(above=0)]
NotNegative = Annotated[float, Number(at_least=0)]
Ratio = Annotated[float, Number(at_least=0, below=0.5)]
"""Poisson's ratio."""
Tilt = Annotated[float, Number(above=-90, below=90)]
Turn = Annotated[float, Number(at_least=-360, at_most=360)]
DampingRatio = Annotated[float, Number(at_least=0, below=1)]
"""xi, of critical damping."""
Count = Annotated[int, Number(at_least=1)]
Factor = Annotated[float, Number(most=1e6, reason="times; look at the units")]

Length = Annotated[
    float,
    Number(
        above=0,
        least=1e-6,
        most=1e6,
        reason="m, whose fifth powers are moments of inertia",
        powers=_LENGTH,
    ),
]
Place = Annotated[
    float,
    Number(most=1e6, reason="m, beyond which places lose the digits of gaps", powers=_LENGTH),
]
Mass = Annotated[float, Number(**_MASSES, powers=_MASS)]
AddedMass = Annotated[float, Number(at_least=0, powers=_MASS)]
Density = Annotated[float, Number(**_MASSES, powers=(1, 0))]
Duration = Annotated[
    float, Number(above=0, least=1e-9, most=1e9, reason=_DIGITS_OF_STEPS, powers=_TIME)
]
Instant = Annotated[float, Number(at_least=0, most=1e9, reason=_DIGITS_OF_STEPS, powers=_TIME)]
Delay = Annotated[float, Number(at_least=0, powers=_TIME)]
Rate = Annotated[float, Number(at_least=0, powers=_RATE)]
"""1/s, and also s/m: velocities go with the square root of lengths as times do."""
Frequency = Annotated[
    float,
    Number(above=0, least=1e-6, most=1e6, reason="1/s; steps have to see its period", powers=_RATE),
]
Modulus = Annotated[
    float,
    Number(
        above=0,
        least=1e-3,
        most=1e20,
        reason="Pa; the stiffest material has 1e12",
        powers=_STRESS,
    ),
]
Cohesion = Annotated[float, Number(at_least=0, powers=_STRESS)]
Spring = Annotated[float, Number(above=0, powers=(1, 2))]
Bedding = Annotated[float, Number(above=0, powers=(1, 0))]
Amplitude = Annotated[float, Number(most=1e4, reason="g; the strongest records have 4")]
Gravity = Annotated[float, Number(at_least=0, most=1e6, reason="m/s2; that of the earth is 9.81")]

Speed = Annotated[float, Number(powers=_TIME)]
Spin = Annotated[float, Number(powers=_RATE)]
Vector: TypeAlias = tuple[Speed, Speed] | tuple[Speed, Speed, Speed]
Rotation: TypeAlias = Spin | tuple[Spin, Spin, Spin]
"""A rotation or its rate; in the plane one number."""
Dimension: TypeAlias = Literal[2, 3]
Cells: TypeAlias = tuple[Count, Count] | tuple[Count, Count, Count]
"""Along width and height; in 3-D along width, thickness and height."""
Cell: TypeAlias = Literal["quadrilateral", "triangle", "hexahedron", "tetrahedron"]
