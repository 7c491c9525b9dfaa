"""What carries the blocks, once it is built: its body, its surface, and how it is damped."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

from mpi4py import MPI

import numpy as np
from dolfinx import fem

from geometry.foundation import level_frame
from geometry.gmsh_model import MeshedBody
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody, Reduction
from solver.bodies.rigid_body import Oscillator
from solver.contact.body_points import FixedPoints, NodePoints, RigidPoints
from solver.contact.carriers import Carrier, Face, Plane
from solver.contact.facets import Facets, carrier_surface
from solver.scene import Scene
from solver.scene.damping import DampingSpec, stiffness_damping
from solver.scene.foundation import FrameSpec, PlateSpec
from solver.types import Array, Indices


class Foot(NamedTuple):
    """Where a column stands on the ground."""

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
    """What carries the blocks.

    Attributes:
        dimension: Of space.
        number: Of its body in the system; None for what does not move.
        body: The body; None for what does not move.
        width: Of a plate that is fully restrained and not meshed, m; None for all others.
        thickness: The same of its thickness.
        surface: Facets of the top of a meshed one.
        held: Linear displacements on the mesh of a fully restrained plate, all of them zero.
        storeys: Parts of a meshed one that moves as a whole.
        reduction: What a reduced one keeps of its mesh; None for others.
    """

    dimension: int
    number: int | None = None
    body: Oscillator | ElasticBody | ReducedBody | None = None
    width: float | None = None
    thickness: float | None = None
    surface: Facets | None = None
    held: fem.FunctionSpace | None = None
    storeys: Storeys = NO_STOREYS
    reduction: Reduction | None = None

    def carrier(self) -> Carrier:
        """The surface that blocks stand on."""
        frame = level_frame(self.dimension)
        if isinstance(self.body, ElasticBody | ReducedBody):
            assert self.surface is not None
            surface, nodes = self.surface, self.surface.nodes
            points = NodePoints(self.body, surface.layer, surface.positions)
            return Face(points, nodes, frame, surface.cell, surface.degree)
        if self.surface is not None:
            return _fixed_face(self.surface.positions, frame)
        if self.width is not None:
            sides = np.array([self.width, self.thickness or self.width, 0.0])
            half = 0.5 * sides[[0, 2] if self.dimension == 2 else [0, 1, 2]]
            return _fixed_face(np.array([-half, half]), frame)
        if isinstance(self.body, Oscillator):
            platform = RigidPoints(self.body, np.zeros((1, self.dimension)))
            return Plane.level(self.dimension, platform)
        return Plane.level(self.dimension)


def _fixed_face(positions: Array, frame: Array) -> Face:
    """The level rectangle around some positions (n, d), m, as a face of one facet that is fixed.

    On what neither rises nor is stretched all facets are one.
    """
    low, high = positions.min(axis=0), positions.max(axis=0)
    ends = np.array(list(product((0, 1), repeat=len(low) - 1)))[:, ::-1]  # as basix counts corners
    corners = low + np.column_stack([ends, np.zeros(len(ends))]) * (high - low)
    cell = "interval" if len(low) == 2 else "quadrilateral"
    return Face(FixedPoints(corners), np.arange(len(corners))[None], frame, cell)


def with_top(
    body: ElasticBody, made: MeshedBody, number: int, storeys: Storeys = NO_STOREYS
) -> FoundationBody:
    """A meshed body that carries blocks on its top."""
    surface = carrier_surface(body.space, made.facet_tags, int(FacetTag.TOP))
    return FoundationBody(body.dimension, number, body, surface=surface, storeys=storeys)


def damping_of(
    scene: Scene,
    spec: PlateSpec | FrameSpec,
    alone: Callable[[MPI.Intracomm], ElasticBody],
) -> DampingSpec | None:
    """Rayleigh damping of a meshed foundation; collective.

    By the ratio of its first sway mode where that is given: `alone` makes the body without damping,
    which every rank asks for itself.
    """
    ratio = spec.sway_damping_ratio
    if not ratio:
        return scene.damping_of(spec) if ratio is None else None
    from solver.bodies.modes import sway_frequency  # scipy's sparse solvers take their time

    return stiffness_damping(ratio, sway_frequency(alone(MPI.COMM_SELF)))
