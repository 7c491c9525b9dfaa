"""Write the generated tables of docs/output.md and docs/scene.md: `make docs-tables`.

The columns of a history come from `solver.history.columns`; the keys of a scene from the fields of
the specifications in `solver.scene`: their types say what is allowed, the text after a field what
it means, and behind "Default:" what happens where the key is left out. A table stands in a page
between the comments `<!-- generated: NAME -->` and `<!-- end of generated table -->`.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from textwrap import dedent
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from solver import scene
from solver.history.events import Event
from solver.history.pairs import MEANING
from solver.history.table import TABLE, Column
from solver.scene import Scene, foundation, motion, output
from solver.scene.cells import SHAPES
from solver.scene.checking import key_of, shown
from solver.scene.quantities import Cell

PAGES = tuple(Path(__file__).with_name(name) for name in ("output.md", "scene.md"))

END = "<!-- end of generated table -->"

MARKED = re.compile(rf"(<!-- generated: (?P<name>[^>]+?) -->\n).*?({END})", re.DOTALL)
"""A table with the comments before and after it."""

OF_KINDS = ("kind", "vertical", "second")
"""Keys that stand once for all kinds, in the table of `[foundation]` or `[motion]` itself."""

COLUMNS = {
    "columns of the run": lambda column: column.part == "run",
    "columns of a block in the plane": lambda column: in_block(column, 2),
    "columns of a block in space": lambda column: in_block(column, 3),
    "columns of the platform": lambda column: column.part == "platform",
    "columns of a link": lambda column: column.part == "link",
    "columns of a foot": lambda column: column.part == "foot",
    "columns of a structure": lambda column: column.part in ("foundation", "storey", "column"),
    "columns of the energies": lambda column: column.part == "energy",
}
"""Which columns stand in which table of docs/output.md."""


def in_block(column: Column, dimension: int) -> bool:
    """True if a column belongs to the blocks of a dimension."""
    return column.part == "block" and column.dimension in (None, dimension)


def table(heads: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    head, *body = [f"| {' | '.join(cells)} |\n" for cells in (heads, *rows)]
    return "".join([head, "|---" * len(heads), "|\n", *body])


def columns_table(name: str) -> str:
    """A table of columns of the history, of the events or of the pairs."""
    if name == "columns of the events":
        cells = texts(Event)
    elif name == "columns of the pairs":
        cells = MEANING
    else:
        return history_table(name)
    return table(("column", "meaning"), ((f"`{key}`", text) for key, text in cells.items()))


def history_table(name: str) -> str:
    """A table of columns of the history."""
    chosen = [column for column in TABLE if COLUMNS[name](column)]
    rows = ((f"`{column.name}`", column.unit, column.meaning) for column in chosen)
    return table(("column", "unit", "meaning"), rows)


def texts(cls: Any) -> dict[str, str]:
    """The text after each field of a specification, by the name of the field, in one line each."""
    found = texts(cls.__base__) if is_dataclass(cls.__base__) else {}
    (tree,) = ast.parse(dedent(inspect.getsource(cls))).body
    assert isinstance(tree, ast.ClassDef)
    for field, text in zip(tree.body, tree.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr):
            assert isinstance(field.target, ast.Name) and isinstance(text.value, ast.Constant)
            found[field.target.id] = " ".join(str(text.value.value).split())
    return found


def members(hint: Any) -> list[Any]:
    """The members of a union without None, else the type alone."""
    union = get_origin(hint) in (Union, UnionType)
    return [part for part in (get_args(hint) if union else [hint]) if part is not NoneType]


def number(hint: Any, key: str) -> str:
    """Allowed values of a number, in words."""
    kind, range_ = get_args(hint)
    words = range_.words(key).removeprefix(f"{key} ")
    words = words if words == "a finite number" else f"`{words}`"
    return f"a whole number {words}" if kind is int else words


def allowed(hint: Any, key: str) -> str:
    """Allowed values of a key, in words."""
    if hint == Cell:
        plane, space = (", ".join(f"`{shown(name)}`" for name in SHAPES[d]) for d in (2, 3))
        return f"{plane}; 3-D: {space}"
    parts = members(hint)
    tuples = [get_args(part) for part in parts if get_origin(part) is tuple]
    if all(is_dataclass(part) for part in parts):
        return "a table"
    if len(tuples) == 2 and get_origin(parts[0]) is Annotated:
        return f"{number(parts[0], key)}; 3-D: 3 values, or a table of 3 x 3"
    if len(tuples) == 2:
        counts = [f"{len(items)} value{'s' * (len(items) > 1)}" for items in tuples]
        return f"{counts[0]}, 3-D: {len(tuples[1])}, each {number(tuples[0][0], key)}"
    if len(parts) == 2:
        first, other = parts
        if is_dataclass(first):
            return "a table, or an array of tables"
        if first is str:
            return f"a text, or {allowed_one(other, key)}"
        if get_origin(other) is Literal:
            return f"{number(first, key)}, {allowed_one(other, key)}"
        if get_origin(other) is tuple and is_dataclass(get_args(other)[0]):
            return f"{number(first, key)}, or an array of tables"
        if is_dataclass(other) or other is str:
            return f"{number(first, key)}, or {allowed_one(other, key)}"
        return f"{number(first, key)}; 3-D: {len(get_args(other))} values"
    return allowed_one(parts[0], key)


def allowed_one(hint: Any, key: str) -> str:
    """Allowed values of a key that is no union, in words."""
    origin = get_origin(hint)
    if origin is tuple:
        items = get_args(hint)
        if is_dataclass(items[0]):
            return "an array of tables, one or more"
        if items[-1] is Ellipsis:
            return f"an array, each {allowed_one(items[0], key)}"
        words = dict.fromkeys(allowed_one(item, key) for item in items)  # equal ones once
        return f"{len(items)} values, {'each ' * (len(words) == 1)}{' and '.join(words)}"
    if origin is Literal:
        return ", ".join(f"`{shown(word)}`" for word in get_args(hint))
    if origin is Annotated:
        return number(hint, key)
    if is_dataclass(hint):
        return "a table"
    return {bool: "`true`, `false`", str: "a text", Path: "the name of a file"}[hint]


def key_row(cls: Any, field: Field[Any]) -> tuple[str, ...]:
    """The row of a key: its name, its default, what is allowed, what it means.

    Raises:
        ValueError: Names the field whose text is missing, or does not say the default.
    """
    key, hint = key_of(field), get_type_hints(cls, include_extras=True)[field.name]
    where = f"{cls.__name__}.{field.name}"
    meaning, _, words = texts(cls).get(field.name, "").partition(" Default: ")
    if not meaning:
        raise ValueError(f"{where}: no text after the field says what it means")
    if field.default is field.default_factory is MISSING:
        default = "required"
    elif words or field.default in (None, MISSING):
        default = words.removesuffix(".")
        if not default:
            raise ValueError(f'{where}: no "Default: ..." in the text after the field')
    else:
        default = f"`{shown(field.default)}`"
    return f"`{key}`", default, allowed(hint, key), meaning.removesuffix(".")


def keys_table(cls: Any) -> str:
    """The table of the keys of a specification, without those that all its kinds share."""
    hints = get_type_hints(cls, include_extras=True)
    shared = OF_KINDS if len(get_args(hints.get("kind"))) == 1 else ()
    rows = (key_row(cls, field) for field in fields(cls) if field.name not in shared)
    return table(("key", "default", "allowed", "meaning"), rows)


def kinds_table(field: str) -> str:
    """The table of the keys that all kinds of foundations or motions share."""
    kinds = members(get_type_hints(Scene, include_extras=True)[field])
    names = [next(f.default for f in fields(cls) if f.name == "kind") for cls in kinds]
    meanings = [texts(cls)["kind"].removesuffix(".") for cls in kinds if "kind" in texts(cls)]
    listed = ", ".join(f"`{shown(name)}`" for name in names)
    joined = "; ".join([meanings[0], *(text[0].lower() + text[1:] for text in meanings[1:])])
    first = ("`kind`", f"`{shown(names[0])}`", listed, joined)
    others = [f for f in fields(kinds[0]) if f.name in OF_KINDS and f.name != "kind"]
    rows = (key_row(kinds[0], other) for other in others)
    return table(("key", "default", "allowed", "meaning"), iter([first, *rows]))


def specification(name: str) -> Any:
    """A class of a scene's tables by its name."""
    return next(
        getattr(home, name) for home in (scene, foundation, motion, output) if hasattr(home, name)
    )


def generated(name: str) -> str:
    """A table by the name that its comment gives it."""
    if name.startswith("columns of "):
        return columns_table(name)
    if name.startswith("kinds of "):
        return kinds_table(name.removeprefix("kinds of "))
    return keys_table(specification(name.removeprefix("keys of ")))


def with_tables(text: str) -> str:
    """A page with all its tables as they are generated."""
    return MARKED.sub(lambda found: f"{found[1]}\n{generated(found['name'])}\n{found[3]}", text)


def main() -> None:
    """Write the pages."""
    for page in PAGES:
        page.write_text(with_tables(page.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
