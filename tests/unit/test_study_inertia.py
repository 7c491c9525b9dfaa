"""The study of inertia: roots, the one reported, what is refused, what it leaves, going on."""

from __future__ import annotations

import csv
import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from html_page import Page

from rockslip import load_scene
from solver.cli import main
from solver.errors import SceneError
from solver.study.inertia.cells import RATIO, TOP, cells_of, chosen, ladder
from solver.study.inertia.numbers import Curve, grid, portions

pytestmark = pytest.mark.serial

ROOT = Path(__file__).parents[2]
SCENE = ROOT / "demos" / "suite" / "scene.toml"

Captured = pytest.CaptureFixture[str]

LEFT = {"inertia.csv", "inertia.md", "summary.json"}


def curve() -> Curve:
    """Rises to 0.5, falls to 0.8, rises on."""
    return Curve(np.array([-0.5, 0.5, 0.8, 1.5]), np.array([0.0, 1.0, 0.7, 1.4]))


def test_all_roots_are_found() -> None:
    assert curve().roots(0.8) == pytest.approx([0.3, 0.7, 0.9])
    assert curve().roots(0.5) == pytest.approx([0.0])
    assert curve().roots(1.0) == pytest.approx([0.5, 1.1])  # a turning point is a root
    assert curve().roots(2.0).size == 0
    assert curve().turns() == pytest.approx([0.5, 0.8])


def test_the_reported_root_is_followed_from_one() -> None:
    own = curve()
    assert own.followed(np.array([0.9, 0.8, 0.71])) == pytest.approx([1.0, 0.9, 0.81])
    # Below the fold at 0.8 its branch has ended: the nearest root, and then on from there.
    assert own.followed(np.array([0.8, 0.6, 0.8])) == pytest.approx([0.9, 0.1, 0.3])
    found = own.followed(np.array([0.9, 1.5, 1.2]))
    assert math.isnan(found[1])
    assert (found[0], found[2]) == pytest.approx((1.0, 1.3))


def test_portions_of_a_straight_curve() -> None:
    """D = 1 + lambda of all motions: no scatter, arithmetic and geometric means agree."""
    drifts = np.tile(1 + grid(), (5, 1))
    targets = np.tile([2.0, 1.25, 0.9, 3.0], (5, 1))
    for geometric in (False, True):
        found = portions(drifts, targets, geometric=geometric)
        values = [portion.value for portion in found]
        assert values[:3] == pytest.approx([1.0, 0.25, -0.1], abs=1e-4)
        assert values[3] is None
        assert (found[1].low, found[1].high) == pytest.approx((0.25, 0.25), abs=1e-4)
        assert found[3].without == 1.0
        assert found[3].half_width == math.inf


def test_the_interval_is_that_of_the_mean() -> None:
    """D = lambda of all motions, targets that scatter: 1.645 standard errors to both sides."""
    count = 200
    targets = np.random.default_rng(1).normal(0.6, 0.2, count)
    drifts = np.tile(np.where(grid() > 0, grid(), 0.0), (count, 1))
    (_, portion) = portions(drifts, np.stack([np.ones(count), targets], axis=1), geometric=False)
    error = 1.645 * targets.std() / math.sqrt(count)
    assert portion.value == pytest.approx(targets.mean(), abs=1e-6)
    assert portion.low == pytest.approx(targets.mean() - error, abs=0.15 * error)
    assert portion.high == pytest.approx(targets.mean() + error, abs=0.15 * error)


def test_a_load_that_changes_nothing_has_no_portion() -> None:
    drifts = np.tile(1 + 1e-3 * grid(), (5, 1))
    (portion,) = portions(drifts, np.ones((5, 1)), geometric=False)
    assert (portion.value, portion.roots) == (None, ())


def test_friction_goes_down_from_infinity() -> None:
    found = ladder([0.1, 0.3])
    assert found[0] == math.inf
    assert found[1] == RATIO**TOP
    assert found == sorted(found, reverse=True)
    assert found[-1] == 0.1
    assert 0.3 in found
    assert max(a / b for a, b in itertools.pairwise(found[1:])) <= RATIO * (1 + 1e-12)


