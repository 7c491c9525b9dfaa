"""The parameters that restitution is measured against, and how each is set in a scene."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from solver.errors import SceneError, not_applicable
from solver.scene import BlockSpec, Scene
from solver.scene.checking import nearest, shown, to_table
from solver.scene.damping import DEFAULT_RATIO, stiffness_damping

Tables = dict[str, Any]
"""A scene as plain tables, changed in place."""

Setter = Callable[[Tables, Scene, BlockSpec, float], None]
"""Sets a value in the tables: of which scene, for which block."""

Chosen = Callable[[Scene, BlockSpec], tuple[float, ...]]
"""Values that suit a scene and a block."""

STEPS_OF_CROSSINGS = (4.0, 2.0, 1.0, 0.5, 0.2)
"""Fixed steps, over the time in which sound crosses the height of the block."""

BETAS = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
"""beta_R over the power of ten below that of 2 % of critical damping."""

BETA_BOUNDS = (0.25, 5.0)
"""Bounds of beta_R for calibration, over that of 2 % of critical damping. Below them vibration
lasts from impact to impact; above them more damping takes less, not more, from an impact."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """A parameter that is swept.

    Attributes:
        name: On the command line.
        key: What is set, for headings: the key of the scene, or words.
        unit: Of its values; "" without one.
        meaning: "physical": a property of the blocks; "numerical": of the method.
        text: What it is, in words.
        put: Sets it.
        values: Values that suit a scene.
        limit: Where its limit is: at zero, at infinity, or nowhere.
        bounds: Least and largest value of a calibration; None: it is not one to calibrate.
    """

    name: str
    key: str
    unit: str
    meaning: Literal["physical", "numerical"]
    text: str
    put: Setter
    values: Chosen
    limit: Literal["zero", "infinity", ""] = ""
    bounds: Callable[[Scene, BlockSpec], tuple[float, float]] | None = None

    def __reduce__(self) -> tuple[Callable[[str], Axis], tuple[str]]:
        """By its name when it is sent to another process, which has the same axes."""
        return axis_called, (self.name,)

    @property
    def label(self) -> str:
        """Name and unit, for the axis of a picture."""
        return f"{self.key} ({self.unit})" if self.unit else self.key

    def distance(self, value: float) -> float:
        """Distance of a value from the limit, in any unit; meaningless without a limit."""
        return 1 / value if self.limit == "infinity" else value


def _set(*path: str) -> Setter:
    """Set the key at the end of a path."""

    def put(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
        table = tables
        for name in path[:-1]:
            table = table.setdefault(name, {})
        table[path[-1]] = value

    return put


def _fixed(*values: float) -> Chosen:
    """Values that do not depend on the scene."""
    return lambda scene, block: values


def table_of(tables: Tables, block: BlockSpec) -> Tables:
    """The table of a block."""
    entries: list[Tables] = tables["block"]
    return next(entry for entry in entries if entry.get("name", "block") == block.name)


def _put_step(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """Fixed steps of a size, s."""
    for key in ("adaptive", "tolerance", "largest", "smallest"):
        tables["time"].pop(key, None)
    tables["time"]["step"] = value


def _steps(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """Fixed steps around the time in which sound crosses the block, s."""
    assert block.young is not None
    crossing = block.height * math.sqrt(block.shape.density / block.young)
    steps = dict.fromkeys(_round(ratio * crossing) for ratio in STEPS_OF_CROSSINGS)
    return tuple(step for step in steps if step <= scene.time.end / 10)


def _round(value: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    digit = min((1, 2, 5, 10), key=lambda digit: abs(math.log(digit * power / value)))
    return float(f"{digit * power:.0e}")


def _put_tolerance(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """Adaptive steps of a tolerance."""
    if not scene.time.adaptive:
        for key in ("step", "smallest", "damped_steps"):
            tables["time"].pop(key, None)
    tables["time"]["tolerance"] = value


def _tolerances(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """From 16 times the tolerance of the scene, or the default, to a fourth of it."""
    own = scene.time.tolerance or 1e-3
    return tuple(float(f"{ratio * own:.3g}") for ratio in (16, 4, 1, 0.25))


def _put_damped_steps(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """Damped steps after a change of contact: a whole number."""
    tables["time"]["damped_steps"] = int(value) if value.is_integer() else value


def _put_mesh(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """The numbers of cells of all meshed bodies, times a factor."""
    if not value > 0:
        raise SceneError("--of mesh", shown(value), "factors > 0")
    for spec in scene.blocks:
        if spec.model == "elastic":
            table_of(tables, spec)["cells"] = [_times(value, count) for count in spec.cells]
    foundation = scene.foundation
    if foundation.is_meshed:
        finer = foundation.refined(lambda count: _times(value, count))
        tables["foundation"]["cells"] = to_table(finer)["cells"]


def _times(factor: float, count: int) -> int:
    """A number of cells times a factor."""
    return max(1, round(factor * count))


def _put_young(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """Young's modulus of the block, Pa; its damping stays, also where that is the default."""
    own = table_of(tables, block)
    own["young"] = value
    if block.damping is not None:
        own.setdefault("damping", to_table(block.damping))


