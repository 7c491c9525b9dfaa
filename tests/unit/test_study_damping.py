"""The study of damping without a run: limits, axes, targets, the search, files and refusals."""

from __future__ import annotations

import csv
import json
import math
import tomllib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import load_scene, parse_scene
from solver.cli import main
from solver.errors import SceneError
from solver.reference.housner import housner
from solver.scene import BlockSpec, DampingSpec, Scene
from solver.study.damping.axes import (
    AXES,
    BaseScene,
    DampingCase,
    swept_values,
    time_for,
    watched,
)
from solver.study.damping.calibration import (
    MOST_RUNS,
    Search,
    Trial,
    measured_peaks,
    read_history,
    target_of,
)
from solver.study.damping.numbers import Restitution, limit
from solver.types import Array
from tests.scenes import GRANITE

SCENE = GRANITE + "[damping]\nstiffness = 3.7e-5\n[time]\nend = 3.0\n"

FLOOR = """
[foundation]
kind = "elastic"
support = "bottom"
width = 1.0
height = 0.25
density = 2680.0
young = 5.0e10
poisson = 0.2
cells = [8, 2]
"""

Captured = pytest.CaptureFixture[str]


def base(text: str = SCENE) -> BaseScene:
    scene = parse_scene(text)
    block = watched(scene, None)
    return BaseScene(tables=tomllib.loads(text), scene=scene, block=block, end=1.6)


# --- limits


@pytest.mark.parametrize("order", [0.6, 1.0, 2.0, 4.0])
def test_a_sequence_of_known_limit(order: float) -> None:
    """Values off by 2 x^p, at distances without a common ratio; no more than x^2 is relied on."""
    x = [1e-3, 4e-4, 2e-4, 5e-5] if order <= 2 else [0.5, 0.25, 0.125]
    found = limit(x, [0.936 - 2.0 * h**order for h in x], [0.0] * len(x))
    assert found is not None and found.source == "extrapolated"
    if order > 2:
        assert found.order == 2.0 and abs(found.value - 0.936) < found.uncertainty
        return
    assert (found.value, found.order) == pytest.approx((0.936, order), abs=1e-6)
    assert found.uncertainty == pytest.approx(2.0 * 5e-5**order, rel=1e-6)


@pytest.mark.parametrize(
    ("values", "error", "wanted"),
    [
        ([0.93, 0.94, 0.932], 1e-4, ("scatter", 0.932, 0.01)),
        ([0.93, 0.931, 0.935], 0.0, ("scatter", 0.935, 0.005)),  # differences grow
        ([0.93, 0.9361, 0.9360], 2e-4, ("reached", 0.9360, 2e-4)),
    ],
)
def test_a_sequence_without_an_order(
    values: list[float], error: float, wanted: tuple[str, float, float]
) -> None:
    """Its last value stands, with the range of the last three, or their own errors."""
    found = limit([1.0, 0.5, 0.25], values, [error] * 3)
    assert found is not None and math.isnan(found.order)
    assert (found.source, found.value, found.uncertainty) == pytest.approx(wanted)
    assert limit([1.0, 0.5], values[:2], [error] * 2) is None


# --- restitution of a run


@pytest.mark.parametrize(
    ("known", "said"),
    [
        ([0.9, 0.95, 0.92, 0.91, 0.5], ""),
        ([0.9, None], "1 impact with a restitution by 0.6 s, 4 are wanted"),
        ([], "no impacts with a restitution by 0.6 s, 4 are wanted"),
    ],
)
def test_restitution_is_the_geometric_mean_of_the_first_impacts(
    known: list[float | None], said: str
) -> None:
    block = {"impacts": [{"time_s": k, "restitution": e} for k, e in enumerate(known)]}
    found, first = Restitution.of(block, 4), [e for e in known[:4] if e]
    assert found.mean == (pytest.approx(np.prod(first) ** (1 / len(first))) if first else None)
    error = np.std(first, ddof=1) / math.sqrt(len(first)) if len(first) > 1 else 0.0
    assert found.error == pytest.approx(error)
    assert found.too_few(0.6) == said and found.complete == (not said)


# --- axes and sweeps


