"""Runs that go on from a checkpoint: the same history, whatever ended them."""

from __future__ import annotations

import hashlib
import importlib
import inspect
import json
import os
import pickle
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from processes import outside_mpirun
from scenes import BLOCK, OSCILLATOR, UPPER

from rockslip import History, Scene, parse_scene, read_run, simulate
from solver.cli import main
from solver.errors import SceneError
from solver.run.checkpoint import FORMAT, NAME, TYPES, Checkpoint, Schedule, write_checkpoint
from solver.scene import scene_to_toml

pytestmark = pytest.mark.serial

RIGID = BLOCK.replace("[[block]]", '[[block]]\nmodel = "rigid"') + "\n"
COARSE = BLOCK + "\ncells = [3, 6]\n"
TILTED = COARSE + "tilt_deg = 1.0\n"
SHAKEN = '[motion]\nkind = "sine"\namplitude_g = 0.5\nperiod = 0.3\n'
STEPS = "[time]\nend = 0.3\nstep = 0.001\n"

FRAME = """
[foundation]
kind = "frame"
deck = { width = 2.0, height = 0.3 }
column = { width = 0.1, young = 2e11 }
storey = [{ height = 1.0 }, { height = 1.0 }]
feet = { vertical = 1e9 }
young = 3e10
poisson = 0.2
density = 2500.0
damping_ratio = 0.05
cells = { bay = 4, column = 1, deck = 1, storey = 2 }
"""

LINKS = """
[[link]]
name = "wire"
kind = "tether"
between = ["block", "foundation"]
at = [-0.125, 0.0]
to = [-0.3, -1.0]
stiffness = 1e5
damping = 1e2
yield = 200.0
[[link]]
name = "dab"
kind = "wax"
between = ["foundation", "block"]
at = [0.0, 0.0]
stiffness = 1e6
strength = 1500.0
[[force]]
name = "push"
on = "block"
at = [0.0, 1.0]
force = [600.0, 0.0]
table = [[0.05, 0.0], [0.1, 1.0], [0.2, -1.0]]
"""

SCENES = {
    "rigid, linked": RIGID + LINKS + SHAKEN + STEPS,
    "rigid, plane": RIGID + "tilt_deg = 1.0\n" + SHAKEN + STEPS,
    "rigid, plane, stack on platform": RIGID + UPPER + OSCILLATOR + SHAKEN + STEPS,
    "rigid, space": "dimension = 3\n" + RIGID + "tilt_deg = 1.0\n" + SHAKEN + STEPS,
    "meshed": TILTED + SHAKEN + STEPS,
    "meshed, adaptive": TILTED + "[damping]\nstiffness = 3e-5\n[time]\nend = 0.16\n",
    "meshed, damped steps": COARSE + SHAKEN + STEPS + "damped_steps = 8\n",
    "meshed, theta": TILTED + "[contact]\ntheta = 1\nfriction = 0.2\n" + SHAKEN + STEPS,
    "meshed, on a frame": COARSE + FRAME + SHAKEN + STEPS.replace("0.3", "0.2"),
    "meshed, on a reduced frame": COARSE
    + FRAME
    + "modes = 4\n"
    + SHAKEN
    + STEPS.replace("0.3", "0.1"),
    "meshed, linked": COARSE + LINKS + SHAKEN + STEPS.replace("0.3", "0.2"),
    "mixed, on platform": COARSE + UPPER + OSCILLATOR + SHAKEN + STEPS,
}  # fmt: skip


def scene_of(name: str, every: int) -> Scene:
    if name.startswith(("meshed", "mixed")):
        pytest.importorskip("dolfinx")
    return parse_scene(SCENES[name] + f"[output]\ncheckpoint = {{ steps = {every} }}\n")


