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
# ---- FACETS

def project_onto_facets(
    facets: Indices,
    powers: Indices,
    factors: Array,
    derivatives: Array,
    undeformed: Array,
    meeting: Indices,
    first: Indices,
    along: Array,
    corners: int,
    margin: float,
    position: Array,
    carrier: Array,
    frame: Array,
    place: Array,
    nodes: Indices,
    weights: Array,
    slope: Array,
    stretch: Array,
    beyond_edge: Mask,
    /,
) -> None:
    """Fill in gaps and tangential positions (m, d) of points over a face, and their closest.

    First the fields of the `FacetShapes` of the face (solver/contact/carriers.py); it is linear or
    quadratic. Then positions of the points in space, (m, d), m, those of its nodes, (n, d), and the
    rows normal and tangents of a frame, (d, d). Filled in are the place (g, s), (m, d), m, and the
    fields of the `ClosestPoints` of the points (solver/contact/kinematics.py).
    """

def interpolated(nodes: Indices, weights: Array, values: Array, found: Array, /) -> None:
    """Fill in what nodal values (n, d) are at places (m, d), by nodes and weights (m, k)."""

def add_spread(
    nodes: Indices, weights: Array, factor: float, vectors: Array, target: Array, /
) -> None:
    """Add a factor times forces at places, (m, d), to those on the nodes, (n, d), the target."""

def forces_in_space(
    old_nodes: Indices,
    old_weights: Array,
    old_slope: Array,
    old_stretch: Array,
    old_place: Array,
    old_position: Array,
    nodes: Indices,
    weights: Array,
    slope: Array,
    stretch: Array,
    place: Array,
    position: Array,
    frame: Array,
    facet: float,
    force: Array,
    vectors: Array,
    /,
) -> None:
    """Fill in vectors in space (m, d) of normal and tangential forces, whose work is exact.

    They are f_n (n - kappa t) + a^-T f_t.

    First the foot points at t_n and those at t_{n+1}, each as `FootPointArrays` of
    solver/contact/carriers.py. Then rows normal and tangents of the face, (d, d), the length of its
    smallest facet, m, normal and tangential forces, (m, d), N, and the vectors, N.
    """

def work_defect(
    old_nodes: Indices,
    old_weights: Array,
    old_slope: Array,
    old_stretch: Array,
    old_place: Array,
    old_position: Array,
    nodes: Indices,
    weights: Array,
    slope: Array,
    stretch: Array,
    place: Array,
    position: Array,
    frame: Array,
    facet: float,
    force: Array,
    /,
) -> float:
    """Work of these vectors less that of the forces (m, d), N, on (g, s), J.

    Only closest points of closed points that hardly move have any: kappa . e_t is not e_n there,
    nor a^-1 e_t ds. Arguments as of `forces_in_space`.
    """

# ---- ROTATIONS

def polar_factor(moment: Array, rotation: Array, /) -> None:
    """Fill in the rotation (d, d) nearest to a matrix: its polar factor (Kabsch 1976)."""

def best_rotation(u: Array, moment_row: Array, moment: Array, rotation: Array, /) -> None:
    """Fill in the rotation that fits a displacement (n d,) best, from the moments of its mass.

    Args:
        u: Displacements of the nodes, (n d,), m.
        moment_row: M times the places of the nodes from the centre, (n, d), kg m.
        moment: Sum of these places times their moments, (d, d), kg m2.
        rotation: (d, d); filled in.
    """

def turn_by(vector: Array, rotation: Array, /) -> None:
    """Fill in the rotation by an angle (1,), clockwise, or by a vector in space (3,), rad."""

def vector_of(rotation: Array, vector: Array, /) -> None:
    """Fill in the rotation vector (3,) of a rotation in space, rad: as long as its angle."""

def turning_ahead(
    spin: Array, before: Array, last_rate: Array, last: float, dt: float, turning: Array, /
) -> None:
    """Fill in how a body turns in a coming step: rates, those of them to count on, and angles.

    What an impact did cannot be counted on: it is the smaller of two changes of the angular
    velocity, and none where they go different ways.

    Args:
        spin: Angular velocity at its start, (n,), rad/s.
        before: That at the start of the last step.
        last_rate: Change of the angular velocity in the last step, (n,), rad/s2.
        last: Length of the last step, s.
        dt: Length of the coming one, s.
        turning: The three, (3, n), rad/s2 and rad; filled in.
    """

