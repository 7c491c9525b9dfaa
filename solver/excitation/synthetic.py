"""Synthetic ground motions by the stochastic method (Boore 1983, 2003), and a suite of them.

Noise under an envelope gets the amplitudes that an earthquake has on average. docs/synthetic.md
has the limits of the method. The suite stands in place of the recorded motions of the paper's
Table 1.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.excitation.point_source import duration, fourier_amplitude
from solver.excitation.sampled import SampledMotion
from solver.scene.checking import is_open
from solver.scene.motion import SyntheticSpec
from solver.types import Array

HIGH_PASS_PERIOD = 10.0
"""Period of the high-pass filter's corner, s; at 4 s it takes 1.3 % of the amplitude away."""
ENVELOPE_PEAK = 0.2
"""Time of the envelope's peak over its nominal length (Saragoni and Hart 1974; Boore 2003)."""
ENVELOPE_END = 0.05
"""Height of the envelope after its nominal length, over its peak."""
LENGTH = 2.0
"""Nominal length of the envelope over the duration of the strong shaking."""
CODA = 1.5
"""Length of a motion over the nominal one of its envelope, of which 0.4 % are left there."""
FADE = 2.0
"""Time in which a motion fades to nothing at its end, s."""
SETTLE = 30.0
"""Time after a motion in which what the filters still pass on dies out, s."""

EVENT, SITE, NOISE = 0, 1, 2
"""The streams of random numbers of one seed."""


def synthetic_motion(spec: SyntheticSpec) -> SampledMotion:
    """The motion of a spec; the same for the same spec, bit for bit."""
    value = spec.scale * acceleration(spec)
    return SampledMotion(
        time=spec.start + spec.dt * np.arange(value.size), value=value, step=spec.dt
    )


def acceleration(spec: SyntheticSpec) -> Array:
    """Samples before `spec.scale`, m/s^2: zero at both ends, which the ground is at rest at."""
    nominal = LENGTH * duration(spec.magnitude, spec.distance_km)
    times = np.arange(0.0, math.ceil(CODA * nominal) + spec.dt / 2, spec.dt)
    component = 1 if is_open(spec.component) else spec.component
    noise = _envelope(times / nominal) * _normals(spec.seed, (NOISE, component), times.size)
    # A power of two, long enough that nothing comes round to the beginning.
    size = 2 ** math.ceil(math.log2(times.size + SETTLE / spec.dt))
    white = np.fft.rfft(noise, size)
    white /= math.sqrt(np.mean(np.abs(white) ** 2))
    shaken = np.fft.irfft(white * _transfer(spec, size), size)[: times.size] / spec.dt
    return at_rest(_deviation(spec) * shaken, spec.dt)


def _deviation(spec: SyntheticSpec) -> float:
    """Factor by which this earthquake and this site differ from the average ones."""
    event, site = (float(_normals(spec.seed, (stream,), 2)[0]) for stream in (EVENT, SITE))
    return math.exp(spec.event_sigma * event + spec.site_sigma * site)


def _normals(seed: int, stream: tuple[int, ...], count: int) -> Array:
    """Standard normal numbers, by Box and Muller's formula.

    numpy promises that raw numbers of PCG64 stay what they are, but not its normal ones.
    """
    bits = np.random.PCG64(np.random.SeedSequence(seed, spawn_key=stream))
    pairs = (count + 1) // 2
    raw = bits.random_raw(2 * pairs).reshape(2, pairs)
    first, second = (raw >> np.uint64(11)) * 2.0**-53
    size, angle = np.sqrt(-2 * np.log1p(-first)), 2 * np.pi * second
    return np.concatenate((size * np.cos(angle), size * np.sin(angle)))[:count]


def _envelope(part: NDArray[Any]) -> Array:
    """Over the nominal length; 1 at its peak (Boore 2003)."""
    power = ENVELOPE_PEAK * math.log(ENVELOPE_END)
    power /= -(1 + ENVELOPE_PEAK * (math.log(ENVELOPE_PEAK) - 1))
    since = part / ENVELOPE_PEAK
    return (since * np.exp(1 - since)) ** power


