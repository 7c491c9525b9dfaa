"""Files of motions are read once, by rank 0, which tells the others; kinds and their modules."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from processes import outside_mpirun

from rockslip import Scene, parse_scene
from solver.errors import SceneError
from solver.excitation.layouts import table
from solver.excitation.motion import read_ground
from solver.scene import MotionSpec

REPOSITORY = Path(__file__).resolve().parents[2]

BLOCK = {"width": 0.5, "height": 1.0, "density": 2000.0, "model": "rigid"}


class Wire:
    """What rank 0 says, for the other rank to hear."""

    def __init__(self) -> None:
        self.said: list[Any] = []


class Rank:
    """One of two ranks, run one after the other: rank 0 first."""

    size = 2

    def __init__(self, rank: int, wire: Wire) -> None:
        self.rank, self._wire = rank, wire

    def bcast(self, value: Any, root: int = 0) -> Any:
        """Say it on the root, hear it elsewhere."""
        if self.rank == root:
            self._wire.said.append(value)
            return value
        return self._wire.said.pop(0)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The files that were read."""
    found: list[Path] = []
    read_lines = table.read_lines

    def counting(file: Path, key: str, expected: str) -> list[str]:
        found.append(file)
        return read_lines(file, key, expected)

    monkeypatch.setattr(table, "read_lines", counting)
    return found


def scene(folder: Path) -> Scene:
    """A block under two records."""
    (folder / "motion.txt").write_text("units: g\n0\n0.1\n0.05\n-0.1\n")
    motion = {"kind": "record", "file": "motion.txt", "dt": 0.01}
    content = {
        "block": [BLOCK],
        "motion": motion | {"vertical": motion | {"scale": 0.5}},
        "time": {"end": 0.05, "step": 1e-3},
    }
    return parse_scene(content, folder=folder)


def ranks() -> tuple[Any, Any]:
    """Two ranks that hear one another."""
    wire = Wire()
    return Rank(0, wire), Rank(1, wire)


def test_rank_0_reads_each_direction_once_and_tells_the_samples(
    tmp_path: Path, counted: list[Path]
) -> None:
    """The other rank reads nothing, even where the file is not there."""
    asked, (first, second) = scene(tmp_path), ranks()
    there = read_ground(asked, first)
    assert len(counted) == 2
    (tmp_path / "motion.txt").unlink()
    here = read_ground(asked, second)
    assert len(counted) == 2
    times = np.linspace(0, 0.05, 21)
    np.testing.assert_array_equal(here.accelerations(times), there.accelerations(times))
    np.testing.assert_array_equal(here.velocities(times), there.velocities(times))


def test_what_rank_0_cannot_read_is_refused_on_every_rank(tmp_path: Path) -> None:
    """With the same words."""
    asked, both = scene(tmp_path), ranks()
    (tmp_path / "motion.txt").unlink()
    lines = []
    for rank in both:
        with pytest.raises(SceneError) as caught:
            read_ground(asked, rank)
        lines.append(str(caught.value))
    assert lines[0] == lines[1]
    assert lines[0].startswith("motion.file: got ")


SCRIPT = """
import os, sys
from solver.launcher import launched_rank
if launched_rank() != 0:  # a node on which no file of the scene is there
    from pathlib import Path
    def absent(self, *_, **__):
        raise FileNotFoundError(2, "No such file or directory", str(self))
    Path.read_text = Path.read_bytes = absent
    os.path.isfile = lambda name: False
from solver.cli import main
sys.exit(main(["run", "scene.toml", "-q", *sys.argv[1:]]))
"""


@pytest.mark.serial
@pytest.mark.mpi
def test_files_that_are_missing_on_one_node_are_not_missed(tmp_path: Path) -> None:
    """Scene and motion of two ranks; what is missing for rank 0 is one line."""
    pytest.importorskip("mpi4py")
    (tmp_path / "motion.txt").write_text("units: g\n0\n0.1\n0.05\n-0.1\n")
    (tmp_path / "scene.toml").write_text(
        '[[block]]\nwidth = 0.5\nheight = 1.0\ndensity = 2000.0\nmodel = "rigid"\n'
        '[motion]\nkind = "record"\nfile = "motion.txt"\ndt = 0.01\n'
        "[time]\nend = 0.05\nstep = 0.001\n"
    )

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            ["mpirun", "--oversubscribe", "-n", "2", sys.executable, "-c", SCRIPT, *words],
            cwd=tmp_path,
            env=outside_mpirun() | {"PYTHONPATH": str(REPOSITORY)},
            capture_output=True,
            text=True,
            timeout=120,
        )

    done = run()
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "scene.out" / "summary.json").is_file()
    (tmp_path / "motion.txt").unlink()
    done = run("-o", "other")
    assert done.returncode == 2
    assert done.stderr.count("rockslip:") == 1 and "motion.file" in done.stderr
    assert not (tmp_path / "other").exists()


def test_every_kind_of_motion_has_its_module() -> None:
    """With the function that makes it; no other module is there."""
    kinds = {str(spec.__dataclass_fields__["kind"].default) for spec in get_args(MotionSpec)}
    for kind in kinds:
        assert callable(import_module(f"solver.excitation.kinds.{kind}").signal)
    folder = REPOSITORY / "solver" / "excitation" / "kinds"
    assert {file.stem for file in folder.glob("*.py")} - {"__init__"} == kinds


def test_kinds_are_told_apart_inside_the_scene_only() -> None:
    """Elsewhere a specification is asked what it says of itself."""
    told = [
        f"{file}: {line.strip()}"
        for file in (REPOSITORY / "solver").rglob("*.py")
        if "scene" not in file.relative_to(REPOSITORY).parts
        for line in file.read_text(encoding="utf-8").splitlines()
        if "isinstance(" in line and "Spec" in line
    ]
    assert told == []
