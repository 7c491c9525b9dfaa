"""The scenes that the stability study starts from, and how their values are changed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from solver.study.scenes import Changes, Tables

Grid = dict[str, Changes]

BLOCK: Tables = {
    "name": "block",
    "width": 0.25,
    "height": 1.0,
    "thickness": 0.75,
    "density": 2680.0,
    "young": 5.0e10,
    "poisson": 0.2,
    "cells": [4, 10],
}
"""About the paper's granite block."""

SINE = {"kind": "sine", "amplitude_g": 0.5, "period": 0.4}

ROCK: Tables = {
    "block": [{**BLOCK, "tilt_deg": 3.0}],
    "contact": {"friction": 0.7},
    "damping": {"stiffness": 0.0},
    "time": {"end": 0.6, "step": 1e-3},
}
"""Free rocking over two impacts."""

SHAKE: Tables = {
    "block": [BLOCK],
    "contact": {"friction": 0.3},
    "motion": SINE,
    "damping": {"stiffness": 0.0},
    "time": {"end": 0.8, "step": 1e-3},
}
"""Two periods of a shaken ground, on which the block slides and rocks."""

STACK: Tables = {
    "block": [
        {**BLOCK, "name": "lower", "width": 0.5, "height": 0.5, "cells": [5, 5]},
        {**BLOCK, "name": "upper", "on": "lower", "height": 0.5, "cells": [3, 5]},
    ],
    "contact": {"friction": 0.4},
    "motion": {**SINE, "amplitude_g": 0.6},
    "damping": {"stiffness": 0.0},
    "time": {"end": 0.6, "step": 1e-3},
}
"""Two blocks on a shaken ground: the upper one rocks and slides on the lower one."""

SPACE: Tables = {
    "dimension": 3,
    "block": [{**BLOCK, "cells": [3, 3, 6]}],
    "contact": {"friction": 0.5},
    "motion": {**SINE, "second": {**SINE, "amplitude_g": 0.3, "period": 0.3}},
    "damping": {"stiffness": 0.0},
    "time": {"end": 0.3, "step": 1e-3},
}
"""A block in space, shaken along x and y."""

NEIGHBOURS: Tables = {
    "block": [
        {**BLOCK, "name": name, "model": "rigid", "offset": 0.26 * number}
        for number, name in enumerate(("left", "middle", "right"))
    ],
    "contact": {"friction": 0.4},
    "motion": {**SINE, "amplitude_g": 1.0},
    "damping": {"stiffness": 0.0},
    "time": {"end": 0.8, "step": 1e-3},
}
"""Three rigid blocks side by side, 1 cm apart, which rock and strike each other."""

MESHED_NEIGHBOURS: Tables = {
    **NEIGHBOURS,
    "block": [
        {**block, "model": "elastic", "young": 1e9, "poisson": 0.2, "cells": [2, 6]}
        for block in NEIGHBOURS["block"]
    ],
    "time": {"end": 0.3, "step": 5e-4},
}
"""The same of elastic blocks."""

PLATFORM = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}

FALLING = {"static": 0.6, "dynamic": 0.3, "decay": 20.0}
"""Friction that falls with speed, the paper's Eq. (2)."""

SQUAT: Tables = {
    "block": [
        {
            **{"name": "block", "width": 1.0, "height": 0.5, "mass": 1000.0, "cells": [6, 4]},
            **{"young": 5e10, "poisson": 0.2, "friction": FALLING},
        }
    ],
    "foundation": PLATFORM,
    "motion": {"kind": "sine", "amplitude_g": 0.45, "period": 0.6, "cycles": 6},
    "time": {"end": 4.0},
}
"""A squat block that slides on a platform; default steps and damping."""

RIGID: Changes = {"block.model": "rigid"}
DEFAULT_STEPS: Changes = {"time.step": None}
LANDING: Changes = {"block.tilt_deg": 0.0, "block.velocity": [0.0, -1.4]}
"""Dropped flat from 0.1 m."""
ON_ITS_CORNER: Changes = {"block.tilt_deg": 4.0, "block.tilt_direction_deg": 30.0}

IN_SPACE: Changes = {"dimension": 3, "block.cells": None}


def over(path: str, values: Sequence[Any], **also: Any) -> Grid:
    """Changes of one value, by the value."""
    return {_word(value): {path: value, **also} for value in values}


def _word(value: Any) -> str:
    """A value as a label."""
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def steps(*sizes: float, count: int = 400, most: float = 0.6) -> Grid:
    """Step sizes, each for about so many steps, and no longer than the base scene runs."""
    return {
        f"dt {size:g}": {"time.step": size, "time.end": min(most, count * size)} for size in sizes
    }


