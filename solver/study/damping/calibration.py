"""Calibration: its target, a restitution or a measured history, and the search for the value."""

from __future__ import annotations

import math
import re
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from geometry.block import Block
from solver.errors import SceneError
from solver.excitation.layouts.text import number_in, read_lines, rows_of, split_header
from solver.scene import BlockSpec, Scene
from solver.scene.checking import shown
from solver.study.damping.numbers import Restitution
from solver.types import Array

ALLOWED = "restitution=NUMBER, or history=FILE with times (s) and angles (rad)"
COLUMNS = "two columns, time (s) and angle (rad; degrees or mrad where the heading says so)"

SMALLEST_PEAK = 0.05
"""Peaks below this part of the largest are not distinguished from noise."""

RELEASE = 0.05
"""Largest difference between the release that was measured and that of the scene, over the latter:
how fast peaks fall off depends on the first one, also where every impact loses the same."""

ANGLES = {"deg": math.pi / 180, "degree": math.pi / 180, "degrees": math.pi / 180,
          "°": math.pi / 180, "mrad": 1e-3, "rad": 1.0, "radian": 1.0, "radians": 1.0}  # fmt: skip
"""Units of angles, rad."""

_ANGLE = re.compile(
    r"(?<![A-Za-z])(?i:mrad|rad(?:ians?)?|deg(?:rees?)?)(?![A-Za-z])"
    r"|(?<=[a-z])(?:Rad(?:ians?)?|Deg(?:rees?)?)(?![a-z])|°"  # angleDeg
)

NEAR_PEAK = 0.9
"""Rows above this part of a peak, through which its parabola goes."""

MOST_RUNS = 8
"""Runs of a calibration, those that measure the reach included."""

ENOUGH = 5e-4
"""Difference from the target, root mean square, that ends the search."""

NEAREST = 0.01
"""Least difference between two values that are tried, relative."""

ALIKE = 1e-4
"""Differences from the target that are as good as one another: the smaller value is taken."""