# ---- BODIES AS A WHOLE

def momenta(
    arm: Array, u: Array, v: Array, momentum: Array, directional_mass: Array, sums: Array, /
) -> None:
    """Fill in sums over the nodes of a body: m u and m v, (d,) each, (arm + u) x M v, and v.M v.

    The moments are about the axes of space; in the plane there is one, which turns clockwise.

    Args:
        arm: Places of the nodes from the centre of the undeformed body, (n, d), m.
        u: Displacements, (n d,), m.
        v: Velocities, (n d,), m/s.
        momentum: M v, (n d,), kg m/s.
        directional_mass: Mass of each unknown in motion along each direction, (d, n d), kg.
        sums: The sums, (2 d + 2,) or in space (2 d + 4,); filled in.
    """

def resultant(forces: Array, total: Array, /) -> None:
    """Fill in the sum (d,) of forces on nodes, one after another in (n d,), N."""

def velocities(
    sums: Array, mass: float, rotation: Array, inertia: Array, motion: Array, spin: Array, /
) -> None:
    """Fill in how a body moves as a whole, by sums over its nodes as `momenta` gives them.

    Args:
        sums: Over the nodes of all ranks.
        mass: Of the body, kg.
        rotation: That fits its displacement best, (d, d).
        inertia: Inertia tensor of the unrotated body about its centre, (3, 3), in the plane its
            polar inertia, (1, 1), kg m2.
        motion: Displacement (m) and velocity (m/s) of the centre, (2, d); filled in.
        spin: Angular velocity, (1,) or (3,), rad/s; filled in.
    """

def move_on(arm: Array, u: Array, moved: Array, vector: Array, way: Array, after: Array, /) -> None:
    """Fill in displacements of a body that turns and moves on as a whole, its strains unchanged.

    Args:
        arm: Places of the nodes from the centre of the undeformed body, (n, d), m.
        u: Displacements before, (n d,), m.
        moved: That of the centre, (d,), m.
        vector: Angle (1,) or rotation vector (3,) by which the body turns, rad.
        way: How far its centre moves, (d,), m.
        after: Displacements after, (n d,), m; filled in.
    """

def turn_all(vectors: Array, vector: Array, turned: Array, /) -> None:
    """Fill in vectors, one after another in (n d,), turned by an angle (1,) or a vector (3,)."""

# ---- POINTS THAT CARRY A BLOCK

def touching(force: Array, place: Array, may_touch: Mask, level: float, touch: Mask, /) -> None:
    """Fill in which points touch (n,): closed ones, or else the lowest one and all as low.

    Where no point may touch, these are all.

    Args:
        force: Of the points, normal part first, (n, d), N.
        place: Theirs, (g, s), (n, d), m.
        may_touch: Which of them may touch, (n,).
        level: Points within it of the lowest one are as low, m.
        touch: (n,); filled in.
    """

def mean_slip(
    force: Array, place: Array, may_touch: Mask, level: float, reference: Array, slip: Array, /
) -> None:
    """Fill in the mean slip of the points that touch, (d - 1,), m, from their reference positions.

    These are (n, d - 1), nan where one is not known yet: then the slip is nan. The other arguments
    are as of `touching`.
    """

def penetration(place: Array, inside: Mask, /) -> float:
    """Largest penetration of the points of an interface, m; 0 if none penetrates.

    By the places of all, (n, d), and which of them are over their carrier.
    """

# ---- VALUES CELL BY CELL, AND COLUMNS

def read_cells(values: Array, index: Indices, table: Array, first: int, /) -> None:
    """Fill in k columns of a table, (cells, any), from a first one on, by places among values.

    Args:
        values: All values.
        index: Place among them of each number of a cell, (cells, k).
        table: The table; those columns are filled in.
        first: Number of the first of them.
    """

def place_in_cells(u: Array, values: Array, index: Indices, table: Array, first: int, /) -> None:
    """Let u be the first of the values, and read the table anew, where it is not so already.

    The other arguments are as of `read_cells`; the values are filled in, too.
    """

def add_columns(columns: Array, place: Indices, forces: Array, moved: Array, /) -> None:
    """Add to displacements what forces do, by columns; those without force are not read.

    Args:
        columns: As kept, (ports d, unknowns), m/N.
        place: Places of the ports among them, (m,).
        forces: At the ports, (m, d), N.
        moved: (unknowns,), m; added to.
    """
