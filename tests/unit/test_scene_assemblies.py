"""Scenes with several supports, places in the air and laws of pairs; refused ones are in
`refusals.txt`."""

from __future__ import annotations

import math
import pickle
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from rockslip import Scene, load_scene, parse_scene
from solver.errors import SceneError
from solver.fields.ground import platform_corners
from solver.reference.answer import reference_name
from solver.reference.initiation import has_expected_mode
from solver.run.describe import describe
from solver.scene import FrictionSpec, scene_to_toml
from solver.scene.scaling import Scale, scaled_tables
from solver.study.scenes import refuse_others, with_model

DEMOS = Path(__file__).parents[2] / "demos"

BLOCK = {"width": 0.5, "height": 1.0, "density": 2000.0, "model": "rigid"}
POSTS = [BLOCK | {"name": "left", "offset": -1.0}, BLOCK | {"name": "right", "offset": 1.0}]
LINTEL = BLOCK | {"name": "lintel", "on": ["left", "right"], "width": 3.0}
ELASTIC = {"model": "elastic", "young": 1e9, "poisson": 0.2}
PLATE = {"kind": "elastic", "width": 9.0, "height": 0.2, "density": 2500.0, "young": 2e11,
         "poisson": 0.3}  # fmt: skip

numbers = some.floats(-0.5, 0.5)
positive = some.floats(0.2, 2.0)


def scene(*blocks: dict[str, Any], **tables: Any) -> Scene:
    return parse_scene({"block": list(blocks), "time": {"end": 1.0, "step": 1e-3}} | tables)


def centre(found: Scene, name: str) -> np.ndarray:
    """Place of the centre of a block at the start."""
    block = next(block for block in found.blocks if block.name == name)
    middle = np.zeros((1, found.dimension))
    middle[0, -1] = block.height / 2
    return found.poses()[name](middle)[0]


# -- several supports


@given(left=numbers, right=numbers, offset=some.floats(-0.2, 0.2), tilt=some.floats(-20, 20))
def test_a_block_stands_over_the_middle_of_its_supports(
    left: float, right: float, offset: float, tilt: float
) -> None:
    """Its lowest corner touches their level, and a tilt turns it about that corner."""
    posts = POSTS[0] | {"offset": left - 1}, POSTS[1] | {"offset": right + 1}
    found = scene(*posts, LINTEL | {"offset": offset, "tilt_deg": tilt})
    pose = found.poses()["lintel"]
    corners = pose(np.array(found.blocks[2].shape.corners()))
    assert corners[:, 1].min() == pytest.approx(1.0, abs=1e-15)
    foot = np.array([math.copysign(1.5, tilt) if tilt else 0.0, 0.0])
    place = [(left + right) / 2 + offset + foot[0], 1.0]
    np.testing.assert_allclose(pose(foot[None])[0], place, atol=1e-15)


def test_four_supports_in_space() -> None:
    posts = [
        BLOCK | {"name": f"p{i}{j}", "offset": float(i), "offset_second": float(j)}
        for i in (0, 1) for j in (0, 2)
    ]  # fmt: skip
    names = [post["name"] for post in posts]
    slab = LINTEL | {"on": names, "offset": 0.1, "offset_second": -0.2, "thickness": 3.0}
    found = scene(*posts, slab, dimension=3)
    np.testing.assert_allclose(centre(found, "lintel"), [0.6, 0.8, 1.5], atol=1e-15)
    short = slab | {"thickness": 1.2}
    with pytest.raises(SceneError, match=r"^lintel\.on names p00, over which its bottom does not"):
        scene(*posts, short | {"offset_second": 0.3}, dimension=3)


def test_supports_that_lean_together_are_level() -> None:
    """Two posts on a slab that is tilted, and the lintel with them."""
    slab = BLOCK | {"name": "slab", "width": 4.0, "height": 0.2, "tilt_deg": 5.0}
    posts = [post | {"on": "slab"} for post in POSTS]
    found = scene(slab, *posts, LINTEL)
    c, s = math.cos(math.radians(5)), math.sin(math.radians(5))
    along, up = np.array([c, -s]), np.array([s, c])
    middle = np.array([2.0, 0.0]) - 2.0 * along + (0.2 + 1.0 + 0.5) * up
    np.testing.assert_allclose(centre(found, "lintel"), middle, atol=1e-15)


