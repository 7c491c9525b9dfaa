"""The balance of forces that a step, or an equilibrium, solves, and its solution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.contact.body_points import SurfaceState
from solver.contact.kinematics import ContactKinematics, Observed
from solver.contact.memory import Memory
from solver.law.friction import Bounds
from solver.parallel import global_sums
from solver.scheme.generalized_alpha import TangentWeights
from solver.stepping.convergence import ResidualTolerance
from solver.stepping.nonlinear import NewtonOutcome
from solver.stepping.point_table import joined
from solver.stepping.system import Body, System
from solver.types import Array

RESIDUAL_TOLERANCE = 1e-8
"""Residual that counts as zero, over the loads, where it balances itself on every body."""

RESULTANT_TOLERANCE = 3e-10
"""Acceleration of a body by the resultant of a residual that counts as zero, over the largest that
loads of the same norm give a body, some twice that of gravity: momentum that a step leaves out is
gone, while stress out of balance is taken in by the next step."""

STAGNANT_TOLERANCE = 1e-9
"""Residual over the loads that may be round-off where it no longer falls."""

ROUND_OFFS = 3.0
"""Least residual that counts as zero, over the estimate of its round-off: round-off is to decide
nothing. In the demo and in the scenes of `benchmarks/feature_cost.py`, what is left when no
correction helps is 0.3 to 1.3 of the estimate."""


class Balance(NamedTuple):
    """What is solved for u: internal forces + mass M (u - start - way) + constant = contact."""

    contact: Sequence[Memory]
    """Memory of each interface that the step starts from, in the frame of the step."""
    weights: Sequence[TangentWeights]
    """Weights of the tangent of each body."""
    constant: Array
    """Loads, inertia of the old state (owned unknowns), N."""
    load: Array
    """The loads alone; a residual is small or large in relation to them."""
    start: Array
    """u_n, m."""
    way: Array | None
    """dt v_n, m; None in equilibrium, where the mass term only steadies the tangent."""
    rotations: Sequence[Array | None]
    """Rotations of all bodies at t_n, (d, d) each; None in equilibrium."""
    step: float = np.inf
    """dt, s, for the speed of slip; infinite in equilibrium."""
    glued: bool = False
    """Whether closed points hold any friction."""

    @property
    def static(self) -> bool:
        """Whether it is an equilibrium."""
        return self.way is None

    @property
    def contact_weight(self) -> float:
        """w_c, the same for all bodies."""
        return self.weights[0].contact

    def tolerance(self, system: System, guess: Array) -> ResidualTolerance:
        """What counts as zero: a part of the forces, or round-off of the stresses.

        Displacements at both ends of the step, the guess (m) among them, make the round-off: a body
        that comes down without loads may touch just where its displacement is zero.
        """
        reached = np.maximum(np.abs(guess), np.abs(self.start))
        squares: list[float] = []
        for body, own, weights in zip(system.bodies, system.slices, self.weights, strict=True):
            load, constant = self.load[own], self.constant[own]
            squares += float(load.dot(load)), float(constant.dot(constant))
            squares.append(body.round_off(reached[own], weights))
        squares = global_sums(system.comm, squares)
        loads, inertias, rough = squares[::3], squares[1::3], squares[2::3]  # of each body
        given = loads if any(loads) else inertias
        scale, least = math.sqrt(sum(given)), ROUND_OFFS * math.sqrt(sum(rough))
        accelerations = [
            max(
                RESULTANT_TOLERANCE * math.sqrt(body.unknowns * square),
                ROUND_OFFS * math.sqrt(left),
            )
            / body.mass
            for body, square, left in zip(system.bodies, given, rough, strict=True)
        ]
        return ResidualTolerance(
            norm=max(RESIDUAL_TOLERANCE * scale, least),
            acceleration=max(accelerations),
            round_off=max(STAGNANT_TOLERANCE * scale, least),
        )

    def smooth_residual(self, system: System, u: Array) -> tuple[Array, Array]:
        """Out-of-balance force at the displacement u (m) without that of contact, N.

        And M (u - start - way), kg m, from which its inertia is made; zero in equilibrium.
        """
        # Not from u_n + dt v_n: far from the origin that sum loses the digits of the difference.
        travel, static = None, self.way is None
        if self.way is not None:
            travel = u - self.start
            travel -= self.way
        forces, momenta = [], []
        for body, own, weights in zip(system.bodies, system.slices, self.weights, strict=True):
            # Internal forces are new arrays, which are added to here.
            force, constant = body.internal_force(u[own], static=static), self.constant[own]
            if force is None:
                force = constant.copy()
            else:
                force += constant
            if travel is not None:
                momentum = body.inertia(travel[own])
                momenta.append(momentum)
                force += weights.mass * momentum
            if body.has_spring:
                force += _spring(body, weights, u[own], None if travel is None else travel[own])
            forces.append(force)
        return joined(forces), joined(momenta) if momenta else np.zeros(u.shape)


def _spring(body: Body, weights: TangentWeights, u: Array, travel: Array | None) -> Array:
    """The averaged force of a spring and dashpot to the ground, which there is."""
    moved = weights.interface * u
    if travel is not None:
        moved += (weights.spring - weights.interface) * travel
    spring = body.spring(moved)
    assert spring is not None
    return spring


class Contact(NamedTuple):
    """One interface at the end of a step.

    Attributes:
        surface: Its points.
        kinematics: Their gaps and tangential positions.
        force: Point forces f, (points, d), N.
        bounds: Bounds of friction at all points.
        clear: As in its memory: how far it may move before anybody has to look at it, m.
    """

    surface: SurfaceState
    kinematics: ContactKinematics
    force: Array
    bounds: Bounds
    clear: float = 0.0

    @property
    def seen(self) -> Observed:
        """Its points, and where they are."""
        return self.surface, self.kinematics

    def is_unseen(self, before: Memory) -> bool:
        """Whether the step did not even look where it is: it stays as it was remembered before."""
        return self.surface is before.surface


class StepSolution(NamedTuple):
    """What balances, and how the iteration came to it."""

    u: Array
    """Displacement of the owned unknowns, m."""
    contacts: Sequence[Contact]
    """Interfaces and point forces; empty where the iteration did not converge."""
    residual: Array
    """What is left of the out-of-balance force, N."""
    inertia: Array
    """M (u - u_n - dt v_n), kg m; zero in equilibrium."""
    outcome: NewtonOutcome
    """How the iteration ended."""
    held: Array
    """The residual at the unknowns that do not move, `System.fixed`, N."""
