"""Contact at velocity level after each step, for all bodies at once (the paper's section 3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.bodies.dense_body import DenseBody
from solver.bodies.factorization import Factorization
from solver.contact.nitsche_points import same
from solver.contact.projection import in_frames
from solver.law.friction import Bounds
from solver.law.local_problem import LocalProblem
from solver.law.velocity import impulse_correction
from solver.stepping.contact_points import Contact, frames_at, joined
from solver.stepping.response import CandidateSet, DenseResponse
from solver.stepping.state import State
from solver.stepping.system import Link, System, response_of
from solver.types import Array, Indices


@dataclass(frozen=True, slots=True)
class VelocityCorrection:
    """Change of the velocity (owned unknowns) and the energy it takes (J)."""

    change: Array
    contact: float
    friction: float


class VelocityImpulses:
    """Impulses at closed points that keep them closed, and what they do to all bodies."""

    def __init__(self, system: System, links: Sequence[Link], local: LocalProblem):
        """Factorize the masses."""
        self.system, self.links = system, tuple(links)
        self._local = local
        self._responses = []
        for number, body in enumerate(system.bodies):
            factor: Factorization | Array
            if isinstance(body, DenseBody):
                factor = body.diagonal
            else:
                factor = Factorization(body.hold(body.mass_matrix.copy()))
            self._responses.append(response_of(system, number, links, factor))
        ends = np.cumsum([link.interface.count for link in links]).tolist()
        self._own = [slice(*pair) for pair in zip([0, *ends[:-1]], ends, strict=True)]
        # The mass of a meshed body commutes with rotations: on planes that do not turn G M^-1 G^T
        # does not change while the same points are closed.
        self._constant = not any(link.interface.carrier.turns for link in links) and not any(
            isinstance(body, DenseBody) and body.turns for body in system.bodies
        )
        self._closed: Indices = np.empty(0, dtype=np.int64)
        self._near = CandidateSet(self._closed, np.empty((0, 0, 0)), ())
        self._W: Array = np.empty((0, 0, 0, 0))

    def correct(
        self, state: State, contacts: Sequence[Contact], dt: float
    ) -> VelocityCorrection | None:
        """The correction after a step, or None where no solution was found."""
        force = joined([contact.force for contact in contacts])
        closed = (force[:, 0] > 0).nonzero()[0]
        W = self._delassus(closed, state, contacts)
        mu = joined([contact.bounds.mu for contact in contacts])
        cohesion = joined([contact.bounds.cohesion for contact in contacts])
        bounds = Bounds(mu[closed], dt * cohesion[closed])
        velocity = self._velocity(state, contacts)[closed]
        found = impulse_correction(self._local, velocity, W, dt * force[closed], bounds)
        if found is None:
            return None
        parts = []
        for response, own in zip(self._responses, self.system.slices, strict=True):
            change = response.respond(self._near, found.q, 1.0)
            parts.append(np.zeros(own.stop - own.start) if change is None else change)
        change = parts[0] if len(parts) == 1 else np.concatenate(parts)
        return VelocityCorrection(change, found.contact, found.friction)

    def _delassus(self, closed: Indices, state: State, contacts: Sequence[Contact]) -> Array:
        """G M^-1 G^T of the closed points, (m, d, m, d)."""
        if self._constant and same(closed, self._closed):
            return self._W
        m, d = len(closed), self.system.dimension
        frames = frames_at(closed, [link.interface.carrier.frame for link in self.links], self._own)
        self._near = CandidateSet(closed, frames, [contact.seat for contact in contacts])
        self._W = np.zeros((m, d, m, d))
        for response, own in zip(self._responses, self.system.slices, strict=True):
            if isinstance(response, DenseResponse):
                response.at(state.u[own])  # the mass of a meshed body commutes with rotations
            response.couple(self._near, 1.0, self._W)
        self._closed = closed
        return self._W

    def _velocity(self, state: State, contacts: Sequence[Contact]) -> Array:
        """Velocities of all points relative to their carriers, in their frames, (points, d)."""
        system, parts = self.system, []
        for link, contact in zip(self.links, contacts, strict=True):
            interface = link.interface
            own = system.part(state.u, link.body), system.part(state.v, link.body)
            velocity = interface.points.velocity(*own)
            if contact.seat.tip is not None:
                velocity = contact.seat.tip.carried(velocity)
            if link.carrier is not None and interface.carrier.points is not None:
                its = system.part(state.u, link.carrier), system.part(state.v, link.carrier)
                nodes = interface.carrier.points.velocity(*its)
                velocity = velocity - interface.carrier.carried(contact.seat, nodes)
            parts.append(in_frames(velocity, interface.carrier.frame))
        return parts[0] if len(parts) == 1 else np.concatenate(parts)
