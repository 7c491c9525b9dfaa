"""The nonlinear problem of one step, solved with one factorization.

The residual is the exact nonlinear one. The tangent is that of the undeformed body, turned with the
body's rotation R (K(u) = R K_0 R^T up to terms of the size of the strain), so that a correction
costs one back substitution and one small contact problem:

    du_f = -K^-1 r,    f = solution of the local problem with W = w_c G K^-1 G^T,
    du = du_f + w_c K^-1 G^T df.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solver.contact.compliance import Compliance
from solver.contact.local_problem import LocalProblem, NoContactSolution, image, row_sum_scaling
from solver.contact.plane_contact import ContactState, PlaneContact
from solver.contact.points import SurfaceState
from solver.dynamics.generalized_alpha import TangentWeights
from solver.dynamics.nonlinear import NonlinearSolver, Outcome
from solver.mechanics.elastic_body import ElasticBody
from solver.mechanics.factorization import Factorization
from solver.parallel import global_sum

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """The balance of forces to be solved for u: internal + mass M (u - drift) + constant = contact.

    Attributes:
        contact: Contact memory that the step starts from.
        weights: Of the tangent.
        constant: Loads, inertia of the old state (owned unknowns), N/m.
        load: The loads alone; a residual is small or large in relation to them.
        drift: u_n + dt v_n, m; None in equilibrium, where the mass term only steadies the tangent.
        traction_weight: Weight of the new traction in the theta term.
    """

    contact: ContactState
    weights: TangentWeights
    constant: Array
    load: Array
    drift: Array | None
    traction_weight: float


@dataclass(frozen=True, slots=True)
class Solution:
    """Displacement, surface and point forces that balance, and how SNES came to them.

    `residual` is what is left of the out-of-balance force.
    """

    u: Array
    surface: SurfaceState
    force: Array
    residual: Array
    outcome: Outcome


class ContactSolve:
    """SNES with the contact problem condensed inside its correction."""

    def __init__(
        self,
        body: ElasticBody,
        interface: PlaneContact,
        local: LocalProblem,
        options: Sequence[str],
    ):
        """Set SNES up for a body and its interface."""
        self.body, self.interface, self.local = body, interface, local
        self.points = interface.points
        functions = self._residual, self._correct, NoContactSolution
        self._solver = NonlinearSolver(body.comm, body.size, *functions, options)
        self._compliances: dict[TangentWeights, Compliance] = {}
        # Points farther from the plane than this after the free step are not pressed into it by the
        # others.
        self._margin = 0.002 * interface.points.size

    def destroy(self) -> None:
        """Free what PETSc holds; collective."""
        self._solver.destroy()

    def solve(self, balance: Balance, guess: Array, force: Array) -> Solution:
        """Solve a balance from a guess of displacement and point forces."""
        body = self.body
        self._balance, self._force = balance, force.copy()
        self._rotation = body.rotation(guess)
        self._factor = body.factorization(balance.weights)
        self._compliance = self._compliance_for(balance.weights, self._factor)
        self._near: Indices = np.empty(0, dtype=np.int64)
        u, outcome = self._solver.solve(guess, self._tolerance(guess))
        return Solution(u, self._surface, self._force, self._solver.residual, outcome)

    def _compliance_for(self, weights: TangentWeights, factor: Factorization) -> Compliance:
        """The compliance that belongs to a factorization."""
        if weights not in self._compliances:
            rows = self.interface.force_rows, self.interface.read_rows
            self._compliances[weights] = Compliance(self.body, self.points, factor, *rows)
        return self._compliances[weights]

    def _tolerance(self, u: Array) -> float:
        """Residual that counts as zero: a fraction of the forces, or round-off of the stresses."""
        balance, body = self._balance, self.body
        load, constant = balance.load, balance.constant
        squares = global_sum(body.comm, np.array([load @ load, constant @ constant, u @ u]))
        weight, inertia, length = (float(value) for value in np.sqrt(squares))
        node_mass = body.mass * body.dimension / body.unknowns
        stiffness = 0.6 * body.material.longitudinal + 0.1 * balance.weights.mass * node_mass
        return max(TOLERANCE * (weight or inertia), float(np.finfo(float).eps) * stiffness * length)

    def _residual(self, u: Array) -> Array:
        """Out-of-balance force at u with the current point forces."""
        body, balance = self.body, self._balance
        d = body.dimension
        residual = body.internal_force(u, static=balance.drift is None)
        residual += balance.constant
        if balance.drift is not None:
            residual += balance.weights.mass * body.inertia(u - balance.drift)
        nodes = u.reshape(-1, d)
        self._surface = self.points.evaluate(self.points.layer.gather(nodes))
        old = self._surface if balance.drift is None else balance.contact.surface
        contact = self.interface.nodal(
            old, self._surface, self._force, balance.traction_weight, balance.weights.contact
        )
        self.points.layer.add(residual.reshape(-1, d), -contact)
        residual[body.fixed] = 0.0
        return residual

    def _correct(self, residual: Array) -> Array:
        """Free step, local contact problem, and the response to the change of the point forces."""
        d, R, interface = self.body.dimension, self._rotation, self.interface
        turned = residual.reshape(-1, d) @ R
        free = -self._factor.solve(turned.ravel()).reshape(-1, d)
        layer = self.points.layer.gather(free)
        moved = (interface.read_rows @ layer.ravel()).reshape(-1, d)
        frame = interface.frame @ R
        y = interface.augmented(self._surface) + moved @ frame.T
        near = np.flatnonzero(
            (y[:, 0] < self._margin) & self._balance.contact.eligible | (self._force[:, 0] > 0)
        )
        if not len(near):
            return (free @ R.T).ravel()
        W, scaling, response = self._delassus(near, frame)
        force = self._force[near]
        # W holds the interface's own softness too, which is no part of y.
        q = y[near] - image(W, force) + force * interface.softness[near, None]
        q[:, 1] -= self._balance.contact.anchor[near]
        new = self.local.solve(W, q, force, scaling)
        self._force[near] = new
        change = self._balance.weights.contact * (response @ ((new - force) @ frame).ravel())
        return ((free + change.reshape(-1, d)) @ R.T).ravel()

    def _delassus(self, near: Indices, frame: Array) -> tuple[Array, Array, Array]:
        """W (m, 2, m, 2) with the interface's softness, its scaling, responses in body frame."""
        if not np.array_equal(near, self._near):
            W = self._balance.weights.contact * self._compliance.in_frame(near, frame)
            number = np.arange(len(near))
            for k in range(2):
                W[number, k, number, k] += self.interface.softness[near]
            response = self._compliance.of(near)[1]
            self._near, self._turned = near, (W, row_sum_scaling(W), response)
        return self._turned
