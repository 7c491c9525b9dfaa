"""The X server that VTK draws through where it is built for one."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from solver.errors import EnvironmentTrouble


@contextmanager
def screen() -> Iterator[None]:
    """Have a screen to draw on: that of the user, or one of our own for as long as it lasts."""
    if os.environ.get("DISPLAY") or not _needs_x():
        yield
        return
    program = shutil.which("Xvfb")
    if program is None:
        raise EnvironmentTrouble("VTK draws through an X server here: install xvfb or set DISPLAY")
    server, number = _start(program)
    os.environ["DISPLAY"] = f":{number}"
    try:
        yield
    finally:
        del os.environ["DISPLAY"]
        server.terminate()
        server.wait()


def _needs_x() -> bool:
    """Whether VTK's windows are those of X."""
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (it says which windows there are)
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    return str(vtkRenderWindow().GetClassName()).startswith("vtkX")


def _start(program: str) -> tuple[subprocess.Popen[bytes], int]:
    """Start a server on a display that is free, which it tells; returns it and the number."""
    answer, told = os.pipe()
    words = [program, "-displayfd", str(told), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"]
    silent = subprocess.DEVNULL
    # A session of its own: Ctrl-C ends the film, and the film ends the server.
    server = subprocess.Popen(
        words, pass_fds=[told], stdout=silent, stderr=silent, start_new_session=True
    )
    os.close(told)
    with os.fdopen(answer) as stream:
        number = stream.readline().strip()
    if not number:
        server.wait()
        raise EnvironmentTrouble("Xvfb did not start")
    return server, int(number)
