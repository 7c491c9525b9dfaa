"""Where machine code is kept between runs: a folder per version of the sources it is made of."""

from __future__ import annotations

import os
import shutil
import time
from contextlib import suppress
from pathlib import Path

UNUSED = 30 * 24 * 3600.0
"""How long the code of a version that nothing uses is kept, s."""


def cache_folder() -> Path | None:
    """Where machine code may be kept, or None."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    base = Path(given or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = base / "rockslip" / "compiled"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def folder_of(version: str, folder: Path) -> Path:
    """The folder of a version among others, marked as used.

    Where it is new, those that nothing has used for a month are removed: an update of the whole
    program would leave 17 MB for ever, which is what all that its tests call takes.
    """
    own = folder / version
    with suppress(OSError):
        if not own.is_dir():
            remove_unused(folder)
            own.mkdir()
        os.utime(own)
    return own


def remove_unused(folder: Path) -> None:
    """Remove the folders in a folder that were not marked as used for a month."""
    now = time.time()
    for other in folder.iterdir():
        if other.is_dir() and now - other.stat().st_mtime > UNUSED:
            shutil.rmtree(other, ignore_errors=True)
