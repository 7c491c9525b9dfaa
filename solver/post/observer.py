"""What is worth writing down of each step: one row of the history."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from solver.dynamics.state import Exchange, State
from solver.dynamics.stepper import Stepper
from solver.mechanics.kinematics import lean, unwrap
from solver.parallel import global_sum

Array = NDArray[np.float64]


class Observer:
    """Angle, slip, gaps, forces and the energy ledger of one block on a rigid plane.

    Slip and the dissipated energies are carried on from step to step, so every step has to be seen.
    """

    def __init__(self, stepper: Stepper, state: State, thickness: float):
        """Start at a state.

        Args:
            stepper: Body, interface, loads.
            state: Where the run starts.
            thickness: Of the block, m: forces and energies are those of the whole block.
        """
        self._stepper, self._thickness = stepper, thickness
        self._angle, self._slip = 0.0, 0.0
        self._exchanged = np.zeros(5)
        self._interface = stepper.interface
        self._home = self._first_home(state)
        self._corners, self._places = self._bottom()
        self._start: float | None = None

    def _bottom(self) -> tuple[NDArray[np.int64], Array]:
        """The two bottom corners: where they stand in the interface's layer, and in the block."""
        places = self._stepper.interface.points.node_positions
        row = np.flatnonzero(places[:, 1] < places[:, 1].min() + 1e-9 * np.ptp(places[:, 0]))
        corners = row[[np.argmin(places[row, 0]), np.argmax(places[row, 0])]]
        return corners, places[corners]

    def row(self, state: State, exchange: Exchange, step: float) -> list[float]:
        """The values of a history row, in the order of `solver.post.history.columns`."""
        stepper, body = self._stepper, self._stepper.body
        u = state.u.reshape(-1, body.dimension)
        momentum = body.inertia(state.v).reshape(-1, body.dimension)
        arm = body.arm + u
        spin = float(np.sum(arm[:, 1] * momentum[:, 0] - arm[:, 0] * momentum[:, 1]))
        sums = global_sum(
            body.comm, np.array([*(body.directional_mass @ state.u), *momentum.sum(axis=0), spin])
        )
        moved, velocity = sums[:2] / body.mass, sums[2:4] / body.mass
        spin = float(sums[4]) - body.mass * (moved[1] * velocity[0] - moved[0] * velocity[1])
        self._angle = unwrap(lean(body.rotation(state.u)), self._angle)
        gaps, corners, closed = self._contact(state)
        centre = body.centre + moved
        forces = self._thickness * state.contact.force.sum(axis=0)
        penetration = max(0.0, -float(gaps[:, 0].min()))
        kinematic = [self._angle, spin / body.polar_inertia, self._slip, *corners[:, 0]]
        kinematic += [penetration, *centre, *forces]
        head = [
            state.time,
            step,
            float(exchange.iterations),
            float(closed),
            float(stepper.base(state.time)[0]),
        ]
        return (
            head + [float(value) for value in kinematic] + self._energies(state, exchange, centre)
        )

    def _contact(self, state: State) -> tuple[Array, Array, int]:
        """Gaps of all points and of the bottom corners, number of closed points; slip goes on."""
        interface = self._stepper.interface
        gaps = interface.gaps(state.contact.surface)
        if interface is not self._interface:
            self._interface = interface
            self._corners, self._places = self._bottom()
        closed = state.contact.force[:, 0] > 0
        touching = np.flatnonzero(closed) if closed.any() else [int(np.argmin(gaps[:, 0]))]
        self._slip = self._slip_of(gaps[:, 1], touching)
        displacement = self._stepper.layer(state.u)[self._corners]
        corners = (self._places + displacement - interface.origin) @ interface.frame.T
        return gaps, corners, int(closed.sum())

    def _first_home(self, state: State) -> dict[tuple[float, ...], float]:
        """Where the points of the face that stands on the plane belong along it, m.

        As far from the lowest one as in the block: a tilted block has its base foreshortened.
        """
        interface, points = self._interface, self._interface.points
        gaps = interface.gaps(state.contact.surface)
        lowest = int(np.argmin(np.where(state.contact.eligible, gaps[:, 0], np.inf)))
        along = (points.reference - points.reference[lowest]) @ interface.frame[1]
        keys = interface.keys()
        same = np.flatnonzero(points.tag == points.tag[lowest])
        return {keys[q]: float(gaps[lowest, 1] + along[q]) for q in same}

    def _slip_of(self, place: Array, touching: Sequence[int] | NDArray[np.int64]) -> float:
        """Mean displacement of the touching points along the plane since they were at home.

        Home is where a point belongs at the start, for points of other faces where it has
        to be for the slip not to jump when they first touch.
        """
        keys = self._interface.keys()
        known = [place[q] - self._home[keys[q]] for q in touching if keys[q] in self._home]
        slip = float(np.mean(known)) if known else self._slip
        for q in touching:
            self._home.setdefault(keys[q], place[q] - slip)
        return slip

    def _energies(self, state: State, exchange: Exchange, centre: Array) -> list[float]:
        """Stored, taken in and dissipated energy, J."""
        stepper = self._stepper
        gravity = -stepper.body.mass * float(stepper.gravity @ centre)
        stored = [
            state.kinetic,
            state.strain,
            gravity,
            0.0,
            stepper.interface.energy(state.contact),
        ]
        self._exchanged += [
            exchange.input,
            exchange.friction,
            exchange.damping,
            exchange.contact,
            exchange.numerical,
        ]
        total = sum(stored)
        if self._start is None:
            self._start = total
        error = total - self._start - self._exchanged[0] + self._exchanged[1:].sum()
        values = [*stored, *self._exchanged, total, error]
        return [float(self._thickness * value) for value in values]
