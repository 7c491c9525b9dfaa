"""Folders that commands write into: made, or refused where that would write over something."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from solver.errors import SceneError, Statement
from solver.launcher import hidden_by_in_env

#: What a run or its pictures leave in a folder; a new run with --force removes these, nothing else.
LEFT_BEHIND = (
    "history.csv",
    "summary.json",
    "run.log",
    "open_in_paraview.py",
    "fields*.pvd",
    "fields*.pvtu",
    "fields*.vtu",
    *(
        f"{name}.png"
        for name in ("angle", "phase", "forces", "energy", "deformed", "overlay", "platform")
    ),
)


def claim_folder(folder: Path, scene: Path, force: bool) -> None:
    """Make the folder of a run, or refuse to write over what is there."""
    refuse_hidden(folder)
    target = folder / "scene.toml"
    with unusable_is_refused(folder):
        if target.exists() and target.samefile(scene):
            raise SceneError("-o", f"{folder}, which holds the scene itself", "another folder")
        make_folder(folder, force=force)
        for pattern in LEFT_BEHIND:
            for file in folder.glob(pattern):
                file.unlink()


def make_folder(folder: Path, *, force: bool, allowed: str = "an empty folder, or --force") -> bool:
    """Make a folder where there is none; returns whether one with something in it is taken.

    With `force`; else it is refused, with these words on what is allowed.
    """
    refuse_hidden(folder)
    with unusable_is_refused(folder):
        folder.mkdir(parents=True, exist_ok=True)
        used = any(folder.iterdir())
    if used and not force:
        raise SceneError("-o", f"{folder}, which is in use", allowed)
    return used


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
