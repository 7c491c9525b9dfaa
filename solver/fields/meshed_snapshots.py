"""Snapshots of a run for ParaView: the fields of every body, filled from the state of the run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import numpy as np
from dolfinx import fem

from geometry.convex import loops_of
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody, ReducedParts
from solver.bodies.rigid_body import DenseBody, RigidBox
from solver.build.assembly import Assembly
from solver.contact.body_points import NitschePoints
from solver.contact.memory import Memory
from solver.contact.pairs import Link
from solver.fields.contacts import ContactFields
from solver.fields.functions import BodyFunctions, part_of
from solver.fields.ground import platform_corners
from solver.fields.links import LinkFields
from solver.fields.nodal_contact import NodeState, edge_forces, nodal_contact
from solver.fields.paraview import write_script
from solver.fields.part import one_cell, rigid_fields, triangles
from solver.fields.vtu import FieldsBefore, PieceSeries, PvdFiles
from solver.scene import Scene
from solver.stepping.state import State
from solver.types import Array


class SteppedRun(Protocol):
    """The run that snapshots are taken of."""

    assembly: Assembly
    state: State

    def pairs(self) -> Array:
        """What pairs of bodies did in the last step, as `World.pairs` of one step; collective."""


class Snapshots:
    """Displacement, velocity, stress and contact of all bodies, and links; collective."""

    def __init__(
        self, run: SteppedRun, folder: Path, scene: Scene, before: FieldsBefore | None = None
    ):
        """Begin the files and write the script that shows them in ParaView."""
        system = run.assembly.stepper.system
        writes = system.comm.rank == 0
        files = PvdFiles(folder, before or FieldsBefore(), writes=writes)
        self._bodies: list[
            MeshedFields | RigidFields | HeldFields | MeshedContacts | MeshedLinks
        ] = []
        for number, body in enumerate(system.bodies):
            if isinstance(body, ElasticBody):
                self._bodies.append(MeshedFields(run, number, body, files))
            elif isinstance(body, ReducedBody):
                if body.parts is not None:
                    self._bodies.append(ReducedFields(run, number, body.parts, files))
            elif isinstance(body, DenseBody):
                corners = body.corners if isinstance(body, RigidBox) else platform_corners(scene)
                solid = body.shape.solid if isinstance(body, RigidBox) else None
                if solid is None:
                    own = one_cell(corners)
                else:
                    own = triangles(corners, loops_of(solid.parts))
                writer = files.body(body.name, own)
                self._bodies.append(RigidFields(run, number, body, corners, writer))
        held = run.assembly.support.held
        if held is not None:
            self._bodies.append(HeldFields(held, files))
        self._bodies.append(MeshedContacts(run, ContactFields(scene, files)))
        if scene.links:
            self._bodies.append(MeshedLinks(run, LinkFields(scene, files)))
        files.begin()
        if writes:
            write_script(folder, scene, stress=bool(system.meshed))

    def write(self, time: float) -> None:
        """Write the fields of the run's state, at a time, s.

        An OSError is raised after all that ranks do together, on those where it happened.
        """
        trouble = None
        for body in self._bodies:
            try:
                body.write(time)
            except OSError as error:
                trouble = trouble or error
        if trouble is not None:
            raise trouble


class MeshedFields:
    """The fields of a meshed body."""

    def __init__(self, run: SteppedRun, number: int, body: ElasticBody, files: PvdFiles):
        """Make the functions that the files hold."""
        self._run, self._body = run, body
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
        self._functions = BodyFunctions(nodal, body.moduli, body.thickness, self._linear_about())
        self._writer = files.body(body.name, part_of(space))

    def write(self, time: float) -> None:
        """Write the fields."""
        body, state = self._body, self._run.state
        for function, values in ((self._displacement, state.u), (self._velocity, state.v)):
            function.x.array[: body.size] = self._on_mesh(values[self._own])
        self._displacement.x.scatter_forward()  # its gradient in cells at the border of a rank
        self._fill_contact()
        self._writer.write(time, *self._functions.arrays())

    def _linear_about(self) -> fem.Function | None:
        """The displacement about which the body is linear; None where it is not."""
        return None

    def _on_mesh(self, values: Array) -> Array:
        """Owned nodal values, from the unknowns of the run."""
        return values

    def _fill_contact(self) -> None:
        """Pressure, friction and state of the nodes."""
        body = self._body
        for function in (self._pressure, self._friction, self._state):
            function.x.array[:] = 0.0
        area = np.zeros(body.owned)
        for link, memory in self._contacts():
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
        self._add_edges(area)

    def _contacts(self) -> Iterator[tuple[Link, Memory]]:
        """The interfaces of the run and their memories."""
        return zip(self._run.assembly.stepper.links, self._run.state.contacts, strict=True)

    def _add_edges(self, area: Array) -> None:
        """Add edge forces where the body overhangs what carries it; `area` of each node, m2."""
        body, d = self._body, self._body.dimension
        forces = np.zeros((body.owned, 2 + d))
        for link, memory in self._contacts():
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


class ReducedFields(MeshedFields):
    """The fields of a reduced body on the mesh that it stands for; on rank 0, which has it all."""

    def __init__(self, run: SteppedRun, number: int, parts: ReducedParts, files: PvdFiles):
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

    def __init__(self, space: fem.FunctionSpace, files: PvdFiles):
        """Take the space of the plate's displacements, all zero."""
        nodal = {name: fem.Function(space) for name in ("displacement", "velocity")}
        self._functions = BodyFunctions(nodal, None)
        self._writer = files.body("plate", part_of(space))

    def write(self, time: float) -> None:
        """Write the plate."""
        self._writer.write(time, *self._functions.arrays())


class MeshedContacts:
    """The forces between the bodies of a run."""

    def __init__(self, run: SteppedRun, points: ContactFields):
        """Take the run, and the writer of points."""
        self._run, self._points = run, points

    def write(self, time: float) -> None:
        """Write the forces; collective."""
        self._points.write(time, self._run.pairs())


class MeshedLinks:
    """The links of a run, whose ends are where bodies carry them, bent as they are."""

    def __init__(self, run: SteppedRun, lines: LinkFields):
        """Take the run, and the writer of lines."""
        self._run, self._lines = run, lines

    def write(self, time: float) -> None:
        """Write the links; collective."""
        attached, state = self._run.assembly.stepper.attached, self._run.state
        assert attached is not None and state.body_links is not None
        places = attached.observe(state.u).places
        ends = np.array([places[list(link.ends)] for link in attached.links.links])
        self._lines.write(time, ends, attached.links.numbers(state.body_links))


class RigidFields:
    """A rigid body among meshed ones."""

    def __init__(
        self,
        run: SteppedRun,
        number: int,
        body: DenseBody,
        corners: Array,
        writer: PieceSeries,
    ):
        """Take the body, its corners and the writer."""
        self._run = run
        self._body, self._corners, self._writer = body, corners, writer
        self._own = run.assembly.stepper.system.slices[number]

    def write(self, time: float) -> None:
        """Write the body."""
        body, state = self._body, self._run.state
        pose, speed = body.replicate(state.u[self._own]), body.replicate(state.v[self._own])
        moved = body.material_positions(self._corners, pose) - self._corners
        fields = rigid_fields(moved, body.rows(self._corners, pose) @ speed)
        self._writer.write(time, fields, {})
