"""How the feet of contact points go over a face within a step, and what follows; compiled.

With the shape functions N at the feet before and after, the nodes x_c of the face, the frame (n, t)
of the step, bars for means and d for increments over the step (docs/method.md, "What carries"),

    e = dN . mean x_c = (e_n, e_t)                the way of the foot over the mean surface
    dg = (n - kappa t) . (dx - mean N dx_c),      kappa = e_n/e_t        the mean slope
    ds = (t/a) . (dx - mean N dx_c),              a = e_t/ds             the mean stretch

hold exactly, whatever the step and however many facets it crosses.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solver.contact.kernels.shapes import inverted
from solver.law.compiled import compiled
from solver.types import Array, Indices

STANDING_STILL = 1e-4
"""Part of a facet: a foot that moves by less has the local slope and stretch, one that moves by
twice as much or more those of its way; between the two they go over from one to the other."""


class Stand(NamedTuple):
    """Where points stand on a face at one instant."""

    nodes: Indices
    """Nodes of the facet of each point, (m, k)."""
    weights: Array
    """Shape functions N of these there, (m, k)."""
    slope: Array
    """Rise of the face along the tangents of the frame, (m, d-1)."""
    stretch: Array
    """Current over undeformed tangential lengths, (m, d-1, d-1)."""
    place: Array
    """(g, s), (m, d), m."""
    position: Array
    """Where the nodes of the face are, (n, d), m."""


StandArrays = tuple[Indices, Array, Array, Array, Array, Array]
"""The fields of a `Stand` as Python hands them over: without names they take half the time."""


@compiled
def interpolated(nodes: Indices, weights: Array, values: Array, found: Array) -> None:
    """Fill in what nodal values (n, d) are at places (m, d), by nodes and weights (m, k)."""
    found[:] = 0.0
    for p in range(len(nodes)):
        for a in range(nodes.shape[1]):
            for i in range(values.shape[1]):
                found[p, i] += weights[p, a] * values[nodes[p, a], i]


@compiled
def add_spread(
    nodes: Indices, weights: Array, factor: float, vectors: Array, target: Array
) -> None:
    """Add a factor times forces at places, (m, d), to those on the nodes, (n, d)."""
    for p in range(len(nodes)):
        for a in range(nodes.shape[1]):
            for i in range(vectors.shape[1]):
                target[nodes[p, a], i] += factor * weights[p, a] * vectors[p, i]


@compiled
def foot_way(
    p: int,
    old: Stand,
    new: Stand,
    frame: Array,
    facet: float,
    way: Array,
    ds: Array,
    kappa: Array,
    a: Array,
) -> float:
    """Fill in the way of the foot of point p; returns how far slope and stretch are those of it.

    Args:
        p: Number of the point.
        old: Stand at t_n.
        new: At t_{n+1}.
        frame: Rows normal and tangents of the face, (d, d).
        facet: Length of the smallest facet, m.
        way: e = (e_n, e_t), (d,), m.
        ds: Way in the undeformed face, (d-1,), m.
        kappa: Slope: that of the way where the foot moves, else of the surface there, (d-1,).
        a: Stretch likewise, (d-1, d-1).
    """
    d, moved = len(frame), np.zeros(len(frame))
    for k in range(new.nodes.shape[1]):
        first, last = old.nodes[p, k], new.nodes[p, k]
        for i in range(d):
            before = 0.5 * (old.position[first, i] + new.position[first, i])
            after = 0.5 * (old.position[last, i] + new.position[last, i])
            moved[i] += new.weights[p, k] * after - old.weights[p, k] * before
    way[:] = 0.0
    for i in range(d):
        for j in range(d):
            way[i] += frame[i, j] * moved[j]
    squares = along = 0.0
    for i in range(d - 1):
        ds[i] = new.place[p, 1 + i] - old.place[p, 1 + i]
        kappa[i] = 0.5 * (old.slope[p, i] + new.slope[p, i])
        squares, along = squares + ds[i] ** 2, along + way[1 + i] ** 2
        for j in range(d - 1):
            a[i, j] = 0.5 * (old.stretch[p, i, j] + new.stretch[p, i, j])
    share = min(max(math.sqrt(squares) / (STANDING_STILL * facet) - 1.0, 0.0), 1.0)
    if share > 0.0:
        # The least changes after which kappa . e_t = e_n and a ds = e_t.
        lift = way[0]
        for i in range(d - 1):
            lift -= kappa[i] * way[1 + i]
        for i in range(d - 1):
            kappa[i] += share * lift / along * way[1 + i]
            missing = way[1 + i]
            for j in range(d - 1):
                missing -= a[i, j] * ds[j]
            for j in range(d - 1):
                a[i, j] += share * missing * ds[j] / squares
    return share


@compiled
def forces_in_space(
    before: StandArrays,
    after: StandArrays,
    frame: Array,
    facet: float,
    force: Array,
    vectors: Array,
) -> None:
    """Fill in vectors in space (m, d) of normal and tangential forces, whose work is exact.

    They are f_n (n - kappa t) + a^-T f_t; arguments as in `foot_way`.
    """
    d, old, new = len(frame), Stand(*before), Stand(*after)
    way, ds, kappa, local = np.empty(d), np.empty(d - 1), np.empty(d - 1), np.empty(d)
    a, inverse = np.empty((d - 1, d - 1)), np.empty((d - 1, d - 1))
    vectors[:] = 0.0
    for p in range(len(force)):
        loaded = False
        for i in range(d):
            loaded = loaded or force[p, i] != 0.0
        if not loaded:
            continue
        foot_way(p, old, new, frame, facet, way, ds, kappa, a)
        inverted(a, inverse)
        local[0] = force[p, 0]
        for i in range(d - 1):
            local[1 + i] = -force[p, 0] * kappa[i]
            for j in range(d - 1):
                local[1 + i] += inverse[j, i] * force[p, 1 + j]
        for i in range(d):
            for j in range(d):
                vectors[p, j] += local[i] * frame[i, j]


@compiled
def work_defect(
    before: StandArrays, after: StandArrays, frame: Array, facet: float, force: Array
) -> float:
    """Work of these vectors less that of the forces (m, d), N, on (g, s), J.

    Only feet of closed points that hardly move have any: kappa . e_t is not e_n there,
    nor a^-1 e_t ds. Arguments as in `foot_way`.
    """
    d, total, old, new = len(frame), 0.0, Stand(*before), Stand(*after)
    way, ds, kappa = np.empty(d), np.empty(d - 1), np.empty(d - 1)
    a, inverse = np.empty((d - 1, d - 1)), np.empty((d - 1, d - 1))
    for p in range(len(force)):
        if not force[p, 0] > 0.0 or foot_way(p, old, new, frame, facet, way, ds, kappa, a) >= 1.0:
            continue
        inverted(a, inverse)
        total += force[p, 0] * way[0]
        for i in range(d - 1):
            drag = -ds[i]
            for j in range(d - 1):
                drag += inverse[i, j] * way[1 + j]
            total += force[p, 1 + i] * drag - force[p, 0] * kappa[i] * way[1 + i]
    return total
