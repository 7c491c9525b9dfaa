"""PETSc SNES, told what the residual is and how to correct it.

SNES drives, monitors and judges; the correction (free step, local contact problem, compliance) stands where
a preconditioned Krylov method stands elsewhere: `newtonls`, line search `basic`, `preonly`, a shell matrix
and a Python preconditioner. All options are within reach under the prefix, as in

    rockslip run scene.toml -- -rockslip_snes_monitor
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PREFIX = "rockslip_"

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
class Outcome:
    """How a nonlinear solve ended."""

    converged: bool
    iterations: int
    residual: float
    reason: str


class Tangent:
    """The shell matrix that SNES is given; with `preonly` nothing is ever multiplied by it."""


class Correction:
    """The preconditioner of SNES: turns a residual into the negative of a correction."""

    def __init__(self, correct: Callable[[Array], Array]):
        """Take the function that gives the correction du for a residual."""
        self._correct = correct

    def apply(self, pc: PETSc.PC, residual: PETSc.Vec, negative: PETSc.Vec) -> None:
        """Called by PETSc; the residual is locked and may only be read."""
        negative.array[:] = -self._correct(residual.array_r)


class NonlinearSolver:
    """One SNES for a whole run."""

    def __init__(
        self,
        comm: MPI.Intracomm,
        size: int,
        residual: Callable[[Array], Array],
        correct: Callable[[Array], Array],
        options: Sequence[str] = (),
    ):
        """Set SNES up.

        Args:
            comm: Communicator.
            size: Owned unknowns of this rank.
            residual: Residual at given unknowns.
            correct: Correction for the residual at the unknowns last given.
            options: PETSc options, as on a command line; they override what is set here.
        """
        self._residual = residual
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
        snes.setJacobian(self._jacobian, shell, shell)
        snes.setTolerances(rtol=0.0, atol=0.0, stol=1e-15, max_it=30)
        ksp = snes.getKSP()
        ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = ksp.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(Correction(correct))
        self._set_options(snes, options)
        self.snes = snes
        self._tolerance = snes.getTolerances()[1]  # the user's, where options name one

    @staticmethod
    def _set_options(snes: PETSc.SNES, options: Sequence[str]) -> None:
        """Let SNES read the user's options, and take them out of PETSc's data base again."""
        database = PETSc.Options()
        chosen: dict[str, str | None] = {f"-{PREFIX}snes_linesearch_type": "basic"}
        for position, word in enumerate(options):
            if _is_name(word):
                following = options[position + 1] if position + 1 < len(options) else None
                chosen[word] = None if following is None or _is_name(following) else following
        for name, value in chosen.items():
            database.setValue(name, value)
        snes.setFromOptions()
        for name in chosen:
            database.delValue(name)

    def _function(self, snes: PETSc.SNES, x: PETSc.Vec, r: PETSc.Vec) -> None:
        """Residual, called by SNES."""
        r.array[:] = self._residual(x.array_r)

    def _jacobian(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        """The tangent is constant in the frame of the body: nothing to assemble."""

    def destroy(self) -> None:
        """Free what PETSc holds; collective."""
        for thing in (self.snes, self._shell, self._x, self._r):
            thing.destroy()

    def solve(self, unknowns: Array, tolerance: float) -> tuple[Array, Outcome]:
        """Solve from `unknowns` until the residual is below `tolerance` (its Euclidean norm)."""
        self.snes.setTolerances(atol=self._tolerance or tolerance)
        self._x.array[:] = unknowns
        self.snes.solve(None, self._x)
        code = self.snes.getConvergedReason()
        reason = REASONS.get(code, f"SNES reason {code}")
        return self._x.array_r.copy(), Outcome(
            code > 0, self.snes.getIterationNumber(), self.snes.getFunctionNorm(), reason
        )


def _is_name(word: str) -> bool:
    """Whether a word of a command line names an option (and is not a negative number)."""
    return word.startswith("-") and len(word) > 1 and not word[1].isdigit() and word[1] != "."
