"""Ensembles: motions at levels of intensity, engines beside each other, their statistics."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest

from rockslip import parse_scene
from solver.cli import main
from solver.excitation.motion import GroundMotion
from solver.excitation.sampled import SampledMotion
from solver.study.suite.cases import equation
from solver.study.suite.numbers import Sample, distances, fits, samples

pytestmark = pytest.mark.serial

SCENE = Path(__file__).parents[2] / "demos" / "ensemble" / "scene.toml"
SLENDERNESS = math.atan(0.25)

Rows = list[dict[str, str]]


def table(file: Path) -> Rows:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def study(folder: Path, *words: str) -> int:
    return main(["study", "suite", str(SCENE), "-o", str(folder), "-q", "-j", "1", *words])


@pytest.mark.slow
def test_levels_of_intensity(tmp_path: Path) -> None:
    """Every motion has the intensity that was asked for; the engines see the same motions."""
    pytest.importorskip("matplotlib")
    words = ["--count", "3", "--levels", "0.45,0.2", "--engines", "rigid,ode", "-j", "1"]
    assert study(tmp_path / "out", *words, "--set", "time.step=1e-3") == 0
    rows = table(tmp_path / "out" / "suite.csv")
    assert len(rows) == 12
    for row in rows:
        assert float(row["pga_g"]) == pytest.approx(float(row["level"]), rel=1e-9)
    weak = [row for row in rows if row["level"] == "0.2"]  # below B/H
    assert max(float(row["block.peak_angle_rad"]) for row in weak) < 1e-6
    assert study(tmp_path / "out", *words, "--set", "time.step=1e-3", "--resume") == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert [fit["engine"] for fit in summary["fits"]] == ["rigid", "ode"]
    assert "median" not in summary["fits"][0]  # all overturn at one level, none at the other
    assert [(row["engine"], row["level"], row["overturned"]) for row in summary["levels"]] == [
        ("rigid", 0.2, 0), ("rigid", 0.45, 3), ("ode", 0.2, 0), ("ode", 0.45, 3)
    ]  # fmt: skip


def test_the_engine_and_the_equation_agree_while_motions_are_short(tmp_path: Path) -> None:
    """Before errors have grown: the same peaks within 1 %, one motion after the other."""
    time = np.arange(0.0, 2.005, 0.01)
    (tmp_path / "motions").mkdir()
    for number in range(4):
        rng = np.random.default_rng(number)
        value = sum(rng.normal() * np.sin(2 * math.pi * f * time) for f in (0.7, 1.1, 1.9))
        lines = [f"{t:.2f},{a!r}" for t, a in zip(time, value.tolist(), strict=True)]
        (tmp_path / "motions" / f"m{number}.csv").write_text("\n".join(lines) + "\n")
    words = ["--motions", str(tmp_path / "motions"), "--set", "motion.units=g", "-j", "1"]
    words += ["--levels", "0.3", "--intensity", "PGA", "--engines", "rigid,ode"]
    assert study(tmp_path / "out", *words) == 0
    rows = table(tmp_path / "out" / "suite.csv")
    peaks = [[float(r["block.peak_angle_while_standing_rad"]) for r in rows if r["engine"] == e]
             for e in ("rigid", "ode")]  # fmt: skip
    assert min(peaks[1]) > 0.02 * SLENDERNESS
    assert peaks[0] == pytest.approx(peaks[1], rel=0.01)


def row(engine: str, level: float, angle: float, *, over: bool = False) -> dict[str, object]:
    return {
        "status": "completed", "engine": engine, "level": level,
        "a.peak_angle_over_alpha_while_standing": angle / 0.2,
        "a.overturned_at_s": 1.0 if over else None,
        "a.peak_slip_while_standing_m": 1e-3 * angle,
    }  # fmt: skip


def test_statistics_of_rows() -> None:
    """Samples by engine and level, overturned blocks beyond all angles, curves and distances."""
    rows = [row("rigid", level, 0.1 * k, over=10 * level + k > 9)
            for level in (0.2, 0.4, 0.6, 0.8) for k in range(1, 6)]  # fmt: skip
    rows += [row("elastic", 0.2, 0.1 * k + 0.05) for k in range(1, 6)]
    rows.append({"status": "failed", "engine": "rigid", "level": 0.2, "reason": "none"})
    found = samples(rows, ("engine", "level"), ["a"])
    assert [(s.engine, s.level, s.overturned) for s in found] == [
        ("rigid", 0.2, 0), ("rigid", 0.4, 0), ("rigid", 0.6, 2), ("rigid", 0.8, 4),
        ("elastic", 0.2, 0),
    ]  # fmt: skip
    assert found[0].angle == pytest.approx((0.5, 1.0, 1.5, 2.0, 2.5))
    (apart,) = distances(found)
    assert apart["angle"] == pytest.approx(0.2) and apart["overturned"] == 0.0
    curves = dict((own[0].engine, curve) for own, curve in fits(found))
    assert curves["elastic"] is None
    assert curves["rigid"] is not None and 0.6 < curves["rigid"].median < 0.8
    sample = Sample((("block", "a"),), "ode", 0.5, (0.1, math.inf, 0.3), ())
    assert sample.row()["angle_over_alpha_50"] == 0.3
    assert sample.row()["angle_over_alpha_84"] is None  # a third overturned
    assert sample.row()["slip_m_50"] is None


@pytest.mark.slow
def test_rigid_blocks_and_the_equation_have_one_distribution(tmp_path: Path) -> None:
    """24 motions scaled to 2 g tan alpha: Kolmogorov-Smirnov distance below 0.15.

    A motion of many impacts is chaotic: some blocks overturn in one of both alone, as often in the
    one as in the other (McNemar's test, two standard deviations).
    """
    words = ["--count", "24", "--levels", "0.5", "--engines", "rigid,ode"]
    words += ["--set", "time.step=1e-3"]
    assert study(tmp_path / "out", *words) == 0
    (apart,) = json.loads((tmp_path / "out" / "summary.json").read_text())["distances"]
    assert apart["angle"] < 0.15
    overturned: dict[str, list[bool]] = {"rigid": [], "ode": []}
    for found in table(tmp_path / "out" / "suite.csv"):
        overturned[found["engine"]].append(bool(found["block.overturned_at_s"]))
    pairs = list(zip(overturned["rigid"], overturned["ode"], strict=True))
    alone = pairs.count((True, False)), pairs.count((False, True))
    assert sum(alone) <= 6
    assert abs(alone[0] - alone[1]) <= 2 * math.sqrt(sum(alone))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--intensity", "PGV"], "--levels is required beside --intensity"),
        (["--levels", "0"], "--levels: got"),
        (["--levels", "1", "--intensity", "PGX"], '--intensity: got "PGX", allowed PGA, PGV'),
        (["--engines", "rigd"], "did you mean 'rigid'"),
        (["--engines", "ode", "--set", "block.tilt_deg=1"], "block: got a block that is tilted"),
        (["--engines", "elastic", "--set", "block.young=-1"], "block.young: got -1"),
    ],
)
def test_what_is_refused(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", "suite", str(SCENE), "-o", str(tmp_path / "out"), *words]) == 2
    assert said in capsys.readouterr().err


def test_housner_s_block_beyond_its_balance_at_the_end_has_overturned() -> None:
    """On the moon, under a steady a = g, its angle is between 0.363 and 0.607 (p t)^2.

    It passes alpha = 0.245 at (p t)^2 between 0.404 and 0.674, and stays below 2 alpha up to 0.807.
    """
    gravity = 1.62
    p = math.sqrt(3 * gravity / (4 * math.hypot(0.125, 0.5)))
    end = math.sqrt(0.74) / p
    block = {"width": 0.25, "height": 1.0, "mass": 503.0, "model": "rigid"}
    scene = parse_scene({"block": [block], "gravity": gravity, "time": {"end": end}})
    steady = SampledMotion(time=np.array([0.0, 9.0]), value=np.array([gravity, gravity]))
    found = equation(scene, GroundMotion((steady, None)))["blocks"]["block"]
    assert math.sqrt(0.404) < p * found["overturned_at_s"] < math.sqrt(0.674)
    assert found["mode"] == "overturned"
    assert 1.0 < found["peak_angle_over_alpha"] < 2.0


def test_housner_s_block_that_was_beyond_its_balance_and_came_back_has_rocked() -> None:
    """Pushed by 1.07 g for 0.15 s, held back by 0.8 g for 0.2 s, then left alone."""
    block = {"width": 0.25, "height": 1.0, "mass": 503.0, "model": "rigid", "restitution": 0.5}
    scene = parse_scene({"block": [block], "time": {"end": 5.0}})
    time = np.array([0.0, 0.15, 0.1501, 0.35, 0.3501])
    push = SampledMotion(time=time, value=np.array([10.5, 10.5, -8.0, -8.0, 0.0]))
    summary = equation(scene, GroundMotion((push, None)))
    found = summary["blocks"]["block"]
    assert 1.0 < found["peak_angle_over_alpha"] < 2.0
    assert found["overturned_at_s"] is None
    assert found["mode"] == "rock"
    assert summary["end_s"] == pytest.approx(5.0, abs=3e-3)
    weak = SampledMotion(time=time, value=np.array([2.4, 2.4, -2.4, -2.4, 0.0]))
    still = equation(scene, GroundMotion((weak, None)))["blocks"]["block"]
    assert still["mode"] == "rest"  # below g tan alpha
