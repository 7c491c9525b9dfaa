"""Rocking and sliding of blocks under base motion, by finite elements with frictional contact.

    from rockslip import load_scene, simulate
    result = simulate(load_scene("scene.toml"))

dolfinx and PETSc come in when `simulate` is first touched; reading scenes needs neither. The
names below are the public ones; the packages `solver` and `geometry` are internal.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from solver import VERSION as __version__

if TYPE_CHECKING:
    from solver.errors import RockslipError, SceneError
    from solver.history.history import History
    from solver.reference import housner
    from solver.results.runs import read_run
    from solver.run.simulate import Result, simulate
    from solver.scene import BlockSpec, Scene, load_scene, parse_scene

__all__ = [
    "BlockSpec",
    "History",
    "Result",
    "RockslipError",
    "Scene",
    "SceneError",
    "__version__",
    "housner",
    "load_scene",
    "parse_scene",
    "read_run",
    "simulate",
]

_HOMES = {
    "BlockSpec": "solver.scene",
    "History": "solver.history.history",
    "Result": "solver.run.simulate",
    "RockslipError": "solver.errors",
    "Scene": "solver.scene",
    "SceneError": "solver.errors",
    "load_scene": "solver.scene",
    "parse_scene": "solver.scene",
    "read_run": "solver.results.runs",
    "simulate": "solver.run.simulate",
}


def __getattr__(name: str) -> Any:
    """A public name, from the module that defines it, which is imported when it is first used."""
    if name == "housner":
        return import_module("solver.reference.housner")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """The public names."""
    return list(__all__)


if __name__ == "__main__":
    from solver.cli import main

    raise SystemExit(main())
