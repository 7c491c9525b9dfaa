"""What the default damping is to a meshed block."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

from rockslip import Result, Scene, parse_scene, simulate
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
    ("slenderness", "plane", "cells", "degree", "share"),
    [
        (12, "strain", [6, 72], 2, 0.0203),
        (8, "stress", [6, 48], 2, 0.0198),
        (4, "stress", [8, 32], 2, 0.01917),
        (4, "strain", [8, 32], 2, 0.01955),
        (4, "strain", [6, 16], 1, 0.0198),  # the demo's mesh
        (3, "strain", [8, 24], 2, 0.01895),
        (2, "strain", [8, 16], 2, 0.0175),  # shear bends a squat block, too
        (1, "strain", [8, 8], 2, 0.0134),
    ],
)
def test_the_mesh_has_two_percent_of_critical(
    slenderness: float, plane: str, cells: list[int], degree: int, share: float
) -> None:
    """Within 4.5 % of it where H/B is 4 and more; less damping where a block is squat."""
    asked = scene(slenderness, cells, plane=plane, block={"degree": degree})
    damping = asked.blocks[0].damping
    assert damping is not None
    found = damping.ratio(first_frequency(asked))
    assert found == pytest.approx(share, abs=6e-5)
    if slenderness >= 4:
        assert found == pytest.approx(0.02, rel=0.045)


def test_so_it_has_in_space_across_its_narrower_side() -> None:
    thin = {"degree": 2, "thickness": 0.125}
    asked = scene(4, [3, 2, 8], dimension=3, block=thin)
    damping = asked.blocks[0].damping
    assert damping is not None
    assert damping.ratio(first_frequency(asked)) == pytest.approx(0.02, rel=0.04)


def rocking(**tables: Any) -> Scene:
    """A block that rocks over its first impact."""
    block = {"tilt_deg": 3.0} | tables.pop("block", {})
    return scene(4, [3, 8], block=block, contact={"friction": 0.7}, **tables)


def completed(asked: Scene) -> Result:
    """A run that went to its end and accounts for its energy."""
    result = simulate(asked)
    assert result.status == "completed"
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-8
    return result


def test_a_scene_that_says_nothing_is_damped_and_zero_is_none() -> None:
    """By default material damping takes most of what an impact loses, and no caution is given."""
    result = completed(rocking())
    assert result.summary["energy"]["loss_share"]["damping"] > 0.5
    assert result.summary["cautions"] == []
    for nothing in ({"damping": {"stiffness": 0.0}}, {"block": {"damping": {}}}):
        undamped = completed(rocking(**nothing))
        assert not undamped.history["energy.damping_J"].any()


def test_the_copy_of_a_scene_gives_the_same_run() -> None:
    """So does a scene in which the number stands."""
    asked = rocking()
    result, default = completed(asked), asked.blocks[0].default_damping(2)
    stated = rocking(damping={"stiffness": default.stiffness})
    for same in (parse_scene(asked.to_dict()), stated):
        other = completed(same)
        for column in result.history.columns:
            assert np.array_equal(result.history[column], other.history[column], equal_nan=True)
