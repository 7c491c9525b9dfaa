"""Quantities of a scene: the range of a number, magnitudes beyond all use, and how it scales."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias, get_args, get_origin

from solver.errors import SceneError


class Extremes(NamedTuple):
    """Magnitudes of a quantity, but 0, far beyond anything that rocks."""

    least: float
    most: float
    reason: str
    """The unit, and the reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """The range of a number; never infinite, never NaN."""

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    extremes: Extremes | None = None
    """Magnitudes beyond which nothing can be computed."""
    powers: tuple[float, float] = 0.0, 0.0
    """Scaling: powers of the scales of density and of length. Accelerations stay, so that
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
        beyond = self.extremes
        if beyond is None or value == 0 or beyond.least <= abs(value) <= beyond.most:
            return
        large = abs(value) > beyond.most
        allowed = f"at most {beyond.most:g}" if large else f"at least {beyond.least:g}"
        raise SceneError(name, f"{value:g}", f"{allowed} ({beyond.reason})")

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
_MASS, _STRESS, _MOMENT = (1.0, 3.0), (1.0, 1.0), (1.0, 5.0)

_SIZES = Extremes(1e-6, 1e6, "m, whose fifth powers are moments of inertia")
_PLACES = Extremes(0.0, 1e6, "m, beyond which places lose the digits of gaps")
_WEIGHTS = Extremes(1e-9, 1e15, "beyond which weights lose their digits")
_TURNS = Extremes(1e-24, 1e30, "kg m2, beyond which moments of inertia lose their digits")
_FORCES = Extremes(0.0, 1e15, "beyond which forces lose their digits")
_STEPS = Extremes(1e-9, 1e9, "s, beyond which times lose the digits of steps")
_INSTANTS = Extremes(0.0, _STEPS.most, _STEPS.reason)
_RATES = Extremes(1e-6, 1e6, "1/s; steps have to see its period")
_MODULI = Extremes(1e-3, 1e20, "Pa; the stiffest material has 1e12")
_AMPLITUDES = Extremes(0.0, 1e4, "g; the strongest records have 4")
_FACTORS = Extremes(0.0, 1e6, "times; look at the units")
_GRAVITIES = Extremes(0.0, 1e6, "m/s2; that of the earth is 9.81")

Positive = Annotated[float, Number(above=0)]
NotNegative = Annotated[float, Number(at_least=0)]
Ratio = Annotated[float, Number(at_least=0, below=0.5)]
"""Poisson's ratio."""
Tilt = Annotated[float, Number(above=-90, below=90)]
Turn = Annotated[float, Number(at_least=-360, at_most=360)]
DampingRatio = Annotated[float, Number(at_least=0, below=1)]
"""xi, of critical damping."""
Count = Annotated[int, Number(at_least=1)]
Factor = Annotated[float, Number(extremes=_FACTORS)]
Amplitude = Annotated[float, Number(extremes=_AMPLITUDES)]
Gravity = Annotated[float, Number(at_least=0, extremes=_GRAVITIES)]

Length = Annotated[float, Number(above=0, extremes=_SIZES, powers=_LENGTH)]
NotNegativeLength = Annotated[float, Number(at_least=0, extremes=_PLACES, powers=_LENGTH)]
Place = Annotated[float, Number(extremes=_PLACES, powers=_LENGTH)]
Mass = Annotated[float, Number(above=0, extremes=_WEIGHTS, powers=_MASS)]
AddedMass = Annotated[float, Number(at_least=0, powers=_MASS)]
Moment = Annotated[float, Number(above=0, extremes=_TURNS, powers=_MOMENT)]
"""Of inertia, kg m2."""
Product = Annotated[float, Number(powers=_MOMENT)]
"""Of inertia, kg m2."""
Density = Annotated[float, Number(above=0, extremes=_WEIGHTS, powers=(1.0, 0.0))]
Duration = Annotated[float, Number(above=0, extremes=_STEPS, powers=_TIME)]
Instant = Annotated[float, Number(at_least=0, extremes=_INSTANTS, powers=_TIME)]
Delay = Annotated[float, Number(at_least=0, powers=_TIME)]
Rate = Annotated[float, Number(at_least=0, powers=_RATE)]
"""1/s, and also s/m: velocities go with the square root of lengths as times do."""
Frequency = Annotated[float, Number(above=0, extremes=_RATES, powers=_RATE)]
Modulus = Annotated[float, Number(above=0, extremes=_MODULI, powers=_STRESS)]
Cohesion = Annotated[float, Number(at_least=0, powers=_STRESS)]
Spring = Annotated[float, Number(above=0, powers=(1.0, 2.0))]
Bedding = Annotated[float, Number(above=0, powers=(1.0, 0.0))]
Gap = Annotated[float, Number(at_least=0, extremes=_PLACES, powers=_LENGTH)]
Dashpot = Annotated[float, Number(at_least=0, extremes=_FORCES, powers=(1.0, 2.5))]
"""N s/m."""
Push = Annotated[float, Number(extremes=_FORCES, powers=_MASS)]
"""A component of a force, N: accelerations stay, so that forces go as masses do."""
Preload = Annotated[float, Number(at_least=0, extremes=_FORCES, powers=_MASS)]
Strength = Annotated[float, Number(above=0, extremes=_FORCES, powers=_MASS)]
Pressure = Annotated[float, Number(extremes=_FORCES, powers=_STRESS)]

Speed = Annotated[float, Number(powers=_TIME)]
Spin = Annotated[float, Number(powers=_RATE)]
Position: TypeAlias = tuple[Place, Place] | tuple[Place, Place, Place]
Vector: TypeAlias = tuple[Speed, Speed] | tuple[Speed, Speed, Speed]
Forces: TypeAlias = tuple[Push, Push] | tuple[Push, Push, Push]
Course: TypeAlias = tuple[tuple[Instant, Factor], ...]
"""Instants and factors there."""
Rotation: TypeAlias = Spin | tuple[Spin, Spin, Spin]
"""A rotation or its rate; in the plane one number."""
Row: TypeAlias = tuple[Product, Product, Product]
Inertia: TypeAlias = Moment | tuple[Moment, Moment, Moment] | tuple[Row, Row, Row]
"""In the plane one number, in space three moments or a table."""
Dimension: TypeAlias = Literal[2, 3]
Cells: TypeAlias = tuple[Count, Count] | tuple[Count, Count, Count]
"""Along width and height; in 3-D along width, thickness and height."""
Cell: TypeAlias = Literal["quadrilateral", "triangle", "hexahedron", "tetrahedron"]