@given(step=some.floats(1e-8, 0.1), turned=some.booleans())
def test_tops_that_are_not_level_are_refused_with_both_levels(step: float, turned: bool) -> None:
    heights = (1.0 + step, 1.0) if turned else (1.0, 1.0 + step)
    posts = [post | {"height": height} for post, height in zip(POSTS, heights, strict=True)]
    with pytest.raises(SceneError) as caught:
        scene(*posts, LINTEL)
    left, right = (f"{height:.10g} m" for height in heights)
    assert str(caught.value) == (
        f"lintel.on needs level tops: that of left is at {left}, that of right at {right}"
    )
    level = [POSTS[0], POSTS[1] | {"height": 1.0 + 1e-10}]
    assert scene(*level, LINTEL)  # round-off


def test_one_name_in_an_array_is_as_the_name() -> None:
    upper = BLOCK | {"name": "upper", "offset": 0.1}
    one, other = (scene(*POSTS, upper | {"on": on}) for on in ("left", ["left"]))
    np.testing.assert_array_equal(centre(one, "upper"), centre(other, "upper"))
    with pytest.raises(SceneError, match="so that left is below its bottom"):
        scene(*POSTS, upper | {"on": ["left"], "offset": 0.6})
    assert scene(BLOCK | {"on": ["foundation"]}).blocks[0].carrier == "foundation"


def test_carriers_and_the_weight_on_them() -> None:
    """In equal shares."""
    stone = BLOCK | {"name": "stone", "on": "lintel"}
    found = scene(stone, LINTEL, *POSTS)
    by_name = {block.name: block for block in found.blocks}
    lintel, masses = by_name["lintel"], found.stacked_masses
    assert (lintel.carriers, lintel.carrier) == (("left", "right"), "left")
    assert found.carrier_of(lintel) is by_name["left"]
    assert [block.name for block in found.order] == ["left", "right", "lintel", "stone"]
    assert masses["lintel"] == pytest.approx(6000.0 + 1000.0)
    assert masses["left"] == masses["right"] == pytest.approx(1000.0 + 3500.0)
    neighbours = {frozenset((a.name, b.name)) for a, b in found.non_adjacent()}
    assert neighbours == {frozenset(pair) for pair in (
        ("left", "right"), ("stone", "left"), ("stone", "right"))}  # fmt: skip


@given(floors=some.integers(1, 8), bricks=some.integers(2, 5))
def test_all_weight_of_a_wall_arrives_at_the_ground(floors: int, bricks: int) -> None:
    """A heap of courses, each a brick shorter than the one below, that touch one another."""
    blocks: list[dict[str, Any]] = []
    for floor in range(min(floors, bricks)):
        for k in range(bricks - floor):
            below = [f"b{floor - 1}-{k}", f"b{floor - 1}-{k + 1}"]
            place = {"on": below} if floor else {"offset": 0.5 * k}
            blocks.append(BLOCK | {"name": f"b{floor}-{k}"} | place)
    found = scene(*blocks)
    ground = [block.name for block in found.blocks if found.carrier_of(block) is None]
    masses = found.stacked_masses
    assert sum(masses[name] for name in ground) == pytest.approx(found.carried_mass, rel=1e-14)
    for block in found.blocks:
        floor, k = map(int, block.name[1:].split("-"))
        place = [0.5 * (k + floor / 2), floor + 0.5]
        np.testing.assert_allclose(centre(found, block.name), place, atol=1e-14)


# -- places in the air


