"""The same runs on one rank and on two."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from processes import runs_on_two_ranks
from scenes import GRANITE

from rockslip import History, load_scene, read_run, simulate

GRANITE_ROCKS = GRANITE + "[time]\nend = 1.2\nstep = 1.0e-3\n[output]\nevery = 0.1\n"

ON_A_BED = GRANITE.replace("friction = 0.7", "friction = 0.7\ndamping = 0.3")
ON_A_BED += "[time]\nend = 0.22\n"

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

TIED = """
[[block]]
width = 0.5
height = 1.0
mass = 500.0
young = 5e10
poisson = 0.2
cells = [2, 4]
[foundation]
kind = "frame"
deck = { width = 3.0, height = 0.3 }
column = { width = 0.1, young = 2e11 }
young = 3e10
poisson = 0.2
density = 2500.0
damping_ratio = 0.05
cells = { bay = 8, column = 1, deck = 1, storey = 2 }
modes = "auto"
storey = [{ height = 1.0 }]
[[link]]
name = "bar"
kind = "tether"
between = ["block", "foundation"]
at = [0.25, 1.0]
to = [1.03, 0.0]
stiffness = 1e5
[[link]]
name = "foot"
kind = "anchor"
between = ["block", "foundation"]
at = [-0.2, 0.0]
stiffness = 1e5
damping = 1e2
[contact]
friction = 0.1
[motion]
kind = "one_sine"
amplitude_g = 0.3
duration = 0.5
[time]
end = 0.15
step = 2.0e-3
"""

SCENES = {"granite": GRANITE_ROCKS, "bed": ON_A_BED, "dominoes": DOMINOES}
SCENES |= {"linked": LINKED, "tied": TIED}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds the runs: NAME on two ranks, "NAME alone" on one."""
    folder = tmp_path_factory.mktemp("ranks")
    for name, text in SCENES.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
        simulate(load_scene(folder / f"{name}.toml"), folder=folder / f"{name} alone")
    runs_on_two_ranks(folder, *SCENES)
    return folder


def histories(folder: Path, name: str) -> tuple[History, History]:
    """On one rank and on two, with as many rows."""
    one, two = (History.read(folder / each / "history.csv") for each in (f"{name} alone", name))
    assert len(one) == len(two)
    return one, two


@pytest.mark.mpi
def test_histories_agree(folder: Path) -> None:
    """To 1e-8 up to 1 s, over three impacts."""
    one, many = histories(folder, "granite")
    assert len(one) == 1201
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
    alone, together = (read_run(folder / name).summary for name in ("granite alone", "granite"))
    times = [[i["time_s"] for i in s["blocks"]["block"]["impacts"]] for s in (alone, together)]
    impacts = times[0][:3]
    for name in ("block.normal_force_N", "block.friction_force_N"):
        for impact, limit in zip(impacts, (1e-9, 1e-7, 1e-6), strict=True):
            span = one["time_s"] < impact
            assert many[name][span] == pytest.approx(one[name][span], abs=limit * weight), name
    early = one["time_s"] < impacts[2]
    total = one["energy.total_J"][early]
    assert many["energy.total_J"][early] == pytest.approx(total, abs=1e-8 * np.ptp(total))
    assert (alone["cost"]["ranks"], together["cost"]["ranks"]) == (1, 2)
    assert times[1] == pytest.approx(times[0], abs=1e-6)


@pytest.mark.mpi
def test_beds_of_two_ranks_are_those_of_one(folder: Path) -> None:
    """Rocking on springs and dashpots in adaptive steps, up to after the first impact."""
    one, two = histories(folder, "bed")
    limits = {"block.angle_rad": 0.05236, "block.centre_y_m": 0.25, "energy.total_J": 1.0}
    for name, size in (limits | {"energy.contact_damping_J": 1.0}).items():
        assert two[name] == pytest.approx(one[name], abs=1e-8 * size), name
    assert one["energy.contact_damping_J"][-1] > 0.1


@pytest.mark.mpi
def test_fields_of_two_ranks_are_those_of_one(folder: Path) -> None:
    """Displacements in the files, read back and ordered by place."""
    import pyvista

    ends = []
    for name in ("granite alone", "granite"):
        reader = pyvista.get_reader(folder / name / "fields.pvd")
        reader.set_active_time_value(0.2)
        data = reader.read()[:-1].combine()  # but the forces, which are others
        _, first = np.unique(np.round(data.points, 9), axis=0, return_index=True)
        ends.append((data.points[first], data["displacement"][first]))
    assert ends[0][0] == pytest.approx(ends[1][0], abs=1e-12)
    assert ends[0][1] == pytest.approx(ends[1][1], abs=1e-9)


@pytest.mark.mpi
def test_meshed_neighbours_collide_on_two_ranks_as_on_one(folder: Path) -> None:
    """To 1e-8 up to the second collision, and the impulse of the first."""
    one, many = histories(folder, "dominoes")
    met = [read_run(folder / name).history.events for name in ("dominoes alone", "dominoes")]
    first, second = ([e for e in events if e.kind == "collision"] for events in met)
    assert len(first) > 1 and first[0].time_s == pytest.approx(0.606, abs=1e-3)
    assert second[0].time_s == pytest.approx(first[0].time_s, abs=1e-10)
    assert second[0].impulse_Ns == pytest.approx(first[0].impulse_Ns, rel=1e-7)
    rows = one["time_s"] <= first[1].time_s
    for name in ("first", "second"):
        for column in ("angle_rad", "slip_m", "centre_x_m", "centre_y_m"):
            key = f"{name}.{column}"
            np.testing.assert_allclose(many[key][rows], one[key][rows], rtol=0, atol=1e-8)


@pytest.mark.mpi
def test_linked_blocks_are_the_same_on_two_ranks_to_the_byte(folder: Path) -> None:
    for file in ("history.csv", "events.csv"):
        one, two = ((folder / name / file).read_bytes() for name in ("linked alone", "linked"))
        assert one == two
    assert b",break,block,foundation,wire," in one


@pytest.mark.mpi
def test_links_of_meshed_bodies_pull_on_two_ranks_as_on_one(folder: Path) -> None:
    """Of an elastic block, which the ranks share, and a reduced frame, which one of them has."""
    one, two = histories(folder, "tied")
    weight = 500.0 * 9.81
    for name in ("bar.force_N", "foot.shear_force_N"):
        assert np.abs(one[name]).max() > 1e-2 * weight, name
        assert two[name] == pytest.approx(one[name], abs=1e-8 * weight), name
    assert two["block.slip_m"] == pytest.approx(one["block.slip_m"], abs=1e-8 * 0.5)