DIGITS = 3
"""Significant digits of the values that are tried."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """The target of a calibration.

    Attributes:
        restitution: Mean restitution, which has to be within the reach of the parameter.
        peaks: Peaks after the release, over the angle of release; empty: restitution is compared.
        impacts: Number of impacts that count.
        history: Times (s) and angles (rad) that were measured; None: there are none.
    """

    restitution: float
    peaks: tuple[float, ...]
    impacts: int
    history: tuple[Array, Array] | None = None

    @property
    def wanted(self) -> tuple[float, ...]:
        """The numbers that are wanted."""
        return self.peaks or (self.restitution,)

    def of(self, row: Mapping[str, Any]) -> tuple[float, ...] | None:
        """The numbers of a run that the target has, too; None where it has too few impacts."""
        found = Restitution.of(row, self.impacts)
        if found.mean is None or not found.complete:
            return None
        if not self.peaks:
            return (found.mean,)
        angles = [peak["angle_rad"] for peak in row["peaks"][: len(self.peaks) + 1]]
        if len(angles) <= len(self.peaks):
            return None
        return tuple(angle / angles[0] for angle in angles[1:])


def target_of(word: str, scene: Scene, block: BlockSpec, impacts: int) -> Target:
    """The target that a command line names.

    Args:
        word: `restitution=0.936` or `history=FILE`.
        scene: What is calibrated.
        block: The block whose impacts count.
        impacts: Number of impacts that count.
    """
    kind, _, text = word.partition("=")
    if kind == "restitution":
        value = number_in(text)
        if value is None or not 0 < value <= 1:
            raise SceneError("--target", shown(word), "restitution=NUMBER, 0 < NUMBER <= 1")
        return Target(restitution=value, peaks=(), impacts=impacts)
    if kind != "history" or not text:
        raise SceneError("--target", shown(word), ALLOWED)
    moves = scene.motion is not None or scene.carrier_moves or scene.gravity_tilt_deg
    if moves or not block.tilt:
        # Energies between peaks mean nothing where the base, or an incline, does work.
        allowed = "restitution=NUMBER unless a block is released from a tilt on level ground"
        raise SceneError("--target", shown(word), allowed)
    history = read_history(Path(text))
    peaks, side = measured_peaks(*history), -1 if block.tilt < 0 else 1
    balance = block.shape.slenderness(side)
    if peaks and peaks[0] >= balance:
        got = f"a peak of {peaks[0]:.3g} rad, beyond the block's balance at {balance:.3g}"
        raise SceneError(text, got, COLUMNS)
    if len(peaks) < 2:
        raise SceneError(text, f"{len(peaks)} peaks", "a release and a peak on the other side")
    released, tilt = math.degrees(peaks[0]), math.degrees(abs(block.tilt))
    if abs(released - tilt) > RELEASE * tilt:
        allowed = f"that of a release from {tilt:.3g} as in the scene, or another block.tilt_deg"
        raise SceneError(text, f"a history that begins at {released:.3g} degrees", allowed)
    damping = scene.damping_of(block)
    shape, gravity, drag = block.shape, scene.gravity, damping.mass if damping else 0.0
    count = min(impacts, len(peaks) - 1)
    kept = peaks[: count + 1]
    sides = [side * (-1) ** number for number in range(len(kept))]
    swings = list(zip(kept, sides, strict=True))
    down = [speed_at_impact(peak, shape, gravity, drag, on) for peak, on in swings[:-1]]
    up = [speed_at_impact(peak, shape, gravity, -drag, on) for peak, on in swings[1:]]
    ratios = [after / before for before, after in zip(down, up, strict=True)]
    return Target(
        restitution=statistics.geometric_mean(ratios),
        peaks=tuple(peak / kept[0] for peak in kept[1:]),
        impacts=count,
        history=history,
    )


def speed_at_impact(
    peak: float, shape: Block, gravity: float, drag: float = 0.0, side: int = 0
) -> float:
    """Speed with which a rigid block that is at rest at a peak (rad) comes to its impact, 1/s.

    By theta'' = -p^2 sin(alpha - theta) - drag theta', with the drag, 1/s, of damping that is
    proportional to mass. With a negative drag it is the speed after an impact that leads to the
    peak: the same swing backwards. The side is that of the edge it turns about.
    """
    alpha, square = shape.slenderness(side), shape.frequency(gravity, side) ** 2
    if drag == 0.0:
        return math.sqrt(2 * square * (math.cos(alpha - peak) - math.cos(alpha)))

    def slope(time: float, state: Array) -> list[float]:
        return [state[1], -square * math.sin(alpha - state[0]) - drag * state[1]]

    def lands(time: float, state: Array) -> float:
        return float(state[0])

    setattr(lands, "terminal", True)
    found = solve_ivp(slope, (0.0, 1e3), [peak, 0.0], events=lands, rtol=1e-9, atol=1e-12)
    return abs(float(found.y[1, -1]))


def read_history(file: Path) -> tuple[Array, Array]:
    """Times (s) and angles (rad) of a file of two columns, separated by commas or blanks."""
    lines = read_lines(file, "--target history", COLUMNS)
    header, rest = split_header(lines)
    rows = rows_of(file, rest, COLUMNS, first=len(header) + 1)
    if len(rows) < 10:
        raise SceneError(f"{file}", f"{len(rows)} rows of numbers", "10 or more")
    for row in rows:
        if len(row.values) != 2:
            raise SceneError(f"{file}: line {row.line}", f"{len(row.values)} numbers", COLUMNS)
    found = np.array([row.values for row in rows])
    back = np.flatnonzero(np.diff(found[:, 0]) <= 0)
    if len(back):
        row = rows[int(back[0]) + 1]
        raise SceneError(f"{file}: line {row.line}", f"time {row.words[0]}", "increasing times")
    return found[:, 0], found[:, 1] * _unit(header)


def _unit(header: Sequence[str]) -> float:
    """Unit of the angles, rad: that in the heading of the second column, or anywhere before it."""
    for line in reversed(header):
        _, *others = re.split(r"[,;\t]", line)
        found = _ANGLE.findall(" ".join(others)) or _ANGLE.findall(line)
        if found:
            return ANGLES[found[0].lower()]
    return ANGLES["rad"]


def measured_peaks(time: Array, angle: Array) -> list[float]:
    """Largest angles of the swings of a measured history, rad, without sign.

    What is noise around zero is no swing, and what stays on one side is one swing. Each peak is
    that of the parabola that fits the rows around it best.

    Args:
        time: t, s.
        angle: Rocking angle, rad.
    """
    least = SMALLEST_PEAK * float(np.max(np.abs(angle), initial=0.0))
    large = np.flatnonzero(np.abs(angle) > least)
    if not len(large) or not least:
        return []
    side = np.sign(angle[large])
    swings = np.split(large, np.flatnonzero(np.diff(side)) + 1)
    return [_peak(time[rows], np.abs(angle[rows])) for rows in swings]


def _peak(time: Array, angle: Array) -> float:
    """Largest angle of a swing, rad."""
    near = np.flatnonzero(angle >= NEAR_PEAK * angle.max())
    rows = np.arange(near[0], near[-1] + 1)
    if len(rows) < 5 or rows[0] == 0:  # few rows; or released here, at rest
        return float(angle.max())
    middle = float(np.mean(time[rows]))
    c, b, a = np.polynomial.polynomial.polyfit(time[rows] - middle, angle[rows], 2)
    return float(c - b**2 / (4 * a)) if a < 0 else float(angle.max())


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One run.

    Attributes:
        value: Of the parameter.
        restitution: Mean restitution.
        found: What is compared with the target.
    """

    value: float
    restitution: float
    found: tuple[float, ...]


