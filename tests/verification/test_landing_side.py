"""The side of an elastic hexagon lands: against an explicit scheme that shares nothing with ours.

A rigid side that lands keeps its leading corner on the ground. An elastic one is stopped by waves
from all of itself at once, whatever its modulus, and that corner rebounds with some 0.7 of its
velocity: a hexagon that rolls is in the air then, and lags behind its rigid twin.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from rockslip import parse_scene, simulate
from solver.types import Array

pytest.importorskip("dolfinx")

SIDE, YOUNG, POISSON, DENSITY, FRICTION = 0.3, 5e10, 0.2, 2400.0, 2.0
VELOCITY, SPIN = np.array([1.568, -0.7363]), 4.8269
"""Of one that rolls down 40 degrees when its next side lands: the other end of that is at rest."""


def hexagon(count: int) -> tuple[Array, Array]:
    """Nodes and equilateral triangles of a hexagon with a side at level 0, `count` to a side."""
    ends, h = range(-count, count + 1), SIDE / count
    lattice = [(i, j) for i in ends for j in ends if abs(i + j) <= count]
    number = {place: k for k, place in enumerate(lattice)}
    rows = np.array([j + count for _, j in lattice])  # from the lowest
    x = [(i + j / 2) * h for i, j in lattice]
    nodes = np.stack([x, rows * h * math.sin(math.pi / 3)], axis=1)
    upward = [[(i, j), (i + 1, j), (i, j + 1)] for i, j in lattice]
    downward = [[(i + 1, j), (i + 1, j + 1), (i, j + 1)] for i, j in lattice]
    whole = [cell for cell in upward + downward if all(place in number for place in cell)]
    cells = [[number[place] for place in cell] for cell in whole]
    return nodes, np.array(cells)


def landed(count: int, end: float = 8e-4) -> tuple[Array, float]:
    """Velocity of the centre and spin after the landing, by central differences.

    Constant strains, lumped masses, plane strain; nodes that would sink in are stopped.
    """
    nodes, cells = hexagon(count)
    lame = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    shear = YOUNG / (2 * (1 + POISSON))
    edges = np.stack([nodes[cells[:, k]] - nodes[cells[:, 0]] for k in (1, 2)], axis=2)
    areas, inverse = np.linalg.det(edges) / 2, np.linalg.inv(edges)
    gradients = np.concatenate([-inverse.sum(axis=1)[:, None], inverse], axis=1)
    mass = np.zeros(len(nodes))
    np.add.at(mass, cells, (DENSITY * areas / 3)[:, None])
    arm = nodes - mass @ nodes / mass.sum()
    v, x = VELOCITY + SPIN * np.stack([arm[:, 1], -arm[:, 0]], axis=1), nodes.copy()
    dt = 0.3 * SIDE / count / math.sqrt((lame + 2 * shear) / DENSITY)
    below = np.flatnonzero(nodes[:, 1] == 0.0)
    for _ in range(round(end / dt)):
        gradient = np.einsum("eai,eaj->eij", x[cells], gradients)
        strain = (np.einsum("eki,ekj->eij", gradient, gradient) - np.eye(2)) / 2
        trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
        stress = gradient @ (lame * trace * np.eye(2) + 2 * shear * strain)
        force = np.zeros_like(x)
        np.add.at(force, cells, -np.einsum("e,eij,eaj->eai", areas, stress, gradients))
        v += dt * force / mass[:, None]
        hit = below[x[below, 1] + dt * v[below, 1] < 0]
        stop = -x[hit, 1] / dt - v[hit, 1]
        v[hit, 1] += stop
        v[hit, 0] -= np.clip(v[hit, 0], -FRICTION * stop, FRICTION * stop)
        x += dt * v
    arm = x - mass @ x / mass.sum()
    turning = mass @ (arm[:, 1] * v[:, 0] - arm[:, 0] * v[:, 1])
    return mass @ v / mass.sum(), float(turning / (mass @ (arm**2).sum(axis=1)))


def test_an_elastic_side_lands_as_an_explicit_scheme_has_it() -> None:
    """To the 4 % that cells of 30 mm leave.

    The spin is off by 17, 7, 2.4 and 1.3 % for 150, 60, 30 and 20 mm.
    """
    block = {"density": DENSITY, "young": YOUNG, "poisson": POISSON, "shape": {"regular": 6}}
    block |= {"width": 2 * SIDE, "velocity": list(VELOCITY), "angular_velocity": SPIN}
    tables = {"gravity": 0.0, "contact": {"friction": FRICTION}, "damping": {"stiffness": 0.0}}
    tables |= {"block": [block | {"cell_size": 0.03}], "time": {"end": 0.0012}}
    result = simulate(parse_scene(tables | {"output": {"fields": "none"}}))
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9
    rows = result.history["time_s"] > 8e-4
    time = result.history["time_s"][rows]
    found = [
        np.polyfit(time, result.history[f"block.{key}"][rows], 1)[0]
        for key in ("centre_x_m", "centre_y_m", "angle_rad")
    ]
    velocity, spin = landed(16)
    assert found[:2] == pytest.approx(list(velocity), rel=0.04)
    assert found[2] == pytest.approx(spin, rel=0.04)
    corner = velocity[1] - spin * SIDE / 2, VELOCITY[1] - SPIN * SIDE / 2
    assert -corner[0] / corner[1] == pytest.approx(0.72, abs=0.05)
