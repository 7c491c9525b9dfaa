"""Default damping of a meshed block."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from ledger import completed
from scipy.sparse.linalg import eigsh

from rockslip import Scene, parse_scene
from solver.build.assembly import build

pytestmark = pytest.mark.serial

WIDTH = 0.25
DENSITY = 503.0 / (0.25 * 1.0 * 0.75)  # the demo's at H/B 4


def scene(slenderness: float, cells: list[int], **tables: Any) -> Scene:
    """A block of granite of a height over width."""
    block = {"width": WIDTH, "height": slenderness * WIDTH, "thickness": 0.75, "cells": cells}
    block |= {"density": DENSITY, "young": 5e10, "poisson": 0.2}
    block |= tables.pop("block", {})
    return parse_scene(
        {"block": [block], "time": {"end": 0.25}, "output": {"fields": "none"}} | tables
    )


def first_frequency(asked: Scene) -> float:
    """Natural frequency (rad/s) of the mesh of a block, held at its base."""
    (body,) = build(asked).stepper.system.bodies
    stiffness, mass = (
        sp.csr_matrix(matrix.getValuesCSR()[::-1], shape=matrix.size)
        for matrix in (body.stiffness_matrix, body.mass_matrix)
    )
    height = body.nodes[:, -1]
    free = np.flatnonzero(np.repeat(~np.isclose(height, height.min()), asked.dimension))
    K, M = (matrix[free][:, free] for matrix in (stiffness, mass))
    (squared,) = eigsh(K, 1, M, sigma=0.0, return_eigenvectors=False)
    return math.sqrt(float(squared))


@pytest.mark.parametrize(
    ("slenderness", "cells"),
    [(0.25, [12, 4]), (0.5, [10, 5]), (1, [8, 8]), (2, [6, 12]), (4, [6, 20]), (10, [4, 30])],
)
@pytest.mark.parametrize(("plane", "poisson"), [("strain", 0.4), ("stress", 0.0)])
def test_the_frequency_is_that_of_the_mesh(
    slenderness: float, cells: list[int], plane: str, poisson: float
) -> None:
    """Timoshenko's beam is within 2 % of quadratic elements."""
    asked = scene(slenderness, cells, plane=plane, block={"degree": 2, "poisson": poisson})
    assert asked.bending_frequency(asked.blocks[0]) == pytest.approx(
        first_frequency(asked), rel=0.02
    )


def test_the_mesh_of_the_demo_has_two_percent_of_critical() -> None:
    asked = scene(4, [6, 16])
    damping = asked.blocks[0].damping
    assert damping is not None
    assert damping.ratio(first_frequency(asked)) == pytest.approx(0.02, rel=0.02)


@pytest.mark.parametrize(
    ("slenderness", "up", "thickness"), [(0.25, 3, 1.0), (1, 4, 2.0), (10, 16, 1.0)]
)
def test_so_it_is_in_space_across_the_narrower_side(
    slenderness: float, up: int, thickness: float
) -> None:
    """Within 2 % and what the coarse mesh is too stiff where a block is flat (0.4 %)."""
    block = {"degree": 2, "thickness": WIDTH * thickness}
    asked = scene(slenderness, [4, 4, up], dimension=3, block=block)
    assert asked.bending_frequency(asked.blocks[0]) == pytest.approx(
        first_frequency(asked), rel=0.02 if slenderness > 0.25 else 0.024
    )


def rocking(**tables: Any) -> Scene:
    """A block that rocks over its first impact."""
    block = {"tilt_deg": 3.0} | tables.pop("block", {})
    return scene(4, [3, 8], block=block, contact={"friction": 0.7}, **tables)


accounted = partial(completed, gain=math.inf, ledger=1e-8)


@pytest.mark.slow
def test_a_scene_that_says_nothing_is_damped_and_zero_is_none() -> None:
    """By default material damping takes most of what an impact loses, and no caution is given."""
    result = accounted(rocking())
    assert result.summary["energy"]["loss_share"]["damping"] > 0.5
    assert result.summary["cautions"] == []
    for nothing in ({"damping": {"stiffness": 0.0}}, {"block": {"damping": {}}}):
        undamped = accounted(rocking(**nothing))
        assert not undamped.history["energy.damping_J"].any()


def test_the_copy_of_a_scene_gives_the_same_run() -> None:
    """So does a scene in which the number stands."""
    asked = rocking()
    result, default = accounted(asked), asked.default_damping(asked.blocks[0])
    stated = rocking(damping={"stiffness": default.stiffness})
    for same in (parse_scene(asked.to_dict()), stated):
        other = accounted(same)
        for column in result.history.columns:
            assert np.array_equal(result.history[column], other.history[column], equal_nan=True)
