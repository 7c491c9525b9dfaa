"""The command: what it says, what it refuses, and that nothing is written over."""

from __future__ import annotations

import json
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import pytest
from processes import outside_mpirun
from scenes import SHORT_GRANITE

from rockslip import load_scene, read_run, simulate
from solver.cli import main
from solver.errors import NotConverged, SceneError
from solver.run.folders import LEFT_BEHIND

HEAVY = ("dolfinx", "gmsh", "matplotlib", "mpi4py", "petsc4py", "pyvista")

Captured = pytest.CaptureFixture[str]


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """`rockslip run` with a solver that does nothing but remember what it was asked."""
    remembered: list[dict[str, Any]] = []
    summary = {"end_s": 0.3, "reason": "", "blocks": {}, "energy": {}, "cost": {}}

    def simulate(scene: Any, **options: Any) -> Any:
        status = scene.title if scene.title in ("interrupted", "not converged") else "completed"
        if scene.title == "raises":
            raise NotConverged("static start: no equilibrium")
        remembered.append({"scene": scene, **options})
        (options["folder"] / "history.csv").write_text("new")
        return types.SimpleNamespace(status=status, summary=summary | {"status": status})

    module: Any = types.ModuleType("solver.run.simulate")
    module.simulate = simulate
    monkeypatch.setitem(sys.modules, "solver.run.simulate", module)
    return remembered


def refused(arguments: list[str], captured: Captured) -> str:
    """The one line of a refusal with exit code 2."""
    try:
        code = main(arguments)
    except SystemExit as stop:
        code = int(str(stop.code))
    output = captured.readouterr()
    assert code == 2
    assert output.out == ""
    assert output.err.startswith("rockslip: ")
    assert output.err.count("\n") == 1
    return output.err


def test_without_arguments_it_helps(granite: Path, capsys: Captured) -> None:
    assert main([]) == 0
    text = capsys.readouterr().out
    for word in ("run", "check", "reference", "plot", "info", "Exit codes"):
        assert word in text


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["check", "absent.toml"], ["absent.toml"]),
        (["check", "granite.toml", "--set", "block.widht=1"], ["block.widht", "'width'"]),
        (["run"], ["SCENE", "rockslip run --help"]),
        (["walk"], ["walk", "run"]),
        (["runn", "granite.toml"], ["did you mean 'run'?"]),
        (["study", "suit"], ["did you mean 'suite'?", "rockslip study --help"]),
        (["run", "granite.toml", "--outptu", "x"], ["no option --outptu, did you mean '--output'"]),
        (["check", "granite.toml", "--zzz"], ["no option --zzz (see rockslip check --help)"]),
        (["check", "granite.toml", "--", "-x"], ["rockslip run"]),
        (["plot", "nowhere"], ["nowhere", "scene.toml"]),
        (["reference", "granite.toml", "-o", "."], ["granite.toml", "not empty"]),
        (["reference", "granite.toml", "--set", "dimension=3"], ["dimension", "reference"]),
    ],
)
def test_bad_input_is_one_line(
    granite: Path, capsys: Captured, arguments: list[str], parts: list[str]
) -> None:
    if arguments[0] == "run":
        pytest.importorskip("mpi4py")
    line = refused(arguments, capsys)
    for part in parts[-1:] if arguments[-1] == "." else parts:
        assert part in line
    assert list(granite.parent.iterdir()) == [granite]


def test_reference_and_its_folder(granite: Path, capsys: Captured) -> None:
    assert main(["reference", "granite.toml"]) == 0
    text = capsys.readouterr().out
    assert "Housner 1963" in text
    assert "1 impact at 0.1916 s" in text
    folder = granite.parent / "granite.rigid"
    names = {file.name for file in folder.iterdir()}
    assert names == {"history.csv", "events.csv", "scene.toml", "summary.json"}
    # what it wrote is a scene that means the same
    before = (folder / "history.csv").read_text()
    assert main(["reference", "granite.rigid/scene.toml", "-o", "again", "-q"]) == 0
    assert capsys.readouterr().out == ""
    assert (granite.parent / "again" / "history.csv").read_text() == before


