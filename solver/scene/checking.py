"""Tables of plain values <-> dataclasses, strictly: the types of the fields say what is allowed.

Understood are `bool`, `str`, `Path`, `Literal[...]`, `Annotated[float, Number(...)]` and the same
with `int`, tuples of these, dataclasses, tuples of dataclasses, `... | None`, and unions: of
dataclasses that differ by their `kind`, of tuples of different lengths, of a number and a
tuple or a dataclass.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeGuard, Union, get_args, get_origin, get_type_hints

from solver.errors import SceneError, UnknownKey, below, missing_key, not_applicable

#: Default of a field that is resolved once the rest is known; its type need not admit None.
OPEN: Any = None


def is_open(value: object) -> bool:
    """True if a value is still to be resolved."""
    return value is OPEN


def shown(value: Any) -> str:
    """A value as TOML would have it, in one short line."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        text = f"[{', '.join(shown(item) for item in value)}]"
    else:
        text = f'"{value}"' if isinstance(value, str | Path) else str(value)
    text = " ".join(text.split())
    return text if len(text) <= 60 else f"{text[:56]} ..."


def nearest(word: str, words: Iterable[str]) -> str | None:
    """The one of `words` that a misspelt word was meant to be."""
    from difflib import get_close_matches

    return next(iter(get_close_matches(word, list(words), n=1)), None)


class Checked:
    """Base of the frozen dataclasses that are checked and resolved when an instance is made."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Bring every field to its type, resolve what is open, and check the whole.

        Raises:
            SceneError: Names the key, the value, and what is allowed.
        """
        cls: Any = type(self)  # mypy takes a class for unhashable
        for field, hint in fields_of(cls):
            value = getattr(self, field.name)
            if value is not None or field.default is not None:
                object.__setattr__(self, field.name, _checked(hint, value, key_of(field)))
        for name, value in self.resolved():
            object.__setattr__(self, name, value)
        self.check()

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """The fields that are open and their values, which may depend on those before them."""
        return iter(())

    def check(self) -> None:
        """Refuse values that do not go together: SceneError."""


def exactly_one(spec: Any, *names: str) -> None:
    """Refuse a specification of which not exactly one of these fields has a value."""
    given = [name for name in names if getattr(spec, name) is not None]
    wanted = f"exactly one of {' and '.join(names)}"
    if not given:
        raise missing_key(names[0], f"({wanted})")
    if len(given) > 1:
        raise SceneError(names[0], f"{'both ' * (len(given) == 2)}{' and '.join(given)}", wanted)


def only_where(spec: Any, applies: object, what: str, *names: str) -> None:
    """Refuse fields with other values than their defaults where they do not apply.

    `what` follows "applies to".
    """
    cls: Any = type(spec)
    for field, _ in fields_of(cls) if not applies else ():
        if field.name in names and getattr(spec, field.name) not in (field.default, None, ()):
            raise not_applicable(key_of(field), what)


def refuse_other_dimension(spec: Any, dimension: int) -> None:
    """Refuse values of a specification, and of those in it, that are not of a scene's dimension.

    A field of two alternatives, in the plane and in space, says so by its type: vectors of 2 or 3
    values, places along 1 or 2 axes, a rotation as a number or 3 values.
    """
    cls: Any = type(spec)
    for field, hint in fields_of(cls):
        key, value, choices = key_of(field), getattr(spec, field.name), choices_of(hint)
        members = value if isinstance(value, tuple) else (value,)
        for number, member in enumerate(members, start=1):
            if dataclasses.is_dataclass(member):
                own = getattr(member, "name", f"{key}.{number}")
                with below(own if members is value else key):
                    refuse_other_dimension(member, dimension)
        counts = [len(get_args(each)) if get_origin(each) is tuple else 0 for each in choices]
        if value is None or counts not in ([2, 3], [1, 2], [0, 3]):
            continue
        if counts[dimension - 2] != (len(value) if members is value else 0):
            words = _words(choices[dimension - 2], key) + "," * (counts[dimension - 2] > 0)
            raise SceneError(key, shown(value), f"{words} where dimension = {dimension}")


