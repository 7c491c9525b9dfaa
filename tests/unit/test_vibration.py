"""Vibration of a meshed body: what a motion has besides the motion as a whole, on known ones."""

from __future__ import annotations

from mpi4py import MPI

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rockslip import Scene, parse_scene
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.kinematics import rigid_modes
from solver.bodies.reduced_body import ReducedBody
from solver.build.assembly import build
from solver.build.foundation import foundation as built

FRAME = {
    "kind": "frame",
    "deck": {"width": 1.5, "height": 0.2},
    "column": {"width": 0.1},
    "storey": 1.0,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2500.0,
    "cells": {"bay": 3, "column": 1, "deck": 1, "storey": 4},
    "modes": 6,
}


def scene(dimension: int, **tables: object) -> Scene:
    """A coarse block, twice as high as wide."""
    block = {"width": 0.5, "height": 1.0, "thickness": 0.4, "mass": 400.0}
    block |= {"young": 1e9, "poisson": 0.2, "cells": [2, 4, 2][:dimension]}
    return parse_scene({"dimension": dimension, "block": [block], "time": {"end": 1.0}} | tables)


def block(dimension: int) -> ElasticBody:
    """The meshed body of that block."""
    body = build(scene(dimension), comm=MPI.COMM_SELF).members[0].body
    assert isinstance(body, ElasticBody)
    return body


def turned(dimension: int) -> np.ndarray:
    """A large rotation."""
    if dimension == 2:
        return Rotation.from_euler("z", 0.7).as_matrix()[:2, :2]
    return Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rigid_motion_has_none_however_far_the_body_turned(dimension: int) -> None:
    body, rotation = block(dimension), turned(dimension)
    arm = body.arm @ rotation.T
    u = (arm - body.arm + 0.2).ravel()
    weights = np.linspace(1.0, 2.0, len(rigid_modes(arm)))
    v = weights @ np.array(rigid_modes(arm))
    whole = float(v @ body.inertia(v)) / body.mass
    assert body.vibration(u, v, body.rotation(u)) < 1e-12 * whole


@pytest.mark.parametrize("dimension", [2, 3])
def test_it_is_what_no_rigid_motion_takes_away(dimension: int) -> None:
    """The least mean square over all rigid motions, by least squares with the mass as weight."""
    body, rotation = block(dimension), turned(dimension)
    arm = body.arm @ rotation.T
    u = (arm - body.arm).ravel()
    v = np.random.default_rng(1).standard_normal(body.size)
    modes = np.array(rigid_modes(arm))
    inertia = np.array([body.inertia(mode) for mode in modes])
    left = v - np.linalg.solve(inertia @ modes.T, inertia @ v) @ modes
    expected = float(left @ body.inertia(left)) / body.mass
    assert body.vibration(u, v, body.rotation(u)) == pytest.approx(expected, rel=1e-10)


def test_a_body_that_stands_on_the_ground_does_not_turn_as_a_whole() -> None:
    """Its turning is bending, and is judged as such."""
    body = built(scene(2, foundation=FRAME), 0, MPI.COMM_SELF).body
    assert isinstance(body, ReducedBody) and body.parts is not None
    mesh = body.parts.mesh
    modes = np.array(rigid_modes(mesh.arm))[:2]
    v = body.expanded(np.random.default_rng(2).standard_normal(body.size))
    mean = modes @ mesh.inertia(v) / mesh.mass
    left = v - mean @ modes
    expected = float(left @ mesh.inertia(left)) / mesh.mass
    still = np.zeros(mesh.size)
    assert mesh.vibration(still, v, np.eye(2)) == pytest.approx(expected, rel=1e-10)


def test_a_reduced_body_vibrates_as_its_mesh_does() -> None:
    body = built(scene(2, foundation=FRAME), 0, MPI.COMM_SELF).body
    assert isinstance(body, ReducedBody) and body.parts is not None
    y = np.random.default_rng(2).standard_normal(body.size)
    mesh, v = body.parts.mesh, body.expanded(y)
    expected = mesh.vibration(np.zeros(mesh.size), v, np.eye(2))
    assert body.vibration(np.zeros(body.size), y, np.eye(2)) == pytest.approx(expected, rel=1e-9)
