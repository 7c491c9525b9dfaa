"""PETSc SNES with a residual and its correction.

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

from solver.errors import RockslipError, SceneError
from solver.stepping.convergence import (
    Convergence,
    IterationRecord,
    IterationTolerances,
    ResidualTolerance,
)
from solver.stepping.petsc_options import PREFIX, command_line, parse_options
from solver.types import Array

CORRECTION_TOLERANCE = 1e-15
"""Part of the unknowns that a correction has to exceed to change anything but round-off."""

DEFAULTS = {f"{PREFIX}snes_linesearch_type": "basic", f"{PREFIX}snes_lag_jacobian": "-2"}
"""Full corrections; the tangent is a shell that never changes: once it is set is enough."""

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
    """Outcome of a nonlinear solve."""

    converged: bool
    """True if it found a solution."""
    iterations: int
    """Corrections that it took."""
    residual: float
    """Euclidean norm of the last residual, N."""
    reason: str
    """Reason why it ended, in words."""


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


def _last_line(error: PETSc.Error) -> str:
    """The last line of an error of PETSc."""
    return str(error).splitlines()[-1]


@contextmanager
def _in_data_base(options: Mapping[str, str | None]) -> Iterator[None]:
    """Let options stand in PETSc's data base meanwhile."""
    for name, value in options.items():
        PETSc.Options().setValue(name, value)
    try:
        yield
    finally:
        for name in options:
            PETSc.Options().delValue(name)


def check_options(words: Sequence[str] = ()) -> None:
    """Refuse options that SNES does not take, before anything else is done.

    They are those given, besides what PETSc was started with.
    """
    NonlinearSolver(MPI.COMM_SELF, 1, ArithmeticError, words).close()


class NonlinearSolver:
    """One SNES for a whole run; `solve` is given one problem after another.

    It is the context of the Python preconditioner, whose `apply` PETSc calls.
    """

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

        Raises:
            SceneError: PETSc does not take an option, or it is for another method.
        """
        self._convergence, self._failure = Convergence(), failure
        self._problem: NonlinearProblem | None = None
        self._trouble: Exception | None = None
        """Exception for want of a correction, if that is why SNES stopped."""
        self._residuals: list[float] = []
        self._x = PETSc.Vec().createMPI((size, None), comm=comm)
        self._r = self._x.duplicate()
        self._shell = PETSc.Mat().createPython(((size, None), (size, None)), object(), comm=comm)
        self._shell.setUp()
        self._options = dict(parse_options(options))
        self.snes = self._set_up(comm)
        self._relative, self._tolerance, self._smallest, _ = self.snes.getTolerances()
        """The user's tolerances: of the residual relative and absolute, N, and of a correction; the
        absolute one is 0 where options name none."""
        self._tolerances = IterationTolerances(ResidualTolerance.of_norm(0.0), 0.0, 0.0)

    def _set_up(self, comm: MPI.Intracomm) -> PETSc.SNES:
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
        pc.setPythonContext(self)
        snes.setSolution(self._x)
        given = PETSc.Options().getAll()
        defaults = {name: value for name, value in DEFAULTS.items() if name not in given}
        with _in_data_base(defaults | self._options):
            try:
                snes.setFromOptions()
                snes.setUp()
            except PETSc.Error as error:
                raise self._refused(f"values for PETSc: {_last_line(error)}") from None
            methods = snes.getType(), snes.getKSP().getType(), snes.getKSP().getPC().getType()
            if methods != ("newtonls", "preonly", "python") or snes.hasNPC():
                allowed = "newtonls, preonly and python: no matrix is assembled for others"
                raise self._refused(allowed)
        return snes

    def _given(self) -> dict[str, str | None]:
        """The options of this solver, in PETSc's data base and besides."""
        known = PETSc.Options().getAll().items() - DEFAULTS.items()
        return {name: value for name, value in known if name.startswith(PREFIX)} | self._options

    def _refused(self, allowed: str) -> SceneError:
        """The options, refused."""
        return SceneError("options after --", " ".join(command_line(self._given())), allowed)

    def _function(self, snes: PETSc.SNES, x: PETSc.Vec, r: PETSc.Vec) -> None:
        """Residual, called by SNES; not a number where the unknowns are past all geometry."""
        assert self._problem is not None
        try:
            r.array = self._problem.residual(x.array_r.copy())
        except np.linalg.LinAlgError:  # no exception may pass through PETSc
            r.set(np.nan)

    def apply(self, pc: PETSc.PC, residual: PETSc.Vec, negative: PETSc.Vec) -> None:
        """The negative of the correction, called by PETSc; the residual may only be read."""
        assert self._problem is not None
        try:
            negative.array = -self._problem.correction(residual.array_r)
        except (self._failure, np.linalg.LinAlgError, RockslipError) as trouble:
            # No exception may pass through PETSc: not-a-number ends SNES.
            self._trouble = trouble
            negative.set(np.nan)

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

    def close(self) -> None:
        """Free what PETSc holds; collective."""
        for thing in (self.snes, self._shell, self._x, self._r):
            thing.destroy()

    @property
    def residual(self) -> Array:
        """The residual where SNES stopped (owned unknowns), N."""
        return np.array(self._r.array_r)

    def solve(
        self, problem: NonlinearProblem, unknowns: Array, tolerance: ResidualTolerance
    ) -> tuple[Array, NewtonOutcome]:
        """Solve a problem from a guess; where SNES stopped, and how it ended.

        Raises:
            RockslipError: A correction needs what this machine has not, or an option a Jacobian.
        """
        self._problem, self._trouble = problem, None
        if self._tolerance:  # the user's
            tolerance = ResidualTolerance.of_norm(self._tolerance)
        self.snes.setTolerances(atol=tolerance.norm)
        self._tolerances = IterationTolerances(tolerance, self._relative, self._smallest)
        self._x.array = unknowns
        options = _in_data_base(self._options) if self._options else nullcontext()
        try:
            with options, np.errstate(over="ignore", invalid="ignore"):  # what diverges says so
                self.snes.solve(None, self._x)
        except PETSc.Error as error:
            if not self._given():
                raise
            allowed = f"those that multiply by no matrix: {_last_line(error)}"
            raise self._refused(allowed) from None
        trouble = self._trouble
        if isinstance(trouble, RockslipError):
            raise trouble
        code = self.snes.getConvergedReason()
        reason = str(trouble) if trouble else REASONS.get(code, f"SNES reason {code}")
        return np.array(self._x.array_r), NewtonOutcome(
            code > 0, self.snes.getIterationNumber(), self.snes.getFunctionNorm(), reason
        )
