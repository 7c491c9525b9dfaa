"""Edges far from contact, which steps do not look at, and plates that are fully restrained."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.contact.body_points import FixedPoints
from solver.contact.interface import Interface
from solver.stepping import active_set
from solver.stepping.contact_solve import StepFailed

BLOCK = {
    "width": 0.6,
    "height": 0.4,
    "mass": 600.0,
    "young": 3e10,
    "poisson": 0.2,
    "cells": [3, 2],
    "offset": -0.5,
    "velocity": [4.0, 0.0],
}
PLATE = {
    "kind": "elastic",
    "width": 2.0,
    "height": 0.2,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2500.0,
}


def sliding_off(block: dict[str, Any]) -> dict[str, Any]:
    """A block that slides over the edge of a plate, tips there and falls."""
    return {
        "block": [BLOCK | block],
        "foundation": PLATE,
        "contact": {"friction": 0.1},
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.5, "step": 2e-3},
    }


@pytest.mark.slow
def test_far_interfaces_left_out_change_no_digit(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same digits to the end, where the edge of the plate has come into play."""
    scene = sliding_off({"model": "rigid"}) | {"foundation": PLATE | {"meshed": True}}
    looks = 0
    observe = Interface.observe

    def counted(self: Interface, u: Any, carrier_u: Any, since: Any) -> Any:
        nonlocal looks
        looks += not self.theta and isinstance(self.points, FixedPoints)
        return observe(self, u, carrier_u, since)

    monkeypatch.setattr(Interface, "observe", counted)
    found = simulate(parse_scene(scene))
    few, looks = looks, 0
    monkeypatch.setattr(active_set, "STEPS_AHEAD", np.inf)
    expected = simulate(parse_scene(scene))
    assert expected.history["block.penetration_m"].any()
    for column in expected.history.columns:
        np.testing.assert_array_equal(found.history[column], expected.history[column], column)
    assert few < 0.8 * looks


def test_a_step_in_which_bodies_move_farther_than_anybody_looked_fails() -> None:
    """0.4 m in a step, with an edge that was to be looked at after 1e-6 m."""
    assembly = build(parse_scene(sliding_off({})))
    stepper = assembly.stepper
    state, _ = initial_state(parse_scene(sliding_off({})), assembly)
    state, _ = stepper.advance(state, 1e-3)
    assert [memory.clear > 0 for memory in state.contacts] == [False, True]
    near = state.contacts[1]._replace(clear=1e-6)
    state = state._replace(contacts=[state.contacts[0], near])
    with pytest.raises(StepFailed, match="too far"):
        stepper.advance(state, 0.1)
    after, _ = stepper.advance(state, 1e-3)  # 4 mm: less than what is left until contact
    assert after.contacts[1].clear > 0.1