def last_checkpoint(folder: Path) -> dict[str, float]:
    with np.load(folder / NAME) as table:
        found: dict[str, float] = json.loads(str(table["header"]))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_to_the_byte(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The history, the summary and the times of the fields are those of a run without a break."""
    monkeypatch.setattr(Schedule, "wanted", False)  # none at the end, as where a run is killed
    scene = scene_of(name, 70)
    whole = simulate(scene, folder=tmp_path / "whole")
    assert whole.status == "completed"
    at = last_checkpoint(tmp_path / "whole")["time"]
    assert 0 < at < scene.time.end
    folder = tmp_path / "whole"
    text, fields = (folder / "history.csv").read_bytes(), (folder / "fields.pvd").read_bytes()
    again = simulate(scene, folder=folder, resume=True)
    assert (folder / "history.csv").read_bytes() == text
    assert again.summary["blocks"] == whole.summary["blocks"]
    for count in ("steps", "rejected_steps", "newton_iterations"):
        assert again.summary["cost"][count] == whole.summary["cost"][count]
    times = [line.split(b'"')[1] for line in fields.splitlines() if b"timestep" in line]
    listed = (folder / "fields.pvd").read_bytes().splitlines()
    entries = [line.split(b'"') for line in listed if b"timestep" in line]
    assert [entry[1] for entry in entries] == times
    assert all((folder / entry[-2].decode()).is_file() for entry in entries)
    assert f"resumed at t = {at:.6g} s" in (folder / "run.log").read_text()


@pytest.mark.slow
def test_to_the_byte_from_where_contact_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Adaptive steps look ahead there; what they saw is not in the checkpoint."""
    scene = scene_of("meshed, adaptive", 1)
    monkeypatch.setattr(Schedule, "is_due", lambda _, step: step == chosen)
    monkeypatch.setattr(Schedule, "wanted", False)
    chosen = 0
    closed = simulate(scene).history["contact_points_closed"]
    (changes,) = np.nonzero(np.diff(closed))
    assert len(changes) > 4
    for step in changes[:: len(changes) // 4]:
        chosen, folder = int(step) + 1, tmp_path / f"{step}"
        simulate(scene, folder=folder)
        text = (folder / "history.csv").read_bytes()
        simulate(scene, folder=folder, resume=True)
        assert (folder / "history.csv").read_bytes() == text, chosen


@pytest.mark.slow
def test_what_is_killed_ten_times_ends_the_same(tmp_path: Path) -> None:
    """By SIGKILL, at random times after a new checkpoint; interpreted, so that there is time."""
    text = RIGID + "tilt_deg = 1.0\n" + SHAKEN + "[time]\nend = 1.0\nstep = 1e-4\n"
    text += '[output]\nfields = "none"\ncheckpoint = { steps = 100 }\n'
    (tmp_path / "scene.toml").write_text(text)
    command = [sys.executable, "-m", "solver", "run", "-q"]
    environment = outside_mpirun()

    def started(*words: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [*command, *words], cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True
        )

    with started("scene.toml", "-o", "whole") as process:
        process.communicate(timeout=300)
        assert process.returncode == 0
    chance, folder, reached = random.Random(17), tmp_path / "out", [0.0]
    for number in range(10):
        words = ["--resume", "out"] if number else ["scene.toml", "-o", "out"]
        with started(*words) as process:
            beyond = reached[-1] + chance.choice([0.0, 0.01, 0.02])
            while process.poll() is None and not (
                (folder / NAME).is_file() and last_checkpoint(folder)["time"] > beyond
            ):
                time.sleep(0.002)
            time.sleep(chance.uniform(0.0, 0.05))
            process.send_signal(signal.SIGKILL)
            said = process.communicate()[1]
            assert (process.returncode, said) == (-signal.SIGKILL, "")
        reached.append(last_checkpoint(folder)["time"])
    assert reached == sorted(set(reached))
    with started("--resume", "out") as process:
        said = process.communicate(timeout=300)[1]
        assert process.returncode == 0, said
    one, other = (tmp_path / name / "history.csv" for name in ("whole", "out"))
    assert one.read_bytes() == other.read_bytes()


def test_an_interrupted_run_goes_on_from_its_last_step(tmp_path: Path) -> None:
    scene = parse_scene(
        RIGID + "tilt_deg = 1.0\n[time]\nend = 1.0\nstep = 1e-4\n"
        '[output]\nfields = "none"\ncheckpoint = { minutes = 60.0 }\n'
    )
    whole = simulate(scene, folder=tmp_path / "whole")
    part = simulate(scene, folder=tmp_path / "out", seconds=0.0)
    assert part.status == "interrupted"
    end = part.history["time_s"][-1]
    assert last_checkpoint(tmp_path / "out")["time"] == end
    again = simulate(scene, folder=tmp_path / "out", resume=True)
    assert (again.status, whole.status) == ("completed", "completed")
    texts = [(tmp_path / name / "history.csv").read_bytes() for name in ("whole", "out")]
    assert texts[0] == texts[1]


LONGER = {
    "rigid, plane": (0.2, 0.3),
    "rigid, plane, stack on platform": (0.2005, 0.3),
    "rigid, space": (0.2, 0.3),
    "meshed": (0.1, 0.14),
    "meshed, adaptive": (0.08, 0.16),
    "meshed, on a reduced frame": (0.05, 0.1),
}
"""Ends of runs that are finished, and of those that go on from there, s."""


@pytest.mark.parametrize("name", LONGER)
def test_a_finished_run_goes_on_to_a_later_end(tmp_path: Path, name: str) -> None:
    """To the byte as one that went there at once; also beyond a last step that was cut short."""
    first, last = LONGER[name]
    scene = scene_of(name, 1000)
    span = replace(scene.time, end=last)
    if span.largest is not None:  # a step of both
        span = replace(span, largest=1e-3, step=2.5e-4, smallest=2.5e-4 / 4096)
    scene = replace(scene, time=span)
    whole = simulate(scene, folder=tmp_path / "whole")
    part = replace(scene, time=replace(span, end=first))
    folder = tmp_path / "out"
    assert simulate(part, folder=folder).history["time_s"][-1] == pytest.approx(first)
    words = ["run", "-q", "--resume", str(folder), "--set", f"time.end={last}"]
    assert main(words) == 0
    texts = [(tmp_path / each / "history.csv").read_bytes() for each in ("whole", "out")]
    assert texts[0] == texts[1]
    events = [(tmp_path / each / "events.csv").read_bytes() for each in ("whole", "out")]
    assert events[0] == events[1]
    run = read_run(folder)
    assert run.scene.time.end == last
    assert run.summary["blocks"] == whole.summary["blocks"]
    assert main([*words[:-1], f"time.end={first / 2}"]) == 2
    assert read_run(folder).summary["end_s"] == pytest.approx(last)


def test_an_end_that_decides_on_modes_is_no_other_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("dolfinx")
    text = SCENES["meshed, on a reduced frame"].replace("modes = 4", 'modes = "auto"')
    text = text.replace("end = 0.1", "end = 0.005")
    scene = parse_scene(text + "[output]\ncheckpoint = { steps = 100 }\n")
    simulate(scene, folder=tmp_path)
    assert main(["run", "-q", "--resume", str(tmp_path), "--set", "time.end=0.01"]) == 2
    assert "of another scene: time.end" in capsys.readouterr().err


def test_types_that_runs_save_exist() -> None:
    """The list goes with the modules; numpy's are those of numpy 2."""
    pytest.importorskip("dolfinx")
    for module, names in TYPES.items():
        if not module.startswith("numpy"):
            found = importlib.import_module(module)
            assert [name for name in names if not isinstance(getattr(found, name), type)] == []


def test_the_format_goes_with_the_fields_of_the_types() -> None:
    """If this fails, raise FORMAT: a checkpoint with other fields is refused, never misread."""
    pytest.importorskip("dolfinx")
    types = [
        getattr(importlib.import_module(module), name)
        for module, names in TYPES.items()
        if not module.startswith("numpy")
        for name in names
    ]
    fields = "\n".join(f"{one.__name__} {[*inspect.signature(one).parameters]}" for one in types)
    world = (Path(__file__).parents[2] / "solver" / "kernels" / "world.hpp").read_text()
    fields += "\n".join(re.findall(r"archive[.(].*", world))
    digest = hashlib.sha256(fields.encode()).hexdigest()[:16]
    assert (FORMAT, digest) == (23, "ca281a559d68261a"), fields


class TestRefused:
    """Checkpoints that a run cannot go on from: refused in one line."""

    @pytest.fixture
    def done(self, tmp_path: Path) -> Path:
        scene = scene_of("rigid, plane", 100)
        simulate(scene, folder=tmp_path / "out")
        return tmp_path / "out"

    def refusal(self, folder: Path, captured: pytest.CaptureFixture[str], *words: str) -> str:
        assert main(["run", "--resume", str(folder), "-q", *words]) == 2
        output = captured.readouterr()
        assert output.err.count("\n") == 1
        return output.err

    @pytest.mark.parametrize("damage", ["cut", "turned", "empty", "text", "pickle"])
    def test_damaged(self, done: Path, capsys: pytest.CaptureFixture[str], damage: str) -> None:
        content = (done / NAME).read_bytes()
        middle = len(content) // 2
        (done / NAME).write_bytes(
            {
                "cut": content[:middle],
                "turned": content[:middle] + bytes([content[middle] ^ 255]) + content[middle + 1 :],
                "empty": b"",
                "text": b"not a checkpoint",
                "pickle": b"\x80\x04N.",
            }[damage]
        )
        before = (done / "history.csv").read_bytes()
        assert f"{NAME}, which is damaged" in self.refusal(done, capsys)
        assert (done / "history.csv").read_bytes() == before

    def test_of_another_record(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        """The scene names the same file; what is in it has changed."""
        record = tmp_path / "motion.csv"
        record.write_text("0,0\n0.1,0.2\n0.2,0\n")
        tables = scene_of("rigid, plane", 100).to_dict()
        tables["motion"] = {"kind": "table", "file": str(record), "units": "g"}
        simulate(parse_scene(tables), folder=tmp_path / "out")
        assert main(["run", "--resume", str(tmp_path / "out"), "-q"]) == 0
        record.write_text("0,0\n0.1,0.21\n0.2,0\n")
        assert "of other samples of the motion" in self.refusal(tmp_path / "out", capsys)

    def test_of_something_else(
        self, done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        other = tmp_path / "other"
        shutil.copytree(done, other)
        changed = parse_scene((done / "scene.toml").read_text(), overrides=["block.height=1.1"])
        (other / "scene.toml").write_text(scene_to_toml(changed))
        assert "of another scene: block" in self.refusal(other, capsys)
        with np.load(done / NAME) as table:
            header, own = json.loads(str(table["header"])), table["rank0"]
        for key, value, said in (
            ("rockslip", "0.0.1", "of another version of rockslip"),
            ("format", 2, "in another format"),
            ("ranks", 1, ""),
        ):
            strange = json.dumps(header | {key: value})
            np.savez(done / NAME, header=np.array(strange), rank0=own)
            if said:
                assert said in self.refusal(done, capsys)
        assert main(["run", "--resume", str(done), "-q"]) == 0

    @pytest.mark.parametrize(
        "value",
        [
            Path("x"),
            os.system,
            np.fromfile,
            SceneError("a", "b", "c"),
            write_checkpoint,
            Checkpoint,
        ],
        ids=["path", "command", "function of numpy", "error", "function", "type"],
    )
    def test_what_no_run_saves(
        self, done: Path, capsys: pytest.CaptureFixture[str], value: object
    ) -> None:
        """Neither what could do harm nor other types of the packages whose types runs save."""
        with np.load(done / NAME) as table:
            header = json.loads(str(table["header"]))
        part = pickle.dumps(({"system": value}, None), protocol=5)
        header["sums"] = [hashlib.sha256(part).hexdigest()]
        own = np.frombuffer(part, np.uint8)
        np.savez(done / NAME, header=np.array(json.dumps(header)), rank0=own)
        assert f"{NAME}, which holds what no run has saved" in self.refusal(done, capsys)

    def test_nothing_to_go_on_from(
        self, done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        lines = (done / "history.csv").read_text().splitlines(keepends=True)
        (done / "history.csv").write_text("".join(lines[:50]))
        assert "got 49 rows, allowed the 301 rows" in self.refusal(done, capsys)
        assert (done / "summary.json").exists()
        (done / NAME).unlink()
        assert f"which holds no {NAME}" in self.refusal(done, capsys)
        assert "scene.toml" in self.refusal(tmp_path / "nowhere", capsys)
        said = self.refusal(done, capsys, "--set", "a=1")
        assert "--set of other keys than time.end applies to runs that begin" in said
        assert main(["run"]) == 2
        assert "SCENE is required" in capsys.readouterr().err

    def test_how_often(self) -> None:
        for wrong in ("{}", "{ steps = 0 }", "{ steps = 5, minutes = 1.0 }", "3"):
            with pytest.raises(SceneError, match=r"output\.checkpoint"):
                parse_scene(SCENES["rigid, plane"] + f"[output]\ncheckpoint = {wrong}\n")


def test_rows_of_a_history_that_goes_on(tmp_path: Path) -> None:
    file = tmp_path / "history.csv"
    file.write_text("time_s,a\n0,1\n1,2\n2,3\n3")
    history = History.resumed(["time_s", "a"], file, 2)
    assert file.read_text() == "time_s,a\n0,1\n1,2\n"
    history.append([5.0, 6.0])
    history.flush()
    assert file.read_text() == "time_s,a\n0,1\n1,2\n5,6\n"
