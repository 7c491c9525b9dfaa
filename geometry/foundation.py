"""Shapes of the bodies that carry the blocks."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from solver.types import Array


def face_frame(normal: Array) -> Array:
    """Rows normal and tangents of a face with an outward unit normal, (d, d).

    In the plane the tangent is the normal turned clockwise: +x on a top. In space the frame is
    right-handed, and the first tangent is what of +x is in the face, or of +y where the normal is
    along x.
    """
    if len(normal) == 2:
        return np.array([normal, [normal[1], -normal[0]]]) + 0.0
    axis = np.eye(3)[1 if abs(normal[0]) > 0.5 else 0]
    first = axis - (axis @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([normal, first, np.cross(normal, first)]) + 0.0


def level_frame(dimension: int, up: float = 1.0) -> Array:
    """Rows normal and tangents of a level face that points up, or down with `up` = -1, (d, d)."""
    return face_frame(up * np.eye(dimension)[-1])


def _refuse_what_is_not_positive(shape: Plate | Frame, names: tuple[str, ...]) -> None:
    """Lengths are finite and > 0."""
    for name in names:
        value = getattr(shape, name)
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{type(shape).__name__}.{name}: got {value}, allowed a number > 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Plate:
    """An elastic plate that blocks stand on; origin at the centre of its top."""

    width: float
    """W, m, > 0; along x."""
    height: float
    """h, m, > 0; from -h to 0."""
    thickness: float = 1.0
    """t, m, > 0; across the plane of motion."""

    def __post_init__(self) -> None:
        """Refuse what is no plate."""
        _refuse_what_is_not_positive(self, tuple(field.name for field in fields(self)))

    @property
    def volume(self) -> float:
        """W h t, m^3."""
        return self.width * self.height * self.thickness


class Storey(NamedTuple):
    """A storey below the uppermost one of a frame."""

    columns: float
    """Height of its columns, m."""
    deck: float
    """Height of its deck, m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A deck on columns that are fixed at their feet; origin at the centre of the deck's top.

    In the plane the columns are as thick as the deck. In space the deck stands on four of them, one
    under each corner (one bay).
    """

    deck: Plate
    """The deck."""
    column_width: float
    """Width of a column along x, m, > 0."""
    storey: float
    """Length of the columns, from their feet to the underside of the deck, m, > 0."""
    below: tuple[Storey, ...] = ()
    """Storeys below, from the ground upwards; all decks are of one width and thickness."""
    bays: int = 1
    """Spaces between columns, >= 1: bays + 1 columns, at equal distances, the outer ones flush."""
    column_thickness: float | None = None
    """Thickness of a column across the plane of motion, m, > 0, in space; None: as its width."""

    def __post_init__(self) -> None:
        """Refuse what is no frame."""
        _refuse_what_is_not_positive(self, ("column_width", "storey"))
        if self.bays < 1:
            raise ValueError(f"Frame.bays: got {self.bays}, allowed a whole number >= 1")
        if not self.bay > 0:
            raise ValueError(
                f"Frame.column_width: got {self.column_width}, allowed less than"
                f" {self.deck.width / (self.bays + 1)}: the columns leave no bay under the deck"
            )
        if self.column_thickness is not None and not (
            0 < 2 * self.column_thickness < self.deck.thickness
        ):
            raise ValueError(
                f"Frame.column_thickness: got {self.column_thickness}, allowed more than 0 and less"
                f" than half the deck's {self.deck.thickness}"
            )

    @property
    def levels(self) -> Array:
        """Levels at which columns or decks end, from the feet up to the top at 0, m."""
        storeys = [*self.below, Storey(self.storey, self.deck.height)]
        heights = [part for storey in storeys for part in storey]
        upwards: Array = np.concatenate([np.cumsum(heights[::-1])[::-1] * -1.0, [0.0]])
        return upwards

    @property
    def bay(self) -> float:
        """Clear distance between two columns, m."""
        return (self.deck.width - (self.bays + 1) * self.column_width) / self.bays
