"""Two equal rigid blocks, one on the other, on a meshed plate, shaken along x and y.

The upper one slides to and fro, so that corners of the lower one come out from under it and go back
below it, a little lower than it by the lean of one step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rockslip import Result, parse_scene, simulate

SIZE = {"model": "rigid", "width": 2.44, "thickness": 6.06, "height": 2.59}


def shaken(foundation: dict[str, Any], **upper: float) -> Result:
    lower = {"name": "c1", "mass": 24000.0, "friction": 0.3}
    above = {"name": "c2", "on": "c1", "mass": 12000.0, "friction": 0.25}
    second = {"kind": "one_sine", "amplitude_g": 0.5, "duration": 0.7, "start": 0.05}
    motion = {"kind": "half_sine", "amplitude_g": -0.5, "duration": 0.4, "second": second}
    tables = {
        "dimension": 3,
        "block": [lower | SIZE, above | SIZE | upper],
        "foundation": foundation,
        "motion": motion,
        "time": {"end": 1.4, "step": 5e-3},
    }
    return simulate(parse_scene(tables))


@pytest.mark.slow
def test_the_upper_one_slides_and_stays_level() -> None:
    plate = {
        **{"kind": "elastic", "width": 6.0, "thickness": 8.0, "height": 0.5},
        **{"density": 2500.0, "young": 3e10, "poisson": 0.2},
    }
    result, rigid = shaken(plate), shaken({"kind": "rigid"})
    block, expected = (each.summary["blocks"]["c2"] for each in (result, rigid))
    assert block["mode"] == expected["mode"] == "slide"
    assert block["peak_slip_m"] == pytest.approx(expected["peak_slip_m"], rel=0.01)
    assert block["peak_angle_rad"] < 2e-5
    history = result.history
    assert np.abs(history["c2.slip_second_m"]).max() > 0.04  # corners come out and go back
    assert history["c2.slip_second_m"][-1] > 0.005
    weight = 12000 * 9.81
    assert history["c2.normal_force_N"][-1] == pytest.approx(weight, rel=1e-6)
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-9
    assert history["c2.penetration_m"].max() < 5e-5  # of the first step that slides
