"""What all steps share while no face joins: bodies, contact points, tangents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from solver.law.local_problem import LocalProblem
from solver.scheme.generalized_alpha import TangentWeights
from solver.stepping.delassus import Softening
from solver.stepping.point_table import PointTable
from solver.stepping.response import AnyResponse
from solver.stepping.system import System


@dataclass(frozen=True, slots=True)
class ContactModel:
    """What all steps share while no face joins.

    Attributes:
        system: All bodies.
        points: All contact points.
        local: Solver of local problems.
        softening: Of rigid points; None where there are none.
        turns: Whether a carrier turns with its body.
    """

    system: System
    points: PointTable
    local: LocalProblem
    softening: Softening | None
    turns: bool


@dataclass(frozen=True, slots=True)
class Tangents:
    """What bodies offer for one set of tangents.

    Attributes:
        weights: Weights of the tangent of each body.
        responses: Responses of all bodies.
        stiffness: How often the stiffness of bodies was made anew before.
    """

    weights: tuple[TangentWeights, ...]
    responses: Sequence[AnyResponse]
    stiffness: int
