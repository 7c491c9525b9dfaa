"""`rockslip scale`: what becomes of each quantity of a scene, and of the motion of its ground."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import load_scene, parse_scene
from solver.cli import main
from solver.excitation.motion import read_ground
from solver.scene import Scene
from solver.scene.scaling import Scale, scaled_tables

pytestmark = pytest.mark.serial

BLOCK = {"width": 0.25, "height": 1.0, "thickness": 0.75, "density": 2700.0, "young": 5e10,
         "poisson": 0.2, "velocity": [0.1, 0.0], "tilt_deg": 1.0}  # fmt: skip
FRICTION = {"static": 0.6, "dynamic": 0.5, "decay": 20.0, "cohesion": 10.0}
PLATFORM = {"kind": "oscillator", "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}


def scene(**tables: Any) -> Scene:
    base = {"block": [BLOCK], "time": {"end": 1.0, "step": 1e-3}}
    return parse_scene(base | tables)


@pytest.mark.parametrize(("keeps", "masses"), [("density", 3375.0), ("young", 225.0)])
def test_a_model_of_one_to_fifteen(keeps: Any, masses: float) -> None:
    """Lengths 1/15, times 1/3.873, masses 1/3375 or 1/225, moduli and pressures alike."""
    prototype = scene(foundation=PLATFORM, contact={"friction": FRICTION})
    model = parse_scene(scaled_tables(prototype, Scale(1 / 15, keeps), {}))
    old, new = prototype.blocks[0], model.blocks[0]
    stress = masses / 225
    time = math.sqrt(15)
    assert time == pytest.approx(3.873, abs=1e-4)
    assert old.height / new.height == pytest.approx(15)
    assert old.shape.mass / new.shape.mass == pytest.approx(masses)
    assert old.young / new.young == pytest.approx(stress)  # type: ignore[operator]
    assert old.velocity[0] / new.velocity[0] == pytest.approx(time)
    assert old.damping.stiffness / new.damping.stiffness == pytest.approx(time)  # type: ignore[union-attr]
    assert model.default_damping(new).stiffness == pytest.approx(new.damping.stiffness)  # type: ignore[union-attr]
    assert prototype.time.end / model.time.end == pytest.approx(time)
    damped = parse_scene(scaled_tables(scene(damping={"mass": 3.0}), Scale(1 / 15, keeps), {}))
    own = damped.blocks[0].damping
    assert own is not None
    assert own.mass == pytest.approx(3.0 * time)  # a rate, 1/s
    friction = model.friction_of(new)
    assert 20.0 / friction.decay == pytest.approx(1 / time)
    assert 10.0 / friction.cohesion == pytest.approx(stress)
    platforms = prototype.platform(), model.platform()
    assert platforms[0].mass / platforms[1].mass == pytest.approx(masses)
    assert platforms[0].period / platforms[1].period == pytest.approx(time)
    again = parse_scene(scaled_tables(model, Scale(15.0, keeps), {}))
    assert again.blocks[0].shape.mass == pytest.approx(old.shape.mass, rel=1e-12)
    assert (again.gravity, again.time.rho_inf) == (prototype.gravity, prototype.time.rho_inf)


def test_the_command_writes_a_scene(granite: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scale", str(granite), "--lengths", "15", "--set", "block.height=1.5"]) == 0
    model = parse_scene(capsys.readouterr().out)
    assert model.blocks[0].height == pytest.approx(0.1)
    assert model.title == "A block of granite, 1:15"
    assert main(["scale", str(granite), "--lengths", "0.1", "-o", "large.toml"]) == 0
    assert load_scene("large.toml").blocks[0].height == pytest.approx(10.0)
    assert load_scene("large.toml").title.endswith(", 10:1")


def test_samples_go_beside_the_scene(tmp_path: Path) -> None:
    """Their times shrink, their accelerations stay; in every direction."""
    still = {"kind": "synthetic", "seed": 3, "vertical": {"kind": "synthetic", "scale": 0.5}}
    base = 'title = "a"\n[[block]]\nmodel = "rigid"\nwidth = 0.3\nheight = 1.2\ndensity = 2700.0\n'
    motion = "[motion]\n" + "".join(f"{k} = {v!r}\n" for k, v in still.items() if k != "vertical")
    motion += '[motion.vertical]\nkind = "synthetic"\ncomponent = 3\nscale = 0.5\n'
    file, model = tmp_path / "scene.toml", tmp_path / "model.toml"
    file.write_text(base + motion + "[time]\nend = 20.0\n")
    assert main(["scale", str(file), "--lengths", "15", "-o", str(model)]) == 0
    grounds = [read_ground(load_scene(path)) for path in (file, model)]
    times = np.linspace(0, 20, 777)
    old, new = grounds[0].acceleration(times), grounds[1].acceleration(times / math.sqrt(15))
    assert np.abs(old).max() > 1.0
    assert np.abs(old - new).max() < 1e-9 * np.abs(old).max()
    assert {path.name for path in tmp_path.iterdir()} == {
        "scene.toml", "model.toml", "model_motion.csv", "model_vertical_motion.csv"
    }  # fmt: skip


def test_a_refused_scale_leaves_nothing_and_takes_nothing(
    granite: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["scale", str(granite), "--set", "motion.kind=synthetic", "-o", "model.toml"]
    assert main([*words, "--lengths", "1e7"]) == 2
    assert "at least 1e-06" in capsys.readouterr().err
    assert list(granite.parent.iterdir()) == [granite]
    samples = granite.parent / "model_motion.csv"
    samples.write_text("mine")
    assert main([*words, "--lengths", "15"]) == 2
    assert "-o: got model_motion.csv, which exists" in capsys.readouterr().err
    assert samples.read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--lengths", "0"], "--lengths: got 0, allowed a number > 0"),
        (["--lengths", "15", "-o", "granite.toml"], "-o: got granite.toml, which exists"),
        (
            ["--lengths", "15", "--set", "motion.kind=synthetic"],
            "motion: got a motion from samples",
        ),
        (["--lengths", "1e7"], "at least 1e-06"),
    ],
)
def test_what_is_refused(
    words: list[str], said: str, granite: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scale", str(granite), *words]) == 2
    assert said in capsys.readouterr().err


def test_links_and_forces_go_with_the_scale() -> None:
    """Stiffness 1/N², forces 1/N³, dashpots 1/N^2.5, pressures 1/N, times 1/sqrt(N)."""
    link = {"kind": "lashing", "between": ["block", "foundation"], "at": [0.0, 1.0]}
    link |= {"to": [1.0, 0.0], "stiffness": 2e6, "damping": 30.0, "preload": 5.0, "strength": 1e4}
    push = {"name": "push", "on": "block", "force": [100.0, 0.0], "table": [[0.5, 2.0], [1.0, 3.0]]}
    wind = {"name": "wind", "on": "block", "pressure": 50.0, "face": "left", "ramp": [0.0, 0.5]}
    given = scene(block=[BLOCK | {"model": "rigid"}], link=[link], force=[push, wind])
    model = parse_scene(scaled_tables(given, Scale(1 / 16), {}))
    (old,), (new,) = given.links, model.links
    assert old.to is not None and new.to is not None
    assert old.to[0] / new.to[0] == pytest.approx(16)
    assert old.stiffness / new.stiffness == pytest.approx(16**2)
    assert old.damping / new.damping == pytest.approx(16**2.5)
    assert (new.preload, new.strength) == pytest.approx((5.0 / 16**3, 1e4 / 16**3))
    pushed, blown = model.forces
    assert pushed.force == pytest.approx((100 / 16**3, 0.0))
    assert pushed.table == pytest.approx(np.array([[0.125, 2.0], [0.25, 3.0]]))
    assert blown.pressure == pytest.approx(50 / 16) and blown.ramp == pytest.approx((0.0, 0.125))
