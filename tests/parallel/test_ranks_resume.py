"""A run on two ranks that goes on from its checkpoint."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from processes import on_ranks, runs_on_two_ranks
from scenes import BLOCK

from rockslip import History, parse_scene, simulate
from solver.cli import main
from solver.run.checkpoint import NAME

SCENE = f"""
{BLOCK}
cells = [3, 6]
tilt_deg = 1.0
[foundation]
kind = "oscillator"
mass_ratio = 0.5
period = 0.4
[motion]
kind = "sine"
amplitude_g = 0.5
period = 0.3
[damping]
stiffness = 3e-5
[time]
end = 0.0925
adaptive = true
step = 0.00023125
largest = 0.000925
[output]
every = 0.019
checkpoint = {{ steps = 150 }}
"""

END, HALF = 0.0925, 0.0555
"""Ends of the runs, and of their first parts, s: both are whole numbers of the longest step."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds a run on 2 ranks to its end, the first part of it, and the beginning of one on 1."""
    folder = tmp_path_factory.mktemp("resume")
    for name, end in (("on2", END), ("begun2", HALF)):
        text = SCENE.replace(f"end = {END}", f"end = {end}")
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    runs_on_two_ranks(folder, "on2", "begun2")
    simulate(parse_scene(SCENE, overrides=["time.end=0.00185"]), folder=folder / "begun1")
    return folder


@pytest.mark.mpi
def test_as_many_ranks_go_on_to_the_byte(whole: Path) -> None:
    """On two ranks, over an impact."""
    folder = whole / "again"
    shutil.copytree(whole / "begun2", folder)
    done = on_ranks(2, whole, "run", "--resume", "again", "-q", "--set", f"time.end={END}")
    assert done.returncode == 0, done.stderr
    one, other = (History.read(each / "history.csv") for each in (whole / "on2", folder))
    assert one["block.angle_rad"][-1] < 0 < one["block.angle_rad"][0]
    for name in one.columns:
        np.testing.assert_array_equal(other[name], one[name])
    for name in ("history.csv", "events.csv"):
        assert (folder / name).read_bytes() == (whole / "on2" / name).read_bytes()
    listed = (folder / "fields.pvd").read_text()
    pieces = [
        line.split('file="')[1].split('"')[0] for line in listed.splitlines() if "file" in line
    ]
    # of the block, the platform and the forces; that of the first end is one of them
    assert len(pieces) == 3 * 7
    assert all((folder / piece).is_file() for piece in pieces)


@pytest.mark.mpi
@pytest.mark.parametrize(("before", "after"), [(2, 1), (1, 2)])
def test_another_number_of_ranks_is_refused(
    whole: Path, before: int, after: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line, with exit code 2; nothing is lost."""
    folder = whole / f"from{before}to{after}"
    shutil.copytree(whole / f"begun{before}", folder)
    words = "run", "--resume", str(folder), "--set", f"time.end={END}"
    if after == 1:
        code, errors = main(list(words)), capsys.readouterr().err
    else:
        done = on_ranks(after, whole, *words)
        code, errors = done.returncode, done.stderr
    assert code == 2
    said = [line for line in errors.splitlines() if line.startswith("rockslip:")]
    assert len(said) == 1 and f"of {before} ranks" in said[0], errors
    assert (folder / "summary.json").is_file() and (folder / NAME).is_file()
