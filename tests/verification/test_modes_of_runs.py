"""Runs of one mode each, beside closed forms: a block that turns on its corners, one that hops."""

from __future__ import annotations

import math
from typing import Any

import pytest

from rockslip import Result, Scene, parse_scene, simulate

GRAVITY, FRICTION, STEP = 9.81, 0.4, 1e-3


def scene(dimension: int, end: float, **block: Any) -> Scene:
    """A rigid block, 1.2 x 0.8 x 0.5 m, on firm ground."""
    size = {"width": 1.2, "thickness": 0.8, "height": 0.5, "mass": 1000.0, "model": "rigid"}
    return parse_scene(
        {
            "dimension": dimension,
            "block": [size | block],
            "contact": {"friction": FRICTION},
            "time": {"end": end, "step": STEP},
            "output": {"fields": "none"},
        }
    )


def told(result: Result) -> dict[str, Any]:
    block: dict[str, Any] = result.summary["blocks"]["block"]
    return block


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_thrown_up_and_aside_hops(dimension: int) -> None:
    """It flies 2 v_x v_z/g, which is displacement; landing takes mu v_z, and the rest is slip."""
    along, up = 1.0, 1.2
    velocity = [along, up] if dimension == 2 else [along, 0.0, up]
    block = told(simulate(scene(dimension, 0.5, velocity=velocity)))
    left = along - FRICTION * up
    slip, flown = left**2 / (2 * FRICTION * GRAVITY), 2 * along * up / GRAVITY
    assert block["mode"] == "slide-hop"
    assert block["residual_slip_m"] == pytest.approx(slip, abs=along * STEP)
    assert block["residual_displacement_m"] == pytest.approx(slip + flown, abs=along * STEP)
    assert block["peak_displacement_m"] == pytest.approx(slip + flown, abs=along * STEP)


def test_a_block_that_lands_and_stays_only_hops() -> None:
    """Friction takes all of v_x, as mu v_z exceeds it: no slip at all."""
    block = told(simulate(scene(2, 0.5, velocity=[0.4, 1.2])))
    assert block["mode"] == "hop"
    assert block["peak_slip_m"] < 1e-9
    assert block["peak_displacement_m"] == pytest.approx(2 * 0.4 * 1.2 / GRAVITY, abs=0.4 * STEP)


@pytest.mark.slow
def test_an_elastic_block_turns_as_under_pressure_that_is_nearly_even() -> None:
    """0.488 rad where even pressure gives 0.500, and four corners 0.270."""
    size = {"width": 1.0, "thickness": 1.0, "model": "elastic", "young": 5e10, "poisson": 0.2}
    given = scene(3, 0.5, **size, cells=[4, 4, 2], angular_velocity=[0.0, 0.0, 3.0])
    block = told(simulate(given))
    mean = (math.sqrt(2) + math.asinh(1)) / 6
    even = 9.0 * 2 / 12 / (2 * FRICTION * GRAVITY * mean)
    assert block["mode"] == "turn"
    assert block["residual_turn_rad"] == pytest.approx(even, rel=0.03)
