"""Compiled functions of meshed bodies; `meshed.pyi` says what each of them does.

The library is loaded when the first of them is needed.
"""

from __future__ import annotations

from typing import Any

from solver.kernels.library import library


def __getattr__(name: str) -> Any:
    """A function of the library, which is here afterwards."""
    if name.startswith("__"):
        raise AttributeError(name)
    found = globals()[name] = getattr(library(), name)
    return found
