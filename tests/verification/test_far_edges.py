"""Outlines of faces, which join only near the edge that they are, and plates that are held."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.contact import pairs
from solver.contact.body_points import FixedPoints
from solver.contact.interface import Interface
from solver.stepping.contact_solve import StepFailed

BLOCK = {
    "width": 0.6,
    "height": 0.4,
    "mass": 600.0,
    "young": 3e10,
    "poisson": 0.2,
    "cells": [3, 2],
    "offset": -0.5,
    "velocity": [4.0, 0.0],
}
PLATE = {
    "kind": "elastic",
    "width": 2.0,
    "height": 0.2,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2500.0,
}


def sliding_off(block: dict[str, Any]) -> dict[str, Any]:
    """A block that slides over the edge of a plate, tips there and falls."""
    return {
        "block": [BLOCK | block],
        "foundation": PLATE,
        "contact": {"friction": 0.1},
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.5, "step": 2e-3},
    }


@pytest.mark.slow
def test_outlines_that_join_late_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same motion to the end, where the edge of the plate has come into play."""
    scene = sliding_off({"model": "rigid"}) | {"foundation": PLATE | {"meshed": True}}
    looks = 0
    observe = Interface.observe

    def counted(self: Interface, u: Any, carrier_u: Any, since: Any) -> Any:
        nonlocal looks
        looks += isinstance(self.points, FixedPoints)
        return observe(self, u, carrier_u, since)

    monkeypatch.setattr(Interface, "observe", counted)
    found = simulate(parse_scene(scene))
    few, looks = looks, 0
    monkeypatch.setattr(pairs, "NEAR", 10.0)
    expected = simulate(parse_scene(scene))
    assert expected.history["block.penetration_m"].any()
    for name in ("centre_x_m", "centre_y_m", "angle_rad", "slip_m", "angular_velocity_rad_s"):
        column = f"block.{name}"
        np.testing.assert_allclose(
            found.history[column], expected.history[column], rtol=0, atol=1e-10, err_msg=column
        )
    assert 0 < few < 0.8 * looks


def test_an_outline_is_there_while_the_face_is_near_it() -> None:
    """On its own, from 6 mm inside the edge, and up to 12 mm once it was there."""
    scene = parse_scene(sliding_off({"model": "rigid", "velocity": [0.0, 0.0]}))
    assembly = build(scene)
    stepper = assembly.stepper
    state, _ = initial_state(scene, assembly)
    found = []
    for inside in (0.3, 0.013, 0.011, 0.0061, 0.0059, 0.0061, 0.0119, 0.0121, 0.0061):
        u = state.u.copy()
        u[0] += 1.2 - inside - u[0]
        state = state._replace(u=u, motions={})
        state, _ = stepper.advance(state, 1e-6)
        found.append(len(stepper.links))
    assert found == [1, 1, 1, 1, 2, 2, 2, 1, 1]


def test_a_step_that_leads_onto_an_outline_unawares_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A load that velocities do not tell of throws a block on a narrower one far below it."""
    scene = parse_scene(
        {
            "block": [
                {"name": "lower", "model": "rigid", "width": 0.3, "height": 0.4, "mass": 300.0},
                BLOCK | {"name": "upper", "on": "lower", "offset": 0.0, "velocity": [0.0, 0.0]},
            ],
            "time": {"end": 0.1},
        }
    )
    assembly = build(scene)
    stepper = assembly.stepper
    state, _ = initial_state(scene, assembly)
    u = state.u.copy()
    u[stepper.system.slices[1]][1::2] += 0.1
    state, _ = stepper.advance(state._replace(u=u, motions={}), 1e-3)
    own = stepper.system.slices[1]
    for way, fails in ((0.05, False), (0.15, True)):
        load = np.zeros_like(u)
        load[own] = -stepper.system.directional_mass[1, own] * 2.0 * way / 1e-3**2
        monkeypatch.setattr(stepper, "_load", lambda time, dt, load=load: load)
        if fails:
            with pytest.raises(StepFailed, match="too far"):
                stepper.advance(state, 1e-3)
        else:
            after, _ = stepper.advance(state, 1e-3)
            assert (after.u - state.u)[own][1::2].max() < -0.04
