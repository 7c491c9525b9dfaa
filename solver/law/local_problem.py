"""The local contact problem: Signorini and Coulomb at points coupled by a small dense matrix.

`solver.law.newton` states the problem. Newton's method settles nearly all of them; behind it stand
slower methods, and the names of those that settled a problem are counted.
"""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from solver.law.compiled import compiled
from solver.law.friction import (
    BOUND_ROUND_OFF,
    TOUCHING_SLOPE,
    Bounds,
    at_bound,
    is_frictionless,
    radius,
)
from solver.law.many_points import MANY_ROWS, ManyPoints
from solver.law.newton import OPEN, SLIP, STICK, Local, lengths, newton
from solver.types import Array, Indices

#: Names of the methods behind Newton's, in the order in which they are tried. Neither is proved to
#: converge under Coulomb's law, where the bounds depend on the solution; hence there are two.
#: docs/method.md has what each of them settles.
FALLBACKS = ("proximal", "continuation")

#: Linear solves of Newton's method for an eased problem.
EASED_ROUNDS = 30
#: The same for the problem itself, from the solution of an eased one.
POLISHING_ROUNDS = 6
#: Halvings of a step by the line search.
HALVINGS = 12

#: Problems with a proximal term that are tried.
PROXIMAL_ROUNDS = 100
#: The first proximal term: what it adds to the diagonal of W, relative to it.
SOFTNESS = 1e-2
#: The least and the largest one.
SOFTNESSES = (1e-8, 1e4)
#: Factors of the term after a problem that was solved and after one that was not.
HARDENING, SOFTENING = 0.1, 3.0

#: Smallest part of friction by which the continuation goes on.
SMALLEST_SHARE = 1e-3

#: Halvings of the interval of the shift of a slipping point.
ONE_POINT_HALVINGS = 200

#: What can become of a local problem, as counted.
OUTCOMES = ("Newton", "touching", *FALLBACKS, "velocity solve left out")
#: Linear solves of Newton's method, and two more for each point.
ROUNDS = 20
#: Rows of a problem of many points up to which these methods are tried, too.
FALLBACK_ROWS = 600


class NoContactSolution(Exception):
    """The local problem was settled by no method; a smaller time step is the remedy."""


def new_counts() -> Indices:
    """Room to count outcomes."""
    return np.zeros(len(OUTCOMES), dtype=np.int64)


def named(counts: Indices) -> Counter[str]:
    """Counts of what was needed besides Newton's method, by name."""
    return Counter({name: int(n) for name, n in zip(OUTCOMES[1:], counts[1:], strict=True) if n})


def image(W: Array, f: Array) -> Array:
    """W f for points (m, d)."""
    return (W.reshape(f.size, f.size) @ f.ravel()).reshape(f.shape)


@compiled
def solve(
    d: int,
    W: Array,
    q: Array,
    bounds: Bounds,
    f: Array,
    states: Indices,
    counts: Indices,
) -> bool:
    """Solve a local problem; False where no method settled it.

    Args:
        d: Rows of a point: 3 in space, 2 in the plane.
        W: Compliance, (d m, d m), m/N.
        q: Free values, (d m,), m.
        bounds: Of friction; where none of the points has any, tangential rows are dropped.
        f: Guess and answer, (d m,), N.
        states: Left as those of the answer, `OPEN`, `STICK` or else slip, (m,).
        counts: Of outcomes, see `OUTCOMES`.
    """
    if is_frictionless(bounds):
        normal = f[::d].copy()
        local = Local(1, W[::d, ::d].copy(), q[::d].copy(), bounds)
        settled = _settle(local, normal, states, counts)
        f[:] = 0.0
        f[::d] = normal
        return settled
    return _settle(Local(d, W, q, bounds), f, states, counts)


@compiled
def solve_points(
    W: Array, q: Array, mu: Array, cohesion: Array, slope: float, f: Array, counts: Indices
) -> bool:
    """As `solve`, with W (m, d, m, d), q and f (m, d), and the fields of the bounds one by one."""
    (m, d), bounds = q.shape, Bounds(mu, cohesion, slope)
    states = np.empty(m, np.int64)
    flat = W.reshape(d * m, d * m)
    return solve(d, flat, q.reshape(d * m), bounds, f.reshape(d * m), states, counts)


