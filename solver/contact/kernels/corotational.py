"""Motions of a meshed body in the frame that turns with it; compiled.

Nodes are d numbers each, one after another. How a body is turned, its `turns`, are three matrices,
(3, d, d): R at the end of a step, R_m in its middle, and the shift S = (R^T R_m - I)/(w m), m/N,
which moves all nodes by what their forces make together.
"""

from __future__ import annotations

import numpy as np

from solver.bodies.kinematics import polar_factor
from solver.law.compiled import compiled
from solver.types import Array, Indices, Mask


@compiled
def into_frame(vectors: Array, turns: Array, factor: float, turned: Array, total: Array) -> None:
    """Fill in multiples of R_m^T x of vectors x, (n d,), and their sum (d,).

    Args:
        vectors: x, one after another, (n d,).
        turns: Of the body.
        factor: What they are multiplied by.
        turned: (n d,).
        total: Their sum, (d,).
    """
    d, rotation = len(total), turns[1]
    total[:] = 0.0
    for n in range(0, len(turned), d):
        for j in range(d):
            along = 0.0
            for i in range(d):
                along += rotation[i, j] * vectors[n + i]
            turned[n + j] = factor * along
            total[j] += factor * along


@compiled
def shifted(shift: Array, push: Array) -> Array:
    """Displacement of all nodes alike by a push (d,): S p, (d,)."""
    shift_by = np.zeros(len(push))
    for j in range(len(push)):
        for i in range(len(push)):
            shift_by[j] += shift[j, i] * push[i]
    return shift_by


@compiled
def point_vectors(
    force: Array, weight: float, frames: Array, rotation: Array, vectors: Array
) -> None:
    """Fill in `weight` times forces (m, d) in frames (m, d, d), as vectors in a turned frame."""
    m, d = force.shape
    space = np.empty(d)
    vectors[:] = 0.0
    for p in range(m):
        space[:] = 0.0
        for k in range(d):
            for i in range(d):
                space[i] += weight * force[p, k] * frames[p, k, i]
        for i in range(d):
            for j in range(d):
                vectors[p, j] += space[i] * rotation[i, j]


@compiled
def moved_with_strain(
    nodes: Array,
    push: Array,
    strain: Array,
    vectors: Array,
    turns: Array,
    moved: Array,
) -> None:
    """Fill in R (x + S p) where forces (m, d) add strain, (n d,), and push, as vectors (n d,)."""
    d, rotation, total = len(push), turns[0], np.zeros(len(push))
    for p in range(len(vectors)):
        total += vectors[p]
    shift_by, further = shifted(turns[2], push), shifted(turns[2], total)
    for n in range(0, len(nodes), d):
        for i in range(d):
            along = 0.0
            for j in range(d):
                added = strain[n + j] + further[j]
                along += rotation[i, j] * ((nodes[n + j] + shift_by[j]) + added)
            moved[n + i] = along


@compiled
def out_of_frame(nodes: Array, push: Array, turns: Array, vectors: Array) -> None:
    """Fill in R (x + S p), vectors one after another in (n d,)."""
    strain, nothing = np.zeros(len(vectors)), np.empty((0, len(push)))
    moved_with_strain(nodes, push, strain, nothing, turns, vectors)


@compiled
def add_places(
    moved: Array, first: int, sign: float, motions: Array, frame: Array, rotation: Array
) -> None:
    """Add motions of points in the frame of their body to their places over a carrier.

    Args:
        moved: Places of all points, (points, d), m.
        first: Number of the first of these points.
        sign: 1; -1 where the body carries the points.
        motions: In the body's frame, (m, d), m.
        frame: Rows normal and tangents, one for all points, (1, d, d), or one for each, (m, d, d).
        rotation: R of the body, (d, d).
    """
    m, d = motions.shape
    turned = np.empty((d, d))
    for p in range(m):
        if p < len(frame):
            turned[:] = 0.0
            for i in range(d):
                for k in range(d):
                    for j in range(d):
                        turned[i, j] += frame[p, i, k] * rotation[k, j]
        for i in range(d):
            for j in range(d):
                moved[first + p, i] += sign * turned[i, j] * motions[p, j]


@compiled
def read_points(
    start: Indices,
    column: Indices,
    weight: Array,
    nodes: Array,
    push: Array,
    shift: Array,
    read: Array,
) -> None:
    """Fill in what sparse rows read from a motion x + S p: of points, (m, d), row after row.

    Args:
        start: Place of the first entry of each row, and their end, (m d + 1,).
        column: Number of the unknown of each entry.
        weight: By which it counts.
        nodes: x, (n d,), m.
        push: p, (d,), N.
        shift: S, (d, d), m/N.
        read: (m, d).
    """
    (m, d), shift_by = read.shape, shifted(shift, push)
    for p in range(m):
        for i in range(d):
            total = 0.0
            for a in range(start[p * d + i], start[p * d + i + 1]):
                total += weight[a] * (nodes[column[a]] + shift_by[column[a] % d])
            read[p, i] = total


