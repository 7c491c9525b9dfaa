"""Machine code and forms of common scenes, as the image brings them.

`python3 -m solver.run.warming [KIND ...]` runs a short scene of each kind, which leaves them in the
caches of the user.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from solver.run.simulate import simulate
from solver.run.streams import say
from solver.scene import parse_scene

BLOCK = {"width": 0.3, "height": 0.9, "thickness": 0.4, "mass": 270.0, "tilt_deg": 0.3}
KINDS: dict[str, dict[str, Any]] = {
    "rigid": {"model": "rigid"},
    "elastic": {"young": 5e10, "poisson": 0.2},
}
CELLS = {2: [3, 6], 3: [2, 2, 4]}
END = 0.08
"""End of the runs, s: after the first impact."""


def scene_of(kind: str, dimension: int) -> dict[str, Any]:
    """The content of a scene of a kind."""
    block = BLOCK | KINDS[kind] | {"cells": CELLS[dimension]}
    return {"dimension": dimension, "block": [block], "time": {"end": END}}


def main(kinds: list[str]) -> None:
    """Run scenes of some kinds, of all without one, in the plane and in space."""
    for kind in kinds or KINDS:
        for dimension in (2, 3):
            with TemporaryDirectory() as folder:  # fields for ParaView have forms of their own
                result = simulate(
                    parse_scene(scene_of(kind, dimension)), folder=Path(folder) / "out"
                )
            say(f"{kind}, {dimension}-D: {result.status}\n")
            if result.status != "completed":
                sys.exit(1)


if __name__ == "__main__":
    main(sys.argv[1:])