@given(x=numbers, y=some.floats(0.6, 9.0), tilt=some.floats(-89, 89))
def test_a_place_is_that_of_the_centre_whatever_the_tilt(x: float, y: float, tilt: float) -> None:
    found = scene(BLOCK | {"position": [x, y], "tilt_deg": tilt})
    pose = found.poses()["block"]
    np.testing.assert_allclose(centre(found, "block"), [x, y], atol=1e-15)
    assert math.degrees(math.atan2(*pose.rotation[0][::-1])) == pytest.approx(tilt)
    upright = found.poses(upright=True)["block"](np.zeros((1, 2)))[0]
    np.testing.assert_allclose(upright, [x, y - 0.5], atol=1e-15)


def test_a_place_in_space_and_what_stands_on_it() -> None:
    low = BLOCK | {"name": "low", "position": [1.0, -2.0, 3.0], "tilt_deg": 10.0,
                   "tilt_direction_deg": 90.0}  # fmt: skip
    found = scene(low, BLOCK | {"name": "top", "on": "low", "offset": 0.1}, dimension=3)
    c, s = math.cos(math.radians(10)), math.sin(math.radians(10))
    np.testing.assert_allclose(centre(found, "low"), [1, -2, 3], atol=1e-15)
    np.testing.assert_allclose(centre(found, "top"), [1.1, -2 + s, 3 + c], atol=1e-15)
    block = found.blocks[0]
    assert (block.on, block.offset, block.offset_second) == (None, None, None)
    assert (block.carriers, found.carrier_of(block)) == (("foundation",), None)


@given(y=some.floats(0.3, 0.8), tilt=some.floats(-89, 89), space=some.booleans())
def test_no_block_reaches_into_the_ground(y: float, tilt: float, space: bool) -> None:
    a = math.radians(abs(tilt))
    depth = (0.5 * math.sin(a) + math.cos(a)) / 2 - y
    block = BLOCK | {"position": [0.0, *[0.0] * space, y], "tilt_deg": tilt}
    if depth > 1e-6:
        words = rf"^block block reaches into the foundation by {depth:.4g} m at the start"
        with pytest.raises(SceneError, match=words):
            scene(block, dimension=2 + space)
    elif depth < -1e-6:
        assert scene(block, dimension=2 + space)


def test_an_upper_block_may_not_reach_into_the_ground_either() -> None:
    low = BLOCK | {"name": "low", "tilt_deg": 80.0}
    high = BLOCK | {"name": "high", "on": "low", "height": 0.6, "width": 1.0, "offset": 0.7}
    with pytest.raises(SceneError, match=r"^block high reaches into the foundation by .*offset"):
        scene(low, high)


def test_a_block_may_lie_on_another_without_standing_on_it() -> None:
    """What merely touches does not overlap."""
    found = scene(*POSTS, LINTEL | {"on": "left", "offset": 1.0},
                  BLOCK | {"name": "stone", "position": [0.0, 2.5]})  # fmt: skip
    np.testing.assert_allclose(centre(found, "lintel"), [0, 1.5], atol=1e-15)


def test_a_block_in_the_air_has_no_rigid_answer() -> None:
    found = scene(BLOCK | {"position": [0.0, 2.0]})
    assert not has_expected_mode(found)
    with pytest.raises(SceneError, match=r"^block\.position: got \[0\.0, 2\.0\], allowed offset"):
        reference_name(found)


def test_the_platform_that_is_drawn_reaches_below_it() -> None:
    oscillator = {"kind": "oscillator", "mass_ratio": 1.0, "period": 0.5}
    found = scene(BLOCK | {"position": [-2.0, 4.0]}, foundation=oscillator)
    assert platform_corners(found)[:, 0].min() == -4.5


# -- laws of pairs


@some.composite
def assemblies(draw: some.DrawFn) -> Scene:
    """Two posts, a lintel and a stone, with laws of their own and of pairs."""
    law = some.one_of(
        positive,
        some.fixed_dictionaries({"static": some.floats(0.5, 1), "dynamic": some.floats(0, 0.5)}),
    )
    own = some.fixed_dictionaries(
        {}, optional={"friction": law, "restitution": some.floats(0.1, 1)}
    )
    stone = BLOCK | {"name": "stone", "position": [0.0, 3.0]}
    blocks = [block | draw(own) for block in (*POSTS, LINTEL, stone)]
    names = ["foundation", *(block["name"] for block in blocks)]
    pairs = draw(some.lists(some.sampled_from(list(combinations(names, 2))), unique=True))
    tables = []
    for pair in pairs:
        given_keys = draw(own)
        if given_keys:
            between = list(pair) if draw(some.booleans()) else [pair[1], pair[0]]
            tables.append({"between": between} | given_keys)
    return scene(*draw(some.permutations(blocks)), pair=tables)


