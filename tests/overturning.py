"""What a pulse does to a block by Housner's equation, in the words of the study of overturning."""

from __future__ import annotations

from solver.reference.housner import housner
from solver.scene import Scene
from solver.study.overturning.blocks import PulseKind, Upright
from solver.study.overturning.boundaries import fate_of


def housner_fate(scene: Scene, kind: PulseKind, frequency: float, amplitude: float) -> str:
    """The fate under a pulse of a frequency omega/p and an amplitude over g tan alpha."""
    upright = Upright.of(scene)
    pulse = kind.motion(amplitude * upright.unit, frequency * upright.frequency)
    found = housner(
        upright.shape,
        gravity=scene.gravity,
        end=pulse.stop + 25 / upright.frequency,
        step=pulse.stop / 40,
        acceleration=pulse.acceleration,
        restitution=upright.given or None,
    )
    return fate_of(overturns=found.overturned, impacts=len(found.impacts))
