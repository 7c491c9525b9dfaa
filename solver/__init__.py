"""Rocking and sliding of blocks under base motion, by finite elements with frictional contact.

    from solver import load_scene, simulate
    result = simulate(load_scene("scene.toml"))

dolfinx and PETSc come in when `simulate` is first touched; reading scenes needs neither.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solver.scene import load_scene
    from solver.simulate import simulate

__all__ = ["load_scene", "simulate"]

_HOMES = {"load_scene": "solver.scene", "simulate": "solver.simulate"}


def __getattr__(name: str) -> Any:
    """What this package offers, from its home, which is imported when it is first asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


class _Package(ModuleType):
    """This package; here the name `simulate` means the function, whatever was imported before."""

    def __setattr__(self, name: str, value: Any) -> None:
        """Importing the submodule `simulate` would put the module in the function's place."""
        if not (name == "simulate" and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
