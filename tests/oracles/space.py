"""One block on firm ground, in space: rigid and meshed."""

from tests.oracles import own
from tests.oracles.answers import (
    FALLS,
    FINER,
    HALF,
    curves,
    downhill,
    falling,
    first_swing,
    flown,
    moved,
    on_corner,
    onto_corner,
    pulse,
    quarter,
    rocks,
    slides,
    stops,
    tumbles,
    vertical,
)
from tests.oracles.oracle import Numbers, Oracle, changed, closed, program, word
from tests.oracles.rigid_ground import ELASTIC, GRANITE, RIGID, SQUAT, STANDS

COLUMN = changed(GRANITE, {"dimension": 3, **RIGID, "block.cells": [3, 2, 8], "time.end": 1.5})
SQUARE = changed(SQUAT, {"dimension": 3, "block.thickness": 1.0, "block.cells": [3, 3, 2]})
ACROSS = {"block.width": 0.75, "block.thickness": 0.25}
THROWN = {"block.velocity": [0.6, 0.8, 0.0]}
BOTH = {
    **pulse("half_sine", 0.5, duration=0.4),
    "motion.second": {"kind": "half_sine", "amplitude_g": 0.5, "duration": 0.4},
}
HALVES = {"kind": "half_sine", "amplitude_g": -0.5 * HALF, "duration": 0.3}
FREE = {**STANDS, "gravity": 0.0, "block.velocity": [0.0, 0.0, 3.0], "time.end": 1.0}
SPIN = "omega2 I/(2 mu m g r), r to the four corners"


def diagonal(rel: float) -> Numbers:
    """Equal pulses along x and y push a block along the diagonal."""
    slip = own.sliding(0.3, 1.0, ground=own.sine(0.5 / HALF, 0.8, 0.5)).peak_slip
    name = "sliding block along the diagonal, own ODE"
    return {
        "block.peak_slip_m": program(slip, name, rel=rel),
        "last block.slip_second_m": program(-slip * HALF, name, rel=rel),
    }


def both(rel: float) -> Numbers:
    """A block thrown along 3-4-5."""
    return {**stops(rel, 0.6), **stops(rel, 0.8, "slip_second_m")}


# fmt: off
ORACLES = [
    *(Oracle(name, COLUMN, changes, numbers) for name, changes, numbers in (
        ("rocks along x", {}, rocks(5, 4, 2e-4)),
        ("rocks along y", {**ACROSS, "block.tilt_direction_deg": 90.0}, rocks(5, 4, 2e-4)),
        ("rocks back, steps of 0.5 ms", {"block.tilt_direction_deg": 180.0, "time.step": 5e-4},
            rocks(5, 4, 5e-4)),
        ("restitution by key", {"block.restitution": 0.95}, rocks(4, 3, 5e-4, e=0.95)),
        ("released on a corner", {"block.thickness": 0.25, "block.tilt_direction_deg": 45.0,
            "block.friction": 2.0, "time.end": 0.4}, on_corner(0.25, 1.0)),
        ("elastic, released on a corner", {**ELASTIC, "block.thickness": 0.25,
            "block.tilt_direction_deg": 45.0, "block.friction": 10.0, "block.cells": [2, 2, 6],
            "block.damping": {"stiffness": 0.0}, "time.step": 5e-4, "time.end": 0.2},
            on_corner(0.25, 1.0, rel=5e-3)),
        ("two motions lift it onto a corner", {**STANDS, "block.thickness": 0.25,
            "block.friction": 10.0, "time.end": 0.3, "motion": HALVES | {"second": HALVES}},
            onto_corner(0.25, 1.0, 0.5, 0.3)),
        ("rocking under a pulse along y", {**STANDS, **ACROSS, "block.friction": 5.0, "motion": {
            "second": {"kind": "half_sine", "amplitude_g": 0.35, "duration": 0.4}}},
            lambda: moved("half_sine", 0.35, 1.5, duration=0.4)),
        ("rocking with vertical motion", {**vertical(0.3, 0.3), "time.end": 1.2},
            rocks(3, 2, 5e-4, vertical=own.sine(0.3, 0.3))),
        ("tumbles freely", {**FREE, "block.angular_velocity": [1.0, 2.0, 0.5], "time.step": 1e-3},
            lambda: tumbles([1.0, 2.0, 0.5], [0.25, 0.75, 1.0], 1.0)),
        ("spins freely, default steps", {**FREE, "block.angular_velocity": [0.0, 0.0, 10.0]}, {
            "last block.angular_velocity_z_rad_s": closed(10.0, "a principal axis", rel=1e-9),
            "last block.angle_z_rad": closed(10.0, "omega t", rel=2e-3)}))),
    *(Oracle(name, SQUARE, changes, numbers) for name, changes, numbers in (
        ("thrown along 3-4-5", THROWN, both(1e-4)),
        ("spins to rest", {"block.angular_velocity": [0.0, 0.0, 3.0]}, {
            "last block.angle_z_rad": closed(9 / 2 / (0.3 * own.G * HALF * 6), SPIN, rel=2e-3),
            "block.mode": word("turn"), "block.peak_slip_m": closed(0.0, "on the spot", abs=1e-6)}),
        ("pulses along x and y", BOTH, lambda: diagonal(5e-3)),
        ("thrown, ground accelerates across",
            {"block.velocity": [0.0, 1.5, 0.0], **pulse("rectangular", 0.2, duration=2.0)},
            lambda: curves(0.3, 0.2, 1.5, 1.0)),
        ("friction that decays", {**pulse("sine", 0.7, period=0.6, cycles=2), "time.end": 1.5,
            "block.friction": FALLS}, slides(5e-3, falling, 1.5, ground=own.sine(0.7, 0.6, 2))),
        ("cohesion", {**pulse("sine", 0.6, period=0.4, cycles=2),
            "block.friction": {"static": 0.3, "cohesion": 800.0}},
            slides(2e-3, 0.3, 1.0, cohesion=0.8, ground=own.sine(0.6, 0.4, 2))),
        ("incline, slides", {"gravity_tilt_deg": 20.0}, downhill(1e-4)),
        ("rebound of a flat landing", {"block.velocity": [0.0, 0.0, 1.0], "time.end": 0.25,
            "block.restitution": 0.6, "time.step": 1e-3}, {
            "last block.gap_1_m": closed(flown(0.6, 0.25 - 2 / own.G), "e v", abs=5e-5)}),
        ("elastic, thrown along 3-4-5", {**ELASTIC, **THROWN, "time.end": 0.5}, both(5e-3)),
        ("elastic, pulses along x and y, fixed steps", {**ELASTIC, **BOTH, "time.step": 2e-3},
            lambda: diagonal(0.01)),
        ("elastic, rests", {**ELASTIC, "time.end": 0.1}, {
            "last block.normal_force_N": closed(1000 * own.G, "m g", rel=1e-6),
            "block.mode": word("rest")}))),
    Oracle("elastic, rocks along x", COLUMN, {**ELASTIC, "time.end": 0.6},
           first_swing(0.929, 0.003), beside=FINER, slow=True),
    Oracle("elastic, tetrahedra", COLUMN, {**ELASTIC, "block.cell": "tetrahedron",
        "block.cells": [2, 2, 5], "time.end": 0.25}, quarter(2e-3), slow=True),
]
