"""Solvers of the local contact problem in three dimensions, with the disc of friction itself.

`newton` holds for two dimensions as well, where the disc is an interval.

Newton's method is that of Alart and Curnier (1991): the root of f - P(f - r y), with P the
projection on the admissible forces, r one over the diagonal of W. Without a line search on this
residual it cycles in some problems, with it it stalls in some others; each settles most of what the
other leaves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgesv

from solver.contact.local_rescues import Method, gradual, projected, tresca
from solver.contact.local_system import (
    Line,
    LocalSystem,
    diagonal_scaling,
    project,
)
from solver.rigid.compiled import NUMBA
from solver.rigid.local_problem import TOUCHING_SLOPE

Array = NDArray[np.float64]

TOLERANCE = 1e-11
ROUND_OFF = 64 * float(np.finfo(float).eps)
ITERATIONS = 25
"""Of Newton's method, and one more for each point."""

HALVINGS = 12

FEW = 20
"""Points that the methods of rigid blocks are for: their elimination is a plain one."""

LENGTHS = ((1e-2, 1e-1), (1e2, 1e3))
"""r of `other_r` in the normal and the tangential directions, over one over the diagonal of W."""


class DiscSolver:
    """Newton's method with line search, and those behind it."""

    def __init__(self) -> None:
        """Name the slower methods, in the order in which they are tried: without, with cohesion."""
        slower: dict[str, Method] = {
            "other r": other_r,
            "projected": projected(either, rounds=25),
        }
        self.rescues: dict[str, Method] = {
            "full steps": lambda system, start: full_steps(system, start, system.line()),
            "machine code": in_machine_code,
            **slower,
            "tresca": tresca(either, rounds=25),
        }
        self.cohesive: dict[str, Method] = {
            "touching": lambda system, start: newton(system, start, system.touching),
            "machine code": in_machine_code,
            "gradual cohesion": gradual(either),
            **slower,
        }

    def fast(self, system: LocalSystem, start: Array) -> Array | None:
        """Newton's method."""
        return newton(system, start, system.coulomb)


def full_steps(system: LocalSystem, start: Array, line: Line) -> Array | None:
    """Newton's method without line search."""
    return newton(system, start, line, halvings=0)


def either(system: LocalSystem, start: Array, line: Line) -> Array | None:
    """Newton's method with line search, else without."""
    found = newton(system, start, line)
    return full_steps(system, start, line) if found is None else found


def other_r(system: LocalSystem, start: Array) -> Array | None:
    """Newton's method with r much smaller, then much larger; that of the system polishes.

    The root is the same for all r, but which states are tried on the way to it is not: of 151
    problems that Newton's method and its states of before left, these two settle 125.
    """
    for normal, tangential in LENGTHS:
        scaling = diagonal_scaling(system.W)
        scaling[:, 0] *= normal
        scaling[:, 1:] *= tangential
        found = newton(system.scaled(scaling), start, system.line())
        polished = None if found is None else newton(system, found, system.line())
        if polished is not None:
            return polished
    return None


def in_machine_code(system: LocalSystem, start: Array) -> Array | None:
    """The methods of rigid blocks, which settle most of few points in a few milliseconds; polished.

    Of 159, 150, 698 and 184 problems that Newton's method left in four scenes it settles 112, 127,
    558 and 117.
    """
    if NUMBA is None or len(start) > FEW:
        return None
    from solver.rigid.space_friction import settle_with
    from solver.rigid.space_sweeps import Discs

    force, bounds = start.ravel().copy(), system.bounds
    W = np.ascontiguousarray(system.W.reshape(force.size, force.size))
    slope = TOUCHING_SLOPE if bounds.cohesion.any() else np.inf
    discs = Discs(bounds.mu, bounds.cohesion, slope)
    if not settle_with(W, system.q.ravel().copy(), force, discs):
        return None
    return newton(system, force.reshape(start.shape), system.line())


def newton(system: LocalSystem, f: Array, line: Line, *, halvings: int = HALVINGS) -> Array | None:
    """The root of f - P(f - r y); None where it is not reached.

    Args:
        system: The problem.
        f: Start, (m, d).
        line: Law of friction.
        halvings: How often the line search may halve a step.
    """
    trial = system.trial(f)
    nearest = project(trial, line)
    for _ in range(ITERATIONS + len(f)):
        noise = TOLERANCE * np.abs(f).max() + ROUND_OFF * np.abs(f - trial).max()
        if np.abs(f - nearest).max() <= noise:
            return nearest
        target = _linearised(system, trial, line)
        if target is None:
            return None
        found = _searched(system, line, f, target, nearest, halvings)
        if found is None:
            return None
        f, trial, nearest = found
    return None


def _searched(
    system: LocalSystem, line: Line, f: Array, target: Array, nearest: Array, halvings: int
) -> tuple[Array, Array, Array] | None:
    """The force between f and its target that leaves enough less, else the least; P of it too.

    None where no number is left: forces beyond all bounds, of an iteration that diverges.
    """
    before, least, best = float(np.linalg.norm(f - nearest)), np.inf, None
    for k in range(halvings + 1):
        step = 0.5**k
        force = f + step * (target - f)
        trial = system.trial(force)
        following = project(trial, line)
        left = float(np.linalg.norm(force - following))
        if left < least:
            least, best = left, (force, trial, following)
        if left <= (1.0 - 0.1 * step) * before:
            break
    return best


def _linearised(system: LocalSystem, trial: Array, line: Line) -> Array | None:
    """The root of the linearised f - P(f - r y), 0 at open points; None if singular."""
    force = np.zeros_like(trial)
    closed = np.flatnonzero(trial[:, 0] > 0)
    if not len(closed):
        return force
    scaling = system.scaling[closed]
    # Rows r y = 0: unscaled ones beside rows of forces lose six digits.
    matrix = scaling[:, :, None, None] * system.W[closed[:, None], :, closed].swapaxes(1, 2)
    right = -scaling * system.q[closed]
    slope, intercept = line(trial[:, 0])
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
