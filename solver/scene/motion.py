"""Motions of the ground, as a scene describes them.

A new kind is a class here, its name in `MotionSpec`, and a module of that name in
`solver.excitation.kinds`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from solver.errors import SceneError, not_applicable
from solver.scene.checking import Checked, Number, exactly_one, shown
from solver.scene.ranges import Count, Finite, NotNegative, Positive
from solver.scene.units import G_UNIT

Units: TypeAlias = Literal["g", "m/s2", "cm/s2"]
"""Units of accelerations in files."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion(Checked):
    """Base of the kinds: what a motion along x may have beside it.

    The motions beside it have nothing more.
    """

    vertical: MotionSpec | None = None
    """Along the vertical, positive upwards: `[motion.vertical]`."""
    second: MotionSpec | None = None
    """Along y: `[motion.second]`, 3-D only."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        for direction, motion in self.beside():
            for below, _ in motion.beside():
                raise not_applicable(f"{direction}.{below}", "[motion] itself only")

    @property
    def known_peak(self) -> float | None:
        """Largest |a_g| along this direction, m/s^2, as far as the keys alone tell it.

        None where it takes reading a file or computing the motion.
        """
        return None

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

    @property
    def known_peak(self) -> float | None:
        """No motion has no peak: 0."""
        return 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SineSpec(Motion):
    """A sine of the ground's acceleration: `[motion]` with kind = "sine"."""

    kind: Literal["sine"] = "sine"
    amplitude_g: Finite
    """Amplitude over 9.81 m/s^2, whatever `gravity` is."""
    period: Positive
    """s."""
    cycles: Positive | None = None
    """Number of periods; None: to the end of the run."""
    start: NotNegative = 0.0
    """s."""

    @property
    def known_peak(self) -> float | None:
        """The amplitude, m/s^2."""
        return abs(self.amplitude_g) * G_UNIT


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pulse(Motion):
    """A motion that is over after a while."""

    amplitude_g: Finite
    """Amplitude over 9.81 m/s^2, whatever `gravity` is."""
    duration: Positive
    """s."""
    start: NotNegative = 0.0
    """s."""

    @property
    def known_peak(self) -> float | None:
        """The amplitude, m/s^2."""
        return abs(self.amplitude_g) * G_UNIT


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
    amplitude_g: Finite
    """Acceleration in the middle over 9.81 m/s^2, whatever `gravity` is."""
    duration: Positive | None = None
    """s; or `frequency`. A wavelet of frequency f lasts 3/f: cut off at 1e-8 of its amplitude."""
    frequency: Positive | None = None
    """f, where its spectrum is highest, 1/s."""
    start: NotNegative = 0.0
    """s."""

    def __post_init__(self) -> None:
        """Check the values."""
        Motion.__post_init__(self)
        exactly_one(self, "duration", "frequency")

    @property
    def known_peak(self) -> float | None:
        """The amplitude, m/s^2."""
        return abs(self.amplitude_g) * G_UNIT


@dataclass(frozen=True, slots=True, kw_only=True)
class TableSpec(Motion):
    """The ground's acceleration from a file of two columns: `[motion]` with kind = "table"."""

    kind: Literal["table"] = "table"
    file: Path
    """Time (s) and acceleration; relative to the folder of the scene."""
    units: Units = "g"
    """Of the accelerations; g is 9.81 m/s^2."""
    scale: Finite = 1.0
    """Factor on the accelerations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordSpec(Motion):
    """A recorded accelerogram, samples at equal distances: `[motion]` with kind = "record"."""

    kind: Literal["record"] = "record"
    file: Path
    """PEER's .AT2, two columns, or one with `dt`; relative to the folder of the scene."""
    scale: Finite = 1.0
    """Factor on the accelerations."""
    units: Units | None = None
    """Of the accelerations; g is 9.81 m/s^2. None: those that the header names."""
    dt: Positive | None = None
    """Time between samples, s, for files that do not say it."""
    window: tuple[NotNegative, Positive] | None = None
    """First and last time of the part that is used, s from the first sample; None: all."""
    baseline: Literal["none", "constant", "linear", "quadratic"] = "none"
    """Polynomial taken off the accelerations, so that the velocities become smallest."""
    start: NotNegative = 0.0
    """When the first sample that is used comes, s."""

    def __post_init__(self) -> None:
        """Check the values."""
        Motion.__post_init__(self)
        if self.window is not None and self.window[0] >= self.window[1]:
            raise SceneError("window", shown(self.window), "a first time before the last one")


@dataclass(frozen=True, slots=True, kw_only=True)
class SyntheticSpec(Motion):
    """A motion simulated for an earthquake and a site: `[motion]` with kind = "synthetic"."""

    kind: Literal["synthetic"] = "synthetic"
    seed: Annotated[int, Number(at_least=0)] = 1
    """Of the random numbers: one seed, one earthquake and one site."""
    component: Count = 1
    """Which of the directions of one earthquake at one site: each has noise of its own."""
    magnitude: Annotated[float, Number(at_least=4, at_most=8)] = 6.7
    """Moment magnitude M."""
    distance_km: Annotated[float, Number(at_least=0, at_most=200)] = 25.0
    """R_JB, to the surface projection of the rupture."""
    vs30: Annotated[float, Number(at_least=150, at_most=1500)] = 400.0
    """Mean velocity of shear waves in the upper 30 m, m/s."""
    event_sigma: NotNegative = 0.0
    """Standard deviation of ln amplitude between earthquakes; 0: the average one."""
    site_sigma: NotNegative = 0.0
    """The same between sites and paths."""
    scale: Finite = 1.0
    """Factor on the accelerations."""
    dt: Annotated[float, Number(at_least=0.001, at_most=0.02)] = 0.005
    """Time between samples, s; another one is another motion."""
    start: NotNegative = 0.0
    """s."""


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
