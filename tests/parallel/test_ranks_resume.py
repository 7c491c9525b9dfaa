"""A run that goes on from its checkpoint on another number of ranks."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from processes import on_ranks
from scenes import BLOCK

from rockslip import History
from solver.run.checkpoint import NAME

WIDTH, WEIGHT = 0.25, 503.0 * 9.81

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

SIZES = {"m": WIDTH, "m_s": WIDTH, "m_s2": 9.81, "rad": 0.2, "rad_s": 1.0, "N": WEIGHT}
"""What columns of these units are compared with at least: some hold nothing but round-off."""

ROWS = 20
"""Rows after the checkpoint up to the first impact: it multiplies round-off by 15 to 50."""


def differences(one: History, other: History, rows: slice) -> dict[str, float]:
    """The largest difference of each column in some rows, over the size of the column."""
    found = {}
    for name in one.columns:
        unit = next((u for u in sorted(SIZES, key=len)[::-1] if name.endswith(f"_{u}")), "")
        least = WEIGHT * WIDTH if name.endswith("_J") else SIZES.get(unit, 0.0)
        size = max(least, float(np.abs(one[name]).max()))
        difference = float(np.abs(one[name] - other[name])[rows].max())
        found[name] = difference / size if size else difference
    return found


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds the runs on 1 and 2 ranks: to their end, and the first part of each."""
    folder = tmp_path_factory.mktemp("resume")
    (folder / "scene.toml").write_text(SCENE, encoding="utf-8")
    for ranks in (1, 2):
        for name, end in (("on", END), ("begun", HALF)):
            words = "run", "scene.toml", "-q", "-o", f"{name}{ranks}", "--set", f"time.end={end}"
            done = on_ranks(ranks, folder, *words)
            assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.mpi
@pytest.mark.parametrize(("before", "after"), [(2, 1), (2, 3), (1, 2), (2, 2)])
def test_other_ranks_go_on(whole: Path, before: int, after: int) -> None:
    """To 1e-10 up to the first impact, as the runs on one rank and on as many as before do.

    To 1e-8 after it; on the same number of ranks to the byte.
    """
    folder = whole / f"from{before}to{after}"
    shutil.copytree(whole / f"begun{before}", folder)
    with np.load(folder / NAME) as table:
        header = json.loads(str(table["header"]))
    words = "run", "--resume", str(folder), "-q", "--set", f"time.end={END}"
    done = on_ranks(after, whole, *words)
    assert done.returncode == 0, done.stderr
    histories = [whole / f"on{before}", whole / "on1", folder]
    same, one, found = (History.read(each / "history.csv") for each in histories)
    rows = header["rows"]
    assert header["ranks"] == before
    assert len(found) == len(same) == len(one)
    assert max(differences(same, found, slice(rows)).values()) == 0.0
    assert len(found["time_s"][rows:]) > 2 * ROWS
    assert np.all(found["block.angle_rad"][: rows + ROWS] > 0) and found["block.angle_rad"][-1] < 0
    for other in (same, one):
        apart = differences(other, found, slice(rows, rows + ROWS))
        assert {name: size for name, size in apart.items() if size > 1e-10} == {}
        apart = differences(other, found, slice(rows + ROWS, None))
        assert {name: size for name, size in apart.items() if size > 1e-8} == {}
    if before == after:
        texts = [(each / "history.csv").read_bytes() for each in (histories[0], folder)]
        assert texts[0] == texts[1]
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["cost"]["ranks"] == after
    listed = (folder / "fields.pvd").read_text()
    pieces = [
        line.split('file="')[1].split('"')[0] for line in listed.splitlines() if "file" in line
    ]
    assert len(pieces) == 2 * 7  # that of the first end is one of them
    assert all((folder / piece).is_file() for piece in pieces)


@pytest.mark.mpi
@pytest.mark.parametrize(("before", "after"), [(1, 2), (2, 1)])
def test_the_one_file_of_fields_goes_on(tmp_path: Path, before: int, after: int) -> None:
    """Ranks number nodes and cells in another order, the file goes on in its own."""
    pytest.importorskip("h5py")
    pytest.importorskip("pyvista")
    from solver.pictures.field_grids import HdfGrids

    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    words = ["run", "scene.toml", "-q", "--set", 'output.fields="vtkhdf"', "-o", "out"]
    done = on_ranks(before, tmp_path, *words)
    assert done.returncode == 0, done.stderr
    shutil.copytree(tmp_path / "out", tmp_path / "again")
    done = on_ranks(after, tmp_path, "run", "--resume", "again", "-q")
    assert done.returncode == 0, done.stderr
    whole, found = (HdfGrids(tmp_path / each / "fields.vtkhdf") for each in ("out", "again"))
    assert list(found.times) == pytest.approx(list(whole.times), abs=1e-12)
    for number in range(len(whole.times)):
        for one, other in zip(whole.read(number), found.read(number), strict=True):
            np.testing.assert_allclose(
                other.point_data["displacement"], one.point_data["displacement"], atol=1e-9
            )
            for name, values in one.cell_data.items():
                size = np.abs(values).max()
                np.testing.assert_allclose(other.cell_data[name], values, atol=1e-3 * size + 1.0)
