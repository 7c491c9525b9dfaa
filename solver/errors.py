"""Errors of the program, each with the exit code of the command for it."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
"""Numbers of the system's errors where a disk is full, a quota used up, a file as long as it may
be."""


UNUSABLE = frozenset(
    {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.EISDIR, errno.ENOTDIR, errno.EIO}
)
"""Numbers of the system's errors where a file or folder is not for this user, not there any more,
or no file or folder."""

LONGEST = 200
"""Characters of a message, those of the names of files in it not counted in."""


def in_one_line(text: str) -> str:
    """A message in one line of printable characters, cut where it is too long."""
    plain = "".join(c if c.isprintable() or c in " \t\r\n" else ascii(c)[1:-1] for c in text)
    words = plain.split()
    files = sum(len(word) for word in words if "/" in word and len(word) <= LONGEST)
    line = " ".join(words)
    return line if len(line) <= LONGEST + files else f"{line[: LONGEST + files - 4]} ..."


def of_file(error: OSError, file: Path) -> OSError:
    """The system's error with the file that it is about, which errors of writing do not name."""
    return OSError(error.errno, error.strerror, str(file))


#: The variable with the folders that ./in-env shows to the command, where it does not show all.
VISIBLE = "ROCKSLIP_VISIBLE"


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
        return in_one_line(f"{_short(self.where)}: got {self.got}, allowed {self.allowed}{hint}")


@contextmanager
def below(prefix: str) -> Iterator[None]:
    """Errors of the scene within get their key below the table `prefix`."""
    try:
        yield
    except SceneError as error:
        raise error.under(prefix) from None


class UnknownKey(SceneError):
    """A key that no table of this kind has."""

    def __str__(self) -> str:
        """One line."""
        hint = f", did you mean '{self.nearest}'?" if self.nearest else ","
        return in_one_line(f"{_short(self.where)}: unknown key{hint} allowed {self.allowed}")


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
        return in_one_line(f"{_short(self.where)} {self.allowed}")


def _short(where: str) -> str:
    """A path, the name of a file excepted, in at most 60 characters."""
    return where if len(where) <= 60 or "/" in where else f"{where[:56]} ..."


def missing_key(where: str, what: str) -> Statement:
    """The error of a key that is required and not there; `what` follows "is required"."""
    return Statement(where, f"is required {what}")


def not_applicable(where: str, what: str) -> Statement:
    """The error of a key that means nothing in this scene; `what` follows "applies to"."""
    return Statement(where, f"applies to {what}; remove it")


def hidden_by_in_env(path: Path) -> str:
    """The reason for which ./in-env does not show a path, as the predicate of a sentence.

    Empty where it does. What is written there goes into a layer that ends with the command.
    """
    shown = [Path(folder) for folder in os.environ.get(VISIBLE, "").split(":") if folder]
    places = {Path(os.path.abspath(path)), path.resolve()}
    if not shown or all(any(p.is_relative_to(folder) for folder in shown) for p in places):
        return ""
    place = path.resolve()
    if any(place.is_relative_to(folder) for folder in shown):
        place = Path(os.path.abspath(path))
    parent = place if place.parent == Path("/") else place.parent
    return f"is in no folder that ./in-env shows to the command; set ROCKSLIP_MOUNT={parent}"


class NotConverged(RockslipError):
    """The equations of a step have no solution that was found; what was computed before is kept."""

    exit_code = 3


class EnvironmentTrouble(RockslipError):
    """Something that the run needs is not installed, too old or broken."""

    exit_code = 4


def not_installed(error: ImportError | str) -> EnvironmentTrouble:
    """The error of a package that cannot be imported, or a text about it, with advice."""
    said = " ".join(str(error).split())
    return EnvironmentTrouble(
        f"{said}; the environment is described in docs/install.md, ./in-env rockslip ... has it all"
    )


class OutputTrouble(EnvironmentTrouble):
    """Results cannot be written; those written before stay."""

    @classmethod
    def of(cls, error: OSError, written: str = "") -> OutputTrouble:
        """The system's error in one line; `written` is what is there, such as "up to t = 1 s"."""
        said = (error.strerror or str(error)).lower().removesuffix(" on device")
        file = Path(error.filename).name if error.filename else "output"
        return cls(f"{file}: {said}{', written ' if written else ''}{written}")
