"""The demo of the block on a platform, at reduced length, through the functions of its script."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

Captured = pytest.CaptureFixture[str]

pytestmark = [pytest.mark.serial, pytest.mark.slow]

NAMES = (
    "friction 0.1 elastic", "friction 0.1 rigid", "friction 0.3 elastic", "friction 0.3 rigid"
)  # fmt: skip


@pytest.fixture(scope="module")
def demo() -> ModuleType:
    for package in ("dolfinx", "gmsh", "matplotlib"):
        pytest.importorskip(package)
    return importlib.import_module("demos.platform.block_on_platform")


@pytest.fixture(scope="module")
def folders(demo: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The demo's four runs up to 1.35 s: two cycles, and slips that turned round three times."""
    made: list[Path] = demo.slide(tmp_path_factory.mktemp("demo") / "output", "time.end=1.35")
    return made


def test_the_scene_is_the_one_of_the_published_numbers(demo: ModuleType) -> None:
    scene = demo.load_scene(demo.SCENE)
    (block,), platform = scene.blocks, scene.platform()
    assert (block.width, block.height, block.mass, block.cells) == (1.0, 0.5, 1000.0, (6, 4))
    assert (platform.mass, platform.period, platform.damping_ratio) == pytest.approx(
        (500.0, 0.5, 0.05)
    )
    assert (scene.motion.amplitude_g, scene.motion.period, scene.motion.cycles) == (0.4, 0.6, 6)
    assert (scene.time.end, scene.time.adaptive) == (6.0, True)
    assert tuple(demo.variants()) == NAMES


@pytest.mark.parametrize(
    ("friction", "drift", "slip"), [(0.1, 0.07699, -0.1001), (0.3, 0.10089, 0.1359)]
)
def test_what_it_compares_with(
    demo: ModuleType, friction: float, drift: float, slip: float
) -> None:
    """The numbers of an independent program for T2 (docs/error_runtime.md)."""
    exact = demo.exact_numbers(demo.reference(demo.load_scene(demo.SCENE), friction))
    assert exact[0] == pytest.approx(drift, abs=6e-6)
    assert exact[1] == pytest.approx(slip, abs=6e-5)


def test_a_block_bolted_down_makes_one_oscillator(demo: ModuleType) -> None:
    """Against Duhamel's integral of 1500 kg on the spring and dashpot of the platform."""
    scene = demo.load_scene(demo.SCENE)
    answer = demo.reference(scene, 1.0)
    k = 500.0 * (2 * np.pi / 0.5) ** 2
    w, xi = np.sqrt(k / 1500.0), 0.05 / np.sqrt(3)
    wd, t = w * np.sqrt(1 - xi**2), answer.time
    ground = np.where(t <= 3.6, 0.4 * 9.81 * np.sin(2 * np.pi * t / 0.6), 0.0)
    response = np.exp(-xi * w * t) * np.sin(wd * t) / wd
    drift = -np.convolve(ground, response)[: len(t)] * (t[1] - t[0])
    np.testing.assert_allclose(answer.drift, drift, atol=1e-4 * np.abs(drift).max())
    assert demo.drifts(scene).splitlines()[1].endswith(f"{1e3 * np.abs(drift).max():8.1f}")


def test_its_checks_hold(demo: ModuleType, folders: list[Path], capsys: Captured) -> None:
    assert demo.show(folders) == 0
    output = capsys.readouterr()
    assert output.err == ""
    assert output.out.count("holds:") == 4 * 5  # status, drift, slip, gain, ledger
    assert "0.6  bolted\npeak drift mm" in output.out
    assert tuple(folder.name for folder in folders) == NAMES
    for folder in folders:
        names = {file.name for file in folder.iterdir()}
        assert names > {"history.csv", "summary.json", "scene.toml", "run.log", "fields.pvd"}
    assert (folders[0].parent / "drift_and_slip.png").stat().st_size > 20_000


def test_the_table_stands_beside_the_reference(demo: ModuleType, folders: list[Path]) -> None:
    runs = [demo.read_run(folder) for folder in folders]
    rows = [row.split() for row in demo.table(runs, demo.references(runs)).splitlines()[1:]]
    assert [row[1] if len(row) == 4 else row[0] for row in rows] == [
        "reference", "elastic", "rigid"
    ] * 2  # fmt: skip
    assert [row[0] for row in rows if len(row) == 4] == ["0.1", "0.3"]
    for row in (row for row in rows if len(row) == 5):
        assert all(abs(float(word.rstrip("%"))) < 0.5 for word in (row[2], row[4]))


def test_a_check_can_fail(demo: ModuleType, folders: list[Path], capsys: Captured) -> None:
    """One clear line that names the run, and an exit code that is not zero."""
    run = demo.read_run(folders[3])
    run.summary["status"] = "interrupted"
    run.summary["platform"]["peak_drift_m"] *= 1.004
    run.summary["blocks"]["block"]["residual_slip_m"] *= -1
    run.summary["energy"] |= {"largest_gain_fraction": 2e-6, "ledger_error_fraction": 2e-8}
    assert demo.verdict("block_on_platform", demo.checks([run], demo.references([run]))) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"block_on_platform: check failed: {NAMES[3]}: ")
    for word in ("status interrupted", "peak drift", "final slip", "gain 2.0e-06", "error 2.0e-08"):
        assert word in line
