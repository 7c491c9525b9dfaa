"""Shapes of blocks that are no boxes: `shape = { ... }` of a block."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, TypeAlias

from geometry.block import Block
from geometry.density import Tensor, Vector
from solver.errors import SceneError, Statement, below, missing_key, not_applicable
from solver.scene.checking import OPEN, Checked, is_open, only_where
from solver.scene.mass import inertia_tensor
from solver.scene.quantities import Density, Dimension, Length, Number, Place, Position

if TYPE_CHECKING:
    from geometry.cells import Cells
    from geometry.solid import Solid
    from solver.types import Array

ROUND = 16
"""Corners from which on a regular polygon is meant to be round."""

Point: TypeAlias = tuple[Place, Place]

KINDS = ("polygon", "regular", "profile", "cylinder", "file", "union")
"""The keys of which a shape has one."""

DEFAULT_SIDES = 48
"""Facets of a round shape, which lie within the circle by 0.2 % of its radius."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeSpec(Checked):
    """The shape of a block, or of one part of it."""

    polygon: tuple[Point, ...] = ()
    """Corners `[x, y]` of its section in the plane of motion, y upwards, m, in their order; in 3-D
    a prism along y. Need not be convex. Default: -."""
    regular: Annotated[int, Number(at_least=3, at_most=1000)] | None = None
    """Number of the corners of a regular polygon on one of its sides; `width` is twice the radius
    of the circle through them. In 3-D a prism along y: a drum that rolls along x. Default: -."""
    profile: tuple[Point, ...] = ()
    """Half the outline of a body of revolution about the vertical axis, corners `[r, z]`, m, from
    the axis to the axis, or around a ring; may be hollow or undercut. 3-D only. Default: -."""
    cylinder: Length | None = None
    """Diameter of an upright cylinder, as high as `height`, m; 3-D only. Default: -."""
    sides: Annotated[int, Number(at_least=3, at_most=1000)] = OPEN
    """Facets for which a `profile` or `cylinder` stands; corners lie on its circle. Default: 48."""
    file: Path | None = None
    """A closed surface: .stl, .obj, .ply, the body of a .step, or the outside of a mesh, .msh,
    .vtu; relative to the scene's file; 3-D only. Mass, centre and inertia are those of the surface
    itself; an elastic block has the mesh of a .msh as it is. Default: -."""
    scale: Annotated[float, Number(above=0, powers=(0.0, 1.0))] = OPEN
    """Length of a unit of the file, m; of a .step, which has units, times these. Default: 1."""
    contact: Literal["hull", "coacd"] = OPEN
    """What contacts see of a file: its convex `"hull"`, or the convex parts into which CoACD cuts
    it, which has to be installed. Default: `"hull"`."""
    union: tuple[ShapeSpec, ...] = ()
    """Parts that touch one another, and do not overlap, each a table like this one. Default: -."""
    at: Position | None = None
    """Of a part: where the origin of its coordinates is; that of `regular` and `cylinder` is the
    middle of the bottom. Default: 0 in every direction."""
    width: Length | None = None
    """Of a part that is `regular`: twice its radius, m. Default: -."""
    height: Length | None = None
    """Of a part that is a `cylinder`, m. Default: -."""
    thickness: Length | None = None
    """Of a part that is a prism, in 3-D, along y, m. Default: that of the block."""
    density: Density | None = None
    """Of a part, kg/m³. Default: that of the block."""

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """Numbers of facets, and units of files."""
        if is_open(self.sides) and (self.profile or self.cylinder is not None):
            yield "sides", DEFAULT_SIDES
        if is_open(self.scale) and self.file is not None:
            yield "scale", 1.0
        if is_open(self.contact) and self.file is not None:
            yield "contact", "hull"

    def check(self) -> None:
        """Refuse what is no shape, or several."""
        given = [kind for kind in KINDS if getattr(self, kind) not in (None, ())]
        allowed = f"exactly one of {', '.join(KINDS)}"
        if not given:
            raise missing_key(KINDS[0], f"({allowed})")
        if len(given) > 1:
            raise SceneError(given[1], f"it beside {given[0]}", allowed)
        turned = self.profile or self.cylinder is not None
        only_where(self, turned, "a profile or a cylinder only", "sides")
        only_where(self, self.file is not None, "a file only", "scale", "contact")
        for part in self.union:
            if part.union:
                raise not_applicable("union", "the shape of a block, not a part of one")

    @property
    def kind(self) -> str:
        """The key that says what it is."""
        return next(kind for kind in KINDS if getattr(self, kind) not in (None, ()))

    @property
    def is_mesh(self) -> bool:
        """True of a file that is the mesh of an elastic block, which takes it as it is."""
        return self.file is not None and self.file.suffix.lower() == ".msh"

    def cells(self) -> Cells:
        """The cells of the mesh of a file.

        Raises:
            Statement: It is not one of one body in space.
        """
        from geometry.mesh_file import read_cells

        assert self.file is not None
        try:
            return read_cells(self.file, self.scale)
        except ValueError as error:
            raise Statement("shape.file:", str(error)) from None

    @property
    def is_round(self) -> bool:
        """True if it has a thickness of its own."""
        return self.kind in ("profile", "cylinder", "file")

    def radius(self, width: float | None) -> float | None:
        """The largest radius of a round shape, m; None of others, such as polygons of few sides.

        Args:
            width: That of the block, m, for a regular polygon without its own.
        """
        if self.profile:
            return max(r for r, _ in self.profile)
        if self.cylinder is not None:
            return self.cylinder / 2
        if self.regular is not None and self.regular >= ROUND:
            return (self.width or width or 0.0) / 2
        return None

    def refuse_keys_of_parts(self) -> None:
        """Refuse what only a part of a union has; the block itself has these keys."""
        keys = ("at", "width", "height", "thickness", "density")
        with below("shape"):
            only_where(self, False, "a part of a union only", *keys)

    def in_dimension(self, dimension: Dimension) -> None:
        """Refuse shapes that there are not in a dimension."""
        for key in ("profile", "cylinder", "file"):
            if dimension == 2 and getattr(self, key) not in (None, ()):
                other = {"cylinder": " (a disc: regular = 100)"}.get(key, "")
                raise not_applicable(f"shape.{key}", f"3-D scenes only{other}")
        for part in self.union:
            part.in_dimension(dimension)


