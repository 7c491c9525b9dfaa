"""Forms of finite elements: compiled for this processor, with constants packed once.

PETSc takes SIGPIPE over when it is imported, which is taken back here.
"""

from __future__ import annotations

import platform
import signal
import threading
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from petsc4py import PETSc

import numpy as np
from dolfinx import cpp, fem, jit
from numpy.typing import NDArray

VECTORIZED = ["-O3", "-g0", "-fassociative-math", "-fno-signed-zeros", "-fno-trapping-math"]
"""Options with which the C compiler sums over quadrature points and nodes several at a time: two to
four times as fast as by the options of dolfinx. NaN stays NaN. (-ffast-math would let it forget
that, and old linkers then flush small numbers to zero in the whole process.)"""

LEVELS = {
    "x86-64-v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": {"avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"},
}
"""Instruction sets, the largest first, by the flags of Linux. Named, and not "native": code that is
kept for one processor is then never run on another."""


@cache
def compiler_options() -> dict[str, Any]:
    """Options for the compilation of forms; none where the user's settings of dolfinx have them."""
    wanted, name = jit.get_options(), "cffi_extra_compile_args"
    if wanted[name] != jit.DOLFINX_DEFAULT_JIT_OPTIONS[name][0]:
        return {}
    about, found = Path("/proc/cpuinfo"), set[str]()
    if platform.machine() == "x86_64" and about.exists():
        lines = about.read_text(encoding="ascii", errors="replace").splitlines()
        found = set(next((line for line in lines if line.startswith("flags")), "").split())
    known = list(LEVELS.items())
    # Each level holds all below it.
    fitting = [k for k in range(len(known)) if all(has <= found for _, has in known[k:])]
    chosen = [f"-march={known[fitting[0]][0]}"] if fitting else []
    return {name: [*VECTORIZED, *chosen]}


def _ignore_closed_pipes() -> None:
    """Ignore SIGPIPE, as Python does: PETSc took it over when it was imported, and would abort."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)


_ignore_closed_pipes()


def packed_coefficients(form: Any) -> dict[Any, NDArray[np.float64]]:
    """Values of all functions of a compiled form, cell by cell, as its assembly takes them."""
    return {key: table.copy() for key, table in cpp.fem.pack_coefficients(form._cpp_object).items()}


class PackedForm:
    """A compiled form whose constants are packed once: assembly in the time loop without set-up.

    Constants are packed anew by `refresh` only; coefficients at each assembly, unless the form has
    been given `cells`, which then holds their values.
    """

    def __init__(self, form: Any):
        """Compile `form`."""
        self.form = fem.form(form, jit_options=compiler_options())
        self.cells: Mapping[Any, NDArray[np.float64]] | None = None
        self.refresh()

    def refresh(self) -> None:
        """Read the constants again."""
        self.constants = cpp.fem.pack_constants(self.form._cpp_object)

    def _coefficients(self) -> Any:
        """The coefficient functions, cell by cell, as they are now."""
        if self.cells is not None:
            return self.cells
        return cpp.fem.pack_coefficients(self.form._cpp_object)

    def scalar(self) -> float:
        """Integral over the cells of this rank."""
        value = cpp.fem.assemble_scalar(self.form._cpp_object, self.constants, self._coefficients())
        return float(value)

    def vector(self, target: NDArray[np.float64]) -> None:
        """Assemble into `target` (owned and ghost entries), which is overwritten."""
        target.fill(0.0)
        cpp.fem.assemble_vector(target, self.form._cpp_object, self.constants, self._coefficients())

    def matrix(self) -> PETSc.Mat:
        """Assemble a PETSc matrix."""
        from dolfinx.fem.petsc import assemble_matrix

        matrix = assemble_matrix(self.form)
        matrix.assemble()
        return matrix
