"""The interface for callers from Python: names, errors, folders that are in use."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import rockslip
from rockslip import History, RockslipError, SceneError, load_scene, parse_scene, read_run, simulate
from solver.errors import Statement
from solver.results.runs import labels

SCENE = """
[[block]]
name = "block"
model = "rigid"
width = 0.25
height = 1.0
mass = 500.0
tilt_deg = {tilt}
# a comment
[time]
end = {end}
step = 1e-3
[output]
every = 0.01
twin = {twin}
"""


def text(tilt: float = 3.0, end: float = 0.05, twin: str = "false") -> str:
    return SCENE.format(tilt=tilt, end=end, twin=twin)


def test_all_public_names_are_there() -> None:
    assert set(dir(rockslip)) == set(rockslip.__all__)
    assert all(getattr(rockslip, name) for name in rockslip.__all__)
    assert issubclass(SceneError, RockslipError)


def test_a_folder_is_named_by_a_text_and_used_again(tmp_path: Path) -> None:
    """Nothing of the longer run before is left."""
    folder = str(tmp_path / "out")
    simulate(parse_scene(text(end=0.05)), folder=folder)
    (tmp_path / "out" / "notes.txt").write_text("mine")
    simulate(parse_scene(text(end=0.02)), folder=folder)
    run = read_run(folder)
    assert run.history["time_s"][-1] == pytest.approx(0.02)
    # of the block and of the forces on it
    assert len(list((tmp_path / "out" / "fields").glob("*.vtu"))) == 2 * 3
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


def test_a_scene_that_no_run_has_left_is_not_written_over(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(text())
    for _ in range(2):  # also when the cell of a notebook is run again
        with pytest.raises(SceneError, match="which holds a scene of its own, allowed another"):
            simulate(load_scene(file), folder=tmp_path)
    assert "# a comment" in file.read_text()
    assert [file.name for file in tmp_path.iterdir()] == ["scene.toml"]


def test_options_that_petsc_does_not_take_leave_an_earlier_run_as_it_was(tmp_path: Path) -> None:
    simulate(parse_scene(text()), folder=tmp_path)
    before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    with pytest.raises(RockslipError, match="snes_max_it five"):
        scene = parse_scene(text(end=0.02))
        simulate(scene, folder=tmp_path, petsc_options=("-rockslip_snes_max_it", "five"))
    assert {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()} == before


@pytest.mark.parametrize("scene", ["scene.toml", None, {"block": []}])
def test_what_is_no_scene_is_not_run(scene: Any) -> None:
    with pytest.raises(TypeError, match="simulate takes a Scene, as of load_scene"):
        simulate(scene)


def test_to_go_on_needs_a_folder() -> None:
    with pytest.raises(Statement, match="folder is required"):
        simulate(parse_scene(text()), resume=True)


@pytest.mark.parametrize("content", [None, 3, ["[time]"]])
def test_what_is_neither_text_nor_tables(content: Any) -> None:
    with pytest.raises(TypeError, match="parse_scene takes TOML text or its tables"):
        parse_scene(content)


def test_overrides_are_several_texts(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(text())
    with pytest.raises(TypeError, match=r"several texts, not one: \['time.end=1'\]"):
        load_scene(tmp_path / "scene.toml", "time.end=1")


def test_a_history_is_read_by_names() -> None:
    history = History(("time_s", "block.angle_rad"))
    history.append([0.0, 0.1])
    assert list(history) == ["time_s", "block.angle_rad"]
    assert {name: history[name][0] for name in history}["block.angle_rad"] == 0.1
    with pytest.raises(TypeError, match="by the name of a column, not by 0"):
        history[0]  # type: ignore[index]


def test_a_scene_without_a_twin_is_refused_before_it_runs(tmp_path: Path) -> None:
    scene = parse_scene(text(tilt=89.99999, twin="true"))
    with pytest.raises(Statement, match=r"output.twin needs a twin, .* no valid one: tilt"):
        simulate(scene, folder=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_scene_in_which_nothing_can_be_perturbed_has_no_twin(tmp_path: Path) -> None:
    scene = parse_scene("gravity_tilt_deg = 15.0\n" + text(tilt=0.0, twin="true"))
    with pytest.raises(Statement, match="needs something to perturb: a motion, a tilt or a"):
        simulate(scene, folder=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_twin_that_fails_leaves_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any, **__: Any) -> Any:
        raise SceneError("time", "this", "that")

    monkeypatch.setattr("solver.run.simulate._twin", refused)
    summary = simulate(parse_scene(text(twin="true")), folder=tmp_path / "out").summary
    assert summary["horizon"]["perturbed"] == "start"
    assert summary["status"] == "completed"
    assert summary["horizon"]["status"] == "refused: time: got this, allowed that"
    assert summary["horizon"]["time_s"] is None
    assert (tmp_path / "out" / "summary.json").exists()


def test_runs_of_like_folders_are_told_apart(tmp_path: Path) -> None:
    for name in ("soft/out", "hard/out", "other"):
        simulate(parse_scene(text(end=0.002)), folder=tmp_path / name)
    runs = [read_run(tmp_path / name) for name in ("soft/out", "hard/out")]
    assert labels(runs) == ["soft/out", "hard/out"]
    assert labels([runs[0], read_run(tmp_path / "other")]) == ["out", "other"]
    assert labels([runs[0], runs[0]]) == ["out", "out"]


def test_the_code_of_the_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """All of docs/python.md, from top to bottom."""
    pytest.importorskip("pyvista")
    text = (Path(rockslip.__file__).parent / "docs" / "python.md").read_text()
    lines = [line[4:] for line in text.splitlines() if line.startswith("    ") or not line]
    exec("\n".join(lines), {})
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("completed 0.0523598")
    assert [line.split()[0] for line in said[1:4]] == ["0.5", "1.0", "2.0"]
    assert "contact_pressure" in said[4]
