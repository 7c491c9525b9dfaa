"""The contact compliance of all bodies at candidate points: the Delassus operator of a correction.

    W = w_c sum over bodies G K^-1 G^T + softness,      m points, d rows each

with the softness of Nitsche's method, and in the normal direction of beds below the points. At
velocity level masses stand in the place of tangents, and nothing is soft.

One is kept for each set of tangents, and made anew where its points or the configurations of the
bodies have changed; where carriers turn, and feet move from step to step, in each solve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from solver.bodies.rigid_body import DenseBody
from solver.contact.bed import Yielding
from solver.contact.pairs import Link
from solver.kernels import meshed
from solver.stepping.point_table import PointTable
from solver.stepping.response import AnyResponse, CandidateSet
from solver.stepping.system import System
from solver.types import Array, Indices

RIGID_SOFTENING = 1e-9
"""Relative diagonal of W for points between rigid bodies, which makes their forces unique."""

MIXED_SOFTENING = 1e-12
"""Relative diagonal of W for points of a rigid body on a meshed one. The elasticity of the latter
tells how forces are shared, but is as small as that beside the motion of a light body as a whole;
with a larger diagonal, corrections would creep."""

WEIGHT_OVER_ROUND_OFF = 1e4
"""Weight of a rigid body over the change of its point forces that round-off of the places of its
points makes, at least."""

LARGEST_SOFTENING = 1e-5
"""The same diagonal at most, for round-off: W falls with the square of the step, and in the short
steps of an impact a light body would else be caught by the diagonal, not by the contact."""


class Delassus(NamedTuple):
    """The operator at some candidate points.

    Attributes:
        configurations: The configurations of the bodies that it was made with.
        near: The points, their frames and kinematics; behind contact points the places of links.
        couplings: How the points act on each body.
        W: (m, d, m, d), with the softness of the interfaces and of beds, m/N.
        softening: Part of the diagonal that only makes forces of rigid points unique, of contact
            points alone, m/N.
    """

    configurations: Sequence[Any]
    near: CandidateSet
    couplings: Sequence[Any]
    W: Array
    softening: Array

    @property
    def contacts(self) -> Indices:
        """Numbers of the contact points."""
        return self.near.number[: len(self.softening)]

    def fits(self, responses: Sequence[AnyResponse], configurations: Sequence[Any]) -> bool:
        """True if it is that of other configurations as well, as far as corrections need it."""
        places = zip(responses, configurations, self.configurations, strict=True)
        return all(response.close(now, before) for response, now, before in places)


@cache
def of_no_points(d: int) -> Delassus:
    """The operator where no point is near."""
    none = np.empty(0)
    near = CandidateSet(none.astype(np.int64), np.empty((0, d, d)), ())
    return Delassus((), near, (), np.empty((0, d, 0, d)), none)


@dataclass(slots=True)
class Tangents:
    """Responses of all bodies for one step size and rho_inf.

    Attributes:
        responses: Responses of all bodies.
        operator: The Delassus operator made last; None before the first.
    """

    responses: Sequence[AnyResponse]
    operator: Delassus | None = None

    @property
    def nbytes(self) -> float:
        """Memory that factors and compliances take on all ranks together, bytes."""
        return sum(response.nbytes for response in self.responses)


@dataclass(frozen=True, slots=True)
class Softening:
    """The diagonal that makes forces of rigid points unique.

    Attributes:
        relative: Part of the largest diagonal entry of a point, (points,); 0 for points that have a
            softness of their own.
        least: Smallest value in the present step, (points,), m/N.
        rigid: Numbers of the interfaces that have such points, and one or two rigid bodies.
    """

    relative: Array
    least: Array
    rigid: tuple[int, ...]

    @classmethod
    def of(cls, system: System, links: Sequence[Link], softness: Array) -> Softening | None:
        """The softening of all points, with no least value; None where no point needs any.

        The points' own softness is in m/N.
        """
        kinds = [RIGID_SOFTENING if system.rigid(link) else MIXED_SOFTENING for link in links]
        relative = np.repeat(kinds, [link.interface.count for link in links])
        relative = np.where(softness > 0, 0.0, relative)
        rigid = tuple(
            number
            for number, link in enumerate(links)
            if system.is_at_rigid(link) and not link.interface.softness.any()
        )
        return cls(relative, np.zeros_like(relative), rigid) if relative.any() else None

    def in_step(self, system: System, points: PointTable, load: Array) -> Softening:
        """The softening in a step: round-off of places is to mean little force; collective.

        Loads are those on the owned unknowns, N.
        """
        if not self.rigid:
            return self
        least = np.zeros_like(self.least)
        for link, own in ((points.links[number], points.own[number]) for number in self.rigid):
            weights = [
                float(np.linalg.norm(body.replicate(load[system.slices[number]])))
                for number, body in enumerate(system.bodies)
                if number in (link.body, link.carrier) and isinstance(body, DenseBody)
            ]
            lightest = min((weight for weight in weights if weight > 0), default=np.inf)
            round_off = float(np.finfo(float).eps) * link.interface.size
            least[own] = WEIGHT_OVER_ROUND_OFF * round_off / lightest
        return Softening(self.relative, least, self.rigid)

    def at(self, contacts: Indices, W: Array) -> Array:
        """The diagonal at contact points, the first ones of W, m/N, which is without it."""
        relative, least = self.relative.take(contacts), self.least.take(contacts)
        diagonal = own_compliance(W)[: len(contacts)]
        return np.maximum(relative * diagonal, np.minimum(least, LARGEST_SOFTENING * diagonal))


def own_compliance(W: Array) -> Array:
    """What the force at a point moves it by, at most, (m,), m/N, by W, (m, d, m, d)."""
    return np.asarray(np.einsum("ijij->ij", W).max(axis=1))


def assembled(
    responses: Sequence[AnyResponse],
    configurations: Sequence[Any],
    near: CandidateSet,
    *,
    contact_weight: float,
    softness: Array,
    beds: Yielding | None,
    softening: Softening | None,
) -> Delassus:
    """The operator, from the compliances of all bodies.

    Args:
        responses: Responses of all bodies.
        configurations: Their configurations.
        near: The candidate points, and behind all contact points the places of links.
        contact_weight: w_c.
        softness: 1/(gamma_h w) of all contact points, m/N.
        beds: How the beds below all points give way; None where there are none.
        softening: Of all points; None where none needs any.
    """
    m, d = near.frames.shape[:2]
    W = np.zeros((m, d, m, d))
    couplings = [
        response.couple(configuration, near, contact_weight, W)
        for response, configuration in zip(responses, configurations, strict=True)
    ]
    contacts = near.number[: near.number.searchsorted(len(softness))]
    added = np.zeros(len(contacts)) if softening is None else softening.at(contacts, W)
    meshed.add_softness(W, contacts, softness, added)
    if beds is not None:
        normal = W.reshape(-1)[:: d * (m * d + 1)][: len(contacts)]
        normal += beds.softness.take(contacts)
    return Delassus(configurations, near, couplings, W, added)
