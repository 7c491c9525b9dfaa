"""Mesh of a half disc that touches the level y = 0 with its round side, for Hertz's contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from mpi4py import MPI

import gmsh

from geometry.gmsh_model import MeshedBody, make
from geometry.tags import ALL_CELLS, FacetTag

#: Distance from the contact up to which layers grow, over the radius of the disc.
RING_RATIO = 0.75

#: Place on the flat side at which the line from the corner of the core ends, over the radius.
CROWN_RATIO = 0.6


def disc_mesh(
    radius: float,
    *,
    size: float,
    core: float,
    growth: float = 1.1,
    comm: MPI.Intracomm = MPI.COMM_WORLD,
) -> MeshedBody:
    """Mesh the lower half of a disc with quadrilaterals, finest at its lowest point; collective.

    Its centre is (0, R), it touches (0, 0), its flat side lies on top at y = R. A core at the
    contact has cells of one size; layers around it grow outwards. All nodes of the round side
    (BOTTOM) are on the circle; the flat side is TOP. The mesh is its own mirror image.

    Args:
        radius: R, m.
        size: Length of the facets in the core, m; rounded so that they divide it evenly.
        core: Half width of the core along the circle, and its height, m, at most R/4.
        growth: Size of a layer over that of the layer inside it, > 1.
        comm: The ranks that share the mesh.

    Raises:
        ValueError: Where size, core and radius do not fit together, or growth is not above 1.
    """
    if not (0 < size <= core <= radius / 4 and growth > 1):
        raise ValueError(f"disc_mesh: radius={radius}, size={size}, core={core}, growth={growth}")
    cells = round(core / size)
    span = (RING_RATIO * radius - core) * cells / core
    layers = max(1, round(math.log1p(span * (growth - 1)) / math.log(growth)))
    last = (RING_RATIO * radius - core) * (1 - 1 / growth) / (1 - growth**-layers)
    outer = max(1, round(radius * (math.pi / 2 - 2 * math.asin(RING_RATIO / 2)) / last))
    half = _HalfDisc(radius, core, cells, layers, outer, growth)
    return make("disc", half.build, 2, comm)


@dataclass(slots=True)
class _HalfDisc:
    """Five transfinite patches on either side of the axis: core, inner and outer layers.

    Attributes:
        radius: R, m.
        core: Half width and height of the core, m.
        cells: Number of cells along half of the core's width, and along its height.
        layers: Number of layers between the core and the ring.
        outer: Number of layers between the ring and the flat side.
        growth: Size of a layer inside the ring over that of the layer before it.
    """

    radius: float
    core: float
    cells: int
    layers: int
    outer: int
    growth: float

    def build(self) -> None:
        """Make the mesh in the current Gmsh model, tags included."""
        geo = gmsh.model.geo
        centre, origin = geo.addPoint(0, self.radius, 0), geo.addPoint(0, 0, 0)
        heights = (self.core, RING_RATIO * self.radius)
        axis = [origin, *(geo.addPoint(0, y, 0) for y in heights), centre]
        spine = [geo.addLine(a, b) for a, b in pairwise(axis)]
        self._divide(spine)
        surfaces: list[int] = []
        arcs: list[int] = []
        flats: list[int] = []
        for side in (-1, 1):
            patches, below, above = self._one_side(side, axis, spine)
            surfaces += patches
            arcs += below
            flats += above
        geo.synchronize()
        gmsh.model.addPhysicalGroup(2, surfaces, ALL_CELLS)
        gmsh.model.addPhysicalGroup(1, arcs, FacetTag.BOTTOM)
        gmsh.model.addPhysicalGroup(1, flats, FacetTag.TOP)
        gmsh.model.mesh.generate(2)

    def _divide(self, lines: list[int]) -> None:
        """Place nodes on three consecutive lines: through the core, to the ring, outwards."""
        mesh = gmsh.model.geo.mesh
        mesh.setTransfiniteCurve(lines[0], self.cells + 1)
        mesh.setTransfiniteCurve(lines[1], self.layers + 1, "Progression", self.growth)
        mesh.setTransfiniteCurve(lines[2], self.outer + 1)

    def _one_side(
        self, side: int, axis: list[int], spine: list[int]
    ) -> tuple[list[int], list[int], list[int]]:
        """Make one side of the axis; returns its patches, arcs and flat lines."""
        geo, r, ring = gmsh.model.geo, self.radius, RING_RATIO * self.radius

        def point(x: float, y: float) -> int:
            return int(geo.addPoint(side * x, y, 0))

        angles = self.core / r, 2 * math.asin(RING_RATIO / 2), math.pi / 2
        rim = [point(r * math.sin(angle), r * (1 - math.cos(angle))) for angle in angles]
        shoulder = point(self.core, self.core)
        elbow = point(ring * math.sqrt(0.5), ring * math.sqrt(0.5))
        crown = point(CROWN_RATIO * r, r)
        origin, top, above, centre = axis
        arcs = [
            geo.addCircleArc(a, centre, b) for a, b in zip([origin, *rim[:2]], rim, strict=True)
        ]
        self._divide(arcs)
        wall, roof = geo.addLine(rim[0], shoulder), geo.addLine(top, shoulder)
        rings = geo.addCircleArc(rim[1], origin, elbow), geo.addCircleArc(above, origin, elbow)
        flats = [geo.addLine(rim[2], crown), geo.addLine(centre, crown)]
        rays = [geo.addLine(shoulder, elbow), geo.addLine(elbow, crown)]
        self._divide([wall, *rays])
        for line in (roof, *rings, *flats):
            geo.mesh.setTransfiniteCurve(line, self.cells + 1)
        loops = [
            [arcs[0], wall, -roof, -spine[0]],
            [arcs[1], rings[0], -rays[0], -wall],
            [roof, rays[0], -rings[1], -spine[1]],
            [arcs[2], flats[0], -rays[1], -rings[0]],
            [rings[1], rays[1], -flats[1], -spine[2]],
        ]
        return [self._patch(loop) for loop in loops], arcs, flats

    @staticmethod
    def _patch(loop: list[int]) -> int:
        """Make a four-sided patch of quadrilaterals; returns its surface."""
        geo = gmsh.model.geo
        patch = int(geo.addPlaneSurface([geo.addCurveLoop(loop)]))
        geo.mesh.setTransfiniteSurface(patch)
        geo.mesh.setRecombine(2, patch)
        return patch
