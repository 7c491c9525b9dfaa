"""The parts of a scene: the one place where keys are named and their ranges stand.

Units are SI; angles stand in degrees in keys that end in `_deg`, and nowhere else.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from geometry.block import Block
from solver.checking import Checked, Number, shown
from solver.errors import SceneError

Finite = Annotated[float, Number()]
Positive = Annotated[float, Number(above=0)]
NotNegative = Annotated[float, Number(at_least=0)]
Tilt = Annotated[float, Number(above=-90, below=90)]
Count = Annotated[int, Number(at_least=1)]

# Names that mean something else in key paths or in the columns of a history.
RESERVED = (
    *("foundation", "contact", "damping", "motion", "time", "output"),
    *("base", "platform", "energy"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockSpec(Checked):
    """A block: `[[block]]`."""

    name: str = "block"
    """Letters, digits, _ and -; addresses the block in overrides and columns."""
    on: Literal["foundation"] = "foundation"
    """What carries it."""
    width: Positive
    """B, m."""
    height: Positive
    """H, m."""
    thickness: Positive = 1.0
    """t, m."""
    mass: Positive | None = None
    """m, kg; or `density`."""
    density: Positive | None = None
    """rho, kg/m^3; or `mass`."""
    model: Literal["elastic"] = "elastic"
    young: Positive
    """Young's modulus E, Pa."""
    poisson: Annotated[float, Number(at_least=0, below=0.5)]
    """Poisson's ratio nu."""
    offset: Finite = 0.0
    """Of its centre from the centre of what carries it, m."""
    tilt_deg: Tilt = 0.0
    """Initial rigid rotation about the bottom corner on that side, positive towards +x, degrees."""
    cells: tuple[Count, Count] = (6, 16)
    """Number of cells along width and height."""
    cell: Literal["quadrilateral", "triangle"] = "quadrilateral"
    degree: Literal[1, 2] = 1
    """Polynomial degree of the displacement."""
    refinement: Annotated[float, Number(at_least=1)] = 1.0
    """Longest cell edges over those at the bottom corners."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]*", self.name) or self.name in RESERVED:
            allowed = f"a letter, then letters, digits, _ and -; none of {', '.join(RESERVED)}"
            raise SceneError("name", shown(self.name), allowed)
        if (self.mass is None) == (self.density is None):
            got = "nothing" if self.mass is None else "both mass and density"
            raise SceneError("mass", got, "exactly one of mass and density")
        try:
            representable = 0 < self.shape.mass < math.inf
        except (ValueError, ZeroDivisionError):
            representable = False
        if not representable:
            sizes = f"{self.width:g} x {self.height:g} x {self.thickness:g} m"
            raise SceneError("width", sizes, "a block of finite volume, mass and density")

    @property
    def shape(self) -> Block:
        """The block as a geometric body of uniform density."""
        volume = self.width * self.height * self.thickness
        density = self.density or (self.mass or 0.0) / volume  # one of them is there
        size = {"width": self.width, "height": self.height, "thickness": self.thickness}
        return Block(**size, density=density)

    @property
    def tilt(self) -> float:
        """`tilt_deg` in rad."""
        return math.radians(self.tilt_deg)


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundationSpec(Checked):
    """What carries the blocks: `[foundation]`."""

    kind: Literal["rigid"] = "rigid"


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSpec(Checked):
    """Contact and friction: `[contact]`."""

    points: Literal["nodes", "gauss"] = "nodes"
    """Contact points: Gauss-Lobatto, for rocking, or Gauss, for sliding."""
    gamma: Positive = 100.0
    """Nondimensional Nitsche parameter: gamma (lambda + 2 mu) degree^2 / h."""
    theta: Literal[1, 0, -1] = 1
    """Nitsche variant: symmetric, plain, skew-symmetric."""
    friction: NotNegative = 0.6
    """Coulomb's mu."""
    velocity_solve: bool = True
    """Second contact solve, for the velocities, after each step."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DampingSpec(Checked):
    """Rayleigh damping: `[damping]`."""

    mass: NotNegative = 0.0
    """lambda_R, 1/s."""
    stiffness: NotNegative = 0.0
    """beta_R, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SineSpec(Checked):
    """A sine of the ground's acceleration: `[motion]` with kind = "sine"."""

    kind: Literal["sine"] = "sine"
    amplitude_g: Finite
    """Amplitude over 9.81 m/s^2, whatever `gravity` is."""
    period: Positive
    """s."""
    cycles: Positive | None = None
    """Number of periods; None: to the end of the run."""
    start: NotNegative = 0.0
    """s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TableSpec(Checked):
    """The ground's acceleration from a file of two columns: `[motion]` with kind = "table"."""

    kind: Literal["table"] = "table"
    file: Path
    """Time (s) and acceleration; relative to the folder of the scene."""
    units: Literal["g", "m/s2", "cm/s2"] = "g"
    """Of the accelerations; g is 9.81 m/s^2."""
    scale: Finite = 1.0
    """Factor on the accelerations."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)


MotionSpec: TypeAlias = SineSpec | TableSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeSpec(Checked):
    """Time stepping: `[time]`."""

    end: Positive
    """s."""
    step: Positive
    """dt, s."""
    rho_inf: Annotated[float, Number(at_least=0, at_most=1)] = 0.8
    """Spectral radius of generalized-alpha at infinity."""
    initial: Literal["static", "unstressed"] = "static"
    """Begin with gravity in equilibrium (blocks that begin closed), or without stress."""
    smallest: NotNegative = 0.0
    """Smallest step to which steps that do not converge are halved, s; 0 becomes step / 1024."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        if self.step > self.end:
            raise SceneError("step", shown(self.step), f"step <= end = {self.end:g}")
        if self.smallest > self.step:
            raise SceneError("smallest", shown(self.smallest), f"smallest <= step = {self.step:g}")
        if self.smallest == 0:
            object.__setattr__(self, "smallest", self.step / 1024)


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputSpec(Checked):
    """What is written, and how often: `[output]`."""

    every: Positive = 0.01
    """Time between two snapshots of the fields, s."""
    fields: Literal["vtk", "none"] = "vtk"
    history_every: Count = 1
    """Steps between two rows of the history."""
