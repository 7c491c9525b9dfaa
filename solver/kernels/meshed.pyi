"""Compiled functions of meshed bodies: what each does, with shapes and units.

Arrays are of float64 (`Array`), int64 (`Indices`) or bool (`Mask`), in one piece (C order). Those
that a function fills in are named so; it keeps none of them.
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

def out_of_frame(nodes: Array, others: Array, rotation: Array, moved: Array) -> None:
    """Fill in R (x + y) of two motions, vectors one after another in (n d,)."""

def add_shift(vectors: Array, shift: Array, nodes: Array) -> None:
    """Add S p to all nodes (n d,), with p the sum of vectors (m, d) and S (d, d)."""

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
    read: Array,
) -> None:
    """Fill in what sparse rows read from a motion x: of points, (m, d), row after row.

    Args:
        start: Place of the first entry of each row, and their end, (m d + 1,).
        column: Number of the unknown of each entry.
        weight: By which it counts.
        nodes: x, (n d,), m.
        read: (m, d), m.
    """

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

# ---- Facets

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

# ---- Rotations

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

# ---- Bodies as a whole

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

# ---- Points that carry a block

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

# ---- Values cell by cell, and columns

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

# ---- What points hold by friction

def slipping_points(
    force: Array, slip: Array, own: Array, mu: Array, cohesion: Array, found: Mask
) -> None:
    """Fill in the points that slip in a step: at their bound, and moved by more than round-off.

    Args:
        force: Point forces, (m, d), N.
        slip: How far the points moved along their carriers, (m, d-1), m.
        own: What the force at a point moves it by, (m,), m/N.
        mu: The bounds, field by field: coefficients of friction, (m,).
        cohesion: What points hold besides, (m,), N.
        found: Filled in, (m,).
    """

def bounds_by_past(
    static: float,
    dynamic: float,
    decay: float,
    cohesion: float,
    cohesion_lost: bool,
    past: Array,
    area: Array,
    mu: Array,
    held: Array,
) -> None:
    """Fill in the bounds of points of one surface when a step begins.

    Args:
        static: The fields of its `FrictionLaw`, like the next four.
        dynamic: Coefficient of fast sliding.
        decay: s/m.
        cohesion: Pa.
        cohesion_lost: True if a point that has broken loose has no cohesion any more.
        past: What the points remember of their friction, (m, PAST).
        area: What cohesion acts on, (m,), m2.
        mu: Coefficients of friction, filled in, (m,).
        held: Cohesion, filled in, (m,), N.
    """

def bounds_followed(
    static: float,
    dynamic: float,
    decay: float,
    cohesion: float,
    cohesion_lost: bool,
    past: Array,
    area: Array,
    so_far: Array,
    speed: Array,
    slips: Mask,
    mu: Array,
    held: Array,
) -> None:
    """Fill in the bounds of points within a step, by the motion that their coefficients led to.

    Args:
        static: The fields of the `FrictionLaw`, like the next four.
        dynamic: Coefficient of fast sliding.
        decay: s/m.
        cohesion: Pa.
        cohesion_lost: True if a point that has broken loose has no cohesion any more.
        past: What the points remember of their friction, (m, PAST).
        area: What cohesion acts on, (m,), m2.
        so_far: The coefficients, (m,).
        speed: Slip in this step over its length, 0 where a point sticks, (m,), m/s.
        slips: Points that have broken loose in this step, (m,).
        mu: Coefficients that go with the motion, filled in, (m,).
        held: Cohesion, filled in, (m,), N.
    """

# ---- What points remember

def after_step(
    force: Array,
    y: Array,
    old_force: Array,
    old_y: Array,
    old_anchor: Array,
    old_past: Array,
    softness: Array,
    own: Array,
    mu: Array,
    cohesion: Array,
    step: float,
    anchor: Array,
    past: Array,
) -> tuple[float, float]:
    """Fill in anchors and pasts after a step; returns what friction and contact took, J.

    Friction is minus the work of the tangential forces on the anchors. Contact takes the work of
    the forces against y that is neither stored in their softness nor lost in friction.

    Args:
        force: Point forces at t_{n+1}, (points, d), N.
        y: Augmented positions at t_{n+1}, (points, d), m.
        old_force: The same at t_n, in the frame of the step.
        old_y: Likewise.
        old_anchor: Stick memory at t_n, (points, d-1), m.
        old_past: What points remembered of their friction, (points, PAST).
        softness: 1/(gamma_h w), (points,), m/N.
        own: What the force at a point moves it by, (points,), m/N; tells slip from round-off.
        mu: Coefficients of friction in this step, (points,).
        cohesion: What points hold besides, (points,), N.
        step: Its length, s; infinite in equilibrium.
        anchor: Stick memory at t_{n+1}, filled in.
        past: What points remember of their friction afterwards, likewise.
    """

def stored_energy(
    force: Array,
    traction: Array,
    softness: Array,
    weight: Array,
    inverse_gamma: Array,
    theta: float,
) -> float:
    """Energy of an interface whose points have tractions, sum of (f^2/w - theta w T^2)/(2 gamma_h).

    Args:
        force: Point forces, (points, d), N.
        traction: T, (points, d), Pa.
        softness: 1/(gamma_h w), (points,), m/N.
        weight: w, (points,), m or m2.
        inverse_gamma: 1/gamma_h, (points,), m/Pa.
        theta: Variant of Nitsche's method.
    """

def squared_change(weight: Array, old: Array, new: Array) -> float:
    """Weighted sum, (points,), of the squared changes of vectors, (points, d)."""

def changed_forces(
    before: Array, after: Array, past_before: Array, past_after: Array, rigid: bool
) -> tuple[float, float]:
    """Forces of the points that opened, closed, stuck, slipped or turned round, and of all, N.

    Of each point it is the larger one of both ends of a step.

    Args:
        before: Point forces at its start, (points, d), N.
        after: At its end.
        past_before: What points remembered of their friction at its start, (points, PAST).
        past_after: At its end.
        rigid: True if neither body is meshed. Which of their points slip is then chance, unless all
            of them do.
    """

# ---- Contact at velocity level

def impulse_problem(
    number: int,
    W: Array,
    velocity: Array,
    impulse: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    mobility: Array,
    free: Array,
    left_mu: Array,
    left_cohesion: Array,
    start: Array,
) -> None:
    """Fill in the problem of a number for the impulses of closed points.

    In 0 all points obey the law; in 1, points that slipped stay at their bound; in 2 they keep
    their friction; in 3 all points do.

    Args:
        number: 0 to 3.
        W: G M^-1 G^T of the points, (m, d, m, d), 1/kg.
        velocity: After the step, (m, d), m/s.
        impulse: dt f of the step, (m, d), N s.
        mu: The bounds of the impulses, field by field: coefficients of friction, (m,).
        cohesion: What points hold besides, (m,), N s.
        slope: How cohesion grows with the impulse at first.
        mobility: W with the friction that follows the normal impulses, filled in.
        free: Velocities without impulses but those given, filled in, (m, d), m/s.
        left_mu: Coefficients, 0 where friction is no unknown, filled in, (m,).
        left_cohesion: Cohesion, likewise.
        start: Guess of the impulses that are unknown, filled in, (m, d), N s.
    """

def accept_impulses(
    number: int,
    W: Array,
    velocity: Array,
    impulse: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    taken: float,
    solution: Array,
) -> tuple[bool, float, float]:
    """Turn the solution of the problem of a number into the change of the impulses.

    Returns whether energy allows it, and what it takes in the normal and in the tangential
    directions, J.

    Args:
        number: 0 to 3.
        W: G M^-1 G^T of the points, (m, d, m, d), 1/kg.
        velocity: After the step, (m, d), m/s.
        impulse: dt f of the step, (m, d), N s.
        mu: The bounds of the impulses, as in `impulse_problem`.
        cohesion: Likewise.
        slope: Likewise.
        taken: Energy that friction took in the step, J: what the change may return.
        solution: The unknown impulses, replaced, (m, d), N s.
    """

def correct_impulses(
    W: Array,
    velocity: Array,
    impulse: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    taken: float,
    lands: bool,
    counts: Indices,
    q: Array,
) -> tuple[bool, float, float]:
    """Correct the impulses of closed points; returns as `accept_impulses`.

    Args:
        W: G M^-1 G^T of the points, (m, d, m, d), 1/kg.
        velocity: After the step, (m, d), m/s.
        impulse: dt f of the step, (m, d), N s.
        mu: The bounds of the impulses, as in `impulse_problem`.
        cohesion: Likewise.
        slope: Likewise.
        taken: Energy that friction took in the step, J.
        lands: True if a rigid body landed in the step.
        counts: Of outcomes of local problems.
        q: The change of the impulses, filled in, (m, d), N s.
    """

def slip_reversal(force: Array, velocity: Array) -> float:
    """Speed at which points slip back at the end of a step, m/s, a mean over their friction.

    Friction opposes the slip of the step as a whole. Where the slip turned round within the step,
    friction drives what it should by now oppose. 0 where it does not.

    Args:
        force: Of closed points, normal and tangential, (m, d), N.
        velocity: Their velocities at the end of the step, (m, d), m/s.
    """

# ---- Points that may come into contact

def settle(
    y: Array,
    near: Indices,
    W: Array,
    softening: Array,
    margin: Array,
    may_touch: Mask,
    anchor: Array,
    softness: Array,
    held: Array,
    bed: Array,
    round_off: Array,
    force: Array,
    number: Indices,
    mu: Array,
    cohesion: Array,
    alone: bool,
    counts: Indices,
    q: Array,
    change: Array,
) -> tuple[int, int, float]:
    """Let the forces of near points obey the contact law after the free step to y, in one pass.

    Returns what became of that (`solver.stepping.step_contact`), how many points are near, and the
    sum of the squares of their forces, N2.

    Args:
        y: Augmented positions of all points after the free step, (points, d), m.
        near: Points that W belongs to; where others are near nothing is changed.
        W: Their compliance, (m, d, m, d), m/N; it holds softness, softening and beds.
        softening: Of the near points, (m,), m/N: acts on what forces differ by from held ones.
        margin: Gaps below which points may come into contact, (points,), m.
        may_touch: Points that may touch, (points,).
        anchor: Stick memory of all points, (points, d-1), m.
        softness: Of the interface, (points,), m/N: no part of y.
        held: Forces that those so far are compared with, (points, d), N.
        bed: Softness of the beds below all points, (points,), m/N.
        round_off: Of the gaps, (points,), m.
        force: Forces of all points, replaced by those that obey the law, (points, d), N.
        number: Filled in with the numbers of points that are near, rising; it has room for all.
        mu: Coefficients of friction of all points, (points,).
        cohesion: What they hold besides, (points,), N.
        alone: True to solve the problem here, or to leave that to the caller.
        counts: Of outcomes of local problems.
        q: Free values with y = q + W f, filled in, (m, d), m.
        change: How much the forces of near points changed, filled in, (m, d), N.
    """

def sinks_in(y: Array, round_off: Array, may_touch: Mask, seen: Mask) -> bool:
    """True if points that may touch, but were never near, are in their carrier at positions y.

    Args:
        y: Augmented positions, (points, d), m.
        round_off: Of the gaps, (points,), m.
        may_touch: Points that may touch, (points,).
        seen: Points that were near, (points,).
    """

def take_over(force: Array, near: Indices, new: Array, change: Array) -> float:
    """Replace the forces of near points; returns the sum of the squares of the new ones, N2.

    Args:
        force: Of all points, (points, d), N.
        near: Numbers of the points.
        new: Their forces from now on, (m, d), N.
        change: Filled in: new forces less those before, (m, d), N.
    """

def add_softness(W: Array, near: Indices, softness: Array, added: Array) -> None:
    """Add to the diagonal of near points' compliance W, (m, d, m, d), m/N.

    Args:
        W: What is added to.
        near: Numbers of the points.
        softness: Of the interface at all points, (points,), m/N.
        added: Further terms at the near ones, (m,), m/N.
    """

# ---- Local problem with a dense compliance
#
# dense_problem.hpp states the problem. It is handed over by d (rows of a point: 3 in space, 2 in
# the plane, 1 without friction), W (compliance, (d m, d m), m/N; rows of a point side by side,
# normal first), q (free values, (d m,), m) and the bounds of friction: mu (m,), cohesion (m,), N,
# and slope. States of points, (m,): 0 open, 1 stick, 2 slip, 3 slip while cohesion is built up; for
# d = 2 those of slip carry the sign of the friction force. Forces are (d m,), N; the lengths r,
# normal and tangential, (m, 2), N/m.

def solve_dense(matrix: Array, right: Array) -> bool:
    """Solve a linear system, `right` becoming the solution; False where it is singular.

    The matrix is used up.
    """

def lengths(d: int, W: Array, r: Array) -> None:
    """Fill in the lengths r: one over row sums of |W| within a direction."""

def error_of(d: int, f: Array, trial: Array, nearest: Array) -> float:
    """Difference between f and P(f - r y), 1 being what is tolerated; infinite beyond numbers."""

def trial_of(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    r: Array,
    f: Array,
    trial: Array,
) -> None:
    """Fill in the trial forces f - r y, which decide the state of each point."""

def project(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    trial: Array,
    nearest: Array,
    states: Indices,
) -> None:
    """Fill in the admissible forces nearest to trial ones, and the states these stand for."""

def unknowns(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    states: Indices,
    rows: Indices,
) -> int:
    """Fill in the rows that have to be solved for, given the states; returns their number.

    There is room for all rows, (d m,). The other forces follow from these.
    """

def equations(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    r: Array,
    trial: Array,
    states: Indices,
    rows: Indices,
    matrix: Array,
    right: Array,
) -> None:
    """Fill in matrix A and right-hand side b of f - P(f - r y) = 0, linearised at `trial`: A x = b.

    The unknowns x are the forces of some rows, those of `unknowns`.
    """

def write_forces(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    trial: Array,
    states: Indices,
    rows: Indices,
    x: Array,
    f: Array,
) -> None:
    """Fill in all forces f by the unknowns x of the equations."""

def newton(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    r: Array,
    f: Array,
    states: Indices,
    rounds: int,
    moves: bool,
) -> bool:
    """Newton's method from f with full steps; whether it settled. If not, f stays as it is.

    `rounds` is the most linear solves; one is made in any case if it `moves`, else only where f is
    not the solution.
    """

def ease(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    softness: float,
    cohesion_only: bool,
    held: Array,
    soft: Array,
    free: Array,
    r: Array,
) -> None:
    """Fill in the problem with a term that holds forces: `soft`, `free` and its lengths r.

    The term is `softness` times the diagonal of W; `cohesion_only` leaves friction out of what
    makes it larger in normal rows. Only the diagonal of `soft` is written: others are those of W.
    """

def by_proximal_points(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    f: Array,
    states: Indices,
) -> bool:
    """Solve by the proximal point algorithm; f is the guess, and the answer if it settled."""

def solve(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    f: Array,
    states: Indices,
    counts: Indices,
) -> bool:
    """Solve a local problem; False where no method settled it.

    f is the guess and becomes the answer; `states` are left as those of the answer; `counts` are of
    outcomes, see `solver.law.local_problem.OUTCOMES`. Where no point has friction, tangential rows
    are dropped.
    """

def solve_points(
    W: Array, q: Array, mu: Array, cohesion: Array, slope: float, f: Array, counts: Indices
) -> bool:
    """As `solve`, with W (m, d, m, d), q and f (m, d)."""

# ---- Links, direction by direction
#
# Rows of `laws` are stiffness (N/m), damping (N s/m), gap (m), 1 where shortening is resisted, and
# the force at which it flows (N), (n, 5); extensions, (n,), m, are without the plastic part.

def link_forces(
    laws: Array, start: Array, end: Array, acts: Array, step: float, force: Array, slope: Array
) -> None:
    """Fill in mean forces over a step between extensions, N, and their derivatives over the end.

    The dashpots' are in them. Links act for times in the step, s, up to their ends. Where the step
    (s) is infinite forces are those at the end.
    """

def link_springs(laws: Array, elastic: Array, force: Array, energy: Array, flow: Array) -> None:
    """Fill in forces (N) and energies (J) of springs, and by how much they flow there, m."""
