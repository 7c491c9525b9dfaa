"""One meshed block on firm ground, in the plane: rocking, sliding, damping, meshes, steps, beds."""

import math

from tests.oracles import own
from tests.oracles.answers import (
    FALLS,
    FINER,
    P,
    downhill,
    falling,
    first_swing,
    flown,
    half_sine_at,
    holds,
    newmark,
    on_bed,
    pulse,
    quarter,
    slides,
    stops,
    vertical,
)
from tests.oracles.oracle import Oracle, closed, program, word
from tests.oracles.rigid_ground import (
    BOTH,
    BOUND,
    ELASTIC,
    GRANITE,
    NO_SLIP,
    PUSHED,
    SQUAT,
    STANDS,
    THROWN,
)

#: A bar without damping, and sqrt(E/rho), m/s.
BAR = {
    "plane": "stress",
    "gravity": 0.0,
    "block.young": 5e9,
    "block.poisson": 0.0,
    "block.cells": [2, 32],
    "block.damping": {"stiffness": 0.0},
    "block.velocity": [0.0, -0.5],
    "time.end": 0.02,
}
BAR_SPEED = math.sqrt(5e9 * 0.25 * 0.75 / 503)
MESH = {"12 x 32 cells": {"block.cells": [12, 32]}}
SHORT = {"time.end": 0.6}
BED = {"block.friction": 0.0, "contact.stiffness": 4e7, "block.velocity": [0.0, 0.5]}


def most(times: float) -> float:
    """Peak of the granite block under so much of the half sine that overturns it."""
    ground = own.sine(times * 1.8015 * 0.25, math.pi / P, 0.5)
    return max(own.rocking(0.25, 1.0, 3.0, ground=ground).peaks)