def from_table(cls: Any, table: Any, where: str = "") -> Any:
    """An instance of a dataclass from a table that stands at key path `where`."""
    if not isinstance(table, Mapping):
        raise SceneError(where, shown(table), "a table")
    known = {key_of(field): (field, hint) for field, hint in fields_of(cls)}
    for key in table:
        if key not in known:
            raise UnknownKey(_join(where, key), key, ", ".join(known), nearest(key, known))
    values = {}
    for key, (field, hint) in known.items():
        if key in table:
            values[field.name] = _nested(hint, table[key], _join(where, key))
        elif field.default is field.default_factory is dataclasses.MISSING:
            raise missing_key(_join(where, key), f"({_words(hint, key)})")
    with below(where):
        return cls(**values)


def to_table(instance: Any) -> dict[str, Any]:
    """The inverse of `from_table`, without None, which TOML has not, and without empty arrays."""
    pairs = ((key_of(f), getattr(instance, f.name)) for f in dataclasses.fields(instance))
    return {key: _plain(value) for key, value in pairs if value is not None and value != ()}


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return to_table(value)
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def _join(where: str, key: str) -> str:
    return f"{where}.{key}" if where else key


@cache
def fields_of(cls: Any) -> tuple[tuple[dataclasses.Field[Any], Any], ...]:
    """The fields of a dataclass with their types."""
    hints = get_type_hints(cls, include_extras=True)
    return tuple((field, hints[field.name]) for field in dataclasses.fields(cls))


def key_of(field: dataclasses.Field[Any]) -> str:
    """The TOML key of a field: that of its metadata, or its name."""
    return str(field.metadata.get("key", field.name))


def choices_of(hint: Any) -> list[Any]:
    """The members of a union without None, else the type alone."""
    union = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return [choice for choice in union if choice is not NoneType]


def _nested(hint: Any, value: Any, where: str) -> Any:
    """Tables inside a table; other values are left for `_checked`."""
    choices = choices_of(hint)
    tables = [choice for choice in choices if dataclasses.is_dataclass(choice)]
    if tables and (isinstance(value, Mapping) or len(tables) == len(choices)):
        return _table(tables, value, where)
    arrays = [get_args(choice)[0] for choice in choices if get_origin(choice) is tuple]
    item = next(iter(arrays), None)
    if not dataclasses.is_dataclass(item) or (len(choices) > 1 and not isinstance(value, list)):
        return value
    if not isinstance(value, list):
        raise SceneError(where, shown(value), f"an array of tables, [[{where}]]")
    # A member of an array of tables is addressed by its name or names, here as in overrides.
    cls: Any = item
    named = any(key_of(field) == "name" for field, _ in fields_of(cls))
    return tuple(from_table(item, entry, _name(entry, where, named=named)) for entry in value)


def _name(entry: Any, where: str, *, named: bool) -> str:
    """The name of a member of the array of tables `where`; without a valid one, that of all.

    A member that is `between` two bodies and has no key for a name has both names behind that of
    the array.
    """
    if not isinstance(entry, Mapping):
        return where
    names = entry.get("between")
    if not named and isinstance(names, list) and len(names) == 2 and all(map(_is_name, names)):
        return ".".join([where, *names])
    name = entry.get("name")
    return name if _is_name(name) else where


def _is_name(value: Any) -> TypeGuard[str]:
    """True if a value may stand in a path as the name of a body."""
    return isinstance(value, str) and re.fullmatch(r"[\w-]{1,100}", value) is not None


def _table(classes: list[Any], value: Any, where: str) -> Any:
    """A table that may be of several kinds; without `kind` the first, if it has all its keys."""
    first, *others = classes
    keys = {key_of(field) for field, _ in fields_of(first)} - {"kind"}
    if not others or not isinstance(value, Mapping) or set(value) <= keys:
        return from_table(first, value, where)
    kinds = {dict(_defaults(table))["kind"]: table for table in classes}
    choice, place = Literal[tuple(kinds)], _join(where, "kind")
    if "kind" not in value:
        raise missing_key(place, f"({_words(choice, 'kind')})")
    return from_table(kinds[_checked(choice, value["kind"], place)], value, where)


