"""Bodies without stress, gravity and loads that touch for the first time.

All that their residual holds before is round-off, and so is what the tolerance is made of.
"""

from __future__ import annotations

import numpy as np
import pytest

from solver.build.assembly import build
from solver.scene import parse_scene
from solver.stepping.active_set import FIRST_MARGIN, MARGIN
from solver.stepping.step_contact import StepContact

SPEED, STEP, FLIGHT = 1.0, 1e-4, 20


@pytest.mark.parametrize("young", [5e7, 5e10])
@pytest.mark.parametrize(
    ("dimension", "cell", "degree"),
    [
        (2, "quadrilateral", 1),
        (2, "triangle", 2),
        (3, "hexahedron", 2),
        (3, "tetrahedron", 1),
        (3, "tetrahedron", 2),
    ],
)
@pytest.mark.parametrize("part", [1.0, 0.999995, 0.975], ids=["just", "grazing", "within"])
def test_a_body_that_touches_without_loads(
    dimension: int, cell: str, degree: int, young: float, part: float
) -> None:
    """It touches at the very end of a step, a little before, or within it; no step fails."""
    size = {"width": 0.3, "height": 0.4, "thickness": 0.3, "density": 2600.0, "poisson": 0.2}
    mesh = {"cell": cell, "degree": degree, "cells": [2] * dimension, "young": young}
    assembly = build(
        parse_scene(
            {
                "dimension": dimension,
                "gravity": 0.0,
                "block": [size | mesh],
                "contact": {"friction": 0.5, "points": "gauss"},
                "damping": {"stiffness": 0.0},
                "time": {"end": 1.0, "step": STEP},
            }
        )
    )
    stepper = assembly.stepper
    u = np.zeros((stepper.system.size // dimension, dimension))
    v = np.zeros_like(u)
    u[:, -1], v[:, -1] = part * FLIGHT * SPEED * STEP, -SPEED
    state = stepper.start(u.ravel(), v.ravel())
    energy = state.kinetic
    pressed = 0.0
    for _ in range(FLIGHT + 5):
        state, exchange = stepper.advance(state, STEP)
        pressed = max(pressed, float(state.contacts[0].force[:, 0].sum()))
        assert exchange.iterations < 10
    assert pressed > 0.0
    assert state.kinetic + state.strain < energy * (1 + 1e-9)


@pytest.mark.parametrize("margin", [FIRST_MARGIN, MARGIN], ids=["first", "later"])
def test_a_corner_that_the_other_one_turns_into_the_floor_touches(
    margin: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The free step ends with one corner in the floor, contact there turns the other one into it.

    One correction is made to be enough: the other corner has not been examined by then.
    """
    monkeypatch.setattr("solver.stepping.active_set.FIRST_MARGIN", margin)
    looked = []
    sinks_in = StepContact.sinks_in
    monkeypatch.setattr(
        StepContact, "sinks_in", lambda *given: looked.append(sinks_in(*given)) or looked[-1]
    )
    size = {"width": 1.0, "height": 0.4, "thickness": 1.0, "density": 2600.0, "poisson": 0.2}
    scene = {"gravity": 0.0, "block": [size | {"young": 5e12, "cells": [1, 1]}]}
    times = {"time": {"end": 1.0, "step": 1e-3}}
    assembly = build(parse_scene(scene | times), petsc_options=("-rockslip_snes_atol", "1e12"))
    tilt, low, speed = 0.85e-3, 0.2e-3, 1.0
    nodes = assembly.members[0].body.nodes
    place = nodes - nodes.min(axis=0)
    turned = place @ np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    u, v = turned - place + (0.0, low), np.zeros_like(place) - (0.0, speed)
    state, exchange = assembly.stepper.advance(assembly.stepper.start(u.ravel(), v.ravel()), 1e-3)
    assert low < speed * 1e-3 < low + np.sin(tilt)
    expected = ([True, False], 2) if margin == FIRST_MARGIN else ([False], 1)
    assert (looked, exchange.iterations) == expected
    (memory,) = state.contacts
    assert (memory.force[:, 0] > 0.0).all()
    assert np.abs(memory.kinematics.place[:, 0]).max() < 2e-6
