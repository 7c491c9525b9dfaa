"""Compiled functions of meshed bodies; `meshed.pyi` says what each of them does.

The library is loaded when the first of them is needed.
"""

from __future__ import annotations

from typing import Any

from solver.kernels.library import module


def __getattr__(name: str) -> Any:
    """A function of the library; all of them are here afterwards."""
    if name.startswith("__"):
        raise AttributeError(name)
    functions = module("meshed")
    globals().update(
        {key: each for key, each in vars(functions).items() if not key.startswith("_")}
    )
    return getattr(functions, name)
