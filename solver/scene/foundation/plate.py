"""A plate: kind = "elastic"."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from geometry.block import Block
from solver.errors import SceneError, not_applicable
from solver.scene.cells import (
    box_mesh_size,
    box_nodes,
    cell_of,
    cells_in_words,
    cells_of,
    equal_parts,
    refined,
)
from solver.scene.checking import OPEN, Checked, exactly_one, shown
from solver.scene.damping import DampingSpec, refuse_both_dampings
from solver.scene.foundation.base import (
    Foundation,
    Lines,
    Platform,
    sway_damping,
    thickness_of,
)
from solver.scene.material import Material, Plane
from solver.scene.ranges import Cell, Cells, Count, Dimension, NotNegative, Positive, Ratio

#: Numbers of cells of a plate where a scene says nothing.
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
    damping: DampingSpec | None = None
    """Its own Rayleigh damping, a table as `[damping]`; not where all of it is fixed. Default: that
    of `[damping]`."""
    modes: Count | Literal["auto"] | None = None
    """Fixed-interface modes that steps go on with, beside nodes below blocks and at supports: so
    many, or "auto": as many as their error asks for; not where all of it is fixed. Default: all
    unknowns of the mesh."""
    support: Literal["fixed", "bottom", "rollers"] = "fixed"
    """What holds the plate, as described above."""
    meshed: bool = False
    """Whether a plate that is held everywhere is meshed; other plates always are."""
    period: Positive | None = None
    """T of the empty plate taken as rigid, s; rollers only. Default: -; rollers: this or
    `stiffness`."""
    stiffness: Positive | None = None
    """k of the spring, N/m; rollers only. Default: -; rollers: this or `period`."""
    damping_ratio: NotNegative = 0.0
    """xi of the empty plate; rollers: by the dashpot; bottom: that of the first sway mode, below 1,
    by damping that is proportional to its stiffness, instead of `damping`."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        exactly_one(self, "mass", "mass_ratio", "density")
        if self.support == "fixed" and self.damping is not None:
            raise not_applicable("damping", "a plate that is not held everywhere")
        if self.support == "fixed" and self.modes is not None:
            raise not_applicable("modes", "a plate that is not held everywhere")
        if self.support != "fixed" and self.meshed:
            raise not_applicable("meshed", 'a plate with support = "fixed" only: others always are')
        if self.on_spring:
            exactly_one(self, "period", "stiffness")
            return
        for key in ("period", "stiffness"):
            if getattr(self, key):
                raise not_applicable(key, 'a plate with support = "rollers" only')
        if self.damping_ratio:
            if self.support == "fixed":
                raise not_applicable("damping_ratio", "a plate that is not held everywhere")
            if self.damping_ratio >= 1:
                allowed = '0 <= damping_ratio < 1 with support = "bottom"'
                raise SceneError("damping_ratio", shown(self.damping_ratio), allowed)
            refuse_both_dampings(self.damping_ratio, self.damping)

    @property
    def is_firm(self) -> bool:
        """Whether all of it is held, and nothing meshes it."""
        return self.support == "fixed" and not self.meshed

    @property
    def on_spring(self) -> bool:
        """Whether it is on rollers."""
        return self.support == "rollers"

    @property
    def reduced_modes(self) -> int | Literal["auto"] | None:
        """Number of modes of its mesh that steps go on with; None: all unknowns."""
        return self.modes

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
    def mesh_label(self) -> str:
        """Numbers of its cells; a plate that is fully restrained is not meshed."""
        return "" if self.support == "fixed" else cells_in_words(self.cells)

    def structure(self, dimension: Dimension) -> tuple[int, int] | None:
        """On rollers it has neither storeys nor columns; else it is no structure."""
        return (0, 0) if self.on_spring else None

    def in_dimension(self, dimension: Dimension, thickness: float) -> PlateSpec:
        """The plate in a scene of this dimension; `thickness`: of the blocks, m."""
        return replace(
            self,
            thickness=thickness_of(self.thickness, dimension, thickness),
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
        edges = equal_parts((self.width, self.thickness, self.height), self.cells)
        return self.material(plane, carried), min(edges) / self.degree

    def unknowns(self, dimension: Dimension) -> int:
        """Number of unknowns of its mesh; 0 where it is held everywhere."""
        return 0 if self.support == "fixed" else dimension * box_nodes(self)

    def describe(self, dimension: Dimension, carried: float) -> Lines:
        """What `rockslip check` says of it."""
        size = f"{self.width:g} x {self.height:g} x {self.thickness:g} m"
        if self.support == "fixed" and not self.meshed:
            return [("foundation", f"plate, {size}, {SUPPORTS['fixed']}: a rigid face with ends")]
        mesh = box_mesh_size(self, dimension)
        if self.support == "fixed":
            mesh = box_mesh_size(replace(self, degree=1), dimension)
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

    def with_degree(self, degree: Literal[1, 2]) -> PlateSpec:
        """The plate with another polynomial degree."""
        return replace(self, degree=degree)