def _put_beta(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """beta_R of `[damping]` where the block has that, else that of the block itself, s."""
    own = table_of(tables, block)
    owner = own if "damping" in own or "damping" not in tables else tables
    owner["damping"] = dict(owner.get("damping", {})) | {"stiffness": value}


def _two_percent(scene: Scene, block: BlockSpec) -> float:
    """beta_R of 2 % of critical damping at the first bending mode, s."""
    return stiffness_damping(DEFAULT_RATIO, scene.bending_frequency(block)).stiffness


def _betas(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """None, and three decades around 2 % of critical damping, s."""
    decade = 10.0 ** math.floor(math.log10(_two_percent(scene, block)))
    return tuple(float(f"{ratio * decade:.3g}") for ratio in BETAS)


def _beta_bounds(scene: Scene, block: BlockSpec) -> tuple[float, float]:
    """From 0.5 % to 10 % of critical damping, s."""
    usual = _two_percent(scene, block)
    low, high = (float(f"{ratio * usual:.1e}") for ratio in BETA_BOUNDS)
    return low, high


def _contact_bounds(scene: Scene, block: BlockSpec) -> tuple[float, float]:
    """From a fiftieth of the critical value to the critical value."""
    return 0.02, 1.0


def _put_floor(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """E of a meshed floor over that of the block; where the floor is rigid, a plate is put in."""
    assert block.young is not None
    floor = scene.foundation
    if floor.is_meshed:
        tables["foundation"]["young"] = value * block.young
        return
    standing = [spec for spec in scene.blocks if scene.carrier_of(spec) is None]
    if floor.on_spring or len(standing) > 1:
        raise not_applicable("--of floor", "meshed floors and rigid ones with one block on them")
    base = standing[0]
    if base.model == "rigid":
        raise not_applicable("--of floor", "floors under a meshed block")
    *along, _ = base.cells
    sides = [4 * base.width + 2 * abs(base.offset)]
    if scene.dimension == 3:
        sides.append(4 * base.thickness + 2 * abs(base.offset_second))
    own = [base.width, base.thickness][: len(sides)]
    cells = [round(side * n / size) for side, n, size in zip(sides, along, own, strict=True)]
    tables["foundation"] = {
        "kind": "elastic",
        "support": "bottom",
        "width": sides[0],
        "height": base.width,
        "density": base.shape.density,
        "young": value * block.young,
        "poisson": base.poisson,
        "cells": [*cells, along[0]],
        **({"thickness": sides[1]} if scene.dimension == 3 else {}),
    }
    if scene.damping is None and base.damping is not None:  # else it has that of [damping]
        tables["foundation"]["damping"] = to_table(base.damping)


def _youngs(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """A tenth of the block's own modulus to ten times it, Pa."""
    assert block.young is not None
    return tuple(float(f"{ratio * block.young:.3g}") for ratio in (0.1, 0.3, 1, 3, 10))


AXES = {
    axis.name: axis
    for axis in (
        Axis(
            name="step", key="time.step", unit="s", meaning="numerical", limit="zero",
            text="fixed time steps", put=_put_step, values=_steps,
        ),
        Axis(
            name="tolerance", key="time.tolerance", unit="", meaning="numerical", limit="zero",
            text="tolerance of adaptive steps", put=_put_tolerance, values=_tolerances,
        ),
        Axis(
            name="mesh", key="cells of an edge over the scene's", unit="",
            meaning="numerical", limit="infinity", text="mesh of all bodies", put=_put_mesh,
            values=_fixed(0.5, 1.0, 2.0, 4.0),
        ),
        Axis(
            name="gamma", key="contact.gamma", unit="", meaning="numerical",
            text="Nitsche parameter", put=_set("contact", "gamma"),
            values=_fixed(30.0, 100.0, 300.0, 1000.0),
        ),
        Axis(
            name="rho_inf", key="time.rho_inf", unit="", meaning="numerical",
            text="spectral radius of the time integration", put=_set("time", "rho_inf"),
            values=_fixed(0.0, 0.5, 0.8, 1.0),
        ),
        Axis(
            name="damped_steps", key="time.damped_steps", unit="", meaning="numerical",
            text="damped steps after a change of contact", put=_put_damped_steps,
            values=_fixed(0.0, 2.0, 8.0, 32.0),
        ),
        Axis(
            name="beta", key="beta_R", unit="s", meaning="physical",
            text="stiffness-proportional damping", put=_put_beta, values=_betas,
            bounds=_beta_bounds,
        ),
        Axis(
            name="contact", key="contact.damping", unit="", meaning="physical",
            text="dashpots of contact over their critical value",
            put=_set("contact", "damping"), values=_fixed(0.02, 0.05, 0.1, 0.2, 0.5, 1.0),
            bounds=_contact_bounds,
        ),
        Axis(
            name="young", key="E", unit="Pa", meaning="physical",
            text="Young's modulus of the block", put=_put_young, values=_youngs,
        ),
        Axis(
            name="floor", key="E of floor over E of block", unit="",
            meaning="physical", limit="infinity", text="stiffness of a meshed floor",
            put=_put_floor, values=_fixed(1.0, 3.0, 10.0, 30.0),
        ),
    )
}  # fmt: skip
"""All of them by name, in the order in which they are told."""


def axis_called(name: str, option: str = "--of") -> Axis:
    """The axis of a name of the command line."""
    if name not in AXES:
        raise SceneError(option, shown(name), ", ".join(AXES), nearest(name, AXES))
    return AXES[name]