def test_an_earlier_run_is_kept_unless_forced(granite: Path, capsys: Captured) -> None:
    assert main(["reference", "granite.toml", "-q"]) == 0
    folder = granite.parent / "granite.rigid"
    stamp = (folder / "history.csv").read_text()
    mine = folder / "notes.txt"
    mine.write_text("mine")
    (folder / "fields_p0_000001.vtu").write_text("stale")
    for draft in ("fields.vtkhdf", "film.part.mp4", "report.html.part"):
        (folder / draft).write_text("stale")
    other = ["reference", "granite.toml", "-q", "--set", "block.tilt_deg=2"]
    assert "not empty" in refused(other, capsys)
    assert (folder / "history.csv").read_text() == stamp
    assert main([*other, "--force"]) == 0
    assert (folder / "history.csv").read_text() != stamp
    assert mine.read_text() == "mine"
    assert not (folder / "fields_p0_000001.vtu").exists()
    names = {file.name for file in folder.iterdir()}
    assert names == {"history.csv", "events.csv", "scene.toml", "summary.json", "notes.txt"}


def test_a_scene_is_never_written_over(granite: Path, capsys: Captured) -> None:
    folder = granite.parent / "here"
    folder.mkdir()
    own = folder / "scene.toml"
    own.write_text(SHORT_GRANITE)
    line = refused(["reference", str(own), "-o", "here", "--force"], capsys)
    assert "holds the scene itself" in line
    assert own.read_text() == SHORT_GRANITE


def test_a_folder_that_cannot_be_made(granite: Path, capsys: Captured) -> None:
    line = refused(["reference", "granite.toml", "-o", "granite.toml/below"], capsys)
    got = "granite.toml/below (not a directory)"
    assert line == f"rockslip: -o: got {got}, allowed a folder that can be written\n"


@pytest.mark.serial
class TestRun:
    """`rockslip run`, its solver replaced."""

    @pytest.fixture(autouse=True)
    def with_mpi(self) -> None:
        pytest.importorskip("mpi4py")

    def test_what_the_solver_is_asked(
        self, granite: Path, calls: list[dict[str, Any]], capsys: Captured
    ) -> None:
        words = ["run", "granite.toml", "--set", "block.height=1.2", "-q", "--"]
        assert main([*words, "-rockslip_snes_monitor", "-rockslip_snes_rtol", "1e-9"]) == 0
        assert calls[0]["scene"].blocks[0].height == 1.2
        assert calls[0]["folder"] == Path("granite.out")
        assert calls[0]["log"] is None
        output = capsys.readouterr()
        assert output.out == output.err == ""

    def test_what_it_says_at_the_end(
        self, granite: Path, calls: list[dict[str, Any]], capsys: Captured
    ) -> None:
        assert main(["run", "granite.toml", "-o", "there", "-v"]) == 0
        assert "rockslip plot there" in capsys.readouterr().out
        calls[0]["log"]("a line")
        assert capsys.readouterr().err == "a line\n"

    @pytest.mark.parametrize(
        ("title", "code"), [("interrupted", 130), ("not converged", 3), ("raises", 3)]
    )
    def test_exit_codes(
        self, granite: Path, calls: list[dict[str, Any]], capsys: Captured, title: str, code: int
    ) -> None:
        assert main(["run", "granite.toml", "--set", f"title='{title}'"]) == code
        output = capsys.readouterr()
        if title == "raises":
            assert output.err == "rockslip: static start: no equilibrium\n"
        else:
            assert title in output.out

    @pytest.mark.parametrize("missing", ["solver.run.simulate", "dolfinx"])
    def test_what_cannot_be_imported_is_said_before_anything_is_written(
        self, granite: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured, missing: str
    ) -> None:
        monkeypatch.setitem(sys.modules, missing, None)
        assert main(["run", "granite.toml"]) == 4
        assert "in-env" in capsys.readouterr().err
        assert list(granite.parent.iterdir()) == [granite]


