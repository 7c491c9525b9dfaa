"""Reading scenes: what is accepted, what is refused and in which words, overrides, round trips."""

import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as some

from rockslip import BlockSpec, Scene, load_scene, parse_scene
from solver.errors import EnvironmentTrouble, NotConverged, SceneError, Statement, in_one_line
from solver.scene import TimeSpec, scene_to_toml
from solver.scene.motion import HalfSineSpec, SineSpec, SyntheticSpec, TableSpec

TEXT = """
title = "Free rocking"
[[block]]
width = 0.25
height = 1
thickness = 0.75
mass = 503.0
young = 5.0e10
poisson = 0.2
tilt_deg = 3.0
[time]
end = 3.0
step = 1.0e-3
"""
SECOND = """
[[block]]
{}width = 1
height = 1
density = 2000
young = 1e9
poisson = 0
"""
SINE = ("motion.kind=sine", "motion.amplitude_g=0.4", "motion.period=0.6")


def refusal(*overrides, text=TEXT, **options):
    with pytest.raises(SceneError) as caught:
        parse_scene(text, overrides=overrides, **options)
    message = str(caught.value)
    assert "\n" not in message
    assert caught.value.exit_code == 2
    return message


def test_defaults_are_those_of_the_interface():
    scene = parse_scene(TEXT)
    block = scene.blocks[0]
    assert (scene.dimension, scene.plane, scene.gravity, scene.gravity_tilt_deg) == (
        (2, "strain", 9.81, 0.0)
    )
    assert (block.name, block.on, block.model, block.cell) == (
        ("block", "foundation", "elastic", "quadrilateral")
    )
    assert (block.cells, block.degree, block.refinement, block.offset) == ((6, 16), 1, 1.0, 0.0)
    assert scene.foundation.kind == "rigid"
    contact = scene.contact
    assert (contact.points, contact.gamma, contact.theta, contact.friction) == (
        ("nodes", 100.0, 1, 0.6)
    )
    assert contact.velocity_solve is True
    assert scene.damping is None
    assert scene.motion is None
    assert (scene.time.rho_inf, scene.time.initial) == (0.8, "static")
    assert scene.time.smallest == 1e-3 / 1024
    assert (scene.output.every, scene.output.fields, scene.output.history_every) == (None, "vtk", 1)
    assert scene.output.snapshot_time(3.0) == 0.01
    assert scene.output.snapshot_time(60.0) == 0.2


def test_shape_angles_and_types():
    scene = parse_scene(TEXT, overrides=["gravity_tilt_deg=30", "gravity=10"])
    block = scene.blocks[0]
    assert isinstance(block.height, float)  # written as 1
    assert block.shape.mass == pytest.approx(503.0)
    assert block.shape.density == pytest.approx(503.0 / 0.1875)
    assert block.tilt == pytest.approx(0.05235987755982989)
    # An incline turns gravity towards +x.
    assert scene.gravity_vector == pytest.approx((5.0, -8.660254037844386))
    dense = parse_scene(TEXT.replace("mass = 503.0", "density = 2000"))
    assert dense.blocks[0].shape.mass == pytest.approx(375.0)


def sizes(low: float = 0.2, high: float = 2.0):
    return some.floats(low, high)


def table(**optional):
    """Some of these keys."""
    return some.fixed_dictionaries({}, optional=optional)


def pulse(*kinds: str, length: str):
    required = {"kind": some.sampled_from(kinds), "amplitude_g": sizes(-1, 1), length: sizes()}
    return some.fixed_dictionaries(required, optional={"start": sizes(0, 1)})


FRICTION = some.one_of(
    sizes(0, 2),
    some.fixed_dictionaries({"static": sizes(0.5, 2), "dynamic": sizes(0, 0.4)}),
    some.fixed_dictionaries({"static": sizes(), "cohesion": sizes(1, 1e4)}),
)
FILES = {"file": some.just(__file__), "scale": sizes(-3, 3)}
MOTION = some.one_of(
    pulse("half_sine", "one_sine", "rectangular", "ricker", length="duration"),
    pulse("sine", length="period"),
    pulse("ricker", length="frequency"),
    some.fixed_dictionaries(FILES | {"kind": some.sampled_from(["table", "record"])}),
    some.fixed_dictionaries({"kind": some.just("synthetic"), "seed": some.integers(0, 9)}),
)
SPRING = table(damping_ratio=sizes(0, 1)).flatmap(
    lambda rest: some.fixed_dictionaries(
        {"mass_ratio": sizes(), "period": sizes(), **{key: some.just(rest[key]) for key in rest}}
    )
)
STONE = {"young": sizes(1e9, 1e11), "poisson": sizes(0, 0.4), "density": sizes(1e3, 3e3)}


