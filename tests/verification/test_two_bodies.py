"""Forces between two bodies: their work is that on gap and slip, exactly, and they are opposite.

Both bodies turn, deform and slide over one another far more than in a step of a run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry.block import Block
from geometry.foundation import level_frame
from geometry.mesh import block_mesh
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.rigid_body import CARRIED, RigidBox, SpaceBox, rigid_box
from solver.contact.body_points import NitschePoints, RigidPoints
from solver.contact.carriers import Face
from solver.contact.facets import carrier_surface
from solver.contact.interface import Interface
from solver.contact.kinematics import ContactIncrement, ForceWeights
from solver.contact.memory import Memory
from solver.contact.nitsche_points import contact_points
from solver.contact.pairs import Link
from solver.scene import FrictionSpec
from solver.scene.material import Material
from solver.stepping.system import System

Array = NDArray[np.float64]

UPPER = Block(width=0.3, height=0.4, thickness=0.3, density=2000.0)
LOWER = Block(width=1.0, height=0.4, thickness=1.0, density=2000.0)
LAW = FrictionSpec(static=0.5)


@dataclass(frozen=True)
class Pose:
    """Turned by `angle` about the origin after moving by `along` and `up`; then deformed."""

    angle: float
    along: float
    up: float = 0.0
    noise: float = 2e-3

    def rotation(self, dimension: int) -> Array:
        """Clockwise; in space about +y, and half as much about +x."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        if dimension == 2:
            return np.array([[c, s], [-s, c]])
        a, b = np.cos(self.angle / 2), np.sin(self.angle / 2)
        about_x = np.array([[1, 0, 0], [0, a, -b], [0, b, a]])
        return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ about_x

    def of(self, nodes: Array, seed: int) -> Array:
        """Displacements of nodes, flat."""
        dimension = nodes.shape[1]
        shift = np.zeros(dimension)
        shift[0], shift[-1] = self.along, self.up
        if dimension == 3:
            shift[1] = 0.4 * self.along
        noise = self.noise * np.random.default_rng(seed).standard_normal(nodes.shape)
        bent = 0.05 * np.sin(3 * nodes[:, ::-1] + seed)
        return np.asarray(
            ((nodes + shift + noise + bent) @ self.rotation(dimension).T - nodes).ravel()
        )


BEFORE = {"upper": Pose(0.32, -0.22, 0.38), "lower": Pose(0.30, 0.0)}
AFTER = {"upper": Pose(0.37, 0.24, 0.41), "lower": Pose(0.35, 0.03, 0.01)}


class Pair:
    """An upper body on a lower one, and their interface."""

    def __init__(self, upper: str, lower: str, dimension: int, cell: str, degree: int):
        self.dimension = dimension
        bodies = [
            self._body("upper", UPPER, upper, cell, degree),
            self._body("lower", LOWER, lower, cell, degree),
        ]
        self.system = System([body for body, _ in bodies])
        self.interface = Interface(self._points(*bodies[0]), self._face(*bodies[1]), LAW)
        self.link = Link(self.interface, 0, 1)

    def _body(self, name: str, shape: Block, model: str, cell: str, degree: int):
        if model == "rigid":
            centre = np.zeros(self.dimension)
            centre[-1] = shape.height / 2
            return rigid_box(name, shape, centre), None
        count = {"upper": (4, 3, 2), "lower": (7, 5, 2)}[name]
        cells = (count[0], count[2]) if self.dimension == 2 else count
        made = block_mesh(shape, dimension=self.dimension, cells=cells, cell=cell)
        plane = "strain" if self.dimension == 2 else "solid"
        material = Material(young=1e6, poisson=0.2, density=shape.density, plane=plane)
        return ElasticBody(made.mesh, material, degree=degree, name=name), made.facet_tags

    def _points(self, body, tags):
        if isinstance(body, RigidBox):
            places = np.zeros((5, self.dimension))
            places[:, 0] = np.linspace(-0.5, 0.5, 5) * UPPER.width
            places[:, 1:-1] = 0.3 * places[::-1, :1] ** 2
            return RigidPoints(body, places)
        bottom = tags.indices[tags.values == FacetTag.BOTTOM]
        from dolfinx.mesh import meshtags

        tags = meshtags(
            body.space.mesh,
            tags.dim,
            bottom,
            np.full(len(bottom), FacetTag.BOTTOM, dtype=np.int32),
        )
        return NitschePoints(
            body, contact_points(body.space, tags, body.material, points="gauss", gamma=100.0)
        )

    def _face(self, body, tags):
        frame = level_frame(self.dimension)
        if isinstance(body, RigidBox):
            plane = self.dimension == 2  # in the order of basix
            order, cell = ((3, 2), "interval") if plane else ((4, 5, 7, 6), "quadrilateral")
            ends = RigidPoints(body, body.corners[list(order)])
            return Face(ends, np.arange(len(order))[None], frame, cell)
        top = carrier_surface(body.space, tags, int(FacetTag.TOP))
        return Face.of_mesh(body, top, frame)

    def unknowns(self, poses: dict[str, Pose]) -> Array:
        """Of both bodies."""
        parts = []
        for seed, (body, name) in enumerate(
            zip(self.system.bodies, ("upper", "lower"), strict=True)
        ):
            pose = poses[name]
            if isinstance(body, RigidBox):
                shift = np.zeros(self.dimension)
                shift[0], shift[-1] = pose.along, pose.up
                if self.dimension == 3:
                    shift[1] = 0.4 * pose.along
                turn = pose.rotation(self.dimension)
                parts.append(body.initial((body.centre + shift) @ turn.T - body.centre, turn))
            else:
                parts.append(pose.of(body.nodes, seed))
        return np.concatenate(parts)

    def observed(self, u: Array, since: Memory):
        parts = self.system.part(u, 0), self.system.part(u, 1)
        return self.interface.observe(*parts, since)

    def total(self, forces: Array, body: int) -> Array:
        """Force on a body in all."""
        part = forces[self.system.slices[body]]
        if isinstance(self.system.bodies[body], RigidBox):
            return part[: self.dimension]
        return part.reshape(-1, self.dimension).sum(axis=0)