def _defaults(cls: Any) -> Iterator[tuple[str, Any]]:
    return ((field.name, field.default) for field, _ in fields_of(cls))


def _words(hint: Any, name: str) -> str:
    """The values that a field may have, in words."""
    choices = choices_of(hint)
    if all(get_origin(choice) is tuple for choice in choices):
        items = [get_args(choice) for choice in choices]
        if dataclasses.is_dataclass(items[0][0]):
            return f"an array of tables, [[{name}]]"
        if items[0][-1] is Ellipsis:
            return f"an array, each {_words(items[0][0], name)}"
        lengths = " or ".join(str(len(item)) for item in items)
        words = list(dict.fromkeys(_words(item, name) for item in items[0]))
        each = "each " * (len(words) == 1 and lengths != "1")
        return f"{lengths} value{'s' * (lengths != '1')}, {each}{' and '.join(words)}"
    return " or ".join(dict.fromkeys(_words_of_one(choice, name) for choice in choices))


def _words_of_one(hint: Any, name: str) -> str:
    if dataclasses.is_dataclass(hint):
        return "a table"
    if get_origin(hint) is Annotated:
        kind, rule = get_args(hint)
        return f"{'a whole number, ' * (kind is int)}{rule.words(name)}"
    if get_origin(hint) is Literal:
        return " or ".join(map(shown, get_args(hint)))
    if get_origin(hint) is tuple:
        return _words(hint, name)
    return {bool: "true or false", str: "a text", Path: "the name of a file"}[hint]


def _checked(hint: Any, value: Any, name: str) -> Any:
    """A value brought to the type of its field, or a SceneError."""
    choices = choices_of(hint)
    if isinstance(value, list | tuple):
        return _checked_tuple(choices, value, _words(hint, name), name)
    for choice in choices:
        if _fits(choice, value):
            return _converted(choice, value, name)
    words = [word for choice in choices for word in get_args(choice) if isinstance(word, str)]
    meant = nearest(value, words) if isinstance(value, str) else None
    allowed = _words(hint, name)
    numeric = all(get_origin(choice) is Annotated for choice in choices)
    if numeric and not _is_number(value) and "number" not in allowed:
        allowed = f"a number, {allowed}"
    raise SceneError(name, shown(value), allowed, meant)


def _is_number(value: Any, kind: type[Any] = float) -> bool:
    """True if a value is a number of a kind; true and false are none."""
    return isinstance(value, Integral if kind is int else Real) and not isinstance(value, bool)


def _fits(hint: Any, value: Any) -> bool:
    """True if a value that is no array has a type."""
    if get_origin(hint) is Annotated:
        kind, rule = get_args(hint)
        return _is_number(value, kind) and bool(rule.holds(value))
    if get_origin(hint) is Literal:
        # 1 == True == 1.0 in Python, not in TOML
        return any(type(value) is type(word) and value == word for word in get_args(hint))
    return get_origin(hint) is not tuple and isinstance(
        value, (str, Path) if hint is Path else hint
    )


def _converted(hint: Any, value: Any, name: str) -> Any:
    """A value that fits, as its type; a number beyond all use is refused."""
    if get_origin(hint) is Annotated:
        kind, rule = get_args(hint)
        rule.refuse_extreme(name, value)
        return kind(value)
    return Path(value) if hint is Path else value


def _checked_tuple(choices: Iterable[Any], value: Any, words: str, name: str) -> tuple[Any, ...]:
    """An array, as the first of several types of tuples that has its length."""
    for items in (get_args(choice) for choice in choices if get_origin(choice) is tuple):
        if items[-1] is Ellipsis:
            return tuple(_checked(items[0], entry, name) for entry in value)
        if len(items) == len(value):
            try:
                return tuple(_checked(*pair, name) for pair in zip(items, value, strict=True))
            except SceneError:
                continue  # another one may have as many
    raise SceneError(name, shown(value), words)
