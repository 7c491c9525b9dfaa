"""Hertz and Cattaneo-Mindlin: published numbers, resultants, limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from benchmarks.verification.hertz import (
    HertzLine,
    contact_modulus,
    contact_radius,
    shear_traction,
    stick_half_width,
)

MODULUS = contact_modulus((200.0, 0.3), (200.0, 0.3))
LINE = HertzLine(load=10.0, radius=contact_radius(8.0, 8.0), modulus=MODULUS)


def test_public_case() -> None:
    """Two cylinders of radius 8, E 200, nu 0.3, load 10: a case that contact programs publish."""
    assert LINE.half_width == pytest.approx(0.6808, abs=5e-5)
    assert LINE.peak_pressure == pytest.approx(9.352, abs=1e-3)


def test_radii_and_moduli() -> None:
    assert contact_radius(8.0, np.inf) == 8.0
    assert contact_radius(8.0) == 8.0
    assert MODULUS == pytest.approx(100 / 0.91)
    assert contact_modulus((200.0, 0.3), (np.inf, 0.0)) == contact_modulus((200.0, 0.3))


def test_pressure_carries_the_load() -> None:
    a = LINE.half_width
    assert quad(lambda x: float(LINE.pressure(np.array(x))), -a, a)[0] == pytest.approx(10.0)
    assert LINE.pressure(np.array([-0.7, 0.7])).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("used", [0.0, 0.3, -0.9, 1.0])
def test_shear_carries_the_tangential_load(used: float) -> None:
    friction, a = 0.3, LINE.half_width
    tangential = used * friction * LINE.load
    c = stick_half_width(LINE, tangential, friction)
    force = quad(
        lambda x: float(shear_traction(LINE, tangential, friction, np.array(x))),
        -a,
        a,
        points=[-c, c],
        limit=200,
    )[0]
    assert force == pytest.approx(tangential, rel=1e-6, abs=1e-9)


def test_shear_slips_outside_the_stick_zone_only() -> None:
    friction, tangential = 0.3, 1.8
    c = stick_half_width(LINE, tangential, friction)
    assert c == pytest.approx(LINE.half_width * np.sqrt(0.4))
    x = np.linspace(-LINE.half_width, LINE.half_width, 401)
    bound, shear = friction * LINE.pressure(x), shear_traction(LINE, tangential, friction, x)
    slipping = np.abs(x) > c
    np.testing.assert_allclose(shear[slipping], bound[slipping])
    assert np.all(shear[~slipping] < bound[~slipping])


def test_more_than_friction_bears_is_refused() -> None:
    with pytest.raises(ValueError, match="beyond friction"):
        stick_half_width(LINE, 3.1, 0.3)
