"""Snapshots of a run for ParaView: the functions the field writer writes, filled from a state."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from dolfinx import fem

from solver.dynamics.state import State
from solver.dynamics.stepper import Stepper
from solver.post.fields import FieldWriter
from solver.post.paraview import paraview_script


class Snapshots:
    """Displacement, velocity, stress and contact pressure of the body; collective."""

    def __init__(self, stepper: Stepper, folder: Path):
        """Open `fields.pvd` and write the script that shows it in ParaView."""
        self._stepper = stepper
        body = stepper.body
        space = body.space
        self._displacement, self._velocity = fem.Function(space), fem.Function(space)
        degree = space.element.basix_element.degree
        self._pressure = fem.Function(fem.functionspace(space.mesh, ("Lagrange", degree)))
        self._writer = FieldWriter(
            folder / "fields.pvd",
            displacement=self._displacement,
            velocity=self._velocity,
            contact_pressure=self._pressure,
            material=body.material,
        )
        if body.comm.rank == 0:
            size = float(np.linalg.norm(np.ptp(stepper.interface.points.node_positions, axis=0)))
            (folder / "open_in_paraview.py").write_text(paraview_script(size), encoding="utf-8")

    def write(self, state: State) -> None:
        """Write the fields of a state."""
        body, points = self._stepper.body, self._stepper.interface.points
        for function, values in ((self._displacement, state.u), (self._velocity, state.v)):
            function.x.array[: body.size] = values
            function.x.scatter_forward()
        # The point forces spread over the nodes, over the area that belongs to each of them.
        area = points.values_T @ (points.weight * state.contact.eligible)
        force = points.values_T @ state.contact.force[:, 0]
        pressure = np.divide(force, area, out=np.zeros_like(force), where=area > 0)
        self._pressure.x.array[:] = 0.0
        points.layer.add(self._pressure.x.array[: body.owned], np.maximum(pressure, 0.0))
        self._pressure.x.scatter_forward()
        self._writer.write(state.time)

    def close(self) -> None:
        """Finish the files."""
        self._writer.close()