# fmt: off
ORACLES = [
    Oracle("free rocking, defaults", GRANITE, {"time.end": 1.5}, first_swing(0.936, 0.003, 3),
           beside=FINER | MESH, slow=True),
    *(Oracle(f"free rocking, {name}", GRANITE, {**SHORT, **changes}, first_swing(e, spread),
             beside=beside) for name, changes, e, spread, beside in (
        ("beta_R 1e-4 s", {"block.damping": {"stiffness": 1e-4}}, 0.9296, 0.002, FINER),
        ("beta_R 1e-3 s", {"block.damping": {"stiffness": 1e-3}}, 0.937, 0.003, FINER | MESH),
        ("plane stress, triangles", {"plane": "stress", "block.cell": "triangle"}, 0.9317, 0.004,
            FINER),
        ("degree 2", {"block.degree": 2, "block.cells": [3, 8]}, 0.938, 0.004, FINER),
        ("refined corners", {"block.refinement": 3.0}, 0.937, 0.003, FINER),
        ("theta 0", {"contact.theta": 0}, 0.936, 0.004, {"theta -1": {"contact.theta": -1}}),
        ("gamma 1000", {"contact.gamma": 1000.0}, 0.936, 0.004, FINER))),
    *(Oracle(name, GRANITE, changes, numbers) for name, changes, numbers in (
        ("free rocking, damping of mass too",
            {"time.end": 0.9, "block.damping": {"mass": 0.5, "stiffness": 3.65e-5}},
            first_swing(0.936, 0.0, 2, drag=0.5)),
        ("free rocking, vertical motion", {**vertical(0.3, 0.3), **SHORT},
            first_swing(0.936, 0.0, vertical=own.sine(0.3, 0.3))),
        ("free rocking, fixed steps", {"time.step": 5e-4, "time.end": 0.45}, quarter(3e-3)),
        ("free rocking, adaptive from a step", {"time.step": 1e-3, "time.adaptive": True, **SHORT},
            quarter(1e-3)),
        ("rests", {**STANDS, "time.end": 0.2}, {
            "last block.normal_force_N": closed(503 * own.G, "m g", rel=1e-6),
            "block.mode": word("rest"), **holds("symmetry")}),
        ("begins without stress", {**STANDS, "time.end": 0.2, "time.initial": "unstressed"}, {
            "last block.normal_force_N": closed(503 * own.G, "m g once it is damped", rel=2e-3)}),
        ("bar that bounces", {**STANDS, **BAR}, {"last block.centre_y_m": closed(
            0.5 + 0.5 * (0.02 - 2 / BAR_SPEED), "v (t - 2 H/c): no wave is left", abs=3e-4)}),
        ("half sine, stays", {**NO_SLIP, **half_sine_at(0.95), "time.end": 1.6}, lambda: {
            "block.peak_angle_rad": program(most(0.95), "Housner's equation, own ODE", rel=0.01)}),
        ("half sine, overturns",
            {**NO_SLIP, **half_sine_at(1.01), "time.end": 3.0, "time.stop": "overturned"},
            {"block.mode": word("overturned", "threshold of the rigid block")}),
        ("flight", {**STANDS, "block.velocity": [1.5, 3.0], "time.end": 0.5}, {
            "last block.centre_x_m": closed(0.75, "v t", rel=1e-4), "block.mode": word("hop"),
            "last block.centre_y_m": closed(0.5 + flown(3.0, 0.5), "v t - g t2/2", rel=1e-4)}),
        ("spin without gravity", {**STANDS, "gravity": 0.0, "block.velocity": [0.0, 3.0],
            "block.angular_velocity": 2.0, "time.end": 0.5}, {
            "last block.angle_rad": closed(1.0, "omega t", rel=1e-3),
            "last block.centre_y_m": closed(2.0, "v t", rel=1e-4)}))),
    *(Oracle(name, SQUAT, {**ELASTIC, **changes}, numbers) for name, changes, numbers in (
        ("thrown along the ground", THROWN, {**stops(3e-3), "block.mode": word("slide")}),
        ("thrown, points of Gauss", {**THROWN, "contact.points": "gauss"}, stops(3e-3)),
        ("thrown, fixed steps", {**THROWN, "time.step": 1e-3}, stops(5e-3)),
        ("thrown, rho_inf 1", {**THROWN, "time.rho_inf": 1.0, "time.step": 5e-4}, stops(5e-3)),
        ("incline, slides", {"gravity_tilt_deg": 20.0, "time.end": 0.5}, downhill(3e-3, 0.5)),
        ("incline, holds just so", {"gravity_tilt_deg": 16.0}, {
            **holds("tan b < mu", 1e-6), "block.mode": word("rest")}),
        ("rectangular pulse, slides", PUSHED, newmark(5e-3, 0.3, 0.6, 0.2)),
        ("vertical motion, slides", BOTH, slides(
            0.01, 0.3, 1.0, ground=own.sine(0.5, 1.0, 0.5), vertical=own.sine(0.4, 0.25))),
        ("cohesion that holds", {**pulse("half_sine", 0.5, duration=0.2), "time.end": 0.4,
            "block.friction": {**BOUND, "cohesion": 4000.0}},
            holds("c A + mu m g = 1.4 m a", 2e-5)),
        ("cohesion that is lost", {**PUSHED, "block.friction": {**BOUND, "cohesion": 2500.0}},
            newmark(0.01, 0.3, 0.6, 0.2)),
        ("lands on a bed, 0.1 of critical", {**BED, "contact.damping": 0.1, "time.end": 0.15},
            lambda: on_bed(0.1, 0.15)),
        ("lands on a bed, 0.3 of critical", {**BED, "contact.damping": 0.3, "time.end": 0.14},
            lambda: on_bed(0.3, 0.14)))),
    Oracle("restitution as told, damping of mass too", GRANITE,
        {**SHORT, "block.damping": {"mass": 0.5, "stiffness": 3.65e-5}},
        {"impact 1 restitution": closed(0.936, "with it the impacts follow Housner", abs=4e-3)}),
    Oracle("sine, slides, falling friction", SQUAT, {**ELASTIC, "block.friction": FALLS,
        **pulse("sine", 0.7, period=0.6, cycles=2), "time.end": 1.5},
        slides(0.01, falling, 1.5, ground=own.sine(0.7, 0.6, 2)), slow=True),
]
