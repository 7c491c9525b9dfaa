"""Events that a run records: what they say, and that it does not matter how steps come."""

from __future__ import annotations

import math
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import History, Result, parse_scene, read_run, simulate
from solver.history.events import COLUMNS, Event, Meeting, read_events
from solver.results.events import Recorder
from solver.types import Array

G = 9.81
SLENDER: dict[str, Any] = {
    **{"model": "rigid", "width": 0.25, "height": 1.0, "thickness": 0.4, "mass": 100.0},
    "friction": 2.0,
}


def run(*blocks: dict[str, Any], end: float = 2.0, **tables: Any) -> Result:
    """Rigid blocks with steps of 1 ms."""
    given = {"block": [SLENDER | block for block in blocks], "time": {"end": end, "step": 1e-3}}
    return simulate(parse_scene(given | tables))


def events(result: Result, kind: str, block: str = "block") -> list[Event]:
    """Those of a kind."""
    assert result.history.events is not None
    return [e for e in result.history.events if (e.kind, e.block) == (kind, block)]


Told = list[tuple[Array, Sequence[Meeting]]]
"""Rows, and who met in them, as a run tells its recorder."""


@pytest.fixture(scope="module")
def told() -> tuple[Result, Told]:
    """A block that is lifted off by a pulse, rocks and comes to rest, and what its recorder got."""
    pieces: Told = []
    add = Recorder.add

    def note(
        self: Recorder,
        rows: Array,
        met: Sequence[Meeting] = (),
        happened: Sequence[Event] = (),
    ) -> None:
        pieces.append((rows.copy(), met))
        add(self, rows, met, happened)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Recorder, "add", note)
        motion = {"kind": "one_sine", "amplitude_g": 0.4, "duration": 0.4}
        return run({}, motion=motion, end=4.0), pieces


@pytest.fixture(scope="module")
def shaken(told: tuple[Result, Told]) -> Result:
    """That run."""
    return told[0]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("restitution", [None, 0.9])
def test_velocities_impulse_and_energy_of_an_impact(
    dimension: int, restitution: float | None
) -> None:
    """omega+ = e omega-, J = m omega- (1 + e) B/2, and what the rotation loses."""
    result = run({"tilt_deg": 3.0, "restitution": restitution}, dimension=dimension, end=0.4)
    shape = parse_scene({"block": [SLENDER], "time": {"end": 1.0}}).blocks[0].shape
    e = restitution or 1 - 1.5 * math.sin(shape.slenderness()) ** 2
    raised = math.cos(shape.slenderness() - math.radians(3)) - math.cos(shape.slenderness())
    before = -math.sqrt(2 * shape.frequency(G) ** 2 * raised)
    (found,) = events(result, "impact")
    assert found.angular_velocity_before_rad_s == pytest.approx(before, rel=1e-5)
    assert found.angular_velocity_after_rad_s == pytest.approx(e * before, rel=3e-4)
    assert found.velocity_before_m_s == pytest.approx(0.25 * before, rel=0.01)
    assert found.velocity_after_m_s == pytest.approx(0.0, abs=1e-9)
    assert found.impulse_Ns == pytest.approx(-100 * before * (1 + e) * 0.125, rel=0.01)
    lost = 0.5 * shape.rotary_inertia_about_corner() * before**2 * (1 - e**2)
    assert found.energy_lost_J == pytest.approx(lost, rel=2e-3)
    assert (found.where, found.meets) == ({2: "left", 3: "1+4"}[dimension], "foundation")
    known = result.summary["blocks"]["block"]["impacts"]
    assert known == [{"time_s": found.time_s, "restitution": found.restitution}]


def test_a_block_lifts_off_once(shaken: Result) -> None:
    """It does so when the ground's acceleration first passes g B/H, against it."""
    (found,) = events(shaken, "lift-off")
    known = math.asin(0.25 / 0.4) * 0.4 / (2 * math.pi)
    assert found.time_s == pytest.approx(known, abs=0.015)
    assert found.where == "right" and found.angular_velocity_after_rad_s < 0
    assert len(events(shaken, "impact")) > 4


def test_a_flight_and_its_landing() -> None:
    """Thrown up by 1 m/s it is off from the start, and lands with as much."""
    result = run({"velocity": [0.0, 1.0]}, end=0.4)
    (found,) = events(result, "landing")
    assert found.time_s == pytest.approx(2 / G, abs=2e-3)
    assert found.velocity_before_m_s == pytest.approx(-1.0, abs=0.03)
    assert found.velocity_after_m_s == pytest.approx(0.0, abs=1e-9)
    assert found.where == "left+right"


