"""Cells of a map of lambda: structures, friction, shapes; the axes over which they vary."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from solver.errors import SceneError, Statement
from solver.scene import BlockSpec, Platform, Scene, parse_scene
from solver.scene.checking import shown
from solver.scene.time import rounded_down
from solver.study.scenes import changed, with_model
from solver.study.study import numbers_by_name

AXES = {
    "period": "period T of the empty structure (s)",
    "friction": "friction coefficient μ",
    "friction_over_pga": "μ g/PGA",
    "mass_ratio": "mass ratio",
    "damping_ratio": "damping ratio ξ",
    "aspect": "height over width of the blocks, H/B",
}
"""Names of the axes, and what they are called in pictures."""

OF_STRUCTURE = ("period", "mass_ratio", "damping_ratio")
"""Axes that are numbers of the structure."""

DEFAULT = (
    "period=0.25,0.5,0.75,1,1.5,2",
    "friction=0.05,0.1,0.15,0.2,0.25,0.3,0.4,0.5",
)
"""The map of a command line that names no axis: 48 cells."""

STEPS_A_PERIOD = 100
"""Fewest steps of rigid blocks in a period of the structure and in 1/p, if the scene names no step.

That is a tenth of what single runs take, and lambda stays within 0.003 of the sliding block's."""

TOP, RATIO = 4, 1.25
"""The ladder of friction by which lambda is followed goes down from 1.25^4 in such ratios."""

ALLOWED = f"NAME=V1,V2,... of {', '.join(AXES)}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Structure:
    """The empty structure and its live load, as far as sliding depends on them."""

    mass_ratio: float
    """m_L/m_P."""
    period: float
    """T, s."""
    damping_ratio: float
    """xi."""
    gravity: float
    """m/s^2."""
    dynamic: float
    """mu_d/mu_s."""
    unit_pga: bool
    """True if all motions are scaled to a peak of 1 g."""

    def platform(self) -> Platform:
        """A structure of 1 kg, so that the live load is `mass_ratio` kg."""
        return Platform.on_spring(
            1.0, period=self.period, stiffness=None, damping_ratio=self.damping_ratio
        )


class Cell(NamedTuple):
    """One place of a map."""

    values: tuple[tuple[str, float], ...]
    """Names and values of the axes."""
    structure: Structure
    friction: float
    """mu, or mu g/PGA."""
    aspect: float | None = None
    """H/B where the map sets it."""


def chosen(words: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """Axes and values of a command line."""
    found = numbers_by_name("--of", words or DEFAULT, tuple(AXES), ALLOWED)
    for name, values in found.items():
        if not values or not all(value > 0 for value in values):
            got = ",".join(f"{value:g}" for value in values)
            raise SceneError(f"--of {name}", shown(got), "positive numbers, each once")
        found[name] = tuple(sorted(values))
    if {"friction", "friction_over_pga"} <= found.keys():
        raise SceneError("--of", "friction and friction_over_pga", "one of them")
    return found


def structure_of(scene: Scene, *, unit_pga: bool) -> tuple[Structure, float]:
    """The structure of a scene and the friction under its live load; what does not fit is refused.

    The sliding block by which lambda is followed has a single spring, a horizontal base and
    Coulomb's friction without cohesion.
    """
    if scene.foundation.kind != "oscillator":
        raise SceneError("foundation.kind", shown(scene.foundation.kind), '"oscillator"')
    standing = [block for block in scene.blocks if scene.carrier_of(block) is None]
    laws = {scene.friction_of(block) for block in standing}
    if len(laws) > 1:
        raise Statement("contact.friction", "differs between the blocks on the platform")
    law = laws.pop()
    if law.decay or law.cohesion or not law.static > 0:
        raise Statement("contact.friction", "needs to be positive, without decay and cohesion here")
    if scene.gravity_vector[0]:
        raise Statement("scene", "is inclined; the structures of the study are level")
    if any(pair.friction is not None and "foundation" in pair.between for pair in scene.pairs):
        raise Statement("pair", "may not be of the platform, whose friction the study varies")
    if any(block.position is not None for block in scene.blocks):
        raise Statement("scene", "starts with a block in the air; the study starts all at rest")
    if not all(block.begins_at_rest for block in scene.blocks):
        raise Statement("scene", "starts with a tilt or a velocity; the study starts all at rest")
    platform = scene.platform()
    structure = Structure(
        mass_ratio=scene.carried_mass / platform.mass,
        period=platform.period,
        damping_ratio=platform.damping_ratio,
        gravity=scene.gravity,
        dynamic=law.dynamic / law.static,
        unit_pga=unit_pga,
    )
    return structure, law.static


def cells_of(scene: Scene, axes: Mapping[str, tuple[float, ...]]) -> tuple[Cell, ...]:
    """Every combination of the values of the axes; what they do not name is the scene's."""
    unit_pga = "friction_over_pga" in axes
    base, friction = structure_of(scene, unit_pga=unit_pga)
    made = []
    for combination in itertools.product(*axes.values()):
        values: dict[str, Any] = dict(zip(axes, combination, strict=True))
        own = {name: values[name] for name in OF_STRUCTURE if name in values}
        mu = values.get("friction_over_pga", values.get("friction", friction))
        made.append(Cell(tuple(values.items()), replace(base, **own), mu, values.get("aspect")))
    return tuple(made)


def ladder(frictions: Iterable[float]) -> list[float]:
    """Friction from infinity down to the least of these values, which are all part of it."""
    wanted = set(frictions)
    steps, number = set[float](), TOP
    while RATIO**number > min(wanted):
        steps.add(RATIO**number)
        number -= 1
    return [math.inf, *sorted(steps | wanted, reverse=True)]


def step_of(blocks: Iterable[BlockSpec], structure: Structure) -> float:
    """Step of rigid blocks that a map needs, s: 1, 2 or 5 times a power of ten."""
    frequencies = (block.shape.frequency(structure.gravity) for block in blocks)
    longest = min(structure.period, *(1 / p for p in frequencies if p > 0))
    return rounded_down(longest / STEPS_A_PERIOD)


def tables_of(tables: Mapping[str, Any], cell: Cell, model: str) -> dict[str, Any]:
    """The scene of a cell as plain tables; `model`: of all blocks."""
    structure, friction = cell.structure, cell.friction
    changes: dict[str, Any] = {
        "foundation": {
            "kind": "oscillator",
            "mass_ratio": structure.mass_ratio,
            "period": structure.period,
            "damping_ratio": structure.damping_ratio,
        },
        "contact.friction": {"static": friction, "dynamic": structure.dynamic * friction},
    }
    for spec in parse_scene(dict(tables)).blocks:
        name = spec.name
        if spec.carrier == "foundation":
            changes[f"{name}.friction"] = None
        if cell.aspect is not None:
            if not spec.shape.is_even:
                raise SceneError(name, "an uneven block", "homogeneous blocks where H/B varies")
            changes[f"{name}.height"] = cell.aspect * spec.width
            changes |= {f"{name}.mass": spec.shape.mass, f"{name}.density": None}
    made = changed(with_model(tables, model), changes)
    if model == "rigid" and "step" not in made.setdefault("time", {}):
        made["time"]["step"] = step_of(parse_scene(made).blocks, structure)
    return made
