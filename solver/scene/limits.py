"""Scenes that are beyond what the method can do, refused when they are read."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solver.errors import SceneError
from solver.scene.block import BlockSpec
from solver.scene.cells import equal_parts

if TYPE_CHECKING:
    from solver.scene.material import Material
    from solver.scene.scene import Scene

STRONGEST_SHAKING = 1e6
"""Largest peak of the ground's acceleration, m/s2: no step follows what a stronger one throws."""

LARGEST_STRAIN = 0.05
"""Largest strain of a meshed body under the weight that it carries and the inertia of that weight
at the peak acceleration of the ground. Impacts strain it several times as much, and St.
Venant-Kirchhoff's law softens under pressure until it fails at a strain of 0.4."""

LARGEST_CORNER_STRAIN = 0.25
"""Largest strain of the cell at a bottom corner when a rocking block stands on it alone."""

LARGEST_SQUEEZE = 30.0
"""Largest strain of that cell times (lambda + 2 mu)/mu: for a material whose volume hardly changes,
the stiffness that the tangent of the undeformed body leaves out, over the stiffness that it has.
Iterations converged at 28 and did not at 270."""

MOST_CELLS_A_STEP = 1e5
"""Largest number of cells that sound crosses in a step. Where a body turns, the iteration loses
twice as many digits as this number has; bodies as stiff as that show no deformation anyway."""

LARGEST_SETTLEMENT = 1e-3
"""Largest compression of a bed under the weight of what is on it and its inertia, over the height
of the block: a block that rocks there still turns about its corners."""

LARGEST_ASPECT = 100.0
"""Largest length over width of the cell at a bottom corner. When the contact force moves from one
face of a longer cell to the other, the stiffness jumps so much that energy is gained."""

LARGEST_CONTACT_ENERGY = 2e-5
"""For theta 0 and -1, largest energy of contact of a corner on which all the weight stands, over
the smallest scale that gains are measured by, 1e-3 m g H. A rocking block gained up to 0.28 of that
energy."""


def refuse_beyond(scene: Scene, shaking: float) -> None:
    """Refuse bodies too soft for what they carry or too stiff for the steps, and the like.

    The shaking is the peaks of the ground's accelerations in all directions, added up, m/s2. When a
    scene is made, of the motions whose keys tell it; again when the others have been read.

    Raises:
        SceneError: Names the key, what it was given, and what is allowed.
    """
    if shaking > STRONGEST_SHAKING:
        got = f"{shaking:.3g} m/s2 at its peak"
        allowed = f"at most {STRONGEST_SHAKING:g}; look at units, scale and decimal points"
        raise SceneError("motion", got, allowed)
    _refuse_loose_cohesion(scene)
    carried, plane = scene.carried_mass, scene.material_plane
    meshed = [block for block in scene.blocks if block.model == "elastic"]
    corners = {block.name: _corner_cell(block, scene.dimension) for block in meshed}
    for block in meshed:
        _refuse_long(block, corners[block.name])
    for turning in _turning_bodies(scene):
        _refuse_stiff(turning, scene.time.largest or scene.time.step)
    acceleration = scene.gravity + shaking
    pressed = scene.foundation.pressed_material(plane, carried)
    for block in scene.blocks:
        pressure, carrier = _pressure(scene, block, acceleration), scene.carrier_of(block)
        _refuse_soft_bed(scene, block, pressure)
        for body in (block, carrier):
            if body is not None and body.model == "elastic":
                _refuse_soft(f"{body.name}.young", body.material(plane), pressure)
        if block.name in corners:
            _refuse_soft_corner(scene, block, corners[block.name], pressure)
            _refuse_without_energy(scene, block, corners[block.name], pressure)
        if carrier is None and pressed is not None:
            _refuse_soft("foundation.young", pressed, pressure)


def _pressure(scene: Scene, block: BlockSpec, acceleration: float) -> float:
    """Weight and inertia of a block and of all that it carries, over its bottom, Pa.

    `acceleration`: gravity and the peaks of the ground's acceleration, added up, m/s2.
    """
    return scene.stacked_mass(block) * acceleration / _bottom(block)


