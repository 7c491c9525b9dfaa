"""The compiled world in which every body meets every other (solver/kernels): first closed forms."""

import numpy as np
import pytest
from rigid_world import PlaneWorld

pytestmark = pytest.mark.serial


def tilted(restitution: float) -> PlaneWorld:
    """The paper's block, 0.25 m x 1 m, on its right corner at 3 degrees."""
    world, tilt = PlaneWorld(0.8, restitution), np.deg2rad(3)
    c, s = np.cos(tilt), np.sin(tilt)
    place = np.array([0.125, 0.0]) - np.array([[c, s], [-s, c]]) @ [0.125, -0.5]
    world.box((0.25, 1.0), place, 500.0, turn=-tilt)
    world.begin()
    return world


def test_a_plastic_impact_conserves_momentum() -> None:
    """30 kg at 2 m/s meet 70 kg at rest without friction: both go on with 0.6 m/s."""
    world = PlaneWorld(0.0)
    world.box((0.5, 0.2), (0.0, 0.1), 30.0, velocity=(2.0, 0.0))
    world.box((0.5, 0.2), (0.6, 0.1), 70.0)
    world.begin()
    assert world.run(60, 1e-3) == 60
    assert world.bodies()[1:, 3] == pytest.approx([0.6, 0.6], abs=1e-12)


@pytest.mark.parametrize("restitution", [0.0, 0.95, 0.9])
def test_a_block_rocks_as_housner_says(restitution: float) -> None:
    """By energies a while before and after each impact: 1 - 3/2 sin(alpha)^2, or e as given."""
    world, rows = tilted(restitution), []
    begun = world.ledger()
    for _ in range(1400):
        assert world.run(1, 1e-3) == 1
        rows.append(world.bodies()[1])
    found = np.array(rows)
    energy = found[:, 5] ** 2 * (0.25**2 + 1) / 6 + 9.81 * (found[:, 1] - 0.5)
    at = np.flatnonzero(np.diff(np.sign(found[:, 2])))
    assert len(at) >= 4
    kept = np.sqrt(energy[at[:4] + 20] / energy[at[:4] - 20])
    assert kept == pytest.approx([restitution or 1 - 1.5 * 0.0625 / 1.0625] * 4, abs=2e-6)
    assert world.ledger() == pytest.approx(begun, rel=1e-12)


def test_dominoes_fall_in_time() -> None:
    """Five of 0.1 m x 1 m every 0.4 m, the first at 8 degrees: when each passes 20 degrees."""
    world, tilt = PlaneWorld(0.5), np.deg2rad(8)
    c, s = np.cos(tilt), np.sin(tilt)
    world.box((0.1, 1.0), (0.05 - 0.05 * c + 0.5 * s, 0.05 * s + 0.5 * c), 50.0, turn=-tilt)
    for k in range(1, 5):
        world.box((0.1, 1.0), (0.4 * k, 0.5), 50.0)
    world.begin()
    begun, lean = world.ledger(), np.zeros((1800, 5))
    for row in lean:
        assert world.run(1, 1e-3) == 1
        row[:] = -world.bodies()[1:, 2]
    level = np.deg2rad(20)
    first = np.argmax(lean > level, axis=0)
    before, after = (lean[first + k, range(5)] for k in (-1, 0))
    times = (first + (level - before) / (after - before)) * 1e-3
    assert times == pytest.approx([0.72633, 1.10477, 1.33693, 1.51517, 1.65475], abs=1e-4)
    assert world.ledger() == pytest.approx(begun, rel=1e-10)
