"""The text of a scene to plain tables, and single values of it set from the command line."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from solver.errors import SceneError, UnknownKey
from solver.scene.checking import nearest, shown

BARE = r"[-+]?(?:\.\d+|\d+\.)(?:[eE][-+]?\d+)?"
"""Numbers that have no digit before or after their point, which TOML does not allow."""


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


def override(tables: dict[str, Any], text: str, known: Sequence[str]) -> None:
    """Set one value, `path=value`, in the tables of a scene; a block is addressed by its name."""
    path, equals, value = text.partition("=")
    *parents, key = [part.strip() for part in path.split(".")]
    if not equals or not key or not all(parents):
        raise SceneError("--set", shown(text), "path=value, such as block.height=1.2")
    blocks = _blocks(tables)
    allowed = [*blocks, *(key for key in known if key != "block")]
    table: Any = tables
    for depth, parent in enumerate(parents):
        if depth == 0 and parent in blocks:
            table = blocks[parent]
            continue
        if depth == 0 and parent not in allowed:
            raise UnknownKey(parent, parent, ", ".join(allowed), nearest(parent, allowed))
        table = table.setdefault(parent, {})
        if not isinstance(table, dict):
            raise SceneError(f"--set {path}", f"{parent}, which is no table", "the path of a key")
    table[key] = _toml_value(value.strip())


def _blocks(tables: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The tables of the blocks by name."""
    entries = tables.get("block")
    entries = entries if isinstance(entries, list) else []
    return {str(entry.get("name", "block")): entry for entry in entries if isinstance(entry, dict)}


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
