"""Restitution of impacts on inclines, on ground that moves, on blocks that move, and of all models.

Rigid blocks have a given one, or Housner's where impacts are plastic, which is what events say.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rockslip import Result, SceneError, parse_scene, simulate
from solver.results.events import HOPS
from solver.results.report import report

GIVEN = 0.9


def told(result: Result, name: str = "block") -> list[float | None]:
    return [impact["restitution"] for impact in result.summary["blocks"][name]["impacts"]]


def rocks(dimension: int = 2, block: dict[str, Any] | None = None, **tables: Any) -> Result:
    """A slender block that is let go."""
    own = {
        **{"model": "rigid", "width": 0.25, "height": 1.0, "thickness": 0.4, "mass": 503.0},
        **{"tilt_deg": 5.0, "restitution": GIVEN},
    }
    time = {"end": 2.0, "step": 1e-3}
    scene = {"dimension": dimension, "block": [own | (block or {})], "time": time}
    return simulate(parse_scene(scene | {"contact": {"friction": 2.0}} | tables))


HOUSNER = 1 - 1.5 * math.sin(math.atan(0.25)) ** 2
"""Of the slender block where impacts are plastic, on what stands still or moves with the ground."""

SINE = {"kind": "sine", "amplitude_g": 0.2, "period": 0.4, "cycles": 5}

BASES: dict[str, tuple[float, dict[str, Any]]] = {
    "3 degrees downhill": (5.0, {"gravity_tilt_deg": 3.0}),
    "3 degrees uphill": (-5.0, {"gravity_tilt_deg": 3.0}),
    "8 degrees": (3.0, {"gravity_tilt_deg": 8.0}),
    "a sine": (5.0, {"motion": SINE}),
    "a sine, vertical, too": (5.0, {"motion": SINE | {"vertical": SINE | {"period": 0.23}}}),
}
"""Tilt of the block, and what it stands on."""


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("restitution", [GIVEN, None])
def test_on_inclines_and_moving_ground(
    dimension: int, base: str, restitution: float | None
) -> None:
    """In space a plastic impact is one of a step."""
    tilt, tables = BASES[base]
    found = told(rocks(dimension, {"tilt_deg": tilt, "restitution": restitution}, **tables))
    assert len(found) >= 2
    error = 1e-3 if dimension == 3 and restitution is None else 2e-5
    known = restitution or HOUSNER
    assert found[:-1] == [pytest.approx(known, abs=error)] * (len(found) - 1)


@pytest.mark.parametrize(
    ("tables", "within"),
    [
        ({"gravity_tilt_deg": 3.0}, 0.004),
        ({"motion": SINE}, 0.004),
        ({"damping": {"mass": 0.5, "stiffness": 3.7e-5}}, 0.003),
    ],
)
def test_of_an_elastic_block_it_is_that_of_level_ground(
    tables: dict[str, Any], within: float
) -> None:
    """The paper's block keeps 0.936, by its peaks on level ground."""
    own = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "tilt_deg": 3.0}
    own |= {"young": 5e10, "poisson": 0.2, "cells": [6, 16]}
    scene = {"block": [own], "contact": {"friction": 0.7}, "time": {"end": 0.7}}
    found = told(simulate(parse_scene(scene | {"damping": {"stiffness": 3.7e-5}} | tables)))
    assert found[:2] == [pytest.approx(0.936, abs=within)] * 2


@pytest.mark.parametrize("incline", [0.0, 8.0])
def test_on_ground_that_moves_along_y(incline: float) -> None:
    """An incline along x does nothing to a block that rocks along y."""
    second = {"kind": "half_sine", "amplitude_g": 0.05, "duration": 0.3}
    result = rocks(
        3,
        {"width": 0.75, "thickness": 0.25, "tilt_deg": 4.0, "tilt_direction_deg": 90.0},
        motion={"kind": "none", "second": second},
        gravity_tilt_deg=incline,
    )
    found = told(result)
    assert len(found) >= 3
    assert found[:-1] == [pytest.approx(GIVEN, abs=1e-5)] * (len(found) - 1)


@pytest.mark.parametrize("friction", [0.02, 0.05, 2.0])
@pytest.mark.parametrize("shaken", [False, True])
def test_on_a_block_that_slides(friction: float, shaken: bool) -> None:
    """It moves by the impacts themselves, the more the less it is held."""
    low = {
        **{"name": "low", "model": "rigid", "width": 1.0, "height": 0.2, "thickness": 0.4},
        **{"mass": 20.0, "friction": friction},
    }
    up = {
        **{"name": "up", "on": "low", "model": "rigid", "width": 0.25, "height": 1.0},
        **{"thickness": 0.4, "mass": 100.0, "tilt_deg": 6.0, "restitution": GIVEN, "friction": 2.0},
    }
    tables: dict[str, Any] = {"block": [low, up], "time": {"end": 1.5, "step": 2e-4}}
    if shaken:
        tables["motion"] = {"kind": "half_sine", "amplitude_g": 0.02, "duration": 0.1}
    found = told(simulate(parse_scene(tables)), "up")
    assert len(found) >= 3
    assert found[:-1] == [pytest.approx(GIVEN, abs=1e-4)] * (len(found) - 1)


