"""Edges far from contact, which steps do not look at, and plates that are fully restrained."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geometry.foundation import level_frame
from rockslip import parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.contact.body_points import FixedPoints, PointState
from solver.contact.facet_target import Face
from solver.contact.held_face import HeldFace
from solver.contact.interface import Interface
from solver.stepping import sleepers
from solver.stepping.stepper import StepFailed

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
        "time": {"end": 0.5, "step": 1e-3},
    }


@pytest.mark.parametrize("block", [{}, {"model": "rigid"}])
def test_what_nobody_looks_at_is_as_if_everybody_did(
    block: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same digits to the end, where the edge of the plate has come into play."""
    if block:  # the engine of scenes with a mesh
        block = {**block, "name": "rigid"}
    scene = sliding_off(block)
    if block:
        scene["foundation"] = PLATE | {"meshed": True}
    looks = 0
    observe = Interface.observe

    def counted(self: Interface, u: Any, carrier_u: Any) -> Any:
        nonlocal looks
        looks += not self.theta and isinstance(self.points, FixedPoints)
        return observe(self, u, carrier_u)

    monkeypatch.setattr(Interface, "observe", counted)
    asleep = simulate(parse_scene(scene))
    few, looks = looks, 0
    monkeypatch.setattr(sleepers, "STEPS_AHEAD", np.inf)
    awake = simulate(parse_scene(scene))
    assert awake.history["block.penetration_m" if not block else "rigid.penetration_m"].any()
    for column in awake.history.columns:
        np.testing.assert_array_equal(asleep.history[column], awake.history[column], column)
    assert few < 0.8 * looks


def test_a_step_in_which_bodies_move_farther_than_anybody_looked_fails() -> None:
    """0.4 m in a step, with an edge that was to be looked at after 1e-6 m."""
    assembly = build(parse_scene(sliding_off({})))
    stepper = assembly.stepper
    state, _ = initial_state(parse_scene(sliding_off({})), assembly)
    state, _ = stepper.advance(state, 1e-3)
    assert [memory.clear > 0 for memory in state.contacts] == [False, True]
    near = state.contacts[1]._replace(clear=1e-6)
    state = state._replace(contacts=[state.contacts[0], near])
    with pytest.raises(StepFailed, match="too far"):
        stepper.advance(state, 0.1)
    after, _ = stepper.advance(state, 1e-3)  # 4 mm: less than what is left until contact
    assert after.contacts[1].clear > 0.1


@pytest.mark.parametrize("d", [2, 3])
def test_a_held_face_is_the_face_of_its_facets(d: int) -> None:
    """Gaps, slips, ends and forces, over it and beyond its ends."""
    if d == 2:
        corners, facets, cell = np.array([[-1.0, 0.0], [1.0, 0.0]]), np.array([[0, 1]]), "interval"
    else:
        signs = np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
        corners = np.column_stack([signs * (1.0, 0.5), np.zeros(4)])
        facets, cell = np.array([[0, 1, 2, 3]]), "quadrilateral"
    shape = FixedPoints(corners), facets, level_frame(d), cell
    face, held = Face(*shape), HeldFace(*shape)
    random = np.random.default_rng(0)
    before, after = (random.uniform(-1.5, 1.5, (40, d)) for _ in range(2))
    force = random.normal(size=(40, d))
    found = []
    for carrier in (face, held):
        old, new = (carrier.kinematics(x, PointState(corners)) for x in (before, after))
        beyond = carrier.beyond_edge(new)
        assert beyond is not None and beyond.any() and not beyond.all()
        vectors = carrier.vectors(old, new, force)
        defect = carrier.work_defect(old, new, force)
        found.append((new.place, beyond, vectors, defect))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-13)
    assert held.reaction(old, new, force) is None
