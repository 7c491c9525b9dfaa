"""Bodies that meet: events, pairs, and what a summary and its text say first."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import Result, parse_scene, read_run, simulate
from solver.history.events import Event
from solver.history.pairs import force_on_first, read_pairs
from solver.pictures.contact import pair_frames
from solver.pictures.forces import draw_forces
from solver.results.meetings import Contacts, meeting_lines, meetings
from solver.results.report import report
from tests.oracles.neighbours import DOMINOES

G = 9.81
BOX: dict[str, Any] = {"model": "rigid", "width": 0.4, "height": 0.4, "mass": 100.0}
NAMES = [f"n{k}" for k in range(1, 6)]


def run(*blocks: dict[str, Any], folder: Path | None = None, **tables: Any) -> Result:
    """Rigid blocks with steps of 1 ms, for a second."""
    time = {"end": 1.0, "step": 1e-3} | tables.pop("time", {})
    return simulate(
        parse_scene({"block": [BOX | block for block in blocks], "time": time} | tables),
        folder=folder,
    )


def dominoes(folder: Path | None = None, *, end: float = 2.5, **tables: Any) -> Result:
    """Five of them, from the first tilt to the heap."""
    given = copy.deepcopy(DOMINOES)
    given["time"] |= {"end": end} | tables.pop("time", {})
    return simulate(parse_scene(given | tables), folder=folder)


def events_of(result: Result, *kinds: str) -> list[Event]:
    """The events of some kinds."""
    assert result.history.events is not None
    return [event for event in result.history.events if event.kind in kinds]


@pytest.fixture(scope="module")
def fallen() -> Result:
    """The dominoes when all have come down."""
    return dominoes()


def test_dominoes_strike_one_another_in_turn(fallen: Result) -> None:
    """Each meets the next one in the air before it meets anything else."""
    first: dict[str, str] = {}
    for event in events_of(fallen, "collision"):
        first.setdefault(event.block, event.meets)
    assert first == dict(zip(NAMES, [*NAMES[1:], "foundation"], strict=True))
    met = events_of(fallen, "collision")
    assert [e.time_s for e in met] == sorted(e.time_s for e in met)
    assert all(e.velocity_before_m_s < 0 <= e.velocity_after_m_s + 1e-9 for e in met)
    assert all(e.impulse_Ns > 0 and e.energy_lost_J > 0 for e in met)
    # Friction is bounded by mu 0.5.
    assert all(e.impulse_tangential_Ns <= 0.5 * e.impulse_Ns * (1 + 1e-9) for e in met)


def test_the_chain_of_collapse(fallen: Result) -> None:
    summary = fallen.summary
    chain = summary["collapse"]
    assert [link["block"] for link in chain] == NAMES
    assert {link["how"] for link in chain} == {"overturned"}
    assert [link["struck"][0] for link in chain] == [*NAMES[1:], "foundation"]
    for link in chain:
        assert link["time_s"] == summary["blocks"][link["block"]]["overturned_at_s"]
    first = events_of(fallen, "collision")[0]
    assert summary["first_collision"] == {"time_s": first.time_s, "between": ["n1", "n2"]}
    most = max((e for e in events_of(fallen, "collision") if e.meets in NAMES), key=_impulse)
    assert summary["largest_pounding"]["impulse_Ns"] == most.impulse_Ns
    assert 0 <= summary["deepest_penetration_m"] < 1e-9
    text = report(summary)
    assert "first collision of two blocks: n1 meets n2 at 0.6" in text
    assert f"collapse: n5 overturns at {chain[4]['time_s']:.4f} s, strikes the ground" in text


def _impulse(event: Event) -> float:
    return event.impulse_Ns


def test_a_run_that_ends_within_steps_taken_together_has_no_collision_twice() -> None:
    """`time.stop` takes the last steps once more: the events are those of a run to that end."""
    bouncing = {"position": [0.0, 0.23], "restitution": 0.7}
    falling = {"name": "f", "offset": 3.0, "width": 0.1, "height": 1.0, "tilt_deg": 8.0}
    stopped = run(bouncing, falling, time={"stop": "overturned"})
    end = stopped.summary["end_s"]
    assert 0.3 < end < 0.5 and len(events_of(stopped, "landing", "collision")) >= 3
    known = repr(events_of(stopped, "collision", "landing"))
    to_end = run(bouncing, falling, time={"end": end})
    assert known == repr(events_of(to_end, "collision", "landing"))


def test_events_and_pairs_of_a_run_that_went_on(tmp_path: Path, fallen: Result) -> None:
    """A checkpoint has the meetings that are no events yet, and the pairs that have touched."""
    output = {"pairs": True, "checkpoint": {"steps": 100}, "fields": "none", "history_every": 7}
    dominoes(tmp_path / "parts", end=1.5, output=output)
    given = copy.deepcopy(DOMINOES)
    given["time"]["end"] = 2.0
    scene = parse_scene(given | {"output": output})
    went_on = simulate(scene, folder=tmp_path / "parts", resume=True)
    whole = simulate(scene, folder=tmp_path / "whole")
    assert repr(went_on.history.events) == repr(whole.history.events)
    for key in ("collapse", "first_collision", "largest_pounding", "deepest_penetration_m"):
        assert went_on.summary[key] == whole.summary[key], key
    # The part before ended in a row of its own, at 1.5 s.
    one, other = (
        [line for line in (tmp_path / name / "pairs.csv").read_text().splitlines()]
        for name in ("parts", "whole")
    )
    assert [line for line in one if not line.startswith("1.5,")] == other
    times = read_run(tmp_path / "whole").history["time_s"]
    known = read_pairs(tmp_path / "whole" / "pairs.csv")
    np.testing.assert_array_equal(known["n1", "foundation"]["time_s"], times)
    touched = known["n1", "n2"]
    assert touched["time_s"][0] == pytest.approx(0.6063, abs=0.008)
    slides = np.abs(np.diff(touched["slip_m"])) > 1e-6
    ratio = touched["friction_N"][1:][slides] / touched["normal_N"][1:][slides]
    assert np.quantile(np.abs(ratio), 0.5) == pytest.approx(0.5, rel=1e-3)
    frames = np.linspace(0.0, 2.0, 101)
    pushes = pair_frames(read_run(tmp_path / "whole"), frames)
    assert len(pushes) == 4
    assert all(np.all(p.force[frames < 0.6] == 0) and np.abs(p.force).max() > 0 for p in pushes)
    # n1 leans on n2 from the left, so that n2 pushes it back.
    assert np.all(pushes[0].force[(frames > 0.7) & (frames < 1.4), 0] < 0)
    assert np.all(np.diff(pushes[0].place[(frames > 0.7) & (frames < 1.4), 1]) < 0)
    figure = draw_forces(read_run(tmp_path / "whole"))
    titles = {axes.get_title(loc="left") for axes in figure.axes}
    assert {"n5", "between n1 and n2", "between n4 and n5"} <= titles


@pytest.mark.parametrize("dimension", [2, 3])
def test_pairs_of_a_lintel_at_rest(dimension: int, tmp_path: Path) -> None:
    """The posts carry it by the lever rule; pairs are those that touch, and none of its own."""
    posts = [{"name": "a", "offset": -0.8}, {"name": "b", "offset": 0.8}]
    lintel = {"name": "lintel", "on": ["a", "b"], "width": 2.4, "height": 0.2, "offset": 0.2}
    output = {"pairs": True, "history_every": 20, "fields": "none"}
    end = {"end": 0.1}
    run(*posts, lintel, folder=tmp_path, dimension=dimension, output=output, time=end)
    known = read_pairs(tmp_path / "pairs.csv")
    under = [("a", "foundation"), ("a", "lintel"), ("b", "foundation"), ("b", "lintel")]
    assert sorted(known) == under
    weight = 100.0 * G
    for row in (0, -1):
        a, b = (known[name, "lintel"]["normal_N"][row] for name in "ab")
        assert a + b == pytest.approx(weight, rel=1e-9)
        arms = [known[name, "lintel"]["x_m"][row] - 0.2 for name in "ab"]
        assert a * arms[0] + b * arms[1] == pytest.approx(0.0, abs=1e-9 * weight)
        assert known["a", "foundation"]["normal_N"][row] == pytest.approx(weight + a, rel=1e-9)
        assert known["b", "foundation"]["normal_N"][row] == pytest.approx(weight + b, rel=1e-9)
    pushes = 0.0
    for name, middle in (("a", -0.8), ("b", 0.8)):
        on_post = known[name, "lintel"]
        push = force_on_first(on_post)
        np.testing.assert_allclose(push[:, -1], -on_post["normal_N"], rtol=1e-12)
        np.testing.assert_allclose(on_post["z_m" if dimension == 3 else "y_m"], 0.4, atol=1e-12)
        assert np.all(np.abs(on_post["x_m"] - middle) <= 0.2 + 1e-9)
        pushes = pushes + push[:, 0]
    np.testing.assert_allclose(pushes, 0.0, atol=1e-6)  # a thrust of the frame is its own
    for pair in known.values():
        assert np.abs(pair["gap_m"]).max() < 1e-9 and np.abs(pair["slip_m"]).max() < 1e-9
        assert set(pair["points"]) == {2.0 if dimension == 2 else 4.0}
    head = (tmp_path / "pairs.csv").read_text().splitlines()[0]
    assert ("friction_second_N" in head) == (dimension == 3)


def test_slip_and_gap_of_a_pair(tmp_path: Path) -> None:
    """Thrown at 1 m/s with mu 0.5 towards +x: v^2 / (2 mu g); afterwards in the air from 0.1 m."""
    thrown = {"name": "t", "velocity": [1.0, 0.0]}
    high = {"name": "h", "position": [3.0, 0.3]}
    contact = {"friction": 0.5}
    output = {"pairs": True, "fields": "none"}
    run(thrown, high, folder=tmp_path, contact=contact, output=output, time={"end": 0.5})
    known = read_pairs(tmp_path / "pairs.csv")
    slid = known["t", "foundation"]
    assert slid["slip_m"][-1] == pytest.approx(1 / G, rel=1e-3)
    assert slid["friction_N"][50] == pytest.approx(-50 * G, rel=1e-9)
    assert known["h", "foundation"]["time_s"][0] == pytest.approx(math.sqrt(0.2 / G), abs=2e-3)


def test_pairs_of_meshed_blocks(tmp_path: Path) -> None:
    """Weight at rest, of each block and of what is on it; nothing between blocks that are apart."""
    elastic = BOX | {"model": "elastic", "young": 1e9, "poisson": 0.2, "cells": [2, 2]}
    blocks = [elastic | {"name": "low"}, elastic | {"name": "top", "on": "low"}]
    blocks.append(elastic | {"name": "side", "offset": 1.0})
    output = {"pairs": True, "fields": "none"}
    simulate(
        parse_scene({"block": blocks, "time": {"end": 0.02}, "output": output}), folder=tmp_path
    )
    pairs, weight = (
        read_run(tmp_path).pairs(),
        parse_scene({"block": [elastic], "time": {"end": 1.0}}),
    )
    weight = weight.blocks[0].shape.weight(G)
    normal = {names: known["normal_N"][-1] for names, known in pairs.items()}
    assert normal == pytest.approx(
        {
            ("low", "top"): weight,
            ("low", "foundation"): 2 * weight,
            ("side", "foundation"): weight,
        },
        rel=1e-6,
    )
    assert pairs["low", "top"]["normal_y"][-1] == pytest.approx(-1.0)
    assert pairs["low", "top"]["gap_m"][-1] == pytest.approx(0.0, abs=1e-7)


def test_no_pairs_unless_requested(tmp_path: Path) -> None:
    run({}, folder=tmp_path, time={"end": 0.01})
    assert not (tmp_path / "pairs.csv").exists() and not read_run(tmp_path).pairs()


def test_a_block_that_chatters_does_not_fill_the_events() -> None:
    """Dropped flat with e 0.5: what comes slower than a fall of 2e-4 of the width is left out."""
    result = run({"position": [0.0, 0.3], "restitution": 0.5})
    speeds = [-e.velocity_before_m_s for e in events_of(result, "collision", "landing")]
    least, first = math.sqrt(2 * G * 2e-4 * 0.4), math.sqrt(0.2 * G)
    assert speeds[0] == pytest.approx(first, rel=1e-6)
    assert min(speeds) >= least and len(speeds) <= 1 + math.log2(first / least)
    np.testing.assert_allclose(speeds, first * 0.5 ** np.arange(len(speeds)), rtol=1e-3)


def test_a_block_lands_on_another_one() -> None:
    """What it meets is the body below it, not what its columns are measured over."""
    result = run({"name": "low", "width": 0.8}, {"name": "up", "position": [0.1, 0.7]})
    (landing,) = events_of(result, "landing")
    assert (landing.block, landing.meets) == ("up", "low")
    assert landing.time_s == pytest.approx(math.sqrt(0.2 / G), abs=1e-9)
    assert landing.velocity_before_m_s == pytest.approx(-math.sqrt(0.2 * G), rel=1e-9)
    assert result.summary["first_collision"]["between"] == ["up", "low"]
    assert result.summary["largest_pounding"] is None
    assert result.summary["collapse"] == []


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_falls_from_a_block_lands_on_the_platform_and_rests(dimension: int) -> None:
    """Dropped on the edge of a block on a platform that sways: on the one, then on the other."""
    place = [0.25, *[0.0] * (dimension - 2), 1.2]
    falling = {"name": "up", "width": 0.2, "height": 0.3, "mass": 50.0, "position": place}
    foundation = {"kind": "oscillator", "mass": 500.0, "period": 0.5, "damping_ratio": 0.05}
    motion = {"kind": "sine", "amplitude_g": 0.3, "period": 0.6, "cycles": 2}
    more: dict[str, Any] = {"dimension": dimension, "foundation": foundation, "motion": motion}
    result = run({"name": "low"}, falling, time={"end": 4.0}, **more)
    met = [event.meets for event in events_of(result, "landing") if event.block == "up"]
    assert met[0] == "low" and met[-1] == "foundation"
    history = result.history
    height, force = (f"up.centre_{'yz'[dimension - 2]}_m", "up.normal_force_N")
    rests = history["time_s"] > 3.5
    np.testing.assert_allclose(history[height][rests], 0.15, atol=1e-9)
    np.testing.assert_allclose(history[force][rests], 50 * G, rtol=1e-9)
    assert result.summary["deepest_penetration_m"] < 1e-9 * 0.2


def test_a_lintel_falls_when_it_is_off_both_posts() -> None:
    """One post is thrown from under it: it falls at that end, and lies against the other."""
    posts = [{"name": "a", "offset": -0.8}, {"name": "b", "offset": 0.8, "velocity": [6.0, 0.0]}]
    lintel = {"name": "lintel", "on": ["a", "b"], "width": 2.0, "height": 0.1, "mass": 10.0}
    result = run(*posts, lintel, contact={"friction": 0.05}, time={"end": 1.2})
    block = result.summary["blocks"]["lintel"]
    assert block["fell_at_s"] is None or block["fell_at_s"] > 0.2
    still = run({"name": "a", "offset": -0.8}, {"name": "b", "offset": 0.8}, lintel)
    assert still.summary["blocks"]["lintel"]["mode"] == "rest"
    assert still.summary["blocks"]["lintel"]["fell_at_s"] is None


def test_steps_without_a_solution_are_told() -> None:
    scene = parse_scene({"block": [BOX], "time": {"end": 1.0}})
    history = run({}, time={"end": 0.01}).history
    known = meetings(scene, history, (), Contacts(None, 3, 2.5e-5))
    assert known["unsettled"] == {"steps": 3, "largest_defect_m_s": 2.5e-5}
    assert known["deepest_penetration_m"] is known["deepest_penetration_between"] is None
    (line,) = meeting_lines(known)
    assert line.startswith("3 steps found no solution") and "2.5e-05 m/s" in line
    assert meeting_lines(meetings(scene, history, (), Contacts(None, 0, 0.0))) == []
