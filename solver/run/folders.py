"""Folders that commands write into: made, or refused where that would write over something."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from solver.errors import SceneError, Statement, hidden_by_in_env

#: Pictures that are drawn of runs.
PICTURES = (
    *("angle", "phase", "platform", "floors", "forces", "energy", "motion", "deformed"),
    "overlay",
)

#: Name of the page about a run or a study.
REPORT = "report.html"

#: What a run or its pictures leave in a folder; a new run with --force removes these, nothing else.
LEFT_BEHIND = (
    "history.csv",
    "events.csv",
    "pairs.csv",
    "summary.json",
    *("summary.json.part", "scene.toml.part", f"{REPORT}.part", "film.part.mp4", "film.part.gif"),
    "floor_spectra.csv",
    "checkpoint.npz",
    "checkpoint.npz.part",
    "run.log",
    "film.mp4",
    "film.gif",
    REPORT,
    "open_in_paraview.py",
    "fields.vtkhdf",
    "fields*.pvd",
    "fields*.pvtu",
    "fields*.vtu",
    *("fields/fields_*.pvd", "fields/fields_*.pvtu", "fields/fields_*.vtu"),
    *(f"{name}.{ending}" for name in PICTURES for ending in ("png", "pdf", "svg")),
)


def claim_folder(folder: Path, scene: Path, force: bool) -> None:
    """Make the folder of a run, or refuse to write over what is there."""
    refuse_hidden(folder)
    target = folder / "scene.toml"
    with unusable_is_refused(folder):
        if folder.is_dir():
            hold_folder(folder)
        if target.exists() and scene.exists() and target.samefile(scene):
            raise SceneError("-o", f"{folder}, which holds the scene itself", "another folder")
        make_folder(folder, force=force)
        hold_folder(folder)
        _clear(folder)
        target.unlink(missing_ok=True)  # the run writes its own


def renew_folder(folder: Path) -> None:
    """Make the folder of a run that Python starts, without what an earlier run has left there.

    Raises:
        SceneError: It holds a scene that no run has left, or nothing can be written there.
    """
    with unusable_is_refused(folder):
        by_run = any((folder / name).exists() for name in ("run.log", "summary.json"))
        if not by_run and (folder / "scene.toml").exists():
            raise SceneError("folder", f"{folder}, which holds a scene of its own", "another one")
        open_folder(folder)
        hold_folder(folder)
        if by_run:
            _clear(folder)


def _clear(folder: Path) -> None:
    """Remove what an earlier run has left but for its scene, which is written over."""
    for pattern in LEFT_BEHIND:
        for file in folder.glob(pattern):
            file.unlink()
    with suppress(OSError):  # of others where it is not empty, or not there
        (folder / "fields").rmdir()


def make_folder(folder: Path, *, force: bool, allowed: str = "an empty folder, or --force") -> bool:
    """Make a folder where there is none; returns whether one with something in it is taken.

    With `force`; else it is refused, with these words on what is allowed.
    """
    open_folder(folder)
    with unusable_is_refused(folder):
        used = any(folder.iterdir())
    if used and not force:
        raise SceneError("-o", f"{folder}, which is not empty", allowed)
    return used


def open_folder(folder: Path) -> None:
    """Make a folder where there is none, whatever is in it."""
    refuse_hidden(folder)
    with unusable_is_refused(folder):
        folder.mkdir(parents=True, exist_ok=True)
    refuse_unwritable(folder)


def refuse_unwritable(folder: Path) -> None:
    """Refuse a folder that is not there, or into which nothing can be written."""
    refuse_hidden(folder)
    with unusable_is_refused(folder):
        if not folder.is_dir():
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


_held: dict[tuple[int, int], int] = {}
"""Descriptors of the folders that this process keeps others from writing into, by their inodes."""


def hold_folder(folder: Path) -> None:
    """Keep other processes from writing into a folder, until it is released or this one ends.

    A lock of the folder itself, which leaves no file; file systems without such locks have none.
    """
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    try:
        number = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return  # the error is reported where a file is written
    state = os.fstat(number)
    inode = (state.st_dev, state.st_ino)
    if inode in _held:
        os.close(number)
        return
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(number)
        raise SceneError(
            "-o", f"{folder}, which another run is writing", "another folder, or after its end"
        ) from None
    except OSError:
        os.close(number)
        return
    _held[inode] = number


def release_folder(folder: Path) -> None:
    """Let other processes write into a folder again."""
    with suppress(OSError):
        state = folder.stat()
        number = _held.pop((state.st_dev, state.st_ino), None)
        if number is not None:
            os.close(number)


def release_folders() -> None:
    """Let other processes write into all folders again."""
    while _held:
        os.close(_held.popitem()[1])


def refuse_hidden(folder: Path) -> None:
    """Refuse a folder that ./in-env does not show to this process: nothing would be left of it."""
    hidden = hidden_by_in_env(folder)
    if hidden:
        raise Statement("-o", f"{folder} {hidden}")


@contextmanager
def unusable_is_refused(folder: Path) -> Iterator[None]:
    """Refuse a folder where the system lets nothing be written."""
    try:
        yield
    except OSError as error:
        reason = (error.strerror or "unusable").lower()
        raise SceneError("-o", f"{folder} ({reason})", "a folder that can be written") from error