@compiled
def one_point(local: Local) -> tuple[float, float, float]:
    """The force at the only point, normal and two tangential, of which those not in d are 0.

    Slipping forces solve (S + lambda I) f_t = -p, lambda >= 0, with S and p what W and q leave of
    the tangential rows when y_n = 0; |f_t| less the radius has one sign at lambda = 0, the other
    far off, and is halved down.
    """
    d, W, q = local.d, local.W, local.q
    normal = first = second = 0.0
    if q[0] >= 0:
        return normal, first, second
    # S = ((a, b), (c, e)) and p = (g, h)
    a, b, c, e, g, h = 1.0, 0.0, 0.0, 1.0, 0.0, 0.0
    if d > 1:
        g = q[1] - W[1, 0] * q[0] / W[0, 0]
        a = W[1, 1] - W[1, 0] * W[0, 1] / W[0, 0]
    if d > 2:
        h = q[2] - W[2, 0] * q[0] / W[0, 0]
        b, c = W[1, 2] - W[1, 0] * W[0, 2] / W[0, 0], W[2, 1] - W[2, 0] * W[0, 1] / W[0, 0]
        e = W[2, 2] - W[2, 0] * W[0, 2] / W[0, 0]
    low, high, shift = 0.0, np.inf, 0.0
    for _ in range(ONE_POINT_HALVINGS):
        determinant = (a + shift) * (e + shift) - b * c
        normal = -q[0] / W[0, 0]
        first = (b * h - (e + shift) * g) / determinant
        second = (c * g - (a + shift) * h) / determinant
        if d > 1:
            normal -= W[0, 1] * first / W[0, 0]
        if d > 2:
            normal -= W[0, 2] * second / W[0, 0]
        inside = normal > 0 and math.hypot(first, second) <= radius(local.bounds, 0, normal)
        if inside:
            high = shift
        else:
            low = shift
        if inside and (shift == 0.0 or high - low <= 1e-15 * high):
            break
        shift = 4 * shift + a + e if high == np.inf else 0.5 * (low + high)
        if shift in (low, high):
            break
    return normal, first, second


@compiled
def settle_one_point(local: Local, f: Array, states: Indices) -> bool:
    """Write force and state of the only point; False where the closed form does not hold."""
    normal, first, second = one_point(local)
    size = math.hypot(first, second)
    limit = radius(local.bounds, 0, normal) * (1.0 + BOUND_ROUND_OFF)
    if not (normal >= 0.0 and size <= limit):
        return False
    f[0] = normal
    if local.d > 1:
        f[1] = first
    if local.d > 2:
        f[2] = second
    states[0] = OPEN
    if normal > 0.0:
        slip = -SLIP if local.d == 2 and first < 0.0 else SLIP
        states[0] = slip if at_bound(local.bounds, 0, normal, size) else STICK
    return True


@compiled
def fallback(method: int, local: Local, f: Array, states: Indices) -> bool:
    """Solve by a method of `FALLBACKS`; f is the guess, and the answer if it settled."""
    if method == 0:
        return _by_proximal_terms(local, f, states)
    return _by_continuation(local, f, states)


@compiled
def _settles(local: Local, f: Array, states: Indices, rounds: int, searches: bool) -> bool:
    """Newton's method with either r, with full steps and then with line search if it `searches`."""
    for k in range(4 if searches else 2):
        r = lengths(local.d, local.W, k % 2 == 0)
        if newton(local, r, f, states, rounds, 0 if k < 2 else HALVINGS):
            return True
    return False


@compiled
def _by_proximal_terms(local: Local, f: Array, states: Indices) -> bool:
    """The proximal point algorithm, with a term that follows how well Newton's method does.

    The term D (f - f_last) makes the diagonal of W larger for the change of the forces since the
    last solution. It holds back forces that only balance each other, of which W says next to
    nothing: Newton's method would throw them about. As the motion settles the term can become
    smaller, and once it is near the diagonal that makes these forces unique, they settle, too.
    """
    softness, now = SOFTNESS, f.copy()
    for _ in range(PROXIMAL_ROUNDS):
        soft, added = local.W.copy(), softness * np.diag(local.W)
        for k in range(len(f)):
            soft[k, k] += added[k]
        eased = Local(local.d, soft, local.q - added * now, local.bounds)
        if _settles(eased, now, states, EASED_ROUNDS, True):
            trial = now.copy()
            if _settles(local, trial, states, POLISHING_ROUNDS, False):
                f[:] = trial
                return True
            softness = max(SOFTNESSES[0], HARDENING * softness)
        else:
            softness *= SOFTENING
            if softness > SOFTNESSES[1]:
                return False
    return False