def test_every_axis_sets_what_it_says() -> None:
    own = base()
    expected: dict[str, tuple[float, Callable[[Scene], Any], Any]] = {
        "step": (5e-4, lambda s: (s.time.step, s.time.adaptive), (5e-4, False)),
        "tolerance": (4e-3, lambda s: (s.time.tolerance, s.time.adaptive), (4e-3, True)),
        "mesh": (0.5, lambda s: s.blocks[0].cells, (3, 8)),
        "gamma": (300.0, lambda s: s.contact.gamma, 300.0),
        "rho_inf": (0.5, lambda s: s.time.rho_inf, 0.5),
        "damped_steps": (8.0, lambda s: s.time.damped_steps, 8),
        "beta": (1e-4, lambda s: s.damping and s.damping.stiffness, 1e-4),
        "contact": (0.2, lambda s: s.contact.damping, 0.2),
        "young": (5e9, lambda s: s.blocks[0].young, 5e9),
        "floor": (3.0, lambda s: s.to_dict()["foundation"]["young"], 1.5e11),
    }
    assert expected.keys() == AXES.keys()
    for name, (value, read, wanted) in expected.items():
        scene = (base(SCENE + FLOOR) if name == "floor" else own).case(AXES[name], value).scene
        assert read(scene) == wanted, name
        assert scene.time.end == 1.6
    assert own.tables["damping"] == {"stiffness": 3.7e-5}


def test_damping_of_the_block_itself_is_what_is_varied() -> None:
    text = SCENE.replace("tilt_deg", "damping = { mass = 0.5, stiffness = 1e-5 }\ntilt_deg")
    scene = base(text).case(AXES["beta"], 2e-5).scene
    assert scene.blocks[0].damping is not None and scene.damping is not None
    assert (scene.blocks[0].damping.mass, scene.blocks[0].damping.stiffness) == (0.5, 2e-5)
    assert scene.damping.stiffness == 3.7e-5


def test_the_default_damping_is_that_of_the_block_in_what_is_varied() -> None:
    """It does not follow E, so that one parameter varies at a time."""
    text = SCENE.replace("[damping]\nstiffness = 3.7e-5\n", "")
    own = base(text)
    default = own.scene.blocks[0].damping
    assert "damping" not in own.tables and default == own.scene.default_damping(own.scene.blocks[0])
    for name, value, wanted in (("young", 5e9, default.stiffness), ("beta", 1e-4, 1e-4)):
        scene = own.case(AXES[name], value).scene
        assert scene.blocks[0].damping == DampingSpec(stiffness=wanted)
        assert scene.damping is None
    assert own.case(AXES["beta"], default.stiffness).key == own.case(AXES["young"], 5e10).key
    assert own.case(AXES["young"], 5e10).key == own.case().key


def test_equal_scenes_are_run_once() -> None:
    """Values that are the scene's own have its key."""
    own = base()
    found, _ = swept_values(own, ["beta=3.7e-5,1e-4", "mesh=1,2"])
    assert [s.case.key == own.case().key for s in found] == [True, False, True, False]


def test_default_values_that_a_scene_does_not_take_are_told() -> None:
    """A floor has to be meshed; a value asked for is refused instead."""
    found, left_out = swept_values(base(), [])
    assert {swept.axis.name for swept in found} == AXES.keys() - {"floor"}
    assert left_out == ["floor: --of floor applies to meshed foundations; remove it"]
    with pytest.raises(SceneError, match="--of floor applies to"):
        swept_values(base(), ["floor"])
    with pytest.raises(SceneError, match="gamma: got 1"):
        swept_values(base(), ["gamma=1,100"])


def test_runs_end_after_the_impacts_that_count() -> None:
    """A block that loses nothing has its fourth impact and the peak after it."""
    scene = parse_scene(SCENE)
    block = scene.blocks[0]
    end = time_for(scene, block, 4)
    free = housner(block.shape, gravity=9.81, tilt=block.tilt, end=3.0, step=1e-3, restitution=1.0)
    assert free.impacts[3] + 0.19 < end < free.impacts[4]
    shaken = parse_scene(SCENE + '[motion]\nkind = "sine"\namplitude_g = 0.1\nperiod = 0.5\n')
    assert time_for(shaken, shaken.blocks[0], 4) == 3.0


# --- targets


def measured(e: float, *, noise: float = 0.0, end: float = 2.0) -> tuple[BlockSpec, Array, Array]:
    """A rigid block with this restitution, as measured: block, times, angles."""
    block = parse_scene(SCENE).blocks[0]
    found = housner(block.shape, gravity=9.81, tilt=block.tilt, end=end, step=2e-3, restitution=e)
    angle = found.angle + noise * np.random.default_rng(1).standard_normal(len(found.angle))
    keep_rows = np.concatenate([[True], np.diff(found.time) > 0])
    return block, found.time[keep_rows], angle[keep_rows]


