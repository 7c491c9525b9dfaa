"""Solvers of the local contact problem in three dimensions, with the disc of friction itself.

Newton's method is that of Alart and Curnier (1991): the root of f - P(f - r y), with P the
projection on the admissible forces, r one over the diagonal of W. Without a line search on this
residual it cycles in some problems, with it it stalls in some others; each settles most of what the
other leaves. Without, it is the compiled one of rigid blocks, where numba is installed. `newton`
holds for two dimensions as well, where the disc is an interval.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgesv

from solver.law.compiled import NUMBA
from solver.law.discs import Discs
from solver.law.friction import Bounds
from solver.law.local_rescues import Method, gradual, other_r, projected, tresca
from solver.law.local_system import LocalSystem, lines, project
from solver.types import Array

TOLERANCE = 1e-12
ROUND_OFF = 64 * float(np.finfo(float).eps)
ITERATIONS = 25
"""Of Newton's method, and one more for each point."""

HALVINGS = 12

FEW = 40
"""Points that the slower methods of rigid blocks are for."""

LENGTHS = ((1e-3, 10.0), (1e-2, 10.0), (1e-3, 0.1), (1e-3, 1.0), (0.1, 100.0), (1.0, 10.0))
"""r of `other_r` in the normal and the tangential directions, over one over the diagonal of W."""


class DiscSolver:
    """Newton's method, and those behind it."""

    def __init__(self) -> None:
        """Name the slower methods, in the order in which they are tried: without, with cohesion."""
        sideways, nearer = other_r(full_steps, LENGTHS), projected(either, rounds=25)
        self.rescues: dict[str, Method] = {
            "other r": sideways,
            "line search": lambda system, start: newton(system, start, system.coulomb),
            "machine code": in_machine_code,
            "projected": nearer,
            "tresca": tresca(either, rounds=25),
        }
        self.cohesive: dict[str, Method] = {
            "touching": lambda system, start: either(system, start, system.touching()),
            "other r": sideways,
            "machine code": in_machine_code,
            "gradual cohesion": gradual(either),
            "projected": nearer,
        }

    def get_ready(self) -> None:
        """Let what is compiled be compiled, or read what was kept, before time counts."""
        one = np.eye(3).reshape(1, 3, 1, 3), np.full((1, 3), -1.0), np.ones((1, 3))
        self.fast(LocalSystem(*one, Bounds.uniform(0.5, 1)), np.zeros((1, 3)))

    def fast(self, system: LocalSystem, start: Array) -> Array | None:
        """Newton's method without line search."""
        return full_steps(system, start, system.coulomb)


def full_steps(system: LocalSystem, start: Array, discs: Discs) -> Array | None:
    """Newton's method without line search."""
    if NUMBA is None or start.shape[1] < 3:
        return newton(system, start, discs, halvings=0)
    trial = system.trial(start)
    nearest = project(trial, discs)
    if _solved(start, trial, nearest):
        return nearest
    from solver.law import space_friction

    W, q, force = system.flat(start)
    patience = space_friction.Patience(ITERATIONS + len(start), TOLERANCE, 10 * TOLERANCE)
    if not space_friction.newton(W, q, force, discs, system.scaling[:, :2].copy(), patience):
        return None
    return project(system.trial(force.reshape(start.shape)), discs)


def either(system: LocalSystem, start: Array, discs: Discs) -> Array | None:
    """Newton's method without line search, else with it."""
    found = full_steps(system, start, discs)
    return newton(system, start, discs) if found is None else found


def _solved(f: Array, trial: Array, nearest: Array) -> bool:
    """Whether f and P(f - r y) are the same but for round-off."""
    noise = TOLERANCE * np.abs(f).max() + ROUND_OFF * np.abs(f - trial).max()
    return bool(np.abs(f - nearest).max() <= noise)


