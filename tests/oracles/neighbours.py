"""Bodies side by side: impacts, dominoes, a lintel; rigid and meshed."""

import math
from typing import Any

from tests.oracles import own
from tests.oracles.oracle import Numbers, Oracle, Tables, closed, program, word

MATTER = {"model": "rigid", "young": 5e9, "poisson": 0.2, "cells": [12, 2]}
STOPS = (4 - 0.4 * 0.1 * own.G) / (8 * 0.1 * own.G)
PROTOTYPE = "../shared/prototypes/general at three steps; MuJoCo within 2e-3"


def row(pitch: float, masses: tuple[float, ...], **keys: Any) -> list[Tables]:
    """Blocks side by side, n1 from the left."""
    return [
        {"name": f"n{k + 1}", "mass": mass, "offset": k * pitch, **MATTER, **keys}
        for k, mass in enumerate(masses)
    ]


def thrown(friction: float, *masses: float) -> Tables:
    """Two blocks 0.2 m apart, the left one thrown at the other with 2 m/s."""
    blocks = row(1.2, masses, width=1.0, height=0.5, friction=friction)
    blocks[0]["velocity"] = [2.0, 0.0]
    return {"block": blocks, "time": {"end": 0.5}}


def past(*times: float) -> Numbers:
    """Times at which dominoes pass 20 degrees."""
    return {
        f"time of n{k}.angle_rad past {math.radians(20):.7f}": program(time, PROTOTYPE, abs=1e-3)
        for k, time in enumerate(times, 1)
    }


def ended(first: float, second: float, law: str, within: float = 2e-3) -> Numbers:
    """Displacements of two blocks at the end, m."""
    return {
        "last n1.centre_x_m": closed(first, law, abs=within),
        "last n2.centre_x_m": closed(1.2 + second, law, abs=within),
    }


DOMINOES: Tables = {
    "block": row(0.4, 5 * (200.0,), width=0.1, height=1.0, friction=0.5),
    "time": {"end": 1.8, "step": 1e-3},
}
DOMINOES["block"][0]["tilt_deg"] = 8.0
SLENDER = {
    "block.model": "elastic",
    "block.damping": {"stiffness": 0.0},
    "block.poisson": 0.0,
    "block.height": 0.1,
    "block.cells": [48, 2],
}
TRANSIT = 2.0 * 1.0 / math.sqrt(5e9 / 10000.0)  # v L/c: while they touch, 2 L/c, v falls evenly
POST = {**MATTER, "width": 0.4, "height": 1.0, "mass": 800.0}
TRILITH: Tables = {
    "block": [
        {**POST, "name": "a", "offset": -0.8},
        {**POST, "name": "b", "offset": 0.8},
        {**MATTER, "name": "lintel", "on": ["a", "b"], "width": 2.2, "height": 0.3, "mass": 1320.0},
    ],
    "time": {"end": 0.2},
}

# fmt: off
ORACLES = [
    *(Oracle(name, thrown(friction, *masses), changes, numbers)
      for name, friction, masses, changes, numbers in (
        ("plastic impact, 30 kg on 70 kg", 0.0, (30.0, 70.0), {},
            ended(0.2 + 0.24, 0.24, "momentum: 0.6 m/s")),
        ("the same with friction", 0.1, (50.0, 50.0), {"time.end": 1.5},
            ended(0.2 + STOPS, STOPS, "both slide on with half the speed")))),
    Oracle("elastic bars exchange their velocities", thrown(0.0, 1000.0, 1000.0),
        {**SLENDER, "time.end": 0.13},
        ended(0.2 + TRANSIT, 0.06 - TRANSIT, "waves in equal bars, within 1 %", 6e-4)),
    Oracle("five dominoes", DOMINOES, {}, past(0.72633, 1.10477, 1.33693, 1.51517, 1.65475)),
    Oracle("first domino before its blow", DOMINOES, {}, {
        "time of n1.angle_rad past 0.2617994": program(0.5433, "Housner's equation", abs=5e-4)}),
    Oracle("three elastic dominoes", DOMINOES, {"block.model": "elastic", "block.young": 5e10,
        "block.cells": [2, 12], "time": {"end": 0.8}}, {
        f"time of n1.angle_rad past {math.radians(20):.7f}": program(
            0.72633, "the rigid engine; it slips and hops as it strikes", rel=0.01)}),
    Oracle("elastic lintel on two posts", TRILITH, {"block.model": "elastic"}, {
        "lintel.mode": word("rest"),
        "last lintel.normal_force_N": closed(1320 * own.G, "weight", rel=1e-6),
        "last a.normal_force_N": closed(1460 * own.G, "half of the weight", rel=1e-6)}),
    Oracle("lintel on two posts", TRILITH, {}, {"lintel.mode": word("rest"),
        "last a.normal_force_N + b.normal_force_N": closed(2920 * own.G, "weight", rel=1e-9)}),
]
