"""Blocks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from geometry.block import Block
from solver.errors import SceneError, Statement, missing_key, not_applicable
from solver.scene.cells import box_mesh_size, cell_of, cells_of
from solver.scene.checking import OPEN, Checked, exactly_one, is_open, shown
from solver.scene.contact import FrictionSpec
from solver.scene.damping import (
    DEFAULT_RATIO,
    DampingSpec,
    cantilever_frequency,
    restraint,
    sliding_ratio,
    stiffness_damping,
)
from solver.scene.material import Material, Plane
from solver.scene.names import refuse_name
from solver.scene.quantities import (
    Cell,
    Cells,
    Density,
    Dimension,
    Length,
    Mass,
    Modulus,
    NotNegative,
    Number,
    Place,
    Position,
    Ratio,
    Rotation,
    Tilt,
    Turn,
    Vector,
)

#: The key that a block without elastic constants needs.
RIGID_MODEL = 'model = "rigid"'

#: Numbers of cells by default.
DEFAULT_CELLS: dict[Dimension, Cells] = {2: (6, 16), 3: (6, 6, 16)}


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockSpec(Checked):
    """A block: `[[block]]`; open fields are resolved by the scene, for its dimension.

    A rigid block takes the keys of elasticity and mesh, too, and makes no use of them: the same
    scene with one word changed.
    """

    name: str = "block"
    """The block's name, different from all others: a letter, then letters, digits, `_` and `-`,
    100 at most. Names of tables and columns are taken: foundation, contact, pair, damping, motion,
    time, output, base, platform, plate, frame, energy."""
    on: str | tuple[str, ...] = OPEN
    """Its carrier: `"foundation"` or the name of another block; or an array of
    [several](#several-supports), whose tops are level. Default: `"foundation"`."""
    width: Length
    """B, along x, m."""
    height: Length
    """H, m."""
    thickness: Length = 1.0
    """t, across the plane of motion, along y in 3-D, m."""
    mass: Mass | None = None
    """Mass m of the whole block, kg. Default: this or `density`."""
    density: Density | None = None
    """rho, kg/m³. Default: this or `mass`."""
    model: Literal["elastic", "rigid"] = "elastic"
    """With a mesh; or without one, with 3 unknowns (6 in 3-D)."""
    young: Modulus | None = None
    """Young's modulus E, Pa. Default: elastic: required."""
    poisson: Ratio | None = None
    """Poisson's ratio nu. Default: elastic: required."""
    offset: Place = OPEN
    """Distance of its centre from that of its carrier, along x, before the tilt, m; where there are
    several, from the middle of their tops. Default: 0."""
    offset_second: Place = OPEN
    """Distance between these centres along y, m; 3-D only. Default: 0."""
    position: Position | None = None
    """Place of its centre at the start, m, over the middle of the foundation's top, instead of
    `on` and `offset`; see [places in the air](#places-in-the-air). Default: it stands `on`
    something."""
    tilt_deg: Tilt = 0.0
    """Rigid rotation at the start about the bottom corner on that side, positive towards +x,
    degrees; against its carrier, with which it is tilted if that is. With `position` about its
    centre."""
    tilt_direction_deg: Turn = 0.0
    """Direction in which a positive tilt leans: angle from +x towards +y, degrees; 3-D only."""
    velocity: Vector = OPEN
    """Velocity of its centre at the start, relative to the ground, m/s. Default: 0 in every
    direction."""
    angular_velocity: Rotation = OPEN
    """Angular velocity at the start, rad/s, about the centre: to turn about a corner, a block has a
    `velocity` besides. 2-D: positive when a lean towards +x grows; 3-D: about x, y and z by the
    right-hand rule. Default: 0."""
    cells: Cells = OPEN
    """Cells along width and height; 3-D: width, thickness, height. Default: `[6, 16]`; 3-D: `[6, 6,
    16]`."""
    cell: Cell = OPEN
    """Shape of the cells; each quadrilateral makes two triangles, each hexahedron five tetrahedra.
    Default: the first of those allowed."""
    degree: Literal[1, 2] = 1
    """Polynomial degree of the displacement. Tetrahedra of degree 2 need `contact.points =
    "gauss"`."""
    damping: DampingSpec | None = None
    """Its own Rayleigh damping, a table as `[damping]`. Default: that of `[damping]`; without that
    table elastic blocks have [2 % of critical damping](#default-damping)."""
    refinement: Annotated[float, Number(at_least=1)] = 1.0
    """Longest cell edges over those at the bottom corners, along each direction."""
    friction: NotNegative | FrictionSpec | None = None
    """Between it and what carries it; see [friction](#friction). Default: that of `[contact]`."""
    restitution: Annotated[float, Number(above=0, at_most=1)] | None = None
    """e of impacts on what carries it; see [restitution](#restitution). Rigid blocks only, where
    nothing is meshed, also on a plate that is held. Default: impacts without rebound."""

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """Carrier and offsets, where there is no position."""
        defaults = {"on": "foundation", "offset": 0.0, "offset_second": 0.0}
        for key, value in defaults.items():
            if self.position is None and is_open(getattr(self, key)):
                yield key, value

    def check(self) -> None:
        """Refuse values that do not go together."""
        refuse_name(self.name)
        self._check_place()
        exactly_one(self, "mass", "density")
        if self.restitution is not None and self.model != "rigid":
            raise not_applicable("restitution", f"blocks with {RIGID_MODEL} only")
        if self.model == "elastic":
            for key, range_ in (("young", "young > 0"), ("poisson", "0 <= poisson < 0.5")):
                if getattr(self, key) is None:
                    raise missing_key(key, f"for an elastic block ({range_}), or set {RIGID_MODEL}")

    def _check_place(self) -> None:
        """Refuse a place that is given twice, and carriers that are none or the same."""
        for key in ("on", "offset", "offset_second"):
            if self.position is not None and not is_open(getattr(self, key)):
                raise Statement(key, "counts from a carrier and has no meaning beside position")
        if isinstance(self.on, tuple) and not 0 < len(set(self.on)) == len(self.on):
            raise SceneError("on", shown(self.on), "one name or more, each once")

    def in_dimension(self, dimension: Dimension) -> BlockSpec:
        """The block in a scene of this dimension, nothing left open; SceneError if it cannot be."""
        for key in ("offset_second", "tilt_direction_deg"):
            if dimension == 2 and getattr(self, key):
                raise SceneError(key, shown(getattr(self, key)), "0 where dimension = 2")
        if self.position is not None and len(self.position) != dimension:
            allowed = f"{dimension} values, each a finite number, where dimension = {dimension}"
            raise SceneError("position", shown(self.position), allowed)
        return replace(
            self,
            velocity=self._velocity_in(dimension),
            angular_velocity=self._spin_in(dimension),
            cells=cells_of(self, dimension, DEFAULT_CELLS[dimension]),
            cell=cell_of(self, dimension),
        )

    def _velocity_in(self, dimension: Dimension) -> Vector:
        if is_open(self.velocity):
            return (0.0, 0.0) if dimension == 2 else (0.0, 0.0, 0.0)
        if len(self.velocity) != dimension:
            allowed = f"{dimension} values, each a finite number, where dimension = {dimension}"
            raise SceneError("velocity", shown(self.velocity), allowed)
        return self.velocity

    def _spin_in(self, dimension: Dimension) -> Rotation:
        given = self.angular_velocity
        if is_open(given):
            return 0.0 if dimension == 2 else (0.0, 0.0, 0.0)
        if isinstance(given, tuple) != (dimension == 3):
            allowed = "a finite number" if dimension == 2 else "3 values, each a finite number,"
            where = f"{allowed} where dimension = {dimension}"
            raise SceneError("angular_velocity", shown(given), where)
        return given

    @property
    def carriers(self) -> tuple[str, ...]:
        """Names of what carries it at the start; of a block with a position the foundation."""
        if self.position is not None:
            return ("foundation",)
        return self.on if isinstance(self.on, tuple) else (self.on,)

    @property
    def carrier(self) -> str:
        """The first of its carriers, whose top is the frame of its columns of gaps and slip."""
        return self.carriers[0]

    def is_beside(self, other: BlockSpec) -> bool:
        """True if neither of two blocks carries the other."""
        return self.name not in other.carriers and other.name not in self.carriers

    @property
    def shape(self) -> Block:
        """The block as a geometric body of uniform density."""
        volume = self.width * self.height * self.thickness
        density = self.density or (self.mass or 0.0) / volume  # one of them is there
        size = {"width": self.width, "height": self.height, "thickness": self.thickness}
        return Block(**size, density=density)

    @property
    def elasticity(self) -> tuple[float, float]:
        """E (Pa) and nu of an elastic block; ValueError for a rigid one."""
        if self.model != "elastic" or self.young is None or self.poisson is None:
            raise ValueError(f"block {self.name} is rigid")
        return self.young, self.poisson

    def material(self, plane: Plane) -> Material:
        """The material of an elastic block; ValueError for a rigid one."""
        young, poisson = self.elasticity
        return Material(young=young, poisson=poisson, density=self.shape.density, plane=plane)

    def bending_frequencies(self, plane: Plane) -> tuple[float, ...]:
        """First natural frequency (rad/s) of bending of an elastic block that is held at its base.

        Along its width and, in space, along its thickness. ValueError for a rigid block.
        """
        sides = [(self.width, self.thickness), (self.thickness, self.width)]
        material = self.material(plane)
        return tuple(
            cantilever_frequency(
                along, self.height, material, restraint(plane, across, self.height)
            )
            for along, across in sides[: 2 if plane == "solid" else 1]
        )

    def default_damping(self, plane: Plane, friction: float) -> DampingSpec:
        """Damping of an elastic block by default; ValueError for a rigid one.

        2 % of critical at the first bending mode, or more where a block is squat and slides before
        it rocks: what keeps its steady sliding from flutter.

        Args:
            plane: State of stress.
            friction: Static coefficient of friction on what carries it.
        """
        frequencies = self.bending_frequencies(plane)
        found = [stiffness_damping(DEFAULT_RATIO, min(frequencies))]
        for along, frequency in zip((self.width, self.thickness), frequencies, strict=False):
            if friction * self.height < along:
                ratio = sliding_ratio(friction, self.height / along)
                found.append(stiffness_damping(ratio, frequency))
        return max(found, key=lambda damping: damping.stiffness)

    def mesh_size(self, dimension: Dimension) -> str:
        """The size of its mesh, or that there is none."""
        if self.model == "rigid":
            return f"none: rigid, {3 if dimension == 2 else 6} unknowns"
        return box_mesh_size(self, dimension)

    @property
    def tilt(self) -> float:
        """`tilt_deg` in rad."""
        return math.radians(self.tilt_deg)

    @property
    def begins_at_rest(self) -> bool:
        """True if it begins upright and at rest."""
        return not (self.tilt_deg or any(self.velocity) or any(self.spins))

    @property
    def spins(self) -> tuple[float, ...]:
        """Components of its angular velocity at the start, rad/s: one in 2-D, three in 3-D."""
        turns = self.angular_velocity
        return turns if isinstance(turns, tuple) else (turns,)

    @property
    def tilt_direction(self) -> float:
        """`tilt_direction_deg` in rad."""
        return math.radians(self.tilt_direction_deg)