@given(assemblies())
def test_the_law_of_any_two_bodies(found: Scene) -> None:
    """The pair's own; else the upper block's; else the smaller of the neighbours'."""
    own = {block.name: (FrictionSpec.of(0.6 if block.friction is None else block.friction),
                        block.restitution or 0.0) for block in found.blocks}  # fmt: skip
    for first, second in combinations(["foundation", *own], 2):
        law = found.law_between(first, second)
        assert law == found.law_between(second, first)
        if first == "foundation":
            expected = own[second]
        elif "lintel" in (first, second) and "stone" not in (first, second):
            expected = own["lintel"]
        else:
            frictions = [own[name][0] for name in (first, second)]
            smaller = frictions[frictions[1].static < frictions[0].static]
            expected = smaller, min(own[first][1], own[second][1])
        both = {first, second}
        table = next((pair for pair in found.pairs if set(pair.between) == both), None)
        if table is not None and table.friction is not None:
            expected = FrictionSpec.of(table.friction), expected[1]
        if table is not None and table.restitution is not None:
            expected = expected[0], table.restitution
        assert law == expected
    for block in found.blocks:
        law = found.law_between(block.name, block.carrier)
        assert law == (found.friction_of(block), found.restitution_of(block))


@given(assemblies())
def test_an_assembly_comes_back_from_its_text_and_at_another_scale(found: Scene) -> None:
    assert parse_scene(scene_to_toml(found)) == found
    assert pickle.loads(pickle.dumps(found)) == found
    assert describe(found)
    model = parse_scene(scaled_tables(found, Scale(0.1), {}))
    assert model.pairs == found.pairs
    for name, pose in found.poses().items():
        np.testing.assert_allclose(model.poses()[name].place, 0.1 * pose.place, atol=1e-15)


@pytest.mark.parametrize(
    "names", [("left", "left"), ("foundation", "foundation"), ("left", "lost"), ("lost", "gone"),
              ("foundation", "lost")])  # fmt: skip
def test_the_law_of_what_are_not_two_bodies(names: tuple[str, str]) -> None:
    with pytest.raises(ValueError, match="are not two bodies of the scene"):
        scene(*POSTS).law_between(*names)


def test_pairs_are_set_by_both_names() -> None:
    """In any order; what is not there is added."""
    blocks, time = [*POSTS, LINTEL], {"end": 1.0, "step": 1e-3}
    content = {"block": blocks, "time": time,
               "pair": [{"between": ["left", "lintel"], "friction": 0.5}]}  # fmt: skip
    words = ["pair.lintel.left.restitution=0.25", "pair.left.right.friction.static=0.5"]
    found = parse_scene(content, overrides=[*words, "pair.left.right.friction.dynamic=0.25"])
    known = [(pair.between, pair.friction, pair.restitution) for pair in found.pairs]
    law = FrictionSpec(static=0.5, dynamic=0.25)
    assert known == [(("left", "lintel"), 0.5, 0.25), (("left", "right"), law, None)]
    assert content["pair"] == [{"between": ["left", "lintel"], "friction": 0.5}]
    with pytest.raises(SceneError, match=r"^pair: got 3, allowed an array of tables"):
        parse_scene(content | {"pair": 3}, overrides=words)


def test_several_supports_and_places_are_set_too() -> None:
    content = {"block": [*POSTS, LINTEL], "time": {"end": 1.0, "step": 1e-3}}
    found = parse_scene(content, overrides=["lintel.on=['right', 'left']"])
    assert found.blocks[2].carrier == "right"
    found = parse_scene({**content, "block": [BLOCK]}, overrides=["block.position=[0.5, 4]"])
    assert found.blocks[0].position == (0.5, 4.0)


