"""Demos in short forms, and the public cases d1 to d4 of impacts that came out wrong."""

import math
import tomllib
from typing import Any

from tests.oracles import own
from tests.oracles.answers import FINER, agreed, quarter, rocks
from tests.oracles.motions import PEER, README
from tests.oracles.oracle import (
    CASES,
    REPOSITORY,
    Numbers,
    Oracle,
    closed,
    demo,
    program,
    today,
    word,
)
from tests.oracles.rigid_ground import RIGID

AUTO, WHOLE = {"foundation.modes": "auto"}, {"foundation.modes": None}
GROUND = {"foundation": {"kind": "rigid"}}
SPACE = {"dimension": 3, "plane": None, "block.cells": None, "time.step": 2e-4}
STEPS = {"steps of 2 ms": {"time.step": 2e-3}}
STL = str(REPOSITORY / "demos" / "museum" / "statue.stl")
DRIFT, SECOND = "platform.peak_drift_m", "platform.peak_drift_second_m"
SLIDES = {
    "peak 2": program(math.radians(1.780), README, abs=2e-4),
    "last block.slip_m": program(-28.0e-3, README, abs=2e-4),
}
EDGE = "angular momentum about the edge, then Housner's equation"


def case(name: str, numbers: Any, label: str = "", **changes: Any) -> Oracle:
    """A scene of ../shared/cases."""
    file = CASES / f"{name}.toml"
    base = tomllib.loads(file.read_text()) if file.exists() else {}
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    label = f"case {name}{label}"
    return Oracle(label, base, changes, numbers, needs=file)


def on_edge(gap: str) -> Any:
    """The lower edge stops at once; the block turns about it and lands on the other one."""

    def numbers() -> Numbers:
        time, half, phi = 2 / own.G, math.hypot(0.5, 1.0) / 2, math.atan(0.5) - math.radians(10)
        spin = -half * math.sin(phi) / (4 / 3 * half**2)
        answer = own.rocking(0.5, 1.0, 1.0, tilt_deg=10, spin=spin, e=0.8)
        return {
            "impact 1 time_s": program(time + answer.impacts[0], EDGE, rel=2e-3),
            f"block.{gap}_m at 0.25 s": closed(0.0, "no rebound of one edge alone", abs=1e-4),
        }

    return numbers


def platform() -> Numbers:
    """The squat block near the period of the platform."""
    answer = own.sliding(0.3, 3.0, ground=own.sine(0.4, 0.6, 6), platform=(2.0, 0.5, 0.05))
    name = "block on a platform, own ODE"
    return {
        DRIFT: program(answer.drift, name, rel=5e-3),
        "block.peak_slip_m": program(answer.peak_slip, name, rel=0.01),
    }


# fmt: off
ORACLES = [
    Oracle("foundation", demo("foundation"), {"time.end": 0.7},
        {**quarter(1e-3), "impact 1 restitution": today(0.936, abs=0.003)}, beside=FINER),
    Oracle("platform", demo("platform"), {"time.end": 3.0}, platform, slow=True),
    Oracle("stack under a record", demo("stack"), {"time.end": 2.2},
        agreed(5e-3, {DRIFT: 0.0950, "lower.peak_slip_m": 0.1004, "upper.peak_slip_m": 0.0441}),
        files={"record.AT2": PEER}, beside={"rigid blocks": RIGID, **FINER}, slow=True),
    Oracle("statue", demo("statue"),
        {"time.end": 1.7, "time.step": 1e-4, "statue.shape.file": STL}, agreed(2e-3, {
        "statue.peak_angle_rad": 0.09256, "statue impact 1 time_s": 1.5745,
        "statue.peak_turn_rad": 0.10053})
        | {"plinth.mode": word("rest"), "statue.mode": word("turn-rock")},
        beside={"steps of 0.2 ms": {"time.step": 2e-4}}, slow=True),
    Oracle("pedestal", demo("pedestal"), {"time.end": 8.0, "output.twin": False},
        agreed(5e-3, {"block.peak_angle_rad": 0.0674, "impact 1 time_s": 3.7988}),
        beside={"space": SPACE, "steps of 0.1 ms": {"time.step": 1e-4}}),
    Oracle("frame", demo("frame"), {},
        agreed(3e-3, {DRIFT: 4.387e-3, SECOND: 2.742e-3, "block.peak_slip_m": 0.2945}),
        beside={"rigid block": RIGID, "modes": AUTO, **STEPS}, slow=True),
    Oracle("laboratory", demo("laboratory"), {"time.end": 2.0, **AUTO},
        agreed(3e-3, {DRIFT: 0.01336, SECOND: 0.04134}) | {"block.mode": word("rest")},
        beside={"all of the mesh": WHOLE, "rigid block": RIGID}, slow=True),
    Oracle("yard", demo("yard"), {"time.end": 6.0, **AUTO}, agreed(6e-3, {
        DRIFT: 0.11115, "platform.peak_base_shear_N": 8.846e5, "container1.peak_slip_m": 0.3365}),
        beside={"all of the mesh": WHOLE, **FINER}, slow=True),
    case("d1_end_of_step", lambda: {
        "block.peak_slip_m": closed(0.0, "friction 0.65 holds the impact", abs=1e-6),
        **rocks(2, 2, 2e-4, size=(0.5, 1.0), tilt=5)()}),
    case("d2_held_plate", SLIDES),
    case("d2_held_plate", SLIDES, " on the ground", **GROUND),
    case("d2_held_plate", SLIDES, " in space", **GROUND, dimension=3),
    case("d3_decay", {"status": word("completed"), "end_s": closed(0.6, "time.end", abs=1e-9)}),
    case("d4_edge_rebound", on_edge("gap_2")),
    case("d4_edge_rebound", on_edge("gap_right"), " in the plane", dimension=2,
        block__velocity=[0.0, 1.0]),
]
