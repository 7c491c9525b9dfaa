"""Positions and tractions of contact points, and forces on the nodes: one pass each, compiled.

The rows of an evaluation reach the nodes of one cell only, so that a pass takes as long as there
are evaluations, whatever the size of the body.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.law.compiled import compiled
from solver.types import Array, Indices


class SurfaceRows(NamedTuple):
    """What turns displacements into positions and tractions: e evaluations that make p points."""

    nodes: Indices
    """Nodes that each evaluation reaches, (e, k)."""
    values: Array
    """Their shape functions N there, (e, k)."""
    gradients: Array
    """And the derivatives of these, (e, k, d), 1/m."""
    point: Indices
    """The point that each evaluation belongs to, (e,)."""
    share: Array
    """Its weight in the averages of that point, (e,)."""
    stress_rows: Array
    """D with S N = D (2 E), (e, d, d d), Pa."""
    reference: Array
    """Positions of the points in the undeformed body, (p, d), m."""


class NitscheState(NamedTuple):
    """What a surface knows of one configuration: positions and nominal tractions of its points."""

    position: Array
    """x, (p, d), m."""
    traction: Array
    """T = F S N, (p, d), Pa, averaged over the evaluations of a point."""
    deformation: Array
    """F, (e, d, d)."""
    normal_stress: Array
    """S N, second Piola-Kirchhoff stress on the normal, (e, d), Pa."""


def new_state(rows: SurfaceRows) -> NitscheState:
    """Room for what a surface knows of one configuration.

    Compiled code fills it, as all arrays here: each one that it returned would cost a microsecond.
    """
    evaluations, (count, d) = len(rows.nodes), rows.reference.shape
    place, each = (count, d), (evaluations, d)
    return NitscheState(np.empty(place), np.empty(place), np.empty((*each, d)), np.empty(each))


@compiled
def evaluate(rows: SurfaceRows, displacement: Array, state: NitscheState) -> None:
    """Fill in positions and tractions for displacements of the nodes, (n, d)."""
    nodes, values, gradients, point, share, stress_rows, reference = rows
    position, traction, deformation, stress = state
    d = displacement.shape[1]
    gradient, twice = np.empty((d, d)), np.empty((d, d))
    position[:], traction[:], stress[:] = reference, 0.0, 0.0
    for e in range(len(nodes)):
        p, gradient[:] = point[e], 0.0
        for a in range(nodes.shape[1]):
            for i in range(d):
                moved = displacement[nodes[e, a], i]
                position[p, i] += share[e] * values[e, a] * moved
                for j in range(d):
                    gradient[i, j] += moved * gradients[e, a, j]
        # 2 E = H + H^T + H^T H with H = F - I: F^T F - I would lose the digits of small strains.
        for i in range(d):
            for j in range(d):
                twice[i, j] = gradient[i, j] + gradient[j, i]
                for k in range(d):
                    twice[i, j] += gradient[k, i] * gradient[k, j]
        for i in range(d):
            gradient[i, i] += 1.0
            for j in range(d):
                for k in range(d):
                    stress[e, i] += stress_rows[e, i, d * j + k] * twice[j, k]
        for i in range(d):
            for j in range(d):
                deformation[e, i, j] = gradient[i, j]
                traction[p, i] += share[e] * gradient[i, j] * stress[e, j]


@compiled
def point_values(rows: SurfaceRows, nodal: Array, found: Array) -> None:
    """Fill in what values of the nodes, (n, d), are at the points, (p, d)."""
    found[:] = 0.0
    for e in range(len(rows.nodes)):
        p = rows.point[e]
        for a in range(rows.nodes.shape[1]):
            factor = rows.share[e] * rows.values[e, a]
            for i in range(nodal.shape[1]):
                found[p, i] += factor * nodal[rows.nodes[e, a], i]


@compiled
def add_point_forces(rows: SurfaceRows, force: Array, nodal: Array) -> None:
    """Add forces at the points, (p, d), to those on the nodes, (n, d)."""
    for e in range(len(rows.nodes)):
        p = rows.point[e]
        for a in range(rows.nodes.shape[1]):
            factor = rows.share[e] * rows.values[e, a]
            for i in range(nodal.shape[1]):
                nodal[rows.nodes[e, a], i] += factor * force[p, i]


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
    rows: SurfaceRows, old: NitscheState, new: NitscheState, vector: Array, nodal: Array
) -> None:
    """Add vectors (p, d) times the discrete gradient of the traction to forces on nodes, (n, d).

    With F at the mean of both states and the increment of S through it, DT[u_new - u_old] is
    exactly T_new - T_old: work against a traction is a difference of states (after Simo and Tarnow
    1992).
    """
    nodes, _, gradients, point, share, stress_rows, _ = rows
    d = vector.shape[1]
    middle, outer, weighted = np.empty((d, d)), np.empty((d, d)), np.empty(d)
    for e in range(len(nodes)):
        for i in range(d):
            weighted[i] = share[e] * vector[point[e], i]
        outer[:] = 0.0
        for i in range(d):
            for j in range(d):
                middle[i, j] = 0.5 * (old.deformation[e, i, j] + new.deformation[e, i, j])
        for k in range(d):
            along = 0.0
            for i in range(d):
                along += weighted[i] * middle[i, k]
            for j in range(d):
                for m in range(d):
                    virtual = 2.0 * along * stress_rows[e, k, d * j + m]
                    for i in range(d):
                        outer[j, i] += virtual * middle[i, m]
        for j in range(d):
            stress = 0.5 * (old.normal_stress[e, j] + new.normal_stress[e, j])
            for i in range(d):
                outer[j, i] += stress * weighted[i]
        for a in range(nodes.shape[1]):
            for j in range(d):
                for i in range(d):
                    nodal[nodes[e, a], i] += gradients[e, a, j] * outer[j, i]


class TractionPull(NamedTuple):
    """What the gradient of the traction is multiplied by: scale (w T - w_c f), T averaged."""

    scale: Array
    """theta/gamma_h, (p,), m/Pa."""
    weight: Array
    """w, (p,), m or m2."""
    force: Array
    """w_c f, (p, d), N: normal, tangential."""
    frame: Array
    """Rows normal and tangents that they are given in, (d, d)."""
    old: float
    """Weight of the traction at t_n: alpha_f, or 0 to leave the theta term out."""
    new: float
    """At t_{n+1}: 1 - alpha_f, or 0."""


@compiled
def add_traction_forces(
    rows: SurfaceRows, old: NitscheState, new: NitscheState, pull: TractionPull, nodal: Array
) -> None:
    """Add a pull times the discrete gradient of the traction to forces on nodes, (n, d)."""
    vector = np.empty_like(pull.force)
    for p in range(len(vector)):
        for i in range(vector.shape[1]):
            averaged = pull.new * new.traction[p, i] + pull.old * old.traction[p, i]
            vector[p, i] = pull.weight[p] * averaged
            for k in range(vector.shape[1]):
                vector[p, i] -= pull.force[p, k] * pull.frame[k, i]
            vector[p, i] *= pull.scale[p]
    add_traction_gradient(rows, old, new, vector, nodal)


@compiled
def add_contact_forces(
    rows: SurfaceRows,
    old: NitscheState,
    new: NitscheState,
    force: Array,
    pull: TractionPull,
    nodal: Array,
) -> None:
    """Add forces at the points, as vectors in space (p, d), and those of a pull to nodal ones."""
    add_point_forces(rows, force, nodal)
    add_traction_forces(rows, old, new, pull, nodal)
