"""Foundations: what carries the blocks, by its kind."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import ClassVar, Literal, NamedTuple, TypeAlias, TypeVar

from geometry.block import Block
from solver.errors import SceneError, missing_key
from solver.scene.cells import (
    SHAPES,
    MeshSize,
    cells_in,
    mesh_of_box,
    mesh_size_in_words,
    refined,
)
from solver.scene.checking import OPEN, Checked, exactly_one, only_where, shown
from solver.scene.damping import DampingSpec, refuse_both_dampings
from solver.scene.material import Material, Plane
from solver.scene.quantities import (
    AddedMass,
    Cell,
    Cells,
    Count,
    DampingRatio,
    Density,
    Dimension,
    Duration,
    Length,
    Mass,
    Modulus,
    NotNegative,
    Positive,
    Ratio,
    Spring,
)

Lines = list[tuple[str, str]]
"""Names and texts, as `rockslip check` prints them."""

Self = TypeVar("Self", bound="Foundation")


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

    @classmethod
    def on_spring(
        cls, mass: float, *, period: float | None, stiffness: float | None, damping_ratio: float
    ) -> Platform:
        """A platform of this mass (kg) with this period (s) or stiffness (N/m)."""
        k = stiffness if stiffness is not None else mass * (2 * math.pi / (period or math.nan)) ** 2
        return cls(mass, k, 2 * damping_ratio * math.sqrt(k * mass))


class Foundation(Checked):
    """Base of the foundations: each kind overrides what is different from rigid ground.

    `carried` is everywhere the mass of all blocks of the scene, kg.
    """

    __slots__ = ()

    needs_mesh_engine: ClassVar[bool] = False
    """True if even a scene of rigid blocks has to run with meshed bodies."""

    @property
    def on_spring(self) -> bool:
        """True if the blocks stand on a horizontal spring: then `platform` is not None."""
        return False

    @property
    def moves_as_a_whole(self) -> bool:
        """True if the history has a motion of what carries the blocks, relative to the ground."""
        return self.on_spring

    @property
    def depth(self) -> float | None:
        """Height from the floor to the surface that carries the blocks, m; None: no size given."""
        return 0.0

    @property
    def top(self) -> tuple[float, float] | None:
        """Width and thickness of the surface that carries the blocks, m; None: without ends."""
        return None

    @property
    def sway_damping_ratio(self) -> float | None:
        """Ratio of critical damping of the first sway mode of its mesh; None: not given by that."""
        return None

    @property
    def modes(self) -> int | Literal["auto"] | None:
        """Number of modes of its mesh that steps go on with; None: all unknowns."""
        return None

    @property
    def is_meshed(self) -> bool:
        """True if it deforms as a body."""
        return False

    @property
    def is_firm(self) -> bool:
        """True for a face with ends that is as firm as the ground itself and not meshed."""
        return False

    def structure(self, dimension: Dimension) -> tuple[int, int] | None:
        """Numbers of storeys and of columns of a mesh that moves as a whole; None for others."""
        return None

    def in_dimension(self: Self, dimension: Dimension, thickness: float) -> Self:
        """The foundation under blocks of this thickness (m), nothing left open.

        Raises:
            SceneError: It cannot be.
        """
        return self

    def platform(self, carried: float) -> Platform | None:
        """The empty platform on its spring; None where there is no spring."""
        return None

    def pressed_material(self, plane: Plane, carried: float) -> Material | None:
        """The material that blocks press on, where it deforms as a body; None elsewhere."""
        return None

    def turning_cells(self, plane: Plane, carried: float) -> tuple[Material, float] | None:
        """Material and smallest cell edge over the degree (m) of a mesh that may turn; else None.

        A mesh that may turn as a whole must not be too stiff for the steps (`scene.limits`).
        """
        return None

    def describe(self, dimension: Dimension, carried: float) -> Lines:
        """Lines of `rockslip check`; the spring and the period of the mesh are added."""
        return [("foundation", "rigid ground")]

    def refined(self: Self, times: Callable[[int], int]) -> Self:
        """The foundation with other numbers of cells; `times` maps each old number to a new one."""
        return self


def sway_damping(ratio: float | None) -> Lines:
    """Line of `rockslip check` on damping by the ratio of the first sway mode."""
    return [] if ratio is None else [("  damping", f"{100 * ratio:g} % of critical at first sway")]


def thickness_of(
    given: float | None, dimension: Dimension, blocks: float, where: str = ""
) -> float:
    """The thickness of a foundation, m; in the plane all bodies are as thick as the blocks.

    `where` is the path of the table, with a dot at its end, for errors.

    Raises:
        SceneError: It is missing in 3-D, or another one than that of the blocks in 2-D.
    """
    if dimension == 3 and given is None:
        raise missing_key(f"{where}thickness", "in 3-D scenes (thickness > 0)")
    if dimension == 2 and given not in (None, blocks):
        allowed = f"that of the blocks, {blocks:g}, where dimension = 2"
        raise SceneError(f"{where}thickness", shown(given), allowed)
    return given or blocks


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidSpec(Foundation):
    """The rigid ground: `[foundation]` with kind = "rigid", the default."""

    kind: Literal["rigid"] = "rigid"
    """The ground."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OscillatorSpec(Foundation):
    """A rigid platform on a horizontal spring: kind = "oscillator"."""

    kind: Literal["oscillator"] = "oscillator"
    """A rigid platform on a spring."""
    mass: Mass | None = None
    """Mass of the empty platform, kg. Default: this or `mass_ratio`."""
    mass_ratio: Positive | None = None
    """Mass of all blocks over that of the platform. Default: this or `mass`."""
    period: Duration | None = None
    """T of the empty platform, s. Default: this or `stiffness`."""
    stiffness: Spring | None = None
    """k of the spring, N/m. Default: this or `period`."""
    damping_ratio: NotNegative = 0.0
    """xi of the empty platform."""

    def check(self) -> None:
        """Refuse values that do not go together."""
        exactly_one(self, "mass", "mass_ratio")
        exactly_one(self, "period", "stiffness")

    @property
    def on_spring(self) -> bool:
        """An oscillator always is."""
        return True

    @property
    def depth(self) -> float | None:
        """A scene gives a platform no size: None."""
        return None

    def platform(self, carried: float) -> Platform:
        """The platform that carries blocks of mass `carried`, kg, in all."""
        return Platform.on_spring(
            self.mass or carried / (self.mass_ratio or math.nan),
            period=self.period,
            stiffness=self.stiffness,
            damping_ratio=self.damping_ratio,
        )

    def describe(self, dimension: Dimension, carried: float) -> Lines:
        """Lines of `rockslip check`."""
        return [("foundation", "rigid platform on a spring")]


