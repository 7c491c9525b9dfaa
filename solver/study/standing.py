"""The scene of a study of one block that stands on firm ground, and variants of it."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

from solver.errors import SceneError, not_applicable
from solver.scene import Scene, parse_scene, read_text, set_values
from solver.scene.checking import nearest, shown
from solver.scene.reader import read_toml

Tables = dict[str, Any]
"""A scene as plain tables."""


def standing_block(path: Path, overrides: Sequence[str]) -> Tables:
    """The tables of a scene of one block at rest on firm ground, in the plane, without its motion.

    Raises:
        SceneError: It is not such a scene.
    """
    tables = read_toml(read_text(path), path.name)
    set_values(tables, overrides)
    motion = tables.pop("motion", None)
    refuse_components(motion if isinstance(motion, dict) else ())
    scene = parse_scene(tables, folder=path.parent, source=path.name)
    refuse_others(scene)
    return tables


def refuse_components(keys: Collection[str]) -> None:
    """Refuse a motion that has not x alone, by the keys of its table."""
    for direction in ("vertical", "second"):
        if direction in keys:
            allowed = "none: the motions of the study are along x"
            raise SceneError(f"motion.{direction}", "a motion", allowed)


def variant(
    tables: Tables, *, model: str | None = None, time: Tables | None = None, **keys: Any
) -> Scene:
    """The scene with other keys of its block; None takes a key away.

    Args:
        tables: Of the scene.
        model: "rigid" or "elastic"; None: as it is. A restitution is of rigid blocks alone.
        time: `[time]` in place of its own.
        keys: Of the block.
    """
    made = deepcopy(tables)
    (block,) = made["block"]
    block |= keys if model is None else keys | {"model": model}
    if block.get("model") != "rigid":
        block["restitution"] = None
    made["block"] = [{key: value for key, value in block.items() if value is not None}]
    if time is not None:
        made["time"] = time
    return parse_scene(made)


def is_elastic(tables: Tables) -> bool:
    """Whether the block of a scene can be run as an elastic one: it has E and nu."""
    (block,) = tables["block"]
    return "young" in block and "poisson" in block


def refuse_others(scene: Scene) -> None:
    """Refuse what is not one upright block at rest on firm ground in the plane: SceneError."""
    if scene.dimension != 2:
        raise SceneError("dimension", "3", "2 in this study")
    if len(scene.blocks) != 1:
        raise SceneError("block", f"{len(scene.blocks)} blocks", "one block in this study")
    block = scene.blocks[0]
    if scene.carrier_moves or scene.foundation.top is not None:
        raise not_applicable("foundation", "blocks on level, firm ground in this study")
    if scene.gravity <= 0 or scene.gravity_vector[0] != 0:
        raise SceneError("gravity", "an incline, or none", "vertical gravity > 0 in this study")
    if block.tilt or any(block.velocity) or block.angular_velocity:
        raise SceneError(block.name, "a block that is tilted or moves", "one at rest in this study")


def numbers(option: str, text: str) -> list[float]:
    """The positive numbers of an option: V1,V2,... or LOW:HIGH:COUNT, equally spaced.

    Raises:
        SceneError: It holds something else.
    """
    import numpy as np

    try:
        if text.count(":") == 2:
            low, high, count = text.split(":")
            found = [float(f"{v:.6g}") for v in np.linspace(float(low), float(high), int(count))]
        else:
            found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if not found or not all(0 < value < math.inf for value in found):
        raise SceneError(option, shown(text), "numbers > 0: V1,V2,... or LOW:HIGH:COUNT")
    return list(dict.fromkeys(found))


def words(option: str, text: str, known: Sequence[str]) -> list[str]:
    """The words of an option, V1,V2,..., all of them known; SceneError where one is not."""
    found = list(dict.fromkeys(text.split(",")))
    for word in found:
        if word not in known:
            raise SceneError(option, shown(word), ", ".join(known), nearest(word, known))
    return found
