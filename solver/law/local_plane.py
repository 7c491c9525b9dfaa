"""Solvers of the local contact problem in two dimensions, where states are finite in number.

A semismooth Newton method decides them by f - r y, with r one over the ROW SUM of |W|: the points
of a stiff body share its rigid modes, so that W is nearly of rank one and 1/diag(W) too large by
about the number of points. It has no line search, costs one small solve for states that were right
already, and cycles now and then. For few points it is the compiled one of rigid blocks, where numba
is installed.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgesv

from solver.law import few_points as compiled
from solver.law.compiled import NUMBA
from solver.law.discs import TOUCHING_SLOPE, Discs
from solver.law.friction import Bounds
from solver.law.local_disc import newton
from solver.law.local_rescues import Method, continuation, other_r, projected, tresca
from solver.law.local_system import LocalSystem, lines
from solver.types import Array, Indices

LENGTHS = ((1e-2, 1e-1), (1e2, 1e3))
"""r of `other_r` in the two directions over one over the diagonal of W: of 151 problems that
Newton's method and its states of before left, these two settle 125."""

STICK, SLIP, SMOOTH = 1.0, 2.0, 3.0

ROUNDS = 40
"""Of Newton's method, and one more for each point."""

FEW = 24
"""Points up to which machine code is faster than LAPACK by way of numpy."""


class States:
    """What each point does, and the unknowns that this leaves.

    Attributes:
        code: 0 open, 1 sticking, +-2 slipping with friction of that sign, 3 closed where nothing
            has friction, (m,).
        key: Equal for equal states and lines.
        line: Slopes and intercepts of the bounds, (m,) each.
        unknown: Flat numbers (normal 2 i, tangential 2 i + 1) of the forces to be solved for, those
            of the closed points' normals first.
        slipping: Places of the slipping points among the closed ones.
        tangential: Flat numbers of their friction forces.
    """

    __slots__ = ("code", "key", "line", "points", "sign", "slipping", "tangential", "unknown")

    def __init__(self, code: Array, line: tuple[Array, Array]):
        """Number what is unknown."""
        self.code, self.line = code, line
        self.key = code.tobytes() + line[0].tobytes()
        closed = code.nonzero()[0]
        code = code[closed]
        self.slipping = (np.abs(code) == SLIP).nonzero()[0]
        self.points, self.sign = closed[self.slipping], 0.5 * code[self.slipping]
        self.tangential = 2 * self.points + 1
        self.unknown = np.concatenate([2 * closed, 2 * closed[code == STICK] + 1])

    def under(self, line: tuple[Array, Array]) -> States:
        """The same states where the bounds may have changed."""
        if line[0] is not self.line[0]:
            self.key = self.code.tobytes() + line[0].tobytes()
        self.line = line
        return self


