"""PETSc SNES, told what the residual is and how to correct it.

SNES drives, monitors and judges; the correction (free step, local contact problem, compliance)
stands where a preconditioned Krylov method stands elsewhere: `newtonls`, line search `basic`,
`preonly`, a shell matrix and a Python preconditioner. All options are within reach under the
prefix, as in

    rockslip run scene.toml -- -rockslip_snes_monitor
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from typing import NamedTuple, Protocol

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from solver.errors import RockslipError, SceneError, Statement
from solver.stepping.convergence import (
    Convergence,
    IterationRecord,
    IterationTolerances,
    ResidualTolerance,
)
from solver.stepping.petsc_options import PREFIX, PetscOptions, parse_options, refuse_unused
from solver.types import Array

CORRECTION_TOLERANCE = 1e-15
"""Part of the unknowns that a correction has to exceed to change anything but round-off."""

NOTHING = nullcontext()
"""What an iteration is surrounded by where no option has to stand in PETSc's data base."""

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


class NewtonOutcome(NamedTuple):
    """How a nonlinear solve ended."""

    converged: bool
    """Whether it found a solution."""
    iterations: int
    """Corrections that it took."""
    residual: float
    """Euclidean norm of the last residual, N."""
    reason: str
    """Why it ended, in words."""


class NonlinearProblem(Protocol):
    """A residual that is to vanish, and what corrects the unknowns."""

    @property
    def forces(self) -> float:
        """Largest norm of the contact forces so far, N: the scale that a residual grows against."""

    def residual(self, u: Array) -> Array:
        """The out-of-balance force at unknowns u (owned), N."""

    def correction(self, residual: Array) -> Array:
        """The correction du for the residual at the unknowns last given, m."""

    def acceleration(self) -> float:
        """Largest acceleration of a body by the resultant of that residual, m/s2; collective."""


class Tangent:
    """The shell matrix that SNES is given; with `preonly` nothing is ever multiplied by it.

    Nor can anything be: the residual depends on the point forces, which corrections change, too,
    and those of rigid bodies have no derivative by the displacement.
    """

    multiplied = False
    """Whether an option let PETSc ask for a product all the same."""

    def mult(self, matrix: PETSc.Mat, vector: PETSc.Vec, product: PETSc.Vec) -> None:
        """Called by PETSc; not-a-number, since no exception may pass through it."""
        self.multiplied = True
        product.array[:] = np.nan


class VectorArrays:
    """The numbers of PETSc's vectors: to ask PETSc for them takes longer than to copy them.

    A vector whose array is kept is never freed, so that its handle stands for no other one.
    """

    MOST = 4
    """Arrays that are kept to be read, and as many to be written: SNES and its preconditioner take
    turns with four vectors."""

    def __init__(self) -> None:
        """Keep none yet."""
        self._read: dict[int, Array] = {}
        self._written: dict[int, Array] = {}

    def read(self, vector: PETSc.Vec) -> Array:
        """The numbers of a vector that may be locked, to be read only."""
        try:
            return self._read[vector.handle]
        except KeyError:
            return self._keep(self._read, vector, vector.array_r)

    def written(self, vector: PETSc.Vec) -> Array:
        """The numbers of a vector, to be written now."""
        vector.stateIncrease()  # PETSc keeps norms of what stays the same
        try:
            return self._written[vector.handle]
        except KeyError:
            return self._keep(self._written, vector, vector.array)

    def forget(self) -> None:
        """Keep none any more."""
        self._read.clear()
        self._written.clear()

    def _keep(self, arrays: dict[int, Array], vector: PETSc.Vec, found: Array) -> Array:
        """The array of a vector, which is kept from now on if there is room."""
        if len(arrays) < self.MOST:
            arrays[vector.handle] = found
        return found


class Correction:
    """The preconditioner of SNES, which turns a residual into the negative of a correction."""

    def __init__(self, failure: type[Exception], arrays: VectorArrays):
        """Take what a problem raises where it has no correction, and the arrays of vectors."""
        self._failure, self._arrays = failure, arrays
        self._problem: NonlinearProblem | None = None
        self.trouble: Exception | None = None
        self.refusal: RockslipError | None = None
        """What ends the run, not only the step."""

    def begin(self, problem: NonlinearProblem) -> None:
        """Correct the residuals of this problem from now on."""
        self._problem, self.trouble = problem, None

    def apply(self, pc: PETSc.PC, residual: PETSc.Vec, negative: PETSc.Vec) -> None:
        """Called by PETSc; the residual is locked and may only be read."""
        assert self._problem is not None
        values, target = self._arrays.read(residual), self._arrays.written(negative)
        try:
            np.negative(self._problem.correction(values), out=target)
        except (self._failure, np.linalg.LinAlgError) as trouble:
            # No exception may pass through PETSc: not-a-number ends SNES.
            self.trouble = trouble
            target[:] = np.nan
        except RockslipError as refusal:
            self.refusal = refusal
            target[:] = np.nan


def _not_for_petsc(words: str, error: PETSc.Error) -> SceneError:
    """What PETSc says of options."""
    return SceneError("options after --", words, f"values for PETSc: {str(error).splitlines()[-1]}")


@contextmanager
def in_data_base(options: Mapping[str, str | None]) -> Iterator[None]:
    """Let options stand in PETSc's data base meanwhile."""
    for name, value in options.items():
        PETSc.Options().setValue(name, value)
    try:
        yield
    finally:
        for name in options:
            PETSc.Options().delValue(name)


def check_options(words: Sequence[str]) -> None:
    """Refuse options for PETSc that it does not know, before anything else is done."""
    NonlinearSolver(MPI.COMM_SELF, 1, ArithmeticError, words).destroy()


