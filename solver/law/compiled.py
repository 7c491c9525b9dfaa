"""`@compiled`: functions of plain numbers and arrays, as machine code where numba is installed.

Without numba, or with ROCKSLIP_NO_NUMBA=1 in the environment, they stay what they are and the same
code is interpreted. Machine code is kept between runs, in a folder per version of the sources:
numba itself looks at the file of a function only, not at those of the functions that it calls, and
would run old code after an update. Nothing is ever written into the checkout.

NUMBA_CACHE_DIR says where to keep it; else it is the user's cache folder, and where that cannot be
written, nowhere: each run then compiles anew.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar

from solver.law.switch import is_interpreted

Function = TypeVar("Function", bound=Callable[..., Any])
Arrays = TypeVar("Arrays", bound=tuple[Any, ...])


def _numba() -> ModuleType | None:
    """The compiler, if it is there and wanted."""
    if is_interpreted():
        return None
    try:
        import numba

        import_module("scipy.linalg.cython_blas")  # numba calls the BLAS and LAPACK of scipy
    except ImportError:
        return None
    return numba


NUMBA = _numba()

#: Folders, beside this one's, whose sources make compiled functions that call one another.
_FOLDERS = ("law", "rigid")


def digest(folders: Sequence[Path]) -> str:
    """Digest of all Python sources in some folders and below them."""
    files = sorted(file for folder in folders for file in folder.rglob("*.py"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


@cache
def _sources() -> str:
    """Digest of the sources of all compiled code: machine code may hold the constants of any."""
    root = Path(__file__).parents[1]
    return digest([root / name for name in _FOLDERS])


def _cache_folder() -> Path | None:
    """Where machine code may be kept, or None."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    base = Path(given or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = base / "rockslip" / "compiled"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def is_kept(module: str) -> bool:
    """Whether machine code of a module, by its name, is there from an earlier run."""
    folder = _cache_folder()
    if folder is None:
        return False
    # numba names the subfolder after that of the source and a digest of its path.
    *_, parent, name = module.split(".")
    return any((folder / _sources()).glob(f"{parent}_*/{name}.*.nbi"))


def compiled(function: Function) -> Function:
    """The function, compiled at its first call where numba is installed."""
    if NUMBA is None or not isinstance(function, FunctionType):
        return function
    folder = _cache_folder()
    if folder is None:
        machine: Function = NUMBA.njit(error_model="numpy")(function)
        return machine
    before = NUMBA.config.CACHE_DIR
    NUMBA.config.CACHE_DIR = str(folder / _sources())
    try:
        kept: Function = NUMBA.njit(cache=True, error_model="numpy")(function)
    finally:
        NUMBA.config.CACHE_DIR = before
    return kept


def _borrowing() -> Callable[[Any], Any]:
    """`borrowed` as an intrinsic of numba, or as the identity."""
    if NUMBA is None:
        return lambda arrays: arrays
    from numba.core import cgutils, types
    from numba.extending import intrinsic

    def borrow(context: Any, arrays: Any) -> Any:
        def without_counts(context: Any, builder: Any, kind: Any, value: Any) -> Any:
            if isinstance(kind, types.Array):
                array = context.make_array(kind)(context, builder, value)
                array.meminfo = cgutils.get_null_value(array.meminfo.type)
                return array._getvalue()
            if isinstance(kind, types.BaseTuple):
                items = zip(kind, cgutils.unpack_tuple(builder, value), strict=True)
                return context.make_tuple(
                    builder, kind, [without_counts(context, builder, *item) for item in items]
                )
            return value

        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return without_counts(context, builder, arrays, values[0])

        return arrays(arrays), generate

    return intrinsic(borrow)


_borrowed = _borrowing()


@compiled
def borrowed(arrays: Arrays) -> Arrays:
    """The same named tuple of arrays, whose uses are not counted; for compiled code.

    numba counts the uses of every array of a tuple at every call, atomically: two thirds of the
    time of a step. Python holds the arrays while compiled code runs, so nobody has to count.
    """
    return _borrowed(arrays)
