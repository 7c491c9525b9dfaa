"""Second order in the step while a block that was let go rocks about one corner.

Orders of the static displacement in the cell size, and of a vibration in the step, are in
test_convergence.py. A block of granite vibrates at its release faster than any of these steps
sees; the elastic block here is so soft that they do.
"""

import math
from itertools import pairwise

import numpy as np
import pytest

from rockslip import Scene, parse_scene, simulate
from solver.reference.housner import housner

pytestmark = pytest.mark.serial

COARSEST = 4e-3
END = 0.16  # the rigid block strikes at 0.1916 s


def scene(step: float, **block) -> Scene:
    return parse_scene({
        "block": [{"width": 0.25, "height": 1.0, "mass": 503.0, "tilt_deg": 3.0} | block],
        "contact": {"friction": 0.7},
        "damping": {"stiffness": 0.0},
        "time": {"end": END, "step": step},
    })  # fmt: skip


def angles(step: float, **block) -> np.ndarray:
    """At the times of the coarsest step."""
    history = simulate(scene(step, **block)).history
    every = round(COARSEST / step)
    assert history["time_s"][every] == pytest.approx(COARSEST)
    return history["block.angle_rad"][::every]


def test_rigid_block_against_housner():
    shape = scene(COARSEST, model="rigid").blocks[0].shape
    exact = housner(shape, gravity=9.81, tilt=math.radians(3.0), end=END, step=COARSEST).angle
    errors = [
        np.linalg.norm(angles(COARSEST / n, model="rigid") - exact) / np.linalg.norm(exact)
        for n in (1, 2, 4, 8)
    ]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(2.0, abs=0.02)
    assert errors[0] < 3e-5


@pytest.mark.slow
def test_soft_block_against_finer_steps():
    """The damped steps after the release have an error of second order, too, from 2e-3 s on."""
    soft = {"young": 5e7, "poisson": 0.2, "thickness": 0.75, "cells": [3, 8]}
    found = [angles(COARSEST / n, **soft) for n in (2, 4, 8, 16)]
    differences = [np.linalg.norm(coarse - fine) for coarse, fine in pairwise(found)]
    orders = np.log2(np.divide(differences[:-1], differences[1:]))
    assert orders == pytest.approx(2.0, abs=0.1)
    assert differences[-1] < 3e-4 * np.linalg.norm(found[-1])
