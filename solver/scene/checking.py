"""Tables of plain values <-> dataclasses, strictly: the types of the fields say what is allowed.

Understood are `bool`, `str`, `Path`, `Literal[...]`, `Annotated[float, Number(...)]` and the same
with `int`, tuples of these, dataclasses, tuples of dataclasses, `... | None`, and unions: of
dataclasses that are told apart by their `kind`, of tuples of different lengths, of a number and a
tuple or a dataclass.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from solver.errors import SceneError, UnknownKey, missing_key
from solver.scene.extremes import refuse_extreme

#: Default of a field that is filled in later, by who knows more; its type need not admit None.
OPEN: Any = None


def is_open(value: object) -> bool:
    """Whether a value is still to be filled in."""
    return value is OPEN


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """The range of a number; never infinite, never NaN."""

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None

    def holds(self, value: Any) -> bool:
        """Whether a number lies in the range."""
        return bool(
            abs(value) <= sys.float_info.max  # false for NaN and for integers beyond any float
            and (self.above is None or value > self.above)
            and (self.at_least is None or value >= self.at_least)
            and (self.below is None or value < self.below)
            and (self.at_most is None or value <= self.at_most)
        )

    def words(self, name: str) -> str:
        """The range in symbols, such as `0 <= poisson < 0.5`."""
        low, high = self.above, self.below
        left = f"{low:g} < " if low is not None else ""
        right = f" < {high:g}" if high is not None else ""
        if self.at_least is not None:
            left = f"{self.at_least:g} <= "
        if self.at_most is not None:
            right = f" <= {self.at_most:g}"
        if left and not right:
            return f"{name} {'>=' if '=' in left else '>'} {left.split()[0]}"
        return f"{left}{name}{right}" if left or right else "a finite number"


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
    """Base of the frozen dataclasses whose fields are checked when an instance is made."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Check every field and bring it to its type."""
        cls: Any = type(self)
        hints = _hints(cls)
        for field in _fields(cls):
            value = getattr(self, field.name)
            if value is None and field.default is None:
                continue
            checked = _checked(hints[field.name], value, key_of(field))
            refuse_extreme(field.name, checked)
            object.__setattr__(self, field.name, checked)


def exactly_one(spec: Any, *names: str) -> None:
    """Refuse a specification of which not exactly one of these fields has a value."""
    given = [name for name in names if getattr(spec, name) is not None]
    wanted = f"exactly one of {' and '.join(names)}"
    if not given:
        raise missing_key(names[0], f"({wanted})")
    if len(given) > 1:
        raise SceneError(names[0], f"{'both ' * (len(given) == 2)}{' and '.join(given)}", wanted)


def from_table(cls: Any, table: Any, where: str = "") -> Any:
    """An instance of a dataclass from a table that stands at key path `where`."""
    if not isinstance(table, Mapping):
        raise SceneError(where, shown(table), "a table")
    keys = {key_of(field): field for field in _fields(cls)}
    for key in table:
        if key not in keys:
            raise UnknownKey(_join(where, key), key, ", ".join(keys), nearest(key, keys))
    values = {}
    for key, field in keys.items():
        hint = _hints(cls)[field.name]
        if key in table:
            values[field.name] = _nested(hint, table[key], _join(where, key))
        elif field.default is field.default_factory is dataclasses.MISSING:
            raise missing_key(_join(where, key), f"({_words(hint, key)})")
    try:
        return cls(**values)
    except SceneError as error:
        raise error.under(where) from None


def to_table(instance: Any) -> dict[str, Any]:
    """The inverse of `from_table`; what is None is left out, as TOML knows no such value."""
    table = {}
    for field in dataclasses.fields(instance):
        value = getattr(instance, field.name)
        if value is not None:
            table[key_of(field)] = _plain(value)
    return table


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return to_table(value)
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def _join(where: str, key: str) -> str:
    return f"{where}.{key}" if where else key


@cache
def _hints(cls: type[Any]) -> dict[str, Any]:
    return get_type_hints(cls, include_extras=True)


def _fields(cls: Any) -> tuple[dataclasses.Field[Any], ...]:
    return dataclasses.fields(cls)


def key_of(field: dataclasses.Field[Any]) -> str:
    """The TOML key of a field: its name, or what its metadata says."""
    return str(field.metadata.get("key", field.name))


def _choices(hint: Any) -> tuple[Any, ...]:
    """The members of a union, else the type alone."""
    return get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)


def _nested(hint: Any, value: Any, where: str) -> Any:
    """Tables inside a table; other values are left for `_checked`."""
    choices = [choice for choice in _choices(hint) if choice is not NoneType]
    tables = [choice for choice in choices if dataclasses.is_dataclass(choice)]
    if tables and (isinstance(value, Mapping) or len(tables) == len(choices)):
        return _table(tables, value, where)
    arrays = [get_args(choice)[0] for choice in choices if get_origin(choice) is tuple]
    item = next(iter(arrays), None)
    if not dataclasses.is_dataclass(item) or (len(choices) > 1 and not isinstance(value, list)):
        return value
    if not isinstance(value, list):
        raise SceneError(where, shown(value), f"an array of tables, [[{where}]]")
    # A member of an array of tables is addressed by its name, here as in overrides.
    return tuple(_member(item, entry, where) for entry in value)


