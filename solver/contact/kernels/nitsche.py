"""Positions and tractions of contact points, and forces on the nodes: one pass each, compiled.

The rows of an evaluation reach the nodes of one cell only, so that a pass takes as long as there
are evaluations, whatever the size of the body. Python hands over few arrays: each one costs a fifth
of a microsecond at every call.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Indices


class SurfaceRows(NamedTuple):
    """Rows from displacements to positions and tractions: e evaluations that make p points."""

    numbers: Indices
    """The point that each evaluation belongs to, and the nodes that it reaches, (e, 1 + k)."""
    table: Array
    """Numbers of each evaluation, one after another, (e, 1 + k + k d + d d d): its weight in the
    averages of its point, the shape functions N of the nodes, their derivatives, 1/m, and D with
    S N = D (2 E), Pa."""
    reference: Array
    """Positions of the points in the undeformed body, (p, d), m."""

    @classmethod
    def of(
        cls,
        *,
        nodes: Indices,
        values: Array,
        gradients: Array,
        point: Indices,
        share: Array,
        stress_rows: Array,
        reference: Array,
    ) -> SurfaceRows:
        """The parts, as the fields name them, put together."""
        e = len(nodes)
        parts = share[:, None], values, gradients.reshape(e, -1), stress_rows.reshape(e, -1)
        numbers = np.column_stack([point, nodes]).astype(np.int64)
        return cls(numbers, np.concatenate(parts, axis=1), np.ascontiguousarray(reference))


class NitscheState(NamedTuple):
    """Positions and nominal tractions of the points of a surface in one configuration."""

    values: Array
    """All of it, (2 p + e (d + 1), d): x and T of all points, and for each evaluation F and S N,
    the second Piola-Kirchhoff stress on the normal, Pa."""
    position: Array
    """x, (p, d), m."""
    traction: Array
    """T = F S N, (p, d), Pa, averaged over the evaluations of a point."""


def new_state(rows: SurfaceRows) -> NitscheState:
    """Room for the state of a surface.

    Compiled code fills it, as all arrays here: each one that it returned would cost a microsecond.
    """
    p, d = rows.reference.shape
    values = np.empty((2 * p + len(rows.numbers) * (d + 1), d))
    return NitscheState(values, values[:p], values[p : 2 * p])


@compiled
def evaluate(
    index: Indices, table: Array, reference: Array, displacement: Array, state: Array
) -> None:
    """Fill in the values of a `NitscheState` for displacements of the nodes, (n, d)."""
    d, k, points = displacement.shape[1], index.shape[1] - 1, len(reference)
    slopes, stiff = 1 + k, 1 + k + k * d
    gradient, twice = np.empty((d, d)), np.empty((d, d))
    state[:points], state[points : 2 * points] = reference, 0.0
    for e in range(len(index)):
        p, share, own = index[e, 0], table[e, 0], 2 * points + e * (d + 1)
        gradient[:] = 0.0
        for a in range(k):
            for i in range(d):
                moved = displacement[index[e, 1 + a], i]
                state[p, i] += share * table[e, 1 + a] * moved
                for j in range(d):
                    gradient[i, j] += moved * table[e, slopes + d * a + j]
        # 2 E = H + H^T + H^T H with H = F - I: F^T F - I would lose the digits of small strains.
        for i in range(d):
            for j in range(d):
                twice[i, j] = gradient[i, j] + gradient[j, i]
                for m in range(d):
                    twice[i, j] += gradient[m, i] * gradient[m, j]
        for i in range(d):
            gradient[i, i] += 1.0
            stress = 0.0
            for j in range(d):
                for m in range(d):
                    stress += table[e, stiff + d * (d * i + j) + m] * twice[j, m]
            state[own + d, i] = stress
        for i in range(d):
            for j in range(d):
                state[own + i, j] = gradient[i, j]
                state[points + p, i] += share * gradient[i, j] * state[own + d, j]


@compiled
def point_values(index: Indices, table: Array, nodal: Array, found: Array) -> None:
    """Fill in what values of the nodes, (n, d), are at the points, (p, d)."""
    found[:] = 0.0
    for e in range(len(index)):
        p = index[e, 0]
        for a in range(1, index.shape[1]):
            factor = table[e, 0] * table[e, a]
            for i in range(nodal.shape[1]):
                found[p, i] += factor * nodal[index[e, a], i]


@compiled
def add_point_forces(index: Indices, table: Array, force: Array, nodal: Array) -> None:
    """Add forces at the points, (p, d), to those on the nodes, (n, d)."""
    for e in range(len(index)):
        p = index[e, 0]
        for a in range(1, index.shape[1]):
            factor = table[e, 0] * table[e, a]
            for i in range(nodal.shape[1]):
                nodal[index[e, a], i] += factor * force[p, i]


@compiled
def augment(place: Array, traction: Array, inverse_gamma: Array, frame: Array, y: Array) -> None:
    """Fill in augmented positions y = (g, s) - T/gamma_h, (p, d), m.

    Args:
        place: (g, s), (p, d), m.
        traction: T, (p, d), Pa.
        inverse_gamma: 1/gamma_h, (p,), m/Pa.
        frame: Rows normal and tangents, (d, d).
        y: (p, d), m.
    """
    y[:] = place
    for p in range(len(y)):
        for i in range(y.shape[1]):
            for j in range(y.shape[1]):
                y[p, i] -= inverse_gamma[p] * frame[i, j] * traction[p, j]


@compiled
def add_traction_gradient(
    index: Indices, table: Array, old: Array, new: Array, vector: Array, nodal: Array
) -> None:
    """Add vectors (p, d) times the discrete gradient of the traction to forces on nodes, (n, d).

    With F at the mean of both states and the increment of S through it, DT[u_new - u_old] is
    exactly T_new - T_old: work against a traction is a difference of states (after Simo and Tarnow
    1992). Both are the values of a `NitscheState`.
    """
    points, d = vector.shape
    k = index.shape[1] - 1
    slopes, stiff = 1 + k, 1 + k + k * d
    middle, outer, weighted = np.empty((d, d)), np.empty((d, d)), np.empty(d)
    for e in range(len(index)):
        own = 2 * points + e * (d + 1)
        for i in range(d):
            weighted[i] = table[e, 0] * vector[index[e, 0], i]
        outer[:] = 0.0
        for i in range(d):
            for j in range(d):
                middle[i, j] = 0.5 * (old[own + i, j] + new[own + i, j])
        for n in range(d):
            along = 0.0
            for i in range(d):
                along += weighted[i] * middle[i, n]
            for j in range(d):
                for m in range(d):
                    virtual = 2.0 * along * table[e, stiff + d * (d * n + j) + m]
                    for i in range(d):
                        outer[j, i] += virtual * middle[i, m]
        for j in range(d):
            stress = 0.5 * (old[own + d, j] + new[own + d, j])
            for i in range(d):
                outer[j, i] += stress * weighted[i]
        for a in range(k):
            node = index[e, 1 + a]
            for j in range(d):
                for i in range(d):
                    nodal[node, i] += table[e, slopes + d * a + j] * outer[j, i]


class TractionPull(NamedTuple):
    """Factor of the gradient of the traction: theta/gamma_h (w T - w_c f)."""

    scale: Array
    """theta w/gamma_h, m2/Pa or m3/Pa, and theta/gamma_h, m/Pa, (p, 2)."""
    force: Array
    """w_c f, (p, d), N: normal, tangential."""
    frame: Array
    """Rows normal and tangents that they are given in, (d, d)."""
    old: float
    """Weight of the traction at t_n: alpha_f, or 0 to leave the theta term out."""
    new: float
    """At t_{n+1}: 1 - alpha_f, or 0."""


@compiled
def add_contact_forces(
    index: Indices,
    table: Array,
    old: Array,
    new: Array,
    vectors: Array,
    scale: Array,
    force: Array,
    frame: Array,
    old_weight: float,
    new_weight: float,
    nodal: Array,
) -> None:
    """Add forces at the points, as vectors in space (p, d), and those of a pull to nodal ones.

    Rows, the values of both states, the vectors, the fields of a `TractionPull`, forces on nodes.
    """
    (points, d), pulled = vectors.shape, np.empty_like(vectors)
    for p in range(points):
        for i in range(d):
            averaged = new_weight * new[points + p, i] + old_weight * old[points + p, i]
            pulled[p, i] = scale[p, 0] * averaged
            for k in range(d):
                pulled[p, i] -= scale[p, 1] * force[p, k] * frame[k, i]
    add_point_forces(index, table, vectors, nodal)
    add_traction_gradient(index, table, old, new, pulled, nodal)
