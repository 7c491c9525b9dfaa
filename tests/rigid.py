"""Scenes of rigid blocks in the plane and in space."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rockslip import Scene, parse_scene

G = 9.81
PAPER = {"model": "rigid", "width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0}
SQUAT = {"model": "rigid", "width": 1.0, "height": 0.2, "thickness": 1.0, "mass": 500.0}
UPWARDS = {2: [0.0, 1.0], 3: [0.0, 0.0, 1.0]}


def scene(d: int, *blocks: dict[str, Any], end: float, step: float = 1e-3, **tables: Any) -> Scene:
    """Blocks (the paper's without any) in d dimensions; friction 0.7 unless given."""
    content = {
        "dimension": d,
        "block": list(blocks) or [PAPER],
        "contact": {"friction": tables.pop("friction", 0.7)},
        "time": {"end": end, "step": step},
    }
    return parse_scene(content | tables)


def in_space(d: int, place: list[float]) -> list[float]:
    """A place in the plane as one in d dimensions."""
    return [place[0], *[0.0] * (d - 2), place[1]]


def table(folder: Path, rows: Any) -> str:
    """A file of samples for `kind = "table"`: time in s, accelerations in m/s2."""
    file = folder / "ground.csv"
    file.write_text("".join(f"{time!r},{value!r}\n" for time, value in rows))
    return str(file)
