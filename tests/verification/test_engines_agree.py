"""The same scene through every engine that can run it: rigid in the plane and in space, meshed.

The meshed engine runs rigid blocks where anything in the scene is meshed: a plate that is held
altogether, which is as rigid as the ground, or a stiff block far from the others.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from rockslip import History, parse_scene, simulate
from solver.history.table import TABLE, Column

PLATE = {"kind": "elastic", "width": 4.0, "height": 0.2, "density": 2400.0}
"""The ground of the meshed engine, fully restrained: its mesh has no use."""

MESH = {"young": 1e11, "poisson": 0.2, "cells": [2, 1]}

PUSH = {"kind": "half_sine", "amplitude_g": 0.45, "duration": 0.3}

LAWS: dict[str, Any] = {
    "plain": 0.3,
    "static and dynamic": {"static": 0.35, "dynamic": 0.25},
    "decay": {"static": 0.35, "dynamic": 0.25, "decay": 5.0},
    "cohesion": {"static": 0.2, "cohesion": 1000.0},
    "lost cohesion": {"static": 0.2, "cohesion": 1000.0, "cohesion_lost": True},
}


def block(name: str, width: float, height: float, **more: Any) -> dict[str, Any]:
    """A rigid block of stone."""
    size = {"width": width, "height": height, "thickness": 0.5, "density": 2400.0}
    return {"name": name, "model": "rigid"} | size | more


def rocking(law: Any) -> dict[str, Any]:
    """A slender block that rocks freely, once over its base; it does not slide."""
    return {
        "block": [block("a", 0.25, 1.0, tilt_deg=3.0, friction=0.7)],
        "contact": {"friction": law},
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.35, "step": 1e-3},
    }


def rebounding(law: Any) -> dict[str, Any]:
    """The same with a restitution, and a block beside it that is thrown up and lands flat."""
    tables = rocking(law)
    tables["block"][0] |= {"restitution": 0.95}
    tables["block"].append(block("b", 0.4, 0.3, offset=2.0, restitution=0.6))
    return tables | {"time": {"end": 0.7, "step": 1e-3}}


def sliding(law: Any) -> dict[str, Any]:
    """A flat block under half a period of a sine."""
    return {
        "block": [block("a", 0.4, 0.3)],
        "contact": {"friction": law},
        "motion": PUSH,
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.5, "step": 1e-3},
    }


def on_an_oscillator(law: Any) -> dict[str, Any]:
    """A flat block on a platform, far from it a light one that sticks."""
    platform = {"kind": "oscillator", "mass_ratio": 1.0, "period": 0.4, "damping_ratio": 0.05}
    return {
        "block": [
            block("a", 0.4, 0.3),
            block("b", 0.2, 0.1, offset=2.0, friction=5.0, density=2.4),
        ],
        "contact": {"friction": law},
        "foundation": platform,
        "motion": PUSH,
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.5, "step": 1e-3},
    }


def stack(law: Any) -> dict[str, Any]:
    """Two blocks that slide on each other and on the ground."""
    return {
        "block": [block("a", 0.6, 0.4), block("b", 0.4, 0.3, on="a", friction=0.2)],
        "contact": {"friction": law},
        "motion": PUSH,
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.5, "step": 1e-3},
    }


SCENES = {
    "rocking": rocking,
    "rebounding": rebounding,
    "sliding": sliding,
    "oscillator": on_an_oscillator,
    "stack": stack,
}

TOLERANCE = {
    ("space", "rocking"): 1e-3,
    ("space", "rebounding"): 1e-4,
    ("space", "sliding"): 2e-5,
    ("space", "oscillator"): 1e-4,
    ("space", "stack"): 1e-5,
    ("meshed", "rocking"): 2e-2,
    ("meshed", "sliding"): 1e-5,
    ("meshed", "oscillator"): 1e-3,
    ("meshed", "stack"): 1e-5,
}
"""Largest difference from the plane, over the scales below.

The meshed engine does not divide its steps at impacts, so the time of one, in a block that rocks,
is known to a step. Its stiff block on the oscillator is not quite rigid.
"""

EARLY_SLIP = {
    ("meshed", "static and dynamic"): 0.1,
    ("meshed", "lost cohesion"): 0.1,
    ("space", "lost cohesion"): 1e-2,
}
"""The same where resistance falls at once.

