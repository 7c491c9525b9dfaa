"""Scenes of studies: from a command line, of one block on firm ground, and variants."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Mapping
from copy import deepcopy
from typing import Any

from solver.errors import SceneError, not_applicable
from solver.reference.answer import refuse_several
from solver.scene import Scene, parse_scene, read_text, set_values
from solver.scene.reader import read_toml

Tables = dict[str, Any]
"""A scene as plain tables."""

HERE = "in this study"

Changes = Mapping[str, Any]
"""Values of a scene by the dotted names of their keys; None takes a key away."""


def scene_tables(options: argparse.Namespace) -> Tables:
    """The tables of the scene of a command line, with the values of `--set`."""
    path = options.scene
    tables = read_toml(read_text(path), path.name)
    set_values(tables, options.overrides)
    return tables


def changed(tables: Mapping[str, Any], changes: Changes) -> Tables:
    """A scene with other values: as `--set` has them.

    Where no block is called so, `block.KEY` is that of all blocks.
    """
    new = deepcopy(dict(tables))
    for path, value in changes.items():
        *parents, key = path.split(".")
        for table in _meant(new, parents):
            if value is None:
                table.pop(key, None)
            else:
                table[key] = deepcopy(value)
    return new


def _meant(tables: Tables, parents: list[str]) -> list[Tables]:
    """The tables at a path: of the block of that name, of all blocks, or below the scene."""
    named = {entry.get("name", "block"): [entry] for entry in tables["block"]}
    found = [tables]
    if parents and parents[0] in ("block", *named):
        found = named.get(parents[0], tables["block"])
        parents = parents[1:]
    for parent in parents:
        found = [table.setdefault(parent, {}) for table in found]
    return found


def with_model(tables: Mapping[str, Any], engine: str | None) -> Tables:
    """The tables of a scene with all blocks "rigid" or "elastic"; None: as they are.

    A restitution is of rigid blocks alone, and of their pairs: elastic ones have their own.
    """
    made = deepcopy(dict(tables))
    for block in made["block"] if engine else ():
        block["model"] = "elastic" if engine == "elastic" else "rigid"
    pairs = made.get("pair", [])
    for table in (*made["block"], *pairs) if engine == "elastic" else ():
        table.pop("restitution", None)
    if pairs:
        made["pair"] = [pair for pair in pairs if {"friction", "restitution"} & pair.keys()]
    return made


def standing_block(options: argparse.Namespace) -> Tables:
    """The tables of a scene of one block at rest on firm ground, in the plane, without its motion.

    Raises:
        SceneError: It is not such a scene.
    """
    tables, path = scene_tables(options), options.scene
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
        model: As of `with_model`.
        time: `[time]` in place of its own.
        keys: Of the block.
    """
    changes: dict[str, Any] = {f"block.{key}": value for key, value in keys.items()}
    if time is not None:
        changes["time"] = time
    return parse_scene(changed(with_model(tables, model), changes))


def is_elastic(tables: Tables) -> bool:
    """True if the block of a scene can be run as an elastic one: it has E and nu."""
    (block,) = tables["block"]
    return "young" in block and "poisson" in block


def refuse_uneven(scene: Scene, what: str) -> None:
    """Refuse blocks whose mass is not spread evenly: SceneError; `what` is for homogeneous ones."""
    for block in scene.blocks:
        for key in ("centre_of_mass", "inertia", "parts"):
            if getattr(block, key) and not block.shape.is_even:
                raise SceneError(f"{block.name}.{key}", "an uneven block", f"none {what}")


def refuse_others(scene: Scene) -> None:
    """Refuse what is not one upright block at rest on firm ground in the plane: SceneError."""
    refuse_several(scene, HERE)
    block = scene.blocks[0]
    if scene.carrier_moves or scene.foundation.top is not None:
        raise not_applicable("foundation", f"blocks on level, firm ground {HERE}")
    if scene.gravity <= 0 or scene.gravity_vector[0] != 0:
        raise SceneError("gravity", "an incline, or none", f"vertical gravity > 0 {HERE}")
    if scene.pairs:
        raise SceneError("pair", scene.pairs[0].where, f"keys of {block.name} {HERE}")
    if block.tilt or any(block.velocity) or block.angular_velocity:
        raise SceneError(block.name, "a block that is tilted or moves", f"one at rest {HERE}")