class Sizes(NamedTuple):
    """What the keys of a block say of its shape beside the shape itself, m and kg/m3."""

    width: float | None
    height: float | None
    thickness: float
    density: float


class Given(NamedTuple):
    """What the keys of a block say of its mass; None: it follows from the shape."""

    mass: float | None
    """kg."""
    centre: Vector | None
    """Of mass, along x, y and upwards in the block's own frame, m."""
    inertia: Tensor | None
    """About that centre, kg m2."""


def own_keys(shape: ShapeSpec) -> tuple[str, ...]:
    """The keys of a block that its shape needs; other lengths follow from it."""
    return {"regular": ("width",), "cylinder": ("height",)}.get(shape.kind, ())


@lru_cache(maxsize=256)
def solid_of(shape: ShapeSpec, sizes: Sizes, dimension: Dimension) -> Solid:
    """The shape as a body in the own frame of its block.

    Raises:
        SceneError: The key, and what is wrong with it.
    """
    return _part(shape, sizes, dimension, "shape").standing()


@lru_cache(maxsize=256)
def shift_of(shape: ShapeSpec, sizes: Sizes, dimension: Dimension) -> tuple[float, ...]:
    """By what a shape is moved from where its numbers are to the own frame of its block, m."""
    there = _part(shape, sizes, dimension, "shape").low
    return tuple(float(x) for x in solid_of(shape, sizes, dimension).low - there)


@lru_cache(maxsize=256)
def block_of(shape: ShapeSpec, sizes: Sizes, dimension: Dimension, given: Given) -> Block:
    """The shape as a block with its mass."""
    solid = solid_of(shape, sizes, dimension)
    if given.mass is not None:
        solid = solid.with_mass(given.mass)
    x, *across, height = map(float, solid.high - solid.low)
    ends = solid.bottom[:, 0]
    return Block(
        width=x,
        height=height,
        thickness=across[0] if across else solid.thickness,
        density=solid.mass / solid.volume,
        centre=given.centre or in_space(solid.centre, solid.size),
        inertia=given.inertia or inertia_tensor(solid.inertia),
        base=(float(ends.min()), float(ends.max())),
        solid=solid,
    )


def in_space(place: Array, size: float) -> Vector:
    """A place along x, y and upwards, in the middle where it is off by round-off of the size."""
    x, *y, z = (0.0 if abs(each) < 1e-14 * size else float(each) for each in place)
    return x, y[0] if y else 0.0, z


def _part(shape: ShapeSpec, sizes: Sizes, dimension: Dimension, where: str) -> Solid:
    """A shape in the frame in which its numbers are given."""
    from geometry import shapes  # numpy and more: scenes of boxes do without
    from geometry.surface_file import read_surface

    density, kind = shape.density or sizes.density, shape.kind
    thickness = shape.thickness or sizes.thickness
    try:
        if kind == "union":
            members = []
            for number, part in enumerate(shape.union, start=1):
                name = f"{where}.union.{number}"
                for key in own_keys(part):
                    if getattr(part, key) is None:
                        raise missing_key(f"{name}.{key}", f"({key} > 0, m)")
                made = _part(part, sizes._replace(width=None, height=None), dimension, name)
                members.append(made.moved(part.at or (0.0,) * dimension))
            return shapes.union(members)
        if kind == "polygon":
            flat = shapes.polygon(shape.polygon, density, thickness)
            return flat if dimension == 2 else shapes.prism(flat, thickness)
        if kind == "regular":
            assert shape.regular is not None
            width = shape.width or sizes.width or 0.0
            flat = shapes.regular(shape.regular, width, density, thickness)
            return flat if dimension == 2 else shapes.prism(flat, thickness)
        if kind == "profile":
            return shapes.turned(shape.profile, shape.sides, density)
        if kind == "cylinder":
            assert shape.cylinder is not None
            height = shape.height or sizes.height or 0.0
            return shapes.cylinder(shape.cylinder, height, shape.sides, density)
        assert shape.file is not None
        surface = read_surface(shape.file, shape.scale)
        return shapes.of_surface(surface, density, shape.contact)
    except ValueError as error:
        said = str(error).removeprefix(f"{kind}: ").removeprefix("union: ")
        raise Statement(f"{where}.{kind}:", said) from None
