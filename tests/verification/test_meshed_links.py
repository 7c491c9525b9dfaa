"""Links of meshed bodies: rigid blocks in the same place, closed forms, energy, momentum."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from histories import events
from ledger import completed
from rigid import in_space, table

from rockslip import History, Scene, SceneError, parse_scene, simulate
from solver.kernels import meshed
from solver.run.meshed import MeshedRun

pytestmark = pytest.mark.serial

G = 9.81
SLENDER: dict[str, Any] = {
    **{"width": 0.5, "height": 2.0, "thickness": 0.5, "mass": 500.0},
    **{"young": 5e10, "poisson": 0.2},
}
WEIGHT = 500.0 * G
CELLS = {2: [2, 6], 3: [2, 2, 4]}
ELASTIC = "young", "poisson", "cells", "damping"
UNDAMPED = {"damping": {"stiffness": 0.0}}

WIRE = {"name": "wire", "kind": "tether", "between": ["block", "foundation"]}
PUSH = {"name": "push", "on": "block"}


def scene(d: int, *blocks: dict[str, Any], end: float, step: float = 4e-3, **tables: Any) -> Scene:
    """Blocks in d dimensions, elastic unless they say otherwise; friction 2 unless given."""
    whole = [block if "shape" in block else {"cells": CELLS[d]} | block for block in blocks]
    for block in whole:
        if block.get("model") == "rigid":
            for key in ELASTIC:
                block.pop(key, None)
    content = {
        "dimension": d,
        "block": whole,
        "contact": {"friction": tables.pop("friction", 2.0)},
        "time": {"end": end, "step": step} | tables.pop("time", {}),
        "output": {"fields": "none"},
    }
    return parse_scene(content | tables)


run = partial(completed, gain=1e-6)


def of_both(d: int, *blocks: dict[str, Any], **tables: Any) -> tuple[History, History]:
    """The history of rigid blocks, and that of elastic ones; both have the same columns."""
    rigid = run(scene(d, *({**block, "model": "rigid"} for block in blocks), **dict(tables)))
    elastic = run(scene(d, *blocks, **dict(tables)))
    assert rigid.history.columns == elastic.history.columns
    for name, link in rigid.summary["links"].items():
        assert elastic.summary["links"][name].keys() == link.keys()
    return rigid.history, elastic.history


def differ(one: History, other: History, column: str) -> float:
    """Largest difference of a column, over its largest value."""
    return float(np.abs(one[column] - other[column]).max() / np.abs(one[column]).max())


# ------------------------------------------------------------------ against rigid blocks


def tethered(d: int, **link: Any) -> dict[str, Any]:
    """A force at its top leans a block over against a tether at its edge."""
    ends = {"at": in_space(d, [-0.25, 0.0]), "to": in_space(d, [-0.25, -1.0]), "stiffness": 1e5}
    force = {"at": in_space(d, [0.0, 2.0]), "force": in_space(d, [1500.0, 0.0]), "ramp": [0.1, 1.1]}
    return {"link": [WIRE | ends | link], "force": [PUSH | force]}


@pytest.mark.parametrize("d", [2, 3])
def test_a_tether_at_the_edge_holds_as_that_of_a_rigid_block(d: int) -> None:
    rigid, elastic = of_both(d, SLENDER, end=1.2, **tethered(d, damping=1e4))
    assert rigid["wire.force_N"].max() > 4000.0
    for column in ("wire.force_N", "wire.extension_m", "block.angle_rad", "energy.spring_J"):
        assert differ(rigid, elastic, column) < 2e-3, column
    for column in ("energy.input_J", "energy.damping_J"):
        assert differ(rigid, elastic, column) < 1e-2, column
    taut = rigid["wire.force_N"] > 1.0
    assert np.array_equal(rigid["wire.state"][taut], elastic["wire.state"][taut])


def test_steps_of_their_own_length_hold_as_well() -> None:
    """Adaptive ones."""
    rigid, _ = of_both(2, SLENDER, end=1.2, **tethered(2))
    adaptive = run(scene(2, SLENDER, end=1.2, **tethered(2), time={"adaptive": True})).history
    then = [np.interp(1.15, each["time_s"], each["wire.force_N"]) for each in (rigid, adaptive)]
    assert then[1] == pytest.approx(then[0], rel=1e-2)


@pytest.mark.parametrize("d", [2, 3])
def test_anchors_hold_a_sliding_block_as_they_hold_a_rigid_one(d: int) -> None:
    """Along axes, with dashpots; friction takes its part."""
    squat = SLENDER | {"height": 0.3, "width": 1.0, "cells": [4, 2] if d == 2 else [4, 2, 2]}
    anchor = {"kind": "anchor", "between": ["block", "foundation"], "stiffness": 1e6}
    links = [
        anchor | {"name": name, "at": in_space(d, [x, 0.0]), "damping": 3e3}
        for name, x in (("one", -0.4), ("two", 0.4))
    ]
    motion = {"kind": "one_sine", "amplitude_g": 0.4, "duration": 0.5}
    tables = {"end": 0.5, "step": 2e-3, "friction": 0.1, "link": links, "motion": motion}
    rigid, elastic = of_both(d, squat, **tables)
    assert np.abs(rigid["one.shear_force_N"]).max() > 0.1 * WEIGHT
    assert differ(rigid, elastic, "one.shear_force_N") < 2e-2
    assert differ(rigid, elastic, "block.slip_m") < 2e-2


def test_a_link_to_a_platform_keeps_the_balance_of_momentum() -> None:
    """Ground force, weight and applied forces are what all masses gain, step by step."""
    bar = {"name": "bar", "between": ["block", "foundation"], "stiffness": 1e5, "damping": 1e2}
    tables = {
        "foundation": {"kind": "oscillator", "mass": 800.0, "period": 0.4, "damping_ratio": 0.05},
        "motion": {"kind": "one_sine", "amplitude_g": 0.2, "duration": 0.5},
        "link": [bar | {"at": [0.25, 0.2], "to": [1.0, 0.0]}],
        "force": [PUSH | {"force": [300.0, 100.0], "ramp": [0.1, 0.4]}],
        "friction": 0.1,
    }
    squat = SLENDER | {"height": 0.4, "cells": [3, 2]}
    rigid, elastic = of_both(2, squat, end=0.5, step=2e-3, **tables)
    for column in ("bar.force_N", "foundation.base_shear_N", "platform.drift_m"):
        assert differ(rigid, elastic, column) < 1e-2, column
    given = scene(2, squat, end=0.5, step=2e-3, **tables)
    engine = MeshedRun(given, lambda _: None)
    stepper, state = engine.assembly.stepper, engine.state
    mass = stepper.system.directional_mass
    for _ in range(100):
        new, exchange = stepper.advance(state, 2e-3)
        assert stepper.attached is not None and exchange.ground is not None
        applied = stepper.attached.applied(state.time, 2e-3).sum(axis=0)
        shaken = -stepper.mean_base(state.time, 2e-3) * mass.sum(axis=1)
        gained = (mass @ (new.v - state.v))[0] / 2e-3
        assert gained == pytest.approx((exchange.ground.total + applied + shaken)[0], abs=1e-5)
        state = new


# ------------------------------------------------------------------ closed forms


def test_what_hangs_on_a_tether_pulls_with_its_weight() -> None:
    free = SLENDER | {"position": [0.0, 3.0]}
    hook = {"at": [0.0, 2.0], "to": [0.0, 8.0], "stiffness": 1e5, "damping": 1.4e4}
    history = run(scene(2, free, end=2.0, link=[WIRE | hook])).history
    assert history["wire.force_N"][-1] == pytest.approx(WEIGHT, rel=1e-6)
    assert history["wire.extension_m"][-1] == pytest.approx(WEIGHT / 1e5, rel=1e-6)
    assert history["energy.damping_J"][-1] == pytest.approx(WEIGHT**2 / 2e5, rel=1e-3)


@pytest.mark.parametrize("d", [2, 3])
def test_a_preload_is_there_at_the_start_and_lifts_its_part_of_the_weight(d: int) -> None:
    hook = {"kind": "lashing", "preload": 2000.0, "stiffness": 1e5}
    hook |= {"at": in_space(d, [0.0, 2.0]), "to": in_space(d, [0.0, 8.0])}
    history = run(scene(d, SLENDER, end=0.1, link=[WIRE | hook])).history
    assert history["wire.force_N"] == pytest.approx(2000.0, rel=1e-8)
    assert history["block.normal_force_N"] == pytest.approx(WEIGHT - 2000.0, rel=1e-6)
    assert history["energy.spring_J"] == pytest.approx(2000.0**2 / 2e5, rel=1e-7)


def test_a_given_length_pulls_in_the_equilibrium_at_the_start() -> None:
    """The block stands meanwhile: k times how much it is too short, and the block has sunk."""
    hook = {"at": [0.0, 2.0], "to": [0.0, 8.0], "length": 5.99, "stiffness": 1e5}
    history = run(scene(2, SLENDER, end=0.1, link=[WIRE | hook])).history
    sunk = (WEIGHT / 2 - 1000.0) * 2.0 / (0.25 * 5e10 / (1 - 0.2**2))  # in plane strain
    pulled = history["wire.force_N"] - 1000.0
    assert 0.5 * 1e5 * sunk < pulled[0] < 2.0 * 1e5 * sunk
    assert np.ptp(pulled) < 1e-4


@pytest.mark.parametrize("kind", ["tether", "wax"])
def test_what_breaks_loses_the_energy_that_it_had(kind: str) -> None:
    """F²/(2 k), at the instant at which it is loaded by its strength."""
    undamped = SLENDER | UNDAMPED
    if kind == "tether":
        tables = tethered(2, strength=900.0)
        stiffness, strength = 1e5, 900.0
    else:
        stiffness, strength = 1e6, 500.0
        dab = {"name": "wire", "kind": "wax", "between": ["block", "foundation"], "at": [0.0, 0.0]}
        pull = {"at": [0.0, 0.5], "force": [2.0 * strength, 0.0], "ramp": [0.0, 0.4]}
        tables = {
            "link": [dab | {"stiffness": stiffness, "strength": strength}],
            "force": [PUSH | pull],
            "friction": 0.0,
        }
    result = run(scene(2, undamped, end=1.2 if kind == "tether" else 0.4, **tables))
    lost = strength**2 / (2 * stiffness)
    (event,) = events(result, "break")
    assert (event.block, event.meets, event.where) == ("block", "foundation", "wire")
    assert event.force_N == strength
    assert event.energy_lost_J == pytest.approx(lost, rel=1e-9)
    assert result.summary["energy"]["loss"]["damping_J"] == pytest.approx(lost, rel=1e-8)
    assert result.summary["links"]["wire"]["broke_at_s"] == event.time_s
    history = result.history
    after = history["time_s"] > event.time_s + 4e-3
    assert np.all(history["wire.state"][after] == 3.0)
    assert np.all(history["wire.force_N"][after] == 0.0)
    if kind == "tether":
        (rigid,) = events(
            simulate(scene(2, SLENDER | {"model": "rigid"}, end=1.2, **tables)), "break"
        )
        assert event.time_s == pytest.approx(rigid.time_s, rel=1e-3)


def test_what_flows_is_longer_for_good() -> None:
    tables = tethered(2, kind="spring", **{"yield": 900.0, "stiffness": 1e6})
    result = run(scene(2, SLENDER | UNDAMPED, end=1.0, **tables))
    (event,) = events(result, "yield")
    history = result.history
    row = int(np.searchsorted(history["time_s"], event.time_s))
    assert history["wire.force_N"].max() == pytest.approx(900.0, rel=1e-9)
    assert set(history["wire.state"][row:]) == {2.0}
    # What flow takes: F times what it is longer.
    longer = history["wire.extension_m"][-1] - history["wire.force_N"][-1] / 1e6
    taken = result.summary["energy"]["loss"]["damping_J"]
    assert taken == pytest.approx(900.0 * longer, rel=1e-2)


# ------------------------------------------------------------------ energy and momentum


@pytest.mark.parametrize(("d", "kind"), [(2, "spring"), (2, "anchor"), (3, "anchor")])
def test_an_undamped_link_of_two_blocks_keeps_energy_and_momentum(d: int, kind: str) -> None:
    """They swing and turn without weight, over some fifty periods."""
    free = {"width": 0.5, "height": 1.0, "thickness": 0.5, "mass": 250.0} | UNDAMPED
    free |= {"young": 1e9, "poisson": 0.2, "cells": [2, 2] if d == 2 else [1, 1, 2]}
    one = free | {"name": "one", "position": in_space(d, [0.0, 5.0])}
    other = free | {"name": "other", "position": in_space(d, [2.0, 5.0])}
    other["velocity"] = [0.3, *[0.1] * (d - 2), 0.2]
    link = {"name": "bar", "kind": kind, "between": ["one", "other"], "stiffness": 2e6}
    link |= {"at": in_space(d, [0.25, 0.9]), "to": in_space(d, [-0.25, 0.2])}
    if kind == "anchor":
        link["shear_stiffness"] = 1e6
    given = scene(d, one, other, end=2.0, link=[link], gravity=0.0, time={"rho_inf": 1.0})
    history = run(given).history
    total = history["energy.total_J"]
    assert (total.max() - total[0]) / total[0] < 1e-6
    assert total.min() / total[0] > 1 - 1e-3
    assert history["energy.spring_J"].max() > 0.04 * total[0]
    for axis in "xyz"[:d]:
        middle = 0.5 * sum(history[f"{name}.centre_{axis}_m"] for name in ("one", "other"))
        speed = np.diff(middle) / np.diff(history["time_s"])
        assert np.ptp(speed) < 1e-9


def test_links_join_rigid_and_elastic_blocks() -> None:
    """Twist-locks of a stack: either block may be the rigid one."""
    box = SLENDER | {"height": 0.8, "width": 0.6, "cells": [4, 4]}
    locks = [
        {"name": name, "kind": "twist-lock", "between": ["low", "up"], "at": [x, 0.8]}
        | {"stiffness": 2e7, "damping": 1e4}
        for name, x in (("left", -0.25), ("right", 0.25))
    ]
    pull = {"name": "pull", "on": "up", "at": [-0.3, 0.8], "force": [0.0, 6000.0]}
    found = []
    for low, up in (("rigid", "rigid"), ("rigid", "elastic"), ("elastic", "rigid")):
        blocks = [
            box | {"name": "low", "model": low, "mass": 900.0},
            box | {"name": "up", "model": up, "on": "low"},
        ]
        force = [pull | {"ramp": [0.0, 0.3]}]
        history = run(scene(2, *blocks, end=0.5, link=locks, force=force)).history
        found.append([history[f"{name}.force_N"][-1] for name in ("left", "right")])
    assert found[0][0] > 1000.0
    for other in found[1:]:
        assert other == pytest.approx(found[0], rel=2e-2, abs=20.0)


def test_twist_locks_of_stiff_containers_pull_by_moments(tmp_path: Path) -> None:
    """Of two on one another from g B/(2 h) = 0.470 g on, under a slow ramp of the ground."""
    box = {"width": 2.438, "height": 2.591, "thickness": 6.058, "mass": 2300.0}
    box |= {"young": 1e12, "poisson": 0.2, "cells": [2, 2]}
    lock = {"kind": "twist-lock", "stiffness": 1e8, "damping": 1e6}
    locks = [
        lock | {"name": f"{name}{side}", "between": [below, name], "at": [x, level]}
        for below, name, level in (("foundation", "low", 0.0), ("low", "up", 2.591))
        for side, x in (("left", -1.219), ("right", 1.219))
    ]
    blocks = [box | {"name": "low"}, box | {"name": "up", "on": "low"}]
    file = table(tmp_path, [(0.0, 0.0), (4.0, -0.7 * G)])
    motion = {"kind": "table", "file": file, "units": "m/s2"}
    history = run(scene(2, *blocks, end=4.0, step=1e-2, link=locks, motion=motion)).history
    weight, shaking = 2 * 2300.0 * G, -history["base.acceleration_m_s2"]
    tension = history["lowleft.force_N"]
    moment = 2 * 2300.0 * (shaking * 2 * 2.591 - G * 2.438) / 2
    assert np.abs(tension - np.maximum(moment / 2.438, 0.0)).max() < 3e-3 * weight
    onset = shaking[np.flatnonzero(tension > 2e-3 * weight)[0]] / G
    assert onset == pytest.approx(2.438 / (2 * 2.591), abs=6e-3)
    assert np.abs(history["upleft.force_N"]).max() < 1e-3 * weight


DECK = {"width": 3.0, "height": 0.3}
FRAME = {
    **{"kind": "frame", "deck": DECK, "column": {"width": 0.1, "young": 2e11}},
    **{"storey": [{"height": 1.0}], "young": 3e10, "poisson": 0.2, "density": 2500.0},
    **{"damping_ratio": 0.05, "cells": {"bay": 8, "column": 1, "deck": 1, "storey": 2}},
}


def test_links_end_on_decks_meshed_and_reduced() -> None:
    """Between nodes of the top; both give the same forces."""
    links = [
        {"name": "bar", "between": ["block", "foundation"], "at": [0.25, 1.0], "to": [1.03, 0.0]},
        {"name": "foot", "kind": "anchor", "between": ["foundation", "block"], "at": [-0.2, 0.0]},
    ]
    tables = {
        "link": [link | {"stiffness": 1e5, "damping": 1e2} for link in links],
        "motion": {"kind": "one_sine", "amplitude_g": 0.3, "duration": 0.5},
        "friction": 0.1,
    }
    whole, reduced = (
        run(scene(2, SLENDER, end=0.3, step=2e-3, foundation=FRAME | more, **dict(tables))).history
        for more in ({}, {"modes": "auto"})
    )
    for column in ("bar.force_N", "foot.shear_force_N", "foundation.base_shear_N"):
        assert np.abs(whole[column]).max() > 50.0
        assert differ(whole, reduced, column) < 1e-2, column


# ------------------------------------------------------------------ the correction


@pytest.mark.parametrize("bound", [{"gap": 1e-3}, {"yield": 3e3}, {"gap": 5e-4, "kind": "tether"}])
def test_stiff_links_that_bend_settle(bound: dict[str, Any]) -> None:
    """A thousand times as stiff as the block holds against them in a step: none is divided."""
    links = [
        {"name": name, "kind": "spring", "between": ["block", "foundation"], "stiffness": 1e9}
        | {"at": [x, 1.0], "to": [4 * x, 1.0]}
        | bound
        for name, x in (("left", -0.25), ("right", 0.25))
    ]
    motion = {"kind": "one_sine", "amplitude_g": 1.0, "duration": 0.25}
    given = scene(2, SLENDER, end=0.4, friction=0.1, link=links, motion=motion)
    result = run(given)
    assert result.summary["cost"]["rejected_steps"] == 0
    assert result.summary["cost"]["newton_iterations"] < 6 * result.summary["cost"]["steps"]
    assert np.abs(result.history["left.force_N"]).max() > 1000.0


def test_the_law_is_that_of_rigid_bodies() -> None:
    """Mean forces of a step by quadrature of the law over the way, by all its corners."""
    random = np.random.default_rng(38)
    for _ in range(50):
        start, end = random.uniform(-3e-3, 3e-3, 2)
        k, gap, bound = 1e6, random.uniform(-1e-3, 1e-3), random.uniform(500.0, 2500.0)
        compression = float(random.integers(2))
        laws = np.array([[k, 0.0, gap, compression, bound]])
        force, slope = np.empty((2, 1))
        ends, acts = (np.array([start]), np.array([end])), np.array([1e-3])
        meshed.link_forces(laws, *ends, acts, 1e-3, force, slope)

        way = np.linspace(start, end, 400_001)
        above = np.where(way > gap, way - gap, 0.0)
        below = np.minimum(way + gap, 0.0) if gap >= 0 else np.minimum(way - gap, 0.0)
        rho = above + (below * (way <= gap) if compression else 0.0)
        mean = np.clip(k * rho, -bound, bound)
        expected = np.trapezoid(mean, way) / (end - start)
        assert force[0] == pytest.approx(expected, rel=1e-6, abs=1e-3)


def test_scenes_without_links_have_nothing_of_them() -> None:
    engine = MeshedRun(scene(2, SLENDER, end=0.1), lambda _: None)
    assert engine.assembly.stepper.attached is None and engine.state.body_links is None


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        (
            {"link": [WIRE | {"at": [-0.4, 0.0], "to": [-0.25, -1.0], "stiffness": 1e5}]},
            r"wire\.at: got \[-0\.4, 0\.0\], allowed a place in block or on it, which is elastic",
        ),
        (
            {
                "link": [WIRE | {"at": [0.0, 1.0], "to": [0.0, -1.0], "stiffness": 1e5}],
                "foundation": FRAME,
            },
            r"wire\.to: got \[0\.0, -1\.0\], allowed a place on the foundation's top, at level 0",
        ),
        (
            {"force": [PUSH | {"at": [0.0, 2.5], "force": [1.0, 0.0]}]},
            r"push\.at: got \[0\.0, 2\.5\], allowed a place in block or on it",
        ),
    ],
)
def test_places_beside_what_deforms_are_refused(tables: dict[str, Any], said: str) -> None:
    with pytest.raises(SceneError, match=said):
        scene(2, SLENDER, end=1.0, **tables)


@pytest.mark.parametrize(
    ("place", "is_in"),
    [
        ([0.0, 0.0, 0.2], False),
        ([0.12, 0.0, 0.2], True),
        ([0.0, 0.0, 0.0], True),
        ([0.0, 0.0, 0.39], False),
        ([0.09, 0.0, 0.0], True),
        ([0.13, 0.0, 0.02], False),
    ],
)
def test_places_in_the_hollow_of_an_elastic_vase_are_refused(
    place: list[float], is_in: bool
) -> None:
    wall = [[0.0, 0.0], [0.1, 0.0], [0.14, 0.2], [0.06, 0.4], [0.05, 0.4], [0.11, 0.2]]
    vase = {"shape": {"profile": [*wall, [0.08, 0.03], [0.0, 0.03]], "sides": 24}}
    vase |= {"density": 2000.0, "young": 5e9, "poisson": 0.2}
    wire = WIRE | {"at": place, "to": [0.5, 0.0, 0.0], "stiffness": 1e5}
    if is_in:
        scene(3, vase, end=1.0, link=[wire])
        return
    with pytest.raises(SceneError, match=r"wire\.at: got .* allowed a place in block or on it"):
        scene(3, vase, end=1.0, link=[wire])
