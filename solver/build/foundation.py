"""The support of the blocks of a scene, as a body and as a surface: meshed, reduced, or rigid."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import singledispatch
from itertools import product
from typing import Any, NamedTuple

from mpi4py import MPI

import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from dolfinx.mesh import compute_midpoints

from geometry.foundation import Frame, Plate, Storey, level_frame
from geometry.frame_mesh import FrameCells, frame_mesh
from geometry.gmsh_model import MeshedBody
from geometry.mesh import plate_mesh
from geometry.tags import FacetTag
from solver.bodies.craig_bampton import FixedInterface, Shapes, linearised, reduced_matrices
from solver.bodies.elastic_body import ElasticBody, GroundSpring, Support
from solver.bodies.elastic_forms import Region
from solver.bodies.memory import require
from solver.bodies.modes import STATIC, eigenvalues, sway_frequency
from solver.bodies.reduced_body import (
    ReducedBody,
    ReducedFacts,
    ReducedParts,
    Reduction,
)
from solver.bodies.rigid_body import Oscillator
from solver.bodies.surface_layer import RowsLayer
from solver.build.meshed_body import meshed_body
from solver.contact.body_points import FixedPoints, RigidPoints
from solver.contact.carriers import Carrier, Face, Plane
from solver.contact.facets import Facets, carrier_surface
from solver.errors import NotConverged, SceneError
from solver.excitation.motion import GroundMotion, read_ground
from solver.excitation.spectrum import highest_frequency
from solver.parallel import global_sum, on_first_rank
from solver.scene import Scene
from solver.scene.damping import DampingSpec, stiffness_damping
from solver.scene.foundation import FeetSpec, Foundation, FrameSpec, OscillatorSpec, PlateSpec
from solver.scene.material import Material
from solver.types import Array, Indices, Mask


class Foot(NamedTuple):
    """Base of a column on the ground."""

    nodes: Indices
    """Owned nodes of the body."""
    centre: Array
    """Its centre along x, in space also along y, m."""


class Storeys(NamedTuple):
    """The parts of a frame that a history tells of; a plate on rollers has none."""

    feet: Sequence[Foot] = ()
    """Feet of its columns: from -x to +x, in space round it from (-x, -y) by (+x, -y)."""
    floors: Sequence[Any] = ()
    """Rows of the mean horizontal motion of the top of each deck, from the lowest upwards, by the
    owned unknowns: sparse or dense matrices, (d - 1, owned d)."""


NO_STOREYS = Storeys()


@dataclass(slots=True)
class FoundationBody:
    """The support of the blocks.

    Attributes:
        carrier: The surface that blocks stand on.
        number: Of its body in the system; None for what does not move.
        body: The body; None for what does not move.
        surface: Facets of the top of a meshed one.
        held: Linear displacements on the mesh of a fully restrained plate, all of them zero.
        storeys: Parts of a meshed one that moves as a whole.
        reduction: What a reduced one keeps of its mesh; None for others.
    """

    carrier: Carrier
    number: int | None = None
    body: Oscillator | ElasticBody | ReducedBody | None = None
    surface: Facets | None = None
    held: fem.FunctionSpace | None = None
    storeys: Storeys = NO_STOREYS
    reduction: Reduction | None = None

    @classmethod
    def on_facets(
        cls,
        number: int,
        body: ElasticBody | ReducedBody,
        surface: Facets,
        storeys: Storeys = NO_STOREYS,
        reduction: Reduction | None = None,
    ) -> FoundationBody:
        """A meshed body that carries blocks on these facets."""
        top = Face.of_mesh(body, surface, level_frame(body.dimension))
        return cls(top, number, body, surface, storeys=storeys, reduction=reduction)


def _fixed_face(positions: Array) -> Face:
    """The level rectangle around some positions (n, d), m, as a face of one facet that is fixed.

    On what neither rises nor is stretched all facets are one.
    """
    low, high = positions.min(axis=0), positions.max(axis=0)
    ends = np.array(list(product((0, 1), repeat=len(low) - 1)))[:, ::-1]  # as basix counts corners
    corners = low + np.column_stack([ends, np.zeros(len(ends))]) * (high - low)
    cell, frame = "interval" if len(low) == 2 else "quadrilateral", level_frame(len(low))
    ring = corners if len(low) == 2 else corners[[0, 1, 3, 2]]
    return Face(FixedPoints(corners), np.arange(len(corners))[None], frame, cell, rings=(ring,))


def with_top(
    body: ElasticBody, made: MeshedBody, number: int, storeys: Storeys = NO_STOREYS
) -> FoundationBody:
    """A meshed body that carries blocks on its top."""
    surface = carrier_surface(body.space, made.facet_tags, int(FacetTag.TOP))
    return FoundationBody.on_facets(number, body, surface, storeys)


def damping_of(
    scene: Scene,
    spec: PlateSpec | FrameSpec,
    alone: Callable[[MPI.Intracomm], ElasticBody],
) -> DampingSpec | None:
    """Rayleigh damping of a meshed foundation; collective.

    By the ratio of its first sway mode where that is given: `alone` makes the body without damping,
    on every rank for itself.
    """
    ratio = spec.sway_damping_ratio
    if not ratio:
        return scene.damping_of(spec) if ratio is None else None
    return stiffness_damping(ratio, sway_frequency(alone(MPI.COMM_SELF)))


def build_frame(spec: FrameSpec, scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """Build a frame; `number` is that of its body."""
    damping = damping_of(scene, spec, lambda own: _body(spec, scene, None, own)[0])
    body, made = _body(spec, scene, damping, comm)
    return with_top(body, made, number, _storeys(spec, body))


def _storeys(spec: FrameSpec, body: ElasticBody) -> Storeys:
    """The feet and the floors of a frame, by the places of its nodes."""
    near = 1e-9 * spec.deck.width
    level = body.nodes[:, -1]
    grounded = np.flatnonzero(np.abs(level + spec.depth) < near)
    feet = []
    for centre in _centres(spec, body.dimension):
        sizes = np.array([spec.column.width, spec.column.thickness])[: body.dimension - 1]
        off = np.abs(body.nodes[grounded, :-1] - centre)
        feet.append(Foot(grounded[np.all(off < sizes / 2 + near, axis=1)], centre))
    tops = _shape(spec, body.dimension).levels[2::2]
    return Storeys(feet, [_mean(body, np.abs(level - top) < near) for top in tops])


def _mean(body: ElasticBody, there: Mask) -> sp.csr_matrix:
    """Rows of the mean horizontal motion of some owned nodes and of those of other ranks."""
    nodes, d = np.flatnonzero(there), body.dimension
    count = float(global_sum(body.comm, np.array([float(len(nodes))]))[0])
    rows = np.repeat(np.arange(d - 1), len(nodes))
    columns = np.concatenate([nodes * d + k for k in range(d - 1)])
    shares = np.full(len(columns), 1 / count)
    return sp.csr_matrix((shares, (rows, columns)), shape=(d - 1, body.size))


def _centres(spec: FrameSpec, dimension: int) -> list[Array]:
    """Centres of the columns in plan, in their order, m."""
    outer = (spec.deck.width - spec.column.width) / 2
    if dimension == 2:
        return [np.array([x]) for x in np.linspace(-outer, outer, spec.bays + 1)]
    side = (spec.deck.thickness - spec.column.thickness) / 2
    return [np.array([sx * outer, sy * side]) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _body(
    spec: FrameSpec, scene: Scene, damping: DampingSpec | None, comm: MPI.Intracomm
) -> tuple[ElasticBody, MeshedBody]:
    """The body of a frame on its feet, and its mesh."""
    frame = _shape(spec, scene.dimension)
    cells = FrameCells(**asdict(spec.cells))
    made = frame_mesh(frame, dimension=scene.dimension, cells=cells, comm=comm)
    *others, material = (spec.material(scene.material_plane, layer) for layer in spec.layers)
    supports, spring = _on_feet(spec, scene.dimension, made, damping)
    body = meshed_body(
        scene,
        spec.kind,
        made,
        material=material,
        thickness=spec.deck.thickness,
        degree=spec.degree,
        damping=damping,
        supports=supports,
        spring=spring,
        regions=_regions(made, frame, others, material),
    )
    return body, made


def _regions(
    made: MeshedBody, frame: Frame, others: Sequence[Material], material: Material
) -> list[Region]:
    """The cells below the uppermost deck whose material is another one than its own."""
    topology = made.mesh.topology
    cells = topology.index_map(topology.dim)
    numbers = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
    height = compute_midpoints(made.mesh, topology.dim, numbers)[:, topology.dim - 1]
    layer = np.searchsorted(frame.levels, height) - 1
    return [
        Region(numbers[layer == k], other) for k, other in enumerate(others) if other != material
    ]


def _on_feet(
    spec: FrameSpec, dimension: int, made: MeshedBody, damping: DampingSpec | None
) -> tuple[list[Support], GroundSpring | None]:
    """Supports of the feet, and the springs below them, which are damped as the frame is."""
    facets = made.facet_tags.find(FacetTag.FEET)
    given = spec.feet or FeetSpec()
    each = (*(given.horizontal,) * (dimension - 1), given.vertical)
    held = tuple(k for k, stiffness in enumerate(each) if stiffness is None)
    supports = [Support(facets=facets, directions=held)] if held else []
    if len(held) == dimension:
        return supports, None
    count = (spec.bays + 1) ** (dimension - 1)
    stiffness = tuple(count * (value or 0.0) for value in each)
    delay = 0.0 if damping is None else damping.stiffness
    return supports, GroundSpring(facets=facets, stiffness=stiffness, delay=delay)


def _shape(spec: FrameSpec, dimension: int) -> Frame:
    """The shape of a frame."""
    heights = [layer.height for layer in spec.layers]
    *below, (storey, deck) = zip(heights[::2], heights[1::2], strict=True)
    return Frame(
        deck=Plate(width=spec.deck.width, height=deck, thickness=spec.deck.thickness),
        column_width=spec.column.width,
        storey=storey,
        below=tuple(Storey(*each) for each in below),
        bays=spec.bays,
        column_thickness=spec.column.thickness if dimension == 3 else None,
    )


def foundation(
    scene: Scene, number: int, comm: MPI.Intracomm, ground: GroundMotion | None = None
) -> FoundationBody:
    """Build what carries the blocks; `number` is that of its body, if it is one.

    The motion of the ground is read where it is needed and not given.
    """

    def meshed(own: MPI.Intracomm) -> FoundationBody:
        """The foundation on a mesh, if it has one."""
        return _built(scene.foundation, scene, number, own)

    if scene.foundation.modes is None:
        return meshed(comm)
    ground = ground or read_ground(scene, comm)
    return reduced_foundation(scene, number, comm, ground, meshed)


@singledispatch
def _built(spec: Foundation, scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """The foundation of a kind: rigid ground, unless a builder is registered below."""
    return FoundationBody(Plane.level(scene.dimension))


@_built.register
def _oscillator(
    spec: OscillatorSpec, scene: Scene, number: int, comm: MPI.Intracomm
) -> FoundationBody:
    """A rigid platform on a spring."""
    platform = scene.platform()
    body = Oscillator(
        mass=platform.mass,
        stiffness=platform.stiffness,
        dashpot=platform.damping,
        dimension=scene.dimension,
        comm=comm,
    )
    top = RigidPoints(body, np.zeros((1, scene.dimension)))
    return FoundationBody(Plane.level(scene.dimension, top), number, body)


@_built.register
def _plate(spec: PlateSpec, scene: Scene, number: int, comm: MPI.Intracomm) -> FoundationBody:
    """A meshed plate on its bottom, on rollers and a spring, or fully restrained.

    That which is fully restrained is a rigid face unless it is to be meshed.
    """
    if spec.support == "fixed":
        if spec.meshed:
            return _held_plate(spec, scene, comm)
        sides = np.array([spec.width, spec.thickness or spec.width, 0.0])
        half = 0.5 * sides[[0, 2] if scene.dimension == 2 else [0, 1, 2]]
        return FoundationBody(_fixed_face(np.array([-half, half])))
    damping = damping_of(scene, spec, lambda own: _plate_body(spec, scene, None, own)[0])
    return with_top(*_plate_body(spec, scene, damping, comm), number)


def _held_plate(spec: PlateSpec, scene: Scene, comm: MPI.Intracomm) -> FoundationBody:
    """A meshed plate that is fully restrained."""
    made = _plate_mesh(spec, scene, comm)
    space = fem.functionspace(made.mesh, ("Lagrange", 1, (scene.dimension,)))
    surface = carrier_surface(space, made.facet_tags, int(FacetTag.TOP))
    return FoundationBody(_fixed_face(surface.positions), surface=surface, held=space)


def _plate_mesh(spec: PlateSpec, scene: Scene, comm: MPI.Intracomm) -> MeshedBody:
    """The mesh of a plate."""
    return plate_mesh(
        Plate(width=spec.width, height=spec.height, thickness=spec.thickness),
        dimension=scene.dimension,
        cells=spec.cells,
        cell=spec.cell,
        comm=comm,
    )


def _plate_body(
    spec: PlateSpec, scene: Scene, damping: DampingSpec | None, comm: MPI.Intracomm
) -> tuple[ElasticBody, MeshedBody]:
    """The body of a plate, and its mesh."""
    dimension, made = scene.dimension, _plate_mesh(spec, scene, comm)
    bottom = made.facet_tags.find(FacetTag.BOTTOM)
    spring, directions = None, tuple(range(dimension))
    if spec.on_spring:
        platform = scene.platform()
        along = (platform.stiffness,) * (dimension - 1)
        delay = platform.damping / platform.stiffness
        spring = GroundSpring(facets=bottom, stiffness=(*along, 0.0), delay=delay)
        directions = (dimension - 1,)
    body = meshed_body(
        scene,
        "plate",
        made,
        material=spec.material(scene.material_plane, scene.carried_mass),
        thickness=spec.thickness,
        degree=spec.degree,
        damping=damping,
        supports=[Support(facets=bottom, directions=directions)],
        spring=spring,
    )
    return body, made


_built.register(build_frame)


def reduction_in_words(scene: Scene, ground: GroundMotion) -> tuple[str, ...]:
    """Numbers of the mesh of a reduced foundation; computed on every rank for itself."""
    found = foundation(scene, 0, MPI.COMM_SELF, ground).reduction
    assert found is not None
    return found.in_words()


def natural_period(scene: Scene) -> float:
    """Longest natural period of the meshed foundation of a scene, without its blocks, s.

    Computed on every rank for itself.

    Raises:
        ValueError: For a foundation without a mesh, or one that nothing deforms.
    """
    body = _built(scene.foundation, scene, 0, MPI.COMM_SELF).body
    if not isinstance(body, ElasticBody):
        raise ValueError(f"a foundation of kind {scene.foundation.kind} has no mesh that moves")
    return 2 * math.pi / math.sqrt(float(eigenvalues(body)[0]))


FACE = ("nodes", "positions", "degree", "cell")
"""Data on all ranks of the face that carries blocks."""

COLUMNS = 3
"""Vectors of the mesh for each unknown that is kept, while a foundation is reduced."""

REMEDY = "use larger cells, or leave foundation.modes out"


class Footprint(NamedTuple):
    """Area of a foundation on which a block stands, and the mass carried there."""

    low: Array
    """Smallest coordinates in plan, (d - 1,), m."""
    high: Array
    """Largest ones, m."""
    mass: float
    """Mass of the block and of all that stand on it, kg."""


class Reduced(NamedTuple):
    """A reduced foundation on rank 0, to be sent to the other ranks."""

    reduction: Reduction
    parts: ReducedParts
    storeys: Storeys
    rows: Array
    """Rows of the nodes of the face."""


def reduced_foundation(
    scene: Scene,
    number: int,
    comm: MPI.Intracomm,
    ground: GroundMotion,
    meshed: Callable[[MPI.Intracomm], FoundationBody],
) -> FoundationBody:
    """The foundation that `meshed` makes, reduced as its scene requests; collective.

    Rank 0 makes and keeps it all; `number` is that of the body.
    """
    found: list[Reduced] = []

    def make() -> tuple[dict[str, Any], list[Array], int, Reduction]:
        """The foundation and its reduction; for the other ranks."""
        full = meshed(MPI.COMM_SELF)
        found.append(_reduced(scene, full, ground))
        assert full.surface is not None
        face = {key: getattr(full.surface, key) for key in FACE}
        centres = [foot.centre for foot in full.storeys.feet]
        return face, centres, len(full.storeys.floors), found[0].reduction

    face, centres, floors, reduction = on_first_rank(comm, make)
    facts, d, none = reduction.facts, scene.dimension, np.empty(0, dtype=np.int64)
    if found:
        (own,) = found
        body, storeys, rows = ReducedBody(comm, facts, own.parts), own.storeys, own.rows
    else:
        body, rows = ReducedBody(comm, facts, None), np.zeros((face["positions"].size, 0))
        nothing = np.zeros((d - 1, 0))
        storeys = Storeys([Foot(none, centre) for centre in centres], [nothing] * floors)
    surface = Facets(**face, layer=RowsLayer(comm, rows, d))
    return FoundationBody.on_facets(number, body, surface, storeys, reduction)


def _reduced(scene: Scene, full: FoundationBody, ground: GroundMotion) -> Reduced:
    """Reduce a foundation that is meshed on one rank."""
    body, surface = full.body, full.surface
    assert isinstance(body, ElasticBody) and surface is not None
    d, prints, top = body.dimension, _footprints(scene), surface.layer.nodes
    loaded = [top[_below(surface, each)] for each in prints]
    try:
        about = linearised(body, _weight(body, np.array(scene.gravity_vector), prints, loaded))
    except NotConverged as buckled:
        allowed = "one that carries its weight and that of the blocks (young in Pa, density)"
        raise SceneError("foundation", str(buckled), allowed) from None
    bounces = (_bounce(body, each.mass, own) for each, own in zip(prints, loaded, strict=True))
    frequency = max(highest_frequency(ground, scene.time.end), *bounces)
    touched = _touched(surface, prints)
    supports = np.unique(np.concatenate([body.fixed, about.spring.indices]) // d)
    kept = np.concatenate([top[touched], np.setdiff1d(supports, top[touched])])
    columns = COLUMNS * len(kept) * d
    require(8.0 * columns * body.size, f"{body.name}: reducing it", REMEDY, body.comm)
    interface = FixedInterface(about, _unknowns(kept, d), _unknowns(top[touched], d), d)
    asked = scene.foundation.modes
    basis = interface.basis(None if asked == "auto" else asked, frequency)
    shapes = Shapes(interface, basis, body.mass, d)
    held = np.flatnonzero(np.isin(interface.kept, body.fixed))
    nothing = np.arange(shapes.used, shapes.unknowns)
    parts = ReducedParts(
        nodes=body.nodes[kept],
        fixed=np.concatenate([held, nothing]).astype(np.int32),
        matrices=reduced_matrices(body, about, shapes),
        shapes=shapes,
        mesh=body,
    )
    nodes = len(touched), len(kept) - len(touched)
    return Reduced(
        Reduction.of(_facts(body, shapes.unknowns), basis, nodes),
        parts,
        _reduced_storeys(full.storeys, kept, shapes),
        rows=shapes.rows(_unknowns(top, d)),
    )


def _facts(body: ElasticBody, unknowns: int) -> ReducedFacts:
    """Data for all ranks of a body that is reduced to so many unknowns."""
    return ReducedFacts(
        name=body.name,
        mass=body.mass,
        rigidity=body.rigidity,
        damping=body.damping,
        delay=body.delay,
        dimension=body.dimension,
        unknowns=unknowns,
        springs=body.has_spring,
        full_unknowns=body.unknowns,
    )


def _unknowns(nodes: Indices, dimension: int) -> Indices:
    """The unknowns of nodes, node by node."""
    return (nodes[:, None] * dimension + np.arange(dimension)).ravel().astype(np.int64)


def _reduced_storeys(full: Storeys, kept: Indices, shapes: Shapes) -> Storeys:
    """Feet by the numbers of kept nodes, floors by rows of the reduced unknowns."""
    number = {int(node): place for place, node in enumerate(kept)}
    feet = [
        Foot(np.array([number[int(node)] for node in foot.nodes], dtype=np.int64), foot.centre)
        for foot in full.feet
    ]
    floors = []
    for floor in full.floors:
        used = np.unique(floor.indices)
        floors.append(floor[:, used] @ shapes.rows(used))
    return Storeys(feet, floors)


def _footprints(scene: Scene) -> list[Footprint]:
    """Footprints of all blocks that stand on the foundation, as if nothing were tilted."""
    placed = scene.poses(upright=True)
    found = []
    for block in scene.blocks:
        if block.carrier == "foundation":
            corners = placed[block.name](np.array(block.shape.corners(scene.dimension)))[:, :-1]
            low, high = corners.min(axis=0), corners.max(axis=0)
            found.append(Footprint(low, high, scene.stacked_mass(block)))
    return found


def _below(surface: Facets, footprint: Footprint) -> Indices:
    """Nodes of the face below a block, as places: the nearest one where there is none."""
    level = surface.positions[:, :-1]
    near = 1e-9 * np.ptp(level)
    within = (level >= footprint.low - near) & (level <= footprint.high + near)
    below = np.flatnonzero(np.all(within, axis=1))
    if len(below):
        return below
    middle = (footprint.low + footprint.high) / 2
    return np.array([np.linalg.norm(level - middle, axis=1).argmin()])


def _weight(
    body: ElasticBody, gravity: Array, prints: list[Footprint], loaded: list[Indices]
) -> Array:
    """Weight of a foundation and of what stands on it, spread over the nodes below, N."""
    d, load = body.dimension, gravity @ body.directional_mass
    for each, nodes in zip(prints, loaded, strict=True):
        for k in range(d):
            load[nodes * d + k] += each.mass * gravity[k] / len(nodes)
    return np.asarray(load)


def _bounce(body: ElasticBody, mass: float, nodes: Indices) -> float:
    """Frequency at which a mass (kg) would bounce on the stiffness below its weight, rad/s."""
    d, push = body.dimension, np.zeros(body.size)
    push[nodes * d + d - 1] = 1 / len(nodes)
    push[body.fixed] = 0.0
    return 1 / math.sqrt(mass * float(push @ body.factorization(STATIC).solve(push)))


def _touched(surface: Facets, prints: list[Footprint]) -> Indices:
    """Nodes of the facets below the blocks and of the next facet around each, as places."""
    level = surface.positions[:, :-1][surface.nodes]
    low, high = level.min(axis=1), level.max(axis=1)
    around = (high - low).max(axis=0) * (1 - 1e-9)
    inside = [
        np.all((high > each.low - around) & (low < each.high + around), axis=1) for each in prints
    ]
    return np.unique(surface.nodes[np.any(inside, axis=0)])
