"""Versions, ranks and linear algebra that the program runs on; names and values as a table."""

from __future__ import annotations

import importlib
import platform
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from solver import VERSION
from solver.errors import not_installed

#: Packages without which `rockslip run` does not work.
NEEDED = ("dolfinx", "petsc4py", "mpi4py", "gmsh", "numpy", "scipy")

#: Python packages whose versions matter.
PACKAGES = (*NEEDED, "pyvista", "matplotlib")

#: Direct solvers that PETSc may have; cholmod factors symmetric matrices only.
DIRECT_SOLVERS = (
    *("petsc", "mumps", "cholmod", "umfpack", "klu"),
    *("superlu", "superlu_dist", "strumpack", "mkl_pardiso"),
)

#: Beginnings of the file names of libraries that do the work of BLAS.
BLAS_LIBRARIES = ("libopenblas", "libblas", "libmkl_rt", "libmkl_core", "libblis", "libatlas")


def versions() -> dict[str, str]:
    """Versions of what a run has used, and of nothing else; for summary.json."""
    found = {"rockslip": VERSION, "python": platform.python_version()}
    for package in ("dolfinx", "gmsh", "numpy", "scipy"):
        if package in sys.modules:
            found[package] = _version(package)
    if "petsc4py.PETSc" in sys.modules:
        found["petsc"] = petsc_version()
    if "mpi4py.MPI" in sys.modules:
        found["mpi"] = mpi_version()
    return found


def description() -> list[tuple[str, str]]:
    """The lines of `rockslip info`, as names and values; called on every rank."""
    missing = [package for package in NEEDED if _version(package) == "missing"]
    if missing:
        raise not_installed(f"{', '.join(missing)} cannot be imported")
    from mpi4py import MPI

    lines = [("rockslip", VERSION), ("python", platform.python_version())]
    lines += [(package, _version(package)) for package in PACKAGES]
    lines += [
        ("petsc", petsc_version()),
        ("mpi", mpi_version()),
        ("ranks", str(MPI.COMM_WORLD.size)),
        ("direct solvers", ", ".join(direct_solvers())),
        ("BLAS", ", ".join(blas_libraries()) or "unknown"),
    ]
    return lines


def _version(package: str) -> str:
    """Version of a Python package, or "missing"."""
    try:
        module = importlib.import_module(package)
    except ImportError:
        return "missing"
    return str(getattr(module, "__version__", "unknown"))


def petsc_version() -> str:
    """Version of PETSc."""
    from petsc4py import PETSc

    return ".".join(str(part) for part in PETSc.Sys.getVersion())


def mpi_version() -> str:
    """Name and version of the MPI library."""
    from mpi4py import MPI

    return str(MPI.Get_library_version()).split(",")[0].split("\n")[0].strip()


def direct_solvers() -> list[str]:
    """Direct solvers that PETSc was built with: those that factor a small matrix."""
    return [name for name in DIRECT_SOLVERS if _factors(name)]


def _factors(name: str) -> bool:
    """True if a solver of that name factors a unit matrix."""
    from mpi4py import MPI
    from petsc4py import PETSc

    matrix = PETSc.Mat().createConstantDiagonal(2, 1.0, comm=MPI.COMM_SELF).convert("aij")
    preconditioner: Any = PETSc.PC().create(MPI.COMM_SELF)
    try:
        preconditioner.setOperators(matrix)
        preconditioner.setType("cholesky" if name == "cholmod" else "lu")
        preconditioner.setFactorSolverType(name)
        preconditioner.setUp()
    except PETSc.Error:
        return False
    finally:
        preconditioner.destroy()
        matrix.destroy()
    return True


def blas_libraries(maps: Path = Path("/proc/self/maps")) -> list[str]:
    """Files of the BLAS libraries that this process has loaded (Linux; elsewhere none)."""
    if not maps.is_file():
        return []
    fields = [line.split(maxsplit=5) for line in maps.read_text().splitlines()]
    loaded = {Path(field[5]) for field in fields if len(field) == 6}
    return sorted(str(file) for file in loaded if file.name.startswith(BLAS_LIBRARIES))


def table(lines: Sequence[tuple[str, str]]) -> str:
    """Names and values in two columns."""
    width = max(len(name) for name, _ in lines) + 2
    return "".join(f"{name:{width}}{value}\n" for name, value in lines)
