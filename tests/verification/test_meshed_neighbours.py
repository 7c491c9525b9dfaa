"""Meshed bodies that meet their neighbours: waves, momentum, dominoes, lintels, pounding."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.rigid_world import scenes
from rockslip import Result, Scene, parse_scene, read_run, simulate
from solver.build.assembly import build, initial_state
from solver.history.events import Event

pytestmark = pytest.mark.serial

G = 9.81
BAR: dict[str, Any] = {
    **{"model": "elastic", "width": 1.0, "height": 0.1, "mass": 1000.0},
    **{"poisson": 0.0, "cells": [48, 2], "friction": 0.0, "damping": {"stiffness": 0.0}},
}


def bars(young: float, count: int, tolerance: float = 1e-3, **keys: Any) -> Result:
    """Bars in a row, a hair apart, of which the first comes with 2 m/s; until they have parted."""
    crossing = 1.0 / math.sqrt(young / 10000.0)  # L/c
    gap = 4 * crossing
    blocks = [BAR | {"young": young, "name": f"n{k}"} | keys for k in range(count)]
    for k, block in enumerate(blocks):
        block["offset"] = k * (1.0 + gap)
    blocks[0]["velocity"] = [2.0, 0.0]
    end = (4 * count + 8) * crossing
    time = {"end": end, "tolerance": tolerance}
    result = simulate(parse_scene({"block": blocks, "time": time}))
    energy = result.summary["energy"]
    assert result.status == "completed" and not result.summary["overlaps"]
    assert energy["largest_gain_fraction"] < 1e-9 and energy["ledger_error_fraction"] < 1e-9
    return result


def last_velocity(result: Result, name: str) -> float:
    """Mean velocity of a block in the last tenth of the run, m/s."""
    time, place = result.history["time_s"], result.history[f"{name}.centre_x_m"]
    rows = time > 0.9 * time[-1]
    return float(np.polyfit(time[rows], place[rows], 1)[0])


def collisions(result: Result) -> list[Event]:
    """The collisions of a run."""
    assert result.history.events is not None
    return [event for event in result.history.events if event.kind == "collision"]


@pytest.mark.slow
@pytest.mark.parametrize(("young", "tolerance"), [(5e9, 1e-3), (5e11, 1e-4)])
def test_equal_bars_exchange_their_velocities(young: float, tolerance: float) -> None:
    """Within 1 %, whatever their stiffness; the impulse is the momentum that the second gets."""
    result = bars(young, 2, tolerance)
    first, second = (last_velocity(result, name) for name in ("n0", "n1"))
    assert first == pytest.approx(0.0, abs=0.02) and second == pytest.approx(2.0, abs=0.02)
    assert first + second == pytest.approx(2.0, abs=1e-6)
    (met,) = collisions(result)
    assert (met.block, met.meets) == ("n0", "n1")
    assert met.time_s == pytest.approx(2 / math.sqrt(young / 10000.0), rel=1e-6)
    assert met.velocity_before_m_s == pytest.approx(-2.0, abs=1e-9)
    assert met.impulse_Ns == pytest.approx(1000 * second, rel=1e-4)


def test_damping_takes_the_vibration_and_leaves_the_momentum() -> None:
    """With C = beta K so large that bars do not vibrate they go on together: a plastic impact."""
    result = bars(5e9, 2, damping={"stiffness": 0.02})
    speeds = [last_velocity(result, name) for name in ("n0", "n1")]
    assert speeds == pytest.approx([1.0, 1.0], abs=0.02)


@pytest.mark.slow
def test_five_in_a_row_pass_their_momentum_on() -> None:
    """Only the last one moves in the end, and four wait; coarse ones lose 1.8 % a blow."""
    result = bars(5e9, 5, cells=[20, 1])
    speeds = [last_velocity(result, f"n{k}") for k in range(5)]
    assert sum(speeds) == pytest.approx(2.0, abs=1e-6)
    assert speeds[:4] == pytest.approx([0.0] * 4, abs=0.1)
    assert speeds[4] == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize(
    ("low", "tall"), [([4, 2], [2, 8]), ([2, 1], [6, 24])], ids=["low is finer", "tall is finer"]
)
def test_a_low_block_strikes_the_face_of_a_tall_one(low: list[int], tall: list[int]) -> None:
    """Its upper corner is met inside a face, whichever has the points: momentum stays."""
    stone: dict[str, Any] = {"model": "elastic", "young": 5e9, "poisson": 0.2, "friction": 0.0}
    first = {"name": "low", "width": 0.4, "height": 0.2, "mass": 80.0, "velocity": [1.0, 0.0]}
    second = {"name": "tall", "width": 0.5, "height": 2.0, "mass": 800.0, "offset": 0.451}
    blocks = [stone | first | {"cells": low}, stone | second | {"cells": tall}]
    result = simulate(parse_scene({"block": blocks, "time": {"end": 0.01}}))
    (met,) = collisions(result)
    assert (met.block, met.meets) == ("low", "tall")
    assert met.time_s == pytest.approx(1e-3, rel=1e-3)  # under their weight both are wider
    momenta = [80.0 * last_velocity(result, "low"), 800.0 * last_velocity(result, "tall")]
    assert sum(momenta) == pytest.approx(80.0, abs=1e-6)
    assert met.impulse_Ns == pytest.approx(86.0, rel=0.03)
    assert not result.summary["overlaps"]
    assert result.history["low.penetration_m"].max() < 1e-6
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9


DOMINO: dict[str, Any] = {
    **{"width": 0.1, "height": 1.0, "mass": 200.0, "friction": 0.5},
    **{"young": 5e10, "poisson": 0.2},
}


@cache
def dominoes(dimension: int, count: int, end: float, model: str, **time: Any) -> Result:
    """Dominoes 0.4 m apart, of which the first leans by 8 degrees."""
    more: dict[str, Any] = {"cells": [2, 10]}
    if dimension == 3:
        more = {"cells": [2, 1, 6], "thickness": 0.4}
    blocks = [
        DOMINO | more | {"name": f"n{k}", "offset": 0.4 * k, "model": model} for k in range(count)
    ]
    blocks[0]["tilt_deg"] = 8.0
    tables = {"dimension": dimension, "block": blocks, "time": {"end": end} | time}
    result = simulate(parse_scene(tables))
    assert result.status == "completed" and not result.summary["overlaps"]
    return result


def passed(result: Result, name: str) -> float:
    """Time at which a domino leans by 20 degrees, s."""
    angle, time = result.history[f"{name}.angle_rad"], result.history["time_s"]
    row = int(np.argmax(angle > math.radians(20)))
    return float(np.interp(math.radians(20), angle[row - 1 : row + 1], time[row - 1 : row + 1]))


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_elastic_dominoes_fall_as_rigid_ones(dimension: int) -> None:
    """Within 3 % of their times; no energy comes in, and the ledger closes."""
    count, end = 3, 1.4
    elastic = dominoes(dimension, count, end, "elastic")
    rigid = dominoes(dimension, count, end, "rigid", step=1e-3)
    for k in range(count):
        assert passed(elastic, f"n{k}") == pytest.approx(passed(rigid, f"n{k}"), rel=0.03)
    weight = 200.0 * G
    total = elastic.history["energy.total_J"]
    assert elastic.summary["energy"]["largest_gain_fraction"] < 1e-6
    assert np.abs(elastic.history["energy.ledger_error_J"]).max() < 1e-9 * weight
    assert total[-1] < total[0]
    found = [(event.block, event.meets) for event in collisions(elastic)]
    assert [pair for k, pair in enumerate(found) if pair not in found[:k]][: count - 1] == [
        (f"n{k}", f"n{k + 1}") for k in range(count - 1)
    ]


@pytest.mark.slow
def test_the_wave_of_dominoes_is_that_of_smaller_steps() -> None:
    """A fourth of the tolerance moves it by less than 0.01 % (2e-5 in space, too)."""
    usual = dominoes(2, 3, 1.4, "elastic")
    finer = dominoes(2, 3, 1.4, "elastic", tolerance=2.5e-4)
    for name in ("n0", "n1", "n2"):
        assert passed(usual, name) == pytest.approx(passed(finer, name), rel=1e-4)


def lintel(dimension: int, width: float = 0.4, cells: int = 8) -> dict[str, Any]:
    """A lintel on two posts of a width, all elastic; in space of so many cells along it."""
    stone: dict[str, Any] = {"model": "elastic", "young": 5e9, "poisson": 0.2, "friction": 0.5}
    post = stone | {"width": width, "height": 1.0, "mass": 2000.0 * width, "cells": [4, 8]}
    beam = stone | {"width": 2.2, "height": 0.3, "mass": 1320.0, "cells": [16, 3]}
    if dimension == 3:
        post |= {"cells": [2, 2, 4], "thickness": 0.5}
        beam |= {"cells": [cells, 2, 2], "thickness": 0.5}
    blocks = [
        post | {"name": "a", "offset": -0.8},
        post | {"name": "b", "offset": 0.8},
        beam | {"name": "lintel", "on": ["a", "b"], "offset": 0.2},
    ]
    output = {"pairs": True, "fields": "none"}
    return {"dimension": dimension, "block": blocks, "time": {"end": 0.05}, "output": output}


@pytest.mark.parametrize(
    ("dimension", "width", "cells", "within"),
    [
        (2, 0.4, 0, 0.04),
        (3, 0.4, 8, 0.04),
        (2, 0.1, 0, 0.01),
        (3, 0.1, 22, 0.01),
        (3, 0.1, 8, 0.01),
    ],
)
def test_a_lintel_stands_on_both_posts(
    dimension: int, width: float, cells: int, within: float, tmp_path: Path
) -> None:
    """Reactions of a beam on two supports: its middle is 0.2 m off, and they are 1.6 m apart.

    Of supports where forces act to round-off; of those in the middles of thin posts to 1 %, also
    where a post is thinner than a cell of the lintel, and stands across a side between two cells.
    """
    result = simulate(parse_scene(lintel(dimension, width, cells)), folder=tmp_path)
    last = {name: result.history[f"{name}.normal_force_N"][-1] for name in ("a", "b", "lintel")}
    weight, posts = 1320.0 * G, 4000.0 * width * G
    assert last["lintel"] == pytest.approx(weight, rel=1e-6)
    assert last["a"] + last["b"] == pytest.approx(weight + posts, rel=1e-6)
    known = read_run(tmp_path).pairs()
    reactions = [known[name, "lintel"]["normal_N"][-1] for name in ("a", "b")]
    assert reactions == pytest.approx([0.375 * weight, 0.625 * weight], rel=within)
    centre = result.history["lintel.centre_x_m"][-1]
    arms = [known[name, "lintel"]["x_m"][-1] - centre for name in ("a", "b")]
    assert np.dot(reactions, arms) == pytest.approx(0.0, abs=1e-6 * weight)
    assert np.abs(np.add(arms, [1.0, -0.6])).max() < width / 2 + 1e-4
    assert result.summary["blocks"]["lintel"]["mode"] == "rest"


@pytest.mark.slow
@pytest.mark.parametrize(("amplitude", "end", "impact"), [(0.35, 0.9, True), (0.5, 0.9, False)])
def test_an_elastic_trilith_rocks_as_the_rigid_one(
    amplitude: float, end: float, impact: bool
) -> None:
    """Under half a sine: both columns lean within 2.5 % of the largest up to the first impact."""
    motion = {"kind": "half_sine", "amplitude_g": amplitude, "duration": 0.6}
    tables = scenes.trilith(friction=3.0, motion=motion)
    rigid = simulate(parse_scene(tables | {"time": {"end": end, "step": 1e-3}}))
    stone: dict[str, Any] = {"model": "elastic", "young": 2e10, "poisson": 0.2}
    for block in tables["block"]:
        block |= stone | {"cells": [12, 3] if block["name"] == "lintel" else [3, 8]}
    elastic = simulate(parse_scene(tables | {"time": {"end": end}}))
    assert elastic.summary["energy"]["largest_gain_fraction"] < 1e-6
    assert elastic.summary["energy"]["ledger_error_fraction"] < 1e-9
    time, known = elastic.history["time_s"], rigid.history["time_s"]
    for name in ("left", "right"):
        landed, expected = (
            [each["time_s"] for each in run.summary["blocks"][name]["impacts"]]
            for run in (elastic, rigid)
        )
        assert len(landed) == len(expected) == impact
        assert landed == pytest.approx(expected, rel=5e-3)
        before = time < min(expected, default=end)
        exact = np.interp(time, known, rigid.history[f"{name}.angle_rad"])
        error = (elastic.history[f"{name}.angle_rad"] - exact)[before]
        assert np.abs(error).max() < 0.025 * np.abs(exact).max()
    assert np.abs(elastic.history["lintel.angle_rad"]).max() < 2e-3


FRAME: dict[str, Any] = {
    **{"kind": "frame", "deck": {"width": 4.0, "height": 0.6}, "column": {"width": 0.1}},
    **{"storey": 3.0, "young": 3e10, "poisson": 0.2, "density": 2500.0},
    "cells": {"bay": 4, "column": 1, "deck": 1, "storey": 3},
    "damping": {"mass": 0.0, "stiffness": 2e-4},
}


def stacks() -> Scene:
    """Two stacks on a deck that pound as the deck shakes: the right one slips more."""
    stone: dict[str, Any] = {
        **{"model": "elastic", "young": 2e10, "poisson": 0.2, "cells": [2, 3]},
        **{"width": 0.5, "density": 2400.0},
    }
    blocks: list[dict[str, Any]] = []
    for k, friction in enumerate((0.4, 0.05)):
        low, top = f"low{k}", f"top{k}"
        blocks.append(stone | {"name": low, "height": 0.6, "offset": 0.503 * k - 0.25})
        blocks[-1]["friction"] = friction
        blocks.append(stone | {"name": top, "height": 0.5, "on": low, "friction": 0.4})
    motion = {"kind": "sine", "amplitude_g": 0.45, "period": 0.66, "cycles": 2}
    time = {"end": 0.3, "step": 1e-3, "adaptive": False}
    return parse_scene(
        {"plane": "stress", "block": blocks, "foundation": FRAME, "motion": motion, "time": time}
    )


@pytest.mark.slow
def test_momentum_of_stacks_that_pound_on_a_deck() -> None:
    """In each step: impulses on each block are its change of momentum, and so is the base shear."""
    case = stacks()
    assembly = build(case)
    stepper, (state, _) = assembly.stepper, initial_state(case, assembly)
    system, step = stepper.system, case.time.step
    mass = sum(body.mass for body in system.bodies)
    shears, left, met = [], [], 0.0
    for _ in range(300):
        new, exchange = stepper.advance(state, step)
        forces = exchange.ground or stepper.ground_forces(new)
        shaken = stepper.mean_base(state.time, step)
        inertia = system.directional_mass @ (new.v - state.v) / step + mass * shaken
        shears.append((-forces.total[0], -inertia[0]))
        given = np.zeros((len(system.bodies), 2))
        for push in exchange.pushes(homes=True):
            for number, sign in ((push.body, 1.0), (push.carrier, -1.0)):
                if number is not None:
                    given[number] += sign * push.impulse
            if {push.body, push.carrier} in ({0, 2}, {1, 3}):
                met += push.pressed
        for number, (body, own) in enumerate(system.members[:4]):
            needs = system.directional_mass[:, own] @ (new.v - state.v)[own]
            needs -= body.mass * step * (stepper.gravity - shaken)
            left.append(np.abs(given[number] - needs).max())
        state = new
    assert met > 10.0
    shear, exact = np.array(shears).T
    np.testing.assert_allclose(shear, exact, atol=1e-10 * np.abs(exact).max(), rtol=0)
    assert max(left) < 1e-10 * met
