"""Files of motions are read by rank 0 alone; the kinds of motion."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import pytest
from processes import python

from solver.excitation.kinds import KINDS
from solver.scene.motion import MotionSpec

REPOSITORY = Path(__file__).resolve().parents[2]


SCRIPT = """
import os, sys
from solver.parallel import launched_rank
if launched_rank() != 0:  # a node on which no file of the scene is there
    from pathlib import Path
    def absent(self, *_, **__):
        raise FileNotFoundError(2, "No such file or directory", str(self))
    own = Path.read_bytes  # of the program, which is there
    Path.read_text = absent
    Path.read_bytes = lambda self: own(self) if self.suffix == ".py" else absent(self)
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

    done = python("-c", SCRIPT, ranks=2, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "scene.out" / "summary.json").is_file()
    (tmp_path / "motion.txt").unlink()
    done = python("-c", SCRIPT, "-o", "other", ranks=2, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("rockslip:") == 1 and "motion.file" in done.stderr
    assert not (tmp_path / "other").exists()


def test_every_kind_of_motion_can_be_made() -> None:
    kinds = {str(spec.__dataclass_fields__["kind"].default) for spec in get_args(MotionSpec)}
    assert set(KINDS) == kinds


def test_kinds_are_told_apart_inside_the_scene_only() -> None:
    """Elsewhere the properties of a specification decide, not its class."""
    told = [
        f"{file}: {line.strip()}"
        for file in (REPOSITORY / "solver").rglob("*.py")
        if "scene" not in file.relative_to(REPOSITORY).parts
        for line in file.read_text(encoding="utf-8").splitlines()
        if "isinstance(" in line and "Spec" in line
    ]
    assert told == []