class PlaneSolver:
    """Newton's method over states, and those behind it; remembers the last states."""

    def __init__(self) -> None:
        """Name the slower methods, in the order in which they are tried: without, with cohesion."""
        self._last: States | None = None
        self._decided: Indices = np.empty(0, dtype=np.int64)
        self._free, self._known = self._decided, False
        self.rescues: dict[str, Method] = {
            "other r": other_r(newton, LENGTHS),
            "continuation": continuation(self._newton),
            "damped continuation": continuation(newton),
            "enumeration": _enumerated,
            "tresca": tresca(newton),
            "projected": projected(newton),
        }
        self.cohesive: dict[str, Method] = {
            "touching": lambda system, start: self._newton(system, start, system.touching()),
            **self.rescues,
        }

    def get_ready(self) -> None:
        """Let what is compiled be compiled, or read what was kept, before time counts."""
        if NUMBA is not None:
            W, q = np.eye(4).reshape(2, 2, 2, 2), np.zeros((2, 2))
            one = LocalSystem(W, q, np.ones((2, 2)), Bounds.uniform(0.5, 2))
            self._in_machine_code(one, q)

    def fast(self, system: LocalSystem, start: Array) -> Array | None:
        """One point by its closed form, several by Newton's method from the last states."""
        if len(start) == 1:
            return _one_point(system)
        if NUMBA is not None and len(start) <= FEW and not system.bounds.frictionless:
            return self._in_machine_code(system, start)
        last = self._last
        if last is not None and len(last.code) == len(start):
            last = last.under(lines(system.coulomb, start[:, 0]))
            return self._newton(system, start, system.coulomb, last)
        return self._newton(system, start, system.coulomb)

    def _in_machine_code(self, system: LocalSystem, start: Array) -> Array | None:
        """Newton's method for few points, where numpy's calls would take longer than the work."""
        count, scaling = len(start), system.scaling.ravel()
        W, q, forces = system.flat(start)
        if len(self._decided) != count:
            self._free = np.zeros(count, dtype=np.int64)
            self._decided = np.empty(count, dtype=np.int64)
            self._known = False
        bounds = compiled.Bounds(system.bounds.mu, system.bounds.cohesion, self._free)
        if not self._known:
            trial = compiled.image(W, q, forces)
            compiled.decide(forces, trial, scaling, bounds, self._decided)
        self._known = compiled.newton(W, q, scaling, bounds, self._decided, forces)
        return forces.reshape(count, 2) if self._known else None

    def _decide(
        self, system: LocalSystem, f: Array, discs: Discs
    ) -> tuple[Array, tuple[Array, Array]]:
        """Codes of the states by the sign and size of f - r y, and the lines they refer to."""
        trial = system.trial(f)
        normal, tangential = trial[:, 0], trial[:, 1]
        rule = lines(discs, normal)
        if system.bounds.frictionless:
            return np.asarray(SMOOTH * (normal > 0), dtype=np.float64), rule
        stick = np.abs(tangential) <= rule[0] * normal + rule[1]
        closed = np.where(stick, STICK, np.copysign(SLIP, tangential))
        return np.where(normal > 0, closed, 0.0), rule

    def _forces(self, system: LocalSystem, states: States) -> Array | None:
        """Forces of given states: y_n = 0 where closed, y_t = 0 where stuck; None if singular."""
        q, unknown, slipping = system.q, states.unknown, states.slipping
        f = np.zeros_like(q)
        if not len(unknown):
            return f
        flat, forces = system.W.reshape(q.size, q.size), f.ravel()
        matrix, right = flat[unknown[:, None], unknown], -q.ravel()[unknown]
        if len(slipping):
            slope = states.sign * states.line[0][states.points]
            intercept = states.sign * states.line[1][states.points]
            coupling = flat[unknown[:, None], states.tangential]
            matrix[:, slipping] += slope * coupling
            right -= coupling @ intercept
        _, _, x, info = dgesv(matrix, right, 1, 1)
        if info:
            return None
        forces[unknown] = x
        if len(slipping):
            forces[states.tangential] = slope * x[slipping] + intercept
        return f

    def _newton(
        self, system: LocalSystem, f: Array, discs: Discs, states: States | None = None
    ) -> Array | None:
        """Active-set iteration until the states repeat themselves; None where they cycle.

        Or wander: many points have many states, and those that settle do so in few rounds.
        """
        if states is None:
            states = States(*self._decide(system, f, discs))
        seen: set[bytes] = set()
        while states.key not in seen and len(seen) < ROUNDS + len(f):
            seen.add(states.key)
            found = self._forces(system, states)
            if found is None:
                return None
            code, rule = self._decide(system, found, discs)
            if code.tobytes() + rule[0].tobytes() == states.key:
                if discs.mu is system.bounds.mu and discs.slope == np.inf:
                    self._last = states
                return found
            states = States(code, rule)
        return None


def _enumerated(system: LocalSystem, start: Array) -> Array | None:
    """Every state of every point, for as few points as that is bearable."""
    if len(start) > compiled.ENUMERATED_POINTS:
        return None
    (W, q, forces), scaling = system.flat(start), system.scaling.ravel()
    states = np.zeros(len(start), dtype=np.int64)
    bounds = compiled.Bounds(system.bounds.mu, system.bounds.cohesion, np.zeros_like(states))
    found = compiled.enumeration(W, q, scaling, bounds, states, forces)
    return forces.reshape(start.shape) if found else None


def _one_point(system: LocalSystem) -> Array | None:
    """The force at a single point: open, sticking, or slipping either way."""
    (nn, nt), (tn, tt) = system.W.reshape(2, 2).tolist()
    free_n, free_t = system.q[0].tolist()
    mu, cohesion = float(system.bounds.mu[0]), float(system.bounds.cohesion[0])
    if free_n >= 0:
        return np.zeros((1, 2))
    if not (mu or cohesion):
        return np.array([[-free_n / nn, 0.0]])
    determinant = nn * tt - nt * tn
    normal, tangential = nt * free_t - tt * free_n, tn * free_n - nn * free_t
    if determinant > 0 < normal and abs(tangential) <= mu * normal + cohesion * determinant:
        return np.array([[normal / determinant, tangential / determinant]])
    rules = ((mu, cohesion), (mu + TOUCHING_SLOPE, 0.0)) if cohesion else ((mu, 0.0),)
    for slope, intercept in rules:
        for sign in (1.0, -1.0):
            denominator = nn + sign * slope * nt
            numerator = -(free_n + sign * intercept * nt)
            if numerator * denominator <= 0:
                continue
            normal = numerator / denominator
            force = sign * (slope * normal + intercept)
            if sign * (free_t + tn * normal + tt * force) <= 0:
                return np.array([[normal, force]])
    return None
