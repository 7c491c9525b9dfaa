"""Compiled functions of meshed bodies: what each does, with shapes and units.

Arrays are of float64 (`Array`), int64 (`Indices`) or bool (`Mask`), in one piece (C order). Those
that a function fills in are named so; it keeps none of them.
"""

from solver.types import Array, Indices, Mask

# ---- Local problem with a dense compliance
#
# dense_problem.hpp states the problem. It is handed over by d (rows of a point: 3 in space, 2 in
# the plane, 1 without friction), W (compliance, (d m, d m), m/N; rows of a point side by side,
# normal first), q (free values, (d m,), m) and the bounds of friction: mu (m,), cohesion (m,), N,
# and slope. States of points, (m,): 0 open, 1 stick, 2 slip, 3 slip while cohesion is built up; for
# d = 2 those of slip carry the sign of the friction force. Forces are (d m,), N; the lengths r,
# normal and tangential, (m, 2), N/m.

def product(matrix: Array, vector: Array, found: Array) -> None:
    """Fill in the product of a square matrix and a vector."""

def solve_dense(matrix: Array, right: Array) -> bool:
    """Solve a linear system, `right` becoming the solution; False where it is singular.

    The matrix is used up.
    """

def lengths(d: int, W: Array, shared: bool, r: Array) -> None:
    """Fill in the lengths r: one over the diagonal of W, or (`shared`) over row sums of |W|."""

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

def best_step(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    r: Array,
    f: Array,
    target: Array,
    halvings: int,
) -> float:
    """The part of the way from f to its target that lowers |f - P(f - r y)| enough, else most."""

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
    halvings: int,
) -> bool:
    """Newton's method from f; whether it settled. If so f is the solution, else it stays as it is.

    `rounds` is the most linear solves, `halvings` how often the line search may halve a step; with
    0 steps are full.
    """

def fallback(
    d: int,
    W: Array,
    q: Array,
    mu: Array,
    cohesion: Array,
    slope: float,
    method: int,
    f: Array,
    states: Indices,
) -> bool:
    """Solve by a method of `FALLBACKS`; f is the guess, and the answer if it settled."""

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
