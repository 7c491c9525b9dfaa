"""Blocks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from geometry import density as densities
from geometry.block import Block
from solver.errors import SceneError, Statement, missing_key
from solver.scene.cells import (
    MeshSize,
    cells_in,
    default_cell_size,
    mesh_of_box,
    mesh_of_file,
    mesh_of_shape,
)
from solver.scene.checking import (
    OPEN,
    Checked,
    exactly_one,
    is_open,
    only_where,
    shown,
)
from solver.scene.contact import FrictionSpec
from solver.scene.container import ContainerName, Load, castings, mass_of, sizes_of
from solver.scene.damping import (
    DEFAULT_RATIO,
    DampingSpec,
    cantilever_frequency,
    restraint,
    sliding_ratio,
    stiffness_damping,
)
from solver.scene.feet import (
    EvenFeetSpec,
    FootSpec,
    block_between_feet,
    block_on_feet,
    single_feet,
)
from solver.scene.mass import (
    PartSpec,
    inertia_tensor,
    refuse_centre,
    refuse_inertia,
    refuse_parts,
    refuse_spread,
    refuse_uneven,
)
from solver.scene.material import Material, Plane
from solver.scene.names import refuse_name
from solver.scene.quantities import (
    Cell,
    Cells,
    Density,
    Dimension,
    Inertia,
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
from solver.scene.shape import (
    Given,
    ShapeSpec,
    Sizes,
    block_of,
    in_space,
    own_keys,
    shift_of,
    solid_of,
)

if TYPE_CHECKING:
    from geometry.cells import Cells as MeshCells
    from geometry.solid import Solid

#: Density of elastic feet over the mean of the block, which has all other mass above them.
FOOT = 1e-3

#: The key that a block without elastic constants needs.
RIGID_MODEL = 'model = "rigid"'

RIGID_ONLY = f"blocks with {RIGID_MODEL} only"
"""The blocks to which keys apply that have no meaning for elastic ones."""

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
    time, output, base, platform, plate, frame, energy, links, contacts."""
    on: str | tuple[str, ...] = OPEN
    """Its carrier: `"foundation"` or the name of another block; or an array of
    [several](#several-supports), whose tops are level. Default: `"foundation"`."""
    given_shape: ShapeSpec | None = field(default=None, metadata={"key": "shape"})
    """What it is where it is no box; see [shapes](#shapes). Default: a box."""
    feet: EvenFeetSpec | tuple[FootSpec, ...] | None = None
    """Pads below the box, which adds their height; see [feet](#feet). Default: none."""
    container: ContainerName | None = None
    """A freight container on its corner castings, its width along x; see [containers](#containers).
    Rigid blocks only. Default: none."""
    load: Load | None = None
    """Of a container: its mass in place of `mass`. Default: this or `mass`."""
    scale: Annotated[float, Number(above=0, powers=(0.0, 1.0))] = OPEN
    """Of a container: its lengths over the true ones, for a model. Default: 1."""
    width: Length = OPEN
    """B, along x, m. Default: required; of a [shape](#shapes) most follow from it,
    of a container all."""
    height: Length = OPEN
    """H, m. Default: as `width`."""
    thickness: Length = OPEN
    """t, across the plane of motion, along y in 3-D, m. Default: 1.0; of round shapes and files it
    follows from the shape."""
    mass: Mass | None = None
    """Mass m of the whole block, kg. Default: this or `density`."""
    density: Density | None = None
    """rho, kg/m³; beside `parts` that of the rest. Default: this or `mass`."""
    centre_of_mass: Position | None = None
    """From the middle of the bottom, upwards last, m; see [uneven mass](#uneven-mass). Default: the
    middle of the block, or as `parts` have it."""
    inertia: Inertia | None = None
    """Rotary inertia about the centre of mass, kg m²; in 3-D about the block's own axes, or a
    symmetric table of 3 x 3. Rigid blocks only. Default: from the density."""
    parts: tuple[PartSpec, ...] = ()
    """Boxes inside the block that have another density; see [uneven mass](#uneven-mass). Default:
    none."""
    model: Literal["elastic", "rigid"] = "elastic"
    """With a mesh; or without one, with 3 unknowns (6 in 3-D)."""
    young: Modulus | None = None
    """Young's modulus E, Pa. Default: elastic: required."""
    poisson: Ratio | None = None
    """Poisson's ratio nu. Default: elastic: required."""
    offset: Place = OPEN
    """Distance of its middle from that of its carrier, along x, before the tilt, m; where there are
    several, from the middle of their tops. Default: 0."""
    offset_second: Place = OPEN
    """Distance between these middles along y, m; 3-D only. Default: 0."""
    position: Position | None = None
    """Place of its centre of mass at the start, m, over the middle of the foundation's top, instead
    of `on` and `offset`; see [places in the air](#places-in-the-air). Default: it stands `on`
    something."""
    tilt_deg: Tilt = 0.0
    """Rigid rotation at the start about the bottom corner on that side, positive towards +x,
    degrees; against its carrier, with which it is tilted if that is. With `position` about its
    centre of mass."""
    tilt_direction_deg: Turn = 0.0
    """Direction in which a positive tilt leans: angle from +x towards +y, degrees; 3-D only."""
    velocity: Vector = OPEN
    """Velocity of its centre of mass at the start, relative to the ground, m/s. Default: 0 in every
    direction."""
    angular_velocity: Rotation = OPEN
    """Angular velocity at the start, rad/s, about that centre: to turn about a corner, a block has
    a `velocity` besides. 2-D: positive when a lean towards +x grows; 3-D: about x, y and z by the
    right-hand rule. Default: 0."""
    cells: Cells = OPEN
    """Cells along width and height; 3-D: width, thickness, height. Default: `[6, 16]`; 3-D: `[6, 6,
    16]`."""
    cell: Cell = OPEN
    """Shape of the cells; each quadrilateral makes two triangles, each hexahedron five tetrahedra.
    Default: the first of those allowed."""
    cell_size: Length = OPEN
    """Length of the edges of the triangles or tetrahedra that an elastic [shape](#shapes), or box
    on feet, is meshed by, in place of `cells`, `cell` and `refinement`, m. Default: by the box
    around the shape, or above the feet, a tenth of the geometric mean of its sides and at most a
    fourth of the shortest one; 3-D: an eighth, and half of it."""
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
        if self.container is not None:
            yield from self._of_container(self.container)
        elif is_open(self.thickness) and (
            self.given_shape is None or not self.given_shape.is_round
        ):
            yield "thickness", 1.0

    def _of_container(self, name: ContainerName) -> Iterator[tuple[str, Any]]:
        """Scale, lengths and mass of a container; a load stands for its mass."""
        scale = 1.0 if is_open(self.scale) else self.scale
        yield "scale", scale
        for key, value in sizes_of(name, scale).items():
            self._refuse_other(key, value, "the container")
            yield key, value
        if self.load is None:
            return
        for key in ("mass", "density", "parts"):
            if getattr(self, key) not in (None, ()):
                raise SceneError("load", f"both load and {key}", "one of them")
        if scale != 1.0:
            raise Statement("load", f"is that of scale 1: give a model of scale {scale:g} its mass")
        yield "mass", mass_of(name, self.load)
        yield "load", None

    def _refuse_other(self, key: str, value: float, of: str) -> None:
        """Refuse a length that is given, and is not the one that follows."""
        given = getattr(self, key)
        if not is_open(given) and abs(given - value) > 1e-9 * value:
            raise SceneError(key, shown(given), f"that of {of}, {value:.10g}, or nothing")

    def check(self) -> None:
        """Refuse values that do not go together."""
        refuse_name(self.name)
        self._check_place()
        self._check_lengths()
        self._check_mass()
        only_where(self, self.model == "rigid", RIGID_ONLY, "inertia", "restitution")
        if self.model == "elastic":
            for key, range_ in (("young", "young > 0"), ("poisson", "0 <= poisson < 0.5")):
                if getattr(self, key) is None:
                    raise missing_key(key, f"for an elastic block ({range_}), or set {RIGID_MODEL}")

    def _check_lengths(self) -> None:
        """Refuse a block without its lengths, and what does not go with a shape."""
        shape = self.given_shape
        self._check_container()
        if self.feet == ():
            raise SceneError("feet", "none", "a table for all, or an array of one table each")
        only_where(self, shape is None, "boxes only; a shape has them as shape.union", "feet")
        for key in ("width", "height") if shape is None else own_keys(shape):
            if is_open(getattr(self, key)):
                raise missing_key(key, f"({key} > 0)")
        self._check_cells()
        if shape is None:
            return
        shape.refuse_keys_of_parts()
        what = f"boxes, and shapes with {RIGID_MODEL}, only"
        only_where(self, self.model == "rigid", what, "centre_of_mass")
        if self.parts:
            raise Statement("parts", "are for boxes; a shape has them as shape.union")
        if self.centre_of_mass is not None and self.inertia is None:
            raise missing_key("inertia", "beside the centre_of_mass of a shape")

    def _check_container(self) -> None:
        """Refuse a container that is something else, too, and its keys without one."""
        if self.container is None:
            only_where(self, False, "containers only", "load", "scale")
            return
        only_where(self, self.model == "rigid", RIGID_ONLY, "container")
        for key, other in (("shape", self.given_shape), ("feet", self.feet)):
            if other is not None:
                raise SceneError(key, f"both container and {key}", "one of them")
        if not self.parts and self.mass is self.density is None:
            raise missing_key("load", '(of a container, "empty" or "full"; or its mass)')

    def _check_cells(self) -> None:
        """Refuse keys of the mesh that its shape does not have."""
        if self.model == "rigid" and self.given_shape is None and not self.is_box:
            return
        if self.is_box:
            what = "blocks with a shape only; a box has cells"
            only_where(self, False, what, "cell_size")
            return
        what = "shapes that are meshed; a .msh is taken as it is"
        only_where(self, not self.takes_mesh, what, "cell_size")
        what = "a shape has a cell_size" if self.feet is None else "on feet it has a cell_size"
        only_where(self, False, f"boxes only; {what}", "cells", "cell", "refinement")

    def _check_mass(self) -> None:
        """Refuse a mass that is not given, or given twice."""
        if not self.parts:
            exactly_one(self, "mass", "density")
        else:
            for key in ("mass", "centre_of_mass", "inertia"):
                if getattr(self, key) is not None:
                    raise Statement(key, "follows from density and parts; give it or these")
            if self.density is None:
                raise missing_key("density", "beside parts: that of the rest of the block")

    def _check_spread(self, dimension: Dimension) -> None:
        """Refuse a centre of mass, an inertia or parts that a block of this dimension cannot have.

        Where the density follows from the centre of mass, it must be negative nowhere.
        """
        refuse_parts(self.parts, self._sizes(dimension))
        if self.inertia is not None:
            if isinstance(self.inertia, tuple) != (dimension == 3):
                allowed = "inertia > 0" if dimension == 2 else "3 values, or a table of 3 x 3,"
                where = f"{allowed} where dimension = {dimension}"
                raise SceneError("inertia", shown(self.inertia), where)
            refuse_inertia(self.inertia)
        low, high = self._ends(dimension)
        if self.centre_of_mass is not None:
            refuse_centre(self.centre_of_mass, low, high)
        if self.inertia is not None:
            body = self._body(dimension)
            refuse_spread(self.inertia, body.mass, body.centre_of_mass(dimension), low, high)
        elif self.centre_of_mass is not None:
            refuse_uneven(self._linear_density(self.centre_of_mass), self.model)

    def _sizes(self, dimension: int) -> tuple[float, ...]:
        """Its edges along x, in space y, and upwards, m."""
        return (self.width, *[self.thickness][: dimension - 2], self.height)

    def _ends(self, dimension: Dimension) -> tuple[Sequence[float], Sequence[float]]:
        """Lowest and highest corner of the box around it, without its feet, in its own frame, m."""
        if self.given_shape is None:
            *across, height = self._sizes(dimension)
            return [*(-side / 2 for side in across), 0.0], [*(side / 2 for side in across), height]
        solid = self._solid(dimension)
        return list(map(float, solid.low)), list(map(float, solid.high))

    def _linear_density(self, centre: tuple[float, ...]) -> densities.LinearDensity:
        """The density over its mean that has a centre of mass."""
        off = *centre[:-1], centre[-1] - self.height / 2
        return densities.LinearDensity(off=off, sizes=self._sizes(len(centre)))

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
        sized = replace(self, **self._lengths_in(dimension))
        sized._feet_in(dimension)
        sized._check_spread(dimension)
        still: Any = (0.0,) * dimension
        spin = 0.0 if dimension == 2 else still
        return replace(
            sized,
            velocity=still if is_open(self.velocity) else self.velocity,
            angular_velocity=spin if is_open(self.angular_velocity) else self.angular_velocity,
            **self._cells_in(dimension),
        )

    def _cells_in(self, dimension: Dimension) -> dict[str, Any]:
        """Number and shape of the cells of a box; their size in a shape, if that is elastic."""
        if self.is_box or (self.given_shape is None and self.model == "rigid"):
            return cells_in(self.cells, self.cell, dimension, DEFAULT_CELLS[dimension])
        if self.takes_mesh:
            self._own_cells()  # is refused here if it is none
        if self.model == "rigid" or self.takes_mesh:
            return {}
        extents = list(self._extents(dimension))
        if is_open(self.cell_size):
            return {"cell_size": default_cell_size(extents)}
        if self.cell_size > max(extents):
            raise SceneError("cell_size", shown(self.cell_size), f"at most {max(extents):.4g}")
        return {}

    def _extents(self, dimension: Dimension) -> tuple[float, ...]:
        """Sides of the box around a shape, or of the box above its feet, m."""
        return tuple(high - low for low, high in zip(*self._ends(dimension), strict=True))

    @property
    def is_box(self) -> bool:
        """True of a box without feet or corner castings."""
        return self.given_shape is None and self.feet is None and self.container is None

    @property
    def takes_mesh(self) -> bool:
        """True if it is elastic and its mesh is that of a file."""
        is_mesh = self.given_shape is not None and self.given_shape.is_mesh
        return is_mesh and self.model == "elastic"

    def _lengths_in(self, dimension: Dimension) -> dict[str, Any]:
        """Width, height and thickness of a shape, which may stand there but not otherwise."""
        if self.given_shape is None:
            return {}
        self.given_shape.in_dimension(dimension)
        solid = self._solid(dimension)
        if self.model == "elastic" and solid.surface is not None and self.given_shape.union:
            allowed = f"one of these alone, a union of other shapes, or {RIGID_MODEL}"
            raise SceneError("shape", "a union with a file or a hollow profile", allowed)
        x, *y, z = map(float, solid.high - solid.low)
        found: dict[str, Any] = {"width": x, "height": z}
        if self.given_shape.kind == "regular":  # whose width is that of its circle
            found["width"] = self.width
        found["thickness"] = y[0] if y else solid.thickness
        for key, value in found.items():
            self._refuse_other(key, value, "the shape")
        return found

    def _feet_in(self, dimension: Dimension) -> tuple[FootSpec, ...]:
        """All feet, each for itself; SceneError where they are not below the box."""
        if self.container is not None:
            return castings(self.container, self.scale, dimension)
        if self.feet is None:
            return ()
        return single_feet(self.feet, (self.width, self.thickness), dimension)

    def _solid(self, dimension: Dimension) -> Solid:
        """Its shape, which is given."""
        assert self.given_shape is not None
        return solid_of(self.given_shape, self._shape_sizes, dimension)

    def shift(self, dimension: Dimension) -> tuple[float, ...]:
        """By what its shape is moved from its file to its own frame, m."""
        assert self.given_shape is not None
        return shift_of(self.given_shape, self._shape_sizes, dimension)

    @property
    def _shape_sizes(self) -> Sizes:
        """What the keys of the block say of its shape."""
        width = self.width if self.given_shape and self.given_shape.kind == "regular" else None
        height = self.height if self.given_shape and self.given_shape.kind == "cylinder" else None
        return Sizes(width, height, self.thickness or 1.0, self.density or 1.0)

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
    def _dimension(self) -> Dimension:
        """Of its scene."""
        return 2 if len(self.velocity) == 2 else 3

    @property
    def shape(self) -> Block:
        """The block as a geometric body with its mass."""
        dimension = self._dimension
        box, feet = self._body(dimension), self._feet_in(dimension)
        if self.container is not None:  # whose height is that over its castings
            return block_between_feet(box, feet, dimension)
        return block_on_feet(box, feet, dimension) if feet else box

    def _body(self, dimension: Dimension) -> Block:
        """The block without its feet; a container as the box around it."""
        if self.given_shape is not None:
            tensor = None if self.inertia is None else inertia_tensor(self.inertia)
            given = Given(self.mass, self._centre_in_space(), tensor)
            return block_of(self.given_shape, self._shape_sizes, dimension, given)
        lengths = self.width, self.height, self.thickness
        size: dict[str, Any] = dict(zip(("width", "height", "thickness"), lengths, strict=True))
        volume = math.prod(lengths)
        if self.parts:
            assert self.density is not None
            edges = self.width, self.thickness, self.height
            found = densities.mass_of_parts(edges, self.density, self._parts_in_space())
            centre, tensor = in_space(found.centre, max(edges)), inertia_tensor(found.inertia)
            return Block(**size, density=found.volume / volume, centre=centre, inertia=tensor)
        density = self.density or (self.mass or 0.0) / volume  # one of them is there
        tensor = None if self.inertia is None else inertia_tensor(self.inertia)
        return Block(**size, density=density, centre=self._centre_in_space(), inertia=tensor)

    def _centre_in_space(self) -> densities.Vector | None:
        """The given centre of mass along x, y and upwards, m; None: the middle of the block."""
        if self.centre_of_mass is None:
            return None
        x, *second, height = self.centre_of_mass
        y = second[0] if second else 0.0
        return None if (x, y, height) == (0.0, 0.0, self.height / 2) else (x, y, height)

    def _parts_in_space(self) -> list[densities.Part]:
        """The parts as boxes in space, in the plane as thick as the block."""
        found = []
        for spec in self.parts:
            part, half = spec.part, self.thickness / 2
            if len(part.low) == 2:
                (x, y), (right, top) = part.low, part.high
                part = densities.Part((x, -half, y), (right, half, top), part.density)
            found.append(part)
        return found

    def relative_density(self) -> densities.Density | None:
        """Its density over the mean; None: it is the same everywhere, or not known (inertia)."""
        solid = self.shape.solid
        if self.feet is not None:
            assert solid is not None
            levels = solid.parts[0].corners[:, -1]
            whole, above = solid.parts_volume, self.width * self.height * self.thickness
            share = (whole - FOOT * (whole - above)) / above
            return densities.FootedDensity(
                low=float(levels.min()),
                high=float(levels.max()),
                box=share,
                feet=FOOT,
                law=self._density_of_box(),
            )
        if solid is not None and solid.surface is None:
            known = [part.density for part in solid.parts]
            if max(known) > min(known) * (1 + 1e-12):
                return densities.PiecewiseDensity(parts=solid.parts, mean=self.shape.density)
        return self._density_of_box()

    def _density_of_box(self) -> densities.LinearDensity | densities.PartedDensity | None:
        """The density of the box over its mean."""
        if self.parts:
            assert self.density is not None
            mean = self._body(self._dimension).density
            parts = (spec.part._replace(density=spec.density / mean) for spec in self.parts)
            return densities.PartedDensity(rest=self.density / mean, parts=tuple(parts))
        if self.centre_of_mass is None or self.inertia is not None:
            return None
        if self._centre_in_space() is None:
            return None
        return self._linear_density(self.centre_of_mass)

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

    @property
    def mesh(self) -> MeshSize:
        """The size of its mesh, if it is elastic."""
        dimension = self._dimension
        if self.is_box:
            sides = self._sizes(dimension)
            return mesh_of_box(sides, self.cells, self.cell, self.degree, self.refinement)
        if self.takes_mesh:
            return mesh_of_file(self.shape, self._own_cells(), self.degree)
        return mesh_of_shape(self.shape, self.cell_size, self.degree, dimension)

    @property
    def mesh_in_words(self) -> str:
        """The size of its mesh, or that there is none."""
        if self.model == "rigid":
            return f"none: rigid, {3 if self._dimension == 2 else 6} unknowns"
        return str(self.mesh)

    def _own_cells(self) -> MeshCells:
        """The cells of the mesh of its file."""
        assert self.given_shape is not None
        return self.given_shape.cells()

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
