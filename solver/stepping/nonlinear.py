"""PETSc SNES, told what the residual is and how to correct it.

SNES drives, monitors and judges; the correction (free step, local contact problem, compliance)
stands where a preconditioned Krylov method stands elsewhere: `newtonls`, line search `basic`,
`preonly`, a shell matrix and a Python preconditioner. All options are within reach under the
prefix, as in

    rockslip run scene.toml -- -rockslip_snes_monitor
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from solver.stepping.petsc_options import PREFIX, parse_options
from solver.types import Array

ROUND_OFF = 50.0
"""A residual within this factor of its tolerance that no longer falls is round-off,"""

STANDS = 0.9
"""that is, not by more than this factor: one that falls slowly still falls."""

EXPECTED = 0.1
"""Of several corrections the last has to be expected to leave no more than this part of the
tolerance: the residual before it, times the factor by which the correction before that shrank it.
Then what is left is round-off, and hardly depends on the number of ranks. A single correction tells
nothing of this; bodies that do not turn need no more."""

PATIENCE, SLOW, MOST = 30, 15, 300
"""Iterations after which the residual has to have halved within so many of the last ones, and the
most there are. Bodies whose volume hardly changes converge slowly, but surely, where they are
strained or turn fast; an iteration that goes to and fro does not, and a shorter step is better."""

GROWN = 1e8
"""A residual that grew by this factor does not fall again (of those that did: by 140 at most)."""

REASONS = {
    2: "residual below its absolute tolerance",
    3: "residual below its relative tolerance",
    4: "correction below its tolerance",
    5: "largest number of iterations, taken as converged",
    -1: "function domain error",
    -2: "a function was called too often",
    -3: "the linear solve failed",
    -4: "the residual is not a number",
    -5: "largest number of iterations",
    -6: "the line search failed",
    -7: "the inner solve failed",
    -8: "a local minimum that is no solution",
    -9: "the residual grows",
}


@dataclass(frozen=True, slots=True)
class NewtonOutcome:
    """How a nonlinear solve ended."""

    converged: bool
    iterations: int
    residual: float
    reason: str


class Tangent:
    """The shell matrix that SNES is given; with `preonly` nothing is ever multiplied by it."""


class Correction:
    """The preconditioner of SNES: turns a residual into the negative of a correction."""

    def __init__(self, correct: Callable[[Array], Array], failure: type[Exception]):
        """Take the function that gives the correction du for a residual, and what it may raise."""
        self._correct, self._failure = correct, failure
        self.trouble: Exception | None = None

    def apply(self, pc: PETSc.PC, residual: PETSc.Vec, negative: PETSc.Vec) -> None:
        """Called by PETSc; the residual is locked and may only be read."""
        try:
            negative.array[:] = -self._correct(residual.array_r)
        except (self._failure, np.linalg.LinAlgError) as trouble:
            # No exception may pass through PETSc: not-a-number ends SNES.
            self.trouble = trouble
            negative.array[:] = np.nan


class NonlinearSolver:
    """One SNES for a whole run."""

    def __init__(
        self,
        comm: MPI.Intracomm,
        size: int,
        residual: Callable[[Array], Array],
        correct: Callable[[Array], Array],
        failure: type[Exception],
        options: Sequence[str] = (),
    ):
        """Set SNES up.

        Args:
            comm: Communicator.
            size: Owned unknowns of this rank.
            residual: Residual at given unknowns.
            correct: Correction for the residual at the unknowns last given.
            failure: What `correct` raises where there is no correction.
            options: PETSc options, as on a command line; they override what is set here.
        """
        self._residual = residual
        self._past: list[float] = []
        self._x = PETSc.Vec().createMPI((size, None), comm=comm)
        self._r = self._x.duplicate()
        self._shell = shell = PETSc.Mat().createPython(
            ((size, None), (size, None)), Tangent(), comm=comm
        )
        shell.setUp()
        snes = PETSc.SNES().create(comm)
        snes.setOptionsPrefix(PREFIX)
        snes.setType(PETSc.SNES.Type.NEWTONLS)
        snes.setFunction(self._function, self._r)
        snes.setConvergenceTest(self._judge)
        snes.setJacobian(self._jacobian, shell, shell)
        snes.setTolerances(rtol=0.0, atol=0.0, stol=1e-15, max_it=MOST)
        ksp = snes.getKSP()
        ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = ksp.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        self._correction = Correction(correct, failure)
        pc.setPythonContext(self._correction)
        self._set_options(snes, options)
        self.snes = snes
        self._tolerance = snes.getTolerances()[1]  # the user's, where options name one

    @staticmethod
    def _set_options(snes: PETSc.SNES, options: Sequence[str]) -> None:
        """Let SNES read the user's options, and take them out of PETSc's data base again."""
        database = PETSc.Options()
        chosen: dict[str, str | None] = {f"-{PREFIX}snes_linesearch_type": "basic"}
        chosen.update(parse_options(options))
        for name, value in chosen.items():
            database.setValue(name, value)
        snes.setFromOptions()
        for name in chosen:
            database.delValue(name)

    def _function(self, snes: PETSc.SNES, x: PETSc.Vec, r: PETSc.Vec) -> None:
        """Residual, called by SNES; not a number where the unknowns are past all geometry."""
        try:
            r.array[:] = self._residual(x.array_r)
        except np.linalg.LinAlgError:  # no exception may pass through PETSc
            r.array[:] = np.nan

    def _judge(self, snes: PETSc.SNES, iterations: int, norms: tuple[float, float, float]) -> int:
        """SNES's own test, and an end where round-off keeps the residual from falling further."""
        unknowns, correction, residual = norms
        rtol, atol, stol, _ = snes.getTolerances()
        past = self._past
        if iterations == 0:
            past.clear()
        past.append(residual)
        if not np.isfinite(residual):
            return int(PETSc.SNES.ConvergedReason.DIVERGED_FNORM_NAN)
        if iterations == 0:
            return 0  # forces that balance need not obey the contact law of this step
        first, before = past[0], past[-2]
        shrunk = before / past[-3] if iterations > 1 and past[-3] else 0.0
        if residual <= atol and (iterations == 1 or before * shrunk <= EXPECTED * atol):
            return int(PETSc.SNES.ConvergedReason.CONVERGED_FNORM_ABS)
        if residual <= rtol * first:
            return int(PETSc.SNES.ConvergedReason.CONVERGED_FNORM_RELATIVE)
        stands_still = iterations > 1 and residual > STANDS * before and residual < ROUND_OFF * atol
        if correction <= stol * unknowns or stands_still:
            return int(PETSc.SNES.ConvergedReason.CONVERGED_SNORM_RELATIVE)
        if residual > GROWN * first > GROWN * atol:  # grown from more than round-off
            return int(PETSc.SNES.ConvergedReason.DIVERGED_DTOL)
        if iterations >= PATIENCE and residual > 0.5 * past[-1 - SLOW]:
            return int(PETSc.SNES.ConvergedReason.DIVERGED_MAX_IT)
        return 0

    def _jacobian(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        """The tangent is constant in the frame of the body: nothing to assemble."""

    def destroy(self) -> None:
        """Free what PETSc holds; collective."""
        for thing in (self.snes, self._shell, self._x, self._r):
            thing.destroy()

    @property
    def residual(self) -> Array:
        """What was left of the residual when SNES stopped (owned unknowns)."""
        return self._r.array_r.copy()

    def solve(self, unknowns: Array, tolerance: float) -> tuple[Array, NewtonOutcome]:
        """Solve from `unknowns` until the residual is below `tolerance` (its Euclidean norm)."""
        self.snes.setTolerances(atol=self._tolerance or tolerance)
        self._x.array[:] = unknowns
        self._correction.trouble = None
        with np.errstate(over="ignore", invalid="ignore"):  # an iteration that diverges says so
            self.snes.solve(None, self._x)
        code = self.snes.getConvergedReason()
        trouble = self._correction.trouble
        reason = str(trouble) if trouble else REASONS.get(code, f"SNES reason {code}")
        return self._x.array_r.copy(), NewtonOutcome(
            code > 0, self.snes.getIterationNumber(), self.snes.getFunctionNorm(), reason
        )
