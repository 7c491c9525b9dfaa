"""`rockslip study error-runtime` on small scenes, whose orders and references are known."""

import json

import pytest

from benchmarks.error_runtime.study import study
from rockslip import parse_scene
from solver import cli
from solver.scene import scene_to_toml

pytestmark = pytest.mark.serial

ROCKING = """
title = "rocking"
[[block]]
width = 0.25
height = 1.0
mass = 503.0
model = "rigid"
tilt_deg = 3.0
[contact]
friction = 0.7
[time]
end = 1.0
step = 4.0e-3
"""

SLIDING = {
    "block": [
        {"width": 1.0, "height": 0.5, "mass": 1e3, "young": 5e10, "poisson": 0.2, "cells": [2, 1]}
    ],
    "contact": {"friction": 0.3},
    "motion": {"kind": "half_sine", "amplitude_g": 0.5, "duration": 0.2},
    "damping": {"stiffness": 0.0},
    "time": {"end": 0.4, "step": 2e-3},
}

RIGID = {"width": 1.0, "height": 0.5, "mass": 1e3, "model": "rigid"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    there = tmp_path_factory.mktemp("study")
    scene = there / "rocking.toml"
    scene.write_text(ROCKING)
    words = ["study", "error-runtime", str(scene), "-o", str(there / "out"), "--rungs", "5"]
    assert cli.main([*words, "--repeat", "2", "-q"]) == 0
    assert cli.main(words) == 2  # nothing is written over
    return there / "out"


def test_rigid_block_converges_in_second_order(folder):
    """To Housner's answer: impacts, peaks, and the angle up to 1 s with three impacts in it."""
    found = json.loads((folder / "errors.json").read_text(encoding="utf-8"))
    assert {r["source"] for r in found["references"].values()} == {"rigid block, Housner 1963"}
    assert found["references"]["block.first_impact_s"]["value"] == pytest.approx(
        0.1916283, abs=1e-7
    )
    assert found["references"]["block.third_impact_s"]["value"] == pytest.approx(
        0.8323062, abs=1e-7
    )
    for measure in ("block.third_impact_s", "block.angle_rad", "block.angle_before_impact_rad"):
        assert found["slopes"][measure]["step"]["order"] == pytest.approx(2.0, abs=0.1), measure
    runs = found["runs"]
    assert [run["size"] for run in runs] == [16e-3, 8e-3, 4e-3, 2e-3, 1e-3]
    assert runs[-1]["block.third_impact_s"] == pytest.approx(0.8323062, rel=2e-6)
    error = runs[-1]["block.third_impact_s"] / 0.8323062 - 1
    assert runs[-1]["error.block.third_impact_s"] == pytest.approx(abs(error), abs=1e-7)
    assert all(run["loop_least_s"] <= run["loop_s"] <= run["loop_most_s"] for run in runs)
    assert all(0 < run["processor_share"] < 1.5 for run in runs)
    # which step is the fastest is up to the machine: all are good enough
    assert found["sentences"]["block.first_impact_s"].startswith(
        "For 1 % error of the time of the first impact use step 0.0"
    )


def test_files_of_a_study(folder):
    names = {file.name for file in folder.iterdir()}
    assert names == {"scene.toml", "errors.csv", "errors.txt", "errors.json", "errors.png"}
    said = (folder / "errors.txt").read_text(encoding="utf-8")
    assert "the median of 2 runs" in said
    assert "time of the third impact (block.third_impact_s): 0.8323062" in said


def test_elastic_slider_is_measured_against_the_rigid_one():
    findings = study(
        parse_scene(SLIDING), names=["model"], wanted=["residual_slip"], rungs=4, repeat=1
    )
    reference = findings.references["block.residual_slip_m"]
    assert reference.source == "rigid block, sliding"
    errors = [findings.error(trial, "block.residual_slip_m") for trial in findings.trials]
    assert [trial.family.name for trial in findings.trials] == 4 * ["step"] + 2 * ["rigid blocks"]
    assert max(errors[:2]) < 0.01 and max(errors[2:4]) < 2e-3 and max(errors[4:]) < 0.01


def test_elastic_rocking_has_a_rigid_reference_for_the_first_impact_alone():
    elastic = {"width": 0.25, "height": 1.0, "mass": 503.0, "tilt_deg": 3.0, "cells": [2, 3]}
    elastic |= {"young": 5e10, "poisson": 0.2}
    scene = {"block": [elastic], "contact": {"friction": 0.7}, "time": {"end": 0.5, "step": 4e-3}}
    scene["damping"] = {"stiffness": 0.0}
    findings = study(parse_scene(scene), names=["mesh"], rungs=3, repeat=1)
    sources = {measure: reference.source for measure, reference in findings.references.items()}
    assert sources["block.first_impact_s"] == "rigid block, Housner 1963"
    for measure in ("block.first_peak_rad", "block.angle_rad"):
        assert sources[measure].startswith("limit of its own steps"), measure
        assert "meshes" in sources[measure]
        assert findings.references[measure].uncertainty > 0


def test_the_answer_of_another_scene(tmp_path):
    """Of a block that slides as far in the plane as aslant in space, which has no answer itself."""
    plane = parse_scene(SLIDING | {"block": [RIGID]})
    pulse = SLIDING["motion"] | {"amplitude_g": 0.3}
    aslant = {"dimension": 3, "motion": pulse | {"second": pulse | {"amplitude_g": 0.4}}}
    space = parse_scene(SLIDING | {"block": [RIGID | {"thickness": 1.0}]} | aslant)
    for name, scene in (("plane", plane), ("space", space)):
        (tmp_path / f"{name}.toml").write_text(scene_to_toml(scene))
    words = ["study", "error-runtime", str(tmp_path / "space.toml"), "-o", str(tmp_path / "out")]
    more = ["--rungs", "2", "--repeat", "1", "-q", "--measures", "peak_slip"]
    assert cli.main([*words, *more, "--answer", str(tmp_path / "plane.toml")]) == 0
    found = json.loads((tmp_path / "out" / "errors.json").read_text(encoding="utf-8"))
    assert found["references"]["block.peak_slip_m"]["source"] == "rigid block, sliding"
    assert found["runs"][-1]["error.block.peak_slip_m"] < 1e-3


def test_a_block_at_rest_is_no_subject(tmp_path, capsys):
    scene = tmp_path / "rest.toml"
    scene.write_text(ROCKING.replace("tilt_deg = 3.0", "").replace("1.0\nstep", "0.02\nstep"))
    words = ["study", "error-runtime", str(scene), "-o", str(tmp_path / "out"), "-q"]
    assert cli.main([*words, "--repeat", "1", "--rungs", "2"]) == 2
    assert "a block that moves" in capsys.readouterr().err