def _member(cls: Any, entry: Any, where: str) -> Any:
    """A member of the array of tables `where`; a name that cannot be names nobody."""
    name = _name(entry, where)
    try:
        return from_table(cls, entry, name)
    except SceneError as error:
        if type(error) is SceneError and error.where == f"{name}.name":
            raise SceneError(f"{where}.name", error.got, error.allowed, error.nearest) from None
        raise


def _name(entry: Any, where: str) -> str:
    name = entry.get("name", where) if isinstance(entry, Mapping) else where
    return name if isinstance(name, str) and name else where


def _table(classes: list[Any], value: Any, where: str) -> Any:
    """A table that may be of several kinds; without `kind` the first, if it has all its keys."""
    if not isinstance(value, Mapping):
        raise SceneError(where, shown(value), "a table")
    first, *others = classes
    if not others or set(value) <= {key_of(field) for field in _fields(first)} - {"kind"}:
        return from_table(first, value, where)
    kinds = {get_args(_hints(table)["kind"])[0]: table for table in classes}
    choice, place = Literal[tuple(kinds)], _join(where, "kind")
    if "kind" not in value:
        raise missing_key(place, f"({_words(choice, 'kind')})")
    kind = _checked(choice, value["kind"], place)
    return from_table(kinds[kind], value, where)


def _words(hint: Any, name: str) -> str:
    """What a field may hold, in words."""
    choices = [choice for choice in _choices(hint) if choice is not NoneType]
    if all(get_origin(choice) is tuple for choice in choices):
        return _words_of_tuples([get_args(choice) for choice in choices], name)
    return " or ".join(dict.fromkeys(_words_of_one(choice, name) for choice in choices))


def _words_of_tuples(items: list[tuple[Any, ...]], name: str) -> str:
    if dataclasses.is_dataclass(items[0][0]):
        return f"an array of tables, [[{name}]]"
    lengths = " or ".join(str(len(item)) for item in items)
    return f"{lengths} values, each {_words(items[0][0], name)}"


def _words_of_one(hint: Any, name: str) -> str:
    origin = get_origin(hint)
    if dataclasses.is_dataclass(hint):
        return "a table"
    if origin is Annotated:
        kind, rule = get_args(hint)
        return f"a whole number, {rule.words(name)}" if kind is int else str(rule.words(name))
    if origin is Literal:
        return " or ".join(shown(value) for value in get_args(hint))
    if origin is tuple:
        return _words_of_tuples([get_args(hint)], name)
    return {bool: "true or false", str: "a text", Path: "the name of a file"}[hint]


def _checked(hint: Any, value: Any, name: str) -> Any:
    """A value brought to the type of its field, or a SceneError."""
    choices = _choices(hint)
    if value is None and NoneType in choices:
        return None
    choices = tuple(choice for choice in choices if choice is not NoneType)
    tables: tuple[Any, ...] = tuple(c for c in choices if dataclasses.is_dataclass(c))
    if isinstance(value, tables):
        return value
    if isinstance(value, list | tuple):
        return _checked_tuple(choices, value, _words(hint, name), name)
    for choice in choices:
        fits, converted = _brought(choice, value)
        if fits:
            return converted
    words = [word for choice in choices for word in get_args(choice) if isinstance(word, str)]
    meant = nearest(value, words) if isinstance(value, str) else None
    allowed = _words(hint, name)
    if _is_no_number(choices, value) and "number" not in allowed:
        allowed = f"a number, {allowed}"
    raise SceneError(name, shown(value), allowed, meant)


def _is_no_number(choices: Iterable[Any], value: Any) -> bool:
    """Whether a number is asked for, and something else stands there."""
    numeric = all(get_origin(choice) is Annotated for choice in choices)
    return numeric and (not isinstance(value, Real) or isinstance(value, bool))


def _brought(hint: Any, value: Any) -> tuple[bool, Any]:
    """Whether a value that is no array has this type, and the value brought to it."""
    origin = get_origin(hint)
    if origin is Annotated:
        kind, rule = get_args(hint)
        number = isinstance(value, Integral if kind is int else Real)
        fits = number and not isinstance(value, bool) and rule.holds(value)
        return fits, kind(value) if fits else value
    if origin is Literal:
        # 1 == True == 1.0 in Python, not in TOML
        return any(type(value) is type(word) and value == word for word in get_args(hint)), value
    if origin is tuple or dataclasses.is_dataclass(hint):
        return False, value
    fits = isinstance(value, (str, Path) if hint is Path else hint)
    return fits, Path(value) if fits and hint is Path else value


def _checked_tuple(choices: Iterable[Any], value: Any, words: str, name: str) -> tuple[Any, ...]:
    """An array, as the first of several types of tuples that has its length."""
    for items in (get_args(choice) for choice in choices if get_origin(choice) is tuple):
        if items[-1] is Ellipsis:
            return tuple(_checked(items[0], entry, name) for entry in value)
        if len(items) == len(value):
            try:
                return tuple(_checked(*pair, name) for pair in zip(items, value, strict=True))
            except SceneError:
                break
    raise SceneError(name, shown(value), words)