HANGING: dict[str, Any] = {
    "block": [SLENDER | {"position": [0.2, 1.0], "angular_velocity": 1.0}],
    "link": [
        {"name": "rope", "kind": "tether", "between": ["block", "foundation"]}
        | {"at": [0.0, 1.0], "to": [0.0, 3.0], "stiffness": 1e6}
    ],
    "output": {"fields": "none"},
}
"""A block that swings on a rope and stands on nothing."""


def test_a_block_that_hangs_neither_lifts_off_nor_strikes(monkeypatch: pytest.MonkeyPatch) -> None:
    """It swings through its upright position some ten times, over many searches."""
    monkeypatch.setattr("solver.results.events.CHUNK", 64)
    result = simulate(parse_scene(HANGING | {"time": {"end": 8.0, "step": 2e-3}}))
    angle = result.history["block.angle_rad"]
    assert np.count_nonzero(np.diff(np.sign(angle))) > 10
    assert result.history.events == ()


def test_a_long_flight_is_told_once_and_needs_no_old_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Thrown up from the ground, it lands after six times as many steps as are kept."""
    for name, value in (("CHUNK", 64), ("MOST_ROWS", 256)):
        monkeypatch.setattr(f"solver.results.events.{name}", value)
    push = {"name": "up", "on": "block", "force": [0.0, 3000.0]}
    table = {"table": [[0.0, 0.0], [0.1, 0.0], [0.11, 1.0], [0.4, 1.0], [0.41, 0.0]]}
    result = run({}, force=[push | table], end=2.2)
    (flight,), (landing,) = events(result, "flight"), events(result, "landing")
    assert result.history.events == (flight, landing)
    assert flight.time_s == pytest.approx(0.1 + 0.01 * 981 / 3000, abs=2e-3)
    assert landing.time_s - flight.time_s > 6 * 0.256
    # Up with 20.19 m/s2 over about 0.3 s, then free.
    lifted = result.history["block.centre_y_m"].max() - 0.5
    assert landing.velocity_before_m_s == pytest.approx(-math.sqrt(2 * G * lifted), rel=2e-2)


def test_a_block_that_loses_what_carries_it_and_overturns() -> None:
    low = {"name": "low", "width": 0.5, "height": 0.2}
    up = {"name": "up", "on": "low", "offset": 0.2, "velocity": [1.0, 0.0], "friction": 0.05}
    result = run(low, up, end=0.8)
    (lost,), (over,) = events(result, "carrier lost", "up"), events(result, "overturned", "up")
    assert lost.meets == "low" and 0.05 < lost.time_s < 0.8
    assert over.time_s == result.summary["blocks"]["up"]["overturned_at_s"]


@pytest.mark.parametrize("first", [1, 7, 300, 512, 4001])
def test_it_does_not_matter_how_steps_come(
    told: tuple[Result, Told], first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By few or together, also where a run stops and goes on, and however often it is looked."""
    monkeypatch.setattr("solver.results.events.CHUNK", 256)
    history = told[0].history
    met = [each for _, all_met in told[1] for each in all_met]
    scene = parse_scene({
        "block": [SLENDER], "time": {"end": 4.0, "step": 1e-3},
        "motion": {"kind": "one_sine", "amplitude_g": 0.4, "duration": 0.4},
    })  # fmt: skip
    rows = np.stack([history[name] for name in history.columns], axis=1)
    one = Recorder(scene, history.columns)

    def piece(begin: int, end: int) -> tuple[Array, list[Meeting]]:
        """Rows and who met in them."""
        part = rows[begin:end]
        after = rows[begin - 1, 0] if begin else -np.inf
        return part, [m for m in met if after < m.time_s <= part[-1, 0]]

    one.add(*piece(0, first))
    other = Recorder(scene, history.columns)
    other.resume(pickle.loads(pickle.dumps(one.saved())))
    for k in range(first, len(rows), 77):
        other.add(*piece(k, k + 77))
    assert repr(other.finish()) == repr(history.events)


def test_events_do_not_depend_on_what_the_history_keeps(shaken: Result, tmp_path: Path) -> None:
    motion = {"kind": "one_sine", "amplitude_g": 0.4, "duration": 0.4}
    tables = {"block": [SLENDER], "time": {"end": 4.0, "step": 1e-3}, "motion": motion}
    sparse = simulate(parse_scene(tables | {"output": {"history_every": 50}}), folder=tmp_path)
    assert repr(sparse.history.events) == repr(shaken.history.events)
    assert repr(read_run(tmp_path).history.events) == repr(shaken.history.events)
    lines = (tmp_path / "events.csv").read_text().splitlines()
    assert lines[0] == ",".join(COLUMNS) and len(lines) == 1 + len(shaken.history.events or ())
    (tmp_path / "events.csv").write_text("time_s,kind\nx,impact\n")
    with pytest.raises(Exception, match=r"events\.csv"):
        read_events(tmp_path / "events.csv")
    assert History(["time_s"]).events is None
