"""`rockslip run` for real, in processes of its own: refusals, signals, options for PETSc."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from processes import outside_mpirun, python
from scenes import GRANITE

from rockslip import History, read_run
from solver.cli import main

SCENE = GRANITE + "[time]\nend = 0.03\nstep = 0.001\n[output]\nevery = 0.01\n"

COMMAND = [sys.executable, "-m", "solver"]
REPOSITORY = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.serial


def rockslip(folder: Path, *words: str, ranks: int = 1) -> subprocess.CompletedProcess[str]:
    """The command, run in a folder."""
    return python("-m", "solver", *words, ranks=ranks, folder=folder)


def fingerprint(folder: Path) -> dict[str, str]:
    """Every file below a folder, its content and the time it was written."""
    return {
        str(file.relative_to(folder)): f"{hash(file.read_bytes())} {file.stat().st_mtime_ns}"
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def summary_of(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return found


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a scene and a finished run of it in `granite.out`."""
    for package in ("dolfinx", "gmsh"):
        pytest.importorskip(package)
    folder = tmp_path_factory.mktemp("earlier")
    (folder / "granite.toml").write_text(SCENE)
    done = rockslip(folder, "run", "granite.toml")
    assert done.returncode == 0, done.stderr
    assert "completed at t = 0.03 s" in done.stdout
    return folder


