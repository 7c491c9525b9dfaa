"""A scene: what is to be simulated, in code and in TOML."""

from __future__ import annotations

import copy
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from solver.checking import Checked, from_table, key_of, nearest, shown, to_table
from solver.errors import SceneError, UnknownKey
from solver.specs import (
    BlockSpec,
    ContactSpec,
    DampingSpec,
    FoundationSpec,
    MotionSpec,
    OutputSpec,
    Positive,
    SineSpec,
    TableSpec,
    Tilt,
    TimeSpec,
)

__all__ = [
    "BlockSpec",
    "ContactSpec",
    "DampingSpec",
    "FoundationSpec",
    "MotionSpec",
    "OutputSpec",
    "Scene",
    "SineSpec",
    "TableSpec",
    "TimeSpec",
    "load_scene",
    "parse_scene",
    "read_text",
    "scene_to_toml",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene(Checked):
    """All of a simulation's input, checked."""

    title: str = ""
    dimension: Literal[2] = 2
    plane: Literal["strain", "stress"] = "strain"
    gravity: Positive = 9.81
    """g, m/s^2."""
    gravity_tilt_deg: Tilt = 0.0
    """Turns gravity towards +x, degrees: an incline."""
    blocks: tuple[BlockSpec, ...] = field(metadata={"key": "block"})
    foundation: FoundationSpec = field(default_factory=FoundationSpec)
    contact: ContactSpec = field(default_factory=ContactSpec)
    damping: DampingSpec | None = None
    motion: MotionSpec | None = None
    time: TimeSpec
    output: OutputSpec = field(default_factory=OutputSpec)

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        names = [block.name for block in self.blocks]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise SceneError(f"{twice}.name", "one name twice", "a name of its own for each block")
        if len(names) != 1:
            raise SceneError("block", f"{len(names)} blocks", "one block, [[block]]")

    @property
    def gravity_vector(self) -> tuple[float, float]:
        """Gravity along x and y, m/s^2."""
        tilt = math.radians(self.gravity_tilt_deg)
        return self.gravity * math.sin(tilt), -self.gravity * math.cos(tilt)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain tables, every default written out."""
        return to_table(self)


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Read a scene file.

    Args:
        path: The TOML file.
        overrides: Such as `"block.height=1.2"`; a block is addressed by its name.
    """
    path = Path(path)
    return parse_scene(read_text(path), folder=path.parent, overrides=overrides, source=path.name)


def read_text(path: Path) -> str:
    """The text of a scene file; the only part of reading a scene that looks at the file."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise SceneError(str(path), f"no text ({reason.lower()})", "a scene in TOML") from None


def parse_scene(
    content: str | Mapping[str, Any],
    *,
    folder: str | Path = ".",
    overrides: Sequence[str] = (),
    source: str = "scene",
) -> Scene:
    """A scene from the text of a TOML file, or from its tables.

    Args:
        content: Text, or plain tables as `tomllib` makes them.
        folder: Where relative names of files start from.
        overrides: As for `load_scene`.
        source: What errors call the text as a whole.
    """
    tables = _tables(content, source) if isinstance(content, str) else copy.deepcopy(dict(content))
    if not tables:
        raise SceneError(source, "an empty scene", "at least [[block]] and [time]")
    for override in overrides:
        _override(tables, override)
    motion = tables.get("motion")
    if isinstance(motion, dict) and isinstance(motion.get("file"), str):
        motion["file"] = os.path.abspath(os.path.join(folder, motion["file"]))
    scene: Scene = from_table(Scene, tables)
    # os.path, unlike pathlib, says False to names that no file can have.
    if isinstance(scene.motion, TableSpec) and not os.path.isfile(scene.motion.file):
        raise SceneError("motion.file", str(scene.motion.file), "a file that exists")
    return scene


def scene_to_toml(scene: Scene) -> str:
    """The scene as text that `parse_scene` reads back to an equal scene."""
    import tomli_w

    text: str = tomli_w.dumps(scene.to_dict())
    return text


def _tables(text: str, source: str) -> dict[str, Any]:
    import tomllib

    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also numbers and nesting beyond all bounds
        raise SceneError(source, f"unreadable TOML, {error}", "TOML") from None


def _toml_value(text: str) -> Any:
    """A value of the command line: TOML where it is TOML, else the text itself."""
    import tomllib

    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text


def _override(tables: dict[str, Any], override: str) -> None:
    """Set one value, `path=value`, in the tables of a scene."""
    path, equals, text = override.partition("=")
    *parents, key = [part.strip() for part in path.split(".")]
    if not equals or not key or not all(parents):
        raise SceneError("--set", shown(override), "path=value, such as block.height=1.2")
    blocks = _blocks(tables)
    table: Any = tables
    for depth, parent in enumerate(parents):
        if depth == 0 and parent in blocks:
            table = blocks[parent]
            continue
        known = [*blocks, *(key_of(item) for item in fields(Scene) if item.name != "blocks")]
        if depth == 0 and parent not in known:
            raise UnknownKey(parent, parent, ", ".join(known), nearest(parent, known))
        table = table.setdefault(parent, {})
        if not isinstance(table, dict):
            raise SceneError(f"--set {path}", f"{parent}, which is no table", "the path of a key")
    table[key] = _toml_value(text.strip())


def _blocks(tables: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The tables of the blocks by name."""
    entries = tables.get("block")
    entries = entries if isinstance(entries, list) else []
    return {str(entry.get("name", "block")): entry for entry in entries if isinstance(entry, dict)}
