"""The library of compiled kernels, which `build.sh` makes ahead of time."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from functools import cache
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from solver import kernels
from solver.errors import EnvironmentTrouble

NAME = "librockslip.so"
"""File of the library in this package, where pip, conda and the image put it."""

MODULE = "kernels"
"""Name of the module in it: `PyInit_kernels` (`module.cpp`)."""

VARIABLE = "ROCKSLIP_KERNELS"
"""Variable that names another file, which goes first; ./in-env sets it."""

SOURCES = ("*.cpp", "*.hpp", "build.sh", "symbols.map")
"""Names of the sources, in the order of their digest."""

REMEDY = "build them by ./in-env rockslip ..., or by pip install anew"


@cache
def library() -> ModuleType:
    """The module that the library is, loaded once in a process.

    Raises:
        EnvironmentTrouble: it is not there, cannot be loaded, or is of other sources.
    """
    file = str(_file())
    spec = spec_from_file_location(MODULE, file, loader=ExtensionFileLoader(MODULE, file))
    assert spec is not None and spec.loader is not None
    try:
        loaded = module_from_spec(spec)
        spec.loader.exec_module(loaded)
    except ImportError as error:
        raise EnvironmentTrouble(f"the compiled kernels cannot be loaded: {error}") from None
    wanted = digest(Path(folder) for folder in kernels.__path__)
    if wanted and loaded.SOURCES != wanted:
        raise EnvironmentTrouble(f"the compiled kernels in {file} are of other sources; {REMEDY}")
    return loaded


def _file() -> Path:
    """The file of the library."""
    named = os.environ.get(VARIABLE)
    if named:
        return Path(named)
    # A package that pip installed in editable form has two folders: sources, and what was built.
    files = [Path(folder) / NAME for folder in kernels.__path__]
    for file in files:
        if file.is_file():
            return file
    raise EnvironmentTrouble(f"the compiled kernels are missing, no {files[0]}; {REMEDY}")


def digest(folders: Iterable[Path]) -> str:
    """Digest of the sources in the first folder that has them, as in `build.sh`; or empty.

    A wheel has no sources.
    """
    for folder in folders:
        files = [file for name in SOURCES for file in sorted(folder.glob(name))]
        if files:
            try:
                content = b"".join(file.read_bytes() for file in files)
            except OSError:  # nothing to compare with
                return ""
            return hashlib.sha256(content).hexdigest()[:16]
    return ""
