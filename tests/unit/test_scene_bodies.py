"""Scenes with stacks, platforms, plates, frames, friction laws and three dimensions."""

from __future__ import annotations

import math
import pickle
from typing import Any

import pytest

from rockslip import BlockSpec, Scene, parse_scene
from solver.errors import SceneError
from solver.scene import FrictionSpec, TimeSpec, scene_to_toml

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


def refusal(*blocks: dict[str, Any], **tables: Any) -> str:
    with pytest.raises(SceneError) as caught:
        scene(*blocks, **tables)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    assert "\n" not in str(caught.value)
    return str(caught.value)


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

    def test_elastic_blocks_need_their_constants(self) -> None:
        line = refusal(RIGID | {"model": "elastic"})
        assert line == (
            'block.young is required for an elastic block (young > 0), or set model = "rigid"'
        )
        line = refusal(RIGID | {"model": "elastic", "young": 1e9})
        assert line.startswith(
            "block.poisson is required for an elastic block (0 <= poisson < 0.5)"
        )

    def test_weightlessness(self) -> None:
        assert scene(gravity=0).gravity_vector == (0.0, 0.0)


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

    def test_unknown_carriers(self) -> None:
        line = refusal(*stack(low="foundation", top="lwo"))
        assert line == ('top.on: got "lwo", allowed "foundation" or "low", did you mean \'low\'?')
        assert refusal(*stack(low="low")).startswith('low.on: got "low", allowed "foundation"')

    def test_circles(self) -> None:
        line = refusal(*stack(ground="foundation", a="b", b="c", c="a"))
        assert line.startswith("a.on: got a on b, b on c, c on a, allowed a stack")

    def test_one_thickness_in_the_plane(self) -> None:
        low, top = stack(low="foundation", top="low")
        line = refusal(low, top | {"thickness": 0.5})
        assert line == "top.thickness: got 0.5, allowed that of low, 0.75, where dimension = 2"
        assert len(scene(low, top | {"thickness": 0.5}, dimension=3).blocks) == 2


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

    @pytest.mark.parametrize(
        ("law", "line"),
        [
            ({"static": 0.3, "dynamic": 0.4}, "dynamic: got 0.4, allowed dynamic <= static = 0.3"),
            ({"static": 0.3, "decay": 1.0}, "decay: got 1.0, allowed 0 where dynamic = static"),
            ({"static": 0.3, "cohesion_lost": True}, "cohesion_lost: got true, allowed false"),
            ({"static": -0.3}, "static: got -0.3, allowed static >= 0"),
            ({"dynamic": 0.3}, "static is required (static >= 0)"),
            ({"static": 0.3, "dynamik": 0.2}, "dynamik: unknown key, did you mean 'dynamic'?"),
        ],
    )
    def test_refused_laws(self, law: dict[str, Any], line: str) -> None:
        assert refusal(contact={"friction": law}).startswith(f"contact.friction.{line}")
        assert refusal(RIGID | {"friction": law}).startswith(f"block.friction.{line}")


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

    @pytest.mark.parametrize("foundation", [{"kind": "rigid"}, PLATE, FRAME])
    def test_others_have_none(self, foundation: dict[str, Any]) -> None:
        asked = scene(foundation=foundation)
        assert not asked.has_platform
        with pytest.raises(ValueError, match="no spring"):
            asked.platform()

    @pytest.mark.parametrize(
        ("foundation", "line"),
        [
            ({"kind": "oscillator", "period": 1.0}, "mass is required (exactly one of"),
            (OSCILLATOR | {"mass": 1.0}, "mass: got both mass and mass_ratio, allowed exactly"),
            (OSCILLATOR | {"stiffness": 1.0}, "period: got both period and stiffness, allowed"),
            ({"kind": "oscillator", "mass": 1.0}, "period is required (exactly one of"),
            (OSCILLATOR | {"damping_ratio": -1}, "damping_ratio: got -1, allowed damping_ratio >="),
            (
                PLATE | {"period": 0.5},
                'period applies to a plate with support = "rollers" only; remove it',
            ),
            (PLATE | {"support": "rollers"}, "period is required (exactly one of"),
            (PLATE | {"mass": 1.0}, "mass: got both mass and density, allowed exactly one of mass"),
            (
                PLATE | {"support": "bottom", "meshed": True},
                'meshed applies to a plate with support = "fixed" only: others',
            ),
            (PLATE | {"support": "roler"}, 'support: got "roler", allowed "fixed" or "bottom" or '),
            (PLATE | {"thickness": 1.0}, "thickness: got 1.0, allowed that of the blocks, 0.75, "),
            (PLATE | {"cell": "hexahedron"}, 'cell: got "hexahedron", allowed "quadrilateral" or '),
            (PLATE | {"bays": 2}, "bays: unknown key"),
            (FRAME | {"column": {"width": 1.0}}, "column.width: got 1.0, allowed less than deck."),
            (FRAME | {"bays": 0}, "bays: got 0, allowed a whole number, bays >= 1"),
            (FRAME | {"cells": [8, 2]}, "cells: got [8, 2], allowed a table"),
            (FRAME | {"deck": {"width": 1.0}}, "deck.height is required (height > 0)"),
            ({"width": 3.0}, 'kind is required ("rigid" or "oscillator" or "elastic" or'),
        ],
    )
    def test_refused_foundations(self, foundation: dict[str, Any], line: str) -> None:
        assert refusal(foundation=foundation).startswith(f"foundation.{line}")

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

    @pytest.mark.parametrize(
        ("block", "line"),
        [
            ({"cells": [2, 3]}, "cells: got [2, 3], allowed 3 values, each a whole number"),
            ({"cell": "triangle"}, 'cell: got "triangle", allowed "hexahedron" or "tetrahedron"'),
            ({"velocity": [1, 0]}, "velocity: got [1.0, 0.0], allowed 3 values"),
            ({"angular_velocity": 1}, "angular_velocity: got 1.0, allowed 3 values"),
            ({"angular_velocity": [1, 2]}, "angular_velocity: got [1, 2], allowed a finite number"),
            (
                {"cell": "tetrahedron", "degree": 2},
                "degree: got 2, allowed 1 for tetrahedra, or",
            ),
        ],
    )
    def test_refused_in_space(self, block: dict[str, Any], line: str) -> None:
        assert refusal(ELASTIC | block, dimension=3).startswith(f"block.{line}")

    @pytest.mark.parametrize(
        ("block", "line"),
        [
            ({"cells": [2, 3, 4]}, "cells: got [2, 3, 4], allowed 2 values, each a whole number"),
            ({"cell": "hexahedron"}, 'cell: got "hexahedron", allowed "quadrilateral" or "tria'),
            ({"velocity": [1, 0, 0]}, "velocity: got [1.0, 0.0, 0.0], allowed 2 values"),
            ({"angular_velocity": [1, 2, 3]}, "angular_velocity: got [1.0, 2.0, 3.0], allowed a f"),
            ({"offset_second": 0.1}, "offset_second: got 0.1, allowed 0 where dimension = 2"),
            ({"tilt_direction_deg": 9}, "tilt_direction_deg: got 9.0, allowed 0 where dimension"),
        ],
    )
    def test_refused_in_the_plane(self, block: dict[str, Any], line: str) -> None:
        assert refusal(ELASTIC | block).startswith(f"block.{line}")

    def test_what_is_of_the_plane_only(self) -> None:
        line = refusal(dimension=3, plane="strain")
        assert line == "plane applies to 2-D scenes only; remove it"

    def test_what_is_of_space_only(self) -> None:
        second = {"second": {"kind": "rectangular", "amplitude_g": 0.1, "duration": 1.0}}
        assert refusal(motion=second) == "motion.second applies to 3-D scenes only; remove it"
        assert scene(dimension=3, motion=second).motion is not None

    def test_foundations_in_space(self) -> None:
        assert refusal(dimension=3, foundation=PLATE).startswith("foundation.thickness is requ")
        assert refusal(dimension=3, foundation=FRAME).startswith("foundation.deck.thickness is")
        deck = {"width": 2.0, "height": 0.1, "thickness": 1.5}
        frame: Any = scene(dimension=3, foundation=FRAME | {"deck": deck}).foundation
        assert frame.column.thickness == frame.column.width
        line = refusal(dimension=3, foundation=FRAME | {"deck": deck, "bays": 2})
        assert line == "foundation.bays: got 2, allowed 1 where dimension = 3"
        thick = FRAME | {"deck": deck, "column": {"width": 0.05, "thickness": 0.8}}
        assert refusal(dimension=3, foundation=thick).startswith("foundation.column.thickness: got")

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

    def test_no_directions_within_directions(self) -> None:
        nested = self.PULSE | {"vertical": self.PULSE | {"second": self.PULSE}}
        assert (
            refusal(motion=nested)
            == "motion.vertical.second applies to [motion] itself only; remove it"
        )

    def test_ricker_by_duration_or_frequency(self) -> None:
        ricker = {"kind": "ricker", "amplitude_g": 1.0}
        assert refusal(motion=ricker).startswith("motion.duration is required (exactly")
        both = ricker | {"duration": 1.0, "frequency": 1.0}
        assert refusal(motion=both).startswith("motion.duration: got both duration and frequency")

    def test_a_kind_that_is_no_word(self) -> None:
        assert refusal(motion={"kind": ["record"]}).startswith("motion.kind: got ")

    def test_files_of_all_directions_are_looked_for(self) -> None:
        table = {"kind": "table", "file": "absent.csv"}
        line = refusal(motion=self.PULSE | {"vertical": table})
        assert line.startswith("motion.vertical.file: got ")
        assert "absent.csv" in line


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

    @pytest.mark.parametrize("key", ["stiffness", "damping"])
    def test_not_without_a_mesh(self, key: str) -> None:
        assert refusal(RIGID, contact={key: 0.5}) == (
            f"contact.{key} applies to scenes with a meshed body only, block.restitution to rigid"
            " blocks; remove it"
        )

    def test_under_a_rigid_block_its_stiffness_has_to_be_given(self) -> None:
        blocks = ELASTIC, RIGID | {"name": "top", "on": "block"}
        assert refusal(*blocks, contact={"damping": 0.5}) == (
            "contact.stiffness is required beside contact.damping, since top is rigid"
            " (stiffness > 0, Pa/m)"
        )
        scene(*blocks, contact={"damping": 0.5, "stiffness": 1e9})

    def test_ranges(self) -> None:
        line = "contact.damping: got 1.5, allowed 0 <= damping <= 1"
        assert refusal(ELASTIC, contact={"damping": 1.5}) == line
        line = "contact.stiffness: got 0, allowed stiffness > 0"
        assert refusal(ELASTIC, contact={"stiffness": 0}) == line

    def test_a_bed_that_is_too_soft(self) -> None:
        assert refusal(ELASTIC, contact={"stiffness": 1e6}) == (
            "contact.stiffness: got 1e+06, pressed in by 0.02 m under block by weight and peak"
            " acceleration, allowed stiffness >= 1.96e+07 (0.001 m)"
        )
        shaken = {"kind": "sine", "period": 1.0, "amplitude_g": 500.0}
        soft = ELASTIC | {"young": 1e7}
        assert ", from the block's own, pressed in by " in refusal(
            soft, contact={"damping": 0.2}, motion=shaken
        )


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


def test_scenes_built_in_code_are_filled_in() -> None:
    block = BlockSpec(width=1, height=2, density=2000, model="rigid", angular_velocity=(0, 0, 3))
    found = Scene(dimension=3, blocks=(block,), time=TimeSpec(end=1, step=0.5)).blocks[0]
    assert found.angular_velocity == (0.0, 0.0, 3.0)
    assert found.velocity == (0.0, 0.0, 0.0)
