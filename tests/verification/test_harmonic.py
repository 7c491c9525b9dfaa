"""Steady rocking under a sine; runs beside their twins, and the study of horizons."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from benchmarks.steady_rocking import (
    SIZE,
    STONE,
    steady,
    under_a_sine,
)
from rockslip import Scene, parse_scene, simulate
from solver.cli import main
from solver.run import simulate as simulate_module
from solver.run.twin import difference, horizon, twin_of
from solver.study.horizon.numbers import as_text

pytestmark = pytest.mark.serial


@pytest.mark.parametrize(("restitution", "most"), [(None, 0.18875), (0.925, 0.1890)])
def test_steady_rocking_of_a_rigid_block(restitution: float | None, most: float) -> None:
    """Within 1 % of Housner's equation; a slender, linear block has 0.18951."""
    keys = {"model": "rigid"} | ({"restitution": restitution} if restitution else {})
    history = simulate(under_a_sine(60, **keys)).history
    found = steady(history["time_s"], history["block.angle_rad"], 60)
    assert found == pytest.approx(most, rel=0.01)
    assert found == pytest.approx(0.18951, rel=0.01)


def test_steady_rocking_has_no_horizon() -> None:
    """A millionth more motion is a millionth more answer."""
    scene = under_a_sine(30, model="rigid")
    runs = [simulate(each).history for each in (scene, twin_of(scene))]
    _, apart = difference(scene, *runs)
    assert 0 < apart.max() < 1e-4
    assert horizon(scene, *runs) is None


@pytest.mark.slow
def test_a_history_that_its_tolerance_decides_has_a_horizon() -> None:
    """A finer one leans otherwise; a millionth of the motion changes nothing to the end."""
    block = SIZE | STONE | {"young": 5e9, "cells": [2, 6]}
    motion = {"kind": "sine", "amplitude_g": 0.45, "period": 0.45, "cycles": 4}
    time = {"end": 2.0, "tolerance": 0.04}
    tables = {"block": [block], "motion": motion, "time": time, "output": {"twin": True}}
    scene = parse_scene(tables)
    result = simulate(scene)
    found = result.summary["horizon"]
    assert found["tolerance"] == 0.01 and found["time_s"] < 1.5
    assert horizon(scene, result.history, simulate(twin_of(scene)).history) is None


def test_a_scene_without_motion_has_a_twin_with_another_start() -> None:
    scene = parse_scene({
        "block": [SIZE | {"model": "rigid", "tilt_deg": 3.0, "velocity": [0.1, 0.0]}],
        "time": {"end": 1.0},
    })  # fmt: skip
    twin = twin_of(scene, 1e-3).blocks[0]
    assert (twin.tilt_deg, *twin.velocity) == pytest.approx((3.003, 0.1001, 0.0))
    assert twin_of(scene, 0.0) == scene


def test_a_run_tells_its_horizon(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In the summary and in words; without it, nothing is said."""
    words = ["run", str(SCENE), "--set", "motion.kind=synthetic", "motion.scale=3",
             "time.end=8", "time.step=2e-3"]  # fmt: skip
    assert main([*words, "output.twin=true", "-o", str(tmp_path / "out")]) == 0
    found = json.loads((tmp_path / "out" / "summary.json").read_text())["horizon"]
    assert found["perturbation"] == 1e-6 and found["status"] == "completed"
    assert capsys.readouterr().out.count("horizon: ") == 1
    assert main([*words, "-o", str(tmp_path / "other")]) == 0
    assert "horizon" not in json.loads((tmp_path / "other" / "summary.json").read_text())
    files = [(tmp_path / name / "history.csv").read_text() for name in ("out", "other")]
    assert files[0] == files[1]


SCENE = Path(__file__).parents[2] / "demos" / "ensemble" / "scene.toml"


def test_the_study(tmp_path: Path) -> None:
    """Smaller differences last longer; the horizon is that of the two runs themselves."""
    pytest.importorskip("matplotlib")
    words = ["study", "horizon", str(SCENE), "-o", str(tmp_path / "out"), "-q", "-j", "1",
             "--set", "motion.kind=synthetic", "motion.scale=3", "time.end=20", "time.step=2e-3",
             "--differences", "1e-3,1e-6,1e-9"]  # fmt: skip
    assert main(words) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    sizes = [row["perturbation"] for row in summary["twins"]]
    assert sizes == [1e-9, 1e-6, 1e-3]
    ends = [row["horizon_s"] or math.inf for row in summary["twins"]]
    assert ends[0] >= ends[1] >= ends[2] and ends[2] < 20
    assert (tmp_path / "out" / "horizon.png").stat().st_size > 10_000
    assert main([*words, "--resume"]) == 0
    assert main(["report", str(tmp_path / "out")]) == 0
    assert "<h1>Horizon: " in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_scales_of_a_scene_without_motion_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All of them would be the same run."""
    file = tmp_path / "scene.toml"
    file.write_text(
        "[[block]]\nwidth = 0.25\nheight = 1.0\nmass = 500.0\nmodel = 'rigid'\ntilt_deg = 3\n"
        "[time]\nend = 1.0\n"
    )
    words = ["study", "horizon", str(file), "-o", str(tmp_path / "out"), "--scales", "1,2"]
    assert main(words) == 2
    assert "--scales: got 1,2, allowed 1 for a scene without [motion]" in capsys.readouterr().err


def test_a_twin_is_solved_as_the_run_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the same options for PETSc; it has the time that the run leaves it."""
    calls: list[dict[str, Any]] = []
    usual = simulate_module.simulate

    def simulated(scene: Scene, **options: Any) -> Any:
        calls.append(options)
        return usual(scene, **options)

    monkeypatch.setattr(simulate_module, "simulate", simulated)
    block = SIZE | {"young": 5e10, "poisson": 0.2, "cells": [1, 2], "tilt_deg": 3.0}
    tables = {"block": [block], "time": {"end": 0.01, "step": 1e-3}, "output": {"twin": True}}
    options = ("-rockslip_snes_rtol", "1e-4")
    usual(parse_scene(tables), petsc_options=options, seconds=1000.0)
    (twin,) = calls
    assert twin["petsc_options"] == options and 0 < twin["seconds"] < 1000


@pytest.mark.parametrize(("peak", "said"), [(0.0, True), (0.3, False)])
def test_a_study_in_which_nothing_rocks_says_so(peak: float, said: bool) -> None:
    twin = {"perturbation": 1e-6, "horizon_s": None, "largest_difference": 0.0}
    run = {"engine": "rigid", "scale": 1.0, "end_s": 5.0, "overturned": False}
    run["peak_angle_over_alpha"] = peak
    assert ("no block leaves the ground" in as_text([run | {"twins": [twin]}])) == said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--differences", "0.5"], "--differences: got 0.5"),
        (["--engines", "ode"], '--engines: got "ode", allowed rigid, elastic'),
    ],
)
def test_what_is_refused(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", "horizon", str(SCENE), "-o", str(tmp_path / "out"), *words]) == 2
    assert said in capsys.readouterr().err
