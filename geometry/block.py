"""Blocks: boxes and other shapes, and the numbers that rigid-body rocking is written in."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from geometry.density import Tensor, Vector, linear_tensor, tensor_of

if TYPE_CHECKING:
    from geometry.solid import Solid

FACES: tuple[tuple[int, ...], ...] = (
    *((3, 2, 1, 0), (4, 5, 6, 7)),
    *((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
)
"""Numbers of the corners around each face of a block in space, anticlockwise from outside: those of
the bottom, the top, the sides; corners as `Block.corners` has them, which is VTK's order, too."""

SIDES = (1, -1)
"""The edges of the bottom on which a block rocks: towards +x, and towards -x."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A block, B x H x t, even or not in its mass; symbols after Housner (1963).

    It is a box, or a solid for which the box stands that is around it.

    Where the centre of mass is off the middle, the two edges of the bottom differ: what is asked of
    a `side` is about the edge on that side, 1 towards +x and -1 towards -x, on which the block
    rocks while it leans there. Side 0 is the edge over which it overturns first.
    """

    width: float
    """B, m, > 0; in the plane of motion."""
    height: float
    """H, m, > 0."""
    thickness: float
    """t, m, > 0; across the plane of motion."""
    density: float
    """rho, kg/m^3, > 0; the mean where it is not the same everywhere."""
    centre: Vector | None = None
    """Centre of mass from the middle of the bottom, along x, y and upwards, m; None: the middle."""
    inertia: Tensor | None = None
    """Inertia tensor about the centre of mass, kg m^2, about x, y and z; None: that of a density
    which varies linearly, or not at all where the centre of mass is in the middle."""
    base: tuple[float, float] | None = None
    """Ends of the bottom along x, from its middle, m; None: it is as wide as the block."""
    solid: Solid | None = None
    """Its shape in its own frame where it is no box; centre, inertia and base are given, too."""
    bottom: tuple[tuple[float, ...], ...] = ()
    """Corners on which a solid may stand, m; none: the lowest ones."""
    feet: int = 0
    """Number of the feet that it stands on, which are the last ones of its parts."""
    walls: tuple[float, float] | None = None
    """Levels between which its faces are, m, where feet are beyond them; None: all its height."""

    def __post_init__(self) -> None:
        """Refuse what is no block."""
        for name in ("width", "height", "thickness", "density"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"Block.{name}: got {value}, allowed a number > 0")

    @property
    def is_even(self) -> bool:
        """True if its mass is that of a homogeneous block, so that both sides are alike."""
        return self.centre is None and self.inertia is None

    @property
    def volume(self) -> float:
        """Volume V, m^3: B H t of a box."""
        if self.solid is not None:
            return self.solid.volume
        return self.width * self.height * self.thickness

    @property
    def mass(self) -> float:
        """Mass m = rho V, kg."""
        if self.solid is not None:
            return self.density * self.solid.volume
        return self.density * self.width * self.height * self.thickness

    @property
    def half_diagonal(self) -> float:
        """Half diagonal sqrt(B^2 + H^2) / 2, m: its size, whatever its mass."""
        return math.hypot(self.width, self.height) / 2

    def centre_of_mass(self, dimension: int = 2) -> tuple[float, ...]:
        """The centre of mass in its own frame (origin at the bottom centre), m."""
        x, y, z = self.centre or (0.0, 0.0, self.height / 2)
        return (x, z) if dimension == 2 else (x, y, z)

    def middle(self, dimension: int = 2) -> tuple[float, ...]:
        """The middle of the box in its own frame, m: its centre of mass where it is even."""
        if self.solid is not None:
            return tuple(map(float, (self.solid.low + self.solid.high) / 2))
        return (*[0.0] * (dimension - 1), self.height / 2)

    @property
    def centre_height(self) -> float:
        """Height h of the centre of mass above the bottom, m."""
        return self.height / 2 if self.centre is None else self.centre[2]

    def arm(self, side: int = 0) -> float:
        """Distance b of the centre of mass from the edge on a side, along x, m."""
        side = side or self.first_side
        edge = self.width / 2 if self.base is None else side * self.base[(side + 1) // 2]
        return edge if self.centre is None else edge - side * self.centre[0]

    @property
    def first_side(self) -> int:
        """The side of the edge that is nearer to the centre of mass: there it overturns first."""
        if self.centre is None:
            return 1
        low, high = self.base or (-self.width / 2, self.width / 2)
        return -1 if self.centre[0] < (low + high) / 2 else 1

    def radius(self, side: int = 0) -> float:
        """Radius R = sqrt(b^2 + h^2), m, from the edge to the centre of mass."""
        return math.hypot(self.arm(side), self.centre_height)

    def slenderness(self, side: int = 0) -> float:
        """Slenderness alpha = atan(b / h), rad: where the block balances above its edge."""
        return math.atan2(self.arm(side), self.centre_height)

    def uplift(self, side: int = 0) -> float:
        """Acceleration over gravity b / h at which it lifts about the edge on a side."""
        return self.arm(side) / self.centre_height

    @property
    def rotary_inertia(self) -> float:
        """Rotary inertia I about the centre of mass in the plane of motion, kg m^2.

        m (B^2 + H^2) / 12 of a homogeneous block.
        """
        return self.mass * self.half_diagonal**2 / 3 if self.is_even else self.inertia_tensor[1][1]

    @property
    def principal_inertias(self) -> tuple[float, float, float]:
        """Rotary inertias of the homogeneous block about its middle, kg m^2, about x, y and z.

        m (t^2 + H^2)/12, m (B^2 + H^2)/12, m (B^2 + t^2)/12: x along the width, y along the
        thickness, z along the height; the inertia tensor in the block's frame is their diagonal.
        """
        b, t, h = self.width**2, self.thickness**2, self.height**2
        return self.mass * (t + h) / 12, self.mass * (b + h) / 12, self.mass * (b + t) / 12

    @property
    def inertia_tensor(self) -> Tensor:
        """Inertia tensor about the centre of mass in the block's frame, kg m^2."""
        if self.inertia is not None:
            return self.inertia
        middle = self.middle(3)
        off = tuple(c - m for c, m in zip(self.centre_of_mass(3), middle, strict=True))
        return linear_tensor(self.mass, self.principal_inertias, (off[0], off[1], off[2]))

    def half_lengths(self, dimension: int = 2) -> tuple[float, ...]:
        """Half its edges along x, in space y, and upwards, m."""
        b, t, h = self.width / 2, self.thickness / 2, self.height / 2
        return (b, h) if dimension == 2 else (b, t, h)

    @property
    def bottom_area(self) -> float:
        """Area of the bottom, m^2; of a solid that of the lowest faces of its parts down there."""
        if self.solid is None:
            return self.width * self.thickness
        levels = [float(part.corners[:, -1].min()) for part in self.solid.parts]
        high = min(levels) + 1e-6 * self.solid.size
        lowest = [p for p, z in zip(self.solid.parts, levels, strict=True) if z <= high]
        area = math.fsum(part.area(part.lowest_face) for part in lowest)
        return area * (self.thickness if self.solid.dimension == 2 else 1.0)

    @property
    def shortest_edge(self) -> float:
        """Length of the shortest edge of the parts of a solid, m; of a box the shortest side."""
        if self.solid is None:
            return min(self.width, self.height, self.thickness)
        return min(part.shortest_edge for part in self.solid.parts)

    def corners(self, dimension: int = 2) -> tuple[tuple[float, ...], ...]:
        """Its corners in its own frame (origin at the bottom centre), m.

        In the plane counterclockwise from the bottom left one; in space those of the bottom, then
        those of the top, both in that order seen from above. Of a solid those of all its parts.
        """
        if self.solid is not None:
            return tuple(tuple(map(float, corner)) for corner in self.solid.corners)
        b, t = self.width / 2, self.thickness / 2
        if dimension == 2:
            return (-b, 0.0), (b, 0.0), (b, self.height), (-b, self.height)
        ring = (-b, -t), (b, -t), (b, t), (-b, t)
        return tuple((x, y, z) for z in (0.0, self.height) for x, y in ring)

    def bottom_corners(self, dimension: int = 2) -> tuple[tuple[float, ...], ...]:
        """The two, in space four, corners of the bottom farthest out, as `corners` orders them, m.

        In space of a bottom that is no rectangle those farthest along both diagonals.
        """
        bottom = self.standing_corners(dimension)
        if self.solid is None:
            return bottom
        if dimension == 2:
            return min(bottom), max(bottom)
        outwards = (-1, -1), (1, -1), (1, 1), (-1, 1)
        return tuple(max(bottom, key=lambda c: x * c[0] + y * c[1]) for x, y in outwards)

    def standing_corners(self, dimension: int = 3) -> tuple[tuple[float, ...], ...]:
        """The corners on which it may stand, m: those of the bottom, and of all feet."""
        if self.solid is None:
            return self.corners(dimension)[: 2 ** (dimension - 1)]
        return self.bottom or tuple(tuple(map(float, corner)) for corner in self.solid.bottom)

    def pivot(self, direction: Sequence[float]) -> tuple[float, ...]:
        """The point of the bottom that stays where it is as the block leans in a direction, m.

        The corner farthest that way, or the middle of those that are equally far.

        Args:
            direction: Horizontal, (1,) in the plane, (2,) in space.
        """
        d = len(direction) + 1
        level = self.standing_corners(d)
        reach = [_dot(direction, corner[:-1]) for corner in level]
        far = max(reach) - 1e-9 * self.half_diagonal
        ends = [corner for corner, each in zip(level, reach, strict=True) if each >= far]
        return tuple(float(sum(c[i] for c in ends)) / len(ends) for i in range(d))

    def rotary_inertia_about_corner(self, side: int = 0) -> float:
        """Rotary inertia I_O = I + m R^2, kg m^2, about a bottom edge; 4/3 m R^2 where even."""
        if self.is_even:
            return 4 / 3 * self.mass * self.half_diagonal**2
        return self.rotary_inertia + self.mass * self.radius(side) ** 2

    def frequency(self, gravity: float, side: int = 0) -> float:
        """Frequency parameter of rocking p = sqrt(m g R / I_O), 1/s, at gravity g (m/s^2).

        sqrt(3 g / (4 R)) of a homogeneous block.
        """
        if self.is_even:
            return math.sqrt(3 * gravity / (4 * self.half_diagonal))
        moment = self.mass * gravity * self.radius(side)
        return math.sqrt(moment / self.rotary_inertia_about_corner(side))

    def fastest(self, gravity: float) -> float:
        """The larger of both frequency parameters, 1/s."""
        return max(self.frequency(gravity, side) for side in SIDES)

    def restitution(self, side: int = 0, share: float = 0.0) -> float:
        """Ratio of angular velocities across an impact without rebound on the edge of a side.

        By angular momentum about that edge, b away from the centre of mass, from a turn about the
        other one, b' away: (I + m (h^2 - b b'))/(I + m (h^2 + b^2)), which is Housner's 1 - 3/2
        sin^2 alpha for a homogeneous block. On a platform that is free to move, (1 - share) h^2
        stands for h^2; `share` is that of the block in the mass of both.
        """
        if self.is_even:
            if not share:
                return 1 - 1.5 * math.sin(self.slenderness()) ** 2
            high = (4 / 3 - share) * (self.height / 2) ** 2
            wide = (self.width / 2) ** 2
            return (high - 2 / 3 * wide) / (high + 4 / 3 * wide)
        side = side or self.first_side
        lands, leaves = self.arm(side), self.arm(-side)
        high = self.rotary_inertia / self.mass + (1 - share) * self.centre_height**2
        return (high - lands * leaves) / (high + lands**2)

    def across(self, direction: Sequence[float]) -> Block:
        """The block as one that leans in a horizontal direction, a unit vector of its own axes.

        As wide as its bottom is along that direction; x points there.
        """
        x, y = (float(part) for part in direction)
        width, base = abs(x) * self.width + abs(y) * self.thickness, self.base
        thickness = self.width * self.thickness / width
        if self.solid is not None:
            width = _extent([x * c[0] + y * c[1] for c in self.solid.corners])
            along = [x * c[0] + y * c[1] for c in self.standing_corners()]
            base, thickness = (min(along), max(along)), self.volume / (width * self.height)
        centre, inertia = self.centre, None
        if centre is not None:
            centre = x * centre[0] + y * centre[1], x * centre[1] - y * centre[0], centre[2]
        if not self.is_even:
            inertia = turned(self.inertia_tensor, x, y)
        return Block(
            width=width,
            height=self.height,
            thickness=thickness,
            density=self.density,
            centre=centre,
            inertia=inertia,
            base=base,
        )

    def weight(self, gravity: float) -> float:
        """Weight W = m g, N, at gravity g (m/s^2)."""
        return self.mass * gravity


def turned(tensor: Tensor, x: float, y: float) -> Tensor:
    """A tensor in axes of which the first is (x, y, 0), a unit vector, and the last the same."""
    axes: Tensor = (x, y, 0.0), (-y, x, 0.0), (0.0, 0.0, 1.0)
    images = [[_dot(row, axis) for row in tensor] for axis in axes]
    return tensor_of([[_dot(axis, image) for image in images] for axis in axes])


def _extent(values: Sequence[float]) -> float:
    """The largest less the least."""
    return float(max(values) - min(values))


def _dot(one: Sequence[float], other: Sequence[float]) -> float:
    """The scalar product."""
    return sum(a * b for a, b in zip(one, other, strict=True))
