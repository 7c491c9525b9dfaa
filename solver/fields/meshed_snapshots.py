"""Snapshots of a run for ParaView: the fields of every body, filled from the state of the run.

Writing evicts the processor's caches, and the steps that follow take longer: a tenth in all for
small bodies. So snapshots of these wait, and are written in batches.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from dolfinx import fem

from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody, ReducedParts
from solver.bodies.rigid_body import DenseBody, RigidBox
from solver.build.assembly import Assembly
from solver.contact.body_points import NitschePoints
from solver.fields.body_functions import BodyFunctions
from solver.fields.destination import Destination, RigidWriter, open_destination
from solver.fields.ground import platform_corners
from solver.fields.nodal_contact import NodeState, edge_forces, nodal_contact
from solver.fields.paraview import write_script
from solver.fields.pvd import FieldsBefore
from solver.scene import Scene
from solver.stepping.state import State
from solver.stepping.system import Link
from solver.types import Array

MOST_WAITING = 200_000
"""Unknowns of all snapshots that wait, at most: those of large bodies are written at once."""


class SteppedRun(Protocol):
    """The run that snapshots are taken of."""

    assembly: Assembly
    state: State


class Taken(NamedTuple):
    """What a snapshot shows.

    Attributes:
        time: s.
        state: The bodies.
        links: The interfaces whose memories the state has.
    """

    time: float
    state: State
    links: Sequence[Link]


class Snapshots:
    """Displacement, velocity, stress and contact of all bodies; collective."""

    def __init__(
        self, run: SteppedRun, folder: Path, scene: Scene, before: FieldsBefore | None = None
    ):
        """Begin the files and write the script that shows them in ParaView."""
        self._run, self._waiting = run, list[Taken]()
        system = self._system = run.assembly.stepper.system
        writes = system.comm.rank == 0
        before = before or FieldsBefore()
        files = self._files = open_destination(scene, folder, before, writes=writes)
        self._bodies: list[MeshedFields | RigidFields | HeldFields] = []
        for number, body in enumerate(system.bodies):
            if isinstance(body, ElasticBody):
                self._bodies.append(MeshedFields(run, number, body, files))
            elif isinstance(body, ReducedBody):
                if body.parts is not None:
                    self._bodies.append(ReducedFields(run, number, body.parts, files))
            else:
                corners = body.corners if isinstance(body, RigidBox) else platform_corners(scene)
                writer = files.rigid(body.name, corners)
                self._bodies.append(RigidFields(run, number, body, corners, writer))
        held = run.assembly.support.held
        if held is not None:
            self._bodies.append(HeldFields(held, files))
        files.begin()
        if writes:
            write_script(folder, scene, stress=bool(system.meshed))

    @property
    def waiting(self) -> bool:
        """Whether any wait to be written."""
        return bool(self._waiting)

    def write(self, time: float) -> None:
        """Take the fields of the run's state, and let them wait if they may."""
        system, links = self._system, self._run.assembly.stepper.links
        self._waiting.append(Taken(time, self._run.state, links))
        if system.comm.size > 1 or len(self._waiting) * system.unknowns > MOST_WAITING:
            self.flush()

    def flush(self) -> None:
        """Write the snapshots that wait.

        An OSError is raised after all that ranks do together, on those where it happened.
        """
        while self._waiting:
            self._write(self._waiting.pop(0))

    def _write(self, taken: Taken) -> None:
        """Write a snapshot."""
        trouble = None
        for body in self._bodies:
            try:
                body.write(taken)
            except OSError as error:
                trouble = trouble or error
        if trouble is not None:
            raise trouble
        self._files.end_time(taken.time)

    def close(self) -> None:
        """Finish the files."""
        for body in self._bodies:
            body.close()
        self._files.close()


