"""Steps of an elastic body on a rigid plane: start, advance, and the energy ledger of each step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack

import numpy as np
from numpy.typing import NDArray

from solver.contact.compliance import Compliance
from solver.contact.faces import ContactFaces, carry_over
from solver.contact.local_problem import LocalProblem
from solver.contact.velocity import VelocityContact
from solver.dynamics.contact_solve import Balance, ContactSolve, Solution
from solver.dynamics.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.dynamics.state import Exchange, State
from solver.mechanics.elastic_body import ElasticBody, StrainWeights
from solver.mechanics.factorization import Factorization
from solver.parallel import global_sum

Array = NDArray[np.float64]


class StepFailed(Exception):
    """The nonlinear solve of a step did not converge."""


class Stepper:
    """Time stepping of one body over one interface."""

    def __init__(
        self,
        body: ElasticBody,
        faces: ContactFaces,
        scheme: GeneralizedAlpha,
        *,
        gravity: Array,
        base_acceleration: Callable[[float], Array] | None = None,
        velocity_solve: bool = True,
        petsc_options: Sequence[str] = (),
    ):
        """Set the solver up.

        Args:
            body: The elastic body.
            faces: Its faces, and what they may touch.
            scheme: Time stepping.
            gravity: Acceleration of gravity, (d,), m/s2.
            base_acceleration: Acceleration of the ground, t -> (d,), m/s2; None for ground at rest.
            velocity_solve: Whether contact is also solved at velocity level after each step.
            petsc_options: Options for SNES.
        """
        self.body, self.scheme, self._faces = body, scheme, faces
        self.gravity, self._base = gravity, base_acceleration
        self.velocity_solve = velocity_solve
        self.local = LocalProblem(faces.friction)
        # A step may go without its velocity solve: it is not worth the slow methods.
        self.velocity_local = LocalProblem(faces.friction, patience=1)
        self._petsc_options = tuple(petsc_options)
        self._resources = ExitStack()

    def _join(self, faces: frozenset[int]) -> None:
        """Let faces take part in contact; the tangent changes with them."""
        self.interface = self._faces.join(faces)
        if self.interface.theta:
            self.body.stiffen(self.interface.theta_matrix(self.body.mass_matrix))
        self._resources.close()
        self._solve = ContactSolve(self.body, self.interface, self.local, self._petsc_options)
        self._resources.callback(self._solve.destroy)
        self._velocity: VelocityContact | None = None

    def _turn(self, state: State) -> None:
        """Before a step: let faces join that turned to the plane, choose the points of corners.

        The interface energy that this loses is kept in the state, also where the step then fails;
        it is added to what contact dissipates.
        """
        rotation = self.body.rotation(state.u)
        facing = self._faces.facing(rotation)
        if facing != self._faces.joined:
            before, interface = self.interface.energy(state.contact), self.interface
            self._join(facing)
            fresh = self.interface.start(
                self.interface.points.evaluate(self.layer(state.u)), rotation
            )
            state.contact = carry_over(state.contact, interface, self.interface, fresh)
            state.exchanged += before - self.interface.energy(state.contact)
        state.exchanged += self.interface.turn(state.contact, rotation)

    def base(self, time: float) -> Array:
        """Acceleration of the ground, m/s2."""
        return np.zeros(self.body.dimension) if self._base is None else self._base(time)

    def start(self, u: Array, v: Array, time: float = 0.0) -> State:
        """A state whose inertia balances loads and stresses without contact forces (r_0 = 0)."""
        rotation = self.body.rotation(u)
        self._join(self._faces.facing(rotation))
        contact = self.interface.start(self.interface.points.evaluate(self.layer(u)), rotation)
        return self._consistent(State(time, u, v, np.zeros_like(u), contact))

    def static_start(self, u: Array, time: float = 0.0) -> State:
        """Gravity in equilibrium with contact, at rest; the ground begins with the first step.

        Raises:
            StepFailed: Where there is no equilibrium.
        """
        state = self.start(u, np.zeros_like(u), time)
        body = self.body
        # The mass term holds the rigid motions of the tangent, far below any elastic stiffness.
        steadying = (
            1e-9
            * body.material.longitudinal
            * float(self.interface.points.weight.sum())
            / body.mass
        )
        weights = TangentWeights(mass=steadying, stiffness=1.0, interface=1.0, contact=1.0)
        body.begin(u, state.v, StrainWeights(new=1.0, old=0.0))
        gravity = self.gravity @ body.directional_mass
        balance = Balance(
            contact=state.contact,
            weights=weights,
            constant=-gravity,
            load=gravity,
            drift=None,
            traction_weight=1.0,
        )
        solution = self._solved(balance, u, state.contact.force)
        contact, _, _ = self.interface.remember(state.contact, solution.surface, solution.force)
        return self._consistent(State(time, solution.u, state.v, state.p, contact))

    def _consistent(self, state: State) -> State:
        """Fill in p_0 = f - F(u_0) - C v_0 and the energies of a state."""
        body, interface = self.body, self.interface
        d = body.dimension
        body.begin(state.u, state.v, StrainWeights(new=1.0, old=0.0, rate=body.damping.stiffness))
        force = body.internal_force(state.u, static=True)
        surface = state.contact.surface
        without = np.zeros_like(state.contact.force)
        interface.points.layer.add(
            force.reshape(-1, d), -interface.nodal(surface, surface, without, 1.0, 1.0)
        )
        momentum = body.inertia(state.v)
        state.p = self._load(state.time) - force - body.damping.mass * momentum
        state.p[body.fixed] = 0.0
        kinetic, strain = global_sum(
            body.comm, np.array([0.5 * state.v @ momentum, body.strain_energy()])
        )
        state.kinetic, state.strain = float(kinetic), float(strain)
        return state

    def _load(self, time: float) -> Array:
        """Body forces of gravity and of the accelerated ground, N/m."""
        return (self.gravity - self.base(time)) @ self.body.directional_mass

    def layer(self, u: Array) -> Array:
        """Displacements of the surface layer, on every rank."""
        return self.interface.points.layer.gather(u.reshape(-1, self.body.dimension))

    def _solved(self, balance: Balance, guess: Array, force: Array) -> Solution:
        """Solve, or say why not."""
        solution = self._solve.solve(balance, guess, force)
        if not solution.outcome.converged:
            raise StepFailed(
                f"SNES: {solution.outcome.reason}, residual {solution.outcome.residual:.2e} N/m"
            )
        return solution

    def advance(self, state: State, dt: float) -> tuple[State, Exchange]:
        """One step of length `dt`.

        Raises:
            StepFailed: `state` can then be tried again with another step.
        """
        scheme, body, damping = self.scheme, self.body, self.body.damping
        self._turn(state)
        af, am, beta = scheme.alpha_f, scheme.alpha_m, scheme.beta
        load = (1 - af) * self._load(state.time + dt) + af * self._load(state.time)
        constant = (am - (1 - am) * (0.5 - beta) / beta) * state.p - load
        if damping.mass:
            constant += damping.mass * body.inertia(state.v)
        viscous = 2 * (1 - af) * damping.stiffness / dt
        strain_weights = StrainWeights(
            1 - af + viscous, af - viscous, -(1 - 2 * af) * damping.stiffness
        )
        body.begin(state.u, state.v, strain_weights)
        drift = state.u + dt * state.v
        balance = Balance(
            contact=state.contact,
            weights=scheme.weights(dt, damping.mass, damping.stiffness),
            constant=constant,
            load=load,
            drift=drift,
            traction_weight=1 - af,
        )
        solution = self._solved(balance, drift, state.contact.force)
        new, exchange = self._update(state, dt, solution)
        exchange.contact += state.exchanged
        exchange.iterations = solution.outcome.iterations
        return new, exchange

    def _update(self, state: State, dt: float, solution: Solution) -> tuple[State, Exchange]:
        """State at t_{n+1} and the ledger of the step."""
        scheme, body, interface = self.scheme, self.body, self.interface
        du = solution.u - state.u
        v = 2 * du / dt - state.v
        p = body.inertia(du - dt * state.v)
        p /= scheme.beta * dt**2
        p -= (0.5 / scheme.beta - 1) * state.p
        nodal = interface.nodal(state.contact.surface, solution.surface, solution.force, 0.0, 1.0)
        nodal /= -2 * scheme.beta
        interface.points.layer.add(p.reshape(-1, body.dimension), nodal)
        p[body.fixed] = 0.0
        contact, friction, lost = interface.remember(
            state.contact, solution.surface, solution.force
        )
        new = State(state.time + dt, solution.u, v, p, contact)
        exchange = self._ledger(state, new, dt, solution.residual)
        exchange.friction, exchange.contact = friction, lost
        if self.velocity_solve:
            self._correct_velocity(new, dt, exchange)
        return new, exchange

    def _ledger(self, state: State, new: State, dt: float, residual: Array) -> Exchange:
        """Energies of the new state before the velocity solve; what damping and averaging took."""
        body, damping = self.body, self.body.damping
        du, dv = new.u - state.u, new.v - state.v
        momentum = body.inertia(new.v)
        sums = [0.5 * new.v @ momentum, body.strain_energy(), residual @ du]
        sums += [body.increment_energy(), body.rate_energy()]
        sums += [du @ (new.p - state.p), *(body.directional_mass @ du)]
        if damping.mass:
            drag = body.inertia(du)
            sums += [drag @ du, drag @ dv]
        kinetic, strain, left, squared, rate, inertial, *rest = global_sum(
            body.comm, np.array(sums)
        )
        moved, dragged = np.array(rest[: body.dimension]), rest[body.dimension :]
        new.kinetic, new.strain = float(kinetic), float(strain)
        before, after = self.base(state.time), self.base(new.time)
        # skew du.dr, r = M a + F + C v - f: what the alpha average of r does not give back.
        increment = inertial + squared + moved @ (after - before)
        increment -= self.interface.theta_increment(state.contact.surface, new.contact.surface)
        increment += damping.stiffness * 2 * (squared / dt - rate)
        lost = damping.stiffness * squared / dt
        if dragged:
            increment += damping.mass * dragged[1]
            lost += damping.mass * dragged[0] / dt
        return Exchange(
            input=-float(moved @ (before + after)) / 2,
            damping=float(lost),
            # `left`: work of the out-of-balance force that the iteration left.
            numerical=float(self.scheme.skew * increment - left),
        )

    def _correct_velocity(self, new: State, dt: float, exchange: Exchange) -> None:
        """Solve contact at velocity level and book what it takes."""
        body, interface = self.body, self.interface
        if not (new.contact.force[:, 0] > 0).any():
            return
        if self._velocity is None:
            rows = interface.position_rows
            factor = Factorization(body.hold(body.mass_matrix.copy()))
            compliance = Compliance(body, interface.points, factor, rows, rows)
            self._velocity = VelocityContact(compliance, interface.frame, self.velocity_local)
        velocity = interface.points.values @ self.layer(new.v)
        correction = self._velocity.correct(velocity, new.contact.force, dt)
        if correction is None:
            return
        new.v = new.v + correction.change
        new.kinetic -= correction.contact + correction.friction
        exchange.contact += correction.contact
        exchange.friction += correction.friction
