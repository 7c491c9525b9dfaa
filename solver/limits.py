"""Scenes that are beyond what the method can do, refused when they are read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from solver.errors import SceneError
from solver.specs import BlockSpec, PlateSpec

if TYPE_CHECKING:
    from solver.scene import Scene

LARGEST_STRAIN = 0.05
"""Of a meshed body under the weight that it carries at rest. Impacts strain it several times as
much, and St. Venant-Kirchhoff's law softens under pressure until it fails at 0.4."""


def refuse_beyond(scene: Scene) -> None:
    """Refuse a scene whose meshed bodies are too soft for what they carry; SceneError names it."""
    plate = scene.foundation
    for block in scene.blocks:
        pressure, carrier = _pressure(scene, block), scene.carrier_of(block)
        for body in (block, carrier):
            if body is not None and body.model == "elastic":
                _refuse_soft(f"{body.name}.young", body.elasticity[0], pressure)
        if carrier is None and isinstance(plate, PlateSpec) and plate.support != "fixed":
            _refuse_soft("foundation.young", plate.young, pressure)


def _pressure(scene: Scene, block: BlockSpec) -> float:
    """Weight of a block and of all that it carries, over its bottom, Pa."""
    carried = sum(other.shape.mass for other in scene.blocks if _stands_on(scene, other, block))
    return carried * scene.gravity / (block.width * block.thickness)


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
        got = f"{young:g}, strained by {pressure / young:.2g} under the weight on it"
        raise SceneError(where, got, f"young >= {least:.3g} (a strain of {LARGEST_STRAIN:g})")