def test_a_block_that_rolls_over_its_corners_has_none() -> None:
    """Its energy goes to and fro between two planes: no ratio of one plane is a restitution."""
    oblique = {"tilt_direction_deg": 20.0, "restitution": 1.0}
    found = told(rocks(3, oblique, time={"end": 1.5, "step": 5e-4}))
    assert len(found) >= 3 and set(found) == {None}


@pytest.mark.parametrize("case", ["slides", "skids on a platform"])
def test_of_a_block_that_slides_as_it_rocks_on_a_base_that_moves(case: str) -> None:
    """The rows beside the impact tell it, whatever friction does in between."""
    if case == "slides":
        result = rocks(
            block={"width": 0.4, "tilt_deg": 10.0, "restitution": None},
            contact={"friction": 0.25},
            motion={"kind": "one_sine", "amplitude_g": 0.3, "duration": 0.5},
            time={"end": 1.5, "step": 1e-4},
        )
    else:
        result = rocks(
            block={"tilt_deg": 0.0, "restitution": None},
            foundation={
                **{"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5},
                "damping_ratio": 0.05,
            },
            motion={
                **{"kind": "sine", "amplitude_g": 0.45, "period": 0.6, "cycles": 4},
                "vertical": {"kind": "sine", "amplitude_g": 0.3, "period": 0.37, "cycles": 7},
            },
            time={"end": 2.5, "step": 1e-4},
        )
    history, checked = result.history, 0
    for impact in result.summary["blocks"]["block"]["impacts"]:
        if impact["restitution"] is not None:
            time, rate = history["time_s"], history["block.angular_velocity_rad_s"]
            row = int(np.searchsorted(time, impact["time_s"]))
            after, before = (
                np.polynomial.Polynomial.fit(time[rows], rate[rows], 1)(impact["time_s"])
                for rows in (slice(row + 2, row + 5), slice(row - 4, row))
            )
            assert impact["restitution"] == pytest.approx(abs(after / before), rel=1e-4)
            checked += 1
    assert checked >= 2


HELD = {
    **{"kind": "elastic", "width": 1.0, "height": 0.2, "young": 5e10, "poisson": 0.2},
    "density": 2400.0,
}
"""A plate that is held everywhere and not meshed."""


@pytest.mark.parametrize("dimension", [2, 3])
def test_on_a_plate_that_is_held(dimension: int) -> None:
    """It is as firm as the ground: all digits are the same."""
    plate = HELD | ({"thickness": 0.8} if dimension == 3 else {})
    ground, held = rocks(dimension), rocks(dimension, foundation=plate)
    assert len(told(held)) >= 3 and told(held)[:2] == [pytest.approx(GIVEN, abs=1e-5)] * 2
    for column in ground.history:
        assert np.array_equal(ground.history[column], held.history[column]), column


def test_a_run_ends_at_the_edge_of_such_a_plate() -> None:
    """After 0.375 m at 1 m/s, without friction."""
    free = {"tilt_deg": 0.0, "velocity": [1.0, 0.0], "friction": 0.0}
    result = rocks(block=free, foundation=HELD)
    assert result.summary["end_s"] == pytest.approx(0.375, abs=1.1e-3)
    assert result.summary["reason"].startswith("block came to the edge of the plate at t = 0.37")


def test_on_a_mesh_it_is_refused() -> None:
    with pytest.raises(SceneError, match=r"block\.restitution.*nothing is meshed"):
        rocks(foundation=HELD | {"meshed": True})


@pytest.mark.parametrize("tilt", [3.0, 8.0])
def test_a_squat_elastic_block_that_hops_has_none(tilt: float) -> None:
    """A cube of steel: its peaks said 0.43, 1.03, 0.28 and 2.73; half of its energy is in hops."""
    cube = {
        **{"width": 0.1, "height": 0.1, "thickness": 0.1, "density": 7850.0, "tilt_deg": tilt},
        **{"young": 2.1e11, "poisson": 0.3, "cells": [4, 4]},
    }
    tables = {"block": [cube], "contact": {"friction": 0.6}, "time": {"end": 0.18}}
    summary = simulate(parse_scene(tables)).summary
    impacts = summary["blocks"]["block"]["impacts"]
    assert len(impacts) >= 4
    assert {(impact["restitution"], impact["reason"]) for impact in impacts} == {(None, HOPS)}
    assert f"none: {HOPS} ({len(impacts)})" in report(summary)


@pytest.mark.slow
def test_of_a_rigid_block_on_a_deck_that_bends() -> None:
    """An impact on it takes time: the rows beside its instant lie within it, and told 0.995.

    By the angles of 0.4/p it is that of a platform as heavy as the deck, within 0.02.
    """
    deck = {
        **{"kind": "elastic", "support": "rollers", "width": 3.0, "height": 0.1},
        **{"density": 2400.0, "young": 3e9, "poisson": 0.2, "cells": [24, 2], "period": 0.5},
        **{"damping_ratio": 0.05, "damping": {"stiffness": 1e-4}},
    }
    block = {"model": "rigid", "width": 0.25, "height": 1.0, "density": 2000.0, "tilt_deg": 5.0}
    tables = {"block": [block], "foundation": deck, "contact": {"friction": 0.7}}
    scene = parse_scene(tables | {"time": {"end": 0.6}})
    found = told(simulate(scene))
    shape = scene.blocks[0].shape
    expected = shape.restitution(0, shape.mass / (shape.mass + scene.platform().mass))
    assert found[:2] == [pytest.approx(expected, abs=0.02)] * 2