@compiled
def add_readings(
    moved: Array,
    first: int,
    sign: float,
    start: Indices,
    column: Indices,
    weight: Array,
    nodes: Array,
    push: Array,
    frame: Array,
    turns: Array,
) -> None:
    """Add to places of points what rows as of `read_points` read; otherwise as `add_places`."""
    d = len(push)
    read = np.empty((len(start) // d, d))
    read_points(start, column, weight, nodes, push, turns[2], read)
    add_places(moved, first, sign, read, frame, turns[0])


@compiled
def mark_ports(
    near: Indices, first: int, count: int, port: int, nodes: Indices, used: Mask
) -> None:
    """Mark the ports that near points of an interface act on.

    Args:
        near: Numbers of the near points of all interfaces, rising, (m,).
        first: Number of the first point of this one.
        count: Number of its points.
        port: Number of the first port that they may act on.
        nodes: Which ones each of them does, counted from there, (count, k).
        used: The ports, (ports,).
    """
    for p in near:
        if first <= p < first + count:
            for a in range(nodes.shape[1]):
                used[port + nodes[p - first, a]] = True


@compiled
def add_loads(
    near: Indices,
    first: int,
    count: int,
    port: int,
    nodes: Indices,
    weights: Array,
    sign: float,
    ports: Indices,
    load: Array,
) -> None:
    """Add how much of their forces near points of an interface put on ports to `load`.

    Args:
        near: As in `mark_ports`, like all up to `nodes`.
        first: Of the interface.
        count: Of the interface.
        port: Of the body.
        nodes: Of each point.
        weights: How much each port gets, (count, k).
        sign: Of all of them.
        ports: Those in `load`, rising.
        load: (m, ports).
    """
    for i in range(len(near)):
        p = near[i] - first
        if 0 <= p < count:
            for a in range(nodes.shape[1]):
                place = np.searchsorted(ports, port + nodes[p, a])
                load[i, place] += sign * weights[p, a]


@compiled
def add_compliance(
    W: Array,
    weight: float,
    frames: Array,
    turns: Array,
    C: Array,
    share: Array,
) -> None:
    """Add `weight` times the compliance of a turned body among points to W, (m, d, m, d).

    Args:
        W: What is added to, m/N.
        weight: w_c.
        frames: Rows normal and tangents at each point, (m, d, d).
        turns: Of the body.
        C: Its compliance in the frame that turns with it, (m, d, m, d), m/N.
        share: How much of each point's force the body gets, (m,).
    """
    (m, d), shift = frames.shape[:2], turns[2]
    moved, pushed = np.zeros_like(frames), np.zeros_like(frames)
    for p in range(m):
        for i in range(d):
            for k in range(d):
                for j in range(d):
                    moved[p, i, k] += frames[p, i, j] * turns[0][j, k]
                    pushed[p, i, k] += frames[p, i, j] * turns[1][j, k]
    half = np.empty((d, d))
    for p in range(m):
        for q in range(m):
            half[:] = 0.0
            for k in range(d):
                for j in range(d):
                    for n in range(d):
                        own = C[p, k, q, n] + share[p] * share[q] * shift[k, n]
                        half[k, j] += own * pushed[q, j, n]
            for i in range(d):
                for j in range(d):
                    for k in range(d):
                        W[p, i, q, j] += weight * moved[p, i, k] * half[k, j]


@compiled
def turn(start: Array, rotation: Array, inertia: float, turns: Array) -> None:
    """Fill in how a body is turned.

    Args:
        start: Rotation at the start of the step, (d, d).
        rotation: R, at its end, (d, d).
        inertia: w m, N/m.
        turns: R, R_m and S.
    """
    d, middle, shift = len(rotation), turns[1], turns[2]
    turns[0] = rotation
    polar_factor(start + rotation, middle)
    for i in range(d):
        for j in range(d):
            shift[i, j] = -1.0 if i == j else 0.0
            for k in range(d):
                shift[i, j] += rotation[k, i] * middle[k, j]
            shift[i, j] /= inertia


@compiled
def largest_turn(now: Array, before: Array) -> float:
    """Largest change of the entries of both rotations between two `turns` of a body."""
    largest = 0.0
    for k in range(2):
        for i in range(now.shape[1]):
            for j in range(now.shape[2]):
                largest = max(largest, abs(now[k, i, j] - before[k, i, j]))
    return largest
