"""What `rockslip check` tells of a motion of the ground."""

from __future__ import annotations

import numpy as np

from solver.excitation.motion import BaseMotion
from solver.excitation.pulses import Pulse
from solver.excitation.sampled import SampledMotion
from solver.excitation.spectrum import (
    arias_intensity,
    longest_spacing,
    peak_ground,
    response_spectrum,
    significant_duration,
)
from solver.scene.motion import G_UNIT

Lines = list[tuple[str, str]]

PERIODS = (0.1, 0.2, 0.5, 1.0, 2.0, 4.0)
"""Periods of the spectrum, s."""


def describe_motion(motion: BaseMotion | None, step: float | None) -> Lines:
    """Names and texts: of sampled motions their measures, of others peak, span and velocity.

    The first name is empty: it is that of the direction. `step` is that of the run, s; None: it is
    not always the same.
    """
    if motion is None:
        return [("", "none")]
    peak = f"{motion.peak / G_UNIT:.4g} g = {motion.peak:.4g} m/s2"
    if isinstance(motion, SampledMotion):
        measures = _measures(motion)
        read = [("read as", motion.source)] if motion.source else []
        samples = [*read, ("samples", _samples(motion))]
        return [("", f"PGA {peak}"), *samples, *measures, _met(motion, step)]
    lines = [("", f"peak {peak}")]
    if isinstance(motion, Pulse):
        lines += [
            ("span", f"{motion.start:.4g} to {motion.start + motion.duration:.4g} s"),
            (
                "velocity",
                f"up to {motion.peak_velocity:.4g} m/s, {motion.end_velocity:.4g} m/s in the end",
            ),
        ]
    return lines


def _samples(motion: SampledMotion) -> str:
    """How many there are, and how far apart."""
    distances = np.diff(motion.time)
    apart = f"{distances.min():.4g} to {distances.max():.4g} s"
    if motion.step is not None:
        apart = f"{motion.step:.6g} s"
    span = f"{motion.duration:.6g} s long, from {motion.time[0]:.4g} s"
    return f"{len(motion.value)}, {apart} apart, {span}"


def _measures(motion: SampledMotion) -> Lines:
    """Peaks, duration, intensity and spectrum; g is 9.81 m/s^2."""
    values, step = motion.evenly_spaced(longest_spacing(PERIODS))
    _, _, moved = peak_ground(values, step)
    spectrum = response_spectrum(values, step, PERIODS) / G_UNIT
    pairs = [f"{period:g} s {value:.4f}" for period, value in zip(PERIODS, spectrum, strict=True)]
    return [
        ("PGV", f"{motion.peak_velocity:.4f} m/s"),
        ("PGD", f"{moved:.4f} m"),
        ("duration D5-95", f"{significant_duration(values, step):.2f} s"),
        ("Arias intensity", f"{arias_intensity(values, step):.4f} m/s"),
        ("PSA in g, 5 %", ", ".join(pairs)),
    ]


def _met(motion: SampledMotion, step: float | None) -> tuple[str, str]:
    """Whether the steps of the run meet all samples."""
    text = "they take the mean acceleration, no sample is skipped"
    if motion.step is None or step is None:
        return "steps", f"not those of the samples: {text}"
    parts, begin = motion.step / step, float(motion.time[0]) / step
    if abs(parts - round(parts)) > 1e-6 * parts or parts < 0.5:
        return "steps", f"{step:g} s does not divide {motion.step:.6g} s: {text}"
    if abs(begin - round(begin)) > 1e-6:
        return "steps", f"the first sample, at {motion.time[0]:.6g} s, is inside one: {text}"
    return "steps", f"{step:g} s divides {motion.step:.6g} s: {round(parts)} between two samples"