The point that slips first takes part of it away before the block moves as a whole: when that is
depends on when an engine takes a point to slip, and on how points share the force before.
"""

SCALES = {"m": 0.1, "m/s": 1.0, "rad": 0.1, "rad/s": 1.0, "m/s²": 1.0}
"""Displacements and speeds of these scenes; forces are measured by the weight, energies by
the largest that is taken in, dissipated or in motion."""

AT_CHANGES = 0.05
"""Part of the rows in which forces may differ by more: the time of a change of contact is known to
a step, and its row has the mean of what is before and after."""

CASES = [
    *((engine, "sliding", law) for engine in ("space", "meshed") for law in LAWS),
    *(
        (engine, name, "plain")
        for engine in ("space", "meshed")
        for name in SCENES
        if name != "sliding" and (engine, name) != ("meshed", "rebounding")
    ),
]


@cache
def history(engine: str, name: str, law: str) -> History:
    """The history of a scene in an engine."""
    tables = SCENES[name](LAWS[law])
    if name == "rebounding":
        up = [0.0, 1.0] if engine == "plane" else [0.0, 0.0, 1.0]
        tables["block"][1] |= {"velocity": up}
    if engine == "space":
        tables["dimension"] = 3
    elif engine == "meshed" and name == "oscillator":
        tables["block"][1] |= {"model": "elastic"} | MESH
    elif engine == "meshed":
        tables["foundation"] = PLATE | MESH
    result = simulate(parse_scene(tables | {"output": {"fields": "none"}}))
    assert result.status == "completed"
    return result.history


IN_SPACE = {
    "NAME.gap_left_m": ("NAME.gap_1_m", "NAME.gap_4_m"),
    "NAME.gap_right_m": ("NAME.gap_2_m", "NAME.gap_3_m"),
    "NAME.centre_y_m": ("NAME.centre_z_m",),
    "NAME.angular_velocity_rad_s": ("NAME.angular_velocity_y_rad_s",),
}
"""Columns of the plane that have other names in space."""

OF_THE_METHOD = ("newton_iterations", "contact_points_closed")
"""Columns that say how a scene is solved, not what happens in it."""


def pairs(engine: str, name: str) -> list[tuple[Column, str, str]]:
    """The columns that are compared, with their names in the plane and in another engine."""
    found = []
    blocks = ["a", "b"] if name in ("stack", "rebounding") else ["a"]
    for column in TABLE:
        if column.dimension == 3 or column.name in OF_THE_METHOD:
            continue
        if column.needs or column.part in ("storey", "column", "link", "foot"):
            continue  # none of these scenes has any
        if column.part in ("platform", "foundation") and name != "oscillator":
            continue
        others = (column.name,)
        if engine == "space":
            others = IN_SPACE.get(column.name, others)
        for block_name in blocks if column.part == "block" else [""]:
            for other in others:
                own = column.name.replace("NAME", block_name)
                found.append((column, own, other.replace("NAME", block_name)))
    return found


def scale(column: Column, plane: History) -> float:
    """Scale by which differences of a column are measured."""
    if column.unit == "N":
        return float(np.median(plane["a.normal_force_N"]))
    if column.unit == "J":
        names = ("kinetic", "input", "friction", "contact")
        return max(float(np.abs(plane[f"energy.{name}_J"]).max()) for name in names)
    return SCALES.get(column.unit, 1.0)


@pytest.mark.parametrize(("engine", "name", "law"), CASES)
def test_engines_agree(engine: str, name: str, law: str) -> None:
    """Column by column: all that is there in the plane is there in the other engine, and alike."""
    plane, other = history("plane", name, law), history(engine, name, law)
    tolerance = EARLY_SLIP.get((engine, law), TOLERANCE[engine, name])
    for column, own, its in pairs(engine, name):
        # At t = 0 the meshed engine has no forces yet, the rigid ones those of the next instant.
        difference = np.abs(other[its] - plane[own])[1:]
        beyond = difference > tolerance * scale(column, plane)
        momentary = column.unit in ("N", "m/s²")
        assert np.mean(beyond) <= AT_CHANGES * momentary, f"{its}: {difference.max():.3g}"


@pytest.mark.parametrize("law", LAWS)
def test_the_block_slides(law: str) -> None:
    """Else all laws would be alike."""
    assert np.abs(history("plane", "sliding", law)["a.slip_m"]).max() > 5e-3
