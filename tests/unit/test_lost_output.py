"""Full disks, closed and full streams, two runs in one folder: nothing is lost or mixed."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from processes import outside_mpirun, python
from scenes import GRANITE, SHORT_GRANITE

from rockslip import History, load_scene, simulate
from solver.cli import main
from solver.errors import OutputTrouble, SceneError
from solver.run.folders import hold_folder, release_folder

pytestmark = pytest.mark.serial

COMMAND = f"{sys.executable} -m solver"
GRANITE_TITLE = 'title = "A block of granite"\n'
RIGID = SHORT_GRANITE.replace("[[block]]", '[[block]]\nmodel = "rigid"')


#: The command with files of limited size, once MPI has made those that it needs.
LIMITED = """
import resource, sys
if len(sys.argv) > 3 and sys.argv[2] == "run":
    from mpi4py import MPI
from solver.cli import main
size = int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
sys.exit(main(sys.argv[2:]))
"""


def shell(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """A line of bash in a folder."""
    return subprocess.run(
        ["bash", "-c", line],
        cwd=folder,
        env=outside_mpirun(),
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "scene.toml"
    file.write_text(RIGID)
    return file


@pytest.mark.parametrize("words", ["check scene.toml", "run scene.toml -o out -q"])
def test_a_title_that_a_terminal_does_not_know(tmp_path: Path, words: str) -> None:
    (tmp_path / "scene.toml").write_text(f'title = "Blöcke ☃"\n{RIGID}'.replace(GRANITE_TITLE, ""))
    done = shell(f"PYTHONIOENCODING=ascii {COMMAND} {words}", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    if words.startswith("check"):
        assert "Bl\\xf6cke \\u2603" in done.stdout


class TestFullDisk:
    """Files may not grow beyond a limit, as on a disk without space."""

    def limited(self, folder: Path, blocks: int, words: str, ranks: int = 1) -> str:
        """Run with files of so many KB; returns the one line that is said."""
        size = str(blocks * 1024)
        done = python("-c", LIMITED, size, *words.split(), ranks=ranks, folder=folder)
        assert done.returncode == 4, done.stderr
        assert "Traceback" not in done.stderr
        said = [line for line in done.stderr.splitlines() if line.startswith("rockslip: ")]
        assert len(said) == 1, done.stderr
        return said[0]

    @pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
    def test_a_rigid_run_keeps_what_fits(self, scene: Path, ranks: int) -> None:
        words = "run scene.toml -o out -q --set output.fields=none"
        line = self.limited(scene.parent, 100, words, ranks)
        history = History.read(scene.parent / "out" / "history.csv")
        assert 50 < len(history) < 301
        end = history["time_s"][-1]
        assert line == f"rockslip: history.csv: file too large, written up to t = {end:.6g} s"
        assert (scene.parent / "out" / "history.csv").read_text().endswith("\n")
        assert "file too large" in (scene.parent / "out" / "run.log").read_text()
        if ranks == 1:
            whole = simulate(load_scene(scene)).history["block.angle_rad"]
            np.testing.assert_allclose(history["block.angle_rad"], whole[: len(history)], 1e-9)

    @pytest.mark.slow
    @pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
    def test_so_does_a_meshed_one(self, tmp_path: Path, ranks: int) -> None:
        pytest.importorskip("dolfinx")
        text = GRANITE + "[time]\nend = 0.3\nstep = 0.001\n[output]\nevery = 0.02\n"
        (tmp_path / "scene.toml").write_text(text)
        line = self.limited(tmp_path, 100, "run scene.toml -o out -q", ranks)
        history = History.read(tmp_path / "out" / "history.csv")
        end = history["time_s"][-1]
        assert 0.02 < end < 0.3
        assert line == f"rockslip: history.csv: file too large, written up to t = {end:.6g} s"
        assert main(["plot", str(tmp_path / "out"), "-o", str(tmp_path / "pictures")]) == 0

    @pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.mpi)])
    def test_so_do_pieces_of_the_fields(self, tmp_path: Path, ranks: int) -> None:
        """Pieces without room are not listed."""
        pytest.importorskip("dolfinx")
        text = GRANITE + "[time]\nend = 0.03\nstep = 0.001\n[output]\nevery = 0.01\n"
        (tmp_path / "scene.toml").write_text(text)
        line = self.limited(tmp_path, 10, "run scene.toml -o out -q", ranks)
        piece = "rockslip: fields_block000000.vtu: file too large"
        assert line == f"{piece}, written up to t = 0 s"
        assert b'name="block"' not in (tmp_path / "out" / "fields.pvd").read_bytes()

    def test_the_reference_says_it_too(self, scene: Path) -> None:
        line = self.limited(scene.parent, 10, "reference scene.toml -o out -q")
        assert line.startswith("rockslip: history.csv: file too large")

    def test_in_python_it_is_an_error(self, scene: Path) -> None:
        folder = scene.parent / "out"
        folder.mkdir()
        (folder / "history.csv").symlink_to("/dev/full")
        with pytest.raises(OutputTrouble, match=r"^history\.csv: no space left$"):
            simulate(load_scene(scene), folder=folder)

    def test_a_summary_without_room_leaves_none_by_halves(self, scene: Path) -> None:
        folder = scene.parent / "out"
        folder.mkdir()
        (folder / "summary.json.part").symlink_to("/dev/full")
        with pytest.raises(OutputTrouble, match=r"^summary\.json: no space left, .* t = 0\.3 s$"):
            simulate(load_scene(scene), folder=folder)
        assert not (folder / "summary.json").exists()
        assert len(History.read(folder / "history.csv")) == 301


class TestStreams:
    """Standard output and error are closed, or full."""

    @pytest.mark.parametrize(
        ("words", "ending", "code"),
        [
            ("check scene.toml", "| true", 0),
            ("check scene.toml", ">&-", 0),
            ("check scene.toml", "> /dev/full", 4),
            ("--help", "> /dev/full", 0),
            ("--help", "| true", 0),
            ("run scene.toml --force -o out", "| true", 0),
            ("run scene.toml --force -o out", "> /dev/full", 0),
            ("run scene.toml --force -o out", ">&-", 0),
            ("run scene.toml --force -o out", "2> /dev/full > /dev/null", 0),
            ("run scene.toml --force -o out", "2>&- > /dev/null", 0),
            ("reference scene.toml --force -o out", "> /dev/full", 0),
        ],
    )
    def test_they_end_quietly(self, scene: Path, words: str, ending: str, code: int) -> None:
        done = shell(f"set -o pipefail; {COMMAND} {words} {ending}", scene.parent)
        said = [line for line in done.stderr.splitlines() if not line.startswith("t ")]
        assert said == []
        assert done.returncode == code
        if "run" in words:
            assert len(History.read(scene.parent / "out" / "history.csv")) == 301
            assert (scene.parent / "out" / "summary.json").is_file()

    @pytest.mark.slow
    def test_so_does_a_meshed_run(self, tmp_path: Path) -> None:
        """PETSc takes SIGPIPE for an error of its own, and would abort."""
        pytest.importorskip("dolfinx")
        (tmp_path / "meshed.toml").write_text(SHORT_GRANITE)
        done = shell(f"set -o pipefail; {COMMAND} run meshed.toml -o out | true", tmp_path)
        assert [line for line in done.stderr.splitlines() if not line.startswith("t ")] == []
        assert done.returncode == 0
        assert (tmp_path / "out" / "summary.json").is_file()


class TestLock:
    """One run at a time in a folder."""

    def test_a_second_run_is_refused_and_touches_nothing(self, scene: Path) -> None:
        folder = scene.parent / "out"
        hold_folder(folder)
        (folder / "history.csv").write_text("mine")
        for command in ("run", "reference"):
            done = shell(f"{COMMAND} {command} scene.toml -o out --force", scene.parent)
            assert done.returncode == 2
            allowed = "allowed another folder, or after its end"
            assert done.stderr == (
                f"rockslip: -o: got out, which another run is writing, {allowed}\n"
            )
        assert (folder / "history.csv").read_text() == "mine"
        assert {file.name for file in folder.iterdir()} == {"history.csv"}
        release_folder(folder)
        done = shell(f"{COMMAND} run scene.toml -o out --force -q", scene.parent)
        assert done.returncode == 0, done.stderr

    def test_two_at_once_are_one(self, scene: Path) -> None:
        """Begun together, one writes and the other is refused, or comes after it."""
        line = f"{COMMAND} run scene.toml -o out --force -q --set time.end=2 time.step=1e-4"
        done = shell(f"{line} & {line}; a=$?; wait $!; echo $a $?", scene.parent)
        assert sorted(done.stdout.split()) in (["0", "2"], ["0", "0"]), done.stderr
        times = History.read(scene.parent / "out" / "history.csv")["time_s"]
        assert len(times) == 20001
        assert (np.diff(times) > 0).all()

    def test_in_python_too(self, scene: Path) -> None:
        """The lock ends with the run, and is no matter of a process with itself."""
        folder = scene.parent / "out"
        held = "from pathlib import Path; from solver.run.folders import hold_folder"
        held += f"; hold_folder(Path('{folder}'))"
        with subprocess.Popen(
            [sys.executable, "-c", f"{held}; print(1, flush=True); input()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as other:
            assert other.stdout is not None
            assert other.stdout.readline() == "1\n"
            with pytest.raises(SceneError, match="which another run is writing"):
                simulate(load_scene(scene), folder=folder)
            other.communicate("\n")
        simulate(load_scene(scene), folder=folder)
        simulate(load_scene(scene), folder=folder)
        assert json.loads((folder / "summary.json").read_text())["status"] == "completed"


@pytest.mark.mpi
def test_under_mpirun_the_folder_is_named_at_the_start(scene: Path) -> None:
    """Since what ranks say once mpirun was interrupted is not passed on."""
    pytest.importorskip("mpi4py")
    done = shell(f"mpirun -n 2 {COMMAND} run scene.toml -o out", scene.parent)
    assert done.returncode == 0, done.stderr
    assert "writing to out" in done.stderr