def test_light_commands_import_nothing_heavy(granite: Path) -> None:
    """Neither `check` of rigid blocks nor `reference` waits for dolfinx."""
    rigid = "'check', 'granite.toml', '--set', 'block.model=\"rigid\"'"
    for words in (rigid, "'reference', 'granite.toml', '-q'"):
        code = (
            f"import sys; from solver.cli import main; main([{words}]);"
            f" sys.exit(' '.join(set({HEAVY}) & set(sys.modules)))"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert done.stderr.strip() == ""


def test_other_ranks_keep_silent(
    granite: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "1")
    assert main(["check", "granite.toml"]) == 0
    assert main(["reference", "granite.toml"]) == 0
    assert main([]) == 0
    with pytest.raises(SystemExit):
        main(["walk"])
    output = capsys.readouterr()
    assert output.out == output.err == ""
    assert list(granite.parent.iterdir()) == [granite]


def test_info_names_what_matters(capsys: Captured) -> None:
    for package in ("dolfinx", "gmsh", "petsc4py"):
        pytest.importorskip(package)
    assert main(["info"]) == 0
    text = capsys.readouterr().out
    for word in ("dolfinx", "petsc", "ranks", "mumps", "BLAS", "openblas"):
        assert word in text


def test_blas_is_read_from_the_loaded_files(tmp_path: Path) -> None:
    from solver.info import blas_libraries

    maps = tmp_path / "maps"
    maps.write_text(
        "7f00-7f01 r-xp 00000000 08:01 1  /usr/lib/blas/libblas.so.3\n"
        "7f01-7f02 r--p 00000000 08:01 1  /usr/lib/blas/libblas.so.3\n"
        "7f02-7f03 rw-p 00000000 00:00 0 \n"
        "7f03-7f04 r-xp 00000000 08:01 2  /usr/lib/libc.so.6\n"
    )
    assert blas_libraries(maps) == ["/usr/lib/blas/libblas.so.3"]
    assert blas_libraries(tmp_path / "absent") == []


def test_files_that_a_new_run_removes_are_those_that_runs_leave() -> None:
    """A scene.toml is written over, not removed; folders of fields of any number of ranks go."""
    assert "scene.toml" not in LEFT_BEHIND
    names = ("fields000001.pvtu", "fields_p2_000001.vtu", "history.csv", "angle.png")
    names += ("fields/fields_block_p2_000001.vtu", "film.gif", "report.html", "energy.svg")
    for name in names:
        assert any(Path(name).match(pattern) for pattern in LEFT_BEHIND)


@pytest.mark.serial
def test_a_dash_reads_the_standard_input(granite: Path) -> None:
    """Files are named after "scene"; with mpirun, rank 0 reads."""
    text = granite.read_text().replace("[[block]]", '[[block]]\nmodel = "rigid"')
    for words, left in (
        ("check -", None),
        ("reference - -q", "scene.rigid"),
        ("run - -q", "scene.out"),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "solver", *words.split()],
            input=text,
            env=outside_mpirun(),
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert done.returncode == 0, done.stderr
        assert left is None or (granite.parent / left / "history.csv").is_file()
    command = [sys.executable, "-m", "solver", "check", "-"]
    for wrong, said in (("", "standard input: got an empty scene"), ("[[", "standard input: got")):
        done = subprocess.run(
            command, input=wrong, env=outside_mpirun(), capture_output=True, text=True
        )
        assert done.returncode == 2
        assert said in done.stderr


def test_steps_that_see_nothing_are_warned_of(granite: Path, capsys: Captured) -> None:
    """By every command, with what others would cost."""
    blind = ["granite.toml", "--set", "block.model=rigid", "time.step=0.1"]
    said = (
        "steps of 0.1 s, 1.9 in the 0.191 s of a swing of block, do not see it: "
        "time.step = 0.01 does, in 30 steps instead of 3"
    )
    assert main(["check", *blind]) == 0
    assert said in capsys.readouterr().out
    assert main(["run", *blind, "-o", "out"]) == 0
    output = capsys.readouterr()
    assert f"caution: {said}\n" in output.err
    assert said in output.out
    summary = json.loads((granite.parent / "out" / "summary.json").read_text())
    assert said in summary["cautions"]
    assert said in (granite.parent / "out" / "run.log").read_text()
    assert main(["check", "granite.toml", "--set", "block.model=rigid"]) == 0
    assert "do not see" not in capsys.readouterr().out


class TestPlot:
    """Pictures of what a run left, whatever came of it."""

    @pytest.fixture
    def run(self, granite: Path, capsys: Captured) -> Path:
        pytest.importorskip("matplotlib")
        assert main(["reference", "granite.toml", "-q", "-o", "done"]) == 0
        return granite.parent / "done"

    def test_a_killed_run_has_its_summary_made(self, run: Path, capsys: Captured) -> None:
        """Its last line may be half a line."""
        summary = json.loads((run / "summary.json").read_text())
        (run / "summary.json").unlink()
        with (run / "history.csv").open("a") as stream:
            stream.write("0.30")
        assert main(["plot", str(run)]) == 0
        output = capsys.readouterr()
        assert output.err == f"{run}: no summary.json, made from the history up to t = 0.3 s\n"
        assert (run / "angle.png").is_file()
        made = read_run(run).summary
        assert made["status"] == "unfinished"
        (again,), (whole,) = (one["blocks"].values() for one in (made, summary))
        impacts = zip(again.pop("impacts"), whole.pop("impacts"), strict=True)
        for one, other in impacts:  # of the digits of the file
            assert one == pytest.approx(other, rel=1e-5)
        assert json.loads(json.dumps(again)) == whole
        assert not (run / "summary.json").exists()

    def test_broken_files_are_one_line(self, run: Path, capsys: Captured) -> None:
        for text in ("", "{", "[]", "\0", "{}", '{"model": "x"}', "[" * 100_000):
            (run / "summary.json").write_text(text)
            assert "summary.json" in refused(["plot", str(run)], capsys)
        (run / "history.csv").write_text("time_s,a\n0,1\n1,2\n")
        assert "no column step_s" in refused(["plot", str(run)], capsys)

    def test_the_folder_of_the_pictures_is_made(self, run: Path, capsys: Captured) -> None:
        new = run.parent / "new" / "pictures"
        assert main(["plot", str(run), "-o", str(new)]) == 0
        assert (new / "angle.png").is_file() and not (run / "angle.png").exists()
        assert main(["plot", str(run), str(run), "-o", str(new.parent)]) == 0
        assert (new.parent / "overlay.png").is_file()
        capsys.readouterr()
        assert "-o: got" in refused(["plot", str(run), "-o", str(run / "scene.toml")], capsys)


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "granite.toml", "-o", "{hidden}"],
        ["run", "granite.toml", "-o", "link"],
        ["run", "{hidden}/scene.toml"],
        ["plot", "{hidden}"],
        ["plot", "granite.rigid", "granite.rigid", "-o", "{hidden}"],
        ["study", "suite", "granite.toml", "-o", "{hidden}"],
    ],
)
def test_folders_that_in_env_does_not_show_are_refused(
    granite: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    """Files written there would be gone when the command ends."""
    if arguments[0] in ("run", "study"):
        pytest.importorskip("mpi4py")
    shown, hidden = granite.parent, granite.parent.parent / "hidden"
    assert main(["reference", "granite.toml", "-q"]) == 0
    (shown / "link").symlink_to(hidden)
    monkeypatch.setenv("ROCKSLIP_VISIBLE", f"/nowhere:{shown}")
    line = refused([word.format(hidden=hidden) for word in arguments], capsys)
    assert f"{hidden}" in line or "link" in line
    assert f"ROCKSLIP_MOUNT={hidden.parent}" in line or "hidden/scene.toml" in line
    assert not hidden.exists()


def test_so_is_a_folder_of_the_python_interface(
    granite: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """That of the demos, too, which call it."""
    monkeypatch.setenv("ROCKSLIP_VISIBLE", str(granite.parent))
    scene = load_scene(granite, ['block.model="rigid"'])
    with pytest.raises(SceneError, match="ROCKSLIP_MOUNT"):
        simulate(scene, folder=granite.parent.parent / "hidden")
    assert main(["reference", "granite.toml", "-o", "shown", "-q"]) == 0