REFUSED: dict[str, tuple[str, str, list[str]]] = {
    "unknown key": (
        SCENE.replace("width", "widht"),
        "",
        ["block.widht", "unknown key", "did you mean 'width'?", "height"],
    ),
    "missing file": (
        f"{SCENE}[motion]\nkind = 'table'\nfile = 'absent.csv'\n",
        "",
        ["motion.file", "absent.csv", "a file that exists"],
    ),
    "unreadable TOML": (f"{SCENE}[[block\n", "", ["bad.toml", "unreadable TOML", "line 18"]),
    "no text": ("\x00\x01", "", ["bad.toml", "unreadable TOML"]),
    "empty scene": ("", "", ["bad.toml", "an empty scene", "[[block]]"]),
    "override": (SCENE, "time.end=1e-4", ["time.step", "step <= end"]),
}
"""Text of a scene, an override, and the words of the refusal; all words: refusals.txt."""


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_one_line_and_touches_nothing(
    earlier: Path, case: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not even with --force is anything of an earlier run removed before the input is good."""
    text, override, parts = REFUSED[case]
    bad = earlier / "bad.toml"
    bad.write_text(text)
    before = fingerprint(earlier)
    words = ["--set", override] if override else []
    monkeypatch.chdir(earlier)
    assert main(["run", "bad.toml", "-o", "granite.out", "--force", *words]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("rockslip: ")
    assert said.err.count("\n") == 1
    for part in parts:
        assert part in said.err
    assert fingerprint(earlier) == before


@pytest.mark.mpi
def test_a_bad_key_on_two_ranks_is_one_line(earlier: Path) -> None:
    """All ranks leave with exit code 2, one of them speaks, an earlier run stays as it was."""
    bad = earlier / "bad.toml"
    bad.write_text(SCENE.replace("tilt_deg", "tilt_dge"))
    before = fingerprint(earlier)
    done = rockslip(earlier, "run", "bad.toml", "-o", "granite.out", "--force", ranks=2)
    assert done.returncode == 2
    ours = [line for line in done.stderr.splitlines() if "rockslip" in line or "block." in line]
    assert len(ours) == 1
    assert "block.tilt_dge: unknown key, did you mean 'tilt_deg'?" in ours[0]
    assert "Traceback" not in done.stderr
    assert fingerprint(earlier) == before


def mpirun_kills() -> bool:
    """True if mpirun answers Ctrl-C and SIGTERM with SIGKILL for its ranks, and nothing before.

    Seen by strace with Open MPI 6.0.0rc2 (PRRTE 5.0.0rc1), which has no option for it.
    """
    said = subprocess.run(["mpirun", "--version"], capture_output=True, text=True, check=True)
    return "(Open MPI) 6." in said.stdout


def interrupted(folder: Path, number: signal.Signals, ranks: int = 1) -> Path:
    """Start a long run, send it a signal once it is under way; returns what it left."""
    launcher = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    words = ["run", "granite.toml", "-o", "out", "--set", "time.end=600.0"]
    process = subprocess.Popen(
        [*launcher, *COMMAND, *words],
        cwd=folder,
        # Open MPI 5 kills after a second, which is short where others share the machine.
        env=outside_mpirun() | {"PRTE_MCA_odls_base_sigkill_timeout": "30"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    history = folder / "out" / "history.csv"
    try:
        deadline = time.monotonic() + 120
        while not history.is_file() or history.read_text().count("\n") < 160:
            assert process.poll() is None, process.communicate()[1]
            assert time.monotonic() < deadline, "the run did not get under way"
            time.sleep(0.02)
        process.send_signal(number)
        out, err = process.communicate(timeout=120)
    finally:
        process.kill()
    if ranks == 1:
        assert process.returncode == 130, err
        assert out.startswith("interrupted at t = ")
    assert "Traceback" not in err
    return folder / "out"


@pytest.mark.mpi
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_whose_ranks_were_killed_can_be_read(tmp_path: Path, number: signal.Signals) -> None:
    """By the mpirun of Open MPI 6: all rows up to the last snapshot, and a summary made of them."""
    pytest.importorskip("dolfinx")
    pyvista = pytest.importorskip("pyvista")
    if not mpirun_kills():
        pytest.skip("this mpirun hands the signal on: test_an_interrupted_run_leaves_all_it_has")
    (tmp_path / "granite.toml").write_text(SCENE)
    folder = interrupted(tmp_path, number, ranks=2)
    assert not (folder / "summary.json").exists()
    run = read_run(folder)
    assert run.summary["status"] == "unfinished"
    assert "made from the history" in run.summary["reason"]
    times = run.history["time_s"]
    assert times == pytest.approx(1e-3 * np.arange(len(times)), abs=1e-12)
    assert len(times) >= 150  # what the signal waited for
    assert run.summary["end_s"] == times[-1]
    reader = pyvista.get_reader(str(folder / "fields.pvd"))
    assert abs(times[-1] - reader.time_values[-1]) < 0.0101
    done = rockslip(tmp_path, "plot", "out")
    assert done.returncode == 0, done.stderr
    assert f"no summary.json, made from the history up to t = {times[-1]:.6g} s" in done.stderr
    assert (folder / "angle.png").is_file()


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("number", "ranks"),
    [(signal.SIGINT, 1), (signal.SIGTERM, 2), (signal.SIGUSR1, 2)],
)
def test_an_interrupted_run_leaves_all_it_has(
    tmp_path: Path, number: signal.Signals, ranks: int
) -> None:
    pytest.importorskip("dolfinx")
    pyvista = pytest.importorskip("pyvista")
    if ranks > 1 and number == signal.SIGTERM and mpirun_kills():
        pytest.skip("this mpirun kills its ranks where it should hand SIGTERM on")
    (tmp_path / "granite.toml").write_text(SCENE)
    folder = interrupted(tmp_path, number, ranks)
    summary = summary_of(folder)
    assert summary["status"] == "interrupted"
    assert "t = " in summary["reason"]
    if ranks == 1:
        assert number.name in summary["reason"]
    # every row is there, up to the last step that was made
    history = History.read(folder / "history.csv")
    count = len(history)
    assert count >= 59
    assert history["time_s"] == pytest.approx(1e-3 * np.arange(count), abs=1e-12)
    assert summary["end_s"] == history["time_s"][-1]
    assert summary["cost"]["steps"] == count - 1
    assert all(np.isfinite(history[name]).all() for name in history.columns)
    # so are the fields, to within one interval of output
    reader = pyvista.get_reader(str(folder / "fields.pvd"))
    times = np.array(reader.time_values)
    assert times[:3] == pytest.approx([0.0, 0.01, 0.02])
    assert 0 <= summary["end_s"] - times[-1] < 0.0101
    reader.set_active_time_value(times[-1])
    grid = reader.read().combine()
    assert np.isfinite(grid.point_data["displacement"]).all()
    # the far top corner is a diagonal of the block away from the one it stands on
    # (whichever way it leans, and however upright the signal found it)
    shown = np.searchsorted(history["time_s"], times[-1] - 1e-9)
    angle = history["block.angle_rad"][shown]
    lift = np.linalg.norm(grid.point_data["displacement"], axis=1).max()
    assert lift == pytest.approx(math.hypot(0.25, 1.0) * abs(angle), rel=0.02, abs=1e-3)
    assert (folder / "open_in_paraview.py").is_file()
    assert "interrupted" in (folder / "run.log").read_text()


@pytest.mark.slow
def test_options_after_two_dashes_reach_snes(tmp_path: Path) -> None:
    pytest.importorskip("dolfinx")
    (tmp_path / "granite.toml").write_text(SCENE)
    words = ["run", "granite.toml", "-q", "--set", "time.end=0.003", "--"]
    done = rockslip(tmp_path, *words, "-rockslip_snes_monitor")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("0 SNES Function norm") == 3  # one for each step


@pytest.mark.slow
def test_a_run_that_cannot_converge_says_where(tmp_path: Path) -> None:
    """One iteration is too few, and one halving all there is: exit code 3, the rest stays."""
    pytest.importorskip("dolfinx")
    (tmp_path / "granite.toml").write_text(SCENE)
    span = ["time.end=0.3", "time.smallest=0.0005"]
    words = ["run", "granite.toml", "-o", "out", "--set", *span, "--"]
    done = rockslip(tmp_path, *words, "-rockslip_snes_max_it", "1")
    assert done.returncode == 3, done.stderr
    assert done.stdout.startswith("not converged at t = ")
    summary = summary_of(tmp_path / "out")
    assert summary["status"] == "not converged"
    end = summary["end_s"]
    assert f"at t = {end:.6g} s with a step of 0.0005 s" in summary["reason"]
    assert "largest number of iterations" in summary["reason"]
    assert summary["cost"]["rejected_steps"] == 2
    history = History.read(tmp_path / "out" / "history.csv")
    assert history["time_s"][-1] == end
    log = (tmp_path / "out" / "run.log").read_text()
    assert log.count("rejected") == 2
    assert "Traceback" not in done.stderr


def test_a_rigid_scene_pays_for_what_it_has(tmp_path: Path) -> None:
    """No MPI on one process, nothing for meshes, no compiler."""
    (tmp_path / "granite.toml").write_text(SCENE.replace("[[block]]", '[[block]]\nmodel = "rigid"'))
    script = """
import sys
from solver.cli import main
code = main()
heavy = {"dolfinx", "gmsh", "mpi4py", "petsc4py", "pyvista", "scipy.linalg", "ufl"}
print(code, *sorted(heavy & set(sys.modules)))
"""
    words = "run", "granite.toml", "--set", "time.end=0.04"
    done = python("-c", script, *words, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].split() == ["0"]
