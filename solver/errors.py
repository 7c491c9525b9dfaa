"""Errors of the program, each with the exit code of the command for it."""

from __future__ import annotations

from typing import ClassVar


class RockslipError(Exception):
    """Anything that ends a run with a message instead of a traceback."""

    exit_code: ClassVar[int] = 1


class SceneError(RockslipError):
    """Bad input; its text is one line."""

    exit_code = 2

    def __init__(self, where: str, got: str, allowed: str, nearest: str | None = None) -> None:
        """Say in words what stands at a path, such as `block.poisson`, and what may stand there.

        The path may also be a file; `nearest` is the allowed word that looks most like it.
        """
        # All four in `args`, so that the error survives pickling between ranks.
        super().__init__(where, got, allowed, nearest)
        self.where, self.got, self.allowed, self.nearest = where, got, allowed, nearest

    def under(self, prefix: str) -> SceneError:
        """This error with its key below the table `prefix`."""
        where = f"{prefix}.{self.where}" if prefix else self.where
        return type(self)(where, self.got, self.allowed, self.nearest)

    def __str__(self) -> str:
        """One line."""
        hint = f", did you mean '{self.nearest}'?" if self.nearest else ""
        return " ".join(f"{self.where}: got {self.got}, allowed {self.allowed}{hint}".split())


class UnknownKey(SceneError):
    """A key that no table of this kind has."""

    def __str__(self) -> str:
        """One line."""
        hint = f", did you mean '{self.nearest}'?" if self.nearest else ","
        return f"{self.where}: unknown key{hint} allowed {self.allowed}"


class Statement(SceneError):
    """Bad input that is best said in a sentence of its own: a key, and what is wrong with it."""

    def __init__(self, where: str, predicate: str) -> None:
        """Say what is wrong: the subject of the sentence, a path of a key, and the rest of it."""
        super().__init__(where, "", predicate)
        self.args = (where, predicate)

    def under(self, prefix: str) -> Statement:
        """This error with its key below the table `prefix`."""
        return Statement(f"{prefix}.{self.where}" if prefix else self.where, self.allowed)

    def __str__(self) -> str:
        """One line."""
        return " ".join(f"{self.where} {self.allowed}".split())


def missing_key(where: str, what: str) -> Statement:
    """The error of a key that is required and not there; `what` follows "is required"."""
    return Statement(where, f"is required {what}")


def not_applicable(where: str, what: str) -> Statement:
    """The error of a key that means nothing in this scene; `what` follows "applies to"."""
    return Statement(where, f"applies to {what}; remove it")


class NotConverged(RockslipError):
    """The equations of a step have no solution that was found; what was computed before is kept."""

    exit_code = 3


class EnvironmentTrouble(RockslipError):
    """Something that the run needs is not installed, too old or broken."""

    exit_code = 4
