"""The damping of elastic blocks in a scene that says nothing about it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scenes import BLOCK
from scipy.linalg import expm

from rockslip import Scene, parse_scene
from solver.excitation.motion import read_ground
from solver.results.cautions import cautions_of_scene
from solver.scene import DampingSpec
from solver.scene.damping import cantilever_frequency
from solver.scene.material import Material

DEFAULT = 3.7406e-5
"""beta_R of the paper's block, s."""


def scene(*overrides: str) -> Scene:
    """The paper's block."""
    return parse_scene(f"{BLOCK}\n[time]\nend = 2.0\n", overrides=overrides)


def damping(*overrides: str) -> DampingSpec:
    """That of the block."""
    asked = scene(*overrides)
    found = asked.damping_of(asked.blocks[0])
    assert found is not None
    return found


def transfer(omega: float, width: float, height: float, material: Material) -> float:
    """Residual at a free end of Timoshenko's beam at a frequency: zero at its natural ones.

    Deflection, rotation, moment and shear go from the base to the top by the exponential of their
    differential equations, for a rectangle of unit thickness in plane stress.
    """
    kappa = 5 * (1 + material.poisson) / (6 + 5 * material.poisson)
    area, inertia = width, width**3 / 12
    slope = np.zeros((4, 4))
    slope[0, 1], slope[0, 3] = 1.0, 1 / (kappa * material.shear * area)
    slope[1, 2] = 1 / (material.young * inertia)
    slope[2, 1], slope[2, 3] = -material.density * inertia * omega**2, -1.0
    slope[3, 0] = -material.density * area * omega**2
    scale = np.diag([1.0, 1.0, material.young, material.young])
    whole = expm(np.linalg.solve(scale, slope @ scale) * height)
    return float(np.linalg.det(whole[2:, 2:]))


@pytest.mark.parametrize("height", [0.05, 0.1, 0.25, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_the_frequency_is_the_lowest_of_timoshenkos_beam(height: float, poisson: float) -> None:
    """By another way of solution, above and below the cut-off frequency, and none below it."""
    material = Material(young=5e10, poisson=poisson, density=2700.0, plane="stress")
    found = cantilever_frequency(0.25, height, material, held=0.0)
    below, above = (transfer(part * found, 0.25, height, material) for part in (0.9999, 1.0001))
    assert below * above < 0
    lower = [transfer(part * found, 0.25, height, material) for part in np.linspace(0.01, 0.999)]
    assert np.ptp(np.sign(lower)) == 0


def test_a_slender_block_bends_by_euler_and_bernoulli_and_a_flat_one_shears() -> None:
    material = Material(young=5e10, poisson=0.2, density=2700.0, plane="stress")
    slender = 3.51602 * material.wave_speed * (0.25 / math.sqrt(12)) / 25.0**2
    assert cantilever_frequency(0.25, 25.0, material, 0.0) == pytest.approx(slender, rel=2e-4)
    kappa = 6.0 / 7.0
    flat = math.pi / 2 / 0.0025 * math.sqrt(kappa * material.shear / material.density)
    assert cantilever_frequency(0.25, 0.0025, material, 0.0) == pytest.approx(flat, rel=1e-3)


def test_the_default_is_two_percent_of_critical_at_the_first_bending_mode() -> None:
    asked = scene()
    frequency = asked.bending_frequency(asked.blocks[0])
    assert frequency / (2 * math.pi) == pytest.approx(170.2, rel=1e-3)
    assert damping().stiffness == pytest.approx(0.04 / frequency, rel=1e-12)
    assert damping().stiffness == pytest.approx(DEFAULT, rel=1e-4)
    assert damping().ratio(frequency) == pytest.approx(0.02, rel=1e-12)


@pytest.mark.parametrize(
    ("height", "friction", "ratio"),
    [
        (0.125, 0.3, 0.066),  # 0.22 of the friction
        (0.125, 0.05, 0.02),  # but 2 % at least
        (0.125, 2.5, 0.02),  # it rocks before it slides
        (0.25, 0.5, 0.066),  # 0.22 (1.6 - H/B) of it
        (0.5, 0.3, 0.02),
        (1.0, 0.7, 0.02),
    ],
)
def test_squat_blocks_that_slide_have_more(height: float, friction: float, ratio: float) -> None:
    asked = scene(f"block.height={height}", f"contact.friction={friction}")
    found = asked.damping_of(asked.blocks[0])
    assert found is not None
    frequency = asked.bending_frequency(asked.blocks[0])
    assert found.ratio(frequency) == pytest.approx(ratio, rel=1e-12)


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (("block.young=5e8",), 10 * DEFAULT),  # as the root of rho/E
        (("block.cells=[12, 32]", "block.degree=2", "block.cell='triangle'"), DEFAULT),
        (("time.step=1e-5", "contact.damping=0.1"), DEFAULT),
    ],
)
def test_it_depends_on_size_material_and_friction_alone(
    overrides: tuple[str, ...], expected: float
) -> None:
    assert damping(*overrides).stiffness == pytest.approx(expected, rel=1e-4)


