"""The pulses of the study, each of one angular frequency omega."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

from solver.excitation.kinds import base_motion
from solver.excitation.pulses import Pulse
from solver.scene.motion import G_UNIT, HalfSineSpec, OneSineSpec, RickerSpec


@dataclass(frozen=True, slots=True)
class PulseKind:
    """A kind of pulse.

    Attributes:
        words: For titles.
        spec: Kind of the motion in a scene.
        periods: Its duration, as a scene has it, in periods 2 pi/omega.
    """

    words: str
    spec: type[HalfSineSpec | OneSineSpec | RickerSpec]
    periods: float

    def table(self, amplitude: float, frequency: float) -> dict[str, Any]:
        """`[motion]` of a pulse of an amplitude (m/s^2) and a frequency omega (rad/s)."""
        period = 2 * math.pi / frequency
        return {
            "kind": self.spec(amplitude_g=0.0, duration=1.0).kind,
            "amplitude_g": amplitude / G_UNIT,
            "duration": self.periods * period,
        }

    def motion(self, amplitude: float, frequency: float) -> Pulse:
        """A pulse of an amplitude (m/s^2) and a frequency omega (rad/s)."""
        table = self.table(amplitude, frequency)
        spec = self.spec(amplitude_g=table["amplitude_g"], duration=table["duration"])
        return cast("Pulse", base_motion(spec, math.inf))


PULSES = {
    "half_sine": PulseKind("half sine", HalfSineSpec, 0.5),
    "one_sine": PulseKind("one sine", OneSineSpec, 1.0),
    "ricker": PulseKind("Ricker", RickerSpec, 3.0),
}
"""All of them by the name that scenes use; omega of a Ricker wavelet is 2 pi f."""