def _refuse_soft(where: str, material: Material, pressure: float) -> None:
    """Refuse a modulus below what a pressure (Pa) asks for."""
    least = pressure / LARGEST_STRAIN
    if material.young < least:
        got = (
            f"{material.young:g}, strained by {pressure / material.young:.2g} under what it carries"
        )
        raise SceneError(where, got, f"young >= {least:.3g} (a strain of {LARGEST_STRAIN:g})")


def _refuse_soft_bed(scene: Scene, block: BlockSpec, pressure: float) -> None:
    """Refuse a bed that gives way too far under a pressure (Pa)."""
    bed, settled = scene.bed_of(block), LARGEST_SETTLEMENT * block.height
    if bed is not None and pressure > bed.stiffness * settled:
        depth = pressure / bed.stiffness
        own = "" if scene.contact.stiffness else ", from the block's own"
        got = f"{bed.stiffness:.4g}{own}, pressed in by {depth:.2g} m under {block.name}"
        got += " by weight and peak acceleration"
        allowed = f"stiffness >= {pressure / settled:.3g} ({settled:.2g} m)"
        raise SceneError("contact.stiffness", got, allowed)


def _refuse_soft_corner(
    scene: Scene, block: BlockSpec, cell: Sequence[float], pressure: float
) -> None:
    """Refuse a modulus or a cell too small for a pressure (Pa) times the bottom on one corner."""
    material = block.material(scene.material_plane)
    load = pressure * _bottom(block) / material.young  # over E, m2
    strain = load / _facet_below(cell, block)
    if strain > LARGEST_CORNER_STRAIN:
        got = f"{material.young:g}, strained by {strain:.2g} on a corner cell alone"
        least = material.young * strain / LARGEST_CORNER_STRAIN
        allowed = f"young >= {least:.3g} (a strain of {LARGEST_CORNER_STRAIN:g}), or larger cells"
        raise SceneError(f"{block.name}.young", got, allowed)
    strain = load / _bottom_of(cell, block)
    squeezed = strain * material.longitudinal / material.shear
    if squeezed > LARGEST_SQUEEZE:
        got = f"{material.young:g}, strained by {strain:.2g} on a corner cell alone"
        got += f" at poisson {material.poisson:g}"
        least = material.young * squeezed / LARGEST_SQUEEZE
        allowed = f"young >= {least:.3g}, a smaller poisson, or larger cells"
        raise SceneError(f"{block.name}.young", got, allowed)


def _refuse_without_energy(
    scene: Scene, block: BlockSpec, cell: Sequence[float], pressure: float
) -> None:
    """Refuse theta 0 and -1, which know no energy of contact, where there is much of it."""
    contact = scene.contact
    if contact.theta == 1:
        return
    material = block.material(scene.material_plane)
    gamma_h = contact.gamma * material.longitudinal * block.degree**2 / cell[-1]
    weight = _bottom_of(cell, block) / 2 ** (scene.dimension - 1)
    load = pressure * _bottom(block)
    share = load / (2 * gamma_h * weight) / (1e-3 * block.height)
    if share > LARGEST_CONTACT_ENERGY:
        got = f"{contact.theta}, for which contact may gain some {share:.1g} of the energy"
        least = contact.gamma * share / LARGEST_CONTACT_ENERGY
        raise SceneError("contact.theta", got, f"1, or gamma >= {least:.3g}")


