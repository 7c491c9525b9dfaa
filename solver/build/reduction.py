"""A meshed foundation reduced to few unknowns: which nodes are kept, and how many modes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from mpi4py import MPI

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.memory import require
from solver.bodies.modes import STATIC
from solver.bodies.reduced.body import ReducedBody, ReducedFacts, ReducedParts
from solver.bodies.reduced.craig_bampton import FixedInterface
from solver.bodies.reduced.layer import ReducedLayer
from solver.bodies.reduced.linearised import linearised
from solver.bodies.reduced.matrices import Shapes, reduced_matrices
from solver.bodies.reduced.reduction import Reduction
from solver.build.support import Foot, FoundationBody, Storeys
from solver.contact.carrier_surface import Facets
from solver.errors import NotConverged, SceneError
from solver.excitation.motion import GroundMotion
from solver.excitation.spectrum import highest_frequency
from solver.parallel import on_first_rank
from solver.scene import Scene
from solver.types import Array, Indices

FACE = ("nodes", "positions", "degree", "cell")
"""What all ranks know of the face that carries blocks."""

COLUMNS = 3
"""Vectors of the mesh for each unknown that is kept, while a foundation is reduced."""

REMEDY = "use larger cells, or leave foundation.modes out"


class Footprint(NamedTuple):
    """Where a block stands on a foundation, and what it carries there."""

    low: Array
    """Smallest coordinates in plan, (d - 1,), m."""
    high: Array
    """Largest ones, m."""
    mass: float
    """Mass of the block and of all that stand on it, kg."""


class Reduced(NamedTuple):
    """A reduced foundation on rank 0, to be told to the others."""

    reduction: Reduction
    parts: ReducedParts
    storeys: Storeys
    places: Indices
    """Places of kept nodes on the face."""
    rows: Array
    """Rows of the other nodes of the face."""


def reduced_foundation(
    scene: Scene,
    number: int,
    comm: MPI.Intracomm,
    ground: GroundMotion,
    meshed: Callable[[MPI.Intracomm], FoundationBody],
) -> FoundationBody:
    """The foundation that `meshed` makes, reduced as its scene asks for; collective.

    Rank 0 makes and keeps it all; `number` is that of the body.
    """
    found: list[Reduced] = []

    def make() -> tuple[dict[str, Any], list[Array], int, Reduction]:
        """The foundation and its reduction; what the other ranks are told."""
        full = meshed(MPI.COMM_SELF)
        found.append(_reduced(scene, full, ground))
        assert full.surface is not None
        face = {key: getattr(full.surface, key) for key in FACE}
        centres = [foot.centre for foot in full.storeys.feet]
        return face, centres, len(full.storeys.floors), found[0].reduction

    face, centres, floors, reduction = on_first_rank(comm, make)
    facts, d, none = reduction.facts, scene.dimension, np.empty(0, dtype=np.int64)
    size = len(face["positions"])
    if found:
        (own,) = found
        body, storeys = ReducedBody(comm, facts, own.parts), own.storeys
        layer = ReducedLayer(comm, own.places, own.rows, size)
    else:
        body, layer = ReducedBody(comm, facts, None), ReducedLayer(comm, none, _none(0), size)
        storeys = Storeys([Foot(none, centre) for centre in centres], [_none(d - 1)] * floors)
    surface = Facets(**face, layer=layer)
    return FoundationBody(d, number, body, surface=surface, storeys=storeys, reduction=reduction)


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
    asked = scene.foundation.reduced_modes
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
        _storeys(full.storeys, kept, shapes),
        places=touched,
        rows=shapes.rows(_unknowns(np.delete(top, touched), d)),
    )


def _facts(body: ElasticBody, unknowns: int) -> ReducedFacts:
    """What all ranks are told of a body that is reduced to so many unknowns."""
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


def _none(rows: int) -> Array:
    """Rows of no unknowns."""
    return np.zeros((rows, 0))


def _unknowns(nodes: Indices, dimension: int) -> Indices:
    """The unknowns of nodes, node by node."""
    return (nodes[:, None] * dimension + np.arange(dimension)).ravel().astype(np.int64)


def _storeys(full: Storeys, kept: Indices, shapes: Shapes) -> Storeys:
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
        if block.on == "foundation":
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
