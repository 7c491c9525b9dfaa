"""Synthetic motions: amplitudes, medians against BSSA14, reproducibility, rest at the end."""

from __future__ import annotations

import hashlib
import math
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rockslip import parse_scene
from solver.excitation.motion import read_ground
from solver.excitation.point_source import (
    PERIODS,
    duration,
    effective_distance,
    fourier_amplitude,
    median_spectrum,
    site_factors,
)
from solver.excitation.sampled import SampledMotion
from solver.excitation.spectrum import (
    response_spectrum,
    significant_duration,
    velocity_and_displacement,
)
from solver.excitation.synthetic import (
    acceleration,
    minimum_phase,
    synthetic_motion,
    table1_suite,
)
from solver.scene.motion import SyntheticSpec

G = 9.81


def spectra(count: int, periods: tuple[float, ...]) -> NDArray[np.float64]:
    """PGA, then PSA, m/s^2, of motions in the middle of Table 1, with the seeds from 1000 on."""
    rows = []
    for seed in range(1000, 1000 + count):
        spec = SyntheticSpec(seed=seed)
        samples = acceleration(spec)
        spectrum = response_spectrum(samples, spec.dt, periods)
        rows.append([np.abs(samples).max(), *spectrum])
    return np.array(rows)


def loss(frequency: float, distance: float) -> float:
    """On the way, with the quality factor 180 f^0.45, and below the site, with kappa = 0.04 s."""
    quality = 180 * frequency**0.45
    return math.exp(-math.pi * frequency * (distance / (quality * 3500) + 0.04))


def digest(spec: SyntheticSpec) -> str:
    """Of the samples in 1e-5 m/s^2: far above rounding, far below what matters."""
    return hashlib.sha256(np.rint(acceleration(spec) * 1e5).astype("<i8").tobytes()).hexdigest()


def test_bssa14_on_rock_and_below_the_hinge() -> None:
    """By hand: M 5 (below M_h), 10 km, 760 m/s, PGA."""
    event = 0.4473 + 1.431 * -0.5 + 0.05053 * 0.25
    distance = math.sqrt(10**2 + 4.5**2)
    path = (-1.134 + 0.1917 * 0.5) * math.log(distance) - 0.008088 * (distance - 1)
    assert median_spectrum(5.0, 10.0, 760.0)[0] == pytest.approx(G * math.exp(event + path))
    np.testing.assert_allclose(site_factors(6.7, 25.0, 760.0), 1.0)
    # Softer ground amplifies long periods more than short ones; stronger shaking, less.
    soft, strong = site_factors(6.7, 25.0, 200.0), site_factors(6.7, 0.0, 200.0)
    assert soft[PERIODS.index(2.0)] > soft[0] > 1
    assert soft[0] > strong[0]


def test_amplitude_has_the_levels_of_its_source() -> None:
    """Two corners: f^2 M0 below both; (1 - e) fa^2 + e fb^2 in place of f^2 above both."""
    magnitude, distance = 6.7, effective_distance(6.7, 25.0)
    assert distance == pytest.approx(1e3 * math.hypot(25.0, 10**0.955))
    first, second, share = 10**-1.1422, 10**-0.3236, 10**-1.1035
    moment = 10 ** (1.5 * magnitude + 9.05)
    constant = 0.55 * 2 * math.sqrt(0.5) / (4 * math.pi * 2800 * 3500**3)

    low = fourier_amplitude(np.array([0.001]), magnitude, 25.0, 760.0)[0]
    level = constant * moment * (2 * math.pi * 0.001) ** 2 / distance * 1.0 * 1.19
    assert low == pytest.approx(level * loss(0.001, distance), rel=1e-3)

    high = fourier_amplitude(np.array([80.0]), magnitude, 25.0, 760.0)[0]
    corners = (1 - share) * first**2 + share * second**2
    level = constant * moment * (2 * math.pi) ** 2 * corners / distance * 3.96 * 1.02
    assert high == pytest.approx(level * loss(80.0, distance), rel=1e-3)


