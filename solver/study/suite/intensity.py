"""Measures of how strong a motion is, by which the motions of an ensemble are scaled."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np

from solver.errors import SceneError
from solver.scene.checking import shown
from solver.scene.motion import G_UNIT

if TYPE_CHECKING:
    from solver.excitation.motion import GroundMotion
    from solver.excitation.sampled import SampledMotion

ALLOWED = "PGA, PGV or PSA:T with a period T in s"

ROTD50, GEOMEAN, LARGER = HORIZONTAL = ("RotD50", "geomean", "larger")
"""Measures of two horizontal components together: the median over all directions (Boore 2010), the
geometric mean of both, the larger one."""

DIRECTIONS = 180
"""Directions, a degree apart, of which RotD50 is the median; the other half circle repeats them."""

APART = 1e-9
"""Times of samples that are nearer to each other are one and rounding, s."""


@dataclass(frozen=True, slots=True)
class Intensity:
    """A measure of the horizontal motion.

    Attributes:
        kind: "PGA", "PGV" or "PSA", of 5 % damping.
        period: T of PSA, s; 0 for the others.
        horizontal: How two components are measured, one of `HORIZONTAL`; "" where there is one.
    """

    kind: str
    period: float = 0.0
    horizontal: str = ""

    @classmethod
    def read(cls, text: str) -> Intensity:
        """The measure of a word of the command line; SceneError if it is none."""
        kind, _, period = text.partition(":")
        kind = kind.upper()
        try:
            found = cls(kind, float(period) if period else 0.0)
        except ValueError:
            found = cls("")
        if kind not in ("PGA", "PGV", "PSA") or (kind == "PSA") != (0 < found.period < math.inf):
            raise SceneError("--intensity", shown(text), ALLOWED)
        return found

    @property
    def name(self) -> str:
        """The measure in a word."""
        name = f"PSA({self.period:g} s)" if self.kind == "PSA" else self.kind
        return f"{self.horizontal} {name}".strip()

    @property
    def unit(self) -> str:
        """Its unit."""
        return "m/s" if self.kind == "PGV" else "g"

    def of_ground(self, ground: GroundMotion) -> float:
        """The measure of all horizontal components of a motion given by samples, in its unit."""
        # All motions of suites are given by samples.
        parts = cast("tuple[SampledMotion | None, ...]", ground.parts[:-1])
        x, *others = (part for part in parts if part is not None)
        if not others:
            return self.of(x)
        (y,) = others
        if self.horizontal == ROTD50:
            turned = (turned_motion(x, y, math.pi * k / DIRECTIONS) for k in range(DIRECTIONS))
            return statistics.median(self.of(motion) for motion in turned)
        both = self.of(x), self.of(y)
        return max(both) if self.horizontal == LARGER else math.sqrt(both[0] * both[1])

    def of(self, motion: SampledMotion) -> float:
        """The measure of a motion, in its unit."""
        if self.kind == "PGA":
            return motion.peak / G_UNIT
        if self.kind == "PGV":
            return motion.peak_velocity
        from solver.excitation.spectrum import longest_spacing, response_spectrum

        samples, step = motion.evenly_spaced(longest_spacing(self.period))
        return float(response_spectrum(samples, step, self.period)[0]) / G_UNIT


def turned_motion(x: SampledMotion, y: SampledMotion, angle: float) -> SampledMotion:
    """The motion in the direction at an angle (rad) from x towards y, at the samples of both."""
    from solver.excitation.sampled import even_step

    time = np.union1d(x.time, y.time)
    time = time[np.diff(time, prepend=-math.inf) > APART]
    value = math.cos(angle) * x.acceleration(time) + math.sin(angle) * y.acceleration(time)
    return replace(x, time=time, value=value, step=even_step(time), largest="")
