"""Sliding blocks on everything that can carry them: the same on 1 and 2 ranks, some on 3.

The scenes are those of `benchmarks/ranks.py`, which runs all of them on 3 ranks, too, and for
longer; here for 60 steps.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.ranks import SCENES, WEIGHT, WIDTH, run_on

LIMITS = {
    "rad": 1e-8,
    "rad_s": 1e-5,
    "m": 1e-8 * WIDTH,
    "m_s": 1e-6,
    "N": 1e-6 * WEIGHT,
    "J": 1e-8 * WEIGHT * WIDTH,
}
"""Velocities and forces come out of differences of displacements over steps of 2 ms."""

AT_THE_BOUND = {"stack in space": 1e-4 * WEIGHT}
"""Limits of forces where the start has points that slip under the weight alone.

The static start finds the directions of their friction to 1e-5.
"""


ON_THREE = "frame", "neighbours", "stack in space"
"""Scenes that also run on three ranks."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds the histories on 1, 2 and 3 ranks."""
    folder = tmp_path_factory.mktemp("ranks")
    for ranks in (1, 2, 3):
        done = run_on(ranks, folder, 0.12, ON_THREE if ranks == 3 else tuple(SCENES))
        assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("name", "ranks"), [*((name, 2) for name in SCENES), *((name, 3) for name in ON_THREE)]
)
def test_histories_agree(folder: Path, name: str, ranks: int) -> None:
    """Every column: kinematics to 1e-8 of the block's width, forces to 1e-6 of its weight."""
    one, many = (np.load(folder / f"{name} {number}.npz") for number in (1, ranks))
    assert set(one.files) == set(many.files)
    assert len(one["time_s"]) == len(many["time_s"]) == 61
    slid = "top.slip_m" if "top.slip_m" in one.files else "block.slip_m"
    assert np.abs(one[slid]).max() > 1e-3
    checked = 0
    for column in one.files:
        unit = next((unit for unit in LIMITS if column.endswith(f"_{unit}")), None)
        if unit is not None:
            limit = AT_THE_BOUND.get(name, LIMITS[unit]) if unit == "N" else LIMITS[unit]
            assert many[column] == pytest.approx(one[column], abs=limit), column
            checked += 1
    assert checked > 15


@pytest.mark.mpi
def test_the_neighbours_collide(folder: Path) -> None:
    """So that what agrees is the motion after an impact, too."""
    history = np.load(folder / "neighbours 1.npz")
    apart = history["block.centre_x_m"] - history["beside.centre_x_m"] - WIDTH
    assert apart[0] == pytest.approx(1e-3, abs=1e-6)
    assert apart.min() < 1e-5
    assert np.abs(history["beside.slip_m"]).max() > 1e-3


@pytest.mark.mpi
@pytest.mark.parametrize("part", ["block", "top", "plate"])
def test_fields_of_several_parts_agree(folder: Path, part: str) -> None:
    """Displacement and contact pressure of each body, read back and ordered by place."""
    import pyvista

    ends = []
    for ranks in (1, 2, 3):
        reader = pyvista.get_reader(folder / f"fields{ranks}" / "fields" / f"fields_{part}.pvd")
        reader.set_active_time_value(0.06)
        data = reader.read().combine()
        # A node on the border of two ranks stands in the files of both.
        _, first = np.unique(np.round(data.points, 9), axis=0, return_index=True)
        ends.append(
            (data.points[first], data["displacement"][first], data["contact_pressure"][first])
        )
    for many in ends[1:]:
        assert many[0] == pytest.approx(ends[0][0], abs=1e-12)
        assert many[1] == pytest.approx(ends[0][1], abs=1e-9)
        assert many[2] == pytest.approx(ends[0][2], abs=1e-5 * WEIGHT)
    assert np.ptp(ends[0][1], axis=0).max() > 0
