"""Rayleigh damping of single bodies, and that of a plate by the ratio of its first sway mode."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from ledger import completed
from swaying import decrement

from rockslip import Result, parse_scene
from solver.bodies.elastic_body import ElasticBody
from solver.build.assembly import build
from solver.build.foundation import natural_period
from solver.errors import SceneError
from solver.run.describe import describe

BLOCK = {"width": 0.25, "height": 1.0, "density": 2.7e3, "young": 5e8, "poisson": 0.2}
FRAME = {
    "kind": "frame",
    "deck": {"width": 1.0, "height": 0.1},
    "column": {"width": 0.05},
    "storey": 0.6,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2.5e3,
    "cells": {"bay": 2, "storey": 3},
}
GIVEN = {"mass": 2.0, "stiffness": 1e-3}


def run(block: dict[str, Any] | None = None, **tables: Any) -> Result:
    """Half a tenth of a second on shaken ground."""
    small = {"cells": [2, 4]}
    motion = {"kind": "sine", "amplitude_g": 0.1, "period": 0.05, "cycles": 1}
    time = {"end": 0.05, "step": 1e-3, "adaptive": False}
    scene = {"block": [BLOCK | small | (block or {})], "motion": motion, "time": time} | tables
    return completed(parse_scene(scene), gain=np.inf)


def lost(result: Result) -> np.ndarray:
    """Energy that damping took, J."""
    return result.history["energy.damping_J"]


def test_that_of_a_block_is_that_of_the_scene() -> None:
    """One body with damping of its own moves as with [damping]; an empty table is none."""
    own, of_all = run({"damping": GIVEN}), run(damping=GIVEN)
    assert np.array_equal(lost(own), lost(of_all)) and lost(own)[-1] > 0.0
    assert np.array_equal(own.history["block.centre_x_m"], of_all.history["block.centre_x_m"])
    assert not lost(run({"damping": {}}, damping=GIVEN)).any()


@pytest.mark.slow
def test_that_of_a_frame_is_its_own() -> None:
    """Under a rigid block, that of the frame alone; under an elastic one, either or both."""
    on_rigid = run({"model": "rigid"}, foundation=FRAME | {"damping": GIVEN})
    assert np.array_equal(
        lost(on_rigid), lost(run({"model": "rigid"}, foundation=FRAME, damping=GIVEN))
    )
    frame = run({"damping": {}}, foundation=FRAME | {"damping": GIVEN})
    both = run({"damping": GIVEN}, foundation=FRAME | {"damping": GIVEN})
    assert np.diff(lost(frame)).min() >= 0.0 and lost(frame)[-1] > 0.0
    assert np.array_equal(lost(both), lost(run(foundation=FRAME, damping=GIVEN)))
    assert lost(both)[-1] != lost(frame)[-1]


def test_a_plate_that_is_held_everywhere_has_none() -> None:
    """One line that names the key."""
    plate = {"kind": "elastic", "width": 1.0, "height": 0.2, "density": 2.7e3, "young": 5e10}
    with pytest.raises(SceneError, match=r"^foundation\.damping applies to a plate that is not"):
        run(foundation=plate | {"poisson": 0.2, "damping": GIVEN})


def test_a_plate_on_its_bottom_decays_by_its_damping_ratio() -> None:
    """The logarithmic decrement of its top after a pull, 2 pi xi / sqrt(1 - xi²) within 1 %."""
    ratio = 0.05
    plate = {"kind": "elastic", "support": "bottom", "width": 1.0, "height": 2.0, "young": 1e8}
    plate |= {"poisson": 0.2, "density": 2500.0, "cells": [2, 6], "damping_ratio": ratio}
    pebble = {"width": 0.1, "height": 0.05, "mass": 1e-3, "model": "rigid"}
    step = 1e-3
    case = parse_scene(
        {
            "block": [pebble],
            "plane": "stress",
            "gravity": 0.1,
            "foundation": plate,
            "contact": {"friction": 1.0},
            "time": {"end": 1.0, "step": step, "rho_inf": 1.0, "damped_steps": 0},
        }
    )
    assembly = build(case)
    stepper, number = assembly.stepper, assembly.support.number
    assert number is not None
    assert natural_period(case) > 80 * step
    body, own = stepper.system.bodies[number], stepper.system.slices[number]
    assert isinstance(body, ElasticBody)
    top = np.flatnonzero(np.isclose(body.nodes[:, 1], body.nodes[:, 1].max()))
    pull = np.zeros(stepper.system.size)
    pull[own][2 * top] = 10.0
    rest = np.zeros(stepper.system.size)
    state = stepper.static_start(rest, load=pull)
    drift = []
    for _ in range(500):
        state, _ = stepper.advance(state, step)
        drift.append(state.u[own][2 * top].mean())
    exact = 2 * np.pi * ratio / np.sqrt(1 - ratio**2)
    assert decrement(np.array(drift), 60) == pytest.approx(exact, rel=0.01)
    assert f"{100 * ratio:g} % of critical at first sway" in describe(case)