@pytest.mark.parametrize("noise", [0.0, 3e-4])
def test_peaks_of_a_measured_history(noise: float) -> None:
    """Those of Housner's block, and noise of a fiftieth of a degree is no swing."""
    block, time, angle = measured(0.93, noise=noise)
    peaks = measured_peaks(time, angle)
    exact = housner(
        block.shape, gravity=9.81, tilt=block.tilt, end=2.0, step=2e-3, restitution=0.93
    )
    wanted = [block.tilt, *np.abs(exact.peaks)][-len(exact.peaks) - 1 :]
    wanted = list(dict.fromkeys(round(float(w), 12) for w in wanted))
    assert peaks[1:5] == pytest.approx(wanted[1:5], rel=1e-4 + 8 * noise)


def test_a_history_in_degrees(tmp_path: Path) -> None:
    block, time, angle = measured(0.93)
    file = tmp_path / "measured.csv"
    rows = np.column_stack([time, np.degrees(angle)])
    np.savetxt(file, rows, delimiter=";", header="time_s;angle_deg", comments="")
    read_time, read_angle = read_history(file)
    assert np.allclose(read_time, time) and np.allclose(read_angle, angle)
    target = target_of(f"history={file}", parse_scene(SCENE), block, 4)
    assert target.restitution == pytest.approx(0.93, abs=2e-4)
    alpha = block.shape.slenderness()
    kept = 0.93**2 * (math.cos(alpha - block.tilt) - math.cos(alpha))  # Housner 1963
    first = alpha - math.acos(math.cos(alpha) + kept)
    assert len(target.peaks) == 4
    assert target.peaks[0] == pytest.approx(first / block.tilt, rel=1e-4)


@pytest.mark.parametrize(
    ("heading", "unit"),
    [
        ("time s, angle rad (release at 3 deg)", 1.0),
        ("t_s,theta_mrad", 1e-3),
        ("released from 3 deg\ntime,theta_rad", 1.0),
        ("angle in degrees, time in s", math.pi / 180),
        ("t,Angle (°)", math.pi / 180),
        ("time_s,angleDeg", math.pi / 180),
        ("TIME,THETA DEG", math.pi / 180),
        ("graded stone\nt,theta", 1.0),
    ],
)
def test_units_of_a_history(tmp_path: Path, heading: str, unit: float) -> None:
    file = tmp_path / "measured.csv"
    rows = "\n".join(f"{k},{0.1 * k}" for k in range(10))
    file.write_text(f"{heading}\n{rows}\n", encoding="utf-8")
    assert read_history(file)[1][-1] == pytest.approx(0.9 * unit)


@pytest.mark.parametrize(("scale", "refused"), [(1 / 3, True), (2.0, True), (1.03, False)])
def test_a_history_is_of_the_release_of_the_scene(
    tmp_path: Path, scale: float, refused: bool
) -> None:
    """One from another angle falls off in another way, whatever an impact loses."""
    block, time, angle = measured(0.93)
    file = tmp_path / "measured.csv"
    np.savetxt(file, np.column_stack([time, scale * angle]))
    scene = parse_scene(SCENE)
    if not refused:
        assert target_of(f"history={file}", scene, block, 4).peaks
        return
    with pytest.raises(SceneError, match="allowed that of a release from 3 as in the scene"):
        target_of(f"history={file}", scene, block, 4)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,angle\n0,0.05\n1,0.02\n", "2 rows of numbers, allowed 10 or more"),
        ("\n".join(f"{k},0.05" for k in [*range(11), 5]), "line 12: got time 5"),
        ("\n".join(f"{k},{math.cos(k)}" for k in range(11)), "beyond the block's balance"),
    ],
)
def test_files_that_are_no_history(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "measured.csv").write_text(text)
    scene = parse_scene(SCENE)
    with pytest.raises(SceneError, match=r"measured\.csv") as refused:
        target_of(f"history={tmp_path / 'measured.csv'}", scene, scene.blocks[0], 4)
    assert said in str(refused.value)


# --- the search


def model(beta: float) -> float:
    """Restitution as a smooth function of beta_R, much like the demo's."""
    return 0.9285 + 0.018 / (1 + (beta / 3e-5) ** 0.9)


def turning(beta: float) -> float:
    """Restitution that is least between the values of the first three runs."""
    return 0.93 + 0.004 * math.log10(beta / 1e-4) ** 2 - 0.001 * math.log10(beta / 1e-4)


