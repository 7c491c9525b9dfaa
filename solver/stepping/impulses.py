"""Contact at velocity level after each step, for all bodies at once (the paper's section 3.4)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from solver.bodies.rigid_body import DenseBody
from solver.contact.kinematics import in_frames
from solver.contact.nitsche_points import same
from solver.contact.pairs import Link
from solver.kernels import meshed
from solver.law.friction import Bounds
from solver.law.local_problem import LocalProblem, image
from solver.law.velocity import impulse_correction
from solver.stepping.balance import Contact
from solver.stepping.delassus import Delassus, assembled
from solver.stepping.point_table import PointTable, joined
from solver.stepping.response import CandidateSet, repeat_compliances, saved_compliances
from solver.stepping.system import System, response_of
from solver.types import Array, Indices


class VelocityCorrection(NamedTuple):
    """Effect of contact at velocity level after a step.

    Attributes:
        change: Change of the velocity of the owned unknowns, or (1,) of all alike, m/s.
        contact: Energy it takes in the normal directions, J.
        friction: Energy it takes in the tangential directions, J.
        reversal: Speed at which what slipped in the step slips back at its end, m/s.
        impulse: Of all points, (points, d), N s; None: there is none.
    """

    change: Array
    contact: float
    friction: float
    reversal: float
    impulse: Array | None


UNCHANGED = VelocityCorrection(np.zeros(1), 0.0, 0.0, 0.0, None)
"""The correction where no point is closed, or none was found; on all ranks alike."""


def largest_reversal(closed: Indices, first: Indices, force: Array, velocity: Array) -> float:
    """The largest slip reversal of an interface at the end of a step, m/s.

    Args:
        closed: Numbers of the closed points, rising, (m,).
        first: Number of the first point of each interface, and of all points.
        force: Of the closed points, (m, d), N.
        velocity: Of the closed points at the end of the step, (m, d), m/s.
    """
    if len(first) == 2:
        return meshed.slip_reversal(force, velocity)
    ends = closed.searchsorted(first)
    parts = [slice(a, b) for a, b in pairwise(ends) if b > a]
    return max(meshed.slip_reversal(force[part], velocity[part]) for part in parts)


class VelocityImpulses:
    """Impulses at closed points that keep them closed, and what they do to all bodies."""

    def __init__(self, system: System, links: Sequence[Link], local: LocalProblem):
        """Factorize the masses."""
        self.system, self.links = system, tuple(links)
        self._points = PointTable(system, links)
        self._local = local
        self._first = np.array([*(own.start for own in self._points.own), self._points.count])
        self._responses = [
            response_of(system, number, links, body.mass_inverse())
            for number, body in enumerate(system.bodies)
        ]
        # The mass of a meshed body commutes with rotations: on planes that do not turn G M^-1 G^T
        # does not change while the same points are closed.
        turns = any(isinstance(body, DenseBody) and not body.clamped for body in system.bodies)
        self._changes = joined(
            [np.full(link.interface.count, turns or link.interface.carrier.turns) for link in links]
        )
        self._any_changes = bool(self._changes.any())
        self._kept: Delassus | None = None

    def saved(self) -> tuple[list[Any], Delassus | None]:
        """State that the digits of further corrections depend on, for `resume`."""
        return saved_compliances(self._responses), self._kept

    def resume(self, saved: tuple[list[Any], Delassus | None]) -> None:
        """Go on as others would from where they were saved; collective."""
        repeat_compliances(self._responses, saved[0])
        self._kept = saved[1]

    def correct(
        self,
        u: Array,
        v: Array,
        contacts: Sequence[Contact],
        pressed: Indices,
        dt: float,
        taken: float,
        lands: bool,
    ) -> VelocityCorrection | None:
        """The correction after a step at the points that are `pressed`; None: none was found.

        By displacements (m) at t_{n+1} and velocities (m/s) before it; friction took `taken` in the
        step, J; `lands`: a rigid body landed in it.
        """
        operator = self._operator(pressed, u, contacts)
        velocity, W = self._velocity(u, v, contacts).take(pressed, axis=0), operator.W
        if self._points.has_bed:
            velocity, W = self._held_by_beds(pressed, velocity, W)
        force, mu, cohesion = (
            joined(parts).take(pressed, axis=0)
            for parts in zip(
                *((c.force, c.bounds.mu, c.bounds.cohesion) for c in contacts), strict=True
            )
        )
        found = impulse_correction(
            self._local,
            velocity,
            W,
            dt * force,
            Bounds(mu, dt * cohesion, np.inf),
            taken,
            pressed,
            lands,
        )
        if found is None:
            return None
        after = velocity + image(operator.W, found.q)
        reversal = largest_reversal(pressed, self._first, force, after)
        impulse = np.zeros((self._points.count, self.system.dimension))
        impulse[pressed] = found.q
        change = self._change(operator, found.q)
        return VelocityCorrection(change, found.contact, found.friction, reversal, impulse)

    def _held_by_beds(self, closed: Indices, velocity: Array, W: Array) -> tuple[Array, Array]:
        """Velocities and W of closed points for which normal impulses on beds stay as they are.

        A bed transmits no impulse: its points go on with the velocity that they have. Their normal
        rows act on no other row, nor any on them.
        """
        on_bed = joined(
            [np.full(link.interface.count, link.interface.beds is not None) for link in self.links]
        )
        i = on_bed[closed].nonzero()[0]
        velocity, apart = velocity.copy(), W.copy()
        velocity[i, 0] = apart[i, 0] = apart[:, :, i, 0] = 0.0
        apart[i, 0, i, 0] = W[i, 0, i, 0]
        return velocity, apart

    def _change(self, operator: Delassus, impulse: Array) -> Array:
        """Change of the velocity of all owned unknowns by impulses (m, d) at the closed points."""
        parts = []
        for response, at, coupling in zip(
            self._responses, operator.configurations, operator.couplings, strict=True
        ):
            moved = response.moved_by(at, coupling, operator.near, impulse, 1.0)
            parts.append(response.owned(at, response.at_rest(), moved))
        return joined(parts)

    def _operator(self, closed: Indices, u: Array, contacts: Sequence[Contact]) -> Delassus:
        """G M^-1 G^T of the closed points; the last one where nothing else can have changed."""
        kept = self._kept
        if kept is not None and same(closed, kept.near.number):
            if not self._any_changes or not self._changes[closed].any():
                return kept
        kinematics = [contact.kinematics for contact in contacts]
        self._kept = assembled(
            self._responses,
            [
                response.of_mass(u[own])
                for response, own in zip(self._responses, self.system.slices, strict=True)
            ],
            CandidateSet(closed, self._points.frames_at(closed, kinematics), kinematics),
            contact_weight=1.0,
            softness=self._points.no_bed,
            beds=None,
            softening=None,
        )
        return self._kept

    def _velocity(self, u: Array, v: Array, contacts: Sequence[Contact]) -> Array:
        """Velocities of all points relative to their carriers, in their frames, (points, d)."""
        system, parts = self.system, []
        for link, contact in zip(self.links, contacts, strict=True):
            interface, kinematics = link.interface, contact.kinematics
            velocity = interface.points.velocity(
                system.part(u, link.body), system.part(v, link.body)
            )
            if kinematics.own_projection is not None:
                velocity = kinematics.own_projection.carried(velocity)
            if link.carrier is not None and interface.carrier.points is not None:
                nodes = interface.carrier.points.velocity(
                    system.part(u, link.carrier), system.part(v, link.carrier)
                )
                velocity = velocity - interface.carrier.carried(kinematics, nodes)
            parts.append(in_frames(velocity, kinematics.frame))
        return joined(parts)
