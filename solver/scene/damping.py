"""Rayleigh damping: the table `[damping]`, and that of a body."""

from __future__ import annotations

from dataclasses import dataclass

from solver.scene.checking import Checked
from solver.scene.ranges import NotNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class DampingSpec(Checked):
    """Rayleigh damping: `[damping]`, or `damping` of a body."""

    mass: NotNegative = 0.0
    """lambda_R, 1/s."""
    stiffness: NotNegative = 0.0
    """beta_R, s."""
