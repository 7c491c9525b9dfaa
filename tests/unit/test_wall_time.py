"""Limits of wall time: looked at after each step where steps take long."""

from __future__ import annotations

import time

import pytest

from rockslip import parse_scene, simulate
from solver.rigid.system import Advance, RigidSystem

pytestmark = pytest.mark.serial


@pytest.mark.slow
def test_long_steps_of_rigid_blocks_are_few_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first 40 steps take no time and the others 0.1 s: the limit was looked at after 200."""
    advance, asked = RigidSystem.advance, [0]

    def slow(self: RigidSystem, count: int, *rest: object) -> Advance:
        time.sleep(0.1 * (min(count, max(0, asked[0] + count - 40))))
        asked[0] += count
        return advance(self, count, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(RigidSystem, "advance", slow)
    block = {"model": "rigid", "width": 0.5, "height": 1.0, "density": 1000.0}
    scene = parse_scene({"block": [block], "time": {"end": 0.4, "step": 1e-3}})
    found = simulate(scene, seconds=1.0)
    assert found.status == "interrupted"
    assert "limit of 1 s" in found.summary["reason"]
    assert 40 <= found.summary["cost"]["steps"] < 80