def _transfer(spec: SyntheticSpec, size: int) -> NDArray[np.complex128]:
    """From white noise to the acceleration; causal, so that nothing moves before the start."""
    frequency: Array = np.fft.rfftfreq(size, spec.dt).astype(float)
    frequency[0] = frequency[1]
    amplitude = fourier_amplitude(frequency, spec.magnitude, spec.distance_km, spec.vs30)
    displacement = minimum_phase(amplitude / (2 * np.pi * frequency) ** 2)
    turning = 2j * np.pi * np.fft.rfftfreq(size, spec.dt)
    corner = 2 * np.pi / HIGH_PASS_PERIOD
    high_pass = turning**2 / (turning**2 + math.sqrt(2) * corner * turning + corner**2)
    return turning**2 * displacement * high_pass


def minimum_phase(amplitude: Array) -> NDArray[np.complex128]:
    """The causal transfer function of this amplitude that answers soonest, by its cepstrum.

    The amplitude is positive, at the frequencies of `numpy.fft.rfft` of an even number of samples.
    """
    half = amplitude.size - 1
    fold = np.concatenate(([1.0], np.full(half - 1, 2.0), [1.0], np.zeros(half - 1)))
    return np.exp(np.fft.rfft(fold * np.fft.irfft(np.log(amplitude))))


def at_rest(acceleration: Array, step: float) -> Array:
    """The samples, faded out and less the two slow waves with which the ground would not stop.

    At the last sample acceleration, velocity and displacement are zero, with acceleration linear
    between samples.
    """
    fading = np.ones(acceleration.size)
    fading[0] = 0.0
    last = min(round(FADE / step), acceleration.size // 4)
    fading[-last:] = (1 + np.cos(np.pi * np.arange(1, last + 1) / last)) / 2
    faded = acceleration * fading
    part = np.linspace(0, 1, acceleration.size)
    bump = np.sin(np.pi * part) ** 2
    waves = np.stack((bump, bump * (part - 0.5)), axis=1)
    return faded - waves @ np.linalg.solve(_moments(waves), _moments(faded))


def _moments(acceleration: Array) -> Array:
    """Sums that are proportional to velocity and displacement at the end, where both ends are 0."""
    count = len(acceleration)
    return np.stack((np.ones(count), (count - 1.0) - np.arange(count))) @ acceleration / count


MAGNITUDES = (6.5, 6.9)
DISTANCES_KM = (20.0, 30.0)
VS30 = (180.0, 760.0)
"""Range of shear-wave velocities of NEHRP's classes D and C, m/s."""

EVENT_SIGMA = 0.30
"""Standard deviation between earthquakes, ln: BSSA14's tau, 0.21 to 0.35."""
SITE_SIGMA = 0.50
"""Between sites and paths: with what the noise itself varies it makes BSSA14's phi, 0.5 to 0.6."""


_DRAW = 3
"""The stream of random numbers of one seed that a motion itself makes no use of."""


def table1_suite(count: int = 30, seed: int = 1) -> list[SyntheticSpec]:
    """Motions of earthquakes and sites drawn evenly from Table 1's ranges, Vs30 in its logarithm.

    The first ones are the same however many; motion number i has the seed 1000 `seed` + i.
    """
    return [_drawn(1000 * seed + number) for number in range(1, count + 1)]


def _drawn(seed: int) -> SyntheticSpec:
    raw = np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(_DRAW,))).random_raw(3)
    parts = [float(value >> np.uint64(11)) * 2.0**-53 for value in raw]
    low, high = map(math.log, VS30)
    return SyntheticSpec(
        seed=seed,
        magnitude=round(_within(MAGNITUDES, parts[0]), 2),
        distance_km=round(_within(DISTANCES_KM, parts[1]), 1),
        vs30=float(round(math.exp(_within((low, high), parts[2])))),
        event_sigma=EVENT_SIGMA,
        site_sigma=SITE_SIGMA,
    )


def _within(ends: tuple[float, float], part: float) -> float:
    return ends[0] + part * (ends[1] - ends[0])