#: Numbers of cells of a plate by default.
PLATE_CELLS: dict[Dimension, Cells] = {2: (24, 4), 3: (12, 12, 2)}

SUPPORTS = {"fixed": "held everywhere", "bottom": "held at its bottom", "rollers": "on rollers"}
"""The supports of a plate, in the words of `rockslip check`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateSpec(Foundation):
    """A meshed plate, its top at level 0: kind = "elastic"."""

    needs_mesh_engine: ClassVar[bool] = True
    """Also for a plate that is held everywhere: blocks may fall over its edge."""

    kind: Literal["elastic"] = "elastic"
    """A meshed plate."""
    width: Length
    """Along x, m."""
    height: Length
    """Height, m."""
    thickness: Length = OPEN
    """Along y, m; 2-D: no other than that of the blocks. Default: that of the blocks; 3-D:
    required."""
    mass: Mass | None = None
    """Mass of the plate, kg. Default: one of these three."""
    mass_ratio: Positive | None = None
    """Mass of all blocks over that of the plate. Default: one of these three."""
    density: Density | None = None
    """rho, kg/m³. Default: one of these three."""
    young: Modulus
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
    damping: DampingSpec | None = None
    """Its own Rayleigh damping, a table as `[damping]`; not where all of it is fixed. Default: that
    of `[damping]`."""
    modes: Count | Literal["auto"] | None = None
    """Fixed-interface modes that steps go on with, beside nodes below blocks and at supports: so
    many, or "auto": as many as their error requires; not where all of it is fixed. Default: all
    unknowns of the mesh."""
    support: Literal["fixed", "bottom", "rollers"] = "fixed"
    """Support of the plate, as described above."""
    meshed: bool = False
    """Mesh a plate that is held everywhere; other plates always are."""
    period: Duration | None = None
    """T of the empty plate taken as rigid, s; rollers only. Default: -; rollers: this or
    `stiffness`."""
    stiffness: Spring | None = None
    """k of the spring, N/m; rollers only. Default: -; rollers: this or `period`."""
    damping_ratio: NotNegative = 0.0
    """xi of the empty plate; rollers: by the dashpot; bottom: that of the first sway mode, below 1,
    by damping that is proportional to its stiffness, instead of `damping`."""

    def check(self) -> None:
        """Refuse values that do not go together."""
        exactly_one(self, "mass", "mass_ratio", "density")
        held, loose = self.support == "fixed", "a plate that is not held everywhere"
        only_where(self, not held, loose, "damping", "modes")
        only_where(self, held, 'a plate with support = "fixed" only: others always are', "meshed")
        if self.on_spring:
            exactly_one(self, "period", "stiffness")
            return
        only_where(self, False, 'a plate with support = "rollers" only', "period", "stiffness")
        only_where(self, not held, loose, "damping_ratio")
        if self.damping_ratio:
            if self.damping_ratio >= 1:
                allowed = '0 <= damping_ratio < 1 with support = "bottom"'
                raise SceneError("damping_ratio", shown(self.damping_ratio), allowed)
            refuse_both_dampings(self.damping_ratio, self.damping)

    @property
    def is_firm(self) -> bool:
        """True if all of it is held and it is not meshed."""
        return self.support == "fixed" and not self.meshed

    @property
    def on_spring(self) -> bool:
        """True on rollers."""
        return self.support == "rollers"

    @property
    def sway_damping_ratio(self) -> float | None:
        """Ratio of critical damping of the first sway mode of a plate without a spring."""
        return None if self.on_spring else self.damping_ratio or None

    @property
    def depth(self) -> float | None:
        """Its height, m."""
        return self.height

    @property
    def top(self) -> tuple[float, float]:
        """Its width and thickness, m."""
        return self.width, self.thickness

    @property
    def is_meshed(self) -> bool:
        """True unless all of it is held, which is not meshed, or does not deform."""
        return self.support != "fixed"

    def structure(self, dimension: Dimension) -> tuple[int, int] | None:
        """On rollers it has neither storeys nor columns; else it is no structure."""
        return (0, 0) if self.on_spring else None

    def in_dimension(self, dimension: Dimension, thickness: float) -> PlateSpec:
        """The plate in a scene of this dimension; `thickness`: of the blocks, m."""
        return replace(
            self,
            thickness=thickness_of(self.thickness, dimension, thickness),
            **cells_in(self.cells, self.cell, dimension, PLATE_CELLS[dimension]),
        )

    def shape(self, carried: float) -> Block:
        """The plate as a body of uniform density; `carried`: mass of all blocks, kg."""
        mass = self.mass if self.mass_ratio is None else carried / self.mass_ratio
        density = self.density or (mass or math.nan) / (self.width * self.height * self.thickness)
        return Block(
            width=self.width, height=self.height, thickness=self.thickness, density=density
        )

    def material(self, plane: Plane, carried: float) -> Material:
        """Its material; `carried`: mass of all blocks, kg."""
        density = self.shape(carried).density
        return Material(young=self.young, poisson=self.poisson, density=density, plane=plane)

    def platform(self, carried: float) -> Platform | None:
        """The plate on rollers as one mass; `carried`: mass of all blocks, kg."""
        if not self.on_spring:
            return None
        return Platform.on_spring(
            self.shape(carried).mass,
            period=self.period,
            stiffness=self.stiffness,
            damping_ratio=self.damping_ratio,
        )

    def pressed_material(self, plane: Plane, carried: float) -> Material | None:
        """Its material, unless all of it is held."""
        return None if self.support == "fixed" else self.material(plane, carried)

    def turning_cells(self, plane: Plane, carried: float) -> tuple[Material, float] | None:
        """Material and smallest cell edge over the degree, m, where it may turn about the vertical.

        In space on rollers.
        """
        if plane != "solid" or not self.on_spring:
            return None
        return self.material(plane, carried), min(self.mesh.corner_cell) / self.degree

    @property
    def mesh(self) -> MeshSize:
        """The size of its mesh; held everywhere it has nodes at the corners of its cells alone."""
        across = (self.thickness,) if len(self.cells) == 3 else ()
        degree = 1 if self.support == "fixed" else self.degree
        return mesh_of_box((self.width, *across, self.height), self.cells, self.cell, degree)

    def describe(self, dimension: Dimension, carried: float) -> Lines:
        """Lines of `rockslip check`."""
        size = f"{self.width:g} x {self.height:g} x {self.thickness:g} m"
        if self.support == "fixed" and not self.meshed:
            return [("foundation", f"plate, {size}, {SUPPORTS['fixed']}: a rigid face with ends")]
        mesh = str(self.mesh)
        if self.support == "fixed":
            mesh = f"{mesh.rpartition(', ')[0]}, all of them held"
        return [
            ("foundation", f"meshed plate, {size}, {SUPPORTS[self.support]}"),
            ("  density", f"{self.shape(carried).density:.6g} kg/m3"),
            ("  mesh", mesh),
            *sway_damping(self.sway_damping_ratio),
        ]

    def refined(self, times: Callable[[int], int]) -> PlateSpec:
        """The plate with other numbers of cells."""
        return replace(self, cells=refined(self.cells, times))


@dataclass(frozen=True, slots=True, kw_only=True)
class DeckSpec(Checked):
    """The deck of a frame: `foundation.deck`."""

    width: Length
    """Along x, from outside to outside of the outer columns, m."""
    height: Length
    """Height, m."""
    thickness: Length = OPEN
    """Along y, m; 2-D: no other than that of the blocks. Default: that of the blocks; 3-D:
    required."""
    young: Modulus | None = None
    """Young's modulus E, Pa. Default: that of the frame."""
    poisson: Ratio | None = None
    """Poisson's ratio nu. Default: that of the frame."""
    density: Density | None = None
    """rho, kg/m³. Default: that of the frame."""
    extra_mass: AddedMass = 0.0
    """Mass that is spread over the deck besides its own, kg: fixed to it, it moves and weighs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnSpec(Checked):
    """The columns of a frame: `foundation.column`."""

    width: Length
    """Along x, m; less than the deck's over the number of columns."""
    thickness: Length = OPEN
    """Along y, m; 2-D: no other than that of the blocks, 3-D: less than half of the deck's.
    Default: that of the blocks; 3-D: the width."""
    young: Modulus | None = None
    """Young's modulus E, Pa. Default: that of the frame."""
    poisson: Ratio | None = None
    """Poisson's ratio nu. Default: that of the frame."""
    density: Density | None = None
    """rho, kg/m³. Default: that of the frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoreySpec(Checked):
    """A storey of a frame, from the ground upwards: `[[foundation.storey]]`."""

    height: Length
    """Height of its columns, from the deck below or the ground to the underside of its deck, m."""
    deck_height: Length | None = None
    """Height of its deck, m. Default: that of `[foundation.deck]`."""
    extra_mass: AddedMass | None = None
    """As in `[foundation.deck]`, for this deck, kg. Default: that of `[foundation.deck]`."""


class Layer(NamedTuple):
    """The columns or the deck of a storey."""

    height: float
    """m."""
    deck: bool
    """True for a deck, false for columns."""
    extra_mass: float = 0.0
    """Mass besides its own, kg."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FeetSpec(Checked):
    """Springs below the feet of a frame: `foundation.feet`; what is left out is held."""

    horizontal: Spring | None = None
    """k of each foot along x, in 3-D along y, too, N/m. Default: held."""
    vertical: Spring | None = None
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
    storey: Length | tuple[StoreySpec, ...]
    """Height of the columns, from their feet to the underside of the deck, m; or several storeys,
    `[[foundation.storey]]`."""
    feet: FeetSpec | None = None
    """`[foundation.feet]`: springs below the columns. Default: held in all directions."""
    young: Modulus
    """Young's modulus E, Pa."""
    poisson: Ratio
    """Poisson's ratio nu."""
    density: Density
    """rho, kg/m³."""
    cells: FrameCellsSpec = field(default_factory=FrameCellsSpec)
    """`[foundation.cells]`. Default: its defaults."""
    degree: Literal[1, 2] = 2
    """Polynomial degree of the displacement; thin columns are too stiff with 1."""
    modes: Count | Literal["auto"] | None = None
    """Fixed-interface modes that steps go on with, beside nodes below blocks and at supports: so
    many, or "auto": as many as their error requires. Default: all unknowns of the mesh."""
    damping_ratio: DampingRatio | None = None
    """xi of its first sway mode, by damping that is proportional to its stiffness. Default: see
    `damping`."""
    damping: DampingSpec | None = None
    """Its own Rayleigh damping, a table as `[damping]`, where there is no `damping_ratio`. Default:
    that of `[damping]`."""

    def check(self) -> None:
        """Refuse values that do not go together."""
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
    def is_meshed(self) -> bool:
        """It always is."""
        return True

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
        """Lines of `rockslip check`."""
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

    def mesh_size(self, dimension: Dimension) -> str:
        """Size of the mesh, in words; columns share their uppermost nodes with the deck."""
        cells, degree, flat = self.cells, self.degree, dimension - 1
        columns, storeys = (self.bays + 1) ** flat, len(self.layers) // 2
        along = self.bays * cells.bay + (self.bays + 1) * cells.column
        count = along**flat * cells.deck + columns * cells.column**flat * cells.storey
        nodes = storeys * (degree * along + 1) ** flat * (degree * cells.deck + 1)
        foot = (degree * cells.column + 1) ** flat
        nodes += columns * foot * (storeys * degree * cells.storey - (storeys - 1))
        return mesh_size_in_words(count * storeys, SHAPES[dimension][0], degree, nodes, dimension)

    def refined(self, times: Callable[[int], int]) -> FrameSpec:
        """The frame with other numbers of cells."""
        counts = {key: times(count) for key, count in asdict(self.cells).items()}
        return replace(self, cells=FrameCellsSpec(**counts))


FoundationSpec: TypeAlias = RigidSpec | OscillatorSpec | PlateSpec | FrameSpec
"""All kinds, distinguished by `kind`; the first is the default."""
