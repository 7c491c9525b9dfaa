"""What is swept: the axes of a command line, their values, and the cases that these make."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from solver.errors import SceneError
from solver.excitation.layouts.text import number_in
from solver.scene.checking import shown
from solver.study.damping.axes import AXES, Axis, axis_called
from solver.study.damping.case import BaseScene, DampingCase

ALLOWED = "NAME or NAME=V1,V2,..., such as beta=0,1e-5,1e-4"


@dataclass(frozen=True, slots=True, kw_only=True)
class SweptValue:
    """One value of an axis, and its case.

    Attributes:
        axis: The axis.
        value: Its value.
        at: The value of the axis that the whole sweep is repeated for; None: there is none.
        case: Key of its case.
    """

    axis: Axis
    value: float
    at: float | None
    case: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A study's sweeps.

    Attributes:
        base: Key of the case of the scene as it is.
        values: All values, axis by axis.
        at: The axis that all is repeated for; None: there is none.
        cases: The cases to run, each once.
        left_out: Default values that the scene does not take, in words.
    """

    base: str
    values: tuple[SweptValue, ...]
    at: Axis | None
    cases: tuple[DampingCase, ...]
    left_out: tuple[str, ...]


def chosen_axes(words: Sequence[str], option: str) -> dict[str, tuple[float, ...]]:
    """Axes and values of a command line; an empty tuple stands for the default values.

    Args:
        words: Such as `beta=0,1e-5`, `tolerance` or `beta,tolerance`.
        option: What they were given to, for errors.
    """
    found: dict[str, tuple[float, ...]] = {}
    for word in words:
        names, equals, text = word.partition("=")
        values: tuple[float, ...] = ()
        if equals:
            numbers = [number_in(part) for part in text.split(",")]
            values = tuple(number for number in numbers if number is not None)
            if len(values) < len(numbers) or len(set(values)) < len(values):
                raise SceneError(option, shown(word), ALLOWED)
        several = [name.strip() for name in names.split(",")]
        for name in several:
            axis_called(name, option)
            if name in found or (equals and len(several) > 1):
                raise SceneError(option, shown(word), f"{ALLOWED}, each name once")
            found[name] = values
    return found


def sweep(base: BaseScene, of: Sequence[str], at: Sequence[str]) -> Sweep:
    """The sweeps that a command line asks for.

    Args:
        base: What is varied.
        of: Axes and values; none: all axes with their default values.
        at: One axis with the values for which all is repeated.
    """
    axes = chosen_axes(of, "--of") or dict.fromkeys(AXES, ())
    repeated = chosen_axes(at, "--at")
    if len(repeated) > 1 or repeated.keys() & axes.keys():
        raise SceneError("--at", shown(" ".join(at)), "one axis that is not swept itself")
    axis_at = AXES[next(iter(repeated))] if repeated else None
    own = base.case()
    cases, values, left_out = {own.key: own}, [], []
    for axis, value, asked in _values(base, axes, named=bool(of)):
        for other in _at_values(base, axis_at, repeated):
            before = [] if axis_at is None or other is None else [(axis_at, other)]
            try:
                case = base.case(*before, (axis, value))
            except SceneError as error:
                if asked:
                    raise
                left_out.append(f"{axis.name} {value:g}: {error}")
                continue
            cases.setdefault(case.key, case)
            values.append(SweptValue(axis=axis, value=value, at=other, case=case.key))
    return Sweep(
        base=own.key,
        values=tuple(sorted(values, key=_place)),
        at=axis_at,
        cases=tuple(cases.values()),
        left_out=tuple(left_out),
    )


def _values(
    base: BaseScene, axes: dict[str, tuple[float, ...]], *, named: bool
) -> Iterator[tuple[Axis, float, bool]]:
    """All axes with their values, and whether the command line asks for just that.

    Args:
        base: What is varied.
        axes: Names and values; without values the default ones.
        named: Whether the command line names the axes.
    """
    for name, values in axes.items():
        axis = AXES[name]
        for number, value in enumerate(values or axis.values(base.scene, base.block)):
            # Of an axis that is asked for by name, at least the first value has to be possible.
            yield axis, value, bool(values) or (named and number == 0)


def _at_values(
    base: BaseScene, axis: Axis | None, chosen: dict[str, tuple[float, ...]]
) -> tuple[float | None, ...]:
    """Values that all is repeated for; a single None where nothing is."""
    if axis is None:
        return (None,)
    return chosen[axis.name] or axis.values(base.scene, base.block)


def _place(swept: SweptValue) -> tuple[int, float, float]:
    """Place in the table: by axis, repetition and value."""
    order = list(AXES).index(swept.axis.name)
    return order, -1.0 if swept.at is None else swept.at, swept.value
