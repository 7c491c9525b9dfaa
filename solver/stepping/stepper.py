"""Steps of bodies in contact: start, advance, and the energy ledger of each step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from functools import lru_cache, partial
from typing import Any

import numpy as np

from solver.bodies.elastic_body import ElasticBody
from solver.contact.memory import contact_changed
from solver.contact.pairs import ContactPair, Link
from solver.excitation.motion import GroundMotion
from solver.law.local_problem import LocalProblem
from solver.parallel import any_rank
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.attached import UNATTACHED, Attached, StepAttached
from solver.stepping.balance import (
    Balance,
    Step,
    StepSolution,
    balance_of,
    consistent,
    extrapolated,
    impulsive_forces,
    inertia_force,
    remembered,
    static_weights,
    turned,
)
from solver.stepping.contact_solve import ContactSolve, StepFailed
from solver.stepping.impulses import UNCHANGED, VelocityCorrection, VelocityImpulses
from solver.stepping.interfaces import Active, Interfaces, StepStart
from solver.stepping.ledger import StepEnds, beyond_law, numerical_loss, step_sums
from solver.stepping.point_table import joined
from solver.stepping.pushes import pushes
from solver.stepping.reactions import (
    HeldForces,
    forces_at_rest,
    ground_forces,
    with_impulses,
)
from solver.stepping.state import Exchange, GroundForces, RotationPrediction, State
from solver.stepping.system import System
from solver.types import Array


class Stepper:
    """Time stepping of all bodies of a scene."""

    def __init__(
        self,
        system: System,
        contacts: Sequence[ContactPair],
        scheme: GeneralizedAlpha,
        *,
        gravity: Array,
        ground: GroundMotion | None = None,
        velocity_solve: bool = True,
        petsc_options: Sequence[str] = (),
        attached: Attached | None = None,
    ):
        """Set the solver up.

        Args:
            system: The bodies.
            contacts: Pairs of bodies that may touch.
            scheme: Time stepping.
            gravity: Acceleration of gravity, (d,), m/s2.
            ground: Motion of the ground; None for ground at rest.
            velocity_solve: True if contact is also solved at velocity level after each step.
            petsc_options: Options for SNES.
            attached: Links and forces on bodies; None without any.
        """
        self.attached = attached
        self.system, self.scheme = system, scheme
        self._interfaces = Interfaces(system, contacts)
        self._active: Active | None = None
        self.links: tuple[Link, ...] = ()
        """The active interfaces."""
        self._stiffened: dict[int, tuple[Link, ...]] = {}
        self.gravity = gravity
        self._weight: Array = gravity @ system.directional_mass
        motion = ground if ground is not None and ground.moves else None
        self._shaken, still = motion is not None, np.zeros(system.dimension)
        self.base = motion.acceleration if motion else lambda time: still
        """Acceleration of the ground at a time, (d,), m/s2."""
        self.mean_base = lru_cache(maxsize=1)(motion.mean if motion else lambda time, dt: still)
        """Mean acceleration of the ground over a step: its start and length, m/s2."""
        self._weights = lru_cache(
            lambda scheme, dt: [body.weights(scheme, dt) for body in system.bodies]
        )
        self.velocity_solve = velocity_solve
        self.local = LocalProblem()
        self._petsc_options = tuple(petsc_options)
        self._resources = ExitStack()

    def join(self, active: Active) -> None:
        """Make these interfaces the active ones; tangents change with them."""
        if active is self._active or active == self._active:
            return
        self._active, links = active, self._interfaces.links(active)
        if links == self.links:
            return
        self.links = links
        self._rigid = [self.system.rigid(link) for link in self.links]
        for number, body in enumerate(self.system.bodies):
            own = tuple(k for k in self.links if k.body == number and k.interface.theta)
            if isinstance(body, ElasticBody) and own != self._stiffened.get(number, ()):
                body.stiffen([link.interface.theta_matrix(body.mass_matrix) for link in own])
                self._stiffened[number] = own
        self._resources.close()
        options, attached = self._petsc_options, self.attached
        self._solve = ContactSolve(self.system, self.links, self.local, options, attached)
        self._resources.callback(self._solve.close)
        self._impulses: VelocityImpulses | None = None

    def prepare(self, state: State, dt: float) -> StepStart:
        """Start of a step of length `dt` (s) from a state.

        Faces that have turned to others are active afterwards; the state stays as it is.
        """
        active = self._interfaces.active(state, dt, state.active)
        self.join(active)
        return self._interfaces.start(state, active, dt)

    def saved(self) -> dict[str, Any]:
        """Data that the digits of further steps depend on besides the state, for `resume`."""
        bodies = self.system.bodies
        self.local.forget()  # here as in a run that goes on from this
        return {
            "active": self._active,
            "strained": [getattr(body, "strained_at", None) for body in bodies],
            "solve": self._solve.saved(),
            "impulses": None if self._impulses is None else self._impulses.saved(),
            "counts": self.local.counts,
        }

    def resume(self, saved: dict[str, Any]) -> None:
        """Go on as another stepper of the same bodies would from where it was saved; collective."""
        for body, strained_at in zip(self.system.bodies, saved["strained"], strict=True):
            if isinstance(body, ElasticBody) and strained_at is not None:
                body.resume_stiffness(strained_at)
        self.join(saved["active"])
        self._solve.resume(saved["solve"])
        if saved["impulses"] is not None:
            self._impulses = VelocityImpulses(self.system, self.links, self.local)
            self._impulses.resume(saved["impulses"])
        self.local.counts = saved["counts"]

    def interface_energy(self, state: State) -> float:
        """Energy stored in all interfaces, J."""
        return self._interfaces.energy(state.active, state.contacts)

    def ground_forces(self, state: State) -> GroundForces:
        """Forces of the ground on bodies that it holds at the start of a run."""
        return forces_at_rest(self.system, state, self.gravity)

    def start(self, u: Array, v: Array, time: float = 0.0) -> State:
        """A state whose inertia balances stresses, without loads and contact forces (r_0 = 0)."""
        state = State(time, u, v, p=np.zeros_like(u), contacts=(), motions={})
        active = self._interfaces.active(state, 0.0, None)
        self.join(active)
        contacts = self._interfaces.fresh(active, state)
        return self._begun(state._replace(contacts=contacts, active=active))

    def _begun(self, state: State) -> State:
        """A state at the start, with what it stores, and where links begin."""
        state = consistent(self.system, self.links, state)
        if self.attached is None:
            return state
        links = self.attached.links
        memory = links.start(self.attached.observe(state.u).places)
        return state._replace(body_links=memory, spring=state.spring + links.energy(memory))

    def launch(self, state: State, v: Array) -> State:
        """The state with other velocities."""
        return self._begun(state._replace(v=v, turning=None, damped_until=0.0, motions={}))

    def static_start(
        self,
        u: Array,
        *,
        load: Array | None = None,
        start: State | None = None,
        glued: bool = False,
        pushed: bool = False,
        steady: float = 1e-7,
    ) -> State:
        """Gravity and loads in equilibrium with contact, at rest at t = 0: then the ground moves.

        Args:
            u: Where the search begins.
            load: Forces on the owned unknowns besides gravity, N; they belong to this start alone.
            start: A state whose contact memory is gone on from (loads that come one after another).
            glued: True if friction holds whatever it takes: where a block is about to slide, this
                is what holds it until it is let go.
            pushed: True if applied forces act as at t = 0.
            steady: Stiffness of the tangent against rigid motions of a body, over that against
                strain. Small ones cost the contact forces as many digits, of large ones each
                correction leaves a part in the error.

        Raises:
            StepFailed: Where there is no equilibrium.
        """
        state = start or self.start(u, np.zeros_like(u))
        self.join(state.active)
        system = self.system
        for body, own in system.members:
            body.begin_static(u[own])
        gravity = self.gravity @ system.directional_mass
        total = gravity if load is None else gravity + load
        attached, loads = self._attached_at_rest(u, pushed=pushed), total
        if attached is not None:
            loads = attached.with_loads(total, 1.0)
        balance = Balance(
            contact=state.contacts,
            weights=static_weights(system.bodies, steady),
            constant=-total,
            load=loads,
            start=u,
            way=None,
            rotations=[None] * len(system.bodies),
            glued=glued,
            attached=attached,
        )
        solution = self._solve.solve(balance, u)
        contacts, _ = remembered(self.links, state.contacts, solution.contacts, np.inf)
        rest, u = np.zeros_like(u), self.system.settled(solution.u)
        stands = self._begun(
            State(0.0, u, rest, p=rest, contacts=contacts, motions={}, active=state.active)
        )
        if not math.isfinite(stands.strain):
            raise StepFailed(beyond_law(system, u))
        return stands

    def _attached_at_rest(self, u: Array, *, pushed: bool) -> StepAttached | None:
        """Links and forces in an equilibrium; None without any."""
        if self.attached is None:
            return None
        applied = self.attached.applied(0.0, 0.0)
        return StepAttached(self.attached, u, applied * pushed, None, np.inf)

    def _load(self, time: float, dt: float) -> Array:
        """Body forces of gravity and of the accelerated ground, mean over a step, N.

        From the ground's velocity: no impulse goes missing, whatever the step.
        """
        if not self._shaken:
            return self._weight
        return (self.gravity - self.mean_base(time, dt)) @ self.system.directional_mass

    def advance(self, state: State, dt: float, end: float | None = None) -> tuple[State, Exchange]:
        """One step of length `dt` (s) from a state, which stays as it is.

        It ends at a time `end` (s): that of the state and dt, or what differs by round-off.

        Raises:
            StepFailed: The state can then be tried again with another step.
        """
        step = self._begin(state, dt)
        attached = step.attached
        balance = balance_of(self.system, state, step, self._weights(step.scheme, dt))
        guess = extrapolated(self.system, state, step.turning)
        try:
            solution = self._solve.solve(balance, guess)
            while attached and solution.on_places and attached.breaks_at(solution.on_places):
                solution = self._solve.solve(balance, guess)
        except StepFailed:
            self.join(state.active)
            raise
        return self._ended(state, step, solution, state.time + dt if end is None else end)

    def _begin(self, state: State, dt: float) -> Step:
        """Data that are settled before the solve."""
        start = self.prepare(state, dt)
        bodies = range(len(self.system.bodies))
        motions = [state.rigid_motion(self.system, number) for number in bodies]
        attached = None
        if self.attached is not None:
            applied = self.attached.applied(state.time, dt)
            attached = StepAttached(self.attached, state.u, applied, state.body_links, dt)
        turning = RotationPrediction.of([motion.spin for motion in motions], dt, state.turning)
        return Step(
            dt=dt,
            scheme=self.scheme.damped if state.is_damped(dt) else self.scheme,
            start=start,
            load=self._load(state.time, dt),
            turning=turning,
            p=turned(self.system, state.p, turning.halves),
            rotations=[motion.rotation for motion in motions],
            attached=attached,
        )

    def _ended(
        self, state: State, step: Step, solution: StepSolution, end: float
    ) -> tuple[State, Exchange]:
        """State at t_{n+1}, `end` (s), and the ledger of the step."""
        system, dt, old = self.system, step.dt, step.start.contacts
        u, du = solution.u, solution.u - state.u
        mean: Array = np.divide(du, dt)
        v = 2 * mean - state.v
        impulsive, residual = impulsive_forces(system, u, dt), solution.residual
        ends = StepEnds(dt, u, v, du, mean, impulsive, residual, solution.inertia)
        p = inertia_force(
            system, self.links, state, step, ends, solution.contacts, solution.on_places
        )
        at_supports: Array = np.empty(0)
        if len(system.fixed):
            at_supports, p[system.fixed] = p[system.fixed], 0.0
        contacts, lost = remembered(self.links, old, solution.contacts, dt)
        sums = step_sums(system, ends, p - step.p)
        if not math.isfinite(sums.energies.strain):
            self.join(state.active)
            raise StepFailed(beyond_law(system, u))
        correction = self._velocity_correction(u, v, solution, step, lost.friction)
        held, ground = state.held, None
        if system.grounded:
            forces = HeldForces(solution.held, at_supports)
            held, ground = ground_forces(system, state, step, ends, p, forces)
            if correction is not UNCHANGED:
                ground = with_impulses(system, ground, correction.change, dt)
        changed = any_rank(system.comm, contact_changed(old, contacts, self._rigid))
        pulled = UNATTACHED
        if step.attached is not None and solution.on_places is not None:
            pulled = step.attached.end(solution.on_places, state.time)
            changed = changed or bool(step.attached.breaks.any())
        new = State(
            time=end,
            u=system.settled(u),
            v=v + correction.change,
            p=turned(system, p, step.turning.halves),
            contacts=contacts,
            motions={},
            held=held,
            active=step.start.active,
            kinetic=sums.energies.kinetic - correction.contact - correction.friction,
            strain=sums.energies.strain,
            spring=sums.energies.spring + pulled.stored,
            body_links=pulled.memory,
            turning=step.turning,
            changed=changed,
            reversal=correction.reversal,
            damped_until=end + self.scheme.damped_time if changed else state.damped_until,
        )
        if self._interfaces.overlap(new):
            self.join(state.active)
            raise StepFailed("bodies move too far in one step")
        averaged = numerical_loss(sums, self.links, old=old, new=contacts, skew=step.scheme.skew)
        both = step.start.contacts, solution.contacts
        exchange = Exchange(
            input=pulled.work - float(sums.moved @ self.mean_base(state.time, dt)),
            friction=lost.friction + correction.friction,
            damping=sums.damping + pulled.lost,
            contact_damping=lost.damping,
            contact=lost.contact + correction.contact + step.start.exchanged,
            numerical=averaged,
            iterations=solution.iterations,
            ground=ground,
            pushes=partial(pushes, self.links, *both, correction.impulse, step.dt),
        )
        return new, exchange

    def _velocity_correction(
        self, u: Array, v: Array, solution: StepSolution, step: Step, rubbed: float
    ) -> VelocityCorrection:
        """Changes by contact at velocity level after a step in which friction took `rubbed`."""
        correction: VelocityCorrection | None = None
        pressed = [contact.force[:, 0] > 0 for contact in solution.contacts]
        closed = joined(pressed).nonzero()[0]
        if self.velocity_solve and len(closed):
            if self._impulses is None:
                self._impulses = VelocityImpulses(self.system, self.links, self.local)
            sides = zip(self._rigid, pressed, step.start.contacts, strict=True)
            lands = any(rigid and np.any(own & ~(old.force[:, 0] > 0)) for rigid, own, old in sides)
            how = step.dt, rubbed, lands
            correction = self._impulses.correct(u, v, solution.contacts, closed, *how)
        return correction or UNCHANGED
