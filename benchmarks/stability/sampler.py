"""Random scenes for the stability study, from the same ranges as its families, all at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random
from typing import Any

from benchmarks.stability.matrix import StabilityCase
from solver.study.scenes import Tables

CELL_STEPS = 20000
"""Cells times steps of a scene: what keeps it short."""


CROSSINGS = 1000
"""Times that sound crosses the smallest of meshed neighbours in a scene, at most."""


def draw(count: int, seed: int, *, later_keys: bool = True) -> list[StabilityCase]:
    """The first so many random scenes of a seed; a scene does not depend on how many follow it.

    Without `later_keys` they have none of the keys that came after the first seeds were drawn.
    """
    make = _with_later_keys if later_keys else _scene
    return [
        StabilityCase(family=f"random, seed {seed}", row=str(k), column="", tables=make(seed, k))
        for k in range(count)
    ]


def _with_later_keys(seed: int, number: int) -> Tables:
    """One random scene with keys that came later: default steps, beds, damping, neighbours."""
    scene, random = _scene(seed, number), Random(f"{seed}:{number}:later")
    if random.random() < 0.3:
        del scene["time"]["step"]
    if random.random() < 0.15:
        scene["contact"]["damping"] = random.uniform(0.0, 1.0)
        scene["contact"]["stiffness"] = _log(random, 1e6, 1e14)
    if random.random() < 0.15:
        scene["block"][-1]["damping"] = {"stiffness": _log(random, 1e-7, 1e-1)}
    if all(block["model"] == "rigid" for block in scene["block"]):
        for block in scene["block"]:
            block["restitution"] = _mixed(random, (1.0,), 0.01, 1.0)
    random = Random(f"{seed}:{number}:neighbours")
    if random.random() < 0.25:
        for block in scene["block"]:
            block["model"] = "rigid"
        _add_neighbours(random, scene, meshed=False)
    elif Random(f"{seed}:{number}:meshed neighbours").random() < 0.4:
        for block in scene["block"]:
            block.pop("restitution", None)
        _add_neighbours(random, scene, meshed=True)
        if "step" not in scene["time"]:  # adaptive steps follow the waves
            crossings = (
                min(block["width"], block["height"]) * math.sqrt(block["density"] / block["young"])
                for block in scene["block"]
                if block["model"] == "elastic"
            )
            longest = CROSSINGS * min(crossings, default=math.inf)
            scene["time"]["end"] = min(scene["time"]["end"], longest)
    return scene


def _add_neighbours(random: Random, scene: Tables, *, meshed: bool) -> None:
    """Add some blocks beside the others and above them: rigid ones, or of any kind."""
    lowest = scene["block"][0]
    width, height, depth = (lowest[key] for key in ("width", "height", "thickness"))
    plane, edge = scene["dimension"] == 2, 0.5 * width
    for number in range(random.randint(1, 4)):
        wide, high = (size * _log(random, 0.2, 1.5) for size in (width, height))
        middle = edge + width * _mixed(random, (0.0, 1e-6), 0.0, 1.0) + 0.5 * wide
        edge = middle + 0.5 * wide
        x, level = middle, 0.5 * high
        if random.random() < 0.3:
            x, level = random.uniform(-0.5, 0.5) * width, (1.5 + 2 * number) * 3 * height
        block = _block(random, scene["dimension"], "") if meshed else {"model": "rigid"}
        block |= {
            **{"name": f"n{number}", "width": wide, "height": high},
            **{"thickness": depth, "density": _log(random, 1.0, 2e4)},
            "position": [x, level] if plane else [x, 0.0, level],
        }
        if random.random() < 0.5:
            block["velocity"] = [random.uniform(-2.0, 2.0), *(0.0,) * (scene["dimension"] - 1)]
        scene["block"].append(block)


def _scene(seed: int, number: int) -> Tables:
    """One random scene."""
    random = Random(f"{seed}:{number}")
    dimension = 2 if random.random() < 0.8 else 3
    blocks = _blocks(random, dimension)
    step = _log(random, 1e-6, 5e-2)
    cells = sum(math.prod(block["cells"]) * block["degree"] ** dimension for block in blocks)
    end = step * max(20, min(300, CELL_STEPS // cells))
    scene: Tables = {
        "dimension": dimension,
        "block": blocks,
        "contact": _contact(random),
        "time": {"end": end, "step": step, "rho_inf": _mixed(random, (0.0, 1.0), 0.0, 1.0)},
    }
    if random.random() < 0.1:
        scene["gravity"] = random.choice([0.0, 0.1, 100.0])
    if random.random() < 0.1:
        scene["gravity_tilt_deg"] = random.uniform(-45.0, 45.0)
    damped = random.random() < 0.3
    scene["damping"] = {"stiffness": _log(random, 1e-7, 1e-1) if damped else 0.0}
    if random.random() < 0.6:
        scene["motion"] = _motion(random, end)
        if random.random() < 0.3:
            scene["motion"]["vertical"] = _motion(random, end)
    if random.random() < 0.5:
        scene["foundation"] = _foundation(random, dimension, blocks[0])
    return scene


def _log(random: Random, low: float, high: float) -> float:
    """A number between two, even in its logarithm."""
    return math.exp(random.uniform(math.log(low), math.log(high)))


def _mixed(random: Random, special: Sequence[float], low: float, high: float) -> float:
    """Half of the time one of some special values, else any between two."""
    return random.choice(special) if random.random() < 0.5 else random.uniform(low, high)


def _blocks(random: Random, dimension: int) -> list[Tables]:
    """One block, or a stack of two or three in the plane."""
    lowest = _block(random, dimension, "b1")
    height, slender = _log(random, 0.01, 100.0), _log(random, 0.1, 30.0)
    lowest |= {"height": height, "width": height / slender}
    lowest["thickness"] = lowest["width"] * random.uniform(0.5, 2.0)
    if random.random() < 0.5:
        alpha = math.degrees(math.atan(1 / slender))
        lowest["tilt_deg"] = alpha * _mixed(random, (-0.999, 0.999, 1.001), -1.0, 1.0)
        if dimension == 3:
            lowest["tilt_direction_deg"] = random.choice([0.0, 90.0, random.uniform(0.0, 360.0)])
    blocks = [lowest]
    count = random.choices([1, 2, 3], [0.6, 0.25, 0.15])[0] if dimension == 2 else 1
    for number in range(2, count + 1):
        below = blocks[-1]
        block = _block(random, dimension, f"b{number}")
        block["on"] = below["name"]
        block |= {key: below[key] * random.uniform(0.4, 1.0) for key in ("width", "height")}
        block["thickness"] = below["thickness"]
        block["offset"] = below["width"] * random.uniform(-0.3, 0.3)
        blocks.append(block)
    return blocks


def _block(random: Random, dimension: int, name: str) -> Tables:
    """Material and mesh of a block."""
    shapes = ["quadrilateral", "triangle"] if dimension == 2 else ["hexahedron", "tetrahedron"]
    most = 6 if dimension == 2 else 3
    nearly = 0.5 * (1 - 10 ** random.uniform(-3.7, 0.0))
    return {
        "name": name,
        "density": _log(random, 1.0, 2e4),
        "model": "rigid" if random.random() < 0.3 else "elastic",
        "young": _log(random, 1e5, 1e13),
        "poisson": random.choice([0.0, nearly, random.uniform(0.0, 0.4)]),
        "cells": [random.randint(1, most) for _ in range(dimension)],
        "cell": random.choice(shapes),
        "degree": 2 if random.random() < 0.25 else 1,
        "refinement": 1.0 if random.random() < 0.7 else _log(random, 1.0, 100.0),
    }


def _contact(random: Random) -> Tables:
    """Contact and friction."""
    friction: Any = _mixed(random, (0.0, 0.3, 1000.0), 0.0, 2.0)
    if random.random() < 0.2:
        friction = {"static": friction, "cohesion": _log(random, 1.0, 1e7)}
    elif random.random() < 0.3 and friction > 0:
        friction = {"static": friction, "dynamic": friction * random.uniform(0.0, 0.95)}
        friction["decay"] = random.choice([0.0, _log(random, 0.1, 1e5)])
    return {
        "friction": friction,
        "gamma": random.choice([100.0, _log(random, 1.0, 1e4)]),
        "theta": random.choice([1, 1, 0, -1]),
        "points": random.choice(["nodes", "gauss"]),
    }


def _motion(random: Random, end: float) -> Tables:
    """A motion of the ground that fits into the run."""
    kind = random.choice(["sine", "half_sine", "one_sine", "rectangular", "ricker"])
    length = "period" if kind == "sine" else "duration"
    part = random.uniform(0.1, 1.0)
    return {"kind": kind, "amplitude_g": _log(random, 0.05, 10.0), length: part * end}


def _foundation(random: Random, dimension: int, lowest: Tables) -> Tables:
    """A platform on a spring, or a plate."""
    if random.random() < 0.6:
        return {
            "kind": "oscillator",
            "mass_ratio": _log(random, 1e-2, 1e2),
            "period": _log(random, 1e-2, 10.0),
            "damping_ratio": random.choice([0.0, 0.05]),
        }
    support = random.choice(["fixed", "bottom", "rollers"])
    plate = {
        "kind": "elastic",
        "width": lowest["width"] * random.uniform(1.2, 4.0),
        "height": lowest["width"] * random.uniform(0.2, 1.0),
        "density": _log(random, 100.0, 1e4),
        "young": _log(random, 1e6, 1e13),
        "poisson": random.uniform(0.0, 0.4),
        "cells": [random.randint(2, 8), 2] if dimension == 2 else [3, 3, 1],
        "support": support,
    }
    if dimension == 3:
        plate["thickness"] = lowest["thickness"] * random.uniform(1.2, 4.0)
    if support == "rollers":
        plate |= {"period": _log(random, 1e-2, 10.0), "damping_ratio": 0.05}
    return plate
