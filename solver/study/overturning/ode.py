"""Housner's block under a pulse: the ordinary differential equation, without any engine."""

from __future__ import annotations

import numpy as np

from solver.reference.housner import housner
from solver.scene import Scene
from solver.study.overturning.boundaries import Response
from solver.study.overturning.energy import Upright
from solver.study.overturning.pulses import PulseKind

STEPS = 40
"""Steps, at least, in the pulse; the integrator takes shorter ones by itself."""

LATEST = 25.0
"""Time after the pulse up to which the equation is solved, times p."""


class HousnerUnderPulses:
    """Housner's block under pulses of one kind and frequency, whatever their amplitude."""

    def __init__(self, scene: Scene, kind: PulseKind, frequency: float):
        """Set up a scene with one rigid block for a frequency omega over p."""
        self._scene, self._upright, self._kind = scene, Upright.of(scene), kind
        self._omega = frequency * self._upright.frequency

    def __call__(self, amplitude: float) -> Response:
        """Response to a pulse of an amplitude over g tan alpha."""
        pulse = self._kind.motion(amplitude * self._upright.unit, self._omega)
        block, p = self._scene.blocks[0], self._upright.frequency
        found = housner(
            block.shape,
            gravity=self._scene.gravity,
            end=pulse.stop + LATEST / p,
            step=pulse.stop / STEPS,
            acceleration=pulse.acceleration,
            restitution=self._upright.restitution,
        )
        after = int(np.searchsorted(found.time, pulse.stop))
        angle, spin = float(found.angle[after]), float(found.angular_velocity[after])
        swing = np.cos(self._upright.slenderness - abs(angle)) * self._upright.high
        inertia = block.shape.rotary_inertia_about_corner
        margin = self._upright.margin(inertia * spin**2 / 2 + swing, angle, spin)
        overturns = found.overturned
        size = abs(margin) or 1.0
        return Response(overturns, len(found.impacts), size if overturns else -size)
