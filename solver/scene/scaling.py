"""A scene at another scale: the model of a prototype, or the other way round.

Accelerations stay what they are, gravity included, so that times go with the square root of
lengths. Either the material keeps its density, and moduli go with lengths; or it keeps its moduli,
and the density goes with the inverse of lengths (masses are added to a model). In both cases
strains, friction and damping ratios are the same, and histories of angles over p t.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from solver.scene.checking import choices_of, fields_of, key_of
from solver.scene.quantities import Number, number_of
from solver.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Scale:
    """The scale of a model: its lengths over those of the prototype, and what its material keeps.

    Raises:
        ValueError: The scale is no positive number.
    """

    lengths: float
    keeps: Literal["density", "young"] = "density"

    def __post_init__(self) -> None:
        """Check the scale."""
        if not 0 < self.lengths < math.inf:
            raise ValueError(f"lengths times {self.lengths}")

    def of(self, quantity: Number) -> float:
        """The factor on a quantity."""
        by_density, by_length = quantity.powers
        density = 1.0 if self.keeps == "density" else 1 / self.lengths
        return float(density**by_density * self.lengths**by_length)

    @property
    def times(self) -> float:
        """The factor on times."""
        return math.sqrt(self.lengths)


def scaled_tables(scene: Scene, scale: Scale, motions: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """The tables of a scene at another scale, every default written out.

    Args:
        scene: The prototype.
        scale: Of the model.
        motions: Tables that stand for motions from samples at the new scale, by their paths
            ("motion", "motion.vertical").
    """
    tables = _scaled(dataclasses.replace(scene, motion=None), scale)
    found = {
        path: motions.get(path) or _scaled(_alone(motion), scale) for path, motion in scene.motions
    }
    if found:
        tables["motion"] = found.pop("motion")
        tables["motion"] |= {path.removeprefix("motion."): table for path, table in found.items()}
    return tables


def _alone(motion: Any) -> Any:
    """A motion without those in other directions."""
    return dataclasses.replace(motion, vertical=None, second=None)


def _scaled(spec: Any, scale: Scale) -> dict[str, Any]:
    """A table of a scene at another scale."""
    cls: Any = type(spec)
    pairs = ((field, hint, getattr(spec, field.name)) for field, hint in fields_of(cls))
    return {
        key_of(field): _value(value, scale, hint)
        for field, hint, value in pairs
        if value is not None and value != ()
    }


def _value(value: Any, scale: Scale, hint: Any) -> Any:
    """A value of a table at another scale, by its type."""
    if dataclasses.is_dataclass(value):
        return _scaled(value, scale)
    if isinstance(value, tuple):
        items = zip(value, _items(hint, len(value)), strict=True)
        return [_value(item, scale, own) for item, own in items]
    if isinstance(value, Path):
        return str(value)
    quantity = number_of(hint)
    return value * scale.of(quantity) if quantity and isinstance(value, float) else value


def _items(hint: Any, count: int) -> Sequence[Any]:
    """The types of so many members of an array, by its own."""
    for choice in choices_of(hint):
        items = get_args(choice) if get_origin(choice) is tuple else ()
        if items and items[-1] is Ellipsis:
            return [items[0]] * count
        if len(items) == count:
            return items
    return [hint] * count