@some.composite
def scenes(draw):
    """Tables of a scene that is within all limits."""
    dimension = draw(some.sampled_from([2, 3]))
    thickness, count = draw(sizes()), draw(some.integers(1, 3))
    names = draw(some.lists(some.from_regex(r"\A[b-d][a-z0-9_-]{0,5}\Z"), min_size=count,
                            max_size=count, unique=True))  # fmt: skip
    block = some.fixed_dictionaries(
        {"width": sizes(), "height": sizes(), "thickness": some.just(thickness), **STONE},
        optional={
            "model": some.sampled_from(["elastic", "rigid"]),
            "offset": sizes(-0.1, 0.1),
            "velocity": some.tuples(*[sizes(-1, 1)] * dimension).map(list),
            "cells": some.tuples(*[some.integers(1, 5)] * dimension).map(list),
            "friction": FRICTION,
            "degree": some.sampled_from([1, 2]),
        },
    )
    carriers = ["foundation", *names[:-1]]
    tables = {
        "title": draw(some.text(max_size=20)),
        "dimension": dimension,
        "block": [
            draw(block) | {"name": name, "on": on} for name, on in zip(names, carriers, strict=True)
        ],
        "time": {"step": 1e-3, **draw(table(rho_inf=sizes(0, 1), damped_steps=some.integers(0, 9)))}
        | {"end": draw(sizes())},
        "contact": draw(table(friction=FRICTION, gamma=sizes(10, 1e3), theta=some.just(1))),
    }
    parts = {
        "foundation": SPRING.map(lambda spring: {"kind": "oscillator", **spring}),
        "motion": MOTION.flatmap(
            lambda motion: some.one_of(
                some.just(motion), MOTION.map(lambda other: motion | {"vertical": other})
            )
        ),
        "damping": table(mass=sizes(), stiffness=sizes(1e-6, 1e-3)),
        "output": table(every=sizes(), history_every=some.integers(1, 9)),
        "gravity": sizes(1, 20),
    }
    return tables | draw(table(**parts))


@given(scenes())
def test_every_scene_comes_back_from_its_text(tables):
    """Read from tables, written as TOML, read again, sent to another process: always equal."""
    scene = parse_scene(tables)
    text = scene_to_toml(scene)
    assert parse_scene(text) == scene
    assert scene_to_toml(parse_scene(text)) == text
    assert pickle.loads(pickle.dumps(scene)) == scene


VALUES = some.recursive(
    some.none() | some.booleans() | some.integers() | some.floats() | some.text(max_size=8),
    lambda inner: some.lists(inner, max_size=3) | some.dictionaries(some.text(), inner, max_size=3),
    max_leaves=6,
)


@given(scenes(), some.data(), VALUES)
def test_a_spoilt_scene_is_refused_in_one_line(tables, data, value):
    """Any value in any place: an equal scene comes back, or one line names the place."""
    place = tables
    while isinstance(place, dict | list) and place:
        keys = sorted(place) if isinstance(place, dict) else range(len(place))
        above, key = place, data.draw(some.sampled_from(keys))
        place = above[key]
    above[key] = value
    try:
        scene = parse_scene(tables)
    except SceneError as error:
        assert "\n" not in str(error) and str(error).startswith(in_one_line(error.where)[:56])
        assert error.exit_code == 2
    else:
        assert parse_scene(scene_to_toml(scene)) == scene


