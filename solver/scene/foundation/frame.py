"""A meshed deck on columns: kind = "frame"."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import ClassVar, Literal, NamedTuple

from solver.errors import SceneError
from solver.scene.cells import SHAPES, mesh_size_in_words
from solver.scene.checking import OPEN, Checked, shown
from solver.scene.damping import DampingSpec, refuse_both_dampings
from solver.scene.foundation.base import Foundation, Lines, sway_damping, thickness_of
from solver.scene.material import Material, Plane
from solver.scene.ranges import Count, DampingRatio, Dimension, NotNegative, Positive, Ratio


@dataclass(frozen=True, slots=True, kw_only=True)
class DeckSpec(Checked):
    """The deck of a frame: `foundation.deck`."""

    width: Positive
    """Along x, from outside to outside of the outer columns, m."""
    height: Positive
    """Height, m."""
    thickness: Positive = OPEN
    """Along y, m; 2-D: no other than that of the blocks. Default: that of the blocks; 3-D:
    required."""
    young: Positive | None = None
    """Young's modulus E, Pa. Default: that of the frame."""
    poisson: Ratio | None = None
    """Poisson's ratio nu. Default: that of the frame."""
    density: Positive | None = None
    """rho, kg/m³. Default: that of the frame."""
    extra_mass: NotNegative = 0.0
    """Mass that is spread over the deck besides its own, kg: fixed to it, it moves and weighs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnSpec(Checked):
    """The columns of a frame: `foundation.column`."""

    width: Positive
    """Along x, m; less than the deck's over the number of columns."""
    thickness: Positive = OPEN
    """Along y, m; 2-D: no other than that of the blocks, 3-D: less than half of the deck's.
    Default: that of the blocks; 3-D: the width."""
    young: Positive | None = None
    """Young's modulus E, Pa. Default: that of the frame."""
    poisson: Ratio | None = None
    """Poisson's ratio nu. Default: that of the frame."""
    density: Positive | None = None
    """rho, kg/m³. Default: that of the frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoreySpec(Checked):
    """A storey of a frame, from the ground upwards: `[[foundation.storey]]`."""

    height: Positive
    """Height of its columns, from the deck below or the ground to the underside of its deck, m."""
    deck_height: Positive | None = None
    """Height of its deck, m. Default: that of `[foundation.deck]`."""
    extra_mass: NotNegative | None = None
    """As in `[foundation.deck]`, for this deck, kg. Default: that of `[foundation.deck]`."""


class Layer(NamedTuple):
    """The columns or the deck of a storey."""

    height: float
    """m."""
    deck: bool
    """Whether it is a deck."""
    extra_mass: float = 0.0
    """Mass besides its own, kg."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FeetSpec(Checked):
    """Springs below the feet of a frame: `foundation.feet`; what is left out is held."""

    horizontal: Positive | None = None
    """k of each foot along x, in 3-D along y, too, N/m. Default: held."""
    vertical: Positive | None = None
    """k of each foot along the vertical, N/m, spread over it: a foot of width b turns on k b²/12.
    Default: held."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameCellsSpec(Checked):
    """Numbers of quadrilaterals or hexahedra of a frame: `foundation.cells`."""

    bay: Count = 8
    """Along the deck from column to column, in 3-D in both directions."""
    column: Count = 2
    """Across a column, in 3-D in both directions."""
    deck: Count = 2
    """Over the height of the deck."""
    storey: Count = 12
    """Along a column."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameSpec(Foundation):
    """A meshed deck, its top at level 0, on columns fixed at their feet: kind = "frame"."""

    needs_mesh_engine: ClassVar[bool] = True

    kind: Literal["frame"] = "frame"
    """A meshed frame."""
    deck: DeckSpec
    """`[foundation.deck]`."""
    column: ColumnSpec
    """`[foundation.column]`."""
    bays: Count = 1
    """Spaces between columns; there is one column more. 3-D: 1."""
    storey: Positive | tuple[StoreySpec, ...]
    """Height of the columns, from their feet to the underside of the deck, m; or several storeys,
    `[[foundation.storey]]`."""
    feet: FeetSpec | None = None
    """`[foundation.feet]`: springs below the columns. Default: held in all directions."""
    young: Positive
    """Young's modulus E, Pa."""
    poisson: Ratio
    """Poisson's ratio nu."""
    density: Positive
    """rho, kg/m³."""
    cells: FrameCellsSpec = field(default_factory=FrameCellsSpec)
    """`[foundation.cells]`. Default: its defaults."""
    degree: Literal[1, 2] = 2
    """Polynomial degree of the displacement; thin columns are too stiff with 1."""
    modes: Count | Literal["auto"] | None = None
    """Fixed-interface modes that steps go on with, beside nodes below blocks and at supports: so
    many, or "auto": as many as their error asks for. Default: all unknowns of the mesh."""
    damping_ratio: DampingRatio | None = None
    """xi of its first sway mode, by damping that is proportional to its stiffness. Default: see
    `damping`."""
    damping: DampingSpec | None = None
    """Its own Rayleigh damping, a table as `[damping]`, where there is no `damping_ratio`. Default:
    that of `[damping]`."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        columns = (self.bays + 1) * self.column.width
        if columns >= self.deck.width:
            allowed = f"less than deck.width / (bays + 1) = {self.deck.width / (self.bays + 1):g}"
            raise SceneError("column.width", shown(self.column.width), allowed)
        if self.storey == ():
            raise SceneError("storey", "no storey", "storey > 0 or an array of tables, [[storey]]")
        refuse_both_dampings(self.damping_ratio, self.damping)

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Columns, deck, columns, deck, ... from the ground upwards."""
        deck = self.deck
        if not isinstance(self.storey, tuple):
            return Layer(self.storey, False), Layer(deck.height, True, deck.extra_mass)
        found: list[Layer] = []
        for storey in self.storey:
            extra = deck.extra_mass if storey.extra_mass is None else storey.extra_mass
            high = deck.height if storey.deck_height is None else storey.deck_height
            found += [Layer(storey.height, False), Layer(high, True, extra)]
        return tuple(found)

    @property
    def moves_as_a_whole(self) -> bool:
        """The deck sways on its columns."""
        return True

    @property
    def reduced_modes(self) -> int | Literal["auto"] | None:
        """Number of modes of its mesh that steps go on with; None: all unknowns."""
        return self.modes

    @property
    def sway_damping_ratio(self) -> float | None:
        """Ratio of critical damping of the first sway mode; None: Rayleigh damping is given."""
        return self.damping_ratio

    @property
    def depth(self) -> float:
        """From the feet of the columns to the top of the deck, m."""
        return sum(layer.height for layer in self.layers)

    @property
    def top(self) -> tuple[float, float]:
        """Width and thickness of the deck, m."""
        return self.deck.width, self.deck.thickness

    @property
    def mesh_label(self) -> str:
        """The cells of a frame are four numbers, which say little to a reader."""
        return "cells of the frame"

    def structure(self, dimension: Dimension) -> tuple[int, int]:
        """Numbers of storeys and of columns on the ground."""
        return len(self.layers) // 2, 4 if dimension == 3 else self.bays + 1

    def in_dimension(self, dimension: Dimension, thickness: float) -> FrameSpec:
        """The frame in a scene of this dimension; `thickness`: of the blocks, m."""
        if dimension == 3 and self.bays != 1:
            raise SceneError("bays", shown(self.bays), "1 where dimension = 3")
        deep = thickness_of(self.deck.thickness, dimension, thickness, "deck.")
        column = self.column.thickness or (deep if dimension == 2 else self.column.width)
        if dimension == 2:
            column = thickness_of(column, dimension, thickness, "column.")
        elif 2 * column >= deep:
            allowed = f"less than deck.thickness / 2 = {deep / 2:g}"
            raise SceneError("column.thickness", shown(column), allowed)
        return replace(
            self,
            deck=replace(self.deck, thickness=deep),
            column=replace(self.column, thickness=column),
        )

    def material(self, plane: Plane, layer: Layer) -> Material:
        """The material of the columns or the deck of a storey, with its extra mass."""
        part = self.deck if layer.deck else self.column
        deck = self.deck
        extra = layer.extra_mass / (deck.width * layer.height * deck.thickness)
        density = self.density if part.density is None else part.density
        return Material(
            young=self.young if part.young is None else part.young,
            poisson=self.poisson if part.poisson is None else part.poisson,
            density=density + extra,
            plane=plane,
        )

    def describe(self, dimension: Dimension, carried: float) -> Lines:
        """What `rockslip check` says of it."""
        deck, count = self.deck, self.structure(dimension)[1]
        size = f"{deck.width:g} x {deck.height:g} x {deck.thickness:g} m"
        heights = ", ".join(f"{layer.height:g}" for layer in self.layers if not layer.deck)
        column = f"{self.column.width:g} x {self.column.thickness:g} m, {heights} m high"
        return [
            ("foundation", f"meshed frame, deck {size}"),
            ("  columns", f"{count}, {column}"),
            ("  mesh", self.mesh_size(dimension)),
            *self._feet_in_words(),
            *sway_damping(self.damping_ratio),
        ]

    def _feet_in_words(self) -> Lines:
        """The springs below the feet, where there are any."""
        if self.feet is None:
            return []
        given = (("horizontal", self.feet.horizontal), ("vertical", self.feet.vertical))
        words = [f"{name} {'held' if k is None else f'{k:g} N/m'}" for name, k in given]
        return [("  feet", ", ".join(words))]

    def unknowns(self, dimension: Dimension) -> int:
        """Number of unknowns of the mesh; columns share their uppermost nodes with the deck."""
        cells, degree, flat = self.cells, self.degree, dimension - 1
        columns, storeys = (self.bays + 1) ** flat, len(self.layers) // 2
        nodes = storeys * (degree * self._along + 1) ** flat * (degree * cells.deck + 1)
        feet = columns * (degree * cells.column + 1) ** flat
        return dimension * (nodes + feet * (storeys * degree * cells.storey - (storeys - 1)))

    @property
    def _along(self) -> int:
        """Number of cells along a deck."""
        return self.bays * self.cells.bay + (self.bays + 1) * self.cells.column

    def mesh_size(self, dimension: Dimension) -> str:
        """Size of the mesh, in words."""
        cells, flat = self.cells, dimension - 1
        columns, storeys = (self.bays + 1) ** flat, len(self.layers) // 2
        count = self._along**flat * cells.deck + columns * cells.column**flat * cells.storey
        nodes, cell = self.unknowns(dimension) // dimension, SHAPES[dimension][0]
        return mesh_size_in_words(count * storeys, cell, self.degree, nodes, dimension)

    def refined(self, times: Callable[[int], int]) -> FrameSpec:
        """The frame with other numbers of cells."""
        counts = {key: times(count) for key, count in asdict(self.cells).items()}
        return replace(self, cells=FrameCellsSpec(**counts))
