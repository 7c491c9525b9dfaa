"""One rigid block on firm ground, in the plane: rocking, sliding, friction laws, impacts."""

import math

from tests.oracles import own
from tests.oracles.answers import (
    FALLS,
    downhill,
    falling,
    flown,
    half_sine_at,
    holds,
    moved,
    newmark,
    pulse,
    rocks,
    slides,
    stops,
    vertical,
)
from tests.oracles.oracle import Oracle, closed, scene, word

GRANITE = scene("""
[[block]]
width = 0.25
height = 1.0
thickness = 0.75
mass = 503.0
young = 5.0e10
poisson = 0.2
tilt_deg = 3.0
friction = 0.7
[time]
end = 2.0
""")
#: So squat that it slides.
SQUAT = scene("""
[[block]]
model = "rigid"
width = 1.0
height = 0.5
mass = 1000.0
young = 5.0e10
poisson = 0.2
cells = [6, 4]
friction = 0.3
[time]
end = 1.0
""")
RIGID, ELASTIC = {"block.model": "rigid"}, {"block.model": "elastic"}
STANDS = {"block.tilt_deg": 0.0}
NO_SLIP = {**STANDS, "block.friction": 5.0}
THROWN = {"block.velocity": [1.0, 0.0]}
UP = {"block.velocity": [0.0, 1.0]}
PUSHED = pulse("rectangular", 0.6, duration=0.2)
BOTH = {**pulse("half_sine", 0.5, duration=0.5), **vertical(0.4, 0.25)}
ONSET = {**STANDS, **pulse("rectangular", 0.5, duration=1.0), "time.end": 4e-3, "time.step": 1e-4}
BOUND = {"cohesion_lost": True, "static": 0.3}
JUMP = {
    **pulse("half_sine", 0.6, duration=0.3),
    "block.friction": {"static": 0.4, "dynamic": 0.3},
}
jumped = slides(2e-3, 0.3, 1.0, static=0.4, ground=own.sine(0.6, 0.6, 0.5))
ROCK = -0.004 * 0.75 * own.G * (0.5 * 0.5 - 0.125) / (0.125**2 + 0.25)
SLIDE_ROCK = -0.004 * 3 * own.G * (0.28 * 4 - 1) / (0.125 * (4 + 16 - 3 * 0.28 * 4))
THRESHOLD = "nonlinear threshold 1.8015 g tan alpha at omega/p 2"
MOON = math.sqrt(own.G / 1.62)
HANGS = {"between": ["block", "foundation"], "at": [0.0, 0.5], "to": [0.0, 5.0], "stiffness": 1e5}
WAX = {**HANGS, "kind": "wax", "at": [0.0, 0.0], "strength": 1e3, "stiffness": 1e8}
WAX = {key: value for key, value in WAX.items() if key != "to"}
FORCE = {"on": "block", "at": [0.0, 0.0], "force": [6e3, 0.0], "ramp": [0.0, 1.0]}
WIND = {"on": "block", "face": "left", "ramp": [0.0, 0.5]}

