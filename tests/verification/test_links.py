"""Links of rigid blocks: closed forms, energy, and what containers, wax and tendons do."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from histories import events
from ledger import completed as run
from rigid import G, in_space, scene, table
from scipy.optimize import brentq

from rockslip import History, Scene, parse_scene, simulate
from solver.excitation.motion import read_ground
from solver.rigid.system import RigidSystem

SLENDER = {"model": "rigid", "width": 0.5, "height": 2.0, "thickness": 0.5, "mass": 500.0}


# ------------------------------------------------------------------ a tether at the edge


def tethered(d: int, force: float, **link: Any) -> Scene:
    """A block that a force at its top leans over against a tether at its edge, damped."""
    wire = {
        "name": "wire",
        "kind": "tether",
        "between": ["block", "foundation"],
        "at": in_space(d, [-0.25, 0.0]),
        "to": in_space(d, [-0.25, -1.0]),
        "stiffness": 1e5,
        "damping": 1e4,
    }
    push = {"name": "push", "on": "block", "at": in_space(d, [0.0, 2.0]), "ramp": [0.1, 2.1]}
    push["force"] = in_space(d, [force, 0.0])
    return scene(d, SLENDER, end=12.0, step=2e-3, link=[wire | link], force=[push])


def leaning(force: float, stiffness: float) -> tuple[float, float]:
    """Angle at which the block is in balance about its edge, and the tension, by statics."""

    def tension(angle: float) -> tuple[float, float]:
        corner = np.array([0.5 - 0.5 * math.cos(angle), 0.5 * math.sin(angle) + 1.0])
        length = float(np.hypot(*corner))
        pull = stiffness * (length - 1.0)
        # About the edge at the origin, of a corner at (-b cos, b sin).
        x, y = corner[0] - 0.5, corner[1] - 1.0
        moment = -pull * (y * corner[0] - x * corner[1]) / length
        return pull, moment

    def balance(angle: float) -> float:
        c, s = math.cos(angle), math.sin(angle)
        height, centre = 0.25 * s + 2.0 * c, -0.25 * c + 1.0 * s
        return force * height + 500.0 * G * centre + tension(angle)[1]

    angle = float(brentq(balance, 1e-9, 0.5, xtol=1e-15))
    return angle, tension(angle)[0]


@pytest.mark.parametrize("d", [2, 3])
def test_a_tether_at_the_edge_holds_what_statics_says(d: int) -> None:
    result = run(tethered(d, 1500.0))
    angle, tension = leaning(1500.0, 1e5)
    history = result.history
    assert history["block.angle_rad"][-1] == pytest.approx(angle, rel=1e-6)
    assert history["wire.force_N"][-1] == pytest.approx(tension, rel=1e-6)
    assert history["wire.extension_m"][-1] == pytest.approx(tension / 1e5, rel=1e-6)
    assert (history["wire.state"][0], history["wire.state"][-1]) == (0.0, 1.0)
    known = result.summary["links"]["wire"]
    assert known["state"] == "taut" and known["broke_at_s"] is None
    assert result.summary["energy"]["loss"]["damping_J"] > 0.0


def test_a_slack_tether_acts_beyond_its_slack() -> None:
    """By a gap, and as much by a length beyond the distance of its ends."""
    found = [run(tethered(2, 1500.0, **more)).history for more in ({"gap": 0.02}, {"length": 1.02})]
    for history in found:
        taut = history["wire.state"] == 1.0
        reached = history["wire.extension_m"][taut]
        assert np.all(history["wire.force_N"][1:][~taut[1:] & ~taut[:-1]] == 0.0)
        assert reached.min() > (0.02 if history is found[0] else 0.0)
    gap, longer = (history["wire.force_N"][-1] for history in found)
    angles = [history["block.angle_rad"][-1] for history in found]
    assert gap == pytest.approx(longer, rel=1e-3) and angles[0] == pytest.approx(
        angles[1], rel=1e-3
    )
    assert angles[0] > leaning(1500.0, 1e5)[0] + 0.9 * 0.02 / 0.5


def test_a_brittle_tether_loses_its_energy() -> None:
    """F²/(2 k) goes to damping at the instant at which the tension is the strength."""
    result = run(tethered(2, 1500.0, strength=900.0, damping=0.0))
    loss = result.summary["energy"]["loss"]
    assert loss["damping_J"] == pytest.approx(900.0**2 / 2e5, rel=1e-8)
    (event,) = events(result, "break")
    assert (event.block, event.meets, event.where) == ("block", "foundation", "wire")
    assert event.force_N == 900.0
    assert event.energy_lost_J == pytest.approx(900.0**2 / 2e5, rel=1e-8)
    known = result.summary["links"]["wire"]
    assert known["broke_at_s"] == event.time_s and known["peak_force_N"] >= 900.0
    history = result.history
    after = history["time_s"] > event.time_s + 2e-3
    assert np.all(history["wire.state"][after] == 3.0)
    assert np.all(history["wire.force_N"][after] == 0.0)
    # As it broke in that step, and from there on how far its ends are apart.
    row = int(np.searchsorted(history["time_s"], event.time_s))
    extension = history["wire.extension_m"]
    assert extension[row] == pytest.approx(900.0 / 1e5, rel=1e-8)
    assert known["peak_extension_m"] == extension[row] < extension[row + 1] < extension[row + 2]
    place = np.stack([history["block.centre_x_m"], history["block.centre_y_m"]], axis=1)
    angle = history["block.angle_rad"]
    c, s = np.cos(angle), np.sin(angle)
    edge = place + np.stack([-0.25 * c - 1.0 * s, 0.25 * s - 1.0 * c], axis=1)
    apart = np.linalg.norm(edge - [-0.25, -1.0], axis=1)
    assert extension[row + 1 :] == pytest.approx(apart[row + 1 :] - 1.0, abs=1e-12)
    assert result.summary["blocks"]["block"]["mode"] == "overturned"


def test_a_yielding_tether_is_longer_for_good() -> None:
    result = run(tethered(2, 1500.0, **{"yield": 900.0, "damping": 0.0}))
    (event,) = events(result, "yield")
    history = result.history
    row = int(np.searchsorted(history["time_s"], event.time_s))
    assert history["wire.force_N"].max() == pytest.approx(900.0, rel=1e-9)
    assert history["wire.extension_m"][row - 1] <= 9e-3 < history["wire.extension_m"][row]
    assert event.force_N == 900.0 and set(history["wire.state"][row:]) == {2.0}
    assert result.summary["links"]["wire"]["flowed_at_s"] == event.time_s


# ------------------------------------------------------------------ energy


@pytest.mark.slow
def test_undamped_springs_keep_their_energy_over_10000_periods() -> None:
    """A block that swings and turns on two springs, one axial and one along axes."""
    free = SLENDER | {"position": [0.0, 5.0], "velocity": [0.3, 0.0]}
    links = [
        {"name": "one", "between": ["block", "foundation"], "at": [0.1, 2.0], "to": [0.0, 9.0]},
        {"name": "two", "kind": "anchor", "between": ["foundation", "block"], "at": [0.0, 5.0]},
    ]
    step = 2 * math.pi * math.sqrt(500.0 / 4e5) / 40
    given = scene(2, free, end=1.0, step=step, link=[link | {"stiffness": 2e5} for link in links])
    system = RigidSystem(given)
    at = [system.columns.index(f"energy.{name}_J") for name in ("total", "kinetic", "spring")]
    energies = np.concatenate([system.advance(10_000, step).rows[:, at] for _ in range(40)])
    assert np.ptp(energies[:, 0]) < 1e-8 * energies[:, 1].max()
    assert np.ptp(energies[-4000:, 1]) > 0.8 * energies[:, 1].max()


# ------------------------------------------------------------------ containers

BOX = {"model": "rigid", "width": 2.438, "height": 2.591, "thickness": 6.058, "mass": 2300.0}
WEIGHT = 2300.0 * G


def containers(d: int, *, friction: float, step: float, end: float, **more: Any) -> dict[str, Any]:
    """Four containers on one another, locked to one another and to the ground at their corners."""
    blocks, locks = [], []
    below = "foundation"
    for k in range(4):
        name = f"box{k + 1}"
        blocks.append(BOX | {"name": name, "on": below})
        level = 0.0 if k == 0 else BOX["height"]
        for i, x in enumerate((-1.219, 1.219)):
            for j, y in enumerate([0.0] if d == 2 else [-3.029, 3.029]):
                at = [x, level] if d == 2 else [x, y, level]
                lock = {
                    "name": f"lock{k + 1}{i}{j}",
                    "kind": "twist-lock",
                    "between": [below, name],
                }
                locks.append(lock | {"at": at, "stiffness": 1e9 / (d - 1)} | more)
        below = name
    return {
        "dimension": d,
        "block": blocks,
        "link": locks,
        "contact": {"friction": friction},
        "time": {"end": end, "step": step},
        "output": {"fields": "none"},
    }


@pytest.mark.parametrize("d", [2, 3])
def test_twist_locks_of_a_stack_begin_to_pull_where_their_stack_would_uplift(
    tmp_path: Path, d: int
) -> None:
    """At g B/(n h) with n containers above: 0.942, 0.471, 0.314 and 0.236 g; then by moments."""
    strongest, end = 1.1 * G, 20.0
    tables = containers(d, friction=2.0, step=4e-3, end=end, damping=1e7 / (d - 1))
    file = table(tmp_path, [(0.0, 0.0), (end, -strongest)])
    result = run(parse_scene(tables | {"motion": {"kind": "table", "file": file, "units": "m/s2"}}))
    history = result.history
    # The ground is driven towards -x, so that boxes lean to +x and locks at -x pull.
    shaking = -history["base.acceleration_m_s2"]
    for k in range(4):
        above = 4 - k
        locks = [f"lock{k + 1}0{j}" for j in range(d - 1)]
        tension = np.sum([history[f"{lock}.force_N"] for lock in locks], axis=0)
        moment = above * 2300.0 * (shaking * above * 2.591 - G * 2.438) / 2
        expected = np.maximum(moment / 2.438, 0.0)
        assert np.abs(tension - expected)[100:].max() < 1e-3 * above * WEIGHT
        onset = shaking[np.flatnonzero(tension > 2e-3 * above * WEIGHT)[0]] / G
        assert onset == pytest.approx((0.941, 0.4705, 0.3137, 0.2352)[above - 1], abs=5e-3)
        pressed = history[f"lock{k + 1}10.force_N"]
        assert np.abs(pressed).max() < 1e-6 * WEIGHT


def test_with_play_in_the_locks_the_stack_racks_first(tmp_path: Path) -> None:
    """Boxes slip by 6 mm each before a lock bears, and none pulls up to then."""
    tables = containers(2, friction=0.1, step=2e-3, end=8.0, damping=1e5, shear_gap=6e-3)
    file = table(tmp_path, [(0.0, 0.0), (8.0, -0.22 * G)])
    history = run(
        parse_scene(tables | {"motion": {"kind": "table", "file": file, "units": "m/s2"}})
    ).history
    shear = [np.abs(history[f"lock{k}00.shear_force_N"]) for k in range(1, 5)]
    bears = np.flatnonzero(np.max(shear, axis=0) > 0)[0]
    assert history["base.acceleration_m_s2"][bears] < -0.1 * G
    assert max(history[f"box{k}.slip_m"][bears] for k in range(1, 5)) == pytest.approx(
        6e-3, rel=0.05
    )
    for k in range(1, 5):
        assert 6e-3 < history[f"box{k}.slip_m"][-1] < 7e-3
        pull = np.abs(history[f"lock{k}00.force_N"])
        assert max(pull[:bears].max(), pull[-100:].max()) < 1e-6 * WEIGHT
        # Locks, and friction one way or the other, hold all boxes above.
        held = np.sum([history[f"lock{k}{i}0.shear_force_N"][-1] for i in (0, 1)])
        assert (0.22 - 0.1) * 0.99 < abs(held) / ((5 - k) * WEIGHT) < (0.22 + 0.1) * 1.01


# ------------------------------------------------------------------ wax and tendons


@pytest.mark.parametrize(("strength", "breaks"), [(0.1, True), (0.3, False)])
def test_wax_holds_what_friction_does_not(strength: float, breaks: bool) -> None:
    """Under a slow half-sine of 0.4 g: friction takes 0.2 g, wax the rest up to its strength."""
    weight = 50.0 * G
    vase = {"model": "rigid", "width": 0.3, "height": 0.3, "mass": 50.0, "friction": 0.2}
    wax = {"name": "dab", "kind": "wax", "between": ["block", "foundation"], "at": [0.0, 0.0]}
    wax |= {"stiffness": 1e6, "damping": 2e3, "strength": strength * weight}
    motion = {"kind": "half_sine", "amplitude_g": 0.4, "duration": 4.0}
    result = run(scene(2, vase, end=5.0, step=1e-3, friction=0.2, link=[wax], motion=motion))
    found = events(result, "break")
    assert len(found) == breaks
    if breaks:
        instant = math.asin((0.2 + strength) / 0.4) * 4.0 / math.pi
        assert found[0].time_s == pytest.approx(instant, rel=5e-3)
        assert found[0].energy_lost_J == pytest.approx((strength * weight) ** 2 / 2e6, rel=1e-6)
        assert abs(result.history["block.slip_m"][-1]) > 0.1
    else:
        assert np.abs(result.history["block.slip_m"]).max() < 1.2 * 0.2 * weight / 1e6


def test_a_post_tensioned_block_uplifts_where_its_preload_is_overcome(tmp_path: Path) -> None:
    """At g B/H + 2 N B/(m H), and rotates on the stiffness of its tendons from there on."""
    tendons = [
        {
            "name": name,
            "kind": "post-tension",
            "between": ["foundation", "block"],
            "at": [x, -1.0],
            "to": [x, 2.0],
            "preload": 1000.0,
            "stiffness": 2e7,
            "damping": 2e5,
        }
        for name, x in (("left", -0.1), ("right", 0.1))
    ]
    file = table(tmp_path, [(0.0, 0.0), (20.0, -0.8 * G)])
    motion = {"kind": "table", "file": file, "units": "m/s2"}
    given = scene(2, SLENDER, end=20.0, step=4e-3, friction=2.0, link=tendons, motion=motion)
    result = run(given)
    history, uplift = result.history, G * 0.25 + 2 * 1000.0 * 0.5 / (500.0 * 2.0)
    for name in ("left", "right"):
        assert history[f"{name}.force_N"][:100] == pytest.approx(1000.0, rel=1e-9)
    angle, shaking = history["block.angle_rad"], -history["base.acceleration_m_s2"]
    stiffness = 2e7 * (0.15**2 + 0.35**2)
    expected = np.maximum(500.0 * (shaking - uplift) / stiffness, 0.0)
    assert np.abs(angle - expected)[100:].max() < 0.02 * expected.max()
    onset = shaking[np.flatnonzero(angle > 1e-6)[0]]
    assert onset == pytest.approx(uplift, rel=5e-3)


def test_a_lashing_pulls_with_its_preload_at_the_start_and_hangs_through_when_it_is_short() -> None:
    wire = {"kind": "lashing", "preload": 200.0, "gap": 0.0}
    history = run(tethered(2, 0.0, **wire)).history
    assert history["wire.force_N"] == pytest.approx(200.0, rel=1e-9)
    assert history["block.normal_force_N"][1:] == pytest.approx(500.0 * G + 200.0, rel=1e-9)
    assert np.all(history["wire.state"] == 1.0)


# ------------------------------------------------------------------ platforms, stiff links


@pytest.mark.parametrize("d", [2, 3])
def test_a_link_to_a_platform_keeps_the_balance_of_momentum(d: int) -> None:
    """Base shear, and impulses of forces, are what all masses gain, step by step."""
    blocks = [SLENDER | {"name": "tall"}, SLENDER | {"name": "small", "height": 0.3, "offset": 2.0}]
    links = [
        {"name": "wire", "kind": "tether", "between": ["tall", "foundation"], "gap": 1e-3},
        {"name": "bar", "between": ["tall", "small"]},
    ]
    links[0] |= {"at": in_space(d, [0.25, 1.0]), "to": in_space(d, [1.0, 0.0])}
    links[1] |= {"at": in_space(d, [0.25, 1.5]), "to": in_space(d, [0.0, 0.3])}
    given = scene(
        d,
        *blocks,
        end=1.0,
        step=2e-3,
        friction=0.4,
        foundation={"kind": "oscillator", "mass": 800.0, "period": 0.4, "damping_ratio": 0.05},
        motion={"kind": "one_sine", "amplitude_g": 0.6, "duration": 0.5},
        link=[link | {"stiffness": 1e5, "damping": 1e2} for link in links],
        force=[{"on": "tall", "force": in_space(d, [700.0, 300.0]), "ramp": [0.1, 0.6]}],
    )
    system, ground = RigidSystem(given), read_ground(given)
    shear = system.columns.index("foundation.base_shear_N")
    masses = [block.shape.mass for block in given.blocks]

    def momentum() -> float:
        moving = sum(m * system.velocity(b)[0] for b, m in enumerate(masses))
        return float(moving + given.platform().mass * system.drift_velocity[0])

    whole, off = sum(masses) + given.platform().mass, 0.0
    for n in range(500):
        ends, before = 2e-3 * np.array([n, n + 1]), momentum()
        mean = ground.means(ends)
        (row,) = system.advance(1, 2e-3, ground.acceleration(ends), mean=mean).rows
        push = 700.0 * float(np.interp(ends, [0.1, 0.6], [0.0, 1.0]).mean())
        gained = momentum() - before + 2e-3 * whole * mean[0, 0]
        off = max(off, abs(gained - 2e-3 * (push - row[shear])))
    assert off < 1e-9 * whole
    result = run(given)
    assert result.summary["links"]["wire"]["peak_force_N"] > 100.0
    assert "friction_mass_ratio" not in result.summary["blocks"]["tall"]


@pytest.mark.parametrize("d", [2, 3])
def test_a_block_that_slides_without_turning_accounts_for_all_energy_of_its_wire(d: int) -> None:
    """Its wire turns with what it slides."""
    squat = SLENDER | {"height": 0.2, "friction": 0.2}
    wire = {"kind": "lashing", "between": ["block", "foundation"], "preload": 50.0}
    wire |= {"at": in_space(d, [0.0, 0.2]), "to": in_space(d, [0.3, 0.6]), "stiffness": 2e4}
    motion = {"kind": "sine", "amplitude_g": 0.6, "period": 0.5, "cycles": 3}
    result = run(
        scene(d, squat, end=2.0, step=4e-3, friction=0.2, link=[wire], motion=motion), ledger=1e-11
    )
    assert np.abs(result.history["block.slip_m"]).max() > 0.01
    assert np.abs(result.history["block.angle_rad"]).max() < 1e-9


@pytest.mark.parametrize("stiffness", [1e5, 1e10, 1e13])
def test_the_step_of_a_scene_follows_what_swings_on_its_links(stiffness: float) -> None:
    """A twentieth of the period 2 pi sqrt(m/k), down to a tenth of the step without the link.

    Steps are rounded down to 1, 2 or 5 times a power of ten.
    """
    link = {"name": "wire", "kind": "spring", "between": ["block", "foundation"]}
    link |= {"at": [0.0, 2.0], "to": [0.0, 3.0], "stiffness": stiffness}
    tables = {"block": [SLENDER], "time": {"end": 1.0}}
    free, tied = (parse_scene(tables | more).time.step for more in ({}, {"link": [link]}))
    period = 2 * math.pi * math.sqrt(500.0 / stiffness)
    longest = max(min(free, period / 20), free / 10)
    assert longest / 2.5 < tied <= longest
    assert (tied == free) == (stiffness == 1e5)


def test_the_force_of_a_tether_that_snaps_taut_with_steps_by_default() -> None:
    """Within 0.5 % of that with ten times as many, though it lasts a few steps."""
    wire = {"name": "wire", "kind": "tether", "between": ["block", "foundation"], "gap": 0.02}
    wire |= {"at": [-0.25, 0.0], "to": [-0.25, -1.0], "stiffness": 1e10}
    motion = {"kind": "one_sine", "amplitude_g": 0.6, "duration": 0.8}
    tables = {"block": [SLENDER | {"friction": 1.0}], "link": [wire], "motion": motion}
    given = parse_scene(tables | {"time": {"end": 1.2}})
    step = given.time.step / 10
    fine = simulate(parse_scene(tables | {"time": {"end": 1.2, "step": step}}))
    found = simulate(given).summary
    known = fine.summary["links"]["wire"]["peak_force_N"]
    assert known > 1e6
    assert found["links"]["wire"]["peak_force_N"] == pytest.approx(known, rel=5e-3)
    assert found["energy"]["largest_gain_fraction"] < 1e-12


@pytest.mark.parametrize("stiffness", [1e9, 1e11, 1e13])
def test_a_stiff_link_is_solved_in_whole_steps(stiffness: float) -> None:
    """Newton's method for its impulse ends where round-off does: none is divided."""
    result = run(tethered(2, 1500.0, stiffness=stiffness, damping=0.0))
    assert result.summary["cost"]["rejected_steps"] == 0
    last = result.history["wire.force_N"][-500:].mean()
    assert last == pytest.approx((1500.0 * 2.0 - 500.0 * G * 0.25) / 0.5, rel=1e-3)


def test_a_history_that_is_read_back_has_its_events(tmp_path: Path) -> None:
    given = tethered(2, 1500.0, strength=900.0, damping=0.0)
    result = simulate(given, folder=tmp_path / "run")
    read = History.read(tmp_path / "run" / "history.csv")
    assert read.events is not None and result.history.events is not None
    assert [event.kind for event in read.events] == [e.kind for e in result.history.events]
    assert [e.force_N for e in read.events if e.kind == "break"] == [900.0]
