"""Elastic blocks that land flat: what the default damping of bending does to compression."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rockslip import parse_scene, simulate


@pytest.mark.parametrize(("ratio", "cells", "keeps"), [(2, [6, 8], 0.66), (10, [4, 24], 0.36)])
@pytest.mark.slow
def test_slender_blocks_come_back_slowly(ratio: int, cells: list[int], keeps: float) -> None:
    """The speed of the flight after it, from rows of it; and xi of compression, 3.2 % of H/B."""
    block = {"width": 1.0 / ratio, "height": 1.0, "density": 2700.0, "young": 5e10, "poisson": 0.2}
    end = 0.008
    given = {
        "block": [block | {"cells": cells, "velocity": [0.0, -1.0]}],
        "contact": {"friction": 0.6},
        "time": {"end": end},
        "output": {"fields": "none"},
    }
    scene = parse_scene(given)
    own = scene.blocks[0]
    damping = scene.damping_of(own)
    assert damping is not None
    compression = math.pi / 2 * own.material("stress").wave_speed / own.height
    assert damping.ratio(compression) == pytest.approx(0.032 * ratio, rel=0.15)
    for damped, left, band in ((True, keeps, 0.03), (False, 0.93, 0.05)):
        run = simulate(scene if damped else parse_scene(given | {"damping": {"stiffness": 0.0}}))
        time, height = (run.history[name] for name in ("time_s", "block.centre_y_m"))
        flown = time > end / 2
        # Without its fall a flight goes on with the speed at which it began, at about half a ms.
        rising = np.polyfit(time[flown], height[flown] + 4.905 * time[flown] ** 2, 1)
        assert rising[0] == pytest.approx(left, abs=band)
