"""Options for PETSc as they stand on a command line after `--`; read without PETSc."""

from __future__ import annotations

from collections.abc import Sequence

from solver.errors import SceneError

PREFIX = "rockslip_"
"""Beginning of every option of the nonlinear solver, as in `-rockslip_snes_monitor`."""


def parse_options(words: Sequence[str]) -> dict[str, str | None]:
    """Names and values of PETSc options as on a command line.

    Raises:
        SceneError: Where a word is neither an option of this program nor the value of one.
    """
    found: dict[str, str | None] = {}
    name = ""
    for word in words:
        if _is_name(word):
            if not word.startswith(f"-{PREFIX}"):
                raise SceneError("options after --", word, f"names that start with -{PREFIX}")
            name = word
            found[name] = None
        elif name and found[name] is None:
            found[name] = word
        else:
            raise SceneError("options after --", word, f"-{PREFIX}NAME [VALUE] ...")
    return found


def _is_name(word: str) -> bool:
    """Whether a word of a command line names an option (and is not a negative number)."""
    return word.startswith("-") and len(word) > 1 and not word[1].isdigit() and word[1] != "."