CASES = [
    ("elastic", "elastic", 2, "quadrilateral", 1),
    ("elastic", "elastic", 2, "triangle", 2),
    ("elastic", "elastic", 2, "quadrilateral", 2),
    ("rigid", "elastic", 2, "quadrilateral", 1),
    ("elastic", "rigid", 2, "quadrilateral", 1),
    ("rigid", "rigid", 2, "quadrilateral", 1),
    ("elastic", "elastic", 3, "hexahedron", 1),
    ("elastic", "elastic", 3, "hexahedron", 2),
    ("elastic", "elastic", 3, "tetrahedron", 1),
    ("rigid", "elastic", 3, "hexahedron", 1),
    ("elastic", "rigid", 3, "hexahedron", 1),
    ("rigid", "rigid", 3, "hexahedron", 1),
]


def on_from(body: ElasticBody | RigidBox, start: Array, end: Array, travel: float) -> Array:
    """Unknowns of a body a part of the way from one place to another, as a step would have them."""
    if isinstance(body, SpaceBox):
        turn = body.rotation_at(start).T @ body.rotation_at(end)
        skew = 2 * (turn - turn.T) / (1 + np.trace(turn))
        end = np.concatenate([end[:3], [skew[2, 1], skew[0, 2], skew[1, 0]], start[CARRIED]])
    return start + travel * (end - start)


@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(map(str, case)))
@pytest.mark.parametrize("travel", [1.0, 1e-3])
def test_work_is_exact_and_forces_are_opposite(
    case: tuple[str, str, int, str, int], travel: float
) -> None:
    """f.(y1 - y0), whether points slide over several facets or stay on one."""
    pair = Pair(*case)
    system, interface, d = pair.system, pair.interface, pair.dimension
    u0, far = pair.unknowns(BEFORE), pair.unknowns(AFTER)
    u1 = np.concatenate(
        [
            on_from(body, u0[own], far[own], travel)
            for body, own in zip(system.bodies, system.slices, strict=True)
        ]
    )
    middle = 0.5 * (BEFORE["lower"].angle + AFTER["lower"].angle)
    rotations = np.eye(d), Pose(middle, 0.0).rotation(d)
    memory = interface.start(system.part(u0, 0), system.part(u0, 1), *rotations)
    surface, kinematics = pair.observed(u1, memory)
    moved = kinematics.place - memory.kinematics.place
    assert (
        not kinematics.projection.beyond_edge.any()
        and not memory.kinematics.projection.beyond_edge.any()
    )
    if travel == 1.0 and case[1] == "elastic":
        assert np.abs(moved[:, 1]).min() > 2 / 7  # two facets at least
    force = np.random.default_rng(5).uniform(0.5, 1.5, (*interface.weight.shape, d))
    target = np.zeros(system.size)
    increment = ContactIncrement(memory.seen, (surface, kinematics), force)
    interface.add_forces(increment, system.parts(target, pair.link), ForceWeights.of(1.0, 0.0, 1.0))
    y = [seen.augmented for seen in (memory.kinematics, kinematics)]
    work = force * (y[1] - y[0])
    assert target @ (u1 - u0) == pytest.approx(work.sum(), abs=1e-10 * np.abs(work).sum())
    on_points, on_carrier = pair.total(target, 0), pair.total(target, 1)
    np.testing.assert_allclose(on_points, -on_carrier, atol=1e-11 * np.abs(force).sum())
    assert np.linalg.norm(on_points) > 0.1 * np.abs(force).sum()


def test_a_foot_that_hardly_moves_has_the_local_slope() -> None:
    """Below STANDING_STILL of a facet: the error is of the size of the rest of a Taylor series."""
    pair = Pair("elastic", "elastic", 2, "quadrilateral", 1)
    u0, far = pair.unknowns(BEFORE), pair.unknowns(AFTER)
    u1 = u0 + 1e-8 * (far - u0)
    interface = pair.interface
    rotations = np.eye(2), Pose(0.3, 0.0).rotation(2)
    memory = interface.start(pair.system.part(u0, 0), pair.system.part(u0, 1), *rotations)
    _, kinematics = pair.observed(u1, memory)
    force = np.ones((interface.count, 2))
    vectors, reaction = interface.point_forces(memory.kinematics, kinematics, force)
    assert (
        reaction is not None
        and kinematics.carrier is not None
        and memory.kinematics.carrier is not None
    )
    done = np.sum(vectors * (pair.observed(u1, memory)[0].position - memory.surface.position))
    done += np.sum(reaction * (kinematics.carrier.position - memory.kinematics.carrier.position))
    work = force * (kinematics.place - memory.kinematics.place)
    assert done == pytest.approx(work.sum(), abs=1e-7 * np.abs(work).sum())
