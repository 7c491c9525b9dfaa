"""Options for PETSc as they stand on a command line after `--`; read without PETSc."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from solver.errors import SceneError, Statement
from solver.scene.checking import nearest

PREFIX = "rockslip_"
"""Beginning of every option of the nonlinear solver, as in `-rockslip_snes_monitor`."""

SOLVER = ("snes_", "ksp_", "pc_")
"""What such options begin with without the prefix, which may be left out."""

OWN = (
    *("log_view", "log_view_memory", "log_trace", "log_all", "info", "memory_view", "version"),
    *("malloc_view", "malloc_debug", "malloc_dump", "malloc_test", "fp_trap", "no_signal_handler"),
    *("on_error_abort", "on_error_attach_debugger", "start_in_debugger", "stop_for_debugger"),
    *("options_left", "options_view", "options_monitor", "blas_view", "skip_petscrc"),
)
"""PETSc's own options, which it reads when it starts."""

VIEWS = ("snes_view", "snes_view_solution", "snes_view_pre", "ksp_view_solution", "pc_view")
"""Options of the solver that are read at the end of a solve, not when it is set up."""

MATRIX_FREE = {
    "snes_type": ("newtonls",),
    "snes_linesearch_type": ("basic", "l2", "cp"),
    "ksp_type": ("preonly",),
    "pc_type": ("python",),
}
"""The methods that do without products of the Jacobian: a correction solves the contact problem,
and there is no matrix."""

WITH_MATRIX = (
    *("snes_fd", "snes_fd_color", "snes_mf", "snes_mf_operator", "snes_test_jacobian"),
    *("snes_test_jacobian_view", "snes_compare_explicit", "snes_trdc", "npc_snes_type"),
)
"""Options that ask for a matrix."""


@dataclass(frozen=True, slots=True)
class PetscOptions:
    """Names and values of options, without the hyphen; a value of None: there is none."""

    solver: dict[str, str | None] = field(default_factory=dict)
    """Options of the nonlinear solver, with their prefix."""
    own: dict[str, str | None] = field(default_factory=dict)
    """PETSc's own options."""

    @property
    def late(self) -> dict[str, str | None]:
        """Options of the solver that are read at the end of a solve."""
        views = {f"{PREFIX}{name}" for name in VIEWS}
        return {name: value for name, value in self.solver.items() if name in views}

    def own_words(self) -> list[str]:
        """PETSc's own options as on a command line."""
        words = ((f"-{name}", value) for name, value in self.own.items())
        return [word for pair in words for word in pair if word is not None]


def parse_options(words: Sequence[str]) -> PetscOptions:
    """PETSc's options as on a command line.

    Raises:
        SceneError: Where a word is neither an option nor the value of one, or the option asks for
            a matrix.
    """
    found, table, name = PetscOptions(), dict[str, str | None](), ""
    for word in words:
        if _is_name(word):
            name = word.lstrip("-")
            if name.startswith(SOLVER):
                name = PREFIX + name
            table = found.solver if name.startswith(PREFIX) else found.own
            if table is found.own and name not in OWN:
                allowed = f"names that start with -{PREFIX}, or PETSc's own such as -log_view"
                meant = nearest(name, OWN)
                raise SceneError("options after --", word, allowed, meant and f"-{meant}")
            table[name] = None
        elif name and table[name] is None:
            table[name] = word
        else:
            raise SceneError("options after --", word, f"-{PREFIX}NAME [VALUE] ...")
    _refuse_matrices(found.solver)
    return found


def _refuse_matrices(options: Mapping[str, str | None]) -> None:
    """Refuse methods that multiply by a Jacobian: none is assembled here."""
    for name, value in options.items():
        plain = name.removeprefix(PREFIX)
        if plain in WITH_MATRIX or plain.startswith("npc_"):
            what = "asks for a matrix, and none is assembled; leave it out"
            raise Statement(f"options after --: -{plain}", what)
        allowed = MATRIX_FREE.get(plain)
        if allowed is not None and value not in allowed:
            words = f"{' or '.join(allowed)}: others ask for a matrix, and none is assembled"
            raise SceneError(f"options after --: -{plain}", f"{value or 'nothing'}", words)


def refuse_unused(options: PetscOptions) -> None:
    """Refuse options of the solver that it has not asked for when it was set up.

    They stand in PETSc's data base. petsc4py does not tell which were used, PETSc itself does.
    """
    from petsc4py import PETSc

    library = ctypes.CDLL(PETSc.__file__)
    for name in options.solver.keys() - options.late.keys():
        used = ctypes.c_int(0)
        library.PetscOptionsUsed(None, name.encode(), ctypes.byref(used))
        if not used.value:
            allowed = f"an option of PETSc's SNES, KSP or PC behind -{PREFIX}"
            meant = nearest(name, [f"{PREFIX}{known}" for known in COMMON])
            raise SceneError("options after --", f"-{name}", allowed, meant and f"-{meant}")


COMMON = (
    *VIEWS,
    *MATRIX_FREE,
    *("snes_monitor", "snes_converged_reason", "snes_max_it", "snes_atol", "snes_rtol"),
    *("snes_stol", "snes_max_funcs", "snes_linesearch_monitor", "snes_linesearch_damping"),
    *("ksp_monitor", "ksp_view", "ksp_converged_reason", "snes_monitor_short"),
)
"""Names that a misspelt one may have meant."""


def _is_name(word: str) -> bool:
    """Whether a word of a command line names an option (and is not a negative number)."""
    return word.startswith("-") and len(word) > 1 and not word[1].isdigit() and word[1] != "."
