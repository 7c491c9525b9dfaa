"""Oscillators, platforms in space, plates, rollers, frames and reduced foundations."""

import math

from tests.oracles import own
from tests.oracles.answers import (
    FALLS,
    FINER,
    HALF,
    SLIDER,
    agreed,
    driven,
    falling,
    holds,
    pulse,
    quarter,
    rocks,
    stops,
    vertical,
)
from tests.oracles.oracle import Numbers, Oracle, changed, closed, demo, program, scene, today, word
from tests.oracles.rigid_ground import ELASTIC, GRANITE, JUMP, RIGID, SQUAT, THROWN, jumped
from tests.oracles.space import SQUARE
from tests.oracles.space import THROWN as THROWN_BOTH
from tests.oracles.stacks import PAIR

OSCILLATOR = {
    "foundation": {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
}
PLATE = scene("""
kind = "elastic"
width = 2.0
height = 0.3
density = 2400.0
young = 3.0e10
poisson = 0.2
cells = [16, 3]
""")
HELD = {"foundation": PLATE}
MESHED = {"foundation": {**PLATE, "meshed": True}}
BOTTOM = {"foundation": {**PLATE, "support": "bottom"}}
IN_SPACE = {"foundation": {**PLATE, "thickness": 2.0, "cells": [4, 4, 1]}}
ROLLERS = {"foundation": demo("suite", "plate")["foundation"]}
FRAME = scene("""
[[block]]
model = "rigid"
width = 0.8
height = 0.4
thickness = 0.5
mass = 400.0
friction = 0.2
young = 3.0e10
poisson = 0.2
cells = [4, 2]
[foundation]
kind = "frame"
bays = 2
storey = 2.0
young = 3.0e10
poisson = 0.2
density = 2500.0
damping_ratio = 0.05
deck = { width = 3.0, height = 0.2 }
column = { width = 0.1 }
cells = { bay = 4, column = 1, deck = 1, storey = 4 }
[time]
end = 0.5
step = 2.0e-3
""")
FRAME_IN_SPACE = changed(
    demo("frame"),
    {"damping": None, "foundation.damping_ratio": 0.05, "time.end": 0.5, **RIGID, "motion": None},
)
#: Masses of columns, deck and block, kg.
MASS = 2500 * 0.5 * (3.0 * 0.2 + 3 * 2.0 * 0.1) + 400
MASS_IN_SPACE = 2500 * (2.0 * 2.0 * 0.25 + 4 * 2.0 * 0.12**2) + 400
SINE = {**pulse("sine", 0.4, period=0.5, cycles=3), "time.end": 3.0}
ALONG_Y = {"motion": {"second": SINE["motion"]}, "time.end": 3.0}
DIAGONAL = {**pulse("sine", 0.4 * HALF, period=0.5, cycles=3), "time.end": 3.0}
DIAGONAL["motion.second"] = DIAGONAL["motion"]
LONG = {**OSCILLATOR, **pulse("sine", 0.45, period=0.6, cycles=6), "block.friction": FALLS}
TURNS = {**OSCILLATOR, "time.end": 0.7}
STUCK = {**pulse("half_sine", 0.4, duration=0.3), "block.friction": 5.0, "time.end": 0.5}
PUSH = pulse("half_sine", 0.6, duration=0.3)
PUSH_BOTH = pulse("half_sine", 0.3, duration=0.3)
PUSH_BOTH["motion.second"] = PUSH_BOTH["motion"]
AUTO, WHOLE = {"foundation.modes": "auto"}, {"foundation.modes": None}
STOREYS = {"foundation.storey": [{"height": 2.0, "extra_mass": 500.0}, {"height": 1.5}]}
FEET = {"foundation.feet": {"horizontal": 1e7, "vertical": 2e7}}
PLANE_AND_SPACE = {
    "in space": {"dimension": 3, "block.thickness": 1.0, "block.cells": None},
    "elastic, fixed steps": {**ELASTIC, "time.step": 1e-3},
}
AXIAL = "sum of first foundation.column_{{}}.axial_force_N to {}"


def one_way(column: str, share: float = 1.0) -> Numbers:
    """Drift of the platform along one of two directions."""
    drift = driven(1.0, 0.2)()["platform.peak_drift_m"].expected
    name = "block on a platform, own ODE"
    return {f"platform.peak_{column}_m": program(float(drift) * share, name, rel=5e-3)}


def on_platform(impacts: int, rel: float, ratio: float = 2.0) -> object:
    """Times of impacts on an oscillator of T 0.5 s."""
    return rocks(impacts, 0, rel, platform=(ratio, 0.5, 0.05))


def long_slip(end: float, rel: float) -> Numbers:
    """Slip with falling friction on the platform."""
    ground = own.sine(0.45, 0.6, 6)
    answer = own.sliding(falling, end, ground=ground, platform=(2.0, 0.5, 0.05))
    return {"block.peak_slip_m": program(answer.peak_slip, SLIDER, rel=rel)}


# fmt: off
ORACLES = [
    *(Oracle(f"oscillator, {name}", SQUAT, {**OSCILLATOR, **SINE, **changes}, numbers)
      for name, changes, numbers in (
        ("friction 0.1", {"block.friction": 0.1}, driven(3e-3, 0.1)),
        ("friction 0.3", {}, driven(3e-3, 0.3)),
        ("sticks", {"block.friction": 0.9}, driven(3e-3, 0.9)),
        ("the catalogue's", {**pulse("sine", 0.4, period=0.5, cycles=6), "block.friction": 0.2,
            "time.end": 8.0}, {
            "platform.peak_drift_m": program(0.06786, "verification.md, C 8", rel=1e-3),
            "last block.slip_m": program(0.03735, "verification.md, C 8", rel=5e-3)}),
        ("falling friction", {**LONG, "time.end": 5.0}, lambda: long_slip(5.0, 5e-3)),
        ("vertical motion", {"block.friction": 0.2, **vertical(0.3, 0.25)},
            driven(3e-3, 0.2, vertical=own.sine(0.3, 0.25))))),
    *(Oracle(f"base shear balances momentum, {name}", base, {**OSCILLATOR, **STUCK, **changes}, {
        "impulse of foundation.base_shear_N and 1500 kg times platform.velocity_m_s": closed(
            -1500 * 0.4 * own.G * 0.3 * 2 / math.pi, "of the ground: 2 A T/pi", rel=rel)})
      for name, base, changes, rel in (("plane", SQUAT, {}, 1e-9), ("space", SQUARE, {}, 1e-9),
        ("elastic, which still vibrates", SQUAT, ELASTIC, 1e-6))),
    *(Oracle(f"oscillator, elastic block{name}", SQUAT,
             {**OSCILLATOR, **SINE, **ELASTIC, **changes}, numbers, slow=True)
      for name, changes, numbers in (
        ("", {"block.friction": 0.2}, driven(5e-3, 0.2)),
        (", fixed steps", {"block.friction": 0.2, "time.step": 1e-3}, driven(5e-3, 0.2)),
        (", falling friction", LONG, lambda: long_slip(3.0, 0.01)))),
    *(Oracle(f"oscillator, {name}", GRANITE, {**TURNS, **changes}, numbers)
      for name, changes, numbers in (
        ("rocking", RIGID, on_platform(4, 1e-4)),
        ("restitution as told", RIGID, {"impact 1 restitution": closed(
            own.on_platform(0.25, 1.0, 2 / 3), "(R8) of docs/reference.md", abs=5e-3)}),
        ("light block rocks", {**RIGID, "foundation.mass_ratio": 0.5}, on_platform(4, 1e-4, 0.5)),
        ("elastic block rocks", {"block.damping": {"stiffness": 1e-3}, "time.end": 0.25},
            on_platform(1, 2e-3)))),
    Oracle("oscillator, the upper of two slides", PAIR,
        {**OSCILLATOR, **SINE, "lower.friction": 5.0},
        holds("mu 5", block="lower")
        | agreed(5e-3, {"upper.peak_slip_m": 0.1081, "platform.peak_drift_m": 0.09041}),
        beside=PLANE_AND_SPACE),
    *(Oracle(f"platform in space, {name}", SQUARE,
             {**OSCILLATOR, "block.friction": 0.2, **changes}, numbers)
      for name, changes, numbers in (
        ("diagonal", DIAGONAL, lambda: one_way("drift", HALF) | one_way("drift_second", HALF)),
        ("along y", ALONG_Y, lambda: one_way("drift_second") | {
            "platform.peak_drift_m": closed(0.0, "symmetry", abs=1e-9)}),
        ("elastic block", {**SINE, **ELASTIC, "time.step": 2e-3, "time.end": 1.2},
            driven(0.01, 0.2, end=1.2)))),
    *(Oracle(name, GRANITE, {**changes, "time.end": 0.9}, numbers) for name, changes, numbers in (
        ("held plate", {**RIGID, **HELD}, rocks(3, 2, 3e-4)),
        ("held plate, meshed", {**RIGID, **MESHED}, rocks(3, 2, 3e-4)))),
    Oracle("held plate, meshed, elastic block", GRANITE, {**MESHED, "time.end": 0.6},
        {**quarter(1e-3), "impact 1 restitution": today(0.936, abs=0.003)},
        beside={"the ground": {"foundation": {"kind": "rigid"}}}),
    Oracle("held plate in space", SQUARE, {**IN_SPACE, **THROWN_BOTH, "time.end": 0.5},
        {**stops(2e-3, 0.6), **stops(2e-3, 0.8, "slip_second_m")}),
    Oracle("plate on its bottom, elastic block", GRANITE,
        {**BOTTOM, "foundation.damping": {"stiffness": 1e-5}, "time.end": 0.6},
        {**quarter(2e-3), "impact 1 restitution": today(0.928, abs=0.006)},
        beside=FINER, slow=True),
    *(Oracle(name, SQUAT, changes, numbers) for name, changes, numbers in (
        ("held plate, slides off its end",
            {**HELD, "block.velocity": [4.0, 0.0], "block.friction": 0.1, "time.end": 2.0}, {
            "block.mode": word("fell", "4 m/s reach beyond 1 m"),
            "block.fell_at_s": closed(0.394, "1.5 m = v t - mu g t2/2", abs=0.015)}),
        ("plate on its bottom, rigid block slides", {**BOTTOM, **THROWN}, stops(5e-3)),
        ("plate on its bottom, reduced", {**BOTTOM, **THROWN, "foundation.modes": 10}, stops(5e-3)),
        ("rollers, rigid block sticks", {**ROLLERS, **SINE, "time.end": 1.5, "block.friction": 0.9},
            driven(5e-3, 0.9, end=1.5)),
        ("rollers, reduced", {**ROLLERS, **SINE, "time.end": 1.5, "block.friction": 0.9,
            "foundation.modes": 12}, driven(5e-3, 0.9, end=1.5)))),
    Oracle("held plate, friction that jumps", SQUAT, {**HELD, **JUMP}, jumped),
    Oracle("rollers, elastic block slides", SQUAT,
        {**ROLLERS, **ELASTIC, **SINE, "time.end": 1.5, "block.friction": 0.2},
        driven(0.01, 0.2, end=1.5), slow=True),
    Oracle("frame at rest", FRAME, {"time.end": 0.05}, {
        AXIAL.format(3): closed(MASS * own.G, "weight of all", rel=1e-3),
        "last block.normal_force_N": closed(400 * own.G, "m g", rel=1e-5),
        "last foundation.base_shear_N": closed(0.0, "symmetry", abs=1.0)}),
    Oracle("frame on springs of feet, at rest", FRAME, {**FEET, "time.end": 0.02}, {
        AXIAL.format(3): closed(MASS * own.G, "weight of all", rel=1e-3),
        "first energy.spring_J": closed(3 * (MASS * own.G / 3) ** 2 / 4e7, "N2/(2 k)", rel=0.1)}),
    Oracle("frame in space at rest", FRAME_IN_SPACE, {"time.end": 0.02}, {
        AXIAL.format(4): closed(MASS_IN_SPACE * own.G, "weight of all", rel=1e-3)}),
    Oracle("frame, block slides", FRAME, PUSH,
        agreed(5e-3, {"platform.peak_drift_m": 1.5012e-3, "platform.peak_base_shear_N": 10760.0,
                      "block.peak_slip_m": 0.1760}),
        beside={"modes": AUTO, "steps of 1 ms": {"time.step": 1e-3}}),
    Oracle("frame of two storeys", FRAME,
        {**pulse("one_sine", 0.4, duration=0.5), **STOREYS, "block.friction": 5.0},
        agreed(5e-3, {"platform.peak_drift_m": 4.1415e-3, "platform.peak_base_shear_N": 19897.0,
                      "platform.peak_storey_1_drift_m": 3.3198e-3}),
        beside={"modes": AUTO, "steps of 1 ms": {"time.step": 1e-3}}),
    Oracle("frame, reduced, elastic block", FRAME, {**PUSH, **ELASTIC, **AUTO},
        agreed(5e-3, {"platform.peak_drift_m": 1.5015e-3, "block.peak_slip_m": 0.1760}),
        beside={"all of the mesh": WHOLE, "rigid block": RIGID}),
    Oracle("frame in space, shaken both ways alike", FRAME_IN_SPACE,
        {**PUSH_BOTH, "contact.friction": 5.0},
        agreed(5e-3, {"platform.peak_drift_m": 4.1738e-3, "platform.peak_base_shear_N": 13159.0,
                      "platform.peak_drift_second_m": 4.1738e-3}),
        beside={"modes": AUTO, "steps of 2 ms": {"time.step": 2e-3}}, slow=True),
]
