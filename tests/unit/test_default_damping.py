"""The damping of elastic blocks in a scene that says nothing about it."""

from __future__ import annotations

import math
from typing import Any

import pytest
from scenes import BLOCK

from rockslip import Scene, parse_scene
from solver.excitation.motion import read_ground
from solver.results.cautions import cautions_of_scene
from solver.scene import DampingSpec, scene_to_toml

DEFAULT = 3.6514e-5
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


def test_it_is_two_percent_of_critical_of_a_cantilever() -> None:
    """The paper's block, held at its base, bends 174 times a second by Euler and Bernoulli.

    Its frequency is (beta_1 H)^2 sqrt(E I/(rho A))/H^2 where cos(x) cosh(x) = -1 at x = beta_1 H.
    """
    root = 1.8751040687
    assert math.cos(root) * math.cosh(root) == pytest.approx(-1, abs=1e-8)
    block = scene().blocks[0]
    assert block.young is not None
    radius = block.width / math.sqrt(12)
    wave_speed = math.sqrt(block.young / block.shape.density)
    frequency = root**2 * wave_speed * radius / block.height**2
    assert frequency / (2 * math.pi) == pytest.approx(174, rel=0.01)
    assert block.bending_frequency(2) == pytest.approx(frequency, rel=1e-4)
    assert damping().stiffness == pytest.approx(0.04 / frequency, rel=1e-4)
    assert damping().stiffness == pytest.approx(DEFAULT, rel=1e-4)
    assert block.damping is not None
    assert block.damping.ratio(frequency) == pytest.approx(0.02, rel=1e-4)


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (("block.height=2.0", "block.mass=1006"), 4 * DEFAULT),  # as H^2
        (("block.width=0.5", "block.mass=1006"), DEFAULT / 2),  # as 1/B
        (("block.young=5e8",), 10 * DEFAULT),  # as the root of rho/E
        (("block.poisson=0.4", "plane='stress'"), DEFAULT),
        (("block.cells=[12, 32]", "block.degree=2", "block.cell='triangle'"), DEFAULT),
        (("time.step=1e-3",), DEFAULT),
        (("time.step=1e-5",), DEFAULT),
        (("contact.damping=0.1",), DEFAULT),
        (("dimension=3",), DEFAULT),
        (("dimension=3", "block.width=0.75", "block.thickness=0.25"), DEFAULT),  # turned by 90
    ],
)
def test_it_depends_on_size_and_material_alone(overrides: tuple[str, ...], expected: float) -> None:
    assert damping(*overrides).stiffness == pytest.approx(expected, rel=1e-4)


def test_similar_blocks_have_the_same_part_of_critical() -> None:
    """A model at a tenth of the size and a thousandth of the mass."""
    size = ("block.width=0.025", "block.height=0.1", "block.thickness=0.075", "block.mass=0.503")
    assert damping(*size).stiffness == pytest.approx(damping().stiffness / 10, rel=1e-14)


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (("damping.stiffness=0",), DampingSpec()),
        (("damping={}",), DampingSpec()),
        (("damping.mass=0.0",), DampingSpec()),
        (("damping={mass=0.5, stiffness=0}",), DampingSpec(mass=0.5, stiffness=0.0)),
        (("damping.stiffness=1e-4",), DampingSpec(stiffness=1e-4)),
        (("block.damping={}",), DampingSpec()),
        (("block.damping={stiffness=1e-5}",), DampingSpec(stiffness=1e-5)),
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
    assert cautions_of_scene(asked, read_ground(asked)) == []
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
    assert asked.damping_of(top) == top.default_damping(2) != DampingSpec()


def test_the_copy_of_a_scene_has_it_written_out() -> None:
    asked = scene()
    text = scene_to_toml(asked)
    assert "[block.damping]\nmass = 0.0\nstiffness = 3.65" in text
    assert parse_scene(text) == asked
