"""The nonlinear problem of one step: its residual, and a correction that solves contact exactly.

The residual is the exact nonlinear one. The tangent of a meshed body is that of the undeformed one,
turned with the body's rotation R (K(u) = R K_0 R^T up to terms of the size of the strain), so that
a correction costs one back substitution and one small contact problem, which couples all bodies:

    du_f = -K^-1 r,    f = solution of the local problem with W = w_c sum over bodies G K^-1 G^T,
    du = du_f + w_c K^-1 G^T df.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from solver.bodies.dense_body import DenseBody
from solver.contact.kernels.candidates import candidates, free_values, put_away, take_over
from solver.parallel import global_sum
from solver.stepping.balance import Balance
from solver.stepping.carrier_edges import CarrierEdges, EdgeWatch
from solver.stepping.contact_forces import Contact, ContactIncrement, add_contact_forces
from solver.stepping.delassus import (
    Delassus,
    DelassusKey,
    LastDelassus,
    assembled,
)
from solver.stepping.friction_bounds import FrictionBounds
from solver.stepping.model import ContactModel, Tangents
from solver.stepping.point_table import Observed, joined
from solver.stepping.response import CandidateSet, Kinematics
from solver.stepping.sleepers import Sleepers
from solver.types import Array, Indices, Mask

MOST_FRICTION_ROUNDS = 50
"""How often a correction looks at the speeds that friction of these speeds leads to."""

PLACED_CORRECTIONS = 2
"""Corrections of a step that look where bodies are: later ones turn them no more to speak of."""

STEADYING = 0.99
"""Part of their difference that forces of rigid points keep from step to step where no motion tells
it (two corners that push against each other): with nothing to hold them back such forces grow until
their round-off shows, so they become even step by step."""


class Iterate(NamedTuple):
    """Where everything is at one displacement: u, and what each interface looks like there."""

    u: Array
    seen: Sequence[Observed]


class StepProblem:
    """A balance as SNES sees it, with the point forces of the iterate.

    Attributes:
        force: Point forces f of the present iterate, (points, d), N.
        friction: Bounds of friction.
        forces: Largest norm of the contact forces so far, N.
        held: Residual of the iterate at the unknowns that do not move, N.
        inertia: M (u - u_n - dt v_n) at the iterate, kg m; zero in equilibrium.
    """

    def __init__(
        self,
        model: ContactModel,
        tangents: Tangents,
        kept: LastDelassus,
        balance: Balance,
        guess: Array,
        *,
        number: int,
    ):
        """Start from what contact remembers and a guess of the displacement of all owned unknowns.

        `tangents` is what the bodies offer, `kept` the Delassus operator of earlier corrections,
        the number that of the solve.
        """
        self._model, self._tangents, self._kept, self._balance = model, tangents, kept, balance
        self._points, self._system = model.points, model.system
        self._static, self._weight = balance.static, balance.contact_weight
        memories = balance.contact
        self.force: Array = np.concatenate([memory.force for memory in memories])
        self._anchor = joined([memory.anchor for memory in memories])
        self._may_touch = joined([memory.may_touch for memory in memories])
        self.friction = FrictionBounds(
            model.points, memories, step=balance.step, glued=balance.glued
        )
        # The softening of rigid points acts on what forces differ by from these.
        self._softening, self._held = model.softening, self.force
        if model.softening is not None and not balance.static:
            self._softening = model.softening.in_step(model.system, model.points, balance.load)
            self._held = STEADYING * self.force
        self._edges = CarrierEdges(model.points, memories)
        self._beds = model.points.beds(memories, balance.step)
        self._watch = EdgeWatch()
        self.sleepers = Sleepers(model.system, model.points, balance, self._edges)
        self._number = 0
        for carrier, asleep in zip(model.points.carriers, self.sleepers.asleep, strict=True):
            if carrier.turns and not asleep:
                self._number = number
        self._iterate = Iterate(guess, ())
        self._kinematics: Kinematics = []  # at the iterate
        self._configurations: Sequence[Any] = ()
        self._corrections = 0
        self.forces = 0.0
        self.held: Array = np.empty(0)
        self.inertia: Array = self.held
        self._residual: Array = self.held

    def residual(self, u: Array) -> Array:
        """Out-of-balance force at u with the current point forces, N."""
        balance = self._balance
        residual, self.inertia = balance.smooth_residual(self._system, u)
        seen: list[Observed] = []
        asleep = self.sleepers.asleep
        for number, memory in enumerate(balance.contact):
            if asleep[number]:
                seen.append((memory.surface, memory.kinematics))
            else:
                seen.append(self._points.observe(number, u))
                self._subtract_contact(number, seen[-1], residual)
        if len(self._system.fixed):
            self.held = residual[self._system.fixed]
            residual[self._system.fixed] = 0.0
        self._iterate = Iterate(u, seen)
        self._kinematics = [
            None if asleep[number] else kinematics for number, (_, kinematics) in enumerate(seen)
        ]
        self._residual = residual
        return residual

    def acceleration(self) -> float:
        """Largest acceleration that the resultant of that force gives a body, m/s2.

        On rigid bodies all of it is resultant, moments by the metre.
        """
        system = self._system
        sums = np.zeros((len(system.bodies), system.dimension))
        for number, (body, own) in enumerate(system.members):
            force = self._residual[own]
            if isinstance(body, DenseBody):  # one rank has all of it, the others nothing
                sums[number, 0] = math.sqrt(force @ force)
            else:
                sums[number] = body.resultant(force)
        totals = global_sum(system.comm, sums)
        return max(
            math.hypot(*totals[number]) / body.mass for number, body in enumerate(system.bodies)
        )

    def _subtract_contact(self, number: int, seen: Observed, residual: Array) -> None:
        """Subtract the forces of an interface on both its bodies."""
        points, balance = self._points, self._balance
        link = points.links[number]
        increment = ContactIncrement(
            before=balance.contact[number],
            surface=seen[0],
            kinematics=seen[1],
            force=self.force[points.own[number]],
        )
        weights = balance.weights[link.body or 0]
        add_contact_forces(
            self._system,
            link,
            increment.in_equilibrium if self._static else increment,
            residual,
            traction_weight=weights.interface,
            contact_weight=weights.contact,
            sign=-1.0,
        )

    def correction(self, residual: Array) -> Array:
        """Free step, local contact problem, and the response to the change of the point forces."""
        self._corrections += 1
        if self._corrections <= PLACED_CORRECTIONS:
            self._configurations = self._placed()
        y, beyond = self.augmented()
        free = self._free(residual, y)
        near, pressed = self.near(y, beyond)
        if len(near):
            delassus = self._delassus(near, pressed)
            new = self._solved(delassus, y)
            weight, change = self._weight, np.empty(new.shape)
            squares = take_over(self.force, near, new, change)
            self.forces = max(self.forces, weight * math.sqrt(squares))
            for k, response in enumerate(self._tangents.responses):
                at, coupling = self._configurations[k], delassus.couplings[k]
                response.respond(at, coupling, delassus.near, change, weight, free[k])
        return joined(
            [
                response.owned(at, motion)
                for response, at, motion in zip(
                    self._tangents.responses, self._configurations, free, strict=True
                )
            ]
        )

    def _placed(self) -> Sequence[Any]:
        """The configurations of all bodies at the iterate."""
        return [
            response.at(self._iterate.u[own], start)
            for response, own, start in zip(
                self._tangents.responses,
                self._system.slices,
                self._balance.rotations,
                strict=True,
            )
        ]

    def _free(self, residual: Array, y: Array) -> list[Array]:
        """The free motions of all bodies; what they do to augmented positions is added to y."""
        frames, kinematics = self._points.frames, self._kinematics
        found = []
        for response, at, own in zip(
            self._tangents.responses, self._configurations, self._system.slices, strict=True
        ):
            free = response.free(at, residual[own])
            response.read(at, free, y, frames, kinematics)
            found.append(free)
        return found

    def augmented(self) -> tuple[Array, Mask | None]:
        """Augmented positions of all points at the iterate, and which are beyond an edge.

        The compression that is left of a bed counts in. All points of interfaces that sleep count
        as beyond an edge.
        """
        points, parts = self._points, []
        beyond = self.sleepers.points
        for number, (surface, kinematics) in enumerate(self._iterate.seen):
            parts.append(points.links[number].interface.augmented(surface, kinematics))
            off = None
            if not self.sleepers.asleep[number]:
                off = self._edges.beyond(number, kinematics)
            if off is not None and np.count_nonzero(off):
                none = np.zeros(points.count, dtype=np.bool_)
                beyond = none if beyond is None else beyond.copy()
                beyond[points.own[number]] = off
        y = joined(parts)
        if self._beds is not None:
            y[:, 0] += self._beds.offset
        return y, self._watch.settled(beyond)

    def near(self, y: Array, beyond: Mask | None) -> tuple[Indices, Mask]:
        """Numbers of the points that may be in contact at augmented positions y; which are pressed.

        Those of sleeping interfaces and beyond an edge are put far from their carrier in y,
        whatever their gap: a foot far beyond an edge goes to and fro with the face.
        """
        points = self._points
        if beyond is not None:
            put_away(y, beyond, points.size)
        number, pressed = np.empty(len(y), dtype=np.int64), np.empty(len(y), dtype=np.bool_)
        count = candidates(y, points.reach, self._may_touch, self.force, number, pressed)
        return number[:count], pressed[:count]

    def _delassus(self, near: Indices, pressed: Mask) -> Delassus:
        """The operator at candidate points."""
        tangents = self._tangents
        step = 0.0 if self._beds is None else self._balance.step
        key = DelassusKey(near.tobytes(), tangents.weights, tangents.stiffness, step, self._number)

        def make() -> Delassus:
            """Compliances of all bodies as they are at the iterate."""
            return assembled(
                key,
                tangents.responses,
                self._configurations,
                CandidateSet(near, self._points.frames_at(near), self._kinematics, pressed),
                contact_weight=self._weight,
                softness=self._points.softness,
                beds=self._beds,
                softening=self._softening,
            )

        return self._kept.get(key, tangents.responses, self._configurations, make)

    def _solved(self, delassus: Delassus, y: Array) -> Array:
        """Forces of the near points that obey the contact law after the free step to y."""
        points, near, W = self._points, delassus.near.number, delassus.W
        force, q = np.empty(W.shape[:2]), np.empty(W.shape[:2])
        free_values(
            near,
            W,
            y,
            self.force,
            self._anchor,
            points.softness,
            delassus.softening,
            self._held,
            points.round_off,
            force,
            q,
        )
        if self._beds is not None:
            q[:, 0] += self._beds.softness[near] * force[:, 0]
        if not self.friction.steady:
            slip = y[:, 1:] - self._anchor
            self.friction.tell(slip + points.softness[:, None] * self.force[:, 1:])
        for _ in range(MOST_FRICTION_ROUNDS):
            bounds = self.friction.at(near)
            force = self._model.local.solve(W, q, force, bounds, near)
            if not self.friction.follows(near, W, q, force):
                break
        return force

    def continues(self, u: Array) -> bool:
        """Whether the solution u is none: an interface wakes up, or points break loose in it."""
        return self.sleepers.wake(u) or self.friction.break_loose(self.force)

    def contacts(self) -> list[Contact]:
        """Every interface at the end of the step, after `continues` was asked."""
        found, sleepers = [], self.sleepers
        for number, own in enumerate(self._points.own):
            asleep = sleepers.asleep[number]
            surface, kinematics = sleepers.seen(number) if asleep else self._iterate.seen[number]
            force, bounds = self.force[own], self.friction.bounds[number]
            found.append(Contact(surface, kinematics, force, bounds, sleepers.clear(number)))
        return found
