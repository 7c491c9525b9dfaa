"""Rows that wait for one another are those that are made after every step."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import Result, parse_scene, simulate

pytestmark = pytest.mark.serial
pytest.importorskip("dolfinx")

from solver.run import meshed  # noqa: E402
from solver.run.block_observer import BlockObserver  # noqa: E402
from solver.stepping.state import State  # noqa: E402
from solver.stepping.stepper import Stepper  # noqa: E402
from solver.stepping.system import Link  # noqa: E402

STONE = {"height": 1.0, "density": 2500.0, "young": 2e10, "poisson": 0.2}
BELOW = STONE | {"name": "below", "width": 0.5, "cells": [3, 5], "tilt_deg": 1.0}
ABOVE = {"name": "above", "on": "below", "width": 0.3, "height": 0.5, "density": 2500.0}
FALLING = STONE | {"name": "falling", "width": 0.2, "cells": [2, 6], "tilt_deg": 14.0}
SHAKEN = {"kind": "half_sine", "amplitude_g": 0.5, "duration": 0.1}

SCENES: dict[str, dict[str, Any]] = {
    "on a block that turns": {
        "block": [BELOW, ABOVE | {"model": "rigid"}],
        "motion": SHAKEN,
        "time": {"end": 0.12, "step": 1e-3},
    },
    "adaptive": {"block": [BELOW], "time": {"end": 0.2}},
    "some rows only": {
        "block": [BELOW],
        "time": {"end": 0.1005, "step": 1e-3},
        "output": {"history_every": 7},
    },
    "that lands on its side": {
        "block": [FALLING],
        "time": {"end": 1.3, "step": 2e-3},
    },
    "that ends early": {
        "block": [FALLING],
        "time": {"end": 2.0, "step": 4e-3, "stop": "overturned"},
        "output": {"every": 0.012},
    },
    "adaptive, that ends early": {
        "block": [FALLING],
        "time": {"end": 2.0, "stop": "overturned"},
    },
}


def run(content: dict[str, Any], folder: Path | None, at_once: int) -> Result:
    """Run a scene with rows made so many at a time."""
    output = {"every": 0.9} | content.get("output", {})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(meshed, "ROWS_AT_ONCE", at_once)
        patch.setattr(meshed, "ROWS_WATCHED", at_once)
        return simulate(parse_scene(content | {"output": output}), folder=folder)


def counted(result: Result) -> dict[str, Any]:
    """The summary but for seconds, and for what steps after the end have solved."""
    apart = ("wall_s", "setup_s", "output_s", "local_problems_rescued", "factorizations")
    cost = {key: value for key, value in result.summary["cost"].items() if key not in apart}
    return result.summary | {"cost": cost}


@pytest.mark.parametrize("name", SCENES)
def test_they_say_the_same(tmp_path: Path, name: str) -> None:
    """To the last bit, with all that is counted; the last fields are those of the last row."""
    whole = run(SCENES[name], tmp_path / "1", 1)
    assert whole.status == "completed"
    assert whole.summary["reason"].startswith("falling overturned" if "early" in name else "")
    for at_once in (7, 50):
        folder = tmp_path / str(at_once)
        waited = run(SCENES[name], folder, at_once)
        for column in whole.history.columns:
            np.testing.assert_array_equal(waited.history[column], whole.history[column])
        assert counted(waited) == counted(whole)
        for file in (tmp_path / "1" / "fields").iterdir():
            assert (folder / "fields" / file.name).read_bytes() == file.read_bytes()
        assert (folder / "fields.pvd").read_bytes() == (tmp_path / "1/fields.pvd").read_bytes()


def test_they_look_at_the_interfaces_of_their_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also at those before a face has joined, in one batch with those after it."""
    usual, seen = BlockObserver.write, list[list[int]]()

    def write(block: BlockObserver, state: State, links: Sequence[Link], row: Any) -> None:
        counts = [link.interface.count for link in links]
        assert counts == [len(memory.force) for memory in state.contacts]
        seen.append(counts)
        usual(block, state, links, row)

    monkeypatch.setattr(BlockObserver, "write", write)
    run(SCENES["that lands on its side"], None, 50)
    joins = [k for k in range(1, len(seen)) if seen[k] != seen[k - 1]]
    assert joins and any((k - 1) % 50 for k in joins)  # the first row is that of the start


@pytest.mark.parametrize("at_once", [1, 10])
def test_no_step_after_the_end_takes_it_back(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    """The run is over when a step after it comes to grief; before it the error is one."""
    content = SCENES["that ends early"]
    end = run(content, None, 1).summary["end_s"]
    usual, least = Stepper.advance, [end]

    def advance(stepper: Stepper, state: State, *how: float) -> Any:
        if state.time > least[0] - 1e-9:
            raise RuntimeError("no more")
        return usual(stepper, state, *how)

    monkeypatch.setattr(Stepper, "advance", advance)
    result = run(content, None, at_once)
    assert result.status == "completed" and result.summary["end_s"] == end
    least[0] = end - 0.1
    with pytest.raises(RuntimeError, match="no more"):
        run(content, None, at_once)