@dataclass(slots=True)
class Search:
    """A search between two positive values, which tries several at first and then one by one.

    The first runs, at both ends and in the middle, measure what can be reached. From then on all
    numbers that are compared are interpolated over the logarithm of the value, by cubics that
    overshoot nothing, and the next run is made where that comes nearest to the target. Where
    several values do, the smallest is taken.
    """

    low: float
    high: float
    wanted: tuple[float, ...]
    restitution: float
    """Restitution that has to be within reach."""
    most: int = MOST_RUNS
    made: list[Trial] = field(default_factory=list)
    """Runs in the order in which they were made."""

    def next_values(self) -> list[float]:
        """Values to run next; none where the search has ended."""
        if not self.made:
            return [self.low, _rounded(math.sqrt(self.low * self.high)), self.high]
        if len(self.made) >= self.most or self.best_error <= ENOUGH or not self.within_reach:
            return []
        value = self._nearest()
        tried = [abs(math.log(trial.value / value)) for trial in self.trials]
        return [value] if min(tried) > NEAREST else []

    def tell(self, trial: Trial) -> None:
        """Add a run."""
        self.made.append(trial)

    @property
    def trials(self) -> list[Trial]:
        """The runs by their values."""
        return sorted(self.made, key=lambda trial: trial.value)

    @property
    def reach(self) -> tuple[float, float]:
        """Least and largest restitution so far."""
        found = [trial.restitution for trial in self.trials]
        return min(found), max(found)

    @property
    def within_reach(self) -> bool:
        """True if the target lies between restitutions that were found, or next to one."""
        least, largest = self.reach
        return least - ENOUGH <= self.restitution <= largest + ENOUGH

    @property
    def best(self) -> Trial:
        """The run nearest to the target."""
        return min(self.trials, key=self.error)

    @property
    def best_error(self) -> float:
        """Difference of the nearest run from the target."""
        return self.error(self.best)

    def error(self, trial: Trial) -> float:
        """Difference of a run from the target, root mean square."""
        return float(np.sqrt(np.mean((np.array(trial.found) - np.array(self.wanted)) ** 2)))

    def _nearest(self) -> float:
        """Value at which the interpolated runs are nearest to the target."""
        from scipy.interpolate import PchipInterpolator

        places = np.log([trial.value for trial in self.trials])
        found = np.array([trial.found for trial in self.trials])
        fine = np.linspace(places[0], places[-1], 4001)
        differences = PchipInterpolator(places, found)(fine) - np.array(self.wanted)
        errors = np.sqrt(np.mean(differences**2, axis=1))
        good = np.flatnonzero(errors <= errors.min() + ALIKE)
        first = np.split(good, np.flatnonzero(np.diff(good) > 1) + 1)[0]
        return _rounded(math.exp(fine[first[np.argmin(errors[first])]]))


def _rounded(value: float) -> float:
    """A value with few digits."""
    return float(f"{value:.{DIGITS - 1}e}")