BASES = {
    "a block of parts": """
[[block]]
width = 0.25
height = 1.0
thickness = 0.75
density = 1000.0
model = "rigid"
parts = [{ from = [-0.1, 0.1], to = [0.1, 0.4], density = 9000.0 }]
[time]
end = 1.0
step = 1.0e-3
""",
    "a stack": """
[[block]]
name = "low"
width = 0.5
height = 1.0
density = 2000.0
model = "rigid"
[[block]]
name = "top"
on = "low"
width = 0.5
height = 1.0
density = 2000.0
model = "rigid"
[time]
end = 1.0
step = 1e-3
""",
    "a lintel": """
[[block]]
name = "left"
width = 0.5
height = 2.0
density = 2000.0
model = "rigid"
offset = -1.0
[[block]]
name = "right"
width = 0.5
height = 2.0
density = 2000.0
model = "rigid"
offset = 1.0
[[block]]
name = "lintel"
on = ["left", "right"]
width = 3.0
height = 0.4
density = 2000.0
model = "rigid"
[[block]]
name = "stone"
width = 0.2
height = 0.2
density = 2000.0
model = "rigid"
position = [0.0, 3.0]
[[pair]]
between = ["stone", "lintel"]
restitution = 0.5
[time]
end = 1.0
step = 1e-3
""",
    "linked": """
[[block]]
name = "lower"
width = 0.5
height = 0.5
mass = 100.0
model = "rigid"
[[block]]
name = "upper"
on = "lower"
width = 0.5
height = 0.5
mass = 100.0
model = "rigid"
[[link]]
name = "wire"
kind = "tether"
between = ["upper", "foundation"]
at = [0.25, 0.5]
to = [1.0, 0.0]
stiffness = 1e5
[[link]]
name = "lock"
kind = "twist-lock"
between = ["lower", "upper"]
at = [0.25, 0.5]
stiffness = 1e7
[[force]]
name = "push"
on = "upper"
force = [100.0, 0.0]
[time]
end = 1.0
step = 1e-3
""",
    "a container": """
[[block]]
name = "box"
model = "rigid"
container = "20ft"
load = "empty"
[time]
end = 1.0
step = 1e-3
""",
}
"""The scenes of headings of the table that end with these words; else that of a meshed block."""
SHORT = {
    "PLATE": "kind='elastic', width=3.0, height=0.2, density=2500.0, young=2e11, poisson=0.3",
    "FRAME": "kind='frame', storey=1.5, density=7850.0, young=2e11, poisson=0.3",
    "DECK": "width=2.0, height=0.1",
}
TABLE = Path(__file__).resolve().with_name("refusals.txt")


def test_refusals():
    """The table of overrides, behind ">", and the lines that refuse them: where, got, allowed.

    To write it anew: `./in-env env ROCKSLIP_WRITE=1 python3 -m pytest tests/unit/test_scene.py`.
    """
    found, base = [], TEXT
    for line in TABLE.read_text().splitlines():
        if line.startswith("# "):
            base = next((text for name, text in BASES.items() if line.endswith(name)), TEXT)
            found.append(line)
        elif line.startswith("> "):
            words = line[2:]
            for short, long in SHORT.items():
                words = words.replace(short, long)
            found += [line, refusal(*words.split("  "), text=base)]
    if os.environ.get("ROCKSLIP_WRITE"):
        TABLE.write_text("\n".join(found) + "\n")
    assert found == TABLE.read_text().splitlines()


def test_missing_keys_and_tables():
    line = refusal(text=TEXT.replace("width = 0.25", ""))
    assert line == "block.width is required (width > 0)"
    assert refusal(text=TEXT.replace("mass = 503.0", "")).startswith(
        "block.mass is required (exactly one of mass and"
    )
    empty = BASES["a container"].replace('load = "empty"', "")
    assert refusal(text=empty) == (
        'box.load is required (of a container, "empty" or "full"; or its mass)'
    )
    assert refusal(text=TEXT.partition("[time]")[0]) == "time is required (a table)"
    assert refusal(text="[time]\nend = 1\nstep = 1").startswith("block is required (an ar")
    assert refusal(text=TEXT.replace("[[block]]", "[block]")).startswith("block: got a table")
    assert refusal(text="block = []\n[time]\nend = 1\nstep = 1").startswith("block: got 0 blocks")


