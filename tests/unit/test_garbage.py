"""Steps leave nothing behind that only the collector of cyclic garbage could free."""

from __future__ import annotations

import gc
import tomllib
from typing import Any

import pytest
from scenes import GRANITE

from rockslip import parse_scene, simulate

PLATE = {
    "foundation": {
        "kind": "elastic",
        "width": 2.0,
        "height": 0.2,
        "mass_ratio": 2.0,
        "young": 5e10,
        "poisson": 0.2,
        "support": "bottom",
        "cells": [8, 1],
    }
}


def _cyclic(scene: dict[str, Any], steps: int) -> int:
    """How many objects a run of so many steps leaves in cycles."""
    run = parse_scene(scene | {"time": {"end": steps * 1e-3, "step": 1e-3}})
    gc.collect()
    gc.disable()
    try:
        assert simulate(run).summary["cost"]["steps"] == steps
        return gc.collect()
    finally:
        gc.enable()


@pytest.mark.parametrize("more", [{}, PLATE], ids=["ground", "plate"])
def test_steps_leave_no_cycles_behind(more: dict[str, Any]) -> None:
    """A longer run leaves as many as a short one: what its parts and their names hold."""
    scene = tomllib.loads(GRANITE) | more
    _cyclic(scene, 2)  # what is compiled or imported in a first run is in cycles, too
    assert _cyclic(scene, 60) <= _cyclic(scene, 20)
