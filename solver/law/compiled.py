"""`@compiled`: functions of plain numbers and arrays, as machine code where numba is installed.

Without numba, or with ROCKSLIP_NO_NUMBA=1 in the environment, they stay what they are and the same
code is interpreted, as it is in runs that are over before numba is imported (`solver.law.switch`).
Machine code is kept between runs, in a folder per version of a file and of all files that it
imports (`solver.law.sources`): numba itself looks at the file of a function only, not at those of
the functions that it calls, and would run old code after an update. Nothing is ever written into
the checkout.

NUMBA_CACHE_DIR says where to keep it; else it is the user's cache folder, and where that cannot be
written, nowhere: each run then compiles anew (`solver.law.kept_code`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, update_wrapper
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from operator import attrgetter
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast

from solver.law.kept_code import cache_folder, folder_of
from solver.law.late_linking import linked_late, part_of_others
from solver.law.sources import version_of
from solver.law.switch import CHOICE, is_interpreted

Function = TypeVar("Function", bound=Callable[..., Any])


def _numba() -> ModuleSpec | None:
    """Where the compiler is, if it is installed and wanted; it is not imported yet."""
    return None if is_interpreted() else find_spec("numba")


NUMBA = _numba()


@cache
def _compiler() -> ModuleType | None:
    """The compiler, imported; None where that fails."""
    try:
        import numba

        import_module("scipy.linalg.cython_blas")  # numba calls the BLAS and LAPACK of scipy
    except ImportError:
        return None
    return numba


def runs_machine_code() -> bool:
    """Whether compiled functions run as machine code now: see `solver.law.switch`."""
    return NUMBA is not None and not CHOICE.interprets


class _Compiled:
    """A function that is compiled at its first call, or interpreted where a run chose so.

    Compiled functions that call it see the machine code: numba asks what an object is by
    `_numba_type_`.
    """

    def __init__(self, function: FunctionType):
        """Remember the function; numba is not imported yet."""
        self.py_func = function
        update_wrapper(self, function)
        self.choose_again()
        CHOICE.followers.add(self)

    def choose_again(self) -> None:
        """Ask at the next call whether to interpret or to run machine code."""
        self._runs: Callable[..., Any] = self._first

    def _first(self, *arguments: Any, **named: Any) -> Any:
        """Call it for the first time since that was chosen."""
        self._runs = self.py_func if CHOICE.interprets else self._machine
        return self._runs(*arguments, **named)

    __call__ = property(attrgetter("_runs"))
    """Calls it, without a frame of Python's own: that took a third of the time of a small call."""

    @cached_property
    def _machine(self) -> Any:
        """The machine code for Python; the function itself where numba cannot be imported."""
        numba, folder = _compiler(), cache_folder()
        if numba is None:
            return self.py_func
        if folder is None:
            return linked_late(numba.njit(error_model="numpy")(self.py_func), kept=False)
        before = numba.config.CACHE_DIR
        version = version_of(Path(self.py_func.__code__.co_filename))
        numba.config.CACHE_DIR = str(folder_of(version, folder))
        try:
            return linked_late(numba.njit(cache=True, error_model="numpy")(self.py_func), kept=True)
        finally:
            numba.config.CACHE_DIR = before

    @cached_property
    def _part(self) -> Any:
        """The code for other compiled functions, which becomes a part of theirs."""
        return part_of_others(self.py_func)

    @property
    def _numba_type_(self) -> Any:
        """What the machine code is to numba."""
        return self._part._numba_type_


def compiled(function: Function) -> Function:
    """The function, compiled at its first call where numba is installed and wanted."""
    if NUMBA is None or not isinstance(function, FunctionType):
        return function
    lazy: Any = _Compiled(function)
    return cast("Function", lazy)
