"""`@compiled`: functions of plain numbers and arrays, as machine code where numba is installed.

Without numba, or with ROCKSLIP_NO_NUMBA=1 in the environment, they stay what they are and the same
code is interpreted.

numba keeps machine code between runs, in a folder for each version of a package and of all that it
may import from: numba itself checks the file of a function only, not those of the functions
that it calls, and would run old code after an update. NUMBA_CACHE_DIR says where these folders are;
else they are in the user's cache folder, and where that cannot be written, nowhere: each run then
compiles anew.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, cached_property, update_wrapper
from importlib import import_module
from importlib.util import find_spec
from operator import attrgetter
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, Protocol, TypeVar, cast

from solver.law.late_linking import late_linking

Function = TypeVar("Function", bound=Callable[..., Any])

SWITCH = "ROCKSLIP_NO_NUMBA"
"""Environment variable; set to anything but "" or "0": interpret."""

COMPILING = "compiling, once, up to a minute: kept for later runs"
COMPILING_IN_VAIN = "compiling, up to a minute: nothing can be kept in the user's cache folder"
"""Texts on the display while functions are compiled."""

ROOT = Path(__file__).parents[2]
"""Folder of the packages."""

PACKAGES = (
    *("scene", "excitation", "kernels", "law", "scheme", "history", "bodies", "contact"),
    *("stepping", "rigid", "build", "fields", "results", "reference", "run"),
)
"""In the order of docs/architecture.md: each imports only from those before it, so that its machine
code holds nothing of those behind it. Code of other packages is not kept."""

UNUSED = 30 * 24 * 3600.0
"""Age up to which the code of a version that nothing uses is kept, s."""


def is_interpreted() -> bool:
    """True if the environment has compiled functions interpreted."""
    return os.environ.get(SWITCH, "0") not in ("", "0")


NUMBA = None if is_interpreted() else find_spec("numba")
"""Import spec of the compiler, if it is installed and wanted; it is not imported yet."""


@cache
def _compiler() -> ModuleType | None:
    """The compiler, imported; None where that fails."""
    try:
        import numba

        import_module("scipy.linalg.cython_blas")  # numba calls the BLAS and LAPACK of scipy
    except ImportError:
        return None
    return numba


class _Compiled:
    """A function that is compiled at its first call.

    Compiled functions that call it see the machine code: numba reads the type of an object
    from `_numba_type_`.
    """

    def __init__(self, function: FunctionType):
        """Remember the function; numba is not imported yet."""
        self.py_func = function
        update_wrapper(self, function)

    __call__ = property(attrgetter("_machine"))
    """Calls it, without a frame of Python's own: that took a third of the time of a small call."""

    @cached_property
    def _machine(self) -> Any:
        """The machine code for Python; the function itself where numba cannot be imported."""
        numba, folder = _compiler(), _folder_of(self.py_func)
        if numba is None:
            return self.py_func
        if folder is None:
            machine = numba.njit(error_model="numpy")(self.py_func)
        else:
            before, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(folder)
            try:
                machine = numba.njit(cache=True, error_model="numpy")(self.py_func)
            finally:
                numba.config.CACHE_DIR = before
        usual = machine.compile

        def compile_late(signature: Any) -> Any:
            with late_linking(), _watched(kept=folder is not None):
                return usual(signature)

        machine.compile = compile_late
        return machine

    @cached_property
    def _part(self) -> Any:
        """The code for other compiled functions, which becomes a part of theirs."""
        from numba import njit

        no_wrappers = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        return njit(error_model="numpy", **no_wrappers)(self.py_func)

    @property
    def _numba_type_(self) -> Any:
        """Type of the machine code in numba."""
        return self._part._numba_type_


def compiled(function: Function) -> Function:
    """The function, compiled at its first call where numba is installed and wanted."""
    if NUMBA is None or not isinstance(function, FunctionType):
        return function
    lazy: Any = _Compiled(function)
    return cast("Function", lazy)


def digest(paths: Iterable[Path]) -> str:
    """Digest of Python files, and of those in folders and below them."""
    found = ([path] if path.suffix else path.rglob("*.py") for path in paths)
    files = sorted(file for each in found for file in each)
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


def sources_below(package: str) -> list[Path]:
    """All that the machine code of a package can hold: itself, and what it may import from."""
    solver, count = ROOT / "solver", PACKAGES.index(package) + 1
    packages = [solver / name for name in PACKAGES[:count]]
    return [ROOT / "geometry", *solver.glob("*.py"), *packages]


def _folder_of(function: FunctionType) -> Path | None:
    """The folder in which the machine code of a function is kept; None: it is not."""
    file = Path(function.__code__.co_filename)
    parts = file.relative_to(ROOT).parts if file.is_relative_to(ROOT) else ()
    if parts[:1] != ("solver",) or parts[1] not in PACKAGES:
        return None
    given = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    home = Path(given or Path.home() / ".cache") / "rockslip" / "compiled"
    return _folder_of_version(home, parts[1])


@cache
def _folder_of_version(home: Path, package: str) -> Path | None:
    """The folder of this version of a package, marked as used; None where none can be made.

    Where it is new, those that nothing has used for a month are removed.
    """
    own = home / digest(sources_below(package))
    try:
        is_new = not own.is_dir()
        own.mkdir(parents=True, exist_ok=True)
        os.utime(own)
    except OSError:
        return None
    if is_new:
        for other in home.iterdir():
            with suppress(OSError):
                if time.time() - other.stat().st_mtime > UNUSED:
                    shutil.rmtree(other, ignore_errors=True)
    return own if os.access(own, os.W_OK) else None


class Watcher(Protocol):
    """A display that is to stand still while functions are compiled or read back."""

    def pause(self, why: str) -> None:
        """It begins; `why` is empty where machine code is read back."""

    def go_on(self, seconds: float) -> None:
        """It is over, and took some seconds."""


_WATCHERS: list[Watcher] = []


@contextmanager
def watching(watcher: Watcher) -> Iterator[None]:
    """Let a watcher know of what is compiled or read back within this block."""
    _WATCHERS.append(watcher)
    try:
        yield
    finally:
        _WATCHERS.remove(watcher)


@contextmanager
def _watched(*, kept: bool) -> Iterator[None]:
    """Let the watchers pause, and say why as soon as numba begins to compile."""
    from numba.core import event

    began, words = time.perf_counter(), COMPILING if kept else COMPILING_IN_VAIN

    class Listener(event.Listener):  # type: ignore[misc]
        said = False

        def on_start(self, event: Any) -> None:
            if not self.said:
                self.said = True
                for watcher in _WATCHERS:
                    watcher.pause(words)

        def on_end(self, event: Any) -> None:
            """Nothing: watchers go on at the end of the block."""

    for watcher in _WATCHERS:
        watcher.pause("")
    try:
        with event.install_listener("numba:compile", Listener()):
            yield
    finally:
        for watcher in _WATCHERS:
            watcher.go_on(time.perf_counter() - began)