def sizes(*factors: float) -> Grid:
    """Scene scaled in length, and in time as gravity demands (with the root of the length)."""
    return {
        f"{factor:g} m": {
            "block.width": 0.25 * factor,
            "block.height": factor,
            "block.thickness": 0.75 * factor,
            "time.end": 0.6 * factor**0.5,
            "time.step": 1e-3 * factor**0.5,
        }
        for factor in factors
    }


def slenderness(*ratios: float) -> Grid:
    """H/B at the same area; tilted by half of the slenderness, or little where it is squat."""
    grid: Grid = {}
    for ratio in ratios:
        width = 0.5 / ratio**0.5
        lean = 0.5 * math.degrees(math.atan(1 / ratio))
        grid[f"H/B {ratio:g}"] = {
            "block.width": width,
            "block.height": ratio * width,
            "block.tilt_deg": min(lean, 5.0),
            "block.cells": [max(2, round(4 / ratio**0.5)), max(2, round(4 * ratio**0.5))],
        }
    return grid


def mass_ratios(*ratios: float) -> Grid:
    """Mass of the upper block over that of the lower one."""
    return {
        f"{ratio:g}": {
            "block.density": None,
            "upper.mass": 250.0 * ratio**0.5,
            "lower.mass": 250.0 / ratio**0.5,
        }
        for ratio in ratios
    }


def gaps(*sizes: float) -> Grid:
    """Gap between neighbours, m."""
    return {
        f"{gap:g} m": {"left.offset": -0.25 - gap, "middle.offset": 0.0, "right.offset": 0.25 + gap}
        for gap in sizes
    }


def tower(count: int, **changes: Any) -> Tables:
    """Blocks of one size on each other, each a little off its carrier, on a shaken ground."""
    one = {**BLOCK, "width": 0.5, "height": 0.3, "cells": [4, 3], **changes}
    below = ["foundation", *(f"b{k}" for k in range(1, count))]
    blocks = [
        {**one, "name": f"b{k}", "on": on, "offset": 0.01 * (-1) ** k}
        for k, on in enumerate(below, start=1)
    ]
    return {**SHAKE, "block": blocks, "time": {"end": 0.4, "step": 1e-3}}


BODIES: Grid = {
    "elastic": {},
    "rigid": RIGID,
    "rigid, space": {**RIGID, **IN_SPACE},
}
"""The engines that run a scene of one block: of meshes, of rigid blocks in plane and space."""

LINTEL: Changes = {
    "right.offset": None,
    "right.on": ["left", "middle"],
    "right.width": 0.5,
    "right.height": 0.25,
}
ASIDE: Grid = {
    "plane": {},
    "space": {"dimension": 3, "block.cells": None},
    "leaning": {"left.tilt_deg": 13.0, "left.offset": -0.25, "right.offset": 0.6},
    "lintel": LINTEL,
    "on a platform": {"foundation": PLATFORM},
}
"""Three neighbours in plane and space, of which one falls on the next, or lies on the others."""

PAIRS: Grid = {
    "elastic on elastic": {},
    "rigid on elastic": {"upper.model": "rigid"},
    "elastic on rigid": {"lower.model": "rigid"},
    "rigid on rigid": RIGID,
}

MESHES: Grid = {
    "quadrilateral 1": {},
    "quadrilateral 2": {"block.degree": 2},
    "triangle 1": {"block.cell": "triangle"},
    "triangle 2": {"block.cell": "triangle", "block.degree": 2},
}

PLATE = {
    "kind": "elastic",
    "width": 1.5,
    "height": 0.2,
    "density": 2680.0,
    "young": 5e10,
    "poisson": 0.2,
    "cells": [12, 2],
    "support": "bottom",
}
ROLLERS = {**PLATE, "support": "rollers", "period": 0.5, "damping_ratio": 0.05}
FRAME = {
    "kind": "frame",
    "storey": 2.0,
    "young": 2e11,
    "poisson": 0.3,
    "density": 7850.0,
    "deck": {"width": 1.5, "height": 0.1},
    "column": {"width": 0.05},
}

MODULI = over("block.young", (1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13))
MODELS: Grid = {"elastic": {}, "rigid": RIGID}
STACKED: Grid = {"stack": {"block": STACK["block"]}}
CARRIERS: Grid = {
    "platform": {"foundation": PLATFORM},
    "rollers": {"foundation": ROLLERS},
    "frame": {"foundation": FRAME},
}
