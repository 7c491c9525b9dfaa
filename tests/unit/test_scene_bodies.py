"""Scenes with stacks, platforms, plates, frames, friction laws and three dimensions."""

from __future__ import annotations

import math
import pickle
from typing import Any

import pytest

from rockslip import Scene, parse_scene
from solver.scene import FrictionSpec, scene_to_toml

RIGID = {"width": 0.5, "height": 1.0, "thickness": 0.75, "density": 2000.0, "model": "rigid"}
ELASTIC = RIGID | {"model": "elastic", "young": 1e9, "poisson": 0.2}
STEEL = {"young": 2e11, "poisson": 0.3}
OSCILLATOR = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
PLATE = {"kind": "elastic", "width": 3.0, "height": 0.2, "density": 2500.0, **STEEL}
ROLLERS = PLATE | {"support": "rollers", "period": 0.5}
FRAME = {
    "kind": "frame",
    "deck": {"width": 2.0, "height": 0.1},
    "column": {"width": 0.05},
    "storey": 1.5,
    "density": 7850.0,
    **STEEL,
}


def scene(*blocks: dict[str, Any], **tables: Any) -> Scene:
    content = {"block": list(blocks) or [RIGID], "time": {"end": 1.0, "step": 1e-3}}
    return parse_scene(content | tables)


def stack(**carriers: str) -> list[dict[str, Any]]:
    return [RIGID | {"name": name, "on": on} for name, on in carriers.items()]


class TestModels:
    def test_the_same_scene_with_one_word_changed(self) -> None:
        full = ELASTIC | {"cells": [3, 5], "cell": "triangle", "degree": 2, "refinement": 2.0}
        elastic, rigid = (scene(full | {"model": word}).blocks[0] for word in ("elastic", "rigid"))
        assert elastic.elasticity == (1e9, 0.2)
        assert (rigid.young, rigid.cells, rigid.cell) == (1e9, (3, 5), "triangle")
        with pytest.raises(ValueError, match="block is rigid"):
            _ = rigid.elasticity


class TestStacks:
    def test_order_puts_carriers_first_and_else_keeps_that_of_the_file(self) -> None:
        blocks = stack(top="middle", side="foundation", middle="low", low="foundation")
        blocks[1]["offset"] = 5.0
        asked = scene(*blocks)
        assert [block.name for block in asked.blocks] == ["top", "side", "middle", "low"]
        assert [block.name for block in asked.order] == ["side", "low", "middle", "top"]
        carrier = asked.carrier_of(asked.blocks[0])
        assert carrier is asked.blocks[2]
        assert asked.carrier_of(asked.blocks[1]) is None
        assert asked.carried_mass == pytest.approx(4 * 750.0)


class TestFriction:
    def test_a_number_is_a_law(self) -> None:
        asked = scene(*stack(low="foundation", top="low"), contact={"friction": 0.3})
        assert asked.contact.friction == 0.3
        assert asked.friction_of(asked.blocks[1]) == FrictionSpec(static=0.3, dynamic=0.3)

    def test_a_block_may_have_its_own(self) -> None:
        low, top = stack(low="foundation", top="low")
        law = {"static": 0.6, "dynamic": 0.5, "decay": 20.0, "cohesion": 1e3, "cohesion_lost": True}
        asked = scene(low | {"friction": law}, top | {"friction": 0.2})
        found = asked.friction_of(asked.blocks[0])
        assert (found.static, found.dynamic, found.decay) == (0.6, 0.5, 20.0)
        assert (found.cohesion, found.cohesion_lost) == (1e3, True)
        assert asked.friction_of(asked.blocks[1]).static == 0.2
        assert asked.contact.friction == 0.6


class TestPlatforms:
    def test_oscillator_by_ratio_and_period(self) -> None:
        asked = scene(foundation=OSCILLATOR)
        mass, stiffness, damping = platform = asked.platform()
        assert asked.has_platform
        assert mass == pytest.approx(750.0 / 2)
        assert stiffness == pytest.approx(mass * (4 * math.pi) ** 2)
        assert damping == pytest.approx(2 * 0.05 * math.sqrt(stiffness * mass))
        assert (platform.period, platform.damping_ratio) == pytest.approx((0.5, 0.05))

    def test_oscillator_by_mass_and_stiffness(self) -> None:
        spec = {"kind": "oscillator", "mass": 10.0, "stiffness": 40.0}
        assert scene(foundation=spec).platform() == (10.0, 40.0, 0.0)

    def test_rollers_make_a_plate_a_platform(self) -> None:
        platform = scene(foundation=ROLLERS).platform()
        assert platform.mass == pytest.approx(2500.0 * 3.0 * 0.2 * 0.75)
        assert platform.period == pytest.approx(0.5)
        heavy = {key: value for key, value in ROLLERS.items() if key != "density"}
        assert scene(foundation=heavy | {"mass_ratio": 2.0}).platform().mass == pytest.approx(375.0)

    def test_defaults_of_meshed_foundations(self) -> None:
        plate: Any = scene(foundation=PLATE).foundation
        assert (plate.support, plate.thickness, plate.cells) == ("fixed", 0.75, (24, 4))
        assert plate.shape(1.0).mass == pytest.approx(2500.0 * 3.0 * 0.2 * 0.75)
        frame: Any = scene(foundation=FRAME).foundation
        assert (frame.deck.thickness, frame.column.thickness, frame.bays) == (0.75, 0.75, 1)
        assert scene(foundation={}).foundation.kind == "rigid"


