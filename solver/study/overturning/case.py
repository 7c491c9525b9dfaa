"""One case of the study: an engine, a pulse, a frequency, a restitution."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from solver.scene import Scene
from solver.study.overturning.boundaries import Boundary, boundaries
from solver.study.overturning.pulses import PULSES
from solver.study.standing import Tables, variant

TOLERANCE = {"rigid": 1e-5, "ode": 1e-4, "elastic": 2e-3}
"""Relative, of the amplitudes of boundaries."""

BESIDE = 0.01
"""Part of a rigid block's boundary within which the equation's is looked for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OverturningCase:
    """Case of the study, as one process is given it.

    Attributes:
        engine: "rigid", "ode" or "elastic".
        pulse: Its kind.
        frequency: omega/p.
        restitution: e of a rigid block; None: plastic impacts, or an elastic block.
        tables: The scene.
        amplitudes: Over g tan alpha: of the scan of a rigid block, increasing.
        rigid: For the other engines, the boundaries of the rigid block: amplitude, below, above.
    """

    engine: str
    pulse: str
    frequency: float
    restitution: float | None
    tables: Tables
    amplitudes: tuple[float, ...] = ()
    rigid: tuple[tuple[float, str, str], ...] = ()

    @property
    def name(self) -> str:
        """What the study calls it, and no other case; also the name of its file."""
        e = "" if self.restitution is None else f",e={self.restitution:g}"
        beside = "".join(f",{amplitude:.8g}" for amplitude, _, _ in self.rigid)
        return f"{self.engine},{self.pulse},frequency={self.frequency:.8g}{e}{beside}"

    def scene(self) -> Scene:
        """The scene with a rigid block; its impacts are plastic where no restitution is given."""
        return variant(self.tables, model="rigid", restitution=self.restitution)


def run_case(case: OverturningCase) -> dict[str, Any]:
    """Run a case on one process; its row, with a list of boundaries."""
    engines = {"rigid": _rigid, "ode": _ode, "elastic": _elastic}
    found, runs = engines[case.engine](case)
    return {
        "status": "completed",
        "engine": case.engine,
        "pulse": case.pulse,
        "frequency": case.frequency,
        "restitution": case.restitution,
        "runs": runs,
        "boundaries": [
            {"amplitude": each.amplitude, "below": each.below, "above": each.above}
            for each in found
        ],
    }


class _Counted:
    """A function that counts its calls."""

    def __init__(self, function: Any):
        self.function, self.calls = function, 0

    def __call__(self, amplitude: float) -> Any:
        self.calls += 1
        return self.function(amplitude)


def _rigid(case: OverturningCase) -> tuple[list[Boundary], int]:
    """All boundaries of a rigid block by the compiled engine, and the number of runs."""
    from solver.study.overturning.rigid import RigidUnderPulses

    respond = _Counted(RigidUnderPulses(case.scene(), PULSES[case.pulse], case.frequency))
    return boundaries(respond, case.amplitudes, TOLERANCE["rigid"]), respond.calls


def _ode(case: OverturningCase) -> tuple[list[Boundary], int]:
    """The equation's boundaries beside those of the rigid block, and the number of runs."""
    from solver.study.overturning.ode import HousnerUnderPulses

    respond = _Counted(HousnerUnderPulses(case.scene(), PULSES[case.pulse], case.frequency))
    found = []
    for amplitude, below, above in case.rigid:
        beside = [amplitude * (1 - BESIDE), amplitude * (1 + BESIDE)]
        for each in boundaries(respond, beside, TOLERANCE["ode"]):
            if (each.below, each.above) == (below, above):
                found.append(each)
    return found, respond.calls


def _elastic(case: OverturningCase) -> tuple[list[Boundary], int]:
    """The elastic block's boundaries next to those of the rigid one, and the number of runs."""
    from solver.study.overturning.boundaries import STAYS
    from solver.study.overturning.elastic import elastic_fate, near

    kind, found = PULSES[case.pulse], []

    counted = _Counted(partial(elastic_fate, case.tables, kind, case.frequency))
    for amplitude, below, above in case.rigid:
        if STAYS in (below, above):
            ends = near(counted, amplitude, below, above, TOLERANCE["elastic"])
            if ends is not None:
                found.append(Boundary(sum(ends) / 2, below, above))
    return found, counted.calls


def scan(low: float, high: float, samples: int) -> tuple[float, ...]:
    """Amplitudes of a scan, in a geometric series."""
    return tuple(float(value) for value in np.geomspace(low, high, samples))