def test_spreading_and_duration_with_distance() -> None:
    away = [effective_distance(5.0, distance) for distance in (5.0, 80.0, 160.0)]
    near, far, further = (
        fourier_amplitude(np.array([0.01]), 5.0, distance, 760.0)[0] / loss(0.01, metres)
        for distance, metres in zip((5.0, 80.0, 160.0), away, strict=True)
    )
    assert near / far == pytest.approx(math.sqrt(40e3 * away[1]) / away[0])
    assert far / further == pytest.approx(math.sqrt(away[2] / away[1]))
    assert duration(6.7, 25.0) == pytest.approx(0.5 / 10**-1.1422 + 2.4 + 19.576 / 38 * 6, rel=1e-3)
    assert duration(6.7, 200.0) > duration(6.7, 100.0) > duration(6.7, 25.0)


def test_medians_are_those_of_bssa14() -> None:
    """The issue: PGA and PSA(0.5 s) within 10 %, 0.2 to 3 s within 15 %; here 250 seeds."""
    periods = tuple(period for period in PERIODS if 0.2 <= period <= 4.0)
    found = np.exp(np.log(spectra(250, periods)).mean(axis=0)) / G
    assert found[0] == pytest.approx(0.143, rel=0.10)
    assert found[1 + periods.index(0.5)] == pytest.approx(0.243, rel=0.10)
    median = dict(zip(PERIODS, median_spectrum(6.7, 25.0, 400.0) / G, strict=True))
    for period, value in zip(periods, found[1:], strict=True):
        assert value == pytest.approx(median[period], rel=0.15), period


def test_what_one_motion_is_like() -> None:
    """The duration of recorded ones, and deviations as docs/synthetic.md has them."""
    durations = [
        significant_duration(acceleration(SyntheticSpec(seed=s)), 0.005) for s in range(40)
    ]
    assert np.median(durations) == pytest.approx(11.8, abs=0.3)
    spread = np.log(spectra(100, (0.5, 1.0, 3.0))).std(axis=0)
    np.testing.assert_allclose(spread, (0.12, 0.21, 0.25, 0.34), atol=0.05)


@pytest.mark.parametrize(("magnitude", "dt"), [(4.0, 0.001), (6.7, 0.005), (8.0, 0.02)])
def test_the_ground_is_at_rest_at_both_ends(magnitude: float, dt: float) -> None:
    spec = SyntheticSpec(magnitude=magnitude, dt=dt)
    samples = acceleration(spec)
    velocity, displacement = velocity_and_displacement(samples, dt)
    assert samples[0] == 0.0
    assert abs(samples[-1]) < 1e-12
    assert abs(velocity[-1]) < 1e-10 * np.abs(velocity).max()
    assert abs(displacement[-1]) < 1e-10 * np.abs(displacement).max()
    # Not by force: the displacement swings about zero.
    assert 0.2 < -displacement.min() / displacement.max() < 5
    assert (len(samples) - 1) * dt == pytest.approx(round((len(samples) - 1) * dt))


def test_minimum_phase_is_causal_and_keeps_the_amplitude() -> None:
    """1/(a + i w) is the minimum-phase function of its own size: exp(-a t) from t = 0 on."""
    step, size, rate = 0.01, 8192, 3.0
    w = 2 * np.pi * np.fft.rfftfreq(size, step)
    sampled = step / (1 - np.exp(-rate * step - 1j * w * step))
    found = minimum_phase(np.abs(sampled))
    np.testing.assert_allclose(found, sampled, rtol=1e-9, atol=1e-12)


