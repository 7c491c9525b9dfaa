"""Compiled functions of meshed bodies: what each does, with shapes and units.

Arrays are of float64 (`Array`), int64 (`Indices`) or bool (`Mask`), in one piece (C order). Those that
a function fills in are named so; it keeps none of them.
"""

from solver.types import Array, Indices, Mask

# ---- What points hold by friction

def points_at_bound(force: Array, mu: Array, cohesion: Array, slope: float, found: Mask) -> None:
    """Fill in the closed points whose friction is at its bound.

    Args:
        force: Point forces, (m, d), N.
        mu: The bounds, field by field: coefficients of friction, (m,).
        cohesion: What points hold besides, (m,), N.
        slope: How cohesion grows with the force at first.
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