# fmt: off
ORACLES = [
    *(Oracle(name, GRANITE, {**RIGID, **changes}, numbers) for name, changes, numbers in (
        ("free rocking", {}, rocks(7, 4, 1e-5)),
        ("free rocking, steps of 1 ms", {"time.step": 1e-3}, rocks(7, 4, 1e-4)),
        ("free rocking, H/B 2 from -10 degrees", {"block.width": 0.5, "block.tilt_deg": -10.0},
            rocks(5, 3, 2e-5, size=(0.5, 1.0), tilt=10)),
        ("free rocking, H/B 8", {"block.width": 0.125, "time.end": 1.5},
            rocks(3, 3, 2e-5, size=(0.125, 1.0))),
        ("free rocking on the moon", {"gravity": 1.62}, {
            "impact 1 time_s": closed(MOON * own.quarter(0.25, 1, math.radians(3)),
                                      "times go with 1/sqrt(g)", rel=2e-5)}),
        ("restitution by key", {"block.restitution": 0.95}, rocks(6, 4, 2e-5, e=0.95)),
        ("restitution 1 loses nothing", {"block.restitution": 1.0}, {
            "peak 5": closed(math.radians(3), "energy stays", rel=1e-4),
            "energy.loss.contact_J": closed(0.0, "e = 1", abs=1e-6)}),
        ("restitution of a squat block",
            {"block.width": 0.5, "block.restitution": 0.5, "block.friction": 3.0},
            rocks(3, 3, 1e-4, size=(0.5, 1.0), e=0.5)),
        ("incline, rocks", {"gravity_tilt_deg": 3.0}, rocks(3, 2, 5e-5, slope_deg=3)),
        ("vertical motion, rocks", vertical(0.3, 0.3),
            rocks(3, 2, 5e-5, vertical=own.sine(0.3, 0.3))),
        ("flight without spin", {**STANDS, "block.velocity": [1.5, 3.0], "time.end": 0.5}, {
            "last block.centre_x_m": closed(0.75, "v t", rel=1e-9),
            "last block.centre_y_m": closed(0.5 + flown(3.0, 0.5), "v t - g t2/2", rel=1e-6),
            **holds("flown, not slipped"), "block.mode": word("hop")}),
        ("spin without gravity", {**STANDS, "gravity": 0.0, "block.velocity": [0.0, 3.0],
            "block.angular_velocity": 2.0, "time.end": 1.0, "time.step": 1e-3}, {
            # Steps turn by Cayley's map: 1 - (omega dt)^2/12 of omega t.
            "last block.angle_rad": closed(
                2000 * math.atan(1e-3), "2 atan(omega dt/2) a step", rel=1e-12)}),
        ("half sine, just stays", {**NO_SLIP, **half_sine_at(0.999), "time.end": 6.0}, {
            "block.mode": word("rock", THRESHOLD)}),
        ("half sine, just overturns",
            {**NO_SLIP, **half_sine_at(1.001), "time.end": 6.0, "time.stop": "overturned"},
            {"block.mode": word("overturned", THRESHOLD), "reason": word("block overturned")}),
        ("Shenton: rocks", {**ONSET, "block.friction": 0.32}, {
            "last block.angular_velocity_rad_s": closed(
                ROCK, "3/4 (a h - g b)/(b2 + h2)", rel=1e-3), **holds("mu > mu_R = 0.3099")}),
        ("Shenton: slides and rocks", {**ONSET, "block.friction": 0.28}, {
            "last block.angular_velocity_rad_s": closed(
                SLIDE_ROCK, "3 g (mu r - 1)/(b (4 + r2 - 3 mu r))", rel=5e-3)}),
        ("Shenton: slides", {**STANDS, **pulse("rectangular", 0.4, duration=0.3),
            "block.friction": 0.2, "time.end": 1.0}, {
            **newmark(1e-3, 0.2, 0.4, 0.3), "block.mode": word("slide"),
            "block.peak_angle_rad": closed(0.0, "mu < B/H", abs=1e-9)}))),
    *(Oracle(f"rocking under {kind}", GRANITE,
             {**RIGID, **NO_SLIP, **pulse(kind, level, **keys), "time.end": end},
             lambda kind=kind, level=level, keys=keys, end=end: moved(kind, level, end, **keys))
      for kind, level, keys, end in (
          ("half_sine", 0.35, {"duration": 0.4}, 2.2), ("one_sine", 0.35, {"duration": 0.8}, 2.0),
          ("rectangular", 0.3, {"duration": 0.3}, 2.0), ("ricker", -0.4, {"frequency": 1.2}, 3.0),
          ("sine", 0.4, {"period": 0.7}, 2.0))),
    *(Oracle(name, SQUAT, changes, numbers) for name, changes, numbers in (
        ("rebounds of a flat landing", {**UP, "block.restitution": 0.6}, {
            f"block.gap_left_m at {t} s": closed(flown(v, t - after / own.G), "e v", abs=5e-5)
            for t, v, after in ((0.1, 1.0, 0.0), (0.25, 0.6, 2.0), (0.38, 0.36, 3.2))}),
        ("plastic flat landing", UP, {
            "energy.loss.contact_J": closed(500.0, "m v2/2", rel=1e-6),
            "last block.gap_left_m": closed(0.0, "no rebound", abs=1e-9)}),
        ("thrown along the ground", THROWN, {**stops(1e-5), "block.mode": word("slide"),
            "energy.loss.friction_J": closed(500.0, "m v2/2", rel=1e-6)}),
        ("incline, slides", {"gravity_tilt_deg": 20.0}, downhill(1e-5)),
        ("incline, holds just so", {"gravity_tilt_deg": 16.6}, {
            **holds("tan b < mu", 1e-10), "block.mode": word("rest")}),
        ("rectangular pulse, slides", PUSHED, newmark(1e-4, 0.3, 0.6, 0.2)),
        ("sine, slides", {**pulse("sine", 0.5, period=0.4, cycles=4), "time.end": 2.0},
            slides(2e-3, 0.3, 2.0, ground=own.sine(0.5, 0.4, 4))),
        ("friction that decays",
            {**pulse("sine", 0.7, period=0.6, cycles=4), "block.friction": FALLS, "time.end": 3.0},
            slides(5e-3, falling, 3.0, ground=own.sine(0.7, 0.6, 4))),
        ("friction that jumps", JUMP, jumped),
        ("cohesion", {**pulse("sine", 0.6, period=0.4, cycles=4), "time.end": 2.0,
            "block.friction": {"static": 0.3, "cohesion": 800.0}},
            slides(2e-3, 0.3, 2.0, cohesion=0.8, ground=own.sine(0.6, 0.4, 4))),
        ("cohesion that is lost", {**PUSHED, "block.friction": {**BOUND, "cohesion": 2500.0}},
            newmark(5e-3, 0.3, 0.6, 0.2)),
        ("cohesion that holds", {**PUSHED, "block.friction": {**BOUND, "cohesion": 3000.0}},
            holds("c A + mu m g > m a", 1e-10)),
        ("vertical motion, slides", BOTH, slides(
            2e-3, 0.3, 1.0, ground=own.sine(0.5, 1.0, 0.5), vertical=own.sine(0.4, 0.25))))),
    *(Oracle(name, SQUAT, changes, numbers) for name, changes, numbers in (
        ("hangs on a spring", {"block.position": [0.0, 2.0], "link": [HANGS]}, {
            "links.link.peak_extension_m": closed(2e4 * own.G / 1e6, "2 m g/k", rel=1e-4),
            "last link.force_N": closed(
                1000 * own.G * (1 - math.cos(10.0 * 1.0)), "m g (1 - cos(omega t))", rel=1e-3)}),
        ("wax beside friction", {"link": [WAX], "force": [FORCE]}, {
            "links.link.broke_at_s": closed(
                (0.3 * 1000 * own.G + 1000) / 6000, "F = mu m g + strength", abs=2e-3)}),
        ("wind below friction", {"force": [{**WIND, "pressure": 5.85e3}]},
            {"block.mode": word("rest", "p H t < mu m g")}),
        ("wind above friction", {"force": [{**WIND, "pressure": 5.92e3}], "time.end": 4.0},
            {"block.mode": word("slide", "p H t > mu m g")}))),
]