class NonlinearSolver:
    """One SNES for a whole run; `solve` is given one problem after another."""

    def __init__(
        self,
        comm: MPI.Intracomm,
        size: int,
        failure: type[Exception],
        options: Sequence[str] = (),
    ):
        """Set SNES up for the owned unknowns of this rank.

        A problem raises `failure` where it has no correction. PETSc's options are as on a command
        line and override what is set here.
        """
        self._convergence = Convergence()
        self._problem: NonlinearProblem | None = None
        self._residuals: list[float] = []
        self._x = PETSc.Vec().createMPI((size, None), comm=comm)
        self._r = self._x.duplicate()
        self._arrays = VectorArrays()
        self._tangent, self._words = Tangent(), " ".join(options)
        sizes = (size, None), (size, None)
        self._shell = PETSc.Mat().createPython(sizes, self._tangent, comm=comm)
        self._shell.setUp()
        self._correction = Correction(failure, self._arrays)
        self.snes = self._set_up(comm, options)
        self._relative, self._tolerance, self._smallest, _ = self.snes.getTolerances()
        """The user's tolerances: of the residual relative and absolute, N, and of a correction; the
        absolute one is 0 where options name none."""
        self._tolerances = IterationTolerances(ResidualTolerance.of_norm(0.0), 0.0, 0.0)

    def _set_up(self, comm: MPI.Intracomm, options: Sequence[str]) -> PETSc.SNES:
        """SNES with a correction in the place of a preconditioned Krylov method."""
        snes = PETSc.SNES().create(comm)
        snes.setOptionsPrefix(PREFIX)
        snes.setType(PETSc.SNES.Type.NEWTONLS)
        snes.setFunction(self._function, self._r)
        snes.setConvergenceTest(self._judge)
        snes.setJacobian(self._jacobian, self._shell, self._shell)
        snes.setTolerances(
            rtol=0.0, atol=0.0, stol=CORRECTION_TOLERANCE, max_it=self._convergence.most
        )
        ksp = snes.getKSP()
        ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = ksp.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(self._correction)
        self._late = self._set_options(snes, options).late
        return snes

    @staticmethod
    def _set_options(snes: PETSc.SNES, words: Sequence[str]) -> PetscOptions:
        """Let SNES read the user's options, and take them out of PETSc's data base again."""
        options = parse_options(words)
        # The tangent is a shell that never changes: once it is asked for is enough (-2).
        chosen = {
            f"{PREFIX}snes_linesearch_type": "basic",
            f"{PREFIX}snes_lag_jacobian": "-2",
            **options.solver,
        }
        try:
            with in_data_base(chosen):
                snes.setFromOptions()
                refuse_unused(options)
        except PETSc.Error as error:
            raise _not_for_petsc(" ".join(words), error) from None
        return options

    def _function(self, snes: PETSc.SNES, x: PETSc.Vec, r: PETSc.Vec) -> None:
        """Residual, called by SNES; not a number where the unknowns are past all geometry."""
        assert self._problem is not None
        try:
            residual = self._problem.residual(self._arrays.read(x).copy())
        except np.linalg.LinAlgError:  # no exception may pass through PETSc
            residual = np.full(r.getLocalSize(), np.nan)
        self._arrays.written(r)[:] = residual

    def _judge(self, snes: PETSc.SNES, iterations: int, norms: tuple[float, float, float]) -> int:
        """The verdict on an iterate, called by SNES with the norms of x, of dx and of r."""
        assert self._problem is not None
        unknowns, correction, residual = norms
        if iterations == 0:
            self._residuals.clear()
        self._residuals.append(residual)
        problem = self._problem
        progress = IterationRecord(
            self._residuals, correction, unknowns, problem.forces, problem.acceleration
        )
        return int(self._convergence.judge(progress, self._tolerances))

    def _jacobian(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        """Called by SNES; the tangent is constant in the frame of the body and not assembled."""

    def destroy(self) -> None:
        """Free what PETSc holds; collective."""
        self._arrays.forget()
        for thing in (self.snes, self._shell, self._x, self._r):
            thing.destroy()

    @property
    def residual(self) -> Array:
        """The residual where SNES stopped (owned unknowns), N."""
        return self._arrays.read(self._r).copy()

    def solve(
        self, problem: NonlinearProblem, unknowns: Array, tolerance: ResidualTolerance
    ) -> tuple[Array, NewtonOutcome]:
        """Solve a problem from a guess; where SNES stopped, and how it ended.

        Raises:
            RockslipError: A correction needs what this machine has not, or an option a Jacobian.
        """
        self._problem = problem
        self._correction.begin(problem)
        if self._tolerance:  # the user's
            tolerance = ResidualTolerance.of_norm(self._tolerance)
        self.snes.setTolerances(atol=tolerance.norm)
        self._tolerances = IterationTolerances(tolerance, self._relative, self._smallest)
        self._arrays.written(self._x)[:] = unknowns
        late = in_data_base(self._late) if self._late else NOTHING
        try:
            with late, np.errstate(over="ignore", invalid="ignore"):  # what diverges says so
                self.snes.solve(None, self._x)
        except PETSc.Error as error:
            if not self._words:
                raise
            raise _not_for_petsc(self._words, error) from None
        if self._tangent.multiplied:
            what = "multiply by the Jacobian, and none is assembled; leave them out"
            raise Statement(f"options after --: {self._words}", what)
        if self._correction.refusal is not None:
            raise self._correction.refusal
        code = self.snes.getConvergedReason()
        trouble = self._correction.trouble
        reason = str(trouble) if trouble else REASONS.get(code, f"SNES reason {code}")
        return self._arrays.read(self._x).copy(), NewtonOutcome(
            code > 0, self.snes.getIterationNumber(), self.snes.getFunctionNorm(), reason
        )