class MeshedFields:
    """The fields of a meshed body."""

    def __init__(self, run: SteppedRun, number: int, body: ElasticBody, files: Destination):
        """Make the functions that the files hold."""
        self._body = body
        self._own = run.assembly.stepper.system.slices[number]
        self._number, space = number, body.space
        self._displacement, self._velocity = fem.Function(space), fem.Function(space)
        degree = space.element.basix_element.degree
        scalars = fem.functionspace(space.mesh, ("Lagrange", degree))
        self._pressure, self._state = fem.Function(scalars), fem.Function(scalars)
        self._friction = fem.Function(space)
        nodal = {
            "displacement": self._displacement,
            "velocity": self._velocity,
            "contact_pressure": self._pressure,
            "friction": self._friction,
            "contact_state": self._state,
        }
        functions = BodyFunctions(nodal, body.moduli, body.thickness, self._linear_about())
        self._writer = files.meshed(body.name, functions)

    def write(self, taken: Taken) -> None:
        """Write the fields."""
        body, state = self._body, taken.state
        for function, values in ((self._displacement, state.u), (self._velocity, state.v)):
            function.x.array[: body.size] = self._on_mesh(values[self._own])
            function.x.scatter_forward()
        self._fill_contact(taken)
        self._writer.write(taken.time)

    def _linear_about(self) -> fem.Function | None:
        """The displacement about which the body is linear; None where it is not."""
        return None

    def _on_mesh(self, values: Array) -> Array:
        """Owned nodal values, from the unknowns of the run."""
        return values

    def _fill_contact(self, taken: Taken) -> None:
        """Pressure, friction and state of the nodes."""
        body = self._body
        for function in (self._pressure, self._friction, self._state):
            function.x.array[:] = 0.0
        area = np.zeros(body.owned)
        for link, memory in zip(taken.links, taken.state.contacts, strict=True):
            contact = link.interface.points
            if link.body != self._number or not isinstance(contact, NitschePoints):
                continue
            found = nodal_contact(contact.points, memory, body.thickness)
            layer = contact.points.layer
            layer.add(self._pressure.x.array[: body.owned], found.pressure)
            layer.add(self._state.x.array[: body.owned], found.state)
            layer.add(
                self._friction.x.array[: body.size].reshape(-1, body.dimension), found.friction
            )
            layer.add(area, found.area)
        self._add_edges(taken, area)

    def _add_edges(self, taken: Taken, area: Array) -> None:
        """What edges do where the body overhangs what carries it, by the area of each node, m2."""
        body, d = self._body, self._body.dimension
        forces = np.zeros((body.owned, 2 + d))
        for link, memory in zip(taken.links, taken.state.contacts, strict=True):
            if self._number in (link.body, link.carrier):
                carries = link.carrier == self._number
                found = edge_forces(link.interface, memory, carries=carries)
                if found is not None:
                    found.layer.add(forces, np.hstack([found.normal, found.friction]))
        pressed = (forces[:, 0] > 0) & (area > 0)
        own = np.flatnonzero(pressed)
        acting = forces[own] / area[own, None]
        self._pressure.x.array[own] += acting[:, 0]
        friction = self._friction.x.array[: body.size].reshape(-1, d)
        friction[own] += acting[:, 2:]
        state = self._state.x.array
        slips = 2 * forces[own, 1] >= forces[own, 0]
        touched = np.where(slips, float(NodeState.SLIPS), float(NodeState.STICKS))
        state[own] = np.where(state[own] < NodeState.SLIPS, touched, state[own])

    def close(self) -> None:
        """Finish the files."""
        self._writer.close()


class ReducedFields(MeshedFields):
    """The fields of a reduced body on the mesh that it stands for; on rank 0, which has it all."""

    def __init__(self, run: SteppedRun, number: int, parts: ReducedParts, files: Destination):
        """Make the functions that the files hold."""
        super().__init__(run, number, parts.mesh, files)
        self._shapes = parts.shapes

    def _linear_about(self) -> fem.Function | None:
        """Its equilibrium under weight."""
        found, weighed = fem.Function(self._body.space), self._body.strained_at
        assert weighed is not None
        found.x.array[: self._body.size] = weighed
        found.x.scatter_forward()
        return found

    def _on_mesh(self, values: Array) -> Array:
        """Nodal values, from the reduced unknowns."""
        return self._shapes.expanded(values)


class HeldFields:
    """A plate that is meshed and fully restrained: it stands where it stood, without stress."""

    def __init__(self, space: fem.FunctionSpace, files: Destination):
        """Take the space of the plate's displacements, all zero."""
        nodal = {name: fem.Function(space) for name in ("displacement", "velocity")}
        self._writer = files.meshed("plate", BodyFunctions(nodal, None))

    def write(self, taken: Taken) -> None:
        """Write the plate."""
        self._writer.write(taken.time)

    def close(self) -> None:
        """Finish the files."""
        self._writer.close()


class RigidFields:
    """A rigid body among meshed ones."""

    def __init__(
        self,
        run: SteppedRun,
        number: int,
        body: DenseBody,
        corners: Array,
        writer: RigidWriter,
    ):
        """Take the body, its corners and the writer."""
        self._body, self._corners, self._writer = body, corners, writer
        self._own = run.assembly.stepper.system.slices[number]

    def write(self, taken: Taken) -> None:
        """Write the body."""
        body, state = self._body, taken.state
        pose, speed = body.replicate(state.u[self._own]), body.replicate(state.v[self._own])
        moved = body.material_positions(self._corners, pose) - self._corners
        self._writer.write(taken.time, moved, body.rows(self._corners, pose) @ speed)

    def close(self) -> None:
        """Close the files; they are complete after each writing."""
