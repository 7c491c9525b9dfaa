"""Steps after a change of contact: how many, with which scheme, and that nothing is left of it."""

from __future__ import annotations

import numpy as np
import pytest

from rockslip import Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.stepping.stepper import Stepper

SQUAT = {"width": 1.0, "height": 0.5, "mass": 1000.0, "cells": [2, 2], "poisson": 0.2}


def thrown(young: float, speed: float, step: float, *overrides: str) -> Scene:
    """A squat block that is thrown upwards and lands, again and again."""
    return parse_scene(
        {
            "block": [SQUAT | {"young": young, "velocity": [0.0, speed]}],
            "contact": {"friction": 0.3},
            "damping": {"stiffness": 0.0},
            "time": {"end": 0.4, "step": step},
        },
        overrides=overrides,
    )


def test_so_many_steps_after_each_change() -> None:
    """For so long from a change on, and again from the next one."""
    count = 3
    scene = thrown(1e9, 0.3, 2e-3, f"time.damped_steps={count}")
    assembly = build(scene)
    stepper, (state, _) = assembly.stepper, initial_state(scene, assembly)
    left, landings, dt = 0, 0, scene.time.step
    for _ in range(100):
        closed = state.contacts[0].force[:, 0] > 0
        state, _ = stepper.advance(state, dt)
        landed = not closed.any() and bool((state.contacts[0].force[:, 0] > 0).any())
        landings += landed
        flies = not closed.any() and not landed
        left = count if landed else max(left - 1, 0)
        if landed or flies:
            assert round((state.damped_until - state.time) / dt) == left or left == 0
            assert state.is_damped(dt) == (left > 0)
        left = max(round((state.damped_until - state.time) / dt), 0)
    assert landings > 0


def test_a_step_that_fails_leaves_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two halves of a step that failed are as damped as the step would have been."""
    scene = thrown(1e9, 0.3, 2e-3)
    assembly = build(scene)
    stepper, (state, _) = assembly.stepper, initial_state(scene, assembly)
    until = 5 * scene.time.step
    state = state._replace(damped_until=until)
    skews: list[float] = []
    ended = Stepper._ended

    def watch(self: Stepper, *given):  # type: ignore[no-untyped-def]
        skews.append(given[1].scheme.skew)
        return ended(self, *given)

    monkeypatch.setattr(Stepper, "_ended", watch)
    one, _ = stepper.advance(state, scene.time.step)
    two, _ = stepper.advance(state, scene.time.step / 2)
    assert state.damped_until == until
    assert skews == [0.5, 0.5]
    for new in (one, two):
        assert new.damped_until == (new.time + 8 * scene.time.step if new.changed else until)


def test_landing_after_a_flight_that_began_with_damped_steps() -> None:
    """The tangent changes while nothing is near: what belongs to points is built anew."""
    result = simulate(thrown(1e9, 0.3, 1e-2))
    assert result.status == "completed"
    cost = result.summary["cost"]
    assert 8 <= cost["damped_steps"] < cost["steps"]
    assert cost["newton_iterations"] < 4 * cost["steps"]


def test_without_them() -> None:
    """None where they are switched off, or where rho_inf is 1 nothing is damped in them."""
    off = simulate(thrown(1e9, 0.3, 2e-3, "time.damped_steps=0"))
    assert off.summary["cost"]["damped_steps"] == 0
    kept, lost = (
        simulate(thrown(1e9, 0.3, 2e-3, f"time.rho_inf={rho}")).summary["energy"]["loss"]
        for rho in (1.0, 0.8)
    )
    assert abs(kept["numerical_J"]) < 1e-6 * lost["numerical_J"]
    assert np.isfinite(lost["contact_J"])


@pytest.mark.slow
def test_adaptive_steps_need_none() -> None:
    """They resolve what vibrates; where it is asked for, time is counted in first steps."""
    scene = thrown(1e9, 0.3, 2e-3, "time.adaptive=true", "time.end=0.1")
    assert scene.time.damped_steps == 0
    assert simulate(scene).summary["cost"]["damped_steps"] == 0
    words = "time.adaptive=true", "time.damped_steps=4", "time.end=0.1"
    asked = simulate(thrown(1e9, 0.3, 2e-3, *words))
    step, damped = asked.history["step_s"], asked.summary["cost"]["damped_steps"]
    assert damped > 4, "steps are shorter than the first one"
    assert damped < len(step)
