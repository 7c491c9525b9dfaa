"""Motions of the ground, as a scene describes them.

A new kind is a class here, its name in `MotionSpec`, and a function in `solver.excitation.kinds`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

from solver.errors import SceneError, not_applicable
from solver.scene.checking import OPEN, Checked, exactly_one, is_open, shown
from solver.scene.quantities import (
    Amplitude,
    Count,
    Duration,
    Factor,
    Frequency,
    Instant,
    NotNegative,
    Number,
    Positive,
)

G_UNIT = 9.81
"""The unit "g" in amplitudes, records and tables, m/s^2, whatever the gravity of the scene is."""

UNITS = {
    "g": G_UNIT,
    "m/s2": 1.0,
    "cm/s2": 0.01,
    "mm/s2": 0.001,
    "mg": 0.001 * G_UNIT,
    "g/10": 0.1 * G_UNIT,
    "ft/s2": 0.3048,
    "in/s2": 0.0254,
}
"""Units of accelerations, m/s^2."""

SHORTEST_PERIOD_OF_RECORDS = 0.1
"""Period below which the ground's motion in earthquakes hardly moves a block, s."""

COMPONENTS = {"second": 2, "vertical": 3}
"""Components of synthetic motions beside that along x, which is the first."""

Units: TypeAlias = Literal["g", "m/s2", "cm/s2", "mm/s2", "mg", "g/10", "ft/s2", "in/s2"]
"""Units of accelerations in files."""

Format: TypeAlias = Literal[
    "peer", "cosmos", "csmip", "usc", "knet", "esm", "geonet", "afad", "asa", "columns", "obspy"
]
"""Layouts of files: the table in `solver.excitation.layouts.table`, and what obspy reads."""

Shaped = TypeVar("Shaped", bound="Motion")


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion(Checked):
    """Base of the kinds: the motions that one along x may have beside it.

    The motions beside it have nothing more.
    """

    vertical: MotionSpec | None = None
    """`[motion.vertical]`: the motion along the vertical, positive upwards. Default: -."""
    second: MotionSpec | None = None
    """`[motion.second]`: the motion along y; 3-D only. Default: -."""

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """Synthetic motions beside that along x, with components of their own."""
        for direction, motion in self.beside():
            if isinstance(motion, SyntheticSpec) and is_open(motion.component):
                yield direction, replace(motion, component=COMPONENTS[direction])

    def check(self) -> None:
        """Refuse motions beside those beside that along x."""
        for direction, motion in self.beside():
            for below, _ in motion.beside():
                raise not_applicable(f"{direction}.{below}", "[motion] itself only")

    @property
    def shortest_period(self) -> float:
        """Period of the fastest part of the motion that moves blocks, s; infinite without one."""
        return SHORTEST_PERIOD_OF_RECORDS

    def times(self: Shaped, factor: float) -> Shaped:
        """The motion in all directions times a factor."""
        sizes = (key for key in ("scale", "amplitude_g") if hasattr(self, key))
        changed: dict[str, Any] = {key: factor * getattr(self, key) for key in sizes}
        changed |= {direction: motion.times(factor) for direction, motion in self.beside()}
        return replace(self, **changed)

    def beside(self) -> Iterator[tuple[str, MotionSpec]]:
        """The motions in the other directions, with their keys."""
        if self.vertical is not None:
            yield "vertical", self.vertical
        if self.second is not None:
            yield "second", self.second


@dataclass(frozen=True, slots=True, kw_only=True)
class StillSpec(Motion):
    """No motion along x, for `[motion.vertical]` or `[motion.second]` alone: kind = "none"."""

    kind: Literal["none"] = "none"
    """Shape of the acceleration; left out where nothing moves along x."""

    @property
    def shortest_period(self) -> float:
        """No motion has no period."""
        return math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class SineSpec(Motion):
    """A sine of the ground's acceleration: `[motion]` with kind = "sine"."""

    kind: Literal["sine"] = "sine"
    amplitude_g: Amplitude
    """A, g."""
    period: Duration
    """T, s."""
    cycles: Positive | None = None
    """Number of periods. Default: to the end of the run."""
    start: Instant = 0.0
    """Time at which the motion begins, s."""

    @property
    def shortest_period(self) -> float:
        """The period, s."""
        return self.period


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pulse(Motion):
    """A motion that is over after a while."""

    amplitude_g: Amplitude
    """A, g."""
    duration: Duration
    """Duration, s."""
    start: Instant = 0.0
    """Time at which the motion begins, s."""

    @property
    def shortest_period(self) -> float:
        """The duration, s."""
        return self.duration


@dataclass(frozen=True, slots=True, kw_only=True)
class HalfSineSpec(_Pulse):
    """Half a period of a sine, of this duration: kind = "half_sine"."""

    kind: Literal["half_sine"] = "half_sine"


@dataclass(frozen=True, slots=True, kw_only=True)
class OneSineSpec(_Pulse):
    """One period of a sine, of this duration: kind = "one_sine"."""

    kind: Literal["one_sine"] = "one_sine"


