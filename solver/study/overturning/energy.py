"""What the energy of a rigid block says about its fate once the ground is at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

from solver.reference.housner import housner_restitution
from solver.scene import Scene


@dataclass(frozen=True, slots=True)
class Upright:
    """A rigid block and its energies upright and over its corner."""

    slenderness: float
    """alpha, rad."""
    frequency: float
    """p, 1/s."""
    unit: float
    """g tan alpha, m/s^2, which amplitudes are counted in."""
    low: float
    """Potential energy upright, J."""
    high: float
    """Potential energy over its corner, J."""
    restitution: float
    """e of its impacts."""

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """The energies of a scene's only block; e is Housner's where it has none of its own."""
        block = scene.blocks[0]
        shape, gravity = block.shape, scene.gravity
        weight = shape.weight(gravity)
        return cls(
            slenderness=shape.slenderness,
            frequency=shape.frequency(gravity),
            unit=gravity * math.tan(shape.slenderness),
            low=weight * shape.height / 2,
            high=weight * shape.half_diagonal,
            restitution=block.restitution or max(0.0, housner_restitution(shape)),
        )

    def stays(self, energy: float, angle: float) -> bool:
        """Whether the block leans by less than alpha, without the energy (J) to go beyond."""
        return energy < self.high and abs(angle) < self.slenderness

    def falls(self, energy: float, angle: float, spin: float) -> bool:
        """Whether the block leans by more than alpha, and does not come back.

        It turns away, or has not the energy (J) to return; angle in rad, spin in rad/s.
        """
        return abs(angle) > self.slenderness and (angle * spin > 0 or energy < self.high)

    def margin(self, energy: float, angle: float, spin: float) -> float:
        """How far the fate of a block is from its opposite, over the energy from upright to alpha.

        Of a block inside alpha, or that returns, the energy beyond that over its corner; one that
        turns back has to go through an impact first, which leaves e^2 of its energy above upright.
        Of a block that fell, what it lacks to return. The arguments are energy (J), angle (rad) and
        angular velocity (rad/s).
        """
        depth = self.high - self.low
        if self.falls(energy, angle, spin):
            return 1.0 if angle * spin > 0 else (self.high - energy) / depth
        above = energy - self.low
        if angle * spin < 0:
            above *= self.restitution**2
        return above / depth - 1
