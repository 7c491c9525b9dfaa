"""Uneven mass in small: densities over cells, criteria of both edges, studies, pictures, limits."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from overturning import housner_fate

from geometry.block import SIDES, Block
from geometry.density import LinearDensity, Part, PartedDensity, share_in_box
from rockslip import Scene, parse_scene, simulate
from solver.cli import main
from solver.errors import SceneError
from solver.excitation.motion import read_ground
from solver.pictures.contact import _foot
from solver.reference import answer
from solver.reference.housner import housner
from solver.reference.initiation import (
    expected_mode,
    initial_mode,
    release_friction,
    rocking_friction,
)
from solver.results.cautions import cautions_of_scene
from solver.results.motion import BlockMotion, leaning, slenderness
from solver.scene import scene_to_toml
from solver.scene.scaling import Scale, scaled_tables
from solver.study.damping.calibration import speed_at_impact
from solver.study.inertia.cells import cells_of, tables_of
from solver.study.overturning.blocks import PULSES, RigidUnderPulses, Upright

G = 9.81

BLOCK = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0, "model": "rigid"}

OFF = BLOCK | {"centre_of_mass": [0.02, 0.55]}

TEXT = """
[[block]]
width = 0.25
height = 1.0
thickness = 0.75
mass = 503.0
centre_of_mass = [0.02, 0.55]
model = "rigid"
[time]
end = 0.5
step = 1e-3
"""


def scene(block: dict[str, Any], **tables: Any) -> Scene:
    """A block on firm ground."""
    return parse_scene({"block": [block], "time": {"end": 1.0, "step": 1e-3}} | tables)


def shape_of(block: dict[str, Any], **tables: Any) -> Block:
    """Its shape."""
    return scene(block, **tables).blocks[0].shape


# ---------------------------------------------------------------- densities


@pytest.mark.parametrize("d", [2, 3])
def test_shares_of_simplices_in_a_box_add_up(d: int) -> None:
    """Over a box that is cut into boxes, and against points at random in one of them."""
    chance = np.random.default_rng(7)
    for _ in range(20):
        simplex = chance.uniform(-1, 1, (d + 1, d))
        cut = chance.uniform(-0.5, 0.5, d)
        total = 0.0
        for corner in np.ndindex(*(2,) * d):
            low = [(-9.0, x)[k] for k, x in zip(corner, cut, strict=True)]
            high = [(x, 9.0)[k] for k, x in zip(corner, cut, strict=True)]
            total += share_in_box(simplex, low, high)
        assert total == pytest.approx(1.0, abs=1e-12)
    weights = chance.dirichlet(np.ones(d + 1), 200_000)
    points = weights @ simplex
    inside = np.all((points > -0.3) & (points < 0.4), axis=1).mean()
    assert share_in_box(simplex, [-0.3] * d, [0.4] * d) == pytest.approx(inside, abs=5e-3)


def test_a_simplex_that_touches_a_box_has_no_share_in_it() -> None:
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    assert share_in_box(corner, [-1.0, -1.0], [0.0, 1.0]) == 0.0
    assert share_in_box(corner, [0.0, 0.0], [1.0, 1.0]) == 1.0
    assert share_in_box(corner, [0.0, 0.0], [0.5, 1.0]) == pytest.approx(0.75)


def test_means_over_boxes() -> None:
    cells = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 2.0], [1.0, 2.0]]])
    part = Part((0.5, 1.0), (3.0, 4.0), 3.0)
    density = PartedDensity(rest=0.5, parts=(part,))
    assert density.in_cells(cells) == pytest.approx([0.5 + 0.25 * 2.5])


def test_a_linear_density_is_what_it_says() -> None:
    density = LinearDensity(off=(0.02, 0.05), sizes=(0.25, 1.0))
    ends = np.array([[x, y] for x in (-0.125, 0.125) for y in (0.0, 1.0)])
    values = density.in_cells(ends)
    assert values.mean() == pytest.approx(1.0)
    assert values.min() == pytest.approx(1 - 6 * density.reach)
    grid = (np.arange(400) + 0.5) / 400
    x, y = np.meshgrid(0.25 * (grid - 0.5), grid)
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    centre = density.in_cells(points) @ points / len(points)
    assert centre == pytest.approx([0.02, 0.55], abs=1e-6)
    assert density.least([0.25 / 6, 1.0 / 16]) == pytest.approx(
        density.in_cells(np.array([[-0.125 + 0.125 / 6, 0.5 / 16]]))[0]
    )


def test_at_the_limit_of_a_linear_density() -> None:
    """Nothing is negative, and a step more is refused."""
    shape_of(BLOCK | {"centre_of_mass": [0.25 / 6, 0.5]})
    with pytest.raises(SceneError, match="1/6"):
        shape_of(BLOCK | {"centre_of_mass": [0.0418, 0.5]})
    assert shape_of(BLOCK | {"centre_of_mass": [0.1, 0.9], "inertia": 10.0}).arm(1) < 0.026


def test_limits_of_cells_take_the_least_density() -> None:
    """Sound is fastest where a block is lightest; the mean alone would be allowed."""
    stiff = BLOCK | {"model": "elastic", "young": 4.5e16, "poisson": 0.2}
    assert scene(stiff)
    with pytest.raises(SceneError, match="sound crosses"):
        scene(stiff | {"centre_of_mass": [0.04, 0.5]})
    parts = [{"from": [-0.1, 0.0], "to": [0.1, 0.5], "density": 20.0}]
    plain = {key: value for key, value in stiff.items() if key != "mass"} | {"density": 2700.0}
    with pytest.raises(SceneError, match="sound crosses"):
        scene(plain | {"parts": parts})


# ---------------------------------------------------------------- numbers of both edges


def test_a_block_seen_across() -> None:
    """Along y as along x of the block that is turned; the other way round the sides change."""
    tables = {"dimension": 3}
    own = shape_of(BLOCK | {"centre_of_mass": [0.01, -0.03, 0.55]}, **tables)
    turned = shape_of(
        BLOCK | {"width": 0.75, "thickness": 0.25, "centre_of_mass": [-0.03, -0.01, 0.55]},
        **tables,
    )
    across = own.across((0.0, 1.0))
    back = own.across((-1.0, 0.0))
    for side in SIDES:
        assert across.slenderness(side) == pytest.approx(turned.slenderness(side), rel=1e-14)
        assert across.frequency(G, side) == pytest.approx(turned.frequency(G, side), rel=1e-13)
        assert across.restitution(side) == pytest.approx(turned.restitution(side), rel=1e-13)
        assert back.slenderness(side) == pytest.approx(own.slenderness(-side), rel=1e-14)
    tensor = np.array(turned.inertia_tensor)
    assert np.array(across.inertia_tensor) == pytest.approx(tensor, abs=1e-10)
    assert own.first_side == 1 and across.first_side == -1
    assert across.slenderness() == across.slenderness(-1) < across.slenderness(1)


def test_criteria_of_an_even_block_are_shentons() -> None:
    """With its inertia spelt out, the general formulas are those of H/B."""
    for r in (1.5, 4.0, 10.0):
        j = (1 + r**2) / 3
        for a in (1.01 / r, 0.7, 2.0):
            assert rocking_friction(a, r, j) == pytest.approx(rocking_friction(a, r), rel=1e-13)
            for mu in (0.1, 0.3, 1.0):
                assert initial_mode(a, mu, r, j) == initial_mode(a, mu, r)


@pytest.mark.parametrize("side", SIDES)
def test_friction_that_pure_rocking_needs(side: int) -> None:
    """Forces of a block that turns about its edge under a sudden acceleration of the ground."""
    shape = shape_of(OFF)
    b, h, inertia, a = shape.arm(side), shape.centre_height, shape.rotary_inertia, 0.6 * G
    turn = shape.mass * (a * h - G * b) / (inertia + shape.mass * (b**2 + h**2))
    needed = (a - h * turn) / (G + b * turn)
    j = inertia / (shape.mass * b**2)
    assert rocking_friction(0.6, h / b, j) == pytest.approx(needed, rel=1e-13)


@pytest.mark.parametrize("side", SIDES)
def test_friction_that_a_release_needs(side: int) -> None:
    shape, tilt = shape_of(OFF), math.radians(3.0)
    lean, radius = shape.slenderness(side) - tilt, shape.radius(side)
    turn = shape.frequency(G, side) ** 2 * math.sin(lean)
    across, up = radius * turn * math.cos(lean), -radius * turn * math.sin(lean)
    share = shape.mass * radius**2 / shape.rotary_inertia_about_corner(side)
    found = release_friction(tilt, shape.slenderness(side), share)
    assert found == pytest.approx(across / (G + up), rel=1e-12)


def test_the_side_that_moves_first_decides() -> None:
    """Ground that accelerates towards -x tips it towards +x, where b/h is 0.191 and not 0.264."""
    for amplitude, mode in ((-0.22, "rock"), (0.22, "rest"), (0.3, "rock"), (-0.18, "rest")):
        push = {"kind": "half_sine", "amplitude_g": amplitude, "duration": 0.3}
        asked = scene(OFF, motion=push)
        assert expected_mode(asked, read_ground(asked)) == mode
        rocks = np.abs(simulate(asked).history["block.angle_rad"]).max() > 1e-3
        assert rocks == (mode == "rock")
    assert expected_mode(scene(OFF | {"tilt_deg": 12.0})) == "overturned"
    assert expected_mode(scene(OFF | {"tilt_deg": -12.0})) != "overturned"
    thrown = {"contact": {"friction": 0.22}}
    assert expected_mode(scene(OFF | {"velocity": [1.0, 0.0]}, **thrown)) == "slide-rock"
    assert expected_mode(scene(OFF | {"velocity": [-1.0, 0.0]}, **thrown)) == "slide"


def test_modes_of_samples(tmp_path: Path) -> None:
    """Of samples each side has its own peak, too."""
    file = tmp_path / "push.csv"
    file.write_text("0,0\n0.1,0.22\n0.2,0\n0.3,-0.1\n0.4,0\n")
    asked = scene(OFF, motion={"kind": "table", "file": str(file)})
    assert expected_mode(asked) == "rest"
    file.write_text("0,0\n0.1,-0.22\n0.2,0\n0.3,0.1\n0.4,0\n")
    assert expected_mode(asked) == "rock"


def test_answers_on_a_platform() -> None:
    """Rocking where friction holds it at both edges, else sliding, which it may not lift in."""
    base = {"foundation": {"kind": "oscillator", "mass_ratio": 1.0, "period": 0.5}}
    push = {"motion": {"kind": "half_sine", "amplitude_g": -0.6, "duration": 0.3}}
    for friction, name in ((0.3, answer.ROCKING_ON_PLATFORM), (0.22, answer.ON_PLATFORM)):
        asked = scene(OFF, contact={"friction": friction}, **base, **push)
        assert answer.reference_name(asked) == name
    with pytest.raises(SceneError, match="would rock"):
        answer.reference_history(asked)


def test_a_block_overturns_over_its_own_edge() -> None:
    """12 degrees are beyond the balance towards +x, and not towards -x.

    From there it comes back, and has energy enough to go over the nearer edge.
    """
    still = {"contact": {"friction": 2.0}, "time": {"end": 2.0, "step": 1e-3}}
    assert simulate(scene(OFF | {"tilt_deg": -12.0}, **still)).history["block.angle_rad"][-1] > 1.0
    still["time"] = {"end": 0.5, "step": 1e-3}
    for tilt, word in ((12.0, "overturned"), (-12.0, "rock")):
        result = simulate(scene(OFF | {"tilt_deg": tilt}, **still))
        known = result.summary["blocks"]["block"]
        assert known["mode"] == word
        over = abs(math.radians(tilt)) / math.atan2(0.125 - math.copysign(0.02, tilt), 0.55)
        assert known["peak_angle_over_alpha"] >= over * (1 - 1e-9)
        if tilt < 0:
            assert known["peak_angle_over_alpha_while_standing"] == pytest.approx(over, rel=1e-6)


def test_slenderness_in_space_is_that_of_the_way_it_leans() -> None:
    block = BLOCK | {"centre_of_mass": [0.01, -0.03, 0.55]}
    shape = shape_of(block, dimension=3)
    for direction, wanted in (
        (0.0, shape.slenderness(1)),
        (180.0, shape.slenderness(-1)),
        (90.0, shape.across((0.0, 1.0)).slenderness(1)),
        (-90.0, shape.across((0.0, 1.0)).slenderness(-1)),
    ):
        leant = block | {"tilt_deg": 3.0, "tilt_direction_deg": direction}
        given = scene(leant, dimension=3, time={"end": 0.01, "step": 1e-3})
        history = simulate(given).history
        assert slenderness(history, given.blocks[0])[0] == pytest.approx(wanted, rel=1e-12)
        found = leaning(history, given.blocks[0])
        assert found.shape.slenderness(int(np.sign(found.angle[0]))) == pytest.approx(wanted)
        motion = BlockMotion(given, history, given.blocks[0])
        assert np.broadcast_to(motion.tipping.balance, (11,))[0] == pytest.approx(wanted)


# ---------------------------------------------------------------- scenes


@pytest.mark.parametrize(
    ("block", "tables"),
    [
        (OFF, {}),
        (OFF | {"inertia": 40.0}, {}),
        (BLOCK | {"inertia": [60.0, 50.0, 12.0]}, {"dimension": 3}),
        (
            {k: v for k, v in BLOCK.items() if k != "mass"}
            | {"density": 900.0}
            | {"parts": [{"from": [0.0, 0.1], "to": [0.1, 0.3], "density": 7800.0}]},
            {},
        ),
    ],
)
@pytest.mark.parametrize("keeps", ["density", "young"])
def test_models_at_another_scale(block: dict[str, Any], tables: Any, keeps: Any) -> None:
    """Scenes as text and back, and models whose angles are those of the prototype."""
    given = scene(block, **tables)
    assert parse_scene(scene_to_toml(given)) == given
    assert parse_scene(given.to_dict()) == given
    model = parse_scene(scaled_tables(given, Scale(0.25, keeps), {})).blocks[0].shape
    shape = given.blocks[0].shape
    masses = 4.0**-3 if keeps == "density" else 4.0**-2
    assert model.mass == pytest.approx(masses * shape.mass, rel=1e-13)
    assert model.rotary_inertia == pytest.approx(masses / 16 * shape.rotary_inertia, rel=1e-13)
    for side in SIDES:
        assert model.slenderness(side) == pytest.approx(shape.slenderness(side), rel=1e-13)
        assert model.restitution(side) == pytest.approx(shape.restitution(side), rel=1e-12)


def test_a_part_whose_unit_is_in_doubt_is_named() -> None:
    parts = [{"from": [0.0, 0.1], "to": [0.1, 0.3], "density": 7.8}]
    given = scene(
        {k: v for k, v in BLOCK.items() if k != "mass"} | {"density": 900.0, "parts": parts}
    )
    (caution,) = cautions_of_scene(given, read_ground(given))
    assert "part 1 of block weighs 7.8 kg/m3" in caution


# ---------------------------------------------------------------- studies and pictures


def test_the_study_of_modes_takes_even_blocks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(TEXT)
    assert main(["study", "modes", str(file), "--out", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "block.centre_of_mass: got an uneven block, allowed none in this study" in line


def test_the_study_of_inertia_takes_even_blocks_where_they_change() -> None:
    given = scene(OFF, foundation={"kind": "oscillator", "mass_ratio": 1.0, "period": 0.5})
    tables = given.to_dict()
    cell = cells_of(given, {})[0]
    assert tables_of(tables, cell, "rigid")["block"][0]["centre_of_mass"] == [0.02, 0.55]
    with pytest.raises(SceneError, match="an uneven block"):
        tables_of(tables, cell._replace(aspect=3.0), "rigid")


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_overturning_of_both_edges(sign: float) -> None:
    """The engine and the equation say the same of pulses of either sign."""
    given = scene(OFF, contact={"friction": 2.0})
    upright, shape = Upright.of(given), given.blocks[0].shape
    assert upright.high(1.0) == pytest.approx(503.0 * G * shape.radius(1))
    assert upright.slenderness(-1.0) > upright.slenderness(1.0)
    kind = PULSES["one_sine"]
    engine = RigidUnderPulses(given, kind, 3.0)
    fates = []
    for amplitude in (1.2, 2.0, 3.0, 4.0, 6.0):
        own = engine(sign * amplitude)
        assert own.label == housner_fate(given, kind, 3.0, sign * amplitude)
        pulse = kind.motion(sign * amplitude * upright.unit, 3.0 * upright.frequency)
        known = housner(
            shape, gravity=G, end=pulse.stop, step=pulse.stop / 40, acceleration=pulse.acceleration
        )
        angle, spin = known.angle[-1], known.angular_velocity[-1]
        side = -1 if angle < 0 else 1
        kinetic = shape.rotary_inertia_about_corner(side) * spin**2 / 2
        lean = shape.slenderness(side) - abs(angle)
        energy = kinetic + math.cos(lean) * upright.high(angle)
        margin = upright.margin(energy, angle, spin)
        assert own.margin == pytest.approx(abs(margin) * (1 if own.overturns else -1), abs=0.02)
        fates.append(own.overturns)
    assert {True, False} == set(fates)


def test_speeds_at_impacts_of_both_edges() -> None:
    """What a calibration takes from measured peaks: energy about the edge of the swing."""
    shape = shape_of(OFF)
    for side in SIDES:
        alpha, p = shape.slenderness(side), shape.frequency(G, side)
        wanted = p * math.sqrt(2 * (math.cos(alpha - 0.05) - math.cos(alpha)))
        assert speed_at_impact(0.05, shape, G, 0.0, side) == pytest.approx(wanted, rel=1e-12)
        with_drag = speed_at_impact(0.05, shape, G, 1e-9, side)
        assert with_drag == pytest.approx(wanted, rel=1e-6)


def test_the_force_of_a_film_is_below_the_centre_of_mass() -> None:
    """Flat on its bottom; on a corner it is there."""
    corners, up = np.array([0.125, 0.5]) * [(x, y) for x in (-1, 1) for y in (-1, 1)], [[0.0, 1.0]]
    heavy = np.array([0.02, 0.05])
    flat = _foot(np.array([[0.0, 0.5]]), np.eye(2)[None], corners, np.array(up), heavy)
    assert flat[0] == pytest.approx([0.02, 0.0], abs=1e-9)
    c, s = math.cos(0.3), math.sin(0.3)
    turned = np.array([[[c, s], [-s, c]]])
    leans = _foot(np.array([[0.0, 0.6]]), turned, corners, np.array(up), heavy)
    corner = turned[0] @ [0.125, -0.5] + [0.0, 0.6]
    assert leans[0] == pytest.approx(corner, abs=1e-9)


def test_inertia_up_to_that_of_all_mass_at_the_corners() -> None:
    """m ((B/2)^2 + (H/2)^2) in the plane; in space along each axis for itself."""
    text = (
        "dimension = {}\n[[block]]\nmodel = 'rigid'\nwidth = 0.6\nthickness = 0.4\n"
        "height = 1.0\nmass = 100.0\ninertia = {}\n[time]\nend = 1.0\nstep = 1e-3\n"
    )
    most = 100 * (0.3**2 + 0.5**2)
    assert parse_scene(text.format(2, most)).blocks[0].shape.rotary_inertia == most
    with pytest.raises(SceneError, match="allowed at most 34, with all its 100 kg at its corners"):
        parse_scene(text.format(2, most * (1 + 1e-6)))
    x, y, z = 100 * 0.3**2, 100 * 0.2**2, 100 * 0.5**2
    parse_scene(text.format(3, [y + z, x + z, x + y]))
    with pytest.raises(SceneError, match=r"spread by 0\.3 m along x, allowed at most 0\.3 m"):
        parse_scene(text.format(3, [y + z, x * (1 + 1e-6) + z, x * (1 + 1e-6) + y]))