def test_blocks_are_addressed_by_name():
    scene = parse_scene(TEXT.replace("[[block]]", '[[block]]\nname = "tower"'))
    assert scene.blocks[0].name == "tower"
    text = scene_to_toml(scene)
    assert parse_scene(text, overrides=["tower.height=1.2"]).blocks[0].height == 1.2
    assert "did you mean 'width'?" in refusal("tower.widht=1", text=text)
    assert refusal("tower.height=0", text=text).startswith("tower.height: got 0")
    assert "did you mean 'tower'?" in refusal("towre.height=2", text=text)


@pytest.mark.parametrize(
    "name", ["time", "energy", "foundation", "", "a b", "9", "a.b", "a\\nb", 101 * "a"]
)
def test_refused_names(name):
    assert ".name: got" in refusal(text=TEXT.replace("[[block]]", f'[[block]]\nname = "{name}"'))


def test_the_longest_name():
    """With what is added to it, it is the name of a file."""
    scene = parse_scene(TEXT.replace("[[block]]", f'[[block]]\nname = "{100 * "a"}"'))
    assert len(scene.blocks[0].name) == 100


def test_number_of_blocks():
    assert refusal(text=TEXT + SECOND.format("")).startswith(
        'two blocks are named "block"; give each'
    )
    scene = parse_scene(TEXT + SECOND.format('name = "upper"\nthickness = 0.75\noffset = 2.0\n'))
    assert [block.name for block in scene.blocks] == ["block", "upper"]


def test_override_values():
    def changed(*overrides):
        return parse_scene(TEXT, overrides=overrides)

    assert changed("time.step=1e-4").time.step == 1e-4
    assert changed("block.cell = triangle").blocks[0].cell == "triangle"
    assert changed('block.cell="triangle"').blocks[0].cell == "triangle"
    assert changed("block.cells=[2, 3]").blocks[0].cells == (2, 3)
    assert changed("damping.stiffness=1e-4").damping.stiffness == 1e-4
    assert changed("title=a = b").title == "a = b"
    assert changed("title=1\nplane='stress'").plane == "strain"
    assert changed("time.step=1e-4", "time.step=2e-4").time.step == 2e-4
    assert changed(*SINE).motion == SineSpec(amplitude_g=0.4, period=0.6)


def test_content_is_left_alone():
    tables = parse_scene(TEXT).to_dict()
    before = parse_scene(tables).to_dict()
    parse_scene(tables, overrides=["block.height=7", "damping.mass=1"])
    assert tables == before


def test_messages_are_short_and_printable():
    """Whatever a key or a value holds."""
    wild = "\x1b[31m" + "\x07\x00\u202e" * 5000
    for text in (
        refusal(f'block.on="{"x" * 5000}"'),
        refusal(f"block.{'y' * 5000}=1"),
        refusal(f"{'z' * 5000}.width=1"),
        str(SceneError("block.on", wild, "foundation")),
        str(SceneError(wild, "1", "foundation")),
        str(Statement(wild, "is required")),
    ):
        assert len(text) <= 200
        assert text.isprintable()
    assert "\\x1b[31m\\x07\\x00\\u202e" in str(SceneError("a", wild, "b"))
    path = "/a/folder/" + "n" * 150
    assert path in str(SceneError(path, "x" * 100, "y" * 60))


@pytest.mark.parametrize("number", [".1", "-.5e3", "7.", "+1.e-4"])
def test_numbers_without_a_digit(number):
    """In a file they are explained, as TOML has none; on the command line they are taken."""
    text = TEXT.replace("[time]", f"[damping]\nmass = {number}  # .3\n[time]", 1)
    line = 1 + text[: text.index("mass = " + number)].count("\n")
    assert refusal(text=text) == (
        f"scene: got {number} in line {line}, allowed digits on both sides of the point, as in 0.1"
    )
    moved = parse_scene(TEXT, overrides=[f"block.offset={number}"])
    assert moved.blocks[0].offset == float(number)


def test_huge_and_deep_values():
    assert refusal("block.mass=1" + "0" * 400).startswith("block.mass: got 1000")
    assert refusal("block.mass=1" + "0" * 5000).startswith("block.mass: got")
    assert len(refusal("block.cell=" + "x" * 5000)) < 200
    assert refusal(text="a = " + "[" * 9000 + "]" * 9000).startswith("scene: got unreadable TOML")


