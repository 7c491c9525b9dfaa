"""Whether steps of rigid blocks run as machine code: numba, where it is installed, or not."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solver.scene import Scene

#: Set to anything but "" or "0": interpret.
SWITCH = "ROCKSLIP_NO_NUMBA"

#: Steps of one block that take as long interpreted as numba takes to be imported.
SHORT = 1000


def is_interpreted() -> bool:
    """What the environment says."""
    return os.environ.get(SWITCH, "0") not in ("", "0")


def interpret_if_short(scene: Scene) -> None:
    """Let this process interpret, if all it does is one short run and nobody asked otherwise.

    Importing numba takes longer than that, and four times the memory.
    """
    steps = scene.time.end / scene.time.step * len(scene.blocks)
    if scene.is_rigid and scene.dimension == 2 and steps <= SHORT:
        os.environ.setdefault(SWITCH, "1")
