"""Links in a correction: how they answer a free motion and forces at contact points.

A correction sees a link as it sees a contact point, by a row G of its extension and the motion
K^-1 G^T that a force along it makes. Links are taken out of the local problem of contact: with the
tangent D of their forces N, and C = G K^-1 G^T, contact points find the compliance

    W - w_c^2 (G_c K^-1 G^T) (D^-1 + w_c C)^-1 (G_c K^-1 G^T)^T,

and tangents are taken anew until forces are those of the law at the extensions that they lead to.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from solver.bodies.attachment import Attachment, MeshedAttachment, RigidAttachment
from solver.stepping.attached import AttachedForces, StepAttached
from solver.stepping.delassus import Delassus
from solver.stepping.response import AnyResponse, DenseResponse, ElasticMotion, ElasticResponse
from solver.types import Array, Indices


class MeshedPlaceResponse:
    """How places of a meshed body move by forces on them, for one tangent."""

    def __init__(self, response: ElasticResponse, attachment: MeshedAttachment):
        """Solve for the motion by each unit force; collective."""
        self._attachment = attachment
        right = np.asfortranarray(attachment.rows.T.toarray())
        right[attachment.body.fixed] = 0.0
        self._columns: Array = np.asarray(response.compliance.factor.solve_many(right))
        along = np.zeros(attachment.body.size)
        along[:: attachment.body.dimension] = 1.0
        self._whole = attachment.read(along)[:, 0]
        """What each place moves by where all nodes move by 1; a held body needs none."""

    def motion(self, at: Array, force: Array) -> ElasticMotion:
        """The motion by forces on the places, (n, d), N, in the frame of the body."""
        turned = force @ at[1]
        return ElasticMotion(self._columns @ turned.ravel(), self._whole @ turned)

    def read(self, at: Array, motion: ElasticMotion) -> Array:
        """What a motion does to the places, (n, d), m; collective."""
        moved = self._attachment.read(motion.nodes)
        return np.asarray((moved + np.outer(self._whole, at[2] @ motion.push)) @ at[0].T)

    @staticmethod
    def plus(motion: ElasticMotion, other: ElasticMotion, factor: float) -> ElasticMotion:
        """A motion and another one times a factor."""
        nodes = motion.nodes + factor * other.nodes
        return ElasticMotion(nodes, motion.push + factor * other.push)


class RigidPlaceResponse:
    """How places of a rigid body move by forces on them, for one tangent."""

    def __init__(self, response: DenseResponse, attachment: RigidAttachment):
        """Take the diagonal of the tangent."""
        self._attachment, self._tangent = attachment, response.tangent

    def _rows(self, at: Any) -> Array:
        """Rows of the places at a configuration."""
        pose = np.zeros(len(self._tangent)) if at.pose is None else at.pose
        return self._attachment.rows(pose)

    def motion(self, at: Any, force: Array) -> Array:
        """The motion by forces on the places, (n, d), N, of all unknowns."""
        return np.asarray(np.tensordot(force, self._rows(at), 2) / self._tangent)

    def read(self, at: Any, motion: Array) -> Array:
        """What a motion does to the places, (n, d), m."""
        return np.asarray(self._rows(at) @ motion)

    @staticmethod
    def plus(motion: Array, other: Array, factor: float) -> Array:
        """A motion and another one times a factor."""
        return motion + factor * other


class PlaceResponse(Protocol):
    """How places of a body move by forces on them; motions and configurations are its own."""

    def motion(self, at: Any, force: Array) -> Any:
        """The motion by forces on the places, (n, d), N."""

    def read(self, at: Any, motion: Any) -> Array:
        """What a motion does to the places, (n, d), m; collective."""

    def plus(self, motion: Any, other: Any, factor: float) -> Any:
        """A motion and another one times a factor."""


def place_response(response: AnyResponse, attachment: Attachment) -> PlaceResponse:
    """How places of a body move, by its response for a tangent; collective."""
    if isinstance(attachment, MeshedAttachment):
        assert isinstance(response, ElasticResponse)
        return MeshedPlaceResponse(response, attachment)
    assert isinstance(response, DenseResponse)
    return RigidPlaceResponse(response, attachment)


MOST_ROUNDS = 40
"""Times that tangents of links are taken anew in a correction, at most."""

FULL_ROUNDS = 6
"""Times after which they are taken half way to where the last ones led: where a link flows, full
ways go to and fro."""

SETTLED_LINKS = 1e-9
"""Part of the largest force of a link within which forces are those of the law."""


class CorrectedBodies(NamedTuple):
    """Bodies in a correction, as links see them.

    Attributes:
        configurations: Of all bodies.
        free: Their free motions.
        read: Adds what a motion of a body does to augmented positions of all points to an array.
        shape: Of these positions, (points, d).
        weight: w_c.
    """

    configurations: Sequence[Any]
    free: Sequence[Any]
    read: Callable[[int, Any, Array], None]
    shape: tuple[int, ...]
    weight: float


class LinkCorrection:
    """Links in one correction: how they answer, and their part in the compliance of contact."""

    def __init__(
        self,
        step: StepAttached,
        forces: AttachedForces,
        places: Sequence[PlaceResponse],
        corrected: CorrectedBodies,
    ):
        """Take links at the iterate, places of all bodies, and the free motions of these."""
        self._step, self._links, self._places = step, forces.links, places
        self._members = step.attached.members
        self._weight = corrected.weight
        rows = forces.rows
        n = len(rows)
        self._motions: list[tuple[Indices, list[Any]]] = []
        """Of each body with places the directions that move it, and its motion by each of them."""
        self._compliance: Array = np.zeros((n, n))
        self._free: Array = np.zeros(n)
        self._readings: Array = np.zeros((n, *corrected.shape))
        for (number, _, own, _), place in zip(self._members, places, strict=True):
            at, along = corrected.configurations[number], rows[:, own]
            directions = np.flatnonzero(np.any(along != 0, axis=(1, 2)))
            motions: list[Any] = [place.motion(at, along[k]) for k in directions]
            for k, motion in zip(directions, motions, strict=True):
                self._compliance[:, k] += np.tensordot(along, place.read(at, motion), 2)
                corrected.read(number, motion, self._readings[k])
            self._free += np.tensordot(along, place.read(at, corrected.free[number]), 2)
            self._motions.append((directions, motions))
        self._change: Array = np.zeros(n)
        self._trial, self._rounds = forces.links.extension, 0
        self._bias: Array = np.zeros(n)
        self._tangent: Array = np.zeros((n, n))
        self._linearise()

    def _linearise(self) -> None:
        """Take tangents of the forces at the extensions of the trial."""
        links, n = self._links, len(self._free)
        law = self._step.law(self._trial)
        self._bias = law.force - links.force - law.slope * (self._trial - links.extension)
        matrix = np.eye(n) + self._weight * law.slope[:, None] * self._compliance
        self._tangent = np.asarray(np.linalg.solve(matrix, np.diag(law.slope)), dtype=np.float64)

    def _answer(self, free: Array) -> Array:
        """Change of forces by the tangents, for extensions that change by `free` without it."""
        soft = free - self._weight * self._compliance @ self._bias
        return np.asarray(self._bias + self._tangent @ soft)

    def positions(self, y: Array) -> Array:
        """Augmented positions of contact points where links answer the free motion, too."""
        return y - self._weight * np.tensordot(self._answer(self._free), self._readings, 1)

    def condensed(self, operator: Delassus) -> Delassus:
        """The compliance of contact with links that give way by their tangents."""
        near = self._readings[:, operator.near.number]
        part = np.tensordot(self._tangent, near, 1)
        W = operator.W - self._weight**2 * np.tensordot(near, part, ([0], [0]))
        return operator._replace(W=W)

    def follows(self, near: Indices, change: Array | None) -> bool:
        """Answer a change of forces of near points; True if tangents have to be others."""
        free = self._free
        if change is not None:
            pushed = np.tensordot(self._readings[:, near], change, 2)
            free = free + self._weight * pushed
        self._change = self._answer(free)
        reached = self._links.extension + free - self._weight * self._compliance @ self._change
        force, found = self._step.law(reached).force, self._links.force + self._change
        self._rounds += 1
        if np.abs(force - found).max() <= SETTLED_LINKS * np.abs(force).max():
            return False
        if self._rounds == MOST_ROUNDS:
            return False  # the residual of what it leads to is exact
        part = 1.0 if self._rounds < FULL_ROUNDS else 0.5
        self._trial = self._trial + part * (reached - self._trial)
        self._linearise()
        return True

    def moved(self, free: Sequence[Any]) -> list[Any]:
        """Free motions of all bodies with what the change of forces adds."""
        found = list(free)
        for (number, *_), place, (directions, motions) in zip(
            self._members, self._places, self._motions, strict=True
        ):
            for motion, change in zip(motions, self._change[directions], strict=True):
                found[number] = place.plus(found[number], motion, -self._weight * change)
        return found