class TestSpace:
    def test_defaults(self) -> None:
        asked = scene(ELASTIC, dimension=3, gravity=10, gravity_tilt_deg=30)
        block = asked.blocks[0]
        assert (block.cells, block.cell) == ((6, 6, 16), "hexahedron")
        assert (block.velocity, block.angular_velocity) == ((0.0,) * 3, (0.0,) * 3)
        assert asked.gravity_vector == pytest.approx((5.0, 0.0, -8.660254037844386))
        assert asked.plane is None
        assert "plane" not in asked.to_dict()
        flat = scene(ELASTIC).blocks[0]
        assert (flat.velocity, flat.angular_velocity) == ((0.0, 0.0), 0.0)

    def test_what_is_of_space_only(self) -> None:
        second = {"second": {"kind": "rectangular", "amplitude_g": 0.1, "duration": 1.0}}
        assert scene(dimension=3, motion=second).motion is not None

    def test_foundations_in_space(self) -> None:
        deck = {"width": 2.0, "height": 0.1, "thickness": 1.5}
        frame: Any = scene(dimension=3, foundation=FRAME | {"deck": deck}).foundation
        assert frame.column.thickness == frame.column.width

    def test_quadratic_tetrahedra_with_gauss_points(self) -> None:
        block = ELASTIC | {"cell": "tetrahedron", "degree": 2}
        assert scene(block, dimension=3, contact={"points": "gauss"}).blocks[0].degree == 2
        rigid = scene(block | {"model": "rigid"}, dimension=3).blocks[0]
        assert rigid.model == "rigid"


class TestMotions:
    PULSE = {"kind": "half_sine", "amplitude_g": 0.5, "duration": 0.5}  # noqa: RUF012

    def test_vertical_alone(self) -> None:
        motion: Any = scene(motion={"vertical": self.PULSE}).motion
        assert (motion.kind, motion.vertical.kind) == ("none", "half_sine")


class TestBed:
    def test_as_damped_as_asked_for_and_a_tenth_as_stiff_as_the_block(self) -> None:
        found = scene(ELASTIC, contact={"damping": 0.3})
        bed = found.bed_of(found.blocks[0])
        assert bed is not None
        stiffness = 0.1 * found.blocks[0].material("strain").longitudinal / 1.0
        assert bed.stiffness == pytest.approx(stiffness)
        dashpot = bed.retardation * stiffness
        assert dashpot == pytest.approx(0.3 * 2 * math.sqrt(stiffness * 2000.0 * 1.0))

    def test_none_unless_asked_for(self) -> None:
        found = scene(ELASTIC, contact={"damping": 0.0})
        assert found.bed_of(found.blocks[0]) is None


@pytest.mark.parametrize(
    "tables",
    [
        {"foundation": OSCILLATOR},
        {"contact": {"stiffness": 1e9, "damping": 0.1}},
        {"foundation": ROLLERS, "contact": {"friction": {"static": 0.6, "dynamic": 0.5}}},
        {"foundation": FRAME},
        {"foundation": FRAME | {"deck": {"width": 2, "height": 1, "thickness": 3}}, "dimension": 3},
        {"foundation": ROLLERS | {"thickness": 2.0}, "dimension": 3},
        {"motion": {"vertical": TestMotions.PULSE, "second": TestMotions.PULSE}, "dimension": 3},
        {"motion": {"kind": "ricker", "amplitude_g": 1, "frequency": 2}},
        {"gravity": 0},
    ],
)
def test_round_trip(tables: dict[str, Any]) -> None:
    blocks = [ELASTIC | {"friction": 0.2}, RIGID | {"name": "top", "on": "block", "offset": 0.4}]
    asked = scene(*blocks, **tables)
    assert parse_scene(scene_to_toml(asked)) == asked
    assert parse_scene(asked.to_dict()) == asked
    assert pickle.loads(pickle.dumps(asked)) == asked
