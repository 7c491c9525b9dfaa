"""A block on a shaken floor: it stays where it is, or slides as the rigid block does."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from swaying import SwayingBlock, sway_modes

from rockslip import Scene, parse_scene, simulate
from solver.excitation.kinds import base_motion
from solver.reference.sliding import sliding
from solver.scene.material import Material

Array = NDArray[np.float64]

PERIOD = 0.5
CELLS = (6, 16)


def scene(*overrides: str) -> Scene:
    """The paper's block, standing, shaken with 0.2 g at 2 Hz."""
    tables = {
        "block": [
            {
                "width": 0.25,
                "height": 1.0,
                "thickness": 0.75,
                "mass": 503.0,
                "young": 5.0e10,
                "poisson": 0.2,
                "cells": CELLS,
            }
        ],
        "contact": {"friction": 0.7},
        "motion": {"kind": "sine", "amplitude_g": 0.2, "period": PERIOD},
        "damping": {"stiffness": 0.0},
        "time": {"end": 10.0, "step": 1e-3},
    }
    return parse_scene(tables, overrides=overrides)


@pytest.mark.slow
def test_a_sticking_block_does_not_creep() -> None:
    """Between the same phases of the third and the sixth cycle."""
    result = simulate(scene("time.end=3.0", "block.cells=[4, 10]"))
    assert result.status == "completed", result.summary
    slip, per_cycle = result.history["block.slip_m"], round(PERIOD / 1e-3)
    third, sixth = (slip[k * per_cycle : (k + 1) * per_cycle] for k in (2, 5))
    assert np.abs(sixth - third).max() < 5e-9
    assert result.summary["blocks"]["block"]["mode"] == "rest"
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-6


def largest_difference(times: Array, slips: Array, run: Scene) -> float:
    """Largest difference of slips at these times from the rigid block's, over its peak."""
    motion = base_motion(run.motion, run.time.end)
    assert motion is not None
    reference = sliding(
        acceleration=motion.acceleration,
        friction=run.contact.friction,
        gravity=run.gravity,
        end=run.time.end,
        step=run.time.step,
    )
    slip = np.interp(times, reference.time, reference.slip)
    return float(np.abs(slips - slip).max() / np.abs(slip).max())


def swaying(run: Scene) -> tuple[Array, Array]:
    """Times and slips of the block that slides and sways, without finite elements in time."""
    block, motion = run.blocks[0], base_motion(run.motion, run.time.end)
    assert motion is not None
    assert isinstance(block.young, float)
    assert isinstance(block.poisson, float)
    shape = block.shape
    material = Material(young=block.young, poisson=block.poisson, density=shape.density)
    modes = sway_modes(shape, material, CELLS)
    friction = run.friction_of(block).dynamic
    model = SwayingBlock(shape.mass, modes, friction * shape.weight(run.gravity), step=2e-5)
    return model.slip(motion.acceleration, run.time.end)


@pytest.mark.slow
def test_the_difference_from_the_rigid_block_is_that_of_sway() -> None:
    """The block that slides and sways is as far from the rigid one, a third of that from this one.

    At 50 GPa it is 1.6 % off: no elastic block of that stiffness can be within 0.5 % of the rigid
    one (docs/method.md).
    """
    expected = 0.0165
    run = scene("contact.friction=0.1", "motion.cycles=2", "time.end=1.1", "time.step=2e-4")
    result, (times, slips) = simulate(run), swaying(run)
    time, slip = result.history["time_s"], result.history["block.slip_m"]
    assert largest_difference(times, slips, run) == pytest.approx(expected, rel=0.1)
    assert largest_difference(time, slip, run) == pytest.approx(expected, rel=0.15)
    apart = np.abs(slip - np.interp(time, times, slips)).max() / np.abs(slips).max()
    assert apart < 0.35 * expected
