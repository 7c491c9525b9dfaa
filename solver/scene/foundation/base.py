"""What every kind of foundation says of itself; the base class is ground that never gives way."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ClassVar, Literal, NamedTuple, TypeVar

from solver.errors import SceneError, missing_key
from solver.scene.checking import Checked, shown
from solver.scene.material import Material, Plane
from solver.scene.ranges import Dimension

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
    """Whether even a scene of rigid blocks has to run with meshed bodies."""

    @property
    def on_spring(self) -> bool:
        """Whether the blocks stand on a horizontal spring: then `platform` is not None."""
        return False

    @property
    def moves_as_a_whole(self) -> bool:
        """Whether the history shows a motion of what carries the blocks, relative to the ground."""
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
    def mesh_label(self) -> str:
        """The size of the mesh in a few words; empty where nothing is meshed."""
        return ""

    @property
    def sway_damping_ratio(self) -> float | None:
        """Ratio of critical damping of the first sway mode of its mesh; None: not given by that."""
        return None

    @property
    def reduced_modes(self) -> int | Literal["auto"] | None:
        """Number of modes of its mesh that steps go on with; None: all unknowns."""
        return None

    @property
    def is_meshed(self) -> bool:
        """Whether it deforms as a body."""
        return bool(self.mesh_label)

    @property
    def is_firm(self) -> bool:
        """Whether it is as firm as the ground itself, a face with ends that nothing meshes."""
        return False

    def unknowns(self, dimension: Dimension) -> int:
        """Number of unknowns of its mesh; 0 where it has none."""
        return 0

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
        """What blocks press on, where it deforms as a body; None elsewhere."""
        return None

    def turning_cells(self, plane: Plane, carried: float) -> tuple[Material, float] | None:
        """Material and smallest cell edge over the degree (m) of a mesh that may turn; else None.

        A mesh that may turn as a whole must not be too stiff for the steps (`scene.limits`).
        """
        return None

    def describe(self, dimension: Dimension, carried: float) -> Lines:
        """What `rockslip check` says of it; the spring and the period of the mesh are added."""
        return [("foundation", "rigid ground")]

    def refined(self: Self, times: Callable[[int], int]) -> Self:
        """The foundation with other numbers of cells; `times` maps each old number to a new one."""
        return self

    def with_degree(self: Self, degree: Literal[1, 2]) -> Self:
        """The foundation with another polynomial degree, where studies may change it."""
        return self


def sway_damping(ratio: float | None) -> Lines:
    """What `rockslip check` says of damping by the ratio of the first sway mode."""
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
