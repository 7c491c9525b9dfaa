"""Nearly incompressible blocks: where degree 1 locks, and where they are soft as well."""

import pytest

from rockslip import parse_scene, simulate
from solver.run.meshed import MeshedRun


def compliance(**changes: object) -> float:
    """Strain energy of a block glued to an incline of 10 degrees, J: half the work of its load."""
    block = {"width": 0.25, "height": 1.0, "thickness": 0.75, "density": 2680.0, "young": 1e9}
    scene = {
        "block": [{**block, **changes}],
        "gravity_tilt_deg": 10.0,
        "contact": {"friction": 1000.0},
        "damping": {"stiffness": 0.0},
        "time": {"end": 1e-3, "step": 1e-3},
    }
    return MeshedRun(parse_scene(scene), lambda line: None).state.strain


def test_locking() -> None:
    """Over that of a finer mesh, at nu 0.4999: the numbers of the docs."""
    fine = compliance(poisson=0.4999, degree=2, cells=[12, 40])
    for cell, degree, share in (
        ("quadrilateral", 1, 0.144),
        ("quadrilateral", 2, 0.916),
        ("triangle", 2, 0.965),
    ):
        coarse = compliance(poisson=0.4999, cell=cell, degree=degree, cells=[4, 10])
        assert coarse / fine == pytest.approx(share, abs=0.01)


def test_a_soft_strip_on_its_edge_keeps_its_step() -> None:
    """The stiffness of its strained corner, where that of rest fails: steps were 100 times less."""
    block = {"width": 0.13, "height": 0.0145, "thickness": 0.22, "density": 300.0}
    block |= {"young": 1.5e5, "poisson": 0.49985, "cells": [6, 4]}
    scene = {
        "block": [{**block, "cell": "triangle", "degree": 2, "tilt_deg": 84.0}],
        "contact": {"friction": 1.0},
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.05, "step": 2e-3},
    }
    result = simulate(parse_scene(scene))
    assert result.status == "completed"
    assert result.summary["cost"]["steps"] < 2 * 25
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-10
