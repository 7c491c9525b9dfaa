"""A correction begins with the operator of the points that were near last: it changes no digit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from solver.build.assembly import build, initial_state
from solver.scene import Scene, parse_scene
from solver.stepping import step_problem
from solver.stepping.delassus import Delassus
from solver.stepping.step_contact import StepContact
from solver.types import Array

BLOCK = {"width": 0.25, "height": 0.6, "mass": 100.0, "cells": [2, 3]}
BLOCK |= {"young": 1e8, "poisson": 0.2}
PLATE = {"kind": "elastic", "width": 0.6, "height": 0.1, "mass_ratio": 2.0, "cells": [8, 1]}
PLATE |= {"young": 1e9, "poisson": 0.2}


def scene(block: dict[str, Any], **others: Any) -> Scene:
    """A block on the floor, or on what else is given, with steps of 1 ms."""
    tables = {"contact": {"friction": 0.2}, "damping": {"stiffness": 0.0}}
    time = {"end": 1.0, "step": 1e-3}
    return parse_scene({"block": [BLOCK | block], "time": time, **tables, **others})


ROCKS = scene({"tilt_deg": 3.0})
LEAVES = scene({"velocity": [0.0, 0.3], "tilt_deg": 1.0})
SHAKEN = {"kind": "sine", "amplitude_g": 0.8, "period": 0.2, "cycles": 2}

SCENES = {
    "rocks": ROCKS,
    "leaves the floor": LEAVES,
    "slides off a plate": scene(
        {"velocity": [1.2, 0.0]}, foundation=PLATE | {"width": 0.3, "support": "fixed"}
    ),
    "on a plate on rollers": scene(
        {"tilt_deg": 2.0},
        foundation=PLATE | {"support": "rollers", "period": 0.3},
        motion=SHAKEN,
    ),
}


class Counts:
    """How often operators are made and problems are settled."""

    def __init__(self, patch: pytest.MonkeyPatch):
        """Count from now on."""
        self.made = self.settled = 0
        assembled, settle = step_problem.assembled, StepContact.settle

        def make(*given: Any, **named: Any) -> Delassus:
            self.made += 1
            return assembled(*given, **named)

        def solve(contact: StepContact, *given: Any) -> Any:
            self.settled += 1
            return settle(contact, *given)

        patch.setattr(step_problem, "assembled", make)
        patch.setattr(StepContact, "settle", solve)


def run(scene: Scene, steps: int, few: int, leaves: int = -1) -> tuple[list[Array], Counts]:
    """Displacements after each step, and what it took, with the operator of so many points.

    Before the step `leaves` the bodies are thrown up.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(step_problem, "FEW_POINTS", few)
        counts = Counts(patch)
        assembly = build(scene)
        stepper = assembly.stepper
        state, _ = initial_state(scene, assembly)
        found = []
        for number in range(steps):
            if number == leaves:
                up = np.tile([0.0, 0.5], len(state.v) // 2)
                state = stepper.launch(state, state.v + up)
            state, _ = stepper.advance(state, scene.time.step)
            found.append(state.u)
    return found, counts


@pytest.mark.parametrize("name", SCENES)
def test_it_changes_no_digit(name: str) -> None:
    """Beside corrections that first look which points are near."""
    found, _ = run(SCENES[name], 150, step_problem.FEW_POINTS)
    expected, _ = run(SCENES[name], 150, 0)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_block_that_rocks_has_its_problem_settled_once_a_correction() -> None:
    """As many operators are made as before, and the first look at each is spared."""
    _, counts = run(ROCKS, 50, step_problem.FEW_POINTS)
    _, looking = run(ROCKS, 50, 0)
    assert counts.made <= looking.made + 2
    assert counts.settled < looking.settled - 45


def test_points_that_have_left_are_given_up() -> None:
    """A block that turns in the air has no operator made in each step, and lands as before."""
    found, counts = run(ROCKS, 130, step_problem.FEW_POINTS, leaves=20)
    expected, looking = run(ROCKS, 130, 0, leaves=20)
    np.testing.assert_array_equal(found, expected)
    _, flying = run(ROCKS, 60, step_problem.FEW_POINTS, leaves=20)
    _, unasked = run(ROCKS, 60, 0, leaves=20)
    assert flying.made <= unasked.made + 2
    assert counts.made > flying.made + 5  # it has landed
    assert counts.made <= looking.made + 4
