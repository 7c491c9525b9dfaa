"""Limits of the method: bodies, beds and steps beyond them are refused.

Every refusal is a SceneError with the key, its value, and the values that are allowed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from solver.errors import SceneError
from solver.scene.block import BlockSpec
from solver.scene.contact import Bed, ContactSpec
from solver.scene.link import LinkSpec
from solver.scene.material import Material

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

LEAST_STRETCH = 1e-12
"""Least extension of a link by the weight of its lighter body, over the half diagonal of that:
tensions were wrong by 1e-7 at 1e-10, and by 1e-2 at 1e-12."""

EARTH = 9.81
"""Gravity of the earth, m/s2."""

LARGEST_CONTACT_ENERGY = 2e-5
"""For theta 0 and -1, largest energy of contact of a corner on which all the weight stands, over
the smallest scale that gains are measured by, 1e-3 m g H. A rocking block gained up to 0.28 of that
energy."""


def refuse_strong(shaking: float) -> None:
    """Refuse ground whose peak accelerations in all directions, added up, are too large, m/s2."""
    if shaking > STRONGEST_SHAKING:
        got = f"{shaking:.3g} m/s2 at its peak"
        allowed = f"at most {STRONGEST_SHAKING:g}; look at units, scale and decimal points"
        raise SceneError("motion", got, allowed)


def refuse_soft(where: str, material: Material, pressure: float) -> None:
    """Refuse a modulus too small for a pressure (Pa)."""
    least = pressure / LARGEST_STRAIN
    if material.young < least:
        got = (
            f"{material.young:g}, strained by {pressure / material.young:.2g} under what it carries"
        )
        raise SceneError(where, got, f"young >= {least:.3g} (a strain of {LARGEST_STRAIN:g})")


def refuse_soft_bed(block: BlockSpec, contact: ContactSpec, bed: Bed, pressure: float) -> None:
    """Refuse the bed below a block that gives way too far under a pressure (Pa)."""
    settled = LARGEST_SETTLEMENT * block.height
    if pressure > bed.stiffness * settled:
        depth = pressure / bed.stiffness
        own = "" if contact.stiffness else ", from the block's own"
        got = f"{bed.stiffness:.4g}{own}, pressed in by {depth:.2g} m under {block.name}"
        got += " by weight and peak acceleration"
        allowed = f"stiffness >= {pressure / settled:.3g} ({settled:.2g} m)"
        raise SceneError("contact.stiffness", got, allowed)


def refuse_soft_corner(block: BlockSpec, material: Material, pressure: float) -> None:
    """Refuse a modulus or a cell too small for a pressure (Pa) times the bottom on one corner."""
    cell = block.mesh.corner_cell
    load = pressure * block.shape.bottom_area / material.young  # over E, m2
    ratio = material.longitudinal / material.shear
    for strain, most, at, otherwise in (
        (
            load / _facet_below(cell, block),
            LARGEST_CORNER_STRAIN,
            "",
            f" (a strain of {LARGEST_CORNER_STRAIN:g}), or larger cells",
        ),
        (
            load / _bottom_of(cell, block),
            LARGEST_SQUEEZE / ratio,
            f" at poisson {material.poisson:g}",
            ", a smaller poisson, or larger cells",
        ),
    ):
        if strain > most:
            got = f"{material.young:g}, strained by {strain:.2g} on a corner cell alone{at}"
            allowed = f"young >= {material.young * strain / most:.3g}{otherwise}"
            raise SceneError(f"{block.name}.young", got, allowed)


def refuse_without_energy(
    block: BlockSpec, material: Material, contact: ContactSpec, pressure: float
) -> None:
    """Refuse theta 0 and -1, for which contact has no energy, where there is much of it."""
    if contact.theta == 1:
        return
    cell = block.mesh.corner_cell
    gamma_h = contact.gamma * material.longitudinal * block.degree**2 / cell[-1]
    weight = _bottom_of(cell, block) / 2 ** (len(cell) - 1)
    share = pressure * block.shape.bottom_area / (2 * gamma_h * weight) / (1e-3 * block.height)
    if share > LARGEST_CONTACT_ENERGY:
        got = f"{contact.theta}, for which contact may gain some {share:.1g} of the energy"
        least = contact.gamma * share / LARGEST_CONTACT_ENERGY
        raise SceneError("contact.theta", got, f"1, or gamma >= {least:.3g}")


@dataclass(frozen=True, slots=True, kw_only=True)
class TurningBody:
    """A meshed body that may turn.

    Attributes:
        where: Path of its modulus.
        material: Its material.
        edge: Of its smallest cells, over the degree, m.
        otherwise: Alternative to a smaller modulus, in words.
    """

    where: str
    material: Material
    edge: float
    otherwise: str = ""

    @classmethod
    def of(cls, block: BlockSpec, material: Material) -> TurningBody:
        """A block of this material, as light as its lightest cells: sound is fastest there."""
        cell, law = block.mesh.corner_cell, block.relative_density()
        if law is not None:
            material = replace(material, density=material.density * law.least(cell))
        or_rigid = ', or model = "rigid"'
        return cls(
            where=f"{block.name}.young",
            material=material,
            edge=min(cell) / block.degree,
            otherwise=or_rigid,
        )

    @property
    def longest_step(self) -> float:
        """The longest step in which sound crosses few enough of its cells, s."""
        return MOST_CELLS_A_STEP * self.edge / self.material.wave_speed

    def refuse_stiff(self, step: float) -> None:
        """Refuse a modulus with which sound crosses too many cells in a step (s)."""
        crossed = step * self.material.wave_speed / self.edge
        if crossed > MOST_CELLS_A_STEP * (1 + 1e-12):
            young = self.material.young
            most = young * (MOST_CELLS_A_STEP / crossed) ** 2
            got = f"{young:g}, sound crosses {crossed:.2g} cells in a step of {step:g} s"
            allowed = f"young <= {most:.3g} ({MOST_CELLS_A_STEP:g} cells){self.otherwise}"
            raise SceneError(self.where, got, allowed)


def refuse_long(block: BlockSpec) -> None:
    """Refuse a block whose corner cells are far longer than wide."""
    cell = block.mesh.corner_cell
    times = max(cell) / min(cell)
    if times > LARGEST_ASPECT:
        graded = f" and refinement {block.refinement:g}" if block.refinement != 1 else ""
        got = f"{list(block.cells)}{graded}, at bottom corners {times:.3g} times as long as wide"
        raise SceneError(f"{block.name}.cells", got, f"at most {LARGEST_ASPECT:g} times")


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


def refuse_stiff_links(
    links: Sequence[LinkSpec], blocks: Sequence[BlockSpec], gravity: float
) -> None:
    """Refuse links so stiff that what loads them is lost in the round-off of places.

    Gravity is that of the scene, m/s2; without any, that of the earth.
    """
    known = {block.name: block for block in blocks}
    for link in links:
        ends = [known[name] for name in link.between if name in known]
        block = min(ends, key=lambda each: each.shape.mass)
        weight = block.shape.weight(gravity or EARTH)
        most = weight / (LEAST_STRETCH * block.shape.half_diagonal)
        for key in ("stiffness", "shear_stiffness"):
            value = getattr(link, key)
            if value is not None and value > most:
                got = f"{value:g}, stretched {weight / value:.2g} m by the weight of {block.name}"
                allowed = f"{key} <= {most:.3g}: beyond, places have no digits for it"
                raise SceneError(f"{link.name}.{key}", got, allowed)
