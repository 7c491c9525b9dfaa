"""Measures of how strong a motion is, by which the motions of an ensemble are scaled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solver.errors import SceneError
from solver.scene.checking import shown
from solver.scene.units import G_UNIT

if TYPE_CHECKING:
    from solver.excitation.sampled import SampledMotion

ALLOWED = "PGA, PGV or PSA:T with a period T in s"


@dataclass(frozen=True, slots=True)
class Intensity:
    """A measure of the motion along x.

    Attributes:
        kind: "PGA", "PGV" or "PSA", of 5 % damping.
        period: T of PSA, s; 0 for the others.
    """

    kind: str
    period: float = 0.0

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
        return f"PSA({self.period:g} s)" if self.kind == "PSA" else self.kind

    @property
    def unit(self) -> str:
        """Its unit."""
        return "m/s" if self.kind == "PGV" else "g"

    def of(self, motion: SampledMotion) -> float:
        """The measure of a motion, in its unit."""
        if self.kind == "PGA":
            return motion.peak / G_UNIT
        if self.kind == "PGV":
            return motion.peak_velocity
        from solver.excitation.spectrum import longest_spacing, response_spectrum

        samples, step = motion.evenly_spaced(longest_spacing(self.period))
        return float(response_spectrum(samples, step, self.period)[0]) / G_UNIT
