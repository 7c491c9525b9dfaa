"""Stacks of meshed blocks in space, whose edges cross: exact work, energy, momentum, motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from geometry.block import Block
from geometry.foundation import level_frame
from geometry.mesh import block_mesh
from geometry.tags import FacetTag
from rockslip import Scene, parse_scene, simulate
from solver.bodies.elastic_body import ElasticBody
from solver.contact.carriers import Face
from solver.contact.edge_crossings import CrossingInterface, Crossings
from solver.contact.facets import carrier_surface
from solver.contact.kinematics import ContactIncrement, ForceWeights
from solver.contact.pairs import Link
from solver.contact.surfaces import outline_of
from solver.scene import FrictionSpec
from solver.scene.material import Material
from solver.stepping.system import System
from tests.momentum import imbalance

Array = NDArray[np.float64]

G = 9.81
LAW = FrictionSpec(static=0.5)
UPPER, LOWER = (
    Block(width=1.0, height=0.4, thickness=thickness, density=2000.0) for thickness in (0.8, 1.1)
)
STONE = {"young": 3e10, "poisson": 0.2, "density": 2400.0, "thickness": 1.0}
CUBE = STONE | {"width": 1.0, "height": 1.0, "cells": [2, 2, 2]}


def outlined(shape: Block, tag: FacetTag, cell: str, degree: int) -> tuple[ElasticBody, Face]:
    """A meshed body and one of its level faces."""
    made = block_mesh(shape, dimension=3, cells=(4, 3, 1), cell=cell)
    material = Material(young=1e6, poisson=0.2, density=shape.density, plane="solid")
    body = ElasticBody(made.mesh, material, degree=degree, name="body")
    surface = carrier_surface(body.space, made.facet_tags, int(tag))
    up = 1.0 if tag == FacetTag.TOP else -1.0
    frame = level_frame(3, up)
    return body, Face.of_mesh(body, surface, frame)


def placed(body: ElasticBody, turn: tuple[float, ...], shift: tuple[float, ...]) -> Array:
    """Displacements of a body that is bent, turned and shifted."""
    nodes = body.nodes
    noise = 2e-3 * np.random.default_rng(len(nodes)).standard_normal(nodes.shape)
    bent = nodes + noise + 0.01 * np.sin(3 * nodes[:, ::-1])
    return np.asarray((bent @ Rotation.from_rotvec(turn).as_matrix().T + shift - nodes).ravel())


def crossed(bottom: Face, top: Face) -> CrossingInterface:
    """Interface of the crossing edges of two faces."""
    over, under = (outline_of(face, np.eye(3)[2]) for face in (bottom, top))
    return CrossingInterface(Crossings(over, under, top, bottom), LAW)


@pytest.fixture(scope="module")
def squares() -> tuple[ElasticBody, ElasticBody, CrossingInterface]:
    """An upper block on a lower one of equal shape."""
    shape = Block(width=1.0, height=0.4, thickness=1.0, density=2000.0)
    upper, bottom = outlined(shape, FacetTag.BOTTOM, "hexahedron", 1)
    lower, top = outlined(shape, FacetTag.TOP, "hexahedron", 1)
    return upper, lower, crossed(bottom, top)


@pytest.mark.parametrize(
    ("yaw", "along", "across", "tilt", "count"),
    [
        (0.0, 0.0, 0.0, 0.0, 0),  # the corners carry
        (0.0, 0.1, 0.2, 0.0, 2),
        (0.0, 0.1, 0.0, 0.05, 2),  # edges one above the other cross nowhere
        (0.8, 0.0, 0.0, 0.0, 8),
        (5e-4, 0.0, 0.0, 0.0, 4),  # not those that are all but parallel
        (0.0, 0.1, 0.2, 2.2, 0),  # on its back
        (0.0, 1.1, 0.0, 0.0, 0),  # beside it
    ],
)
def test_edges_that_cross(
    squares: tuple[ElasticBody, ElasticBody, CrossingInterface],
    yaw: float,
    along: float,
    across: float,
    tilt: float,
    count: int,
) -> None:
    """The corners of the polygon in which both faces touch that are corners of neither."""
    upper, lower, interface = squares
    turn = Rotation.from_rotvec((0.0, tilt, 0.0)) * Rotation.from_rotvec((0.0, 0.0, yaw))
    lifted = (along, across, 0.4 + max(0.0, 0.5 * np.sin(tilt)))
    u = (upper.nodes @ turn.as_matrix().T + lifted - upper.nodes).ravel()
    memory = interface.start(u, np.zeros(lower.nodes.size), np.eye(3), np.eye(3))
    assert memory.may_touch.sum() == count


@pytest.mark.parametrize(("cell", "degree"), [("hexahedron", 1), ("tetrahedron", 2)])
@pytest.mark.parametrize("travel", [1.0, 1e-3])
def test_work_at_crossings_is_exact(cell: str, degree: int, travel: float) -> None:
    """f.(y1 - y0), over several segments and on one; forces are opposite, gaps those of lines."""
    (upper, bottom), (lower, top) = (
        outlined(UPPER, FacetTag.BOTTOM, cell, degree),
        outlined(LOWER, FacetTag.TOP, cell, degree),
    )
    over, under = (outline_of(face, np.eye(3)[2]) for face in (bottom, top))
    interface = CrossingInterface(Crossings(over, under, top, bottom), LAW)
    system = System([upper, lower])
    u0 = np.concatenate(
        [
            placed(upper, (0.05, 0.1, 0.5), (-0.25, 0.1, 0.46)),
            placed(lower, (0.0, 0.05, 0.0), (0,) * 3),
        ]
    )
    far = np.concatenate(
        [
            placed(upper, (0.1, 0.15, 0.7), (0.2, 0.35, 0.5)),
            placed(lower, (0.03, 0.1, 0.1), (0, 0, 0.02)),
        ]
    )
    u1 = u0 + travel * (far - u0)
    middle = 0.5 * (u0 + u1)
    memory = interface.start(system.part(u0, 0), system.part(u0, 1), np.eye(3), np.eye(3))
    memory = interface.prepare(memory, system.part(middle, 0), system.part(middle, 1))
    surface, kinematics = interface.observe(system.part(u1, 0), system.part(u1, 1), memory)
    present = np.flatnonzero(memory.may_touch)
    assert len(present) >= 4
    assert (
        kinematics.own_projection is not None
        and kinematics.projection is not None
        and memory.kinematics.own_projection is not None
    )
    moved = (
        memory.kinematics.own_projection.segment[present]
        != kinematics.own_projection.segment[present]
    )
    assert moved.any() == (travel == 1.0)
    apart = kinematics.own_projection.carried(surface.position) - kinematics.projection.carried(
        kinematics.carrier.position
    )
    normal = memory.kinematics.frame[:, 0]
    np.testing.assert_allclose(
        apart[present], (kinematics.place[:, :1] * normal)[present], atol=1e-12
    )
    force = np.zeros((interface.count, 3))
    force[present] = np.random.default_rng(5).uniform(0.5, 1.5, (len(present), 3))
    target = np.zeros(system.size)
    increment = ContactIncrement(memory.seen, (surface, kinematics), force)
    interface.add_forces(
        increment, system.parts(target, Link(interface, 0, 1)), ForceWeights.of(1.0, 0.0, 1.0)
    )
    y = [seen.augmented for seen in (memory.kinematics, kinematics)]
    work = force * (y[1] - y[0])
    assert target @ (u1 - u0) == pytest.approx(work.sum(), abs=1e-10 * np.abs(work).sum())
    total = [target[own].reshape(-1, 3).sum(axis=0) for own in system.slices]
    np.testing.assert_allclose(total[0], -total[1], atol=1e-11 * np.abs(force).sum())
    assert np.linalg.norm(total[0]) > 0.1 * np.abs(force).sum()


def stack(upper: dict[str, Any], *, end: float, lower: dict[str, Any] = CUBE, **more: Any) -> Scene:
    """Two blocks in space, one on the other."""
    content = {
        "dimension": 3,
        "block": [lower | {"name": "lower"}, upper | {"name": "upper", "on": "lower"}],
        "contact": {"friction": 0.7},
        "damping": {"stiffness": 0.0},
        "time": {"end": end, "step": 4e-3},
    }
    return parse_scene(content | more)


TOWER = CUBE | {"width": 0.6, "thickness": 0.6, "height": 1.2, "cells": [1, 1, 2]}
LEANING = {"tilt_deg": 3.0, "tilt_direction_deg": 30.0}
TURNING = LEANING | {"angular_velocity": [0.2, 0.3, 1.5]}
OVERHANGING = {"thickness": 0.6, "offset": 0.55, "offset_second": 0.1, "cells": [1, 1, 1]}
"""Two edges lie over the right edge of the block below, with no node near: it tips over that."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "run",
    [stack(TOWER | LEANING, lower=TOWER, end=1.0), stack(CUBE | TURNING, end=0.3)],
    ids=["towers", "turning-cubes"],
)
def test_equal_blocks_rock_on_each_other(run: Scene) -> None:
    """No energy is made, all of it is accounted for, nothing sinks in.

    Without contact of edges blocks would be 4 mm and 14 mm in each other.
    """
    result = simulate(run)
    energy, cost = result.summary["energy"], result.summary["cost"]
    assert result.status == "completed", result.summary["reason"]
    assert energy["largest_gain_fraction"] < 1e-9
    assert energy["ledger_error_fraction"] < 1e-10
    assert cost["rejected_steps"] <= 0.02 * cost["steps"]
    lean = np.abs(result.history["upper.angle_rad"])
    assert lean.min() < 0.1 * lean[0]
    for name in ("lower", "upper"):
        assert result.history[f"{name}.penetration_m"].max() < 2e-6


def test_forces_at_crossings_balance_momentum() -> None:
    """While two crossings carry a block, to 1e-10 of the weight."""
    options = "-rockslip_snes_atol", "1e-8"
    assert imbalance(stack(CUBE | OVERHANGING, end=0.12), 30, petsc_options=options) < 1e-10


def test_a_block_tips_over_a_crossing_as_the_rigid_one() -> None:
    """Within 2 % of the largest angle; the moving edge carries all of its weight."""
    upper, rigid = CUBE | OVERHANGING, {"model": "rigid"}
    runs = stack(upper, end=0.4), stack(upper | rigid, lower=CUBE | rigid, end=0.4)
    found, expected = (simulate(run).history for run in runs)
    peak = np.abs(expected["upper.angle_rad"]).max()
    assert peak > 0.1
    for axis in "xyz":
        column = f"upper.angle_{axis}_rad"
        assert found[column] == pytest.approx(expected[column], abs=0.02 * peak)
