"""A frame as a body: a meshed deck on columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from mpi4py import MPI

import numpy as np
import scipy.sparse as sp
from dolfinx.mesh import compute_midpoints

from geometry.foundation import Frame, Plate, Storey
from geometry.frame_mesh import FrameCells, frame_mesh
from geometry.gmsh_model import MeshedBody
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, GroundSpring, Support
from solver.bodies.elastic_forms import Region
from solver.build.meshed_body import meshed_body
from solver.build.support import Foot, FoundationBody, Storeys, damping_of, with_top
from solver.parallel import global_sum
from solver.scene import Scene
from solver.scene.damping import DampingSpec
from solver.scene.foundation import FeetSpec, FrameSpec
from solver.scene.material import Material
from solver.types import Array, Mask


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
    """What holds the feet, and the springs below them, which are damped as the frame is."""
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
