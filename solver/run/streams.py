"""Standard output and error of a command, which may be closed, or full, without ending its work."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from solver.errors import NO_ROOM

FULL: list[int] = []
"""Numbers of the errors with which the standard output took no more because it was full."""


@contextmanager
def guard_streams() -> Iterator[None]:
    """Let a command end in good order whatever becomes of its standard output and error."""
    FULL.clear()
    _open_closed()
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A title may have letters that a terminal does not know; the standard error writes so, too.
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            _write(stream, "")


def say(text: str) -> None:
    """Write to the standard output, or to nowhere once its reader is gone or it is full."""
    _write(sys.stdout, text)


def tell(text: str) -> None:
    """Write to the standard error output, in the same way."""
    _write(sys.stderr, text)


def _write(stream: TextIO, text: str) -> None:
    """Write at once; a stream that takes no more is led to nowhere."""
    try:
        stream.write(text)
        stream.flush()
    except OSError as error:
        if error.errno in NO_ROOM and stream is sys.stdout:
            FULL.append(error.errno)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def _open_closed() -> None:
    """Open closed streams to nowhere: else a file of the run would get their number."""
    number = os.open(os.devnull, os.O_RDWR)
    while number <= 2:
        number = os.dup(number)
    os.close(number)
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)
