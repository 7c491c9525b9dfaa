"""Random heaps, rows and walls of convex bodies: no step fails, nothing is gained, none overlap."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.assemblies import STEP, Assembly, run
from benchmarks.stability.families import matrix
from rockslip import parse_scene, simulate

SEEDS = 0, 1, 2, 3, 4, 5, 8, 9, 11, 12, 13, 14, 16, 17, 19, 20
"""Of assemblies that take a second or less; `benchmarks.assemblies` runs as many as wanted."""
WEDGED = 39160, 39219, 39039
"""Of heaps in the plane in which a light body is wedged between the ground and a heavy one."""


@pytest.mark.parametrize("seed", SEEDS)
def test_an_assembly_holds(seed: int) -> None:
    outcome = run(seed)
    assert outcome.holds, outcome
    assert outcome.unsettled == 0


@pytest.mark.parametrize("seed", WEDGED)
def test_wedged_bodies_are_settled(seed: int) -> None:
    """The law with the proximal term has other solutions there, and holds impulses back."""
    outcome = run(seed)
    assert outcome.holds, outcome
    assert outcome.unsettled == 0


def test_a_solution_that_is_not_sharp_gains_nothing() -> None:
    """A wall whose bricks weigh up to 7000 times as much as others."""
    assembly, steps = Assembly(13090), 900
    world, shift = assembly.world, np.zeros((steps, assembly.d))
    taken = world.now().followed_by(
        world.run(steps, STEP, STEP / 4096, assembly.ground(steps), shift)
    )
    scale = np.abs(taken.stored).sum(axis=1).max()
    left = taken.stored.sum(axis=1) - taken.exchanged[:, 0]
    assert world.counts()["loose"] > 10
    assert np.diff(left).max() < 2e-13 * scale
    assert np.diff(taken.exchanged[:, 1:].sum(axis=1)).min() > -2e-13 * scale


def test_a_softer_term_helps_where_newton_cycles() -> None:
    """A wall under 1 g whose bricks weigh up to 1e4 times as much as others."""
    assembly, steps = Assembly(285), 600
    shift = np.zeros((steps, assembly.d))
    assembly.world.run(steps, STEP, STEP / 4096, assembly.ground(steps), shift)
    counts = assembly.world.counts()
    assert counts["softened"] > 5
    assert counts["failed"] == 0
    assert counts["unsettled"] == 0


@pytest.mark.parametrize("friction", ["10", "1000"])
def test_a_lintel_that_cannot_slide_settles(friction: str) -> None:
    """Shaken on two posts: with so much friction a contact alone is hard for a soft term."""
    place = "friction of neighbours", "lintel", friction
    (case,) = [case for case in matrix() if (case.family, case.row, case.column) == place]
    assert simulate(parse_scene(case.tables)).summary["unsettled"] is None
