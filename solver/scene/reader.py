"""Reading and writing a scene: TOML text, tables, overrides."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any, get_args

from solver.errors import SceneError, Statement
from solver.launcher import hidden_by_in_env
from solver.scene.checking import from_table, key_of, shown
from solver.scene.motion import MotionSpec
from solver.scene.overrides import override, read_toml
from solver.scene.scene import Scene

STANDARD_INPUT = Path("-")
"""What stands for the standard input among the names of scenes."""


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Read a scene file.

    Args:
        path: The TOML file; "-" is the standard input.
        overrides: Such as `"block.height=1.2"`; a block is addressed by its name.

    Raises:
        SceneError: It cannot be read, or is no scene; names key or file.
    """
    path = Path(path)
    source = "standard input" if path == STANDARD_INPUT else path.name
    return parse_scene(read_text(path), folder=path.parent, overrides=overrides, source=source)


def read_text(path: Path) -> str:
    """The text of a scene file; the only part of reading a scene that looks at the file."""
    try:
        if path == STANDARD_INPUT:
            return sys.stdin.buffer.read().decode("utf-8-sig") if sys.stdin else ""
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        hidden = hidden_by_in_env(path)
        if hidden:
            raise Statement(str(path), hidden) from None
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise Statement(str(path), f"cannot be read as a scene: {reason.lower()}") from None


def parse_scene(
    content: str | Mapping[str, Any],
    *,
    folder: str | Path = ".",
    overrides: Sequence[str] = (),
    source: str = "scene",
    needs_files: bool = True,
) -> Scene:
    """A scene from the text of a TOML file, or from its tables.

    Args:
        content: Text, or plain tables as `tomllib` makes them.
        folder: Where relative names of files start from.
        overrides: As for `load_scene`.
        source: What errors call the text as a whole.
        needs_files: Whether a motion from a file that is not there is refused.

    Raises:
        SceneError: It is no scene; names the key.
        TypeError: The content is neither text nor tables, or `overrides` is a single text.
    """
    if not isinstance(content, (str, Mapping)):
        raise TypeError(f"parse_scene takes TOML text or its tables, not {shown(content)}")
    if isinstance(overrides, str):
        raise TypeError(f"overrides are several texts, not one: [{overrides!r}]")
    tables = read_toml(content, source) if isinstance(content, str) else deepcopy(dict(content))
    if not tables:
        raise SceneError(source, "an empty scene", "at least [[block]] and [time]")
    set_values(tables, overrides)
    find_files(tables.get("motion"), "motion", folder, needed=needs_files)
    scene: Scene = from_table(Scene, tables)
    return scene


def set_values(tables: dict[str, Any], overrides: Sequence[str]) -> None:
    """Set values, as for `load_scene`, in the tables of a scene, which are changed in place."""
    known = [key_of(item) for item in fields(Scene)]
    for text in overrides:
        override(tables, text, known=known)


@cache
def _kinds_with_files() -> tuple[Any, ...]:
    """The kinds of motion that have a key `file`."""
    tables = (
        {field.name: field.default for field in fields(kind)} for kind in get_args(MotionSpec)
    )
    return tuple(keys["kind"] for keys in tables if "file" in keys)


def find_files(motion: Any, where: str, folder: str | Path, *, needed: bool = True) -> None:
    """Make the names of the files of a motion absolute, and refuse those that are not there.

    Args:
        motion: Its table, changed in place; what is no table is left for others to refuse.
        where: The path of its key.
        folder: Where relative names start from.
        needed: Whether they have to be there.
    """
    if not isinstance(motion, dict):
        return
    if motion.get("kind") in _kinds_with_files() and isinstance(motion.get("file"), str):
        motion["file"] = os.path.abspath(os.path.join(folder, motion["file"]))
        # os.path, unlike pathlib, says False to names that no file can have.
        if needed and not os.path.isfile(motion["file"]):
            hidden = "\0" not in motion["file"] and hidden_by_in_env(Path(motion["file"]))
            if hidden:
                raise Statement(f"{where}.file", f"{motion['file']} {hidden}")
            got = motion["file"] + " (a folder)" * os.path.isdir(motion["file"])
            raise SceneError(f"{where}.file", got, "a file that exists")
    for direction in ("vertical", "second"):
        find_files(motion.get(direction), f"{where}.{direction}", folder, needed=needed)


def scene_to_toml(scene: Scene) -> str:
    """The scene as text that `parse_scene` reads back to an equal scene."""
    import tomli_w

    text: str = tomli_w.dumps(scene.to_dict())
    return text
