"""What carries the blocks."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple, TypeAlias

from geometry.block import Block
from solver.errors import SceneError
from solver.scene.cells import cell_of, cells_of
from solver.scene.checking import OPEN, Checked, exactly_one, shown
from solver.scene.ranges import (
    Cell,
    Cells,
    Count,
    Dimension,
    NotNegative,
    Positive,
    Ratio,
)

#: Numbers of cells of a plate where a scene says nothing.
PLATE_CELLS: dict[Dimension, Cells] = {2: (24, 4), 3: (12, 12, 2)}


class Platform(NamedTuple):
    """An empty platform on a horizontal spring and dashpot; the same both ways in 3-D."""

    mass: float
    """kg."""
    stiffness: float
    """k, N/m."""
    damping: float
    """c, N s/m."""

    @property
    def period(self) -> float:
        """Natural period T = 2 pi sqrt(m/k), s."""
        return 2 * math.pi * math.sqrt(self.mass / self.stiffness)

    @property
    def damping_ratio(self) -> float:
        """Damping ratio xi = c / (2 sqrt(k m))."""
        return self.damping / (2 * math.sqrt(self.stiffness * self.mass))


def platform(
    mass: float, *, period: float | None, stiffness: float | None, damping_ratio: float
) -> Platform:
    """A platform of this mass (kg) with this period (s) or stiffness (N/m)."""
    k = stiffness if stiffness is not None else mass * (2 * math.pi / (period or math.nan)) ** 2
    return Platform(mass, k, 2 * damping_ratio * math.sqrt(k * mass))


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidSpec(Checked):
    """The rigid ground: `[foundation]` with kind = "rigid", the default."""

    kind: Literal["rigid"] = "rigid"
    """The ground."""

    def in_dimension(self, dimension: Dimension, thickness: float) -> RigidSpec:
        """Itself."""
        return self


@dataclass(frozen=True, slots=True, kw_only=True)
class OscillatorSpec(Checked):
    """A rigid platform on a horizontal spring: kind = "oscillator"."""

    kind: Literal["oscillator"] = "oscillator"
    """A rigid platform on a spring."""
    mass: Positive | None = None
    """Mass of the empty platform, kg. Default: this or `mass_ratio`."""
    mass_ratio: Positive | None = None
    """Mass of all blocks over that of the platform. Default: this or `mass`."""
    period: Positive | None = None
    """T of the empty platform, s. Default: this or `stiffness`."""
    stiffness: Positive | None = None
    """k of the spring, N/m. Default: this or `period`."""
    damping_ratio: NotNegative = 0.0
    """xi of the empty platform."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        exactly_one(self, "mass", "mass_ratio")
        exactly_one(self, "period", "stiffness")

    def in_dimension(self, dimension: Dimension, thickness: float) -> OscillatorSpec:
        """Itself."""
        return self

    def platform(self, carried: float) -> Platform:
        """The platform that carries blocks of mass `carried`, kg, in all."""
        return platform(
            self.mass or carried / (self.mass_ratio or math.nan),
            period=self.period,
            stiffness=self.stiffness,
            damping_ratio=self.damping_ratio,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateSpec(Checked):
    """A meshed plate, its top at level 0: kind = "elastic"."""

    kind: Literal["elastic"] = "elastic"
    """A meshed plate."""
    width: Positive
    """Along x, m."""
    height: Positive
    """Height, m."""
    thickness: Positive = OPEN
    """Along y, m; 2-D: no other than that of the blocks. Default: that of the blocks; 3-D:
    required."""
    mass: Positive | None = None
    """Mass of the plate, kg. Default: one of these three."""
    mass_ratio: Positive | None = None
    """Mass of all blocks over that of the plate. Default: one of these three."""
    density: Positive | None = None
    """rho, kg/m³. Default: one of these three."""
    young: Positive
    """Young's modulus E, Pa."""
    poisson: Ratio
    """Poisson's ratio nu."""
    cells: Cells = OPEN
    """Cells along width and height; 3-D: width, thickness, height. Default: `[24, 4]`; 3-D: `[12,
    12, 2]`."""
    cell: Cell = OPEN
    """Shape of the cells. Default: the first of those allowed."""
    degree: Literal[1, 2] = 1
    """Polynomial degree of the displacement."""
    support: Literal["fixed", "bottom", "rollers"] = "fixed"
    """What holds the plate, as described above."""
    period: Positive | None = None
    """T of the empty plate taken as rigid, s; rollers only. Default: -; rollers: this or
    `stiffness`."""
    stiffness: Positive | None = None
    """k of the spring, N/m; rollers only. Default: -; rollers: this or `period`."""
    damping_ratio: NotNegative = 0.0
    """xi of the empty plate; rollers only."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        exactly_one(self, "mass", "mass_ratio", "density")
        if self.support == "rollers":
            exactly_one(self, "period", "stiffness")
            return
        for key in ("period", "stiffness", "damping_ratio"):
            if getattr(self, key):
                allowed = 'nothing, unless support = "rollers"'
                raise SceneError(key, shown(getattr(self, key)), allowed)

    def in_dimension(self, dimension: Dimension, thickness: float) -> PlateSpec:
        """The plate in a scene of this dimension, nothing left open; SceneError if it cannot be.

        Args:
            dimension: 2 or 3.
            thickness: Of the blocks, m.
        """
        return replace(
            self,
            thickness=_thickness(self.thickness, dimension, thickness),
            cells=cells_of(self, dimension, PLATE_CELLS[dimension]),
            cell=cell_of(self, dimension),
        )

    def shape(self, carried: float) -> Block:
        """The plate as a body of uniform density; `carried`: mass of all blocks, kg."""
        mass = self.mass if self.mass_ratio is None else carried / self.mass_ratio
        density = self.density or (mass or math.nan) / (self.width * self.height * self.thickness)
        return Block(
            width=self.width, height=self.height, thickness=self.thickness, density=density
        )

    def platform(self, carried: float) -> Platform:
        """The plate on rollers as one mass; `carried`: mass of all blocks, kg."""
        return platform(
            self.shape(carried).mass,
            period=self.period,
            stiffness=self.stiffness,
            damping_ratio=self.damping_ratio,
        )


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


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnSpec(Checked):
    """The columns of a frame: `foundation.column`."""

    width: Positive
    """Along x, m; less than the deck's over the number of columns."""
    thickness: Positive = OPEN
    """Along y, m; 3-D: less than half of the deck's. Default: that of the blocks; 3-D: the
    width."""


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
class FrameSpec(Checked):
    """A meshed deck, its top at level 0, on columns fixed at their feet: kind = "frame"."""

    kind: Literal["frame"] = "frame"
    """A meshed frame."""
    deck: DeckSpec
    """`[foundation.deck]`."""
    column: ColumnSpec
    """`[foundation.column]`."""
    bays: Count = 1
    """Spaces between columns; there is one column more. 3-D: 1."""
    storey: Positive
    """Height of the columns, from their feet to the underside of the deck, m."""
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

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        columns = (self.bays + 1) * self.column.width
        if columns >= self.deck.width:
            allowed = f"less than deck.width / (bays + 1) = {self.deck.width / (self.bays + 1):g}"
            raise SceneError("column.width", shown(self.column.width), allowed)

    def in_dimension(self, dimension: Dimension, thickness: float) -> FrameSpec:
        """The frame in a scene of this dimension, nothing left open; SceneError if it cannot be.

        Args:
            dimension: 2 or 3.
            thickness: Of the blocks, m.
        """
        if dimension == 3 and self.bays != 1:
            raise SceneError("bays", shown(self.bays), "1 where dimension = 3")
        deep = _thickness(self.deck.thickness, dimension, thickness, "deck.")
        column = self.column.thickness or (deep if dimension == 2 else self.column.width)
        if dimension == 2:
            column = _thickness(column, dimension, thickness, "column.")
        elif 2 * column >= deep:
            allowed = f"less than deck.thickness / 2 = {deep / 2:g}"
            raise SceneError("column.thickness", shown(column), allowed)
        return replace(
            self,
            deck=replace(self.deck, thickness=deep),
            column=replace(self.column, thickness=column),
        )


def _thickness(given: float | None, dimension: Dimension, blocks: float, where: str = "") -> float:
    """The thickness of what carries the blocks; in the plane all bodies are equally thick."""
    if dimension == 3 and given is None:
        raise SceneError(f"{where}thickness", "nothing", "thickness > 0 where dimension = 3")
    if dimension == 2 and given not in (None, blocks):
        allowed = f"that of the blocks, {blocks:g}, where dimension = 2"
        raise SceneError(f"{where}thickness", shown(given), allowed)
    return given or blocks


FoundationSpec: TypeAlias = RigidSpec | OscillatorSpec | PlateSpec | FrameSpec
