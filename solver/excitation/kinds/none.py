"""No motion: kind = "none"."""

from __future__ import annotations

from solver.scene.motion import StillSpec


def signal(spec: StillSpec, end: float, where: str) -> None:
    """No motion; the arguments are those of `solver.excitation.motion.base_motion`."""