@compiled
def _by_continuation(local: Local, f: Array, states: Indices) -> bool:
    """From the problem without friction to that with all of it."""
    bounds, done, step, share, now = local.bounds, 0.0, 0.25, 0.0, f.copy()
    while step > SMALLEST_SHARE:
        slope = bounds.slope if bounds.slope == np.inf else share * bounds.slope
        part = Bounds(share * bounds.mu, share * bounds.cohesion, slope)
        if _settles(Local(local.d, local.W, local.q, part), now, states, EASED_ROUNDS, True):
            if share == 1.0:
                f[:] = now
                return True
            done, step = share, 1.5 * step
        elif share == 0.0:
            return False
        else:
            step *= 0.5
        share = min(1.0, done + step)
    return False


@compiled
def _settle(local: Local, f: Array, states: Indices, counts: Indices) -> bool:
    """Newton's method, then the slower ones.

    All cohesion at once may lift its own point, and then there is no solution: behind the first
    try it is built up over the first pressure instead.
    """
    if len(states) == 1 and local.bounds.cohesion[0] == 0.0 and settle_one_point(local, f, states):
        counts[0] += 1
        return True
    r, rounds = lengths(local.d, local.W, True), ROUNDS + 2 * len(states)
    if newton(local, r, f, states, rounds, 0):
        counts[0] += 1
        return True
    if np.any(local.bounds.cohesion > 0.0):
        touching = Bounds(local.bounds.mu, local.bounds.cohesion, TOUCHING_SLOPE)
        local = Local(local.d, local.W, local.q, touching)
        if newton(local, r, f, states, rounds, 0):
            counts[1] += 1
            return True
    for method in range(len(FALLBACKS)):
        if fallback(method, local, f, states):
            counts[2 + method] += 1
            return True
    return False


class LocalProblem:
    """Solver of local problems of points with d rows each, as arrays (m, d)."""

    def __init__(self) -> None:
        """Begin without having solved any."""
        self.counts = new_counts()
        self.forget()

    def forget(self) -> None:
        """Keep nothing from problem to problem, so that the next one does not depend on them."""
        self._many, self._impulses = ManyPoints(), ManyPoints()

    @property
    def fallbacks(self) -> Counter[str]:
        """Numbers of problems that needed more than Newton's method, by name of the fallback."""
        return named(self.counts)

    def solve(
        self, W: Array, q: Array, start: Array, bounds: Bounds, points: Indices | None = None
    ) -> Array:
        """Forces (m, d) for compliance W (m, d, m, d), free values q (m, d) and a guess (m, d).

        By their numbers, (m,), many points are known again in the next problem.

        Raises:
            NoContactSolution: Where every method failed.
        """
        m, force = len(start), np.ascontiguousarray(start).copy()
        whole, free = np.ascontiguousarray(W), np.ascontiguousarray(q)
        if force.size > MANY_ROWS:
            settled = self._settle(self._many, whole, free, bounds, force, points)
        else:
            settled = not m or solve_points(whole, free, *bounds, force, self.counts)
        if not settled:
            raise NoContactSolution(f"the local contact problem of {m} points did not settle")
        return force

    def impulses(
        self, W: Array, q: Array, bounds: Bounds, p: Array, points: Indices | None
    ) -> bool:
        """Solve for the impulses of many points, (m, d); p is the guess and becomes the answer."""
        return self._settle(self._impulses, W, q, bounds, p, points)

    def _settle(
        self,
        many: ManyPoints,
        W: Array,
        q: Array,
        bounds: Bounds,
        f: Array,
        points: Indices | None,
    ) -> bool:
        """By the solver of many points, then by the methods for few of them."""
        flat = W.reshape(f.size, f.size), q.reshape(-1)
        if many.solve(f.shape[1], *flat, bounds, f.reshape(-1), points):
            return True
        return f.size <= FALLBACK_ROWS and solve_points(W, q, *bounds, f, self.counts)
