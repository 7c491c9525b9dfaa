"""Reading and writing a scene: TOML text, tables, overrides."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import fields
from pathlib import Path
from typing import Any

from solver.errors import SceneError, Statement, UnknownKey, hidden_by_in_env
from solver.scene.checking import from_table, key_of, nearest, shown
from solver.scene.scene import Scene

BARE = r"[-+]?(?:\.\d+|\d+\.)(?:[eE][-+]?\d+)?"
"""Numbers that have no digit before or after their point, which TOML does not allow."""

NAMED = ("block", "link", "force")
"""The arrays of tables whose members are addressed by their names."""

STANDARD_INPUT = Path("-")
"""The name of a scene that stands for the standard input."""


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Read a scene file.

    Args:
        path: The TOML file; "-" is the standard input.
        overrides: Such as `"block.height=1.2"`; a block, a link or a force is addressed by its
            name, and a pair by both, as in `"pair.lower.upper.friction=0.4"`.

    Raises:
        SceneError: It cannot be read, or is no scene; names key or file.
    """
    path = Path(path)
    source = "standard input" if path == STANDARD_INPUT else path.name
    return parse_scene(read_text(path), folder=path.parent, overrides=overrides, source=source)


def read_text(path: Path) -> str:
    """The text of a scene file; the only part of reading a scene that opens it."""
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
        source: Name of the text as a whole in errors.
        needs_files: Refuse a motion from a file that is not there.

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
    find_shapes(tables.get("block"), folder, needed=needs_files)
    scene: Scene = from_table(Scene, tables)
    return scene


def set_values(tables: dict[str, Any], overrides: Sequence[str]) -> None:
    """Set values, as for `load_scene`, in the tables of a scene, which are changed in place."""
    known = [key_of(item) for item in fields(Scene)]
    for text in overrides:
        _override(tables, text, known)


def find_files(motion: Any, where: str, folder: str | Path, *, needed: bool = True) -> None:
    """Make the names of the files of a motion absolute, and refuse those that are not there.

    Args:
        motion: Its table, changed in place; anything else is refused later.
        where: The path of its key.
        folder: Where relative names start from.
        needed: Refuse those that are not there.
    """
    if not isinstance(motion, dict):
        return
    if isinstance(motion.get("file"), str):
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


def find_shapes(blocks: Any, folder: str | Path, *, needed: bool = True) -> None:
    """Do the same with the files of the shapes of blocks, whose tables are changed in place."""
    for block in blocks if isinstance(blocks, list) else []:
        shape = block.get("shape") if isinstance(block, dict) else None
        parts = shape.get("union") if isinstance(shape, dict) else None
        for table in [shape, *(parts if isinstance(parts, list) else [])]:
            find_files(table, f"{block.get('name', 'block')}.shape", folder, needed=needed)


def scene_to_toml(scene: Scene) -> str:
    """The scene as text that `parse_scene` reads back to an equal scene."""
    import tomli_w

    text: str = tomli_w.dumps(scene.to_dict())
    return text


def read_toml(text: str, source: str) -> dict[str, Any]:
    """The tables of a TOML text; SceneError, in which it is called `source`, if it is none."""
    import tomllib

    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also numbers and nesting beyond all bounds
        bare = _bare_number(text, str(error))
        if bare:
            raise SceneError(source, bare, "digits on both sides of the point, as in 0.1") from None
        raise SceneError(source, f"unreadable TOML, {error}", "TOML") from None


def _bare_number(text: str, said: str) -> str:
    """The number without a digit before or after its point at which reading ended, if it did so."""
    found = re.search(r"at line (\d+)", said)
    lines = text.splitlines()
    if found is None or int(found[1]) > len(lines):
        return ""
    line = lines[int(found[1]) - 1].partition("#")[0]
    number = re.search(rf"(?<![\w.\"'])({BARE})(?![\w.\"'])", line)
    return f"{number[1]} in line {found[1]}" if number else ""


def _toml_value(text: str) -> Any:
    """A value of the command line: TOML where it is TOML, else the text itself."""
    import tomllib

    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return float(text) if re.fullmatch(BARE, text) else text
    return table["value"] if len(table) == 1 else text


def _override(tables: dict[str, Any], text: str, known: Sequence[str]) -> None:
    """Set one value, `path=value`, in the tables of a scene.

    A block, a link and a force are addressed by their names, and a pair by both names; it is added
    if it is not there.
    """
    path, equals, value = text.partition("=")
    *parents, key = [part.strip() for part in path.split(".")]
    if not equals or not key or not all(parents):
        raise SceneError("--set", shown(text), "path=value, such as block.height=1.2")
    members = _members(tables)
    allowed = [*members, *(key for key in known if key not in NAMED)]
    table: Any = tables
    if parents and parents[0] in members:
        table = members[parents.pop(0)]
    elif parents and parents[0] == "pair":
        if len(parents) < 3:
            raise SceneError(f"--set {path}", shown(value), "pair.NAME.NAME.key=value")
        table, parents = _pair(tables, parents[1:3]), parents[3:]
    elif parents and parents[0] not in allowed:
        first = parents[0]
        raise UnknownKey(first, first, ", ".join(allowed), nearest(first, allowed))
    for parent in parents:
        table = table.setdefault(parent, {})
        if not isinstance(table, dict):
            raise SceneError(f"--set {path}", f"{parent}, which is no table", "the path of a key")
    table[key] = _toml_value(value.strip())


def _members(tables: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The tables of blocks, links and forces by name."""
    found: dict[str, dict[str, Any]] = {}
    for kind in NAMED:
        entries = tables.get(kind)
        for entry in entries if isinstance(entries, list) else []:
            if isinstance(entry, dict):
                found.setdefault(str(entry.get("name", kind)), entry)
    return found


def _pair(tables: dict[str, Any], names: list[str]) -> dict[str, Any]:
    """The table of the pair of two names, which is added if it is not there."""
    entries = tables.setdefault("pair", [])
    if not isinstance(entries, list):
        raise SceneError("pair", shown(entries), "an array of tables, [[pair]]")
    for entry in entries:
        between = entry.get("between") if isinstance(entry, dict) else None
        if isinstance(between, list) and sorted(map(str, between)) == sorted(names):
            found: dict[str, Any] = entry
            return found
    entries.append({"between": names})
    return entries[-1]


def differing(one: Any, other: Any, path: str = "") -> set[str]:
    """Paths of the values that two tables do not share."""
    if isinstance(one, dict) and isinstance(other, dict):
        found = set()
        for key in one.keys() | other.keys():
            below = f"{path}.{key}" if path else key
            found |= differing(one.get(key), other.get(key), below)
        return found
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        both = zip(one, other, strict=True)
        pairs = [differing(a, b, f"{path}.{k + 1}") for k, (a, b) in enumerate(both)]
        return set().union(*pairs)
    return set() if one == other else {path}