@pytest.mark.parametrize(
    ("law", "high", "wanted", "noise"),
    [
        (model, 1.9e-4, 0.932, 0.0),
        (model, 1.9e-4, 0.936, 0.0),
        (model, 1.9e-4, 0.9435, 0.0),
        (model, 1.9e-4, 0.936, 2e-3),
        (turning, 1e-3, 0.9301, 0.0),  # of two values that meet it the smaller one is taken
        (turning, 1e-3, 0.9338, 0.0),
        (turning, 1e-3, 0.9290, 0.0),  # below the least one
    ],
)
def test_the_search(
    law: Callable[[float], float], high: float, wanted: float, noise: float
) -> None:
    """It comes near in few runs, or as near as the noise lets it; else it knows the reach."""
    random = np.random.default_rng(3)
    search = Search(low=3.7e-6, high=high, wanted=(wanted,), restitution=wanted)
    while values := search.next_values():
        for value in values:
            found = law(value) + noise * float(random.uniform(-1, 1))
            search.tell(Trial(value=value, restitution=found, found=(found,)))
    if wanted == 0.9290:
        assert not search.within_reach and len(search.made) == 3
        return
    assert len(search.made) <= (6 if law is model and not noise else MOST_RUNS)
    assert search.best_error <= max(5e-4, noise)
    assert law is model or search.best.value < 1.4e-4


# --- the commands, with runs that are made up


class MadeUp:
    """Stands in for the runs: Housner's block with the restitution of the model."""

    def __init__(self) -> None:
        self.runs = 0

    def __call__(
        self, function: Any, cases: Sequence[DampingCase], **options: Any
    ) -> Iterator[tuple[DampingCase, dict[str, Any]]]:
        for case in cases:
            self.runs += 1
            yield case, self.outcome(case.scene)

    def outcome(self, scene: Scene) -> dict[str, Any]:
        block, damping = scene.blocks[0], scene.damping
        assert damping is not None
        e = model(damping.stiffness) + 1e-3 * math.log2(scene.blocks[0].cells[0] / 6)
        found = housner(
            block.shape, gravity=9.81, tilt=block.tilt, end=scene.time.end, step=1e-3,
            restitution=e,
        )  # fmt: skip
        peaks = [block.tilt, *(abs(float(peak)) for peak in found.peaks if abs(peak) < block.tilt)]
        return {
            "status": "completed",
            "reason": "",
            "end_s": scene.time.end,
            "mode": "rock",
            "impacts": [{"time_s": at, "restitution": e} for at in found.impacts],
            "peaks": [{"time_s": 0.0, "angle_rad": peak} for peak in peaks],
            "loss_share": {"damping": 0.9, "contact": 0.05, "numerical": 0.05},
            "largest_gain_fraction": 0.0,
            "ledger_error_fraction": 0.0,
            "steps": 1000,
            "rejected_steps": 0,
            "wall_s": 1.0,
            "angle": list(zip(found.time.tolist(), found.angle.tolist(), strict=True)),
        }


