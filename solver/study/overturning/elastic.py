"""An elastic block under a pulse, and its boundaries near those of a rigid one."""

from __future__ import annotations

from collections.abc import Callable

from solver.scene import Scene
from solver.study.overturning.boundaries import DIRECTLY, LATER, STAYS
from solver.study.overturning.energy import Upright
from solver.study.overturning.pulses import PulseKind
from solver.study.standing import Tables, variant

LATEST = 9.0
"""Time after the pulse up to which a block is run, times p; near a boundary, by a part d in
amplitude, it takes about ln(1/d) to decide, and the swing back after that."""

FIRST = 0.004
"""Part of the rigid block's threshold by which the first pair of amplitudes differs from it."""

WIDEST = 0.4
"""Part of it beyond which no boundary is looked for."""


def elastic_scene(tables: Tables, kind: PulseKind, frequency: float, amplitude: float) -> Scene:
    """The scene of a run: frequency omega over p, amplitude over g tan alpha."""
    upright = Upright.of(variant(tables, model="rigid", restitution=None))
    p = upright.frequency
    motion = kind.table(amplitude * upright.unit, frequency * p)
    time = {key: value for key, value in tables.get("time", {}).items() if key != "end"}
    end = motion["duration"] + LATEST / p
    return variant(tables | {"motion": motion}, time=time | {"end": end, "stop": "overturned"})


def elastic_fate(tables: Tables, kind: PulseKind, frequency: float, amplitude: float) -> str:
    """What comes of an elastic block under one pulse: one of the words of boundaries.

    Raises:
        RuntimeError: The run failed, or ended before the fate of the block was certain.
    """
    from mpi4py import MPI

    from solver.run.simulate import simulate

    scene = elastic_scene(tables, kind, frequency, amplitude)
    result = simulate(scene, comm=MPI.COMM_SELF)
    if result.status != "completed":
        raise RuntimeError(f"{result.status}: {result.summary['reason']}")
    name, history = scene.blocks[0].name, result.history
    block = result.summary["blocks"][name]
    if block["overturned_at_s"] is not None:
        return LATER if block["impacts"] else DIRECTLY
    upright = Upright.of(variant(tables, model="rigid", restitution=None))
    energy = history["energy.kinetic_J"][-1] + history["energy.gravity_J"][-1]
    if not upright.stays(energy, history[f"{name}.angle_rad"][-1]):
        raise RuntimeError(f"{scene.time.end:g} s decide nothing at {amplitude:g} g tan alpha")
    return STAYS


def near(
    fate: Callable[[float], str], rigid: float, below: str, above: str, tolerance: float
) -> tuple[float, float] | None:
    """The two amplitudes between which the fate changes next to a rigid block's boundary.

    Args:
        fate: What comes of an amplitude, in the words of boundaries.
        rigid: The boundary of a rigid block.
        below: What comes of it below the boundary.
        above: What comes of it above.
        tolerance: Relative, of the distance between both.

    Returns:
        The lower and the higher one; None where none is found within `WIDEST`.
    """
    part, low, high = FIRST, rigid, rigid
    while part < WIDEST:
        if low == rigid and fate(rigid * (1 - part)) == below:
            low = rigid * (1 - part)
        if high == rigid and fate(rigid * (1 + part)) == above:
            high = rigid * (1 + part)
        if low < rigid < high:
            break
        part *= 2
    else:
        return None
    while high - low > tolerance * rigid:
        middle = 0.5 * (low + high)
        found = fate(middle)
        if found not in (below, above):  # another boundary lies between
            return None
        low, high = (low, middle) if found == above else (middle, high)
    return low, high
