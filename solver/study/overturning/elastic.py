"""An elastic block under a pulse, and its boundaries near those of a rigid one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from solver.scene import Scene
from solver.study.overturning.energy import Upright
from solver.study.overturning.pulses import PulseKind
from solver.study.standing import Tables, variant

LATEST = 6.0
"""Time after the pulse up to which a block is run, times p; near a boundary, by a part d in
amplitude, it takes about ln(1/d) to decide."""

FIRST = 0.01
"""Part of the rigid block's threshold by which the first pair of amplitudes differs from it."""

WIDEST = 0.4
"""Part of it beyond which no boundary is looked for."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What came of one run."""

    overturns: bool
    impacts: int


def elastic_scene(tables: Tables, kind: PulseKind, frequency: float, amplitude: float) -> Scene:
    """The scene of a run: frequency omega over p, amplitude over g tan alpha."""
    upright = Upright.of(variant(tables, model="rigid", restitution=None))
    p = upright.frequency
    motion = kind.table(amplitude * upright.unit, frequency * p)
    time = {key: value for key, value in tables.get("time", {}).items() if key != "end"}
    end = motion["duration"] + LATEST / p
    return variant(tables | {"motion": motion}, time=time | {"end": end, "stop": "overturned"})


def elastic_fate(tables: Tables, kind: PulseKind, frequency: float, amplitude: float) -> Fate:
    """Run an elastic block under one pulse."""
    from mpi4py import MPI

    from solver.run.simulate import simulate

    scene = elastic_scene(tables, kind, frequency, amplitude)
    result = simulate(scene, comm=MPI.COMM_SELF, many=True)
    if result.status != "completed":
        raise RuntimeError(f"{result.status}: {result.summary['reason']}")
    block = result.summary["blocks"][scene.blocks[0].name]
    return Fate(block["overturned_at_s"] is not None, len(block["impacts"]))


def near(
    fate: Callable[[float], bool], rigid: float, rises: bool, tolerance: float
) -> tuple[float, float] | None:
    """The two amplitudes between which the fate changes next to a rigid block's boundary.

    Args:
        fate: Whether an amplitude overturns.
        rigid: The boundary of a rigid block.
        rises: Whether it overturns above the boundary, and stays below.
        tolerance: Relative, of the distance between both.

    Returns:
        The lower and the higher one; None where none is found within `WIDEST`.
    """
    part, low, high = FIRST, rigid, rigid
    while part < WIDEST:
        if low == rigid and fate(rigid * (1 - part)) != rises:
            low = rigid * (1 - part)
        if high == rigid and fate(rigid * (1 + part)) == rises:
            high = rigid * (1 + part)
        if low < rigid < high:
            break
        part *= 2
    else:
        return None
    while high - low > tolerance * rigid:
        middle = 0.5 * (low + high)
        if fate(middle) == rises:
            high = middle
        else:
            low = middle
    return low, high
