"""The compiled world by itself: inertia in any axes, bodies of parts, links, applied forces."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geometry.block import FACES, Block
from solver.kernels.world import Body, Link, LinkLaw, LinkStates, Mobility, Steps, World
from solver.rigid.rows import quaternion_of
from solver.types import Array

BOX = Block(width=0.3, height=1.0, thickness=0.5, density=1000.0)
SCHEME = (0.0, 0.5, 0.5)
PLASTIC = np.array([0.4, 0.4, 0.0, 0.0, 0.0, 0.0])
"""Friction 0.4, impacts without rebound."""
CORNERS = np.array(BOX.corners(3)) - [0.0, 0.0, 0.5]


def thrown(turn: Rotation) -> Steps:
    """Steps of a box that spins above the ground, written in axes turned against its own."""
    matrix = turn.as_matrix()
    world = World(3, (0.0, 0.0, -9.81), (0.0, 0.5, 0.5), True)
    shape = world.polyhedron(CORNERS @ matrix, FACES)
    body = Body(
        shape=shape,
        mass=BOX.mass,
        inertia=matrix.T @ np.diag(BOX.principal_inertias) @ matrix,
        centre=(0.0, 0.0, 1.2),
        rotation=quaternion_of(matrix),
        spin=matrix.T @ np.array([0.5, 3.0, 0.2]),
    )
    world.add(body)
    world.begin([np.array([0.5, 0.5, 0.0, 0.0, 0.0, 0.0])], np.zeros((1, 1)), [[]])
    return world.run(400, 2e-3, 1e-6, np.zeros((401, 3)), np.zeros((400, 3)))


def test_the_axes_in_which_an_inertia_is_written_do_not_matter() -> None:
    own, turned = thrown(Rotation.identity()), thrown(Rotation.from_euler("xyz", [0.4, -1.1, 2.0]))
    assert np.allclose(own.centre, turned.centre, atol=1e-12)
    assert np.allclose(own.spin, turned.spin, atol=1e-10)
    # The angular momentum of a body that nothing touches stays; its angular velocity does not.
    assert np.ptp(own.spin[:, 0], axis=0).max() > 0.1
    assert np.allclose(own.stored.sum(axis=1), own.stored[0].sum(), rtol=1e-12)


def ledger(steps: Steps) -> Array:
    """Energy that came from nowhere, J."""
    return steps.stored.sum(axis=1) - steps.exchanged[:, 0] + steps.exchanged[:, 1:].sum(axis=1)


# ------------------------------------------------------------------ several parts


def rectangle(left: float, right: float, low: float, high: float) -> list[list[float]]:
    return [[left, low], [right, low], [right, high], [left, high]]


def slide_over(parts: Sequence[list[list[float]]]) -> Steps:
    """A block that slides over the top of a table of some parts, trips at its end and falls."""
    world = World(2, (0.0, -9.81), SCHEME, True)
    shapes = [world.polygon(np.array(part) - [0.0, 0.2]) for part in parts]
    world.add(Body(shape=shapes, mass=800.0, inertia=800 * 1.16 / 12, centre=(0.0, 0.2)))
    upper = world.polygon(rectangle(-0.1, 0.1, -0.25, 0.25))
    inertia = 100 * 0.29 / 12
    world.add(
        Body(
            shape=upper,
            mass=100.0,
            inertia=inertia,
            centre=(-0.3, 0.65),
            velocity=(1.8, 0.0),
            spin=-0.3,
        )
    )
    world.add(Body(shape=world.half_space(), mobility=Mobility.FIXED))
    world.begin([PLASTIC], np.zeros((3, 3)), [[2], [0], []])
    return world.run(1500, 1e-3, 1e-7, np.zeros((1501, 2)), np.zeros((1500, 2)))


@pytest.mark.parametrize(
    "parts",
    [
        [rectangle(-0.5, -0.05, 0.0, 0.4), rectangle(-0.05, 0.5, 0.0, 0.4)],
        [rectangle(x / 10, (x + 1) / 10, 0.0, 0.4) for x in range(-5, 5)],
        [rectangle(-0.5, 0.5, 0.0, 0.1), rectangle(-0.5, 0.5, 0.1, 0.4)],
        [[[-0.5, 0.0], [0.5, 0.0], [0.5, 0.4]], [[-0.5, 0.0], [0.5, 0.4], [-0.5, 0.4]]],
    ],
    ids=["two", "ten", "layers", "triangles"],
)
def test_a_body_is_the_same_whatever_parts_it_is_made_of(parts: list[list[list[float]]]) -> None:
    whole, cut = slide_over([rectangle(-0.5, 0.5, 0.0, 0.4)]), slide_over(parts)
    assert np.abs(whole.turned[:, 1]).max() > 1.0
    assert np.abs(whole.centre - cut.centre).max() < 2e-6
    assert np.ptp(ledger(cut)) < 1e-10


def land_on(cuts: Sequence[int]) -> Steps:
    """A box that falls obliquely on a slab cut into parts along x, y and z."""
    world = World(3, (0.0, 0.0, -9.81), SCHEME, True)
    low, size = np.array([-0.5, -0.4, -0.1]), np.array([1.0, 0.8, 0.2]) / cuts
    shapes = []
    for index in np.ndindex(*cuts):
        unit = np.array(Block(width=1, height=1, thickness=1, density=1.0).corners(3))
        corners = low + (np.array(index) + unit + [0.5, 0.5, 0.0]) * size
        shapes.append(world.polyhedron(corners, FACES))
    inertia = 400 / 12 * np.array([0.64 + 0.04, 1.04, 1.64])
    world.add(Body(shape=shapes, mass=400.0, inertia=inertia, centre=(0.0, 0.0, 0.1)))
    turn = Rotation.from_euler("xyz", [0.4, 0.3, 0.2])
    world.add(
        Body(
            shape=world.polyhedron(CORNERS, FACES),
            mass=BOX.mass,
            inertia=BOX.principal_inertias,
            centre=(-0.1, 0.05, 1.0),
            rotation=quaternion_of(turn.as_matrix()),
        )
    )
    world.add(Body(shape=world.half_space(), mobility=Mobility.FIXED))
    world.begin([PLASTIC], np.zeros((3, 3)), [[2], [], []])
    return world.run(300, 2e-3, 1e-7, np.zeros((301, 3)), np.zeros((300, 3)))


@pytest.mark.parametrize("cuts", [(2, 1, 1), (3, 2, 1), (2, 2, 2)], ids=str)
def test_a_body_in_space_is_the_same_whatever_parts_it_is_made_of(cuts: tuple[int, ...]) -> None:
    whole, cut = land_on((1, 1, 1)), land_on(cuts)
    assert np.abs(whole.spin[:, 1]).max() > 0.9
    assert np.abs(whole.centre - cut.centre).max() < 1e-6
    assert np.ptp(ledger(cut)) < 1e-9


# ------------------------------------------------------------------ links


def hung(law: LinkLaw, *, strength: float = math.inf, steps: int, dt: float = 1e-2) -> Steps:
    """A mass of 10 kg that is let go on a link of 1.9 m to a fixed point above it."""
    world = World(2, (0.0, -9.81), SCHEME, True)
    square = world.polygon(rectangle(-0.1, 0.1, -0.1, 0.1))
    world.add(Body(shape=square, mass=10.0, inertia=10 * 0.04 / 6, centre=(0.0, 5.0)))
    world.add(Body(shape=world.half_space(), mobility=Mobility.FIXED))
    ends = (0.0, 7.0), (0.0, 0.1)
    world.link(Link(first=1, second=0, ends=ends, length=1.9, laws=[law], strength=strength))
    world.begin([PLASTIC], np.zeros((2, 2)), [[], []])
    return world.run(steps, dt, 1e-7, np.zeros((steps + 1, 2)), np.zeros((steps, 2)))


def test_a_spring_keeps_its_energy() -> None:
    found = hung(LinkLaw(stiffness=1000.0), steps=20000)
    total = found.stored.sum(axis=1)
    assert np.ptp(total) < 1e-12 * total[0]
    assert 5 - found.centre[:, 0, 1].min() == pytest.approx(2 * 98.1 / 1000, rel=1e-4)


def test_a_link_breaks_at_its_strength_and_loses_its_energy() -> None:
    found = hung(LinkLaw(stiffness=1000.0), strength=120.0, steps=2000, dt=1e-4)
    state = LinkStates.split(2, found.links)
    assert state.broken[-1, 0]
    assert state.lost[-1, 0] == pytest.approx(120.0**2 / 2000, rel=1e-9)
    assert state.broken_at[-1, 0] == pytest.approx(math.acos(1 - 120 / 98.1) / 10, abs=1e-6)
    assert np.ptp(ledger(found)) < 1e-10
    fall = found.velocity[-1, 0, 1] - found.velocity[-11, 0, 1]
    assert fall == pytest.approx(-9.81e-3, rel=1e-9)


def test_a_link_flows_at_its_yield_force_and_a_slack_one_does_nothing() -> None:
    law = LinkLaw(stiffness=1000.0, gap=0.05, compression=False, yields=130.0, damping=20.0)
    found = hung(law, steps=3000)
    state = LinkStates.split(2, found.links)
    slack = state.extension[:, 0, 0] < 0.05
    assert np.all(state.force[slack, 0, 0][1:] < 10.0) and np.all(state.force >= 0)
    # At rest in the end: 98.1 N beyond gap and plastic part.
    reached = 0.05 + state.plastic[-1, 0, 0] + 98.1 / 1000
    assert state.plastic[-1, 0, 0] > 0.01
    assert state.extension[-1, 0, 0] == pytest.approx(reached, rel=1e-6)
    assert np.ptp(ledger(found)) < 1e-10 and np.all(np.diff(found.exchanged[:, 2]) >= -1e-12)


def test_a_link_in_three_directions_acts_with_balanced_forces() -> None:
    world = World(3, (0.0, 0.0, 0.0), SCHEME, True)
    box = {"mass": BOX.mass, "inertia": BOX.principal_inertias}
    for place, spin in (((0.0, 0.0, 3.0), (0.0, 1.0, 2.0)), ((0.0, 0.0, 6.2), (0.5, 0.0, 0.0))):
        shape = world.polyhedron(CORNERS, FACES)
        world.add(Body(shape=shape, centre=place, spin=spin, **box))
    laws = [LinkLaw(stiffness=k) for k in (2e4, 3e4, 5e4)]
    ends = (0.1, 0.2, 1.5), (-0.1, 0.1, -1.5)
    world.link(
        Link(first=0, second=1, ends=ends, axes=np.eye(3), length=(-0.2, -0.1, 0.2), laws=laws)
    )
    world.begin([PLASTIC], np.zeros((2, 2)), [[], []])
    found = world.run(2000, 2e-3, 1e-7, np.zeros((2001, 3)), np.zeros((2000, 3)))
    total = found.stored.sum(axis=1)
    assert np.ptp(total) < 1e-9 * total[0] and np.ptp(found.stored[:, 0]) > 0.1 * total[0]
    linear = BOX.mass * found.velocity.sum(axis=1)
    inertia = np.diag(BOX.principal_inertias)
    angular = np.zeros((len(total), 3))
    for b in range(2):
        frame = Rotation.from_quat(found.rotation[:, b][:, [1, 2, 3, 0]]).as_matrix()
        own = np.einsum("sji,sj->si", frame, found.spin[:, b])
        angular += np.einsum("sij,sj->si", frame, own @ inertia)
        angular += BOX.mass * np.cross(found.centre[:, b], found.velocity[:, b])
    assert np.ptp(linear, axis=0).max() < 1e-9
    assert np.ptp(angular, axis=0).max() < 1e-8 * np.abs(angular).max()


# ------------------------------------------------------------------ applied forces


def test_a_force_at_a_point_turns_with_it_and_its_work_is_booked() -> None:
    world = World(2, (0.0, 0.0), SCHEME, True)
    square = world.polygon(rectangle(-0.1, 0.1, -0.1, 0.1))
    world.add(Body(shape=square, mass=10.0, inertia=10 * 0.04 / 6, centre=(0.0, 5.0)))
    world.force(0, (0.1, 0.1))
    world.begin([PLASTIC], np.zeros((1, 1)), [[]])
    time = np.linspace(0.0, 10.0, 1001)
    forces = np.stack([0.3 * time, np.ones_like(time)], axis=1)[:, None]
    forces = np.stack([forces[:-1], forces[1:]], axis=1)
    found = world.run(1000, 1e-2, 1e-7, np.zeros((1001, 2)), np.zeros((1000, 2)), forces)
    assert found.velocity[-1, 0] == pytest.approx([0.3 * 100 / 2 / 10, 1.0])
    assert np.ptp(ledger(found)) < 1e-10
    assert np.abs(found.turned).max() > 1.0


def test_each_part_tells_what_presses_on_it() -> None:
    world = World(2, (0.0, -9.81), SCHEME, True)
    # A beam on two feet, of which the right one carries more: the centre is nearer to it.
    beam = rectangle(-0.5, 0.5, 0.1, 0.3), rectangle(-0.5, -0.4, 0.0, 0.1)
    shapes = [
        world.polygon(np.array(part) - [0.2, 0.15])
        for part in (*beam, rectangle(0.4, 0.5, 0.0, 0.1))
    ]
    world.add(Body(shape=shapes, mass=100.0, inertia=10.0, centre=(0.2, 0.15)))
    world.add(Body(shape=world.half_space(), mobility=Mobility.FIXED))
    world.begin([PLASTIC], np.zeros((2, 2)), [[1], []])
    steps = world.run(10, 1e-3, 1e-7, np.zeros((11, 2)), np.zeros((10, 2)))
    forces = steps.parts[-1] / 1e-3
    assert np.all(forces[0] == 0)
    assert forces[1:, 1].sum() == pytest.approx(981.0, rel=1e-10)
    # Each foot presses with two corners: forces by statics up to where on the foot they act.
    arm = (forces[2, 1] - forces[1, 1]) / forces[1:, 1].sum() * 0.45
    assert arm == pytest.approx(0.2, abs=0.05)
