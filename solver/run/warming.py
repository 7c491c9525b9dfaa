"""Compile what scenes need, as the image does: `python3 -m solver.run.warming [KIND ...]`.

Short runs of one scene of each kind leave machine code and forms in the caches of the user.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from solver.run.simulate import simulate
from solver.run.streams import say
from solver.scene import parse_scene

STONE = {"young": 5e10, "poisson": 0.2}
BLOCK = {"width": 0.3, "height": 0.9, "thickness": 0.4, "mass": 270.0, "tilt_deg": 0.3}
TOP = {"name": "top", "on": "block", "width": 0.2, "height": 0.2, "thickness": 0.4, "mass": 30.0}
PLATE = {"kind": "elastic", "width": 2.4, "height": 0.3, "mass_ratio": 2.0, **STONE}
SWAYING = {"support": "rollers", "period": 0.5}
FRAME = {
    "kind": "frame",
    "deck": {"width": 2.4, "height": 0.3},
    "column": {"width": 0.2},
    "storey": 2.5,
    "density": 2500.0,
    **STONE,
}
STOREYS = {
    "storey": [{"height": 1.5}, {"height": 1.0, "extra_mass": 1000.0}],
    "feet": {"vertical": 1e9},
    "damping_ratio": 0.02,
}
OSCILLATOR = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5}

CELLS: dict[int, dict[str, Any]] = {2: {"cells": [3, 6]}, 3: {"cells": [2, 2, 4]}}
DECK_CELLS = {"bay": 4, "column": 1, "deck": 1, "storey": 3}

RIGID_END = 1.2
"""End of runs of rigid blocks, s: shorter ones might be interpreted."""
END = 0.08
"""End of all others, s: after the first impact."""


def scenes(dimension: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Names and contents of scenes, one of each kind."""
    space = dimension == 3
    deck: dict[str, Any] = {"thickness": 1.0} if space else {}
    plate = PLATE | deck | {"cells": [6, 4, 1] if space else [12, 2]}
    frame = FRAME | {"deck": FRAME["deck"] | deck, "cells": DECK_CELLS}  # type: ignore[operator]
    rigid, elastic = BLOCK | {"model": "rigid"}, BLOCK | STONE | CELLS[dimension]
    stack = [elastic, TOP | STONE | CELLS[dimension]]
    shaken = {"kind": "half_sine", "amplitude_g": 0.3, "duration": 0.2}
    bed = {"friction": 0.6, "damping": 0.3}
    decays = {"friction": {"static": 0.6, "dynamic": 0.5, "decay": 1.0}}
    where = {"dimension": dimension}
    yield "rigid", where | {"block": [rigid], "time": {"end": RIGID_END, "step": 1e-3}}
    for name, blocks, tables in (
        ("elastic", [elastic], {}),
        ("elastic, quadratic", [elastic | {"degree": 2}], {}),
        ("elastic under a motion", [elastic], {"motion": shaken, "contact": decays}),
        ("on a bed", [elastic], {"contact": bed}),
        ("in steps of 1 ms", [elastic], {"time": {"end": END, "step": 1e-3}}),
        ("on an oscillator", [elastic], {"foundation": OSCILLATOR}),
        ("on a plate", [elastic], {"foundation": plate | {"support": "bottom"}}),
        ("on a plate that is held", [elastic], {"foundation": plate}),
        ("on a plate on rollers", [elastic], {"foundation": plate | SWAYING}),
        ("on a frame", [elastic], {"foundation": frame}),
        ("on a frame of storeys", [elastic], {"foundation": frame | STOREYS}),
        ("rigid on a frame", [rigid], {"foundation": frame}),
        ("a stack", stack, {}),
    ):
        rest: Any = tables
        yield name, where | {"block": blocks, "time": {"end": END}} | rest


def main(kinds: Sequence[str]) -> None:
    """Run the scenes of these names; all without one. What each costs shows what it compiles."""
    names = {name for name, _ in scenes(2)}
    if unknown := set(kinds) - names:
        sys.exit(f"got {', '.join(sorted(unknown))}, allowed {', '.join(sorted(names))}")
    for dimension in (2, 3):
        for name, content in scenes(dimension):
            if kinds and name not in kinds:
                continue
            began = time.process_time()
            with TemporaryDirectory() as folder:  # fields for ParaView have forms of their own
                result = simulate(parse_scene(content), folder=Path(folder) / "out", many=True)
            cost = time.process_time() - began
            say(f"{dimension}-D {name}: {result.status}, {cost:.0f} s of processor time\n")
            if result.status != "completed":
                sys.exit(1)


if __name__ == "__main__":
    main(sys.argv[1:])
