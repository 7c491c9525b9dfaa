"""Soft blocks that impacts compress beyond St. Venant-Kirchhoff's law, against a simple wave."""

from __future__ import annotations

import math
from typing import Any

import pytest
from scipy.integrate import quad

from rockslip import Result, parse_scene, simulate

pytest.importorskip("dolfinx")

YOUNG, DENSITY = 1.4e6, 716.0
SOUND = math.sqrt(YOUNG / DENSITY)
HARDEST = SOUND * quad(lambda s: math.sqrt((3 * s**2 - 1) / 2), 1 / math.sqrt(3), 1)[0]
"""Velocity at which a bar without Poisson's ratio hits the ground and is compressed to 1/sqrt(3).

The law softens under pressure, so that the wave spreads: dv = c ds, c^2 = E (3 s^2 - 1)/(2 rho).
"""


def hits(share: float, dimension: int = 2, **keys: Any) -> Result:
    """A bar of a length of 1 m that hits the ground at a share of that velocity."""
    block = {"width": 0.3, "height": 1.0, "density": DENSITY, "young": YOUNG, "poisson": 0.0}
    block |= {"velocity": [*[0.0] * (dimension - 1), -share * HARDEST]} | keys
    tables = {"dimension": dimension, "gravity": 0.0, "contact": {"friction": 0.0}}
    time = {"end": 0.02, "step": 2e-4}
    return simulate(parse_scene(tables | {"block": [block], "time": time}))


@pytest.mark.parametrize(
    ("dimension", "keys"),
    [
        (2, {"cells": [2, 20]}),
        (2, {"cells": [2, 10], "cell": "triangle"}),
        (3, {"cells": [1, 1, 10], "thickness": 0.3}),
    ],
    ids=str,
)
def test_a_bar_is_not_crushed(dimension: int, keys: dict[str, Any]) -> None:
    """A run ends, with what it has, where a wave compresses the bar beyond its law."""
    softer, harder = (hits(share, dimension, **keys) for share in (0.85, 1.15))
    assert softer.status == "completed"
    assert harder.status == "not converged"
    assert "block is compressed beyond St. Venant-Kirchhoff's law" in harder.summary["reason"]
    assert harder.history["time_s"][-1] < 2 / SOUND
    for result in (softer, harder):
        assert result.summary["energy"]["largest_gain_fraction"] < 1e-12
        assert result.summary["energy"]["ledger_error_fraction"] < 1e-12
