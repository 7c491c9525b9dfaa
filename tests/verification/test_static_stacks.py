"""Stacks of equal elastic blocks begin in equilibrium, however soft they are."""

from __future__ import annotations

from typing import Any

import pytest

from rockslip import parse_scene, simulate

G = 9.81


def stack(**keys: Any) -> dict[str, Any]:
    """Two equal blocks on an oscillator, whose corners bulge beyond each other's."""
    size = {"width": 2.44, "height": 2.59, "thickness": 6.06, "poisson": 0.3, "cells": [6, 6]}
    below = {"name": "c1", "mass": 24000.0, "friction": 0.3, **size, **keys}
    above = {"name": "c2", "on": "c1", "mass": 12000.0, "friction": 0.2, **size, **keys}
    return {
        "block": [below, above],
        "foundation": {"kind": "oscillator", "mass": 60000.0, "period": 0.6},
        "time": {"end": 4e-3, "step": 2e-3},
    }


@pytest.mark.parametrize("young", [2e8, 2e9, 2e10])
def test_equal_blocks_begin_in_equilibrium(young: float) -> None:
    """It was not found where only the lowest points were known to be near."""
    result = simulate(parse_scene(stack(young=young)))
    history = result.history
    for row in (0, -1):
        assert history["c2.normal_force_N"][row] == pytest.approx(12000 * G, rel=1e-5)
        assert history["c1.normal_force_N"][row] == pytest.approx(36000 * G, rel=1e-5)
    assert not any("equilibrium" in text for text in result.summary["cautions"])


def test_a_high_stack_begins_in_equilibrium() -> None:
    """Each correction finds more blocks near; those that touch count all the while."""
    tables = stack(young=2e8)
    first, second = tables["block"]
    more = [second | {"name": f"c{k}", "on": f"c{k - 1}"} for k in range(3, 6)]
    tables["block"] = [first, second, *more]
    result = simulate(parse_scene(tables))
    assert result.history["c5.normal_force_N"][0] == pytest.approx(12000 * G, rel=1e-5)
    assert result.history["c1.normal_force_N"][0] == pytest.approx(72000 * G, rel=1e-5)
    assert not any("equilibrium" in text for text in result.summary["cautions"])


def test_a_start_that_is_not_as_asked_is_told() -> None:
    """Friction does not hold a block on a steep incline; the run says so, not only its log."""
    tables = {
        "gravity_tilt_deg": 30.0,
        "block": [{"width": 1.0, "height": 0.5, "mass": 100.0, "young": 1e9, "poisson": 0.2}],
        "contact": {"friction": 0.2},
        "time": {"end": 4e-3, "step": 2e-3},
    }
    result = simulate(parse_scene(tables))
    (caution,) = [text for text in result.summary["cautions"] if "at the start" in text]
    assert caution.startswith("friction does not hold the blocks at the start")
