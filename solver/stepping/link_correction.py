"""Links in a correction: how they answer a free motion and forces at contact points.

The operator of a correction holds places of links behind contact points, W = (W_cc, W_cp; W_pc,
W_pp). With the rows G of extensions on places and the tangent D of the forces N, links are taken
out of the local problem of contact, which finds the compliance

    W_cc - W_cp G^T (D^-1 + G W_pp G^T)^-1 G W_pc,

and tangents are taken anew until forces are those of the law at the extensions that they lead to.
"""

from __future__ import annotations

import numpy as np

from solver.stepping.attached import AttachedForces, StepAttached
from solver.stepping.delassus import Delassus
from solver.types import Array

MOST_ROUNDS = 40
"""Times that tangents of links are taken anew in a correction, at most."""

FULL_ROUNDS = 6
"""Times after which they are taken half way to where the last ones led: where a link flows, full
ways go to and fro."""

SETTLED_LINKS = 1e-9
"""Part of the largest force of a link within which forces are those of the law."""


class LinkCorrection:
    """Links in one correction: how they answer, and their part in the compliance of contact."""

    def __init__(self, step: StepAttached, forces: AttachedForces, moved: Array):
        """Take links at the iterate, and what free motions do to all places, (places, d), m."""
        self._step, self._links = step, forces.links
        self._rows = forces.rows[:, step.attached.moving].reshape(len(forces.rows), -1)
        self._free: Array = self._rows @ moved.ravel()
        self._force: Array = np.zeros_like(self._free)
        self._trial = self._reached = forces.links.extension
        self._rounds = 0
        self._linearise()

    def _linearise(self) -> None:
        """Take tangents of the forces at the extensions of the trial."""
        law, way = self._step.law(self._trial), self._trial - self._links.extension
        self._slope, self._bias = law.slope, law.force - self._links.force - law.slope * way
        self._coupled_by: Delassus | None = None

    def _couple(self, operator: Delassus) -> int:
        """Take G W_pc, G W_pp G^T and (D^-1 + G W_pp G^T)^-1 of an operator; rows of contact."""
        W, slope = _flat(operator), self._slope
        first = len(W) - self._rows.shape[1]
        if operator is not self._coupled_by:
            read: Array = self._rows @ W[first:]
            self._pushed, self._compliance = read[:, :first], read[:, first:] @ self._rows.T
            matrix = np.eye(len(slope)) + slope[:, None] * self._compliance
            self._tangent = np.linalg.solve(matrix, np.diag(slope))
            self._coupled_by = operator
        return first

    def answer(self, operator: Delassus, change: Array | None) -> Array:
        """Changes of forces at all points of the operator, (m, d), N, for those of contact points.

        None: contact forces do not change. Forces of links change by their tangents.
        """
        first, d = self._couple(operator), operator.W.shape[1]
        if change is None:
            change = np.zeros((first // d, d))
        free = self._free + self._pushed @ change.ravel()
        self._force = self._bias + self._tangent @ (free - self._compliance @ self._bias)
        self._reached = self._links.extension + free - self._compliance @ self._force
        return np.concatenate([change, -(self._force @ self._rows).reshape(-1, d)])

    def condensed(self, operator: Delassus) -> Delassus:
        """The operator of contact points alone, with links that give way by their tangents."""
        first, W, near = self._couple(operator), _flat(operator), operator.near
        pulled = W[:first, first:] @ self._rows.T
        alone = W[:first, :first] - pulled @ (self._tangent @ self._pushed)
        m, d = len(operator.contacts), operator.W.shape[1]
        near = near._replace(number=operator.contacts, frames=near.frames[:m])
        return operator._replace(near=near, W=alone.reshape(m, d, m, d))

    def settled(self) -> bool:
        """True if the last answer is that of the law; else tangents are others from now on."""
        expected, found = self._step.law(self._reached).force, self._links.force + self._force
        self._rounds += 1
        if np.abs(expected - found).max() <= SETTLED_LINKS * np.abs(expected).max():
            return True
        if self._rounds == MOST_ROUNDS:
            return True  # the residual of what it leads to is exact
        part = 1.0 if self._rounds < FULL_ROUNDS else 0.5
        self._trial = self._trial + part * (self._reached - self._trial)
        self._linearise()
        return False


def _flat(operator: Delassus) -> Array:
    """W of an operator as a matrix."""
    rows = operator.W.shape[0] * operator.W.shape[1]
    return operator.W.reshape(rows, rows)
