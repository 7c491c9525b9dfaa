"""The command line: studies in short forms, reference, check, resuming, scaling, refusals."""

import math

import numpy as np

from tests.oracles import own
from tests.oracles.answers import FALLS, FINER, agreed, falling, pulse, quarter, rocks
from tests.oracles.foundations import OSCILLATOR
from tests.oracles.motions import COUNT, TIMES, WAVE, peer
from tests.oracles.oracle import Oracle, closed, count, program, word
from tests.oracles.rigid_ground import ELASTIC, GRANITE, NO_SLIP, RIGID, SQUAT, STANDS
from tests.oracles.space import SQUARE

#: Two more components of the made-up earthquake, m/s2.
ACROSS, UP = -0.5 * WAVE[::-1], 0.3 * WAVE
FILES = {
    "event_000.AT2": peer(WAVE),
    "event_090.AT2": peer(ACROSS, "090"),
    "event_UP.AT2": peer(UP, "UP"),
}
OUT = "-o OUT -q -j 1"
DONE = {"exit": count(0, "success")}
SIX = {"kind": "sine", "amplitude_g": 0.1, "period": 1.0}
BOX = {"thickness": 0.75, "width": 0.5, "height": 0.5, "mass": 9.0, "model": "rigid"}
FE_MODE = "FE mode of the held block at 1346 Hz; 0.22 mu of critical"
BETA = 2 * 0.22 * 0.3 / (2 * math.pi * 1346)


def drift(friction: float, wave: object = WAVE) -> float:
    """Of the paper's platform under the made-up earthquake, m."""
    ground, end = own.sampled(TIMES, wave), TIMES[COUNT - 1] + 1
    return own.sliding(friction, end, ground=ground, platform=(2.0, 0.5, 0.05)).drift


def drifts(*cases: tuple[str, float, object]) -> dict[str, object]:
    """Drifts in the rows of a suite: column and row, friction, motion."""
    return DONE | {
        f"out/suite.csv platform.peak_{where}": program(drift(mu, wave), "own ODE", rel=2e-3)
        for where, mu, wave in cases
    }


def overturns(level: float) -> int:
    """1 if the made-up earthquake, scaled to a peak (g), overturns the granite block, else 0."""
    ground = own.sampled(TIMES, WAVE * (level * own.G / np.abs(WAVE).max()))
    return int(own.rocking(0.25, 1.0, TIMES[-1], ground=ground).overturned < TIMES[-1])


