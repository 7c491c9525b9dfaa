"""The command `rockslip study NAME ...`."""

from __future__ import annotations

import argparse
from types import ModuleType


def studies() -> dict[str, ModuleType]:
    """Name and module of every study.

    A module says what it does in `TEXT`, adds its options in `add_arguments(parser)`, and runs in
    `run(options)`, which returns the exit code; its heavy imports stand inside `run`.
    """
    from solver.study import error_runtime, stability
    from solver.study.damping import command as damping
    from solver.study.horizon import command as horizon
    from solver.study.inertia import command as inertia
    from solver.study.modes import command as modes
    from solver.study.overturning import command as overturning
    from solver.study.suite import command as suite

    return {
        "damping": damping,
        "error-runtime": error_runtime,
        "horizon": horizon,
        "inertia": inertia,
        "modes": modes,
        "overturning": overturning,
        "stability": stability,
        "suite": suite,
    }


def add_studies(parser: argparse.ArgumentParser) -> None:
    """Add a command for each study."""
    names = parser.add_subparsers(dest="study", metavar="NAME", required=True)
    for name, module in studies().items():
        text = module.TEXT
        added = names.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        module.add_arguments(added)
        added.set_defaults(action=module.run)
