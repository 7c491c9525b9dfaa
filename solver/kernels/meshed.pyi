"""Compiled functions of meshed bodies: what each does, with shapes and units.

Arrays are of float64 (`Array`), int64 (`Indices`) or bool (`Mask`), in one piece (C order). Those that
a function fills in are named so; it keeps none of them.
"""

from solver.types import Array, Indices, Mask

# ---- Surfaces of meshed bodies
#
# `numbers` and `table` are those of `SurfaceRows`; states are the values of a `NitscheState`.
# There are p points and n nodes.

def evaluate(
    numbers: Indices, table: Array, reference: Array, displacement: Array, state: Array
) -> None:
    """Fill in the values of a `NitscheState` for displacements of the nodes, (n, d), m.

    The first three arguments are the fields of `SurfaceRows`.
    """

def point_values(numbers: Indices, table: Array, nodal: Array, found: Array) -> None:
    """Fill in what values of the nodes, (n, d), are at the points, (p, d)."""

def add_point_forces(numbers: Indices, table: Array, force: Array, nodal: Array) -> None:
    """Add forces at the points, (p, d), to those on the nodes, (n, d), N."""

def augment(place: Array, traction: Array, inverse_gamma: Array, frame: Array, y: Array) -> None:
    """Fill in augmented positions y = (g, s) - T/gamma_h, (p, d), m.

    Args:
        place: (g, s), (p, d), m.
        traction: T, (p, d), Pa.
        inverse_gamma: 1/gamma_h, (p,), m/Pa.
        frame: Rows normal and tangents, (d, d).
        y: (p, d), m.
    """

def add_traction_gradient(
    numbers: Indices, table: Array, old: Array, new: Array, vector: Array, nodal: Array
) -> None:
    """Add vectors (p, d) times the discrete gradient of the traction to forces on nodes, (n, d).

    With F at the mean of both states and the increment of S through it, DT[u_new - u_old] is
    exactly T_new - T_old: work against a traction is a difference of states (after Simo and Tarnow
    1992).
    """

def add_contact_forces(
    numbers: Indices,
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
    """Add forces at the points, as vectors in space (p, d), and those of a pull to nodal ones, N.

    Args:
        numbers: Of the surface.
        table: Of the surface.
        old: State at t_n.
        new: State at t_{n+1}.
        vectors: The forces at the points, (p, d), N.
        scale: This and the following ones are the fields of a `TractionPull`.
        force: See there.
        frame: See there.
        old_weight: See there.
        new_weight: See there.
        nodal: Forces on the nodes, (n, d), which are added to, N.
    """

# ---- Motions of a meshed body in the frame that turns with it
#
# Nodes are d numbers each, one after another. How a body is turned, its `turns`, are three
# matrices, (3, d, d): R at the end of a step, R_m in its middle, and the shift
# S = (R^T R_m - I)/(w m), m/N, which moves all nodes by what their forces make together.

def turn(start: Array, rotation: Array, inertia: float, turns: Array) -> None:
    """Fill in how a body is turned.

    Args:
        start: Rotation at the start of the step, (d, d).
        rotation: R, at its end, (d, d).
        inertia: w m, N/m.
        turns: R, R_m and S, (3, d, d).
    """

def largest_turn(now: Array, before: Array) -> float:
    """Largest change of the entries of both rotations between two `turns` of a body."""

def into_frame(vectors: Array, turns: Array, factor: float, turned: Array, total: Array) -> None:
    """Fill in multiples of R_m^T x of vectors x, (n d,), and their sum (d,).

    Args:
        vectors: x, one after another, (n d,).
        turns: Of the body.
        factor: What they are multiplied by.
        turned: (n d,).
        total: Their sum, (d,).
    """

def out_of_frame(nodes: Array, push: Array, turns: Array, vectors: Array) -> None:
    """Fill in R (x + S p), vectors one after another in (n d,)."""

def moved_with_strain(
    nodes: Array, push: Array, strain: Array, vectors: Array, turns: Array, moved: Array
) -> None:
    """Fill in R (x + S p) where forces (m, d) add strain, (n d,), and push, as vectors (n d,)."""

def point_vectors(
    force: Array, weight: float, frames: Array, rotation: Array, vectors: Array
) -> None:
    """Fill in `weight` times forces (m, d) in frames (m, d, d), as vectors in a turned frame."""

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
        read: (m, d), m.
    """

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
        ports: Those in `load`, rising; all that the points act on are among them.
        load: (m, ports).
    """

def add_compliance(
    W: Array, weight: float, frames: Array, turns: Array, C: Array, share: Array
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
