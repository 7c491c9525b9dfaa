"""Measures of a motion: closed forms, an independent integration, the listed spectra of records."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from rockslip import parse_scene
from solver.excitation.motion import read_ground
from solver.excitation.sampled import SampledMotion
from solver.excitation.spectrum import (
    arias_intensity,
    highest_frequency,
    peak_ground,
    response_spectrum,
    significant_duration,
    velocity_and_displacement,
)

G = 9.81
RECORDS = Path(__file__).parents[3] / "shared" / "records"

LISTED = {
    "RSN6_IMPVALL.I_I-ELC180": (0.6249, 0.7376, 0.4698, 0.1975),
    "RSN169_IMPVALL.H_H-DLT352": (0.6788, 0.6200, 0.4826, 0.2230),
    "RSN730_SPITAK_GUK000": (0.3461, 0.3572, 0.3694, 0.0722),
    "RSN963_NORTHR_ORR090": (1.2228, 0.9660, 0.5331, 0.2323),
    "RSN985_NORTHR_BLD090": (0.4445, 0.3977, 0.1605, 0.1319),
}
"""PSA, g, at 0.2, 0.5, 1 and 2 s."""


def broken_line(count: int = 60, seed: int = 3) -> NDArray[np.float64]:
    return np.random.default_rng(seed).uniform(-3, 3, count)


def integrated(
    samples: NDArray[np.float64], step: float, period: float, damping: float
) -> NDArray[np.float64]:
    """Displacement at the samples, by a method that knows nothing of recursions."""
    w, times = 2 * math.pi / period, step * np.arange(samples.size)

    def rate(time: float, state: NDArray[np.float64]) -> list[float]:
        ground = np.interp(time, times, samples)
        return [state[1], -ground - 2 * damping * w * state[1] - w**2 * state[0]]

    end, limits = times[-1], {"rtol": 1e-9, "atol": 1e-12, "max_step": step / 2}
    return np.asarray(solve_ivp(rate, (0, end), [0, 0], t_eval=times, **limits).y[0])


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.5])
def test_spectrum_against_an_integration_in_time(damping: float) -> None:
    samples, step = np.concatenate((broken_line(), np.zeros(60))), 0.02
    for period in (0.1, 0.4):
        moved = integrated(samples, step, period, damping)
        expected = (2 * math.pi / period) ** 2 * np.abs(moved).max()
        found = response_spectrum(samples[:61], step, period, damping)
        assert found == pytest.approx([expected], rel=1e-6)


def test_spectrum_of_a_step_in_closed_form() -> None:
    """A constant acceleration moves an undamped oscillator by twice its static displacement."""
    spectrum = response_spectrum(np.full(2001, 3.0), 0.001, [0.5, 1.0], damping=0.0)
    np.testing.assert_allclose(spectrum, 6.0, rtol=1e-5)


def test_spectrum_of_a_short_pulse_has_its_peak_after_it() -> None:
    """The impulse I gives the undamped oscillator the velocity I: PSA = w I."""
    step, periods = 1e-4, np.array([0.5, 2.0])
    spectrum = response_spectrum(np.array([0.0, 7.0, 0.0]), step, periods, damping=0.0)
    np.testing.assert_allclose(spectrum, 2 * math.pi / periods * 7.0 * step, rtol=1e-4)


def test_ends_of_the_spectrum() -> None:
    """A stiff oscillator follows the ground; a soft one lags behind by all of its displacement."""
    step = 0.01
    samples = np.sin(2 * np.pi * np.arange(101) * step) * 2.0
    stiff, soft = response_spectrum(samples, step, [0.005, 500.0])
    pga, _, pgd = peak_ground(samples, step)
    assert stiff == pytest.approx(pga, rel=5e-3)
    assert soft == pytest.approx((2 * np.pi / 500.0) ** 2 * pgd, rel=2e-2)


def test_peaks_of_a_constant_acceleration() -> None:
    samples, step = np.full(101, -2.0), 0.01
    assert peak_ground(samples, step) == pytest.approx((2.0, 2.0, 1.0))
    velocity, displacement = velocity_and_displacement(samples, step)
    times = step * np.arange(101)
    np.testing.assert_allclose(velocity, -2 * times, atol=1e-12)
    np.testing.assert_allclose(displacement, -(times**2), atol=1e-12)


def test_displacement_is_exact_for_a_ramp() -> None:
    times = 0.1 * np.arange(11)
    velocity, displacement = velocity_and_displacement(3 * times, 0.1)
    np.testing.assert_allclose(velocity, 1.5 * times**2, atol=1e-12)
    np.testing.assert_allclose(displacement, 0.5 * times**3, atol=1e-12)


def test_arias_intensity_and_duration_in_closed_form() -> None:
    """Constant: pi/(2 g) a^2 t, 90 % of the time; a ramp: the integral of a square is exact."""
    step = 0.01
    constant = np.full(1001, 2.0)
    assert arias_intensity(constant, step) == pytest.approx(math.pi / (2 * G) * 4.0 * 10.0)
    assert significant_duration(constant, step) == pytest.approx(9.0)
    assert significant_duration(constant, step, 0.05, 0.75) == pytest.approx(7.0)
    ramp = np.array([0.0, 6.0])
    assert arias_intensity(ramp, 2.0) == pytest.approx(math.pi / (2 * G) * 24.0)
    assert significant_duration(np.zeros(9), step) == 0.0


def test_a_motion_keeps_its_samples_where_others_come_between() -> None:
    """The broken line is that of the samples; what is near enough is left as it is."""
    value = np.array([0.0, 1.0, -2.0, 0.5])
    even = SampledMotion(time=1.0 + 0.02 * np.arange(4), value=value, step=0.02)
    samples, step = even.evenly_spaced(0.02)
    assert samples is value
    assert step == 0.02
    samples, step = even.evenly_spaced(0.007)
    assert step == pytest.approx(0.02 / 3)
    np.testing.assert_allclose(samples[::3], value, atol=1e-15)
    np.testing.assert_allclose(samples[4:6], [0.0, -1.0], atol=1e-12)
    uneven = SampledMotion(time=np.array([0.0, 0.1, 0.15, 0.4]), value=value)
    samples, step = uneven.evenly_spaced(1.0)
    assert step == pytest.approx(0.05)
    np.testing.assert_allclose(samples, uneven.acceleration(step * np.arange(9)), atol=1e-12)


@pytest.mark.skipif(not RECORDS.is_dir(), reason="the records are not part of the project")
@pytest.mark.parametrize("name", LISTED)
def test_listed_spectra_of_records(name: str) -> None:
    """Read here by the shortest way: this tests the spectrum, not the reader."""
    lines = (RECORDS / f"{name}.AT2").read_text().splitlines()
    found = re.search(r"DT=\s*([\d.]+)", lines[3])
    assert found
    samples = np.array(" ".join(lines[4:]).split(), float)
    spectrum = response_spectrum(samples, float(found[1]), [0.2, 0.5, 1.0, 2.0])
    np.testing.assert_allclose(spectrum, LISTED[name], rtol=1e-3)


def highest(motion: dict[str, Any], end: float) -> float:
    """Highest frequency of the motion of a scene, Hz."""
    block = {"width": 0.5, "height": 1.0, "mass": 100.0, "model": "rigid"}
    scene = parse_scene({"block": [block], "motion": motion, "time": {"end": end}})
    return highest_frequency(read_ground(scene), end) / (2 * math.pi)


def test_a_sine_has_its_own_frequency() -> None:
    """And, since it begins and ends, a little beside it, whether after whole periods or not."""
    sine = {"kind": "sine", "amplitude_g": 0.3, "period": 0.25}
    for end in (10.0, 10.07):
        assert 4.0 <= highest(sine, end) < 6.0


def test_a_motion_that_goes_on_is_no_faster_for_it() -> None:
    """A run that ends in the middle of a record: less than twice the frequency of all of it."""
    record = {"kind": "synthetic", "magnitude": 6.5, "distance_km": 10.0, "seed": 3}
    whole, part = (highest(record, end) for end in (40.0, 3.0))
    assert 5.0 < part < 2 * whole
    assert whole < 100.0


def test_ground_at_rest_has_none() -> None:
    """0, in Hz."""
    assert highest({"kind": "none"}, 1.0) == 0.0
