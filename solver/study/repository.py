"""Studies that measure the program itself: they stand in the repository, in `benchmarks/`."""

from __future__ import annotations

import argparse
from importlib import import_module

from solver.errors import Statement


def run_from_repository(study: str, options: argparse.Namespace) -> int:
    """Run `benchmarks.STUDY.run` with the options of the command; returns its exit code.

    Raises:
        SceneError: Only the installed package is there, without `benchmarks/`.
    """
    try:
        module = import_module(f"benchmarks.{study}.run")
    except ModuleNotFoundError as error:
        if not (error.name or "").startswith("benchmarks"):
            raise
        needs = "needs benchmarks/ of rockslip's repository: call ./in-env rockslip there"
        raise Statement(f"study {study.replace('_', '-')}", needs) from None
    code: int = module.run(options)
    return code
