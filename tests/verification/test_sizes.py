"""Blocks of all sizes and slendernesses: similarity, restitution, no energy out of nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rockslip import Result, Scene, parse_scene, simulate
from solver.scene.scaling import Scale, scaled_tables

STONE = {"density": 2670.0, "young": 5e9, "poisson": 0.2, "cells": [4, 8]}


def released(
    width: float, height: float, *, part: float = 0.25, friction: float = 3.0, **keys: Any
) -> Scene:
    """A block that is released from a part of alpha, for a few swings in steps of 1/(1000 p)."""
    size = {"width": width, "height": height, "thickness": width}
    shape = parse_scene({"block": [size | STONE], "time": {"end": 1.0}}).blocks[0].shape
    tilt = np.degrees(part * shape.slenderness())
    p = shape.frequency(9.81)
    return parse_scene({
        "block": [size | STONE | {"tilt_deg": tilt} | keys],
        "contact": {"friction": friction},
        "time": {"end": 4.0 / p, "step": 1e-3 / p},
    })  # fmt: skip


def completed(scene: Scene) -> Result:
    """The result of a run that gained no energy."""
    result = simulate(scene)
    assert result.status == "completed", result.summary["reason"]
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-5
    return result


@pytest.mark.parametrize(
    ("model", "keeps"),
    [
        ("rigid", "density"),
        ("rigid", "young"),
        pytest.param("elastic", "density", marks=pytest.mark.slow),
    ],
)
def test_three_sizes_are_equal_over_p_t(model: str, keeps: Any) -> None:
    """0.1 m, 1 m and 10 m high, scaled by `rockslip scale`: angle over alpha within 1e-6."""
    middle = released(0.25, 1.0, model=model)
    scenes = [
        parse_scene(scaled_tables(middle, Scale(lengths, keeps), {})) for lengths in (0.1, 1, 10)
    ]
    found = []
    for scene in scenes:
        shape, result = scene.blocks[0].shape, completed(scene)
        p = shape.frequency(scene.gravity)
        found.append((p * result.history["time_s"], result.history["block.angle_rad"]))
    (time, angle), alpha = found[1], scenes[1].blocks[0].shape.slenderness()
    assert np.ptp(angle) > 0.4 * alpha
    for other, there in (found[0], found[2]):
        np.testing.assert_allclose(other, time, rtol=1e-9, atol=1e-12)
        assert np.abs(there - angle).max() < 1e-6 * alpha


@pytest.mark.parametrize("slenderness", [0.75, 1.25, 1.5, 3.0, 10.0])
def test_rigid_restitution_of_all_slendernesses(slenderness: float) -> None:
    """Without slip: 1 - 3/2 sin^2 alpha at every impact; none gains energy."""
    scene = released(1.0 / slenderness, 1.0, model="rigid")
    summary = completed(scene).summary["blocks"]["block"]
    found = [impact["restitution"] for impact in summary["impacts"]]
    if slenderness > 1.25:
        theory = scene.blocks[0].shape.restitution()
        known = [e for e in found if e is not None]
        assert len(known) >= 2
        assert known == pytest.approx([theory] * len(known), abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "height"),
    [(4 / 3, 1.0), (0.1, 1.0), (0.025, 0.1)],
)
def test_elastic_blocks_of_all_slendernesses_gain_nothing(width: float, height: float) -> None:
    """With the friction of stone, so that squat ones slide."""
    result = completed(released(width, height, friction=0.7))
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-5


def test_a_container_and_its_model() -> None:
    """2.438 x 2.591 m and 1:15: the same to 1e-6 in slip and angle while it slides and rocks."""
    keys = {"width": 2.438, "height": 2.591, "thickness": 6.058, "mass": 24e3, "model": "rigid"}
    prototype = parse_scene({
        "block": [keys],
        "contact": {"friction": 0.5},
        "motion": {"kind": "one_sine", "amplitude_g": 0.8, "duration": 0.8},
        "time": {"end": 1.6, "step": 1e-3},
    })  # fmt: skip
    large, small = (
        completed(parse_scene(scaled_tables(prototype, Scale(lengths), {})))
        for lengths in (1.0, 1 / 15)
    )
    slip, shrunk = large.history["block.slip_m"], 15 * small.history["block.slip_m"]
    assert np.abs(slip).max() > 0.05
    assert np.abs(slip - shrunk).max() < 1e-6 * np.abs(slip).max()
    turned = large.history["block.angle_rad"] - small.history["block.angle_rad"]
    assert np.abs(turned).max() < 1e-6 * prototype.blocks[0].shape.slenderness()