def in_machine_code(system: LocalSystem, start: Array) -> Array | None:
    """The methods of rigid blocks, which settle most of few points in a few milliseconds; polished.

    Of 159, 150, 698 and 184 problems that the line search left in four scenes they settle 112, 127,
    558 and 117.
    """
    if NUMBA is None or len(start) > FEW:
        return None
    from solver.law import space_friction

    W, q, force = system.flat(start)
    if not space_friction.settle_with(W, q, force, system.discs):
        return None
    return newton(system, force.reshape(start.shape), system.discs)


def newton(
    system: LocalSystem, f: Array, discs: Discs, *, halvings: int = HALVINGS
) -> Array | None:
    """The root of f - P(f - r y); None where it is not reached.

    Args:
        system: The problem.
        f: Start, (m, d).
        discs: Law of friction.
        halvings: How often the line search may halve a step.
    """
    trial = system.trial(f)
    nearest = project(trial, discs)
    for _ in range(ITERATIONS + len(f)):
        if _solved(f, trial, nearest):
            return nearest
        target = _linearised(system, trial, discs)
        if target is None:
            return None
        found = _searched(system, discs, f, target, nearest, halvings)
        if found is None:
            return None
        f, trial, nearest = found
    return None


def _searched(
    system: LocalSystem, discs: Discs, f: Array, target: Array, nearest: Array, halvings: int
) -> tuple[Array, Array, Array] | None:
    """The force between f and its target that leaves enough less, else the least; P of it too.

    None where no number is left: forces beyond all bounds, of an iteration that diverges.
    """
    before, least, best = float(np.linalg.norm(f - nearest)), np.inf, None
    for k in range(halvings + 1):
        step = 0.5**k
        force = f + step * (target - f)
        trial = system.trial(force)
        following = project(trial, discs)
        left = float(np.linalg.norm(force - following))
        if left < least:
            least, best = left, (force, trial, following)
        if left <= (1.0 - 0.1 * step) * before:
            break
    return best


def _linearised(system: LocalSystem, trial: Array, discs: Discs) -> Array | None:
    """The root of the linearised f - P(f - r y), 0 at open points; None if singular."""
    force = np.zeros_like(trial)
    closed = np.flatnonzero(trial[:, 0] > 0)
    if not len(closed):
        return force
    scaling = system.scaling[closed]
    # Rows r y = 0: unscaled ones beside rows of forces lose six digits.
    matrix = scaling[:, :, None, None] * system.W[closed[:, None], :, closed].swapaxes(1, 2)
    right = -scaling * system.q[closed]
    slope, intercept = lines(discs, trial[:, 0])
    _let_slip(matrix, right, trial[closed], slope[closed], intercept[closed])
    _, _, x, info = dgesv(matrix.reshape(right.size, right.size), right.ravel(), 1, 1)
    if info:
        return None
    force[closed] = x.reshape(right.shape)
    return force


def _let_slip(matrix: Array, right: Array, trial: Array, slope: Array, intercept: Array) -> None:
    """Turn the tangential rows of points whose trial force is beyond the disc into those of slip.

    There P = l e with e = tau/|tau|, and its derivative is e dl + (l/|tau|)(I - e e^T) dtau.
    """
    tau, limit = trial[:, 1:], slope * trial[:, 0] + intercept
    size = np.sqrt((tau**2).sum(axis=1))
    slip = np.flatnonzero(size > limit)
    if not len(slip):
        return
    e = tau[slip] / size[slip, None]
    turning = np.eye(e.shape[1]) - e[:, :, None] * e[:, None, :]
    turning *= (limit[slip] / size[slip])[:, None, None]
    rows = np.einsum("kab,kbjc->kajc", turning, matrix[slip, 1:])
    number = np.arange(len(slip))
    rows[number, :, slip, 1:] += np.eye(e.shape[1]) - turning
    rows[number, :, slip, 0] -= slope[slip, None] * e
    matrix[slip, 1:] = rows
    right[slip, 1:] = np.einsum("kab,kb->ka", turning, right[slip, 1:]) + intercept[slip, None] * e
