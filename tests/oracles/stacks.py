"""Two to four blocks on one another, rigid, meshed and mixed, in the plane and in space."""

import math

from tests.oracles import own
from tests.oracles.answers import flown, holds, newmark, pulse, quarter, rocks
from tests.oracles.oracle import Numbers, Oracle, Tables, closed, program, scene, word
from tests.oracles.rigid_ground import ELASTIC

#: A slender block on a wide and heavy one, which does not move.
STATUE = scene("""
[[block]]
name = "plinth"
model = "rigid"
width = 3.0
height = 0.5
density = 2600.0
young = 5.0e10
poisson = 0.2
cells = [24, 4]
friction = 2.0
[[block]]
name = "statue"
on = "plinth"
model = "rigid"
width = 0.25
height = 1.0
density = 2600.0
young = 5.0e10
poisson = 0.2
tilt_deg = 3.0
friction = 0.7
[time]
end = 1.0
""")
#: Two squat ones that slide.
PAIR = scene("""
[[block]]
name = "lower"
model = "rigid"
width = 1.0
height = 0.3
mass = 800.0
young = 5.0e10
poisson = 0.2
cells = [6, 2]
friction = 0.5
[[block]]
name = "upper"
on = "lower"
model = "rigid"
width = 0.6
height = 0.3
mass = 200.0
young = 5.0e10
poisson = 0.2
cells = [4, 2]
friction = 0.2
[time]
end = 1.0
""")
MATTER = {"young": 3e10, "poisson": 0.2, "cells": [4, 3], "friction": 0.5, "model": "rigid"}
#: Width, mass, offset of each of four unequal ones.
SIZES = ((0.8, 300.0, 0.0), (0.5, 900.0, 0.1), (0.9, 50.0, -0.05), (0.4, 400.0, 0.1))
FOUR: Tables = {
    "block": [
        {"name": f"b{k}", "width": width, "height": 0.4, "mass": mass, "offset": offset, **MATTER}
        | ({"on": f"b{k - 1}"} if k else {})
        for k, (width, mass, offset) in enumerate(SIZES)
    ],
    "time": {"end": 0.3},
}
SPACE = {"dimension": 3, "block.thickness": 0.5, "block.cells": None}
SHAKEN = pulse("rectangular", 0.4, duration=0.2)
AS_ONE = {**SHAKEN, "lower.friction": 0.2, "upper.friction": 0.5}
THIN = {"lower.cells": [3, 2, 1], "upper.cells": [2, 2, 1], "time.step": 2e-3, "time.end": 0.7}
DRAG = 0.8 / (0.2 * own.G)


def rests(spread: float, creep: float) -> Numbers:
    """Four blocks whose interfaces carry what is above."""
    above = enumerate((1650, 1350, 450, 400))
    forces = {
        f"last b{k}.normal_force_N": closed(own.G * mass, "weight above", rel=spread)
        for k, mass in above
    }
    return forces | holds("nothing pushes", creep, "b1") | holds("nothing pushes", creep, "b3")


def swing(rel: float) -> Numbers:
    """First impact of the statue."""
    return {**quarter(rel, "statue"), "plinth.mode": word("rest")}


