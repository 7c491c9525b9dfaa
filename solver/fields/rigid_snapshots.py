"""Snapshots of rigid blocks for ParaView, in the plane and in space; nothing here needs dolfinx."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geometry.arrangement import Pose, level
from geometry.skin import faces_of
from solver.fields.contacts import ContactFields
from solver.fields.ground import platform_corners
from solver.fields.links import LinkFields
from solver.fields.paraview import write_script
from solver.fields.part import in_space, one_cell, rigid_fields, triangles
from solver.fields.vtu import FieldsBefore, PieceSeries, PvdFiles
from solver.rigid.system import RigidSystem
from solver.scene import Scene
from solver.scene.laws import GROUND
from solver.types import Array


class RigidSnapshots:
    """Displacement and velocity of all blocks and of the platform, contact forces, links."""

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
        self._bodies, self._blocks, d = bodies, scene.blocks, scene.dimension
        self._centres = [np.array(b.shape.centre_of_mass(d)) for b in scene.blocks]
        files = PvdFiles(folder, before or FieldsBefore(), writes=writes)
        upright = scene.poses(upright=True)
        self._drawn: list[tuple[Array, Array, PieceSeries]] = []
        """Corners of each block in its own frame and upright, m, and its writer."""
        for block in scene.blocks:
            own, faces = faces_of(block.shape, d)
            placed = upright[block.name](own)
            part = one_cell(placed) if block.shape.solid is None else triangles(placed, faces)
            self._drawn.append((own, placed, files.body(block.name, part)))
        self._platform = None
        if scene.has_platform:
            self._platform = files.body("platform", one_cell(platform_corners(scene)))
        self._contacts = ContactFields(scene, files)
        self._links = LinkFields(scene, files) if scene.links else None
        files.begin()
        if writes:
            write_script(folder, scene, stress=False)

    def write(self, time: float) -> None:
        """Write the bodies as they stand, at a time, s."""
        frames = self._frames()
        for number, (own, upright, writer) in enumerate(self._drawn):
            frame = frames[self._blocks[number].name]
            places, spin = frame(own), self._bodies.angular_velocity(number)
            if len(spin) == 1:  # clockwise
                spin = np.append(np.zeros(2), -spin)
            velocity = in_space(self._bodies.velocity(number)[None])
            velocity = velocity + np.cross(spin, in_space(places - frame.place))
            writer.write(time, rigid_fields(places - upright, velocity), {})
        if self._platform is not None:
            moved = frames[GROUND].place, np.append(self._bodies.drift_velocity, 0.0)
            fields = rigid_fields(*(np.tile(each, (2 ** len(each), 1)) for each in moved))
            self._platform.write(time, fields, {})
        self._contacts.write(time, self._bodies.pairs)
        if self._links is not None:
            self._links.write(time, self._links.ends_by(frames), self._bodies.link_numbers)

    def _frames(self) -> dict[str, Pose]:
        """From the own frame of each block, and of the foundation, to where it is."""
        found = {GROUND: level(np.append(self._bodies.drift, 0.0))}
        for number, (block, own) in enumerate(zip(self._blocks, self._centres, strict=True)):
            rotation, centre = self._bodies.rotation(number), self._bodies.centre(number)
            found[block.name] = Pose(rotation=rotation, about=own, place=centre)
        return found
