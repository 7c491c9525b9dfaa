"""What all steps share while no face joins: bodies and contact points."""

from __future__ import annotations

from dataclasses import dataclass

from solver.law.local_problem import LocalProblem
from solver.stepping.active_set import Reach
from solver.stepping.delassus import Softening
from solver.stepping.point_table import PointTable
from solver.stepping.system import System


@dataclass(frozen=True, slots=True)
class ContactModel:
    """What all steps share while no face joins."""

    system: System
    """All bodies."""
    points: PointTable
    """All contact points."""
    local: LocalProblem
    """Solver of local problems."""
    reach: Reach
    """How near points have to be to be looked at."""
    softening: Softening | None
    """How rigid points give way; None where there are none."""
