"""A motion simulated for an earthquake and a site: kind = "synthetic"."""

from __future__ import annotations

from solver.excitation.sampled import SampledMotion
from solver.excitation.synthetic.suite_motion import synthetic_motion
from solver.scene.motion import SyntheticSpec


def signal(spec: SyntheticSpec, end: float, where: str) -> SampledMotion:
    """The motion of the seed; the same for the same spec, bit for bit."""
    return synthetic_motion(spec)
