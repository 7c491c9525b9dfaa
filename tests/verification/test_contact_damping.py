"""Blocks on a bed of springs and dashpots: what a flat landing loses, whatever the step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rebounds import rebound_of_a_mass
from scenes import BLOCK

from benchmarks.landing_on_bed import SPEED, bar, rebound
from rockslip import Result, Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state


def thrown(*overrides: str) -> Scene:
    """The paper's block, thrown up; it lands flat."""
    text = f"{BLOCK}\nvelocity = [0.0, {SPEED}]\n[contact]\nfriction = 0.7\n[time]\nend = 0.291\n"
    text += '[damping]\nstiffness = 0\n[output]\nfields = "none"\n'
    return parse_scene(text, overrides=overrides)


def check_energy(result: Result) -> None:
    """No gain, and a ledger that closes."""
    assert result.status == "completed"
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10
    assert np.diff(result.history["energy.contact_damping_J"]).min() >= 0.0


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.5])
def test_a_bar_on_a_soft_bed_lands_as_a_mass(ratio: float) -> None:
    assert bar(0.01, ratio, cells=50) == pytest.approx(rebound_of_a_mass(ratio), abs=3e-3)


@pytest.mark.parametrize(("ratio", "beta", "limit"), [(0.1, 0.0, 0.7543), (0.3, 1e-4, 0.4658)])
def test_the_loss_of_a_flat_landing_does_not_depend_on_the_step(
    ratio: float, beta: float, limit: float
) -> None:
    """The limit is that of a tenth of the tolerance; a mesh twice as fine has it to 2e-4.

    Without the bed, all that a landing loses without damping is lost to time integration and to
    points that close.
    """
    result = simulate(thrown(f"contact.damping={ratio}", f"damping.stiffness={beta}"))
    assert rebound(result) == pytest.approx(limit, abs=2e-3)
    check_energy(result)
    share = result.summary["energy"]["loss_share"]
    assert share["contact_damping"] + share["damping"] > 0.99
    assert result.summary["cautions"] == []
    assert result.history["block.normal_force_N"].min() >= 0.0


def test_the_bed_gives_back_what_it_took_without_dashpots() -> None:
    result = simulate(thrown("contact.stiffness=5e8", "time.end=0.3"))
    assert rebound(result) == pytest.approx(1.0, abs=2e-3)
    assert result.history["energy.contact_damping_J"].max() == 0.0
    check_energy(result)


LOW = {"name": "low", "width": 0.5, "height": 0.3, "thickness": 0.3, "density": 2700.0}
ELASTIC = {"young": 1e9, "poisson": 0.2, "cells": [4, 3]}
UP = LOW | {"name": "up", "on": "low", "width": 0.3, "tilt_deg": 2.0}
SPACE = {"thickness": 0.3, "cells": [2, 2, 2]}
SINE = {"kind": "sine", "amplitude_g": 0.4, "period": 0.2, "cycles": 2}
PLATE = {"kind": "elastic", "width": 1.5, "height": 0.2, "density": 2500.0}
SCENES: dict[str, dict[str, Any]] = {
    "stack": {"block": [LOW | ELASTIC, UP | ELASTIC]},
    "rigid on elastic, on an oscillator": {
        "block": [LOW | ELASTIC, UP | {"model": "rigid"}],
        "foundation": {"kind": "oscillator", "mass_ratio": 1.0, "period": 0.3},
        "motion": SINE,
    },
    "over the edge": {"block": [LOW | ELASTIC, UP | ELASTIC | {"offset": 0.15, "tilt_deg": 0.0}]},
    "on a plate": {
        "block": [LOW | ELASTIC | {"tilt_deg": 2.0}],
        "foundation": PLATE | {"young": 1e9, "poisson": 0.2},
        "motion": SINE,
    },
    "stack in space": {
        "dimension": 3,
        "block": [
            LOW | ELASTIC | SPACE | {"width": 0.3},
            UP | ELASTIC | SPACE | {"tilt_direction_deg": 20.0},
        ],
    },
}


@pytest.mark.parametrize(("name", "theta"), [*((name, 1) for name in SCENES), ("stack", 0)])
def test_the_ledger_closes_whatever_carries_the_blocks(name: str, theta: int) -> None:
    """Steps of 1 ms, which resolve the bed (a period of 5 ms) and not the blocks."""
    contact = {"friction": 0.4, "stiffness": 1e9, "damping": 0.2, "theta": theta}
    if theta != 1:
        contact["gamma"] = 10000.0
    tables = {"contact": contact, "time": {"end": 0.12, "step": 1e-3}}
    tables |= {"damping": {"stiffness": 0.0}, "output": {"fields": "none"}}
    result = simulate(parse_scene(SCENES[name] | tables))
    check_energy(result)
    assert result.history["energy.contact_damping_J"][-1] > 0.0
    if theta == 1:  # a frame that turns changes gaps by the square of its turn in a step
        taken = np.diff(result.history["energy.contact_J"])
        assert taken.min() > -1e-7 * result.summary["energy"]["scale_J"]
    for block in SCENES[name]["block"]:
        assert result.history[f"{block['name']}.normal_force_N"].min() >= 0.0


def test_a_block_at_rest_stands_on_the_springs_and_stays() -> None:
    """It settles by its weight over k."""
    scene = thrown("block.velocity=[0.0,0.0]", "contact.damping=0.2", "time.end=0.02")
    result = simulate(scene)
    bed = scene.bed_of(scene.blocks[0])
    assert bed is not None
    settled = 503.0 * 9.81 / (0.25 * 0.75) / bed.stiffness
    assert result.history["block.penetration_m"] == pytest.approx(settled, rel=0.3)
    assert np.ptp(result.history["block.centre_y_m"]) < 1e-6 * settled
    check_energy(result)


def test_no_bed_without_its_keys() -> None:
    """Nothing is computed of a bed then."""
    plain, zero = thrown(), thrown("contact.damping=0")
    assert plain == zero
    assert plain.bed_of(plain.blocks[0]) is None
    assembly = build(plain)
    initial_state(plain, assembly)
    assert all(link.interface.beds is None for link in assembly.stepper.links)
