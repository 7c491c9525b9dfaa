"""Rows that wait for one another are those that are made after every step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import Result, parse_scene, simulate

pytestmark = pytest.mark.serial
pytest.importorskip("dolfinx")

from solver.run import meshed  # noqa: E402

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
    },
}


def run(content: dict[str, Any], folder: Path, at_once: int) -> Result:
    """Run a scene with rows made so many at a time."""
    output = content.get("output", {}) | {"every": 0.9}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(meshed, "ROWS_AT_ONCE", at_once)
        return simulate(parse_scene(content | {"output": output}), folder=folder)


def counted(result: Result) -> dict[str, Any]:
    """The summary but for seconds, and for what steps after the end have solved."""
    apart = ("wall_s", "setup_s", "output_s", "local_problems_rescued")
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