# -- scenes with a mesh, and what is said


def test_meshed_bodies_meet_as_rigid_ones_but_for_restitution() -> None:
    """Pairs, several carriers and places in the air; a mesh rebounds by itself."""
    low, top = BLOCK | ELASTIC | {"name": "low"}, BLOCK | {"name": "top", "on": "low"}
    side = BLOCK | {"name": "side", "offset": 2.0}
    pairs = [
        {"between": names, "friction": friction}
        for names, friction in ((["top", "low"], 0.3), (["top", "side"], 0.2))
    ]
    found = scene(low, top, side, pair=pairs)
    frictions = [found.friction_of(block).static for block in found.blocks]
    assert frictions == [0.6, 0.3, 0.6]
    assert found.law_between("side", "top")[0].static == 0.2
    air = {key: value for key, value in top.items() if key != "on"} | {"position": [0.0, 3.5]}
    assert scene(low, air, side).blocks[1].position == (0.0, 3.5)
    restitution = [pairs[0] | {"restitution": 0.5}]
    remedy = r'model = "rigid" for every block, no meshed foundation'
    with pytest.raises(SceneError, match=rf"^pair\.top\.low\.restitution applies to.*{remedy}"):
        scene(low, top, side, pair=restitution)


def test_restitution_of_a_pair_is_for_the_engine_that_has_it() -> None:
    """On a plate that is held, as that of a block."""
    pair = {"between": ["block", "foundation"], "restitution": 0.5}
    assert not scene(BLOCK, foundation=PLATE).is_rigid
    assert scene(BLOCK, foundation=PLATE, pair=[pair]).is_rigid
    with pytest.raises(SceneError, match=r"^pair\.block\.foundation\.restitution applies to"):
        scene(BLOCK, foundation=PLATE, pair=[pair | {"restitution": 0.0}])


def test_studies_of_elastic_blocks_leave_restitution_out() -> None:
    pairs = [{"between": ["top", "low"], "friction": 0.3, "restitution": 0.5},
             {"between": ["low", "foundation"], "restitution": 0.5}]  # fmt: skip
    low, top = BLOCK | {"name": "low"}, BLOCK | {"name": "top", "on": "low", "restitution": 0.5}
    tables = {"block": [low, top], "pair": pairs, "time": {"end": 1.0}}
    made = with_model(tables, "elastic")
    assert made["pair"] == [{"between": ["top", "low"], "friction": 0.3}]
    assert with_model(tables, "rigid") == tables == with_model(tables, None)
    single = scene(low, pair=[pairs[1]])
    with pytest.raises(SceneError, match=r"^pair: got pair\.low\.foundation, allowed keys of low"):
        refuse_others(single)


def test_check_says_where_blocks_are_and_which_pairs_have_a_law() -> None:
    stone = BLOCK | {"name": "stone", "position": [0.5, 3.0]}
    pairs = [{"between": ["left", "foundation"], "restitution": 0.5},
             {"between": ["lintel", "stone"], "friction": 0.25}]  # fmt: skip
    text = describe(scene(*POSTS, LINTEL, stone, pair=pairs))
    lines = {" ".join(line.split()) for line in text.splitlines()}
    assert lines >= {
        "lintel 3 x 1 x 1 m, on left and right",
        "stone 0.5 x 1 x 1 m, with its centre at (0.5, 3) m",
        "pair left and foundation friction 0.6, restitution 0.5",
        "pair lintel and stone friction 0.25, restitution 0",
        "restitution 0.5, instead of 0.7000 (Housner 1963)",
    }


@pytest.mark.parametrize(("demo", "count"), [("lintel", 3), ("wall", 17)])
def test_demos_are_scenes(demo: str, count: int) -> None:
    found = load_scene(DEMOS / demo / "scene.toml")
    assert len(found.blocks) == count
    assert max(len(block.carriers) for block in found.blocks) == 2
    levels = {round(centre(found, block.name)[1], 9) for block in found.blocks}
    assert len(levels) == (5 if demo == "wall" else 2)
