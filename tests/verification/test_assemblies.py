"""Random heaps, rows and walls of convex bodies: no step fails, nothing is gained, none overlap."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.assemblies import STEP, Assembly, run

SEEDS = 0, 1, 2, 3, 4, 5, 8, 9, 11, 12, 13, 14, 16, 17, 19, 20
"""Of assemblies that take a second or less; `benchmarks.assemblies` runs as many as wanted."""


@pytest.mark.parametrize("seed", SEEDS)
def test_an_assembly_holds(seed: int) -> None:
    outcome = run(seed)
    assert outcome.holds, outcome
    assert outcome.unsettled == 0


def test_an_interior_point_helps_where_newton_cycles() -> None:
    """A wall under 1 g whose bricks weigh up to 1e4 times as much as others."""
    assembly, steps = Assembly(6), 600
    shift = np.zeros((steps, assembly.d))
    assembly.world.run(steps, STEP, STEP / 4096, assembly.ground(steps), shift)
    counts = assembly.world.counts()
    assert counts["interior"] > 20
    assert counts["failed"] < 0.1 * counts["interior"]
    assert counts["unsettled"] == 0