@pytest.mark.parametrize("file", ["nul\\u0000.csv", "x" * 3000])
def test_impossible_file_names(file):
    text = TEXT + f'[motion]\nkind = "table"\nfile = "{file}"\n'
    assert refusal(text=text).startswith("motion.file: got ")


def test_files(tmp_path):
    file = tmp_path / "scene.toml"

    def line():
        with pytest.raises(SceneError) as caught:
            load_scene(file)
        assert "\n" not in str(caught.value)
        return str(caught.value)

    assert line() == f"{file} cannot be read as a scene: no such file or directory"
    file.write_text("")
    assert line().startswith("scene.toml: got an empty scene")
    file.write_text("# nothing\n")
    assert line().startswith("scene.toml: got an empty scene")
    file.write_text("title = 1\n\n[[block]\n")
    assert "scene.toml: got unreadable TOML" in line()
    assert "line 3" in line()
    file.write_text("a = 1\na = 2\n")
    assert "line 2" in line()
    file.write_bytes(b"\xff\xfe\x00")
    assert "not utf-8" in line()
    file.write_bytes(b"\xef\xbb\xbf" + TEXT.encode())
    assert load_scene(file, ["block.height=2"]).blocks[0].height == 2.0


def test_table_of_motion_is_looked_for_beside_the_scene(tmp_path):
    (tmp_path / "scene.toml").write_text(TEXT + '[motion]\nkind = "table"\nfile = "a/m.csv"\n')
    with pytest.raises(SceneError, match=r"^motion.file: got .*m.csv.*, allowed a file that exis"):
        load_scene(tmp_path / "scene.toml")
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "m.csv").write_text("0 0\n1 0\n")
    scene = load_scene(tmp_path / "scene.toml")
    assert scene.motion == TableSpec(file=tmp_path / "a" / "m.csv")
    assert parse_scene(scene_to_toml(scene), folder="/elsewhere") == scene


def test_scenes_built_in_code_are_checked_too():
    block = BlockSpec(width=1, height=2, density=2000, young=1e9, poisson=0.2, cells=(2, 4))
    scene = Scene(blocks=(block,), time=TimeSpec(end=1, step=0.5))
    assert parse_scene(scene.to_dict()) == scene
    with pytest.raises(SceneError, match=r"^poisson: got 0\.5, allowed 0 <= poisson < 0\.5"):
        BlockSpec(width=1, height=2, density=2000, young=1e9, poisson=0.5)
    with pytest.raises(SceneError, match=r"^block: got 0 blocks"):
        Scene(blocks=(), time=TimeSpec(end=1, step=0.5))


def test_errors_survive_pickling_and_have_exit_codes():
    for override in ("block.widht=1", "block.poisson=1"):
        with pytest.raises(SceneError) as caught:
            parse_scene(TEXT, overrides=[override])
        assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    assert (SceneError.exit_code, NotConverged.exit_code, EnvironmentTrouble.exit_code) == (2, 3, 4)


@pytest.mark.serial
def test_light_parts_import_nothing_heavy():
    modules = "solver.scene, solver.excitation.motion, solver.reference.housner, geometry.block"
    heavy = "{'dolfinx', 'gmsh', 'mpi4py', 'petsc4py', 'scipy', 'ufl'}"
    code = f"import sys, {modules}; print(sorted({heavy} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
    code = "import sys, solver.scene; print('numpy' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"


def test_a_motion_times_a_factor_is_so_in_all_directions() -> None:
    pulse = {"kind": "half_sine", "amplitude_g": 0.2, "duration": 0.3}
    motion = pulse | {"vertical": pulse | {"amplitude_g": 0.1}, "second": {"kind": "synthetic"}}
    scene = parse_scene(
        {
            "dimension": 3,
            "block": [{"width": 0.3, "height": 1.0, "mass": 100.0, "model": "rigid"}],
            "motion": motion,
            "time": {"end": 1.0},
        }
    )
    assert scene.motion is not None
    twice = scene.motion.times(2.0)
    assert isinstance(twice, HalfSineSpec) and isinstance(twice.vertical, HalfSineSpec)
    assert (twice.amplitude_g, twice.vertical.amplitude_g) == (0.4, 0.2)
    assert isinstance(twice.second, SyntheticSpec) and twice.second.scale == 2.0