# fmt: off
ORACLES = [
    *(Oracle(name, GRANITE, {**RIGID, **changes},
             lambda more=more, shape=shape: DONE | shape() | more, command=command)
      for name, changes, shape, more, command in (
        ("run and its files", {"time.end": 1.0}, rocks(3, 2, 1e-4), {
            "out/summary.json blocks.block.mode": word("rock"),
            "out/scene.toml block.0.friction": closed(0.7, "as given", abs=1e-12),
            "printed": word("3 impacts at")}, "run SCENE -o OUT"),
        ("resumed beyond its end",
            {"time.end": 0.4, "time.step": 1e-3, "output.checkpoint": {"steps": 150}},
            rocks(3, 2, 1e-4), {},
            "run SCENE -o OUT -q && run --resume OUT --set time.end=1.0 -q"),
        ("reference, rocking", {}, rocks(5, 3, 1e-5), {}, "reference SCENE -o OUT"),
        ("model at 1:15", {"time.end": 0.3}, dict, {
            "model.toml block.0.height": closed(1 / 15, "lengths", rel=1e-9),
            "impact 1 time_s": closed(own.quarter(0.25, 1, math.radians(3)) / math.sqrt(15),
                                      "times go with the root of lengths", rel=1e-4)},
            "scale SCENE --lengths 15 -o model.toml && run model.toml -o OUT -q"))),
    Oracle("resumed, elastic", GRANITE, {"time.end": 0.1, "output.checkpoint": {"steps": 20}},
        DONE | quarter(1e-3) | {"last energy.ledger_error_J": closed(0.0, "energy", abs=1e-6)},
        command="run SCENE -o OUT -q && run --resume OUT --set time.end=0.25 -q", slow=True),
    Oracle("reference, sliding with falling friction", SQUAT,
        {**pulse("sine", 0.7, period=0.6, cycles=4), "block.friction": FALLS, "time.end": 3.0},
        lambda: DONE | {"block.peak_slip_m": program(
            own.sliding(falling, 3, ground=own.sine(0.7, 0.6, 4)).peak_slip, "own ODE", rel=1e-3)},
        command="reference SCENE -o OUT"),
    Oracle("reference, platform", SQUAT,
        {**OSCILLATOR, **pulse("sine", 0.4, period=0.6, cycles=3), "time.end": 2.5},
        lambda: DONE | {"platform.peak_drift_m": program(own.sliding(0.3, 2.5, ground=own.sine(
            0.4, 0.6, 3), platform=(2.0, 0.5, 0.05)).drift, "own ODE", rel=1e-3)},
        command="reference SCENE -o OUT"),
    Oracle("check", GRANITE, {}, DONE | {
        "printed 1": word("0.24498", "alpha = atan(B/H)"), "printed 2": word("3.7783", "p"),
        "printed 3": word("0.9118", "Housner's e"), "printed 4": word("rock", "Shenton 1996")},
        command="check SCENE"),
    Oracle("default damping, squat block", SQUAT, {**ELASTIC, "time.end": 0.001}, DONE | {
        "out/scene.toml block.0.damping.stiffness": program(BETA, FE_MODE, rel=0.03)},
        command="run SCENE -o OUT -q"),
    Oracle("horizon of a swing", GRANITE,
        {**RIGID, **NO_SLIP, **pulse("half_sine", 0.4, duration=0.3), "time.end": 1.5},
        DONE | {"out/horizon.csv largest_difference of row 0": closed(
            0.0, "of the perturbation's size, 1e-6", abs=1e-4)},
        command=f"study horizon SCENE {OUT}"),
    *(Oracle(name, GRANITE, changes, DONE | numbers, slow=True, command=f"study {command} {OUT}",
             files=FILES, beside=beside) for name, changes, numbers, command, beside in (
        ("modes, rigid", STANDS, {
            "out/summary.json maps.0.judged": count(30, "36 less 6 near a boundary"),
            "out/summary.json maps.0.agree": count(30, "Shenton 1996")},
            "modes SCENE --points 6 --engines rigid", {}),
        ("modes, elastic", STANDS, {
            "out/summary.json maps.0.judged": count(8, "9 less 1 near a boundary"),
            "out/summary.json maps.0.agree": count(8, "Shenton 1996")},
            "modes SCENE --points 3 --engines elastic", {}),
        ("overturning by half a sine", NO_SLIP, {
            f"out/overturning.csv amplitude of row {row}": program(
                value, "verification.md, D.8: nonlinear", rel=2e-4)
            for row, value in enumerate((1.8015, 2.7973))},
            "overturning SCENE --pulses half_sine --frequencies 2,4 --amplitudes 1:4:12"
            " --rounds 0", {}),
        ("restitution over damping", {}, {
            f"out/damping.csv restitution where value={beta}": agreed(0.003, {"e": e})["e"]
            for beta, e in (("0.0001", 0.9296), ("0.001", 0.937))},
            "damping SCENE --of beta=1e-4,1e-3 --impacts 1", FINER),
        ("damping of a restitution", {}, {
            "out/summary.json restitution": closed(0.936, "the target", abs=5e-4),
            **agreed(0.1, {"out/summary.json value": 3.5e-5})},
            "damping SCENE --target restitution=0.936 --impacts 1", FINER))),
    Oracle("fragility, two engines", GRANITE, {**RIGID, **NO_SLIP}, lambda: DONE | {
        f"out/fragility.csv overturned of row {row}": count(overturns(level), "own ODE")
        for row, level in enumerate((0.25, 0.9, 0.25, 0.9))}, files=FILES, slow=True,
        command="study suite SCENE --motions event_000.AT2 --levels 0.25,0.9 --engines rigid,ode "
                + OUT),
    Oracle("lambda of thirty motions", SQUAT,
        {**OSCILLATOR, "time.step": 2.5e-3, "time.end": 40.0}, DONE | {
        f"out/summary.json cells.{k}.lambda": program(value, "verification.md, E", abs=0.01)
        for k, value in enumerate((0.265, 0.997))},
        command=f"study inertia SCENE --of friction=0.1,0.5 --count 30 {OUT}", slow=True),
    Oracle("suite of two motions, two frictions", SQUAT, {**OSCILLATOR, "time.step": 1e-3},
        lambda: drifts(("drift_m of row 0", 0.1, WAVE), ("drift_m of row 1", 0.1, ACROSS),
                       ("drift_m of row 2", 0.2, WAVE), ("drift_m of row 3", 0.2, ACROSS)),
        command="study suite SCENE --motions event_000.AT2 event_090.AT2"
                f" --vary block.friction=0.1,0.2 --tail 1 {OUT}", files=FILES, slow=True),
    Oracle("suite, elastic beside reference", SQUAT,
        {**OSCILLATOR, **ELASTIC, "block.friction": 0.1},
        DONE | {"out/suite.csv platform.peak_drift_ratio of row 0": program(
            1.0, "the reference beside it", abs=5e-3)},
        command=f"study suite SCENE --motions event_000.AT2 --reference {OUT}", files=FILES,
        slow=True),
    Oracle("suite of one event of three components", SQUARE, {**OSCILLATOR, "block.friction": 5.0,
        "motion": {**SIX, "second": SIX, "vertical": SIX}, "time.end": 2.0},
        lambda: drifts(("drift_m of row 0", 5.0, WAVE), ("drift_second_m of row 0", 5.0, ACROSS)),
        command=f"study suite SCENE --motions . --tail 1 {OUT}", files=FILES, slow=True),
    Oracle("exit of bad input", GRANITE, {"block.heigth": 2.0}, {"exit": count(2, "bad input"),
        "printed": word("block.heigth")}, command="run SCENE -o OUT"),
    *(Oracle(f"refused: {name}", GRANITE, {**RIGID, **changes}, {
        f"refusal {n}": word(text, "what, where, what it may be") for n, text in enumerate(words)})
      for name, changes, words in (
        ("unknown key", {"block.heigth": 2.0}, ("block.heigth", "height")),
        ("negative friction", {"block.friction": -0.1}, ("block.friction", "-0.1", ">= 0")),
        ("mass and density", {"block.density": 2000.0}, ("density", "mass")),
        ("restitution of a meshed block", {**ELASTIC, "block.restitution": 0.9}, ("restitution",)),
        ("no end", {"time.end": None}, ("time.end",)),
        ("an incompressible block", {"block.poisson": 0.5}, ("block.poisson", "0.5")),
        ("motion without amplitude", {"motion": {"kind": "sine", "period": 1.0}}, ("amplitude_g",)),
        ("a carrier that is not there", {"block.on": "plinth"}, ("on", "plinth")),
        ("overlap", {"+block": {**BOX, "name": "two", "offset": 0.2}}, ("overlap", "two")),
        ("two names alike", {"+block": {**BOX, "name": "block", "offset": 5.0}}, ("name",)),
        ("a step beyond the end", {"time.step": 5.0}, ("time.step",)),
        ("dynamic friction above static", {"block.friction": {"static": 0.3, "dynamic": 0.4}},
            ("dynamic",)))),
]
