"""Snapshots of rigid blocks for ParaView, in the plane and in space; nothing here needs dolfinx."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geometry.arrangement import Pose, level
from geometry.skin import faces_of
from solver.fields.ground import platform_corners
from solver.fields.links import LinkFields
from solver.fields.paraview import write_script
from solver.fields.part import one_cell, rigid_fields, triangles
from solver.fields.vtu import FieldsBefore, PvdFiles
from solver.rigid.system import RigidSystem
from solver.scene import Scene
from solver.scene.laws import GROUND
from solver.types import Array


class RigidSnapshots:
    """Displacement and velocity of all blocks and of the platform."""

    def __init__(
        self,
        bodies: RigidSystem,
        folder: Path,
        scene: Scene,
        *,
        writes: bool = True,
        before: FieldsBefore | None = None,
    ):
        """Begin the files and write the script that shows them in ParaView; on one rank only."""
        self._bodies, self._dimension = bodies, scene.dimension
        seen = [faces_of(block.shape, scene.dimension) for block in scene.blocks]
        self._corners = [corners for corners, _ in seen]
        self._centres = [np.array(b.shape.centre_of_mass(scene.dimension)) for b in scene.blocks]
        upright = scene.poses(upright=True)
        corners = zip(scene.blocks, self._corners, strict=True)
        self._upright = [upright[block.name](own) for block, own in corners]
        self._files = PvdFiles(folder, before or FieldsBefore(), writes=writes)
        parts = [
            (b.name, one_cell(corners) if b.shape.solid is None else triangles(corners, faces))
            for b, corners, (_, faces) in zip(scene.blocks, self._upright, seen, strict=True)
        ]
        if scene.has_platform:
            parts.append(("platform", one_cell(platform_corners(scene))))
        self._writers = [self._files.body(*part) for part in parts]
        self._links = LinkFields(scene, self._files) if scene.links else None
        self._names = [block.name for block in scene.blocks]
        self._files.begin()
        if writes:
            write_script(folder, scene, stress=False)

    def write(self, time: float) -> None:
        """Write the bodies as they stand, at a time, s."""
        for block, upright in enumerate(self._upright):
            arms, velocity = self._moved(block)
            place = arms + self._bodies.centre(block)
            self._writers[block].write(time, rigid_fields(place - upright, velocity), {})
        for writer in self._writers[len(self._corners) :]:
            count = 2**self._dimension
            shift, speed = np.zeros((count, self._dimension)), np.zeros((count, self._dimension))
            shift[:, : self._dimension - 1] = self._bodies.drift
            speed[:, : self._dimension - 1] = self._bodies.drift_velocity
            writer.write(time, rigid_fields(shift, speed), {})
        if self._links is not None:
            ends = self._links.ends_by(self._frames())
            self._links.write(time, ends, self._bodies.link_numbers)

    def _frames(self) -> dict[str, Pose]:
        """From the own frame of each block, and of the foundation, to where it is."""
        place = np.append(self._bodies.drift, 0.0)
        found = {GROUND: level(place)}
        for number, name in enumerate(self._names):
            rotation, centre = self._bodies.rotation(number), self._bodies.centre(number)
            found[name] = Pose(rotation=rotation, about=self._centres[number], place=centre)
        return found

    def _moved(self, block: int) -> tuple[Array, Array]:
        """From a block's centre of mass to its corners, m, and the velocities of these, m/s."""
        own = self._corners[block] - self._centres[block]
        arms = own @ self._bodies.rotation(block).T
        spin = self._bodies.angular_velocity(block)
        if self._dimension == 2:
            turning: Array = spin[0] * np.stack([arms[:, 1], -arms[:, 0]], axis=1)
        else:
            turning = np.asarray(np.cross(spin, arms), dtype=np.float64)
        return arms, turning + self._bodies.velocity(block)

    def close(self) -> None:
        """Close the files; they are complete after every snapshot."""
        self._files.close()