def test_cells_are_all_combinations() -> None:
    scene = load_scene(SCENE)
    assert len(cells_of(scene, chosen([]))) == 48
    cells = cells_of(scene, chosen(["mass_ratio=1,0.5", "period=1"]))
    assert [cell.values for cell in cells] == [
        (("mass_ratio", 0.5), ("period", 1.0)),
        (("mass_ratio", 1.0), ("period", 1.0)),
    ]
    assert cells[0].structure.period == 1.0
    assert cells[0].friction == 0.2
    assert cells[0].structure.damping_ratio == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--of", "perod=1"], "did you mean 'period'?"),
        (["--of", "period=1,1"], "--of: got "),
        (["--of", "period=0"], "positive numbers"),
        (["--of", "friction=0.1", "friction_over_pga=1"], "one of them"),
        (["--of", "aspect=1"], "sliding has no height"),
        (["--by", "elements"], "at most 12"),
        (["-j", "0"], "a whole number > 0"),
        (["--set", "contact.friction.static=0.2", "contact.friction.decay=1"], "contact.friction"),
        (["--set", "foundation={kind='rigid'}"], "foundation.kind"),
        (["--set", "block.velocity=[0.3, 0.0]"], "starts with a tilt or a velocity"),
        (["--set", "block.tilt_deg=1.0"], "starts with a tilt or a velocity"),
    ],
)
def test_it_refuses(words: list[str], said: str, tmp_path: Path, capsys: Captured) -> None:
    folder = tmp_path / "out"
    assert main(["study", "inertia", str(SCENE), "-o", str(folder), *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not folder.exists()


def test_an_inclined_scene_is_refused() -> None:
    with pytest.raises(SceneError, match="inclined"):
        cells_of(load_scene(SCENE, ["gravity_tilt_deg=5"]), chosen([]))


def test_a_motion_that_also_shakes_upwards_is_refused(tmp_path: Path, capsys: Captured) -> None:
    """The sliding block would leave the vertical motion out."""
    file = tmp_path / "motion.csv"
    file.write_text("0 0\n0.1 1\n0.2 -1\n0.3 0\n")
    record = "kind='record', units='m/s2'"
    upwards = f"motion={{{record}, vertical={{{record}, file='{file}'}}}}"
    words = ["--motions", str(file), "--set", upwards, "--of", "friction=0.1", "-q", "-j", "1"]
    assert main(["study", "inertia", str(SCENE), "-o", str(tmp_path / "out"), *words]) == 2
    assert "the motions of the study are along x" in capsys.readouterr().err


WORDS = ["--of", "period=0.5,1", "friction=0.05,0.1", "--count", "12", "-q", "-j", "1"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small study."""
    pytest.importorskip("matplotlib")
    made = tmp_path_factory.mktemp("inertia") / "out"
    assert main(["study", "inertia", str(SCENE), "-o", str(made), *WORDS]) == 0
    return made


def contents(folder: Path) -> dict[str, bytes]:
    """Files of a study by their names, without its subfolders."""
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()}


@pytest.mark.slow
def test_what_it_leaves(folder: Path) -> None:
    assert contents(folder).keys() >= LEFT | {"lambda.png", "map_sliding_block.png", "roots.png"}
    with (folder / "inertia.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["period_s"], row["friction"]) for row in rows] == [
        ("0.5", "0.05"), ("0.5", "0.1"), ("1", "0.05"), ("1", "0.1")
    ]  # fmt: skip
    for row in rows:
        low, value, high = (float(row[k]) for k in ("lambda_low", "lambda", "lambda_high"))
        assert low <= value <= high
        assert float(row["base_shear_over_fixed"]) < 1 < float(row["base_shear_over_bare"])
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["motions"] == 12
    assert summary["cells"][0]["roots"] == pytest.approx([float(rows[0]["lambda"])])


def test_the_page_stands_alone(folder: Path, tmp_path: Path) -> None:
    file = tmp_path / "page.html"
    assert main(["report", str(folder), "-o", str(file)]) == 0
    page = Page()
    page.feed(file.read_text(encoding="utf-8"))
    assert page.open == []
    assert len(page.sources) == 4
    assert all(source.startswith("data:image/png;base64,iVBOR") for source in page.sources)
    assert page.cells == 4 * 19
    command = f"rockslip study inertia {SCENE} --of period=0.5,1 friction=0.05,0.1 --count 12\n"
    assert command in page.text
    assert 'kind = "oscillator"' in page.text


@pytest.mark.slow
def test_it_goes_on_with_what_is_missing(folder: Path, tmp_path: Path) -> None:
    """Half of its runs removed: the same files to the byte; another map takes what there is."""
    again = tmp_path / "out"
    (again / "cases").mkdir(parents=True)
    files = sorted((folder / "cases").iterdir())
    for file in (folder / "settings.json", *files[::2]):
        (again / file.relative_to(folder)).write_bytes(file.read_bytes())
    command = ["study", "inertia", str(SCENE), "-o", str(again), "--resume"]
    assert main([*command, *WORDS]) == 0
    assert contents(again) == contents(folder)
    smaller = ["--of", "period=1", "friction=0.05,0.1", "--count", "10", "-q"]
    times = {file: file.stat().st_mtime_ns for file in (again / "cases").iterdir()}
    assert main([*command, *smaller]) == 0
    assert {file: file.stat().st_mtime_ns for file in (again / "cases").iterdir()} == times


@pytest.mark.slow
def test_rigid_blocks_beside_the_sliding_block(tmp_path: Path) -> None:
    """A squat block and a slender one that rocks; a motion with PGA as the measure of friction."""
    words = ["--of", "aspect=0.5,4", "friction_over_pga=0.5", "--by", "rigid", "--count", "1"]
    set_to = ["--set", "time.step=5e-3", "-q", "-j", "1"]
    folder = tmp_path / "out"
    assert main(["study", "inertia", str(SCENE), "-o", str(folder), *words, *set_to]) == 0
    cells = json.loads((folder / "summary.json").read_text())["cells"]
    assert [(cell["by"], cell["aspect"]) for cell in cells] == [
        ("sliding block", 0.5), ("sliding block", 4.0), ("rigid blocks", 0.5), ("rigid blocks", 4.0)
    ]  # fmt: skip
    closed, squat, slender = (cells[k]["mean_peak_drift_m"] for k in (0, 2, 3))
    assert squat == pytest.approx(closed, rel=2e-3)
    assert abs(slender / closed - 1) > 0.01
