"""What all steps share while no face joins: bodies, contact points, tangents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from solver.law.local_problem import LocalProblem
from solver.scheme.generalized_alpha import TangentWeights
from solver.stepping.active_set import Reach
from solver.stepping.delassus import Softening
from solver.stepping.point_table import PointTable
from solver.stepping.response import AnyResponse
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


@dataclass(frozen=True, slots=True)
class Tangents:
    """What bodies offer for one set of tangents."""

    weights: tuple[TangentWeights, ...]
    """Weights of the tangent of each body."""
    responses: Sequence[AnyResponse]
    """Responses of all bodies."""
    stiffness: int
    """How often the stiffness of bodies was made anew before."""

    @property
    def nbytes(self) -> float:
        """Memory that factors and compliances take on all ranks together, bytes."""
        return sum(response.nbytes for response in self.responses)