def longest_step(scene: Scene) -> float:
    """The longest step in which sound crosses few enough cells of the bodies that may turn, s."""
    return min(
        (MOST_CELLS_A_STEP * body.crossing_time for body in _turning_bodies(scene)),
        default=math.inf,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _TurningBody:
    """A meshed body that may turn.

    Attributes:
        where: Path of its modulus.
        material: Its material.
        edge: Of its smallest cells, over the degree, m.
        otherwise: What else than a smaller modulus is allowed, in words.
    """

    where: str
    material: Material
    edge: float
    otherwise: str = ""

    @property
    def crossing_time(self) -> float:
        """Time in which sound crosses a cell, s."""
        return self.edge / self.material.wave_speed


def _turning_bodies(scene: Scene) -> Iterator[_TurningBody]:
    """The meshed bodies of a scene that may turn."""
    plane = scene.material_plane
    for block in scene.blocks:
        if block.model == "elastic":
            yield _TurningBody(
                where=f"{block.name}.young",
                material=block.material(plane),
                edge=min(_corner_cell(block, scene.dimension)) / block.degree,
                otherwise=', or model = "rigid"',
            )
    turning = scene.foundation.turning_cells(plane, scene.carried_mass)
    if turning is not None:
        material, edge = turning
        yield _TurningBody(where="foundation.young", material=material, edge=edge)


def _sides(block: BlockSpec, dimension: int) -> tuple[float, ...]:
    """Edges along x, in space y, and upwards, m."""
    return (block.width, *(() if dimension == 2 else (block.thickness,)), block.height)


def _bottom(block: BlockSpec) -> float:
    """Area of the bottom, m2."""
    return block.width * block.thickness


def _bottom_of(cell: Sequence[float], block: BlockSpec) -> float:
    """Area of the bottom of a cell of these edges (m), m2; in the plane as thick as the block."""
    return math.prod(cell[:-1]) * (block.thickness if len(cell) == 2 else 1.0)


def _facet_below(cell: Sequence[float], block: BlockSpec) -> float:
    """Area of the facet of a corner cell (m) that a block leans on, m2: beyond 45 degrees a side.

    In space the smaller of its two.
    """
    if abs(block.tilt_deg) <= 45.0:
        return _bottom_of(cell, block)
    return cell[-1] * (block.thickness if len(cell) == 2 else min(cell[:-1]))


def _corner_cell(block: BlockSpec, dimension: int) -> list[float]:
    """Edges of the cell at a bottom corner of a meshed block, the smallest there are, m."""
    sides = _sides(block, dimension)
    if block.refinement == 1:
        return equal_parts(sides, block.cells)
    from geometry.grading import graded, graded_to_both_ends

    along, upwards = block.cells[:-1], block.cells[-1]
    parts = [graded_to_both_ends(count, block.refinement)[1] for count in along]
    parts.append(graded(upwards, block.refinement)[1])
    return [side * float(part) for side, part in zip(sides, parts, strict=True)]


def _refuse_long(block: BlockSpec, cell: Sequence[float]) -> None:
    """Refuse a block whose corner cells, of these edges (m), are far longer than wide."""
    times = max(cell) / min(cell)
    if times > LARGEST_ASPECT:
        graded = f" and refinement {block.refinement:g}" if block.refinement != 1 else ""
        got = f"{list(block.cells)}{graded}, at bottom corners {times:.3g} times as long as wide"
        raise SceneError(f"{block.name}.cells", got, f"at most {LARGEST_ASPECT:g} times")


def _refuse_stiff(body: _TurningBody, step: float) -> None:
    """Refuse a body whose smallest cells sound crosses too often in a step (s)."""
    young, crossed = body.material.young, step / body.crossing_time
    if crossed > MOST_CELLS_A_STEP * (1 + 1e-12):
        most = young * (MOST_CELLS_A_STEP / crossed) ** 2
        got = f"{young:g}, sound crosses {crossed:.2g} cells in a step of {step:g} s"
        allowed = f"young <= {most:.3g} ({MOST_CELLS_A_STEP:g} cells){body.otherwise}"
        raise SceneError(body.where, got, allowed)


def _refuse_loose_cohesion(scene: Scene) -> None:
    """Refuse cohesion at Gauss points where theta gives contact no energy: it gains without end."""
    contact = scene.contact
    if scene.is_rigid:
        return
    coheres = any(scene.friction_of(block).cohesion > 0 for block in scene.blocks)
    if coheres and contact.theta != 1 and contact.points == "gauss":
        got = f'{contact.theta} with points = "gauss" and cohesion'
        raise SceneError("contact.theta", got, '1, or points = "nodes"')
