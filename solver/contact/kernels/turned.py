"""Motions of a meshed body in the frame that turns with it; compiled.

Nodes are rows of d numbers; a shift is the d x d matrix that moves all of them by what their forces
make together.
"""

from __future__ import annotations

import numpy as np

from solver.bodies.kernels.rotation import polar_factor
from solver.law.compiled import compiled
from solver.types import Array, Indices, Mask


@compiled
def into_frame(vectors: Array, rotation: Array, turned: Array, total: Array) -> None:
    """Fill in R^T x of vectors x, one after another in (n d,), as rows (n, d), and their sum (d,).

    Args:
        vectors: x, (n d,).
        rotation: R, (d, d).
        turned: R^T x, (n, d).
        total: Their sum, (d,).
    """
    d = len(total)
    total[:] = 0.0
    for n in range(len(turned)):
        for j in range(d):
            along = 0.0
            for i in range(d):
                along += rotation[i, j] * vectors[n * d + i]
            turned[n, j] = along
            total[j] += along


@compiled
def out_of_frame(turned: Array, rotation: Array, vectors: Array) -> None:
    """Fill in R x of rows x, (n, d), as vectors one after another in (n d,)."""
    d = len(rotation)
    for n in range(len(turned)):
        for i in range(d):
            along = 0.0
            for j in range(d):
                along += rotation[i, j] * turned[n, j]
            vectors[n * d + i] = along


@compiled
def free_step(motion: Array, shift: Array, total: Array) -> None:
    """Let a motion (n, d), K_0^-1 r, become -(K_0^-1 + S) r in place, with the sum of r, (d,)."""
    d = len(total)
    for j in range(d):
        along = 0.0
        for i in range(d):
            along += shift[j, i] * total[i]
        for n in range(len(motion)):
            motion[n, j] = -(motion[n, j] + along)


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
def add_motion(motion: Array, strain: Array, shift: Array, vectors: Array) -> None:
    """Add to a motion (n, d) one with strain, (n d,), and the shift by forces, (m, d)."""
    d = motion.shape[1]
    for j in range(d):
        along = 0.0
        for p in range(len(vectors)):
            for i in range(d):
                along += shift[j, i] * vectors[p, i]
        for n in range(len(motion)):
            motion[n, j] += strain[n * d + j] + along


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
def read_points(start: Indices, column: Indices, weight: Array, motion: Array, read: Array) -> None:
    """Fill in what sparse rows read from a motion: of points, (m, d), row after row.

    Args:
        start: Place of the first entry of each row, and their end, (m d + 1,).
        column: Number of the unknown of each entry.
        weight: By which it counts.
        motion: The unknowns, (n d,).
        read: (m, d).
    """
    m, d = read.shape
    for p in range(m):
        for i in range(d):
            total = 0.0
            for a in range(start[p * d + i], start[p * d + i + 1]):
                total += weight[a] * motion[column[a]]
            read[p, i] = total


@compiled
def add_readings(
    moved: Array,
    first: int,
    sign: float,
    start: Indices,
    column: Indices,
    weight: Array,
    motion: Array,
    frame: Array,
    rotation: Array,
) -> None:
    """Add to places of points what rows as of `read_points` read; otherwise as `add_places`."""
    d = len(rotation)
    read = np.empty((len(start) // d, d))
    read_points(start, column, weight, motion, read)
    add_places(moved, first, sign, read, frame, rotation)


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
    column: Indices,
    load: Array,
) -> None:
    """Add how much of their forces near points of an interface put on ports to `load`.

    Args:
        near: As in `mark_ports`, like all up to `nodes`.
        first: Of the interface.
        count: Of the interface.
        port: Of the body.
        nodes: Of each point.
        weights: How much each port gets, with its sign, (count, k).
        column: Place of each port in `load`, (ports,).
        load: (m, places).
    """
    for i in range(len(near)):
        p = near[i] - first
        if 0 <= p < count:
            for a in range(nodes.shape[1]):
                load[i, column[port + nodes[p, a]]] += weights[p, a]


@compiled
def add_compliance(
    W: Array,
    weight: float,
    frames: Array,
    turns: tuple[Array, Array],
    C: Array,
    share: Array,
    shift: Array,
) -> None:
    """Add `weight` times the compliance of a turned body among points to W, (m, d, m, d).

    Args:
        W: What is added to, m/N.
        weight: w_c.
        frames: Rows normal and tangents at each point, (m, d, d).
        turns: Rotations R and R_m of the body, (d, d) each.
        C: Its compliance in the frame that turns with it, (m, d, m, d), m/N.
        share: How much of each point's force the body gets, (m,).
        shift: S, (d, d), m/N.
    """
    m, d = frames.shape[:2]
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
def middle_of(start: Array, rotation: Array, inertia: float, middle: Array, shift: Array) -> None:
    """Fill in the rotation R_m in the middle of a step, and the shift S = (R^T R_m - I)/(w m).

    Args:
        start: Rotation at its start, (d, d).
        rotation: R, at its end, (d, d).
        inertia: w m, N/m.
        middle: R_m, (d, d).
        shift: S, (d, d), m/N.
    """
    d = len(rotation)
    polar_factor(start + rotation, middle)
    for i in range(d):
        for j in range(d):
            shift[i, j] = -1.0 if i == j else 0.0
            for k in range(d):
                shift[i, j] += rotation[k, i] * middle[k, j]
            shift[i, j] /= inertia


@compiled
def largest_change(end: Array, end_before: Array, middle: Array, middle_before: Array) -> float:
    """Largest change of the entries of two matrices, at the end and in the middle of a step."""
    largest = 0.0
    for i in range(end.shape[0]):
        for j in range(end.shape[1]):
            largest = max(largest, abs(end[i, j] - end_before[i, j]))
            largest = max(largest, abs(middle[i, j] - middle_before[i, j]))
    return largest
