"""Fields of a run for ParaView: displacement, velocity, von Mises stress and contact pressure.

The mesh in the files is the undeformed block in its own frame; mesh + displacement is the place in
the ground frame, so "warp by vector" with factor 1 shows the block as it stands.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import ufl
from dolfinx import fem, io

from solver.bodies.elastic_forms import green_strain
from solver.fields.pvd import PvdIndex
from solver.scene.material import Material

END = b"</VTKFile>\n"
"""What a piece ends with."""


def von_mises_stress(displacement: fem.Function, material: Material) -> Any:
    """The von Mises stress sqrt(3/2 s : s), s the deviator of the Cauchy stress, in UFL, Pa.

    The Cauchy stress is F S F^T / det F, with S of St. Venant-Kirchhoff. In plane strain it has the
    out-of-plane part lambda tr(E) / det F; in plane stress none; in space it is there as it is.
    """
    gradient = ufl.grad(displacement)
    dimension = displacement.function_space.mesh.geometry.dim
    identity = ufl.Identity(dimension)
    strain = green_strain(gradient)
    second = material.lame * ufl.tr(strain) * identity + 2 * material.shear * strain
    deformation = identity + gradient
    volume = ufl.det(deformation)
    cauchy = deformation * second * deformation.T / volume
    across = material.lame * ufl.tr(strain) / volume if material.plane == "strain" else 0
    mean = (ufl.tr(cauchy) + across) / 3
    squares = ufl.inner(cauchy - mean * identity, cauchy - mean * identity)
    if dimension == 2:
        squares += (across - mean) ** 2
    return ufl.sqrt(1.5 * squares)


class FieldWriter:
    """Writes the pieces of one body and lists them in the index; every rank calls every method.

    The functions are those of the solver, written as they are at the time of the call. The stress
    is the mean over each cell; the other fields have the degree of the displacement.
    """

    def __init__(
        self,
        file: Path,
        *,
        displacement: fem.Function,
        velocity: fem.Function,
        contact_pressure: fem.Function,
        material: Material,
        thickness: float = 1.0,
        index: PvdIndex | None = None,
        part: int = 0,
        name: str = "",
    ):
        """Open the files, named after `file`: `fields_NAME.pvd` makes `fields_NAME000000.pvtu`.

        When the writer is closed this file lists them, too: the body alone. The displacement (m) is
        place in the ground frame minus mesh position, the velocity (m/s) relative to the ground,
        the contact pressure (Pa, >= 0) a scalar function of the same degree. The thickness (m) is
        what stresses of the material are times. The index lists the pieces of all bodies as they
        are written, by number and name of the body; None: `file` does.
        """
        mesh = displacement.function_space.mesh
        cellwise = fem.functionspace(mesh, ("DG", 0))
        self._stress = fem.Function(cellwise)
        named = {
            "displacement": displacement,
            "velocity": velocity,
            "contact_pressure": contact_pressure,
            "von_mises": self._stress,
        }
        for field, function in named.items():
            function.name = field
        self._functions = list(named.values())
        rule = {"quadrature_degree": 2 * displacement.function_space.element.basix_element.degree}
        test = ufl.TestFunction(cellwise)
        stress = von_mises_stress(displacement, material)
        self._integral = fem.form(stress * test * ufl.dx(metadata=rule))
        self._volume = thickness * fem.assemble_vector(fem.form(test * ufl.dx)).array
        self._writer = io.VTKFile(mesh.comm, file, "w")
        self._index = PvdIndex(file, writes=mesh.comm.rank == 0) if index is None else index
        self._folder, self._stem, self._count = file.parent, file.stem, 0
        self._part, self._name, self._way = part, name, self._index.way_to(file.parent)

    def write(self, time: float) -> None:
        """Write the fields at a time (s)."""
        owned = self._stress.function_space.dofmap.index_map.size_local
        integral = fem.assemble_vector(self._integral).array
        self._stress.x.array[:owned] = integral[:owned] / self._volume[:owned]
        for function in self._functions:
            function.x.scatter_forward()
        self._writer.write_function(self._functions, time)
        self._check_piece()
        # dolfinx lists its pieces when it closes the file; a killed run would have no list.
        piece = f"{self._way}{self._stem}{self._count:06d}.pvtu"
        self._index.add(time, piece, self._part, self._name)
        self._count += 1

    def _check_piece(self) -> None:
        """Raise what dolfinx keeps to itself: the piece of this rank has no end, the disk is full.

        Local, and after all that ranks do together.
        """
        rank = self._stress.function_space.mesh.comm.rank
        piece = self._folder / f"{self._stem}_p{rank}_{self._count:06d}.vtu"
        with piece.open("rb") as stream:
            stream.seek(max(-len(END), -piece.stat().st_size), os.SEEK_END)
            if END.strip() not in stream.read():
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(piece))

    def close(self) -> None:
        """Finish the files."""
        self._writer.close()
