"""The same run on 1, 2 and 3 ranks."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from processes import on_ranks
from scenes import GRANITE

from rockslip import History, read_run

SCENE = GRANITE + "[time]\nend = 3.0\nstep = 1.0e-3\n[output]\nevery = 0.1\n"


def rockslip_on(ranks: int, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`rockslip run` under mpirun, in a folder that holds scene.toml."""
    return on_ranks(ranks, folder, "run", "scene.toml", "-q", *arguments)


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a serial run."""
    folder = tmp_path_factory.mktemp("ranks")
    (folder / "scene.toml").write_text(SCENE, encoding="utf-8")
    done = rockslip_on(1, folder, "-o", "serial")
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.mpi
def test_histories_agree(serial: Path) -> None:
    """To 1e-8 up to 1 s."""
    ranks = 2
    done = rockslip_on(ranks, serial, "-o", f"ranks{ranks}")
    assert done.returncode == 0, done.stderr
    one = History.read(serial / "serial" / "history.csv")
    many = History.read(serial / f"ranks{ranks}" / "history.csv")
    assert len(one) == len(many) == 3001
    first = one["time_s"] <= 1.0
    # Lengths in relation to the block's width. Rocking multiplies round-off by 15 to 50 in every
    # impact, and it is the round-off of some step that decides what is multiplied. Contact is
    # stiff: of five draws forces differed by 5e-8 N before the first impact, 6e-6 to 5e-5 N
    # before the second, and 1e-4 to 1e-3 N before the third, up to which they are compared.
    angle, width, weight = 0.05236, 0.25, 503.0 * 9.81
    limits = {
        "angle_rad": 1e-8 * angle,
        "slip_m": 1e-8 * width,
        "centre_x_m": 1e-8 * width,
        "centre_y_m": 1e-8 * width,
    }
    for column, limit in limits.items():
        name = f"block.{column}"
        assert many[name][first] == pytest.approx(one[name][first], abs=limit), name
    summary = json.loads((serial / "serial" / "summary.json").read_text(encoding="utf-8"))
    impacts = [impact["time_s"] for impact in summary["blocks"]["block"]["impacts"][:3]]
    for name in ("block.normal_force_N", "block.friction_force_N"):
        for impact, limit in zip(impacts, (1e-9, 1e-7, 1e-6), strict=True):
            span = one["time_s"] < impact
            assert many[name][span] == pytest.approx(one[name][span], abs=limit * weight), name
    early = one["time_s"] < impacts[2]
    total = one["energy.total_J"][early]
    assert many["energy.total_J"][early] == pytest.approx(total, abs=1e-8 * np.ptp(total))
    alone, together = (
        json.loads((serial / folder / "summary.json").read_text(encoding="utf-8"))
        for folder in ("serial", f"ranks{ranks}")
    )
    assert together["cost"]["ranks"] == ranks
    # Later rocking amplifies round-off: impact times agree to 1e-3 s up to the tenth impact.
    times = [[i["time_s"] for i in s["blocks"]["block"]["impacts"]] for s in (alone, together)]
    assert times[1][:10] == pytest.approx(times[0][:10], abs=1e-3)


@pytest.mark.mpi
def test_beds_of_two_ranks_are_those_of_one(serial: Path) -> None:
    """Rocking on springs and dashpots in adaptive steps, up to after the first impact."""
    text = GRANITE.replace("friction = 0.7", "friction = 0.7\ndamping = 0.3")
    (serial / "scene.toml").write_text(f"{text}[time]\nend = 0.22\n", encoding="utf-8")
    for ranks in (1, 2):
        done = rockslip_on(ranks, serial, "-o", f"bed{ranks}")
        assert done.returncode == 0, done.stderr
    (serial / "scene.toml").write_text(SCENE, encoding="utf-8")
    one, two = (History.read(serial / f"bed{ranks}" / "history.csv") for ranks in (1, 2))
    assert len(one) == len(two)
    limits = {"block.angle_rad": 0.05236, "block.centre_y_m": 0.25, "energy.total_J": 1.0}
    for name, size in (limits | {"energy.contact_damping_J": 1.0}).items():
        assert two[name] == pytest.approx(one[name], abs=1e-8 * size), name
    assert one["energy.contact_damping_J"][-1] > 0.1


@pytest.mark.mpi
def test_fields_of_two_ranks_are_those_of_one(serial: Path) -> None:
    """Displacements in the files, read back and ordered by place."""
    import pyvista

    done = rockslip_on(2, serial, "-o", "fields2", "--set", "time.end=0.2")
    assert done.returncode == 0, done.stderr
    ends = []
    for folder in ("serial", "fields2"):
        reader = pyvista.get_reader(serial / folder / "fields.pvd")
        reader.set_active_time_value(0.2)
        data = reader.read().combine()
        # A node on the border of two ranks stands in the files of both.
        _, first = np.unique(np.round(data.points, 9), axis=0, return_index=True)
        ends.append((data.points[first], data["displacement"][first]))
    assert ends[0][0] == pytest.approx(ends[1][0], abs=1e-12)
    assert ends[0][1] == pytest.approx(ends[1][1], abs=1e-9)


DOMINOES = """
[time]
end = 0.66
[[block]]
name = "first"
tilt_deg = 8.0
{0}
[[block]]
name = "second"
offset = 0.4
{0}
""".format(
    'model = "elastic"\nyoung = 5e10\npoisson = 0.2\ncells = [2, 12]\n'
    "width = 0.1\nheight = 1.0\nmass = 200.0\nfriction = 0.5"
)


@pytest.mark.mpi
def test_meshed_neighbours_collide_on_two_ranks_as_on_one(tmp_path: Path) -> None:
    """To 1e-8 up to the second collision, and the impulse of the first."""
    (tmp_path / "scene.toml").write_text(DOMINOES, encoding="utf-8")
    for ranks in (1, 2):
        done = rockslip_on(ranks, tmp_path, "-o", f"ranks{ranks}")
        assert done.returncode == 0, done.stderr
    one, many = (History.read(tmp_path / f"ranks{ranks}" / "history.csv") for ranks in (1, 2))
    assert len(one) == len(many)
    met = [read_run(tmp_path / f"ranks{ranks}").history.events for ranks in (1, 2)]
    first, second = ([e for e in events if e.kind == "collision"] for events in met)
    assert len(first) > 1 and first[0].time_s == pytest.approx(0.606, abs=1e-3)
    assert second[0].time_s == pytest.approx(first[0].time_s, abs=1e-10)
    assert second[0].impulse_Ns == pytest.approx(first[0].impulse_Ns, rel=1e-7)
    rows = one["time_s"] <= first[1].time_s
    for name in ("first", "second"):
        for column in ("angle_rad", "slip_m", "centre_x_m", "centre_y_m"):
            key = f"{name}.{column}"
            np.testing.assert_allclose(many[key][rows], one[key][rows], rtol=0, atol=1e-8)


LINKED = """
[[block]]
model = "rigid"
width = 0.25
height = 1.0
mass = 500.0
[[link]]
name = "wire"
kind = "tether"
between = ["block", "foundation"]
at = [-0.125, 0.0]
to = [-0.125, -1.0]
stiffness = 1e5
strength = 800.0
[[force]]
on = "block"
at = [0.0, 1.0]
force = [1000.0, 0.0]
ramp = [0.0, 1.0]
[time]
end = 1.0
step = 1.0e-3
"""


@pytest.mark.mpi
def test_linked_blocks_are_the_same_on_two_ranks_to_the_byte(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(LINKED, encoding="utf-8")
    for ranks in (1, 2):
        done = rockslip_on(ranks, tmp_path, "-o", f"ranks{ranks}")
        assert done.returncode == 0, done.stderr
    for name in ("history.csv", "events.csv"):
        one, two = ((tmp_path / f"ranks{ranks}" / name).read_bytes() for ranks in (1, 2))
        assert one == two
    assert b",break,block,foundation,wire," in one
