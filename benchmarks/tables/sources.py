"""Digests of what decides a table: equal where only words or the layout of a text differ."""

from __future__ import annotations

import ast
import hashlib
import json
import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

#: Digits of a digest.
LENGTH = 12

#: Digest of what is not there.
NOTHING = "-"

Digests = Mapping[str, str]


def digests(sources: Iterable[str], root: Path = ROOT) -> dict[str, str]:
    """Digest of each file or folder of Python sources, by its path in the repository."""
    return {name: _digest(root, name) for name in sources}


def forget() -> None:
    """Read the sources anew the next time."""
    _digest.cache_clear()


def of_bytes(file: Path) -> str:
    """Digest of a file as it is; `NOTHING` where there is none."""
    return _short(file.read_bytes()) if file.is_file() else NOTHING


def of_python(text: str) -> str:
    """Digest of what a Python source does: comments, docstrings and layout have no part in it."""
    return _short(_shown(ast.parse(text)).encode())


def of_toml(text: str) -> str:
    """Digest of what a TOML file says, without its comments."""
    return _short(json.dumps(tomllib.loads(text), sort_keys=True, default=str).encode())


def differing(before: Digests, now: Digests) -> list[str]:
    """Sources whose digests differ."""
    return sorted(name for name in {*before, *now} if before.get(name) != now.get(name))


@cache
def _digest(root: Path, name: str) -> str:
    """Digest of a file, or of all Python sources in a folder with their places."""
    place = root / name
    if place.is_dir():
        files = sorted(file.relative_to(root).as_posix() for file in place.rglob("*.py"))
        return _short("\n".join(f"{file} {_digest(root, file)}" for file in files).encode())
    if not place.is_file():
        return NOTHING
    if place.suffix == ".py":
        return of_python(place.read_text("utf-8"))
    if place.suffix == ".toml":
        return of_toml(place.read_text("utf-8"))
    return of_bytes(place)


def _short(content: bytes) -> str:
    """The first digits of a digest."""
    return hashlib.sha256(content).hexdigest()[:LENGTH]


def _shown(node: object) -> str:
    """A syntax tree as text, the same from every version of Python: without what is empty."""
    if isinstance(node, list):
        return f"[{','.join(_shown(part) for part in node if not _is_text(part))}]"
    if not isinstance(node, ast.AST):
        return repr(node)
    if isinstance(node, ast.JoinedStr):  # Python 3.12 cuts its texts elsewhere
        return f"JoinedStr({_joined(node.values)})"
    there = ((name, value) for name, value in ast.iter_fields(node) if value not in (None, []))
    return f"{type(node).__name__}({','.join(f'{name}={_shown(value)}' for name, value in there)})"


def _joined(parts: list[ast.expr]) -> str:
    """The parts of an f-string, with its texts in as few pieces as there can be."""
    pieces: list[tuple[bool, str]] = []
    for part in parts:
        plain = isinstance(part, ast.Constant)
        shown = str(part.value) if isinstance(part, ast.Constant) else _shown(part)
        before = pieces.pop()[1] if plain and pieces and pieces[-1][0] else ""
        pieces.append((plain, before + shown))
    return repr([piece for piece in pieces if piece[1]])


def _is_text(node: object) -> bool:
    """Whether a statement is a docstring, or the text after a field."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
