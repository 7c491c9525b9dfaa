"""Pulses: closed forms against quadrature, signs, peaks, all directions together."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

from rockslip import parse_scene
from solver.excitation.kinds import base_motion
from solver.excitation.motion import read_ground
from solver.excitation.pulses import Pulse
from solver.scene.motion import (
    HalfSineSpec,
    OneSineSpec,
    RectangularSpec,
    RickerSpec,
    SineSpec,
)
from solver.study.overturning.blocks import PULSES

PULSE = {"amplitude_g": 0.5, "duration": 0.5, "start": 0.2}
SPECS = {
    "sine": SineSpec(amplitude_g=0.5, period=0.4, cycles=2.3, start=0.2),
    "half_sine": HalfSineSpec(**PULSE),
    "one_sine": OneSineSpec(**PULSE),
    "rectangular": RectangularSpec(**PULSE),
    "ricker": RickerSpec(**PULSE),
    "ricker backwards": RickerSpec(amplitude_g=-0.5, frequency=4.0, start=0.2),
}


def pulse(spec: Any) -> Any:
    found = base_motion(spec, 3.0)
    assert isinstance(found, Pulse)
    return found


@pytest.mark.parametrize(
    "spec",
    [
        *SPECS.values(),
        SineSpec(amplitude_g=0.2, period=0.02, cycles=1000),
        SineSpec(amplitude_g=-0.2, period=0.5, cycles=0.3),
    ],
)
def test_largest_and_last_velocity(spec: Any) -> None:
    """Against 2000 samples a period: a sine of 0.2 g and 0.02 s reaches A T/pi."""
    motion = pulse(spec)
    time = np.linspace(motion.start, motion.stop, 200001)
    speeds = motion.velocity(time)
    assert motion.peak_velocity == pytest.approx(np.abs(speeds).max(), rel=1e-4)
    assert motion.end_velocity == pytest.approx(speeds[-1], abs=1e-6 * motion.peak_velocity)


@pytest.mark.parametrize("name", SPECS)
def test_velocity_is_the_integral(name: str) -> None:
    motion = pulse(SPECS[name])
    for begin, end in ((motion.start, motion.stop), (motion.stop, motion.stop + 0.5)):
        time = np.linspace(begin, end, 2001)
        inside = [motion.acceleration(t) for t in time[1:-1]]
        edge = 1e-12 * (end - begin)
        ends = [motion.acceleration(t) for t in (begin + edge, end - edge)]
        acceleration = np.array([ends[0], *inside, ends[1]])
        velocity = np.array([motion.velocity(t) for t in time])
        change = cumulative_simpson(acceleration, x=time, initial=0)
        np.testing.assert_allclose(velocity - velocity[0], change, atol=1e-9)
    for function in (motion.acceleration, motion.velocity):
        assert function(motion.start - 1e-9) == 0.0
    assert motion.acceleration(motion.stop + 1e-9) == 0.0


@pytest.mark.parametrize("name", SPECS)
def test_peak_is_the_largest_acceleration(name: str) -> None:
    motion = pulse(SPECS[name])
    time = np.linspace(motion.start, motion.stop, 10001)
    largest = max(abs(motion.acceleration(t)) for t in time)
    assert motion.peak == pytest.approx(largest, rel=1e-6)
    assert motion.peak == pytest.approx(0.5 * 9.81)


def test_signs_and_places_of_the_peaks() -> None:
    """A positive amplitude first pushes towards +x; a Ricker wavelet in its middle."""
    assert pulse(SPECS["half_sine"]).acceleration(0.45) == pytest.approx(4.905)
    assert pulse(SPECS["one_sine"]).acceleration(0.325) == pytest.approx(4.905)
    assert pulse(SPECS["one_sine"]).acceleration(0.575) == pytest.approx(-4.905)
    ricker = pulse(SPECS["ricker"])
    assert ricker.acceleration(0.45) == pytest.approx(4.905)
    # its negative lobes lie where (pi f s)^2 = 3/2
    lobe = math.sqrt(1.5) / (math.pi * ricker.frequency)
    assert ricker.acceleration(0.45 - lobe) == pytest.approx(-2 * math.exp(-1.5) * 4.905)
    assert abs(ricker.acceleration(0.2)) < 1e-7 * 4.905


def test_frequency_of_a_ricker_wavelet() -> None:
    """Its spectrum is highest at f, and a duration means the frequency 3/duration."""
    motion = pulse(RickerSpec(amplitude_g=1.0, frequency=4.0))
    assert (motion.stop, pulse(RickerSpec(amplitude_g=1.0, duration=0.75)).frequency) == (0.75, 4.0)
    time = np.arange(0, 0.75, 1e-3)
    values = np.array([motion.acceleration(t) for t in time])
    frequencies = np.linspace(1, 8, 701)
    spectrum = np.abs(np.exp(-2j * np.pi * np.outer(frequencies, time)) @ values)
    assert frequencies[np.argmax(spectrum)] == pytest.approx(4.0, abs=0.011)


def ground(dimension: int, motion: dict[str, Any] | None) -> Any:
    block = {"width": 1.0, "height": 1.0, "density": 1.0, "model": "rigid"}
    content = {"dimension": dimension, "block": [block], "time": {"end": 1.0, "step": 0.1}}
    return read_ground(parse_scene(content | ({"motion": motion} if motion else {})))


def test_all_directions_together() -> None:
    push, heave, sway = (
        {"kind": "rectangular", "amplitude_g": a, "duration": d}
        for a, d in ((0.1, 1.0), (0.2, 0.5), (0.3, 0.25))
    )
    plane = ground(2, push | {"vertical": heave})
    np.testing.assert_allclose(plane.acceleration(0.2), [0.981, 1.962])
    np.testing.assert_allclose(plane.acceleration(0.8), [0.981, 0.0])
    space = ground(3, push | {"vertical": heave, "second": sway})
    np.testing.assert_allclose(space.acceleration(0.2), [0.981, 2.943, 1.962])
    alone = ground(3, {"second": sway})
    np.testing.assert_allclose(alone.acceleration(0.2), [0.0, 2.943, 0.0])
    assert not ground(2, None).moves
    assert not ground(2, {"kind": "none"}).moves


@pytest.mark.parametrize("frequency", [3.0, 20.0])
def test_the_ricker_wavelet_of_the_study_is_strongest_at_its_frequency(frequency: float) -> None:
    """The spectrum f^2 exp(-f^2/f0^2) has its peak at f0 = omega/(2 pi)."""
    pulse = PULSES["ricker"].motion(2.0, frequency)
    period = 2 * math.pi / frequency
    time = np.linspace(pulse.start, pulse.start + 200 * period, 40001)
    spectrum = np.abs(np.fft.rfft(pulse.acceleration(time)))
    found = np.fft.rfftfreq(len(time), float(time[1]))[int(np.argmax(spectrum))]
    assert found == pytest.approx(1 / period, rel=0.006)
    assert pulse.peak == pytest.approx(2.0)
