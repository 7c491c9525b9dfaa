"""A rigid block under a pulse, by the compiled engine, up to where its fate is certain."""

from __future__ import annotations

import copy
import math

import numpy as np

from solver.rigid.plane.system import PlaneSystem
from solver.scene import Scene
from solver.study.overturning.boundaries import Response
from solver.study.overturning.energy import Upright
from solver.study.overturning.pulses import PulseKind
from solver.types import Array

STEP = 4e-3
"""Time step times p."""

STEPS_A_RADIAN = 50
"""Fewest steps while the phase of the pulse moves on by one."""

AT_ONCE = 100
"""Steps between two looks at the block."""

SHIVER = 1e-4
"""Largest angle over alpha of a swing that does not count."""

LATEST = 60.0
"""Time after the pulse at which a block that still rocks is said to stay, times p."""


class RigidUnderPulses:
    """A rigid block under pulses of one kind and frequency, whatever their amplitude."""

    def __init__(self, scene: Scene, kind: PulseKind, frequency: float):
        """Set up a scene with one rigid block for a frequency omega over p."""
        self._upright = Upright.of(scene)
        p = self._upright.frequency
        unit = kind.motion(1.0, frequency * p)
        longest = min(STEP / p, 1 / (STEPS_A_RADIAN * frequency * p))
        self._shaken = math.ceil(unit.stop / longest)
        self._step = unit.stop / self._shaken
        times: Array = self._step * np.arange(self._shaken + 1, dtype=np.float64)
        self._ground, self._mean = np.zeros((len(times), 2)), np.zeros((len(times) - 1, 2))
        self._ground[:, 0] = unit.accelerations(times)
        self._mean[:, 0] = np.diff(unit.velocities(times)) / self._step
        self._system = PlaneSystem.from_scene(scene)
        self._start = self._system.saved()
        names, own = self._system.columns, f"{self._system.names[0]}."
        self._angle = names.index(own + "angle_rad")
        self._spin = names.index(own + "angular_velocity_rad_s")
        self._energies = names.index("energy.kinetic_J"), names.index("energy.gravity_J")

    def __call__(self, amplitude: float) -> Response:
        """Response to a pulse of an amplitude over g tan alpha.

        Raises:
            RuntimeError: A step was not solved.
        """
        self._system.restore(copy.deepcopy(self._start))
        scale = amplitude * self._upright.unit
        ground, mean = scale * self._ground, scale * self._mean
        swings, margin = _Swings(self._upright.slenderness), 0.0
        last = self._shaken + math.ceil(LATEST / (self._upright.frequency * self._step))
        first = 0
        while first < last:
            shaken = first < self._shaken
            stop = min(first + AT_ONCE, self._shaken if shaken else last)
            moved = (ground[first : stop + 1], mean[first:stop]) if shaken else (None, None)
            outcome = self._system.advance(stop - first, self._step, moved[0], mean=moved[1])
            if outcome.failure:
                raise RuntimeError(outcome.failure)
            rows, first = outcome.rows, stop
            swings.follow(rows[:, self._angle])
            angle, spin = float(rows[-1, self._angle]), float(rows[-1, self._spin])
            if abs(angle) > 0.9 * math.pi / 2:
                return Response(True, swings.impacts, margin if margin > 0 else 1.0)
            if shaken and first < self._shaken:
                continue
            energy = float(sum(rows[-1, k] for k in self._energies))
            if first == self._shaken:
                margin = self._upright.margin(energy, angle, spin)
            if self._upright.falls(energy, angle, spin):
                return Response(True, swings.impacts, abs(margin) or 1.0)
            if self._upright.stays(energy, angle):
                break
        return Response(False, swings.impacts, -abs(margin) or -1.0)


class _Swings:
    """Counts the impacts of a block: ends of swings that were more than a shiver."""

    def __init__(self, slenderness: float):
        """Begin with a block at rest of this slenderness, rad."""
        self._least = SHIVER * slenderness
        self._side, self.impacts = 0.0, 0

    def follow(self, angle: Array) -> None:
        """Go on with some more angles, rad."""
        sides = np.sign(angle[np.abs(angle) > self._least])
        if len(sides):
            before = sides[0] if self._side == 0.0 else self._side
            self.impacts += int(np.count_nonzero(np.diff(sides, prepend=before)))
            self._side = float(sides[-1])
