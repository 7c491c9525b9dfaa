"""Suites of events with several components: directions are alike, one factor, what is measured."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver.cli import build_parser, main
from solver.excitation.motion import GroundMotion
from solver.excitation.sampled import SampledMotion
from solver.study.suite.cases import SuiteStudy
from solver.study.suite.intensity import Intensity, turned_motion
from solver.types import Array

pytestmark = pytest.mark.serial

RECORDS = Path(__file__).parents[3] / "shared" / "records"

SCENE = """
dimension = 3
[[block]]
model = "rigid"
width = {width}
thickness = {thickness}
height = 2.0
density = 2000.0
[contact]
friction = 0.45
[motion]
units = "g"
[motion.second]
[motion.vertical]
scale = 0.5
[time]
end = 1.0
step = 1e-3
"""

TIME = 0.01 * np.arange(201)


def noise(seed: int, count: int = 201) -> Array:
    """A motion of two seconds, g."""
    rng, time = np.random.default_rng(seed), 0.01 * np.arange(count)
    waves = (rng.normal() * np.sin(2 * math.pi * f * time + rng.uniform(0, 6)) for f in (0.8, 1.7))
    return np.asarray(0.4 * sum(waves) * np.sin(math.pi * time / time[-1]))


def write(file: Path, value: Array) -> None:
    rows = zip(0.01 * np.arange(len(value)), value.tolist(), strict=True)
    file.write_text("".join(f"{t:.2f} {a!r}\n" for t, a in rows))


def words_of(folder: Path, scene: str, **parts: Array) -> list[str]:
    """The command of a suite of events, whose components are named by the ends of their names."""
    folder.mkdir()
    for name, value in parts.items():
        write(folder / f"{name}.txt", value)
    (folder / "scene.toml").write_text(scene)
    call = [
        "study",
        "suite",
        str(folder / "scene.toml"),
        "-o",
        str(folder / "out"),
        "-q",
        "-j",
        "1",
    ]
    return [*call, "--motions", *(str(file) for file in sorted(folder.glob("*.txt")))]


def suite(folder: Path, scene: str, *words: str, **parts: Array) -> list[dict[str, Any]]:
    """The rows of a suite, which this process runs."""
    call = [*words_of(folder, scene, **parts), *words]
    return [case.run() for case in SuiteStudy(build_parser().parse_args(call)).wanted]


def peaks(row: dict[str, Any]) -> Array:
    """Peaks of a block in a row of a suite, rad and m."""
    keys = ("peak_angle_rad", "peak_slip_m", "peak_angle_over_alpha")
    return np.array([float(row[f"block.{key}"]) for key in keys])


A, B, C, D, UP, DOWN = (noise(seed) for seed in range(2, 8))


def test_two_events_of_three_components_and_their_directions(tmp_path: Path) -> None:
    """Swapped x and y of scene and motions: the same answers; all components take part."""
    scene = SCENE.format(width=0.6, thickness=0.8)
    rows = suite(tmp_path / "one", scene, one_000=A, one_090=B, one_UP=UP,
                 two_000=C, two_090=D, two_UP=DOWN)  # fmt: skip
    other = suite(tmp_path / "swapped", SCENE.format(width=0.8, thickness=0.6),
                  one_000=B, one_090=A, one_UP=UP, two_000=D, two_090=C, two_UP=DOWN)  # fmt: skip
    assert len(rows) == 2
    assert [row["block.mode"] for row in rows] == [row["block.mode"] for row in other]
    for one, swapped in zip(rows, other, strict=True):
        assert peaks(one) == pytest.approx(peaks(swapped), rel=1e-12)
        assert peaks(one).min() > 1e-2
        assert float(one["pga_g"]) == float(swapped["pga_second_g"])
    assert float(rows[0]["pga_g"]) == pytest.approx(np.abs(A).max())
    assert float(rows[0]["pga_second_g"]) == pytest.approx(np.abs(B).max())
    assert float(rows[0]["pga_vertical_g"]) == pytest.approx(0.5 * np.abs(UP).max())
    still = suite(tmp_path / "still", scene, one_000=A, one_090=0 * B, one_UP=UP)
    assert abs(peaks(still[0]) / peaks(rows[0]) - 1).max() > 1e-3


def test_all_components_of_an_event_have_one_factor(tmp_path: Path) -> None:
    """A level of each measure of two components."""
    scene = SCENE.format(width=0.7, thickness=0.7)
    both = np.abs(A).max(), np.abs(B).max()
    known = {"larger": max(both), "geomean": math.sqrt(both[0] * both[1])}
    for how in ("larger", "geomean", "RotD50"):
        words = ["--levels", "0.1", "--horizontal", how]
        (row,) = suite(tmp_path / how, scene, *words, e_000=A, e_090=B, e_UP=UP)
        found = [float(row[f"pga{part}_g"]) for part in ("", "_second", "_vertical")]
        factor = found[0] / both[0]
        assert found[1:] == pytest.approx([factor * both[1], factor * 0.5 * np.abs(UP).max()])
        if how in known:
            assert factor * known[how] == pytest.approx(0.1)
        else:
            assert factor * min(both) < 0.1 < factor * math.hypot(*both)


def test_tables_and_texts_name_components_and_measure(tmp_path: Path) -> None:
    scene = SCENE.format(width=0.7, thickness=0.7)
    words = words_of(tmp_path / "it", scene, e_000=A, e_090=B, e_UP=UP)
    assert main([*words, "-j", "1", "--levels", "0.1"]) == 0
    folder = tmp_path / "it" / "out"
    with (folder / "suite.csv").open(encoding="utf-8", newline="") as stream:
        (row,) = csv.DictReader(stream)
    assert (row["motion"], row["level"], row["intensity"]) == ("e", "0.1", "RotD50 PGA")
    text = (folder / "suite.txt").read_text()
    for part in (
        "motions shake along x, y, the vertical",
        "smaller azimuth (360 is 0) shakes along x",
        "levels are of RotD50 PGA (g); all components of an event have one factor",
        "PGA g  along y  vertical",
    ):
        assert part in text
    assert "RotD50 PGA (g)" in (folder / "fragility.txt").read_text().splitlines()[0]
    assert ",RotD50 PGA (g)" in (folder / "fragility.csv").read_text()


def ground(x: Array, y: Array) -> GroundMotion:
    parts = (
        SampledMotion(time=0.01 * np.arange(len(v)), value=9.81 * v, step=0.01) for v in (x, y)
    )
    return GroundMotion((*parts, None))


@pytest.mark.parametrize("kind", ["PGA", "PGV", "PSA"])
def test_rotd50_by_closed_forms(kind: str) -> None:
    """One component alone: of |cos| over half a circle the median is that of 45 degrees.

    A motion that goes round in a circle is the same in all directions; and whatever the motion is,
    RotD50 does not know how the sensor stood.
    """
    measure = Intensity(kind, 0.3 if kind == "PSA" else 0.0, "RotD50")
    alone = measure.of_ground(ground(A, 0 * A))
    # The 180 directions lie a degree apart: the median is the mean of 45 and 44 or 46 degrees.
    assert alone == pytest.approx(measure.of(ground(A, B).parts[0]) / math.sqrt(2), rel=0.01)
    phase = 2 * math.pi * TIME / 0.36
    swell = np.minimum(TIME, 1.0)
    circle = ground(swell * np.cos(phase), swell * np.sin(phase))
    if kind == "PGA":
        # A sample every 10 degrees is at most 5 from any direction.
        assert math.cos(math.radians(5)) <= measure.of_ground(circle) <= 1.0
    both = ground(A, B)
    x, y = both.parts[:2]
    for degrees in (37, 90, 140):
        angle = math.radians(degrees)
        turned = (turned_motion(x, y, angle), turned_motion(x, y, angle + math.pi / 2), None)
        assert measure.of_ground(GroundMotion(turned)) == pytest.approx(
            measure.of_ground(both), rel=1e-12
        )


def test_components_of_different_length_are_still_after_their_end(tmp_path: Path) -> None:
    """As PEER's records have it: zeros, and the run to the end of the longer one."""
    scene = SCENE.format(width=0.6, thickness=0.8)
    (short,) = suite(tmp_path / "a", scene, e_000=A, e_090=B[:190], e_UP=UP)
    padded = np.concatenate([B[:190], np.zeros(11)])
    (long,) = suite(tmp_path / "b", scene, e_000=A, e_090=padded, e_UP=UP)
    assert float(short["end_s"]) == float(long["end_s"]) == 2.0
    # Where B stops, the broken line falls to zero at once, or within one sample.
    assert peaks(short) == pytest.approx(peaks(long), rel=1e-3)
    assert short["cautions"] == long["cautions"] == ""
    tail = Intensity("PGA", horizontal="RotD50")
    assert tail.of_ground(ground(A, B[:190])) == pytest.approx(tail.of_ground(ground(A, padded)))


@pytest.mark.skipif(not RECORDS.is_dir(), reason="no records here")
def test_rotd50_of_recorded_pairs_is_between_their_components() -> None:
    """And below the vector of both; the components of a pair may have different lengths."""
    from solver.excitation.kinds import read_record
    from solver.scene.motion import RecordSpec

    for name, both in (
        ("RSN1003_NORTHR_STN", ("020", "110")),
        ("RSN1084_NORTHR_SCS", ("052", "142")),
    ):
        pair = [
            read_record(RecordSpec(file=RECORDS / f"{name}{end}.AT2", units="g")) for end in both
        ]
        measure = Intensity("PGA", horizontal="RotD50")
        found = measure.of_ground(GroundMotion((*pair, None)))
        assert min(p.peak for p in pair) / math.sqrt(2) < found * 9.81 < max(p.peak for p in pair)
