"""A step leaves the state that it starts from alone, and can be taken again."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from geometry.tags import FacetTag
from solver.build.assembly import build, initial_state
from solver.law.local_problem import NoContactSolution
from solver.scene import Scene, parse_scene
from solver.stepping.contact_solve import StepFailed, StepProblem
from solver.stepping.state import GroundForces, State
from solver.stepping.stepper import Stepper
from solver.types import Array

BLOCK = {"width": 0.25, "height": 0.6, "mass": 100.0, "young": 1e8, "poisson": 0.2}


def tilted(**contact: Any) -> Scene:
    """A block that falls over its corner: its side joins in the first steps."""
    return parse_scene(
        {
            "block": [BLOCK | {"cells": [2, 3], "tilt_deg": 26.6}],
            "contact": {"friction": 0.5} | contact,
            "damping": {"stiffness": 0.0},
            "time": {"end": 1.0, "step": 2e-3},
        }
    )


def stack(dimension: int, **contact: Any) -> Scene:
    """Two blocks that slide on a shaken floor, the upper one on the top of the lower one."""
    depth = {"thickness": 0.3} if dimension == 3 else {}
    lower = BLOCK | depth | {"name": "lower", "height": 0.2, "cells": [2] * dimension}
    upper = lower | {"name": "upper", "on": "lower", "width": 0.2}
    return parse_scene(
        {
            "dimension": dimension,
            "block": [lower, upper],
            "contact": {"friction": 0.2} | contact,
            "motion": {"kind": "sine", "amplitude_g": 0.6, "period": 0.2, "cycles": 2},
            "damping": {"stiffness": 0.0},
            "time": {"end": 1.0, "step": 1e-3},
        }
    )


SCENES = {
    "a side joins": tilted(),
    "a side joins, theta 0": tilted(theta=0, points="gauss", gamma=10000.0),
    "stack": stack(2),
    "stack, theta -1": stack(2, theta=-1, gamma=10000.0),
    "stack in space, on beds": stack(3, damping=0.3, stiffness=1e9),
}


def equal(a: Any, b: Any) -> bool:
    """True if two values hold the same numbers, to the last digit."""
    if is_dataclass(a):
        names = [field.name for field in fields(a) if field.compare]
        return type(a) is type(b) and all(equal(getattr(a, n), getattr(b, n)) for n in names)
    if isinstance(a, dict):  # what is found when it is first asked for
        return all(equal(a[key], b[key]) for key in a.keys() & b.keys())
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, Sequence) and not isinstance(a, str):
        same = type(a) is type(b) and len(a) == len(b)
        return same and all(equal(x, y) for x, y in zip(a, b, strict=True))
    return bool(a == b)


def on_the_way(scene: Scene, steps: int = 20) -> tuple[Stepper, State, float]:
    """A stepper, a state that it has come to, and the length of its steps."""
    assembly = build(scene)
    state, _ = initial_state(scene, assembly)
    for _ in range(steps):
        state, _ = assembly.stepper.advance(state, scene.time.step)
    return assembly.stepper, state, scene.time.step


def fail(stepper: Stepper, state: State, dt: float) -> None:
    """A step that fails in its first correction, after point forces have changed."""
    correction = StepProblem.correction

    def fails(problem: StepProblem, residual: Array) -> Array:
        correction(problem, residual)
        raise NoContactSolution("as asked")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StepProblem, "correction", fails)
        with pytest.raises(StepFailed, match="as asked"):
            stepper.advance(state, dt)


@pytest.mark.parametrize("name", SCENES)
def test_a_step_that_is_taken_again_ends_at_the_same_state(name: str) -> None:
    """After a step of another length, after one that failed; the ledger is the same as well.

    The state that they start from stays as it is.
    """
    stepper, state, dt = on_the_way(SCENES[name])
    before = copy.deepcopy(state)
    first, booked = stepper.advance(state, dt)
    assert equal(state, before) and not equal(first, before)
    stepper.advance(state, dt / 2)
    fail(stepper, state, dt)
    assert equal(state, before)
    again, once_more = stepper.advance(state, dt)
    scale = np.abs(first.u - state.u).max()
    np.testing.assert_allclose(again.u, first.u, rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(again.v, first.v, rtol=0, atol=1e-9 * np.abs(first.v).max())
    for one, other in zip(first.contacts, again.contacts, strict=True):
        atol = 1e-7 * np.abs(one.force).max(initial=1e-9)
        np.testing.assert_allclose(other.force, one.force, rtol=0, atol=atol)
        assert (one.may_touch == other.may_touch).all()
    total = first.kinetic + first.strain
    for field, given, found in zip(booked._fields, booked, once_more, strict=True):
        if isinstance(given, GroundForces):
            for one, other in zip(given, found, strict=True):
                atol = 1e-7 * np.abs(one).max(initial=1e-9)
                np.testing.assert_allclose(other, one, rtol=0, atol=atol)
        elif field not in ("iterations", "pushes"):  # pushes are found from the contacts
            assert found == pytest.approx(given, rel=1e-6, abs=1e-9 * total)


def test_a_face_that_joined_in_a_step_that_failed_joins_again() -> None:
    """The memories of a state belong to the faces that had joined by then."""
    scene = SCENES["a side joins"]
    assembly = build(scene)
    stepper, (state, _) = assembly.stepper, initial_state(scene, assembly)
    while stepper._interfaces.active(state, scene.time.step, state.active) == state.active:
        state, _ = stepper.advance(state, scene.time.step)
    alone = len(state.contacts[0].force)
    fail(stepper, state, scene.time.step)
    assert len(stepper.links[0].interface.keys) == alone
    new, _ = stepper.advance(state, scene.time.step)
    assert len(new.contacts[0].force) > alone == len(state.contacts[0].force)
    joined = int(FacetTag.RIGHT)
    assert joined in new.active[0].faces and joined not in state.active[0].faces
