"""Compiled forms of common scenes with meshes, as the image brings them.

`python3 -m solver.run.warming` runs a short scene in the plane and in space, which leaves them in
the cache of the user.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from solver.run.simulate import simulate
from solver.run.streams import say
from solver.scene import parse_scene

BLOCK: dict[str, Any] = {
    **{"width": 0.3, "height": 0.9, "thickness": 0.4, "mass": 270.0, "tilt_deg": 0.3},
    **{"young": 5e10, "poisson": 0.2},
}
CELLS = {2: [3, 6], 3: [2, 2, 4]}
END = 0.08
"""End of the runs, s: after the first impact."""


def main() -> None:
    """Run a scene in the plane and one in space."""
    for dimension, cells in CELLS.items():
        block = BLOCK | {"cells": cells}
        scene = parse_scene({"dimension": dimension, "block": [block], "time": {"end": END}})
        with TemporaryDirectory() as folder:  # fields for ParaView have forms of their own
            result = simulate(scene, folder=Path(folder) / "out")
        say(f"{dimension}-D: {result.status}\n")
        if result.status != "completed":
            sys.exit(1)


if __name__ == "__main__":
    main()