def test_motions_are_what_they_were() -> None:
    """In another process, too, whose hashes and allocations differ."""
    spec = SyntheticSpec(seed=7, event_sigma=0.3, site_sigma=0.5)
    samples = acceleration(spec)
    np.testing.assert_array_equal(samples, acceleration(spec))
    code = (
        "import hashlib\n"
        "from solver.excitation.synthetic import acceleration\n"
        "from solver.scene.motion import SyntheticSpec\n"
        "samples = acceleration(SyntheticSpec(seed=7, event_sigma=0.3, site_sigma=0.5))\n"
        "print(hashlib.sha256(samples.tobytes()).hexdigest())\n"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.split()[-1] == hashlib.sha256(samples.tobytes()).hexdigest()
    assert digest(spec) == "da7b0dd0f07edd0d333cd50133adf0bf08ceb0e5de3cea06f15c15b102f264d1"


def test_what_the_keys_do() -> None:
    base = SyntheticSpec(seed=3)
    average = acceleration(base)
    for other in ({"seed": 4}, {"component": 2}, {"vs30": 300.0}, {"magnitude": 6.6}):
        changed = acceleration(replace(base, **other))
        assert changed.size != average.size or not np.allclose(changed, average)
    assert np.abs(acceleration(replace(base, vs30=250.0))).max() > np.abs(average).max()
    assert np.abs(acceleration(replace(base, distance_km=40.0))).max() < np.abs(average).max()
    motion = synthetic_motion(replace(base, scale=-2.0, start=1.5))
    np.testing.assert_array_equal(motion.value, -2.0 * average)
    assert motion.time[0] == 1.5
    assert motion.step == 0.005
    assert motion.acceleration(1.5 + 10.0) == pytest.approx(-2.0 * average[2000])


def test_variability_between_earthquakes_and_sites() -> None:
    """One factor, shared by the components of one seed, log-normal over seeds."""

    def factor(sigmas: dict[str, float], **which: int) -> float:
        varied, average = SyntheticSpec(**which, **sigmas), SyntheticSpec(**which)
        ratio = acceleration(varied)[1:-1] / acceleration(average)[1:-1]
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-6)
        return math.log(ratio[0])

    both = factor({"event_sigma": 0.3, "site_sigma": 0.5}, seed=9)
    assert both == pytest.approx(
        factor({"event_sigma": 0.3}, seed=9) + factor({"site_sigma": 0.5}, seed=9)
    )
    assert both == pytest.approx(
        factor({"event_sigma": 0.3, "site_sigma": 0.5}, seed=9, component=2)
    )
    drawn = np.array([factor({"event_sigma": 0.3}, seed=seed, dt=0.02) for seed in range(200)])
    assert abs(drawn.mean()) < 0.06
    assert drawn.std() == pytest.approx(0.3, rel=0.15)
    assert np.abs(drawn).max() < 1.2


def test_suite_of_table_1() -> None:
    suite = table1_suite()
    assert len(suite) == 30
    assert len({spec.seed for spec in suite}) == 30
    assert table1_suite(count=5) == suite[:5]
    assert not set(suite) & set(table1_suite(seed=2))
    large = table1_suite(count=400)
    magnitudes, distances, vs30 = np.array([(s.magnitude, s.distance_km, s.vs30) for s in large]).T
    for values, low, high in (
        (magnitudes, 6.5, 6.9),
        (distances, 20.0, 30.0),
        (vs30, 180.0, 760.0),
    ):
        assert low <= values.min() < low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) < values.max() <= high
    assert 150 < (vs30 < 360).sum() < 250
    assert {(spec.event_sigma, spec.site_sigma) for spec in suite} == {(0.3, 0.5)}


def test_directions_of_a_scene_do_not_repeat_one_another() -> None:
    """Without `component` those of one earthquake; with it what is asked for."""
    motion = {"kind": "synthetic", "vertical": {"kind": "synthetic"}}
    tables: dict[str, Any] = {
        "dimension": 3,
        "block": [{"width": 0.3, "height": 1.0, "mass": 100.0, "model": "rigid"}],
        "motion": motion | {"second": {"kind": "synthetic"}},
        "time": {"end": 1.0},
    }
    ground = read_ground(parse_scene(tables))
    along, second, up = ground.parts
    assert isinstance(along, SampledMotion)
    for other, number in ((second, 2), (up, 3)):
        assert isinstance(other, SampledMotion)
        assert np.array_equal(other.value, acceleration(SyntheticSpec(component=number)))
        assert abs(np.corrcoef(along.value, other.value)[0, 1]) < 0.1
    tables["motion"] = motion | {"second": {"kind": "synthetic", "component": 1}}
    along, second, _ = read_ground(parse_scene(tables)).parts
    assert isinstance(second, SampledMotion) and isinstance(along, SampledMotion)
    assert np.array_equal(second.value, along.value)