@pytest.fixture
def made_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MadeUp:
    """A scene in the current folder, and runs that are made up."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    stand_in = MadeUp()
    monkeypatch.setattr("solver.study.study.finished_cases", stand_in)
    return stand_in


def study(*words: str) -> int:
    return main(["study", "damping", "scene.toml", "-o", "out", *words])


def test_a_sweep_leaves_tables_and_pictures(made_up: MadeUp, capsys: Captured) -> None:
    words = ("--of", "beta=0,1e-5,1e-4", "mesh=1,2,4")
    assert study(*words) == 0
    assert made_up.runs == 6
    left = {file.name for file in Path("out").iterdir()}
    assert left == {
        "cases", "damping.csv", "damping.md", "damping.png", "settings.json", "summary.json",
    }  # fmt: skip
    with Path("out/damping.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["axis"], row["value"]) for row in rows] == [
        ("", ""), ("mesh", "1"), ("mesh", "2"), ("mesh", "4"), ("beta", "0"), ("beta", "1e-05"),
        ("beta", "0.0001"),
    ]  # fmt: skip
    assert float(rows[-1]["restitution"]) == pytest.approx(model(1e-4), abs=2e-5)
    lines = {
        line["axis"]: line for line in json.loads(Path("out/summary.json").read_text())["lines"]
    }
    assert lines["beta"]["limit"] is None
    # Equal differences for each halving do not converge
    assert lines["mesh"]["limit"]["source"] == "scatter"
    said = capsys.readouterr().out
    assert "mesh to infinity: restitution 0.9" in said and "no order of convergence" in said
    assert "written to out" in said
    assert Path("out/damping.md").read_text().count("\n| ") == 9


def test_a_study_that_is_resumed_runs_nothing_twice(made_up: MadeUp, capsys: Captured) -> None:
    """The same axes, other axes with values in common, and a calibration after a sweep."""
    assert study("--of", "beta=3.7e-6,1e-4", "-q") == 0
    assert made_up.runs == 3
    assert study("--of", "beta=3.7e-6,1e-4", "-q", "--resume") == 0
    assert made_up.runs == 3
    assert study("--of", "beta=1e-4,2e-4", "mesh=1,2", "-q", "--resume") == 0
    assert made_up.runs == 5
    assert study("--of", "beta=3.7e-6,1e-4", "--target", "restitution=0.936", "--resume") == 0
    calibrated = made_up.runs - 5
    assert f"after {calibrated + 2} runs" in capsys.readouterr().out


@pytest.mark.parametrize("wanted", [0.932, 0.936, 0.941])
def test_calibration_to_a_restitution(made_up: MadeUp, wanted: float, capsys: Captured) -> None:
    assert study("--target", f"restitution={wanted}") == 0
    assert made_up.runs <= 8
    found = json.loads(Path("out/summary.json").read_text())
    assert found["restitution"] == pytest.approx(wanted, abs=5e-4)
    damping = load_scene("out/calibrated.toml").damping
    assert damping is not None and model(damping.stiffness) == pytest.approx(wanted, abs=6e-4)
    assert load_scene("out/calibrated.toml").time.end == 3.0
    assert {"calibration.csv", "calibration.md", "calibration.png"} <= {
        file.name for file in Path("out").iterdir()
    }
    assert "within reach: 0.9" in capsys.readouterr().out


@pytest.mark.parametrize("own", [False, True])
def test_calibration_to_a_history(made_up: MadeUp, own: bool) -> None:
    """That of a rigid block released to the other side, by another clock; or that of a run."""
    beta, file, again = 2.5e-5, Path("measured.csv"), ["--resume"] * own
    if own:
        assert study("--of", f"beta={beta}", "-q") == 0
        with Path("out/damping.csv").open(encoding="utf-8", newline="") as stream:
            file = Path("out/cases") / f"{list(csv.DictReader(stream))[-1]['case']}.csv"
    else:
        _, time, angle = measured(model(beta))
        np.savetxt(file, np.column_stack([time + 12.0, -angle]))
    assert study("--target", f"history={file}", "-q", *again) == 0
    found = json.loads(Path("out/summary.json").read_text())
    assert found["value"] == pytest.approx(beta, rel=0.05)
    assert found["difference"] < 5e-4 and found["runs"] <= 8


@pytest.mark.parametrize("wanted", [0.90, 0.96])
def test_a_target_out_of_reach_is_refused_with_the_reach(
    made_up: MadeUp, wanted: float, capsys: Captured
) -> None:
    assert study("--target", f"restitution={wanted}", "-q") == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"--target: got {wanted:g}, allowed 0.9314 to 0.9418" in said
    assert "the reach of beta 9.4e-06 to 0.00019" in said
    assert made_up.runs == 3 and not Path("out/calibrated.toml").exists()


def test_too_few_impacts_refuse_a_calibration(made_up: MadeUp, capsys: Captured) -> None:
    assert study("--target", "restitution=0.936", "--set", "time.end=0.6", "-q") == 2
    said = capsys.readouterr().err
    assert "--target is out of reach: beta 9.4e-06 has 2 impacts with a restitution" in said
    assert study("--of", "beta=1e-5", "--set", "time.end=0.6", "--force") == 0
    assert "2 impacts with a restitution by 0.6 s, 4 are wanted" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--of", "beta=1,x"), '--of: got "beta=1,x", allowed NAME or NAME='),
        (("--of", "beta", "beta"), "each name and value once"),
        (("--of", "betta"), '--of: got "betta", allowed step, '),
        (("--block", "other"), '--block: got "other", allowed block'),
        (("--impacts", "0"), "--impacts: got 0, allowed a whole number > 0"),
        (("--set", "block.model=rigid"), "has no meshed block"),
        (("--of", "rho_inf=2"), "time.rho_inf: got 2"),
        (("--target", "restitution=1.2"), '--target: got "restitution=1.2"'),
        (("--target", "history="), '--target: got "history="'),
        (("--target", "history=none.csv"), "none.csv (no such file or directory)"),
        (
            ("--target", "restitution=0.93", "--of", "mesh"),
            "--of: got mesh, allowed beta or contact",
        ),
        (("--target", "restitution=0.93", "--of", "beta=1,2,3"), "allowed beta=LEAST,LARGEST"),
    ],
)
def test_it_refuses(made_up: MadeUp, capsys: Captured, words: tuple[str, ...], said: str) -> None:
    """One line, exit code 2, nothing run, nothing written."""
    assert study(*words) == 2
    line = capsys.readouterr().err
    assert said in line and line.startswith("rockslip: ") and line.count("\n") == 1
    assert made_up.runs == 0 and not Path("out").exists()
