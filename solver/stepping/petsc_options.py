"""Options for PETSc as they stand on a command line after `--`; read without PETSc."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from solver.errors import SceneError

PREFIX = "rockslip_"
"""Beginning of every option of the nonlinear solver, as in `-rockslip_snes_monitor`."""

SOLVER = ("snes_", "ksp_", "pc_")
"""Beginnings of such options without the prefix, which may be left out."""


def parse_options(words: Sequence[str]) -> dict[str, str | None]:
    """Names of PETSc's options as on a command line, with the prefix, and values; None: no value.

    Raises:
        SceneError: Where a word is neither an option nor the value of one.
    """
    found: dict[str, str | None] = {}
    name = ""
    for word in words:
        if _is_name(word):
            name = word.lstrip("-")
            if name.startswith(SOLVER):
                name = PREFIX + name
            found[name] = None
        elif name and found[name] is None:
            found[name] = word
        else:
            raise SceneError("options after --", word, f"-{PREFIX}NAME [VALUE] ...")
    return found


def command_line(options: Mapping[str, str | None]) -> list[str]:
    """The words of options."""
    pairs = ((f"-{name}", value) for name, value in options.items())
    return [word for pair in pairs for word in pair if word is not None]


def _is_name(word: str) -> bool:
    """True if a word of a command line names an option (and is not a negative number)."""
    return word.startswith("-") and len(word) > 1 and not word[1].isdigit() and word[1] != "."
