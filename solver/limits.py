"""Scenes that are beyond what the method can do, refused when they are read."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from solver.errors import SceneError
from solver.excitation.units import STANDARD_GRAVITY
from solver.specs import BlockSpec, PlateSpec

if TYPE_CHECKING:
    from solver.scene import Scene

LARGEST_STRAIN = 0.05
"""Of a meshed body under the weight that it carries and the inertia of that under a pulse of the
ground. Impacts strain it several times as much, and St. Venant-Kirchhoff's law softens under
pressure until it fails at 0.4."""

MOST_CELLS_A_STEP = 1e5
"""Cells that sound crosses in a step: where a body turns, the iteration loses as many digits twice
over. Bodies as stiff as that are rigid for all that such steps show."""


def refuse_beyond(scene: Scene) -> None:
    """Refuse meshed bodies too soft for what they carry or too stiff for the steps; SceneError."""
    for block in scene.blocks:
        if block.model == "elastic":
            _refuse_stiff(block, scene.time.largest or scene.time.step, scene.dimension)
    plate = scene.foundation
    for block in scene.blocks:
        pressure, carrier = _pressure(scene, block), scene.carrier_of(block)
        for body in (block, carrier):
            if body is not None and body.model == "elastic":
                _refuse_soft(f"{body.name}.young", body.elasticity[0], pressure)
        if carrier is None and isinstance(plate, PlateSpec) and plate.support != "fixed":
            _refuse_soft("foundation.young", plate.young, pressure)


def _pressure(scene: Scene, block: BlockSpec) -> float:
    """Weight and inertia of a block and of all that it carries, over its bottom, Pa."""
    carried = sum(other.shape.mass for other in scene.blocks if _stands_on(scene, other, block))
    return carried * _acceleration(scene) / (block.width * block.thickness)


def _acceleration(scene: Scene) -> float:
    """Of gravity and of pulses of the ground, all added up, m/s2."""
    motions = [] if scene.motion is None else [scene.motion]
    motions += [motion for first in motions for _, motion in first.beside()]
    pulses = sum(abs(getattr(motion, "amplitude_g", 0.0)) for motion in motions)
    return scene.gravity + STANDARD_GRAVITY * pulses


def _stands_on(scene: Scene, block: BlockSpec, below: BlockSpec) -> bool:
    """Whether a block is another one, or stands on it, or on what stands on it."""
    at: BlockSpec | None = block
    while at is not None and at.name != below.name:
        at = scene.carrier_of(at)
    return at is not None


def _refuse_soft(where: str, young: float, pressure: float) -> None:
    """Refuse a modulus (Pa) below what a pressure (Pa) asks for."""
    least = pressure / LARGEST_STRAIN
    if young < least:
        got = f"{young:g}, strained by {pressure / young:.2g} under what it carries"
        raise SceneError(where, got, f"young >= {least:.3g} (a strain of {LARGEST_STRAIN:g})")


def _refuse_stiff(block: BlockSpec, step: float, dimension: int) -> None:
    """Refuse a block whose cells are crossed by sound too often in the longest step (s)."""
    depth = () if dimension == 2 else (block.thickness,)
    sides = (block.width, *depth, block.height)
    cell = min(side / count for side, count in zip(sides, block.cells, strict=True)) / block.degree
    speed = math.sqrt(block.elasticity[0] / block.shape.density)
    crossed = speed * step / cell
    if crossed > MOST_CELLS_A_STEP:
        most = block.elasticity[0] * (MOST_CELLS_A_STEP / crossed) ** 2
        got = f"{block.elasticity[0]:g}, sound crosses {crossed:.2g} cells in a step of {step:g} s"
        allowed = f'young <= {most:.3g} ({MOST_CELLS_A_STEP:g} cells), or model = "rigid"'
        raise SceneError(f"{block.name}.young", got, allowed)