@dataclass(frozen=True, slots=True, kw_only=True)
class RectangularSpec(_Pulse):
    """A constant acceleration for a while: kind = "rectangular"."""

    kind: Literal["rectangular"] = "rectangular"


@dataclass(frozen=True, slots=True, kw_only=True)
class RickerSpec(Motion):
    """A Ricker wavelet, its largest acceleration in the middle: kind = "ricker"."""

    kind: Literal["ricker"] = "ricker"
    amplitude_g: Amplitude
    """A, the acceleration in the middle, g; before and after it the ground is pushed the other way,
    by 0.446 A."""
    duration: Duration | None = None
    """3/f, s. Default: this or `frequency`."""
    frequency: Frequency | None = None
    """f, where the spectrum is highest, 1/s. Default: this or `duration`."""
    start: Instant = 0.0
    """Time at which the motion begins, s."""

    def check(self) -> None:
        """Refuse values that do not go together."""
        Motion.check(self)
        exactly_one(self, "duration", "frequency")

    @property
    def shortest_period(self) -> float:
        """1/f, s."""
        if self.frequency is not None:
            return 1 / self.frequency
        assert self.duration is not None  # one of the two is given
        return self.duration / 3


@dataclass(frozen=True, slots=True, kw_only=True)
class _FromFile(Motion):
    """Base of the kinds whose accelerations stand in a file."""

    file: Path
    """Relative to the folder of the scene."""
    format: Format | None = None
    """The layout of the file; no other than that which its header shows. Default: recognised."""
    column: Annotated[int, Number(at_least=1)] | str | None = None
    """Which of several accelerograms: its number, of columns that in the file (one of times is
    counted, too), or its name. Default: the only one."""
    units: Units | None = None
    """Unit of the accelerations; no other than that of the header. Default: from the header, if it
    states one; `kind = "table"`: `"g"` if there is none at all."""
    scale: Factor = 1.0
    """Factor on the accelerations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TableSpec(_FromFile):
    """The ground's acceleration at any times, from a file: `[motion]` with kind = "table"."""

    kind: Literal["table"] = "table"


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordSpec(_FromFile):
    """A recorded accelerogram, samples at equal distances: `[motion]` with kind = "record"."""

    kind: Literal["record"] = "record"
    dt: Duration | None = None
    """Time between samples, s; no other than that of the file. Default: from the file."""
    window: tuple[NotNegative, Positive] | None = None
    """First and last time of the part that is used, s from the first sample; the samples between
    them, both included. Default: all of it."""
    baseline: Literal["none", "constant", "linear", "quadratic"] = "none"
    """Polynomial of time taken off the accelerations that are used, so that the mean square of the
    velocity becomes least: after Berg and Housner (1961), who took off a parabola."""
    start: Instant = 0.0
    """Time at which the first sample that is used comes, s."""
    trust: bool = False
    """Accept a sample more than 20 times as large as both beside it, and at least half as
    large as the largest: most often it has lost its decimal point."""

    def check(self) -> None:
        """Refuse values that do not go together."""
        Motion.check(self)
        if self.window is not None and self.window[0] >= self.window[1]:
            raise SceneError("window", shown(self.window), "a first time before the last one")


@dataclass(frozen=True, slots=True, kw_only=True)
class SyntheticSpec(Motion):
    """A motion simulated for an earthquake and a site: `[motion]` with kind = "synthetic"."""

    kind: Literal["synthetic"] = "synthetic"
    seed: Annotated[int, Number(at_least=0)] = 1
    """One seed stands for one earthquake and one site."""
    component: Count = OPEN
    """Which of the directions of that earthquake at that site: the same amplitudes, other noise.
    Default: 1; `[motion.second]` 2, `[motion.vertical]` 3, lest they repeat the first one."""
    magnitude: Annotated[float, Number(at_least=4, at_most=8)] = 6.7
    """Moment magnitude M."""
    distance_km: Annotated[float, Number(at_least=0, at_most=200)] = 25.0
    """Joyner and Boore's distance R_JB, from the site to the surface projection of the rupture,
    km."""
    vs30: Annotated[float, Number(at_least=150, at_most=1500)] = 400.0
    """Mean velocity of shear waves in the upper 30 m, m/s."""
    event_sigma: NotNegative = 0.0
    """Standard deviation, between earthquakes, of the logarithm of the amplitude; 0 is the average
    earthquake, 0.3 is realistic."""
    site_sigma: NotNegative = 0.0
    """Standard deviation of that logarithm between sites; 0 is the average site, 0.5 is
    realistic."""
    scale: Factor = 1.0
    """Factor on the accelerations; along the vertical 0.5 to 0.7 is common."""
    dt: Annotated[float, Number(at_least=0.001, at_most=0.02)] = 0.005
    """Time between samples, s; another one is another motion."""
    start: Instant = 0.0
    """Time at which the motion begins, s."""


FileSpec: TypeAlias = TableSpec | RecordSpec
"""The kinds whose accelerations stand in a file."""

MotionSpec: TypeAlias = (
    StillSpec
    | SineSpec
    | HalfSineSpec
    | OneSineSpec
    | RectangularSpec
    | RickerSpec
    | TableSpec
    | RecordSpec
    | SyntheticSpec
)
