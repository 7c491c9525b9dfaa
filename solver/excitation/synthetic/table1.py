"""The synthetic suite in place of the recorded motions of the paper's Table 1."""

from __future__ import annotations

import math

import numpy as np

from solver.scene.motion import SyntheticSpec

MAGNITUDES = (6.5, 6.9)
DISTANCES_KM = (20.0, 30.0)
VS30 = (180.0, 760.0)
"""Range of shear-wave velocities of NEHRP's classes D and C, m/s."""

EVENT_SIGMA = 0.30
"""Standard deviation between earthquakes, ln: BSSA14's tau, 0.21 to 0.35."""
SITE_SIGMA = 0.50
"""Between sites and paths: with what the noise itself varies it makes BSSA14's phi, 0.5 to 0.6."""


_DRAW = 3
"""The stream of random numbers of one seed that a motion itself makes no use of."""


def table1_suite(count: int = 30, seed: int = 1) -> list[SyntheticSpec]:
    """Motions of earthquakes and sites drawn evenly from Table 1's ranges, Vs30 in its logarithm.

    The first ones are the same however many; motion number i has the seed 1000 `seed` + i.
    """
    return [_drawn(1000 * seed + number) for number in range(1, count + 1)]


def _drawn(seed: int) -> SyntheticSpec:
    raw = np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(_DRAW,))).random_raw(3)
    parts = [float(value >> np.uint64(11)) * 2.0**-53 for value in raw]
    low, high = map(math.log, VS30)
    return SyntheticSpec(
        seed=seed,
        magnitude=round(_within(MAGNITUDES, parts[0]), 2),
        distance_km=round(_within(DISTANCES_KM, parts[1]), 1),
        vs30=float(round(math.exp(_within((low, high), parts[2])))),
        event_sigma=EVENT_SIGMA,
        site_sigma=SITE_SIGMA,
    )


def _within(ends: tuple[float, float], part: float) -> float:
    return ends[0] + part * (ends[1] - ends[0])