# fmt: off
ORACLES = [
    *(Oracle(name, STATUE, changes, numbers) for name, changes, numbers in (
        ("rocks on a block that rests", {}, rocks(3, 3, 2e-5, block="statue")),
        ("the same with restitution", {"statue.restitution": 0.95},
            rocks(3, 3, 2e-5, block="statue", e=0.95)),
        ("the same in space", SPACE, rocks(3, 3, 3e-4, block="statue")),
        ("elastic on rigid", {"statue.model": "elastic", "time.end": 0.3}, swing(1e-3)),
        ("rigid on elastic", {"plinth.model": "elastic", "time.end": 0.3}, swing(3e-3)),
        ("elastic on elastic", {**ELASTIC, "time.end": 0.3}, swing(3e-3)),
        ("two that lean together, as one block", {"block.width": 0.25, "plinth.tilt_deg": 3.0,
            "statue.tilt_deg": 0.0, "time.end": 0.3}, quarter(1e-4, "plinth", 1.5)))),
    Oracle("elastic on elastic in space", STATUE, {**SPACE, **ELASTIC, "plinth.cells": [12, 2, 2],
        "statue.cells": [3, 2, 6], "time.end": 0.25}, swing(5e-3), slow=True),
    *(Oracle(name, PAIR, changes, numbers) for name, changes, numbers in (
        ("upper one slides", SHAKEN,
            newmark(1e-3, 0.2, 0.4, 0.2, "upper") | holds("mu 0.5 > 0.4", block="lower")),
        ("both slide as one", AS_ONE,
            newmark(1e-3, 0.2, 0.4, 0.2, "lower") | holds("mu larger than below", block="upper")),
        ("heavy on light, slide as one", {**AS_ONE, "lower.mass": 1.0, "upper.mass": 1e4},
            newmark(1e-3, 0.2, 0.4, 0.2, "lower")),
        ("upper one drags the lower", {"lower.friction": 0.0, "upper.velocity": [1.0, 0.0]}, {
            "last lower.slip_m": closed(0.2 * (1 - DRAG / 2), "0.2 m/s after 0.8/(mu g)", rel=1e-4),
            "last upper.slip_m": closed(DRAG / 2, "v2/(2 mu g (1 + m/M))", rel=1e-4)}),
        ("lands on a block", {"upper.velocity": [0.0, 1.0], "upper.restitution": 0.5,
            "lower.restitution": 1.0, "time.end": 0.28}, {
            "last upper.gap_left_m": closed(flown(0.5, 0.28 - 2 / own.G), "e v", abs=5e-5)}),
        ("falls off a block",
            {"upper.velocity": [2.0, 0.0], "upper.friction": 0.05, "time.end": 2.0},
            {"upper.mode": word("fell", "2 m/s reach 4 m, the edge is at 0.8 m")}),
        ("overhangs too far", {"upper.offset": 0.51, "time.end": 1.5}, {
            "upper.mode": word("fell", "its centre is beyond the edge")}),
        ("overhangs just not too far", {"upper.offset": 0.49}, {
            "upper.mode": word("rest", "its centre is within the edge")}),
        ("friction that decays between blocks",
            {**pulse("half_sine", 0.6, duration=0.3), "lower.friction": 2.0,
             "upper.friction": {"static": 0.4, "dynamic": 0.2, "decay": 10.0}},
            lambda: {"upper.peak_slip_m": program(own.sliding(
                lambda v: 0.2 * (1 + math.exp(-10 * v)), 1.0, ground=own.sine(0.6, 0.6, 0.5),
            ).peak_slip, "sliding block, own ODE", rel=5e-3)}))),
    Oracle("elastic upper one slides", PAIR, {**SHAKEN, **ELASTIC},
        newmark(5e-3, 0.2, 0.4, 0.2, "upper") | holds("mu 0.5 > 0.4", 1e-5, "lower"), slow=True),
    Oracle("elastic ones slide as one, in space", PAIR, {**AS_ONE, **ELASTIC, **SPACE, **THIN},
        newmark(0.01, 0.2, 0.4, 0.2, "lower"), slow=True),
    *(Oracle(name, FOUR, changes, numbers) for name, changes, numbers in (
        ("four unequal ones rest", {}, rests(1e-9, 1e-10)),
        ("four rest under less than friction", pulse("half_sine", 0.15, duration=0.1), {
            f"b{k}.mode": word("rest", "0.15 < mu and < B/H of all above") for k in range(4)}),
        ("four rest in space", SPACE, rests(1e-9, 1e-10)),
        ("four elastic ones rest", ELASTIC, rests(1e-5, 1e-6)),
        ("four, every second one elastic", {"b0.model": "elastic", "b2.model": "elastic"},
            rests(1e-5, 1e-6)))),
]