def test_it_is_the_same_for_a_block_turned_by_90_degrees() -> None:
    turned = damping("dimension=3", "block.width=0.75", "block.thickness=0.25")
    assert turned == damping("dimension=3")


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (("damping.stiffness=0",), DampingSpec()),
        (("damping={mass=0.5, stiffness=0}",), DampingSpec(mass=0.5, stiffness=0.0)),
        (("damping.stiffness=1e-4",), DampingSpec(stiffness=1e-4)),
        (("block.damping={}",), DampingSpec()),
        (("damping.stiffness=1e-4", "block.damping={stiffness=1e-5}"), DampingSpec(stiffness=1e-5)),
    ],
)
def test_what_is_written_is_taken(overrides: tuple[str, ...], expected: DampingSpec) -> None:
    assert damping(*overrides) == expected


@pytest.mark.parametrize("table", ["damping", "block.damping"])
def test_it_stays_beside_damping_by_mass(table: str) -> None:
    """lambda_R alone says nothing of beta_R; foundations have none."""
    expected = DampingSpec(mass=0.5, stiffness=damping().stiffness)
    assert damping(f"{table}.mass=0.5") == expected
    asked = scene(f"{table}.mass=0.5")
    assert parse_scene(asked.to_dict()) == asked
    assert [*cautions_of_scene(asked, read_ground(asked))] == []
    plate = (
        "foundation={kind='elastic', support='bottom', width=2.0, height=0.2, young=5e10,"
        " poisson=0.2, density=2e3}"
    )
    on_plate = scene(f"{table}.mass=0.5", plate)
    assert on_plate.damping_of(on_plate.blocks[0]) == expected
    below = DampingSpec(mass=0.5, stiffness=0.0) if table == "damping" else None
    assert on_plate.damping_of(on_plate.foundation) == below  # type: ignore[arg-type]
    assert parse_scene(on_plate.to_dict()) == on_plate


def test_rigid_blocks_and_meshed_foundations_have_none() -> None:
    tables: dict[str, Any] = {
        "block": [
            {"name": "low", "width": 1.0, "height": 0.5, "density": 2e3, "model": "rigid"},
            {"name": "top", "on": "low", "width": 0.25, "height": 1.0, "density": 2e3},
        ],
        "foundation": {"kind": "elastic", "support": "bottom", "width": 2.0, "height": 0.2},
        "time": {"end": 1.0},
    }
    tables["block"][1] |= {"young": 5e10, "poisson": 0.2}
    tables["foundation"] |= {"density": 2e3, "young": 5e10, "poisson": 0.2}
    asked = parse_scene(tables)
    low, top = asked.blocks
    assert asked.damping is None and low.damping is None
    assert asked.damping_of(asked.foundation) is None
    assert asked.damping_of(top) == asked.default_damping(top) != DampingSpec()
