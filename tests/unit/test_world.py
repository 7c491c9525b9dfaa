"""The compiled world by itself: bodies whose own axes are no principal axes."""

import numpy as np
from scipy.spatial.transform import Rotation

from geometry.block import FACES, Block
from solver.kernels.world import Body, Steps, World
from solver.rigid.rows import quaternion_of

BOX = Block(width=0.3, height=1.0, thickness=0.5, density=1000.0)
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
