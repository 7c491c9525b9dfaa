"""Blocks under a pulse up to where their fate is certain: rigid and elastic.

Amplitudes are over g tan alpha, frequencies omega over p.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Any, Self, cast

from mpi4py import MPI

import numpy as np

from geometry.block import SIDES, Block
from solver.excitation.kinds import base_motion
from solver.excitation.pulses import Pulse
from solver.rigid.system import RigidSystem
from solver.run.simulate import simulate
from solver.scene import Scene
from solver.scene.motion import G_UNIT, HalfSineSpec, OneSineSpec, RickerSpec
from solver.study.overturning.boundaries import STAYS, Response, fate_of
from solver.study.scenes import Tables, variant
from solver.types import Array


@dataclass(frozen=True, slots=True)
class PulseKind:
    """A kind of pulse.

    Attributes:
        words: For titles.
        spec: Kind of the motion in a scene.
        periods: Its duration, as a scene has it, in periods 2 pi/omega.
    """

    words: str
    spec: type[HalfSineSpec | OneSineSpec | RickerSpec]
    periods: float

    def table(self, amplitude: float, frequency: float) -> dict[str, Any]:
        """`[motion]` of a pulse of an amplitude (m/s^2) and a frequency omega (rad/s)."""
        period = 2 * math.pi / frequency
        return {
            "kind": self.spec(amplitude_g=0.0, duration=1.0).kind,
            "amplitude_g": amplitude / G_UNIT,
            "duration": self.periods * period,
        }

    def motion(self, amplitude: float, frequency: float) -> Pulse:
        """A pulse of an amplitude (m/s^2) and a frequency omega (rad/s)."""
        table = self.table(amplitude, frequency)
        spec = self.spec(amplitude_g=table["amplitude_g"], duration=table["duration"])
        return cast("Pulse", base_motion(spec, math.inf))


PULSES = {
    "half_sine": PulseKind("half sine", HalfSineSpec, 0.5),
    "one_sine": PulseKind("one sine", OneSineSpec, 1.0),
    "ricker": PulseKind("Ricker", RickerSpec, 3.0),
}
"""All of them by the name that scenes use; omega of a Ricker wavelet is 2 pi f."""


@dataclass(frozen=True, slots=True)
class Upright:
    """A rigid block and its energies upright and over its corner."""

    shape: Block
    """The block."""
    frequency: float
    """p, 1/s."""
    unit: float
    """g tan alpha, m/s^2, which amplitudes are counted in."""
    weight: float
    """N."""
    low: float
    """Potential energy upright, J."""
    given: float
    """Restitution of its impacts that the scene gives; 0: they are without rebound."""

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """The energies of a scene's only block; e is Housner's where it has none of its own.

        Of an uneven block, p and the unit are those of the edge over which it overturns first.
        """
        block = scene.blocks[0]
        shape, gravity = block.shape, scene.gravity
        weight = shape.weight(gravity)
        return cls(
            shape=shape,
            frequency=shape.frequency(gravity),
            unit=gravity * math.tan(shape.slenderness()),
            weight=weight,
            low=weight * shape.centre_height,
            given=scene.restitution_of(block),
        )

    def slenderness(self, angle: float) -> float:
        """Alpha on the side to which it leans by an angle, rad."""
        return self.shape.slenderness(_side(angle))

    def high(self, angle: float) -> float:
        """Potential energy over the edge on that side, J."""
        return self.weight * self.shape.radius(_side(angle))

    def restitution(self, angle: float) -> float:
        """E of the impact that ends a lean by an angle, on the other edge."""
        return self.given or max(0.0, self.shape.restitution(-_side(angle)))

    def stays(self, energy: float, angle: float) -> bool:
        """True if the block leans by less than alpha, without the energy (J) to go beyond."""
        return energy < min(map(self.high, SIDES)) and abs(angle) < self.slenderness(angle)

    def falls(self, energy: float, angle: float, spin: float) -> bool:
        """True if the block leans by more than alpha, and does not come back.

        It turns away, or has not the energy (J) to return; angle in rad, spin in rad/s.
        """
        beyond = abs(angle) > self.slenderness(angle)
        return beyond and (angle * spin > 0 or energy < self.high(angle))

    def margin(self, energy: float, angle: float, spin: float) -> float:
        """Distance of the fate of a block from its opposite, over the energy from upright to alpha.

        Of a block inside alpha, or that returns, the energy beyond that over its corner; one that
        turns back has to go through an impact first, which leaves e^2 of its energy above upright.
        Of a block that fell, what it lacks to return. The arguments are energy (J), angle (rad) and
        angular velocity (rad/s).
        """
        high = self.high(angle)
        if self.falls(energy, angle, spin):
            return 1.0 if angle * spin > 0 else (high - energy) / (high - self.low)
        above = energy - self.low
        if angle * spin < 0:
            above *= self.restitution(angle) ** 2
            high = self.high(-angle)
        return above / (high - self.low) - 1


def _side(angle: float) -> int:
    """The side to which a block leans."""
    return -1 if angle < 0 else 1


# ---------------------------------------------------------------- a rigid block

STEP = 4e-3
"""Time step of the rigid block times p."""

STEPS_A_RADIAN = 50
"""Fewest steps while the phase of the pulse moves on by one."""

STEPS_BETWEEN_CHECKS = 100
"""Steps between two checks of the block."""

SMALLEST_SWING = 1e-4
"""Largest angle over alpha of a swing that does not count."""

RIGID_LATEST = 60.0
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
        self._ground[:, 0] = unit.acceleration(times)
        self._mean[:, 0] = np.diff(unit.velocity(times)) / self._step
        self._system = RigidSystem(scene)
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
        self._system.resume(copy.deepcopy(self._start))
        scale = amplitude * self._upright.unit
        ground, mean = scale * self._ground, scale * self._mean
        fell, margin, angles = False, 0.0, list[Array]()
        last = self._shaken + math.ceil(RIGID_LATEST / (self._upright.frequency * self._step))
        first = 0
        while first < last:
            shaken = first < self._shaken
            stop = min(first + STEPS_BETWEEN_CHECKS, self._shaken if shaken else last)
            moved = (ground[first : stop + 1], mean[first:stop]) if shaken else (None, None)
            outcome = self._system.advance(stop - first, self._step, moved[0], mean=moved[1])
            if outcome.failure:
                raise RuntimeError(outcome.failure)
            rows, first = outcome.rows, stop
            angles.append(rows[:, self._angle])
            angle, spin = float(rows[-1, self._angle]), float(rows[-1, self._spin])
            if abs(angle) > 0.9 * math.pi / 2:
                fell, margin = True, max(margin, 0.0)
                break
            if first < self._shaken:
                continue
            energy = float(sum(rows[-1, k] for k in self._energies))
            if first == self._shaken:
                margin = self._upright.margin(energy, angle, spin)
            fell = self._upright.falls(energy, angle, spin)
            if fell or self._upright.stays(energy, angle):
                break
        least = SMALLEST_SWING * self._upright.shape.slenderness()
        return Response.of(fell, _impacts(np.concatenate(angles), least), margin)


def _impacts(angle: Array, least: float) -> int:
    """Impacts of a block: ends of swings with angles larger than the least one, rad."""
    sides = np.sign(angle[np.abs(angle) > least])
    return int(np.count_nonzero(np.diff(sides)))


# ---------------------------------------------------------------- an elastic block

ELASTIC_LATEST = 9.0
"""Time after the pulse up to which a block is run, times p; near a boundary, by a part d in
amplitude, it takes about ln(1/d) to decide, and the swing back after that."""


def elastic_scene(tables: Tables, kind: PulseKind, frequency: float, amplitude: float) -> Scene:
    """The scene of a run: frequency omega over p, amplitude over g tan alpha."""
    upright = Upright.of(variant(tables, model="rigid", restitution=None))
    p = upright.frequency
    motion = kind.table(amplitude * upright.unit, frequency * p)
    time = {key: value for key, value in tables.get("time", {}).items() if key != "end"}
    end = motion["duration"] + ELASTIC_LATEST / p
    return variant(tables | {"motion": motion}, time=time | {"end": end, "stop": "overturned"})


def elastic_fate(tables: Tables, kind: PulseKind, frequency: float, amplitude: float) -> str:
    """Fate of an elastic block under one pulse: one of the words of boundaries.

    Raises:
        RuntimeError: The run failed, or ended before the fate of the block was certain.
    """
    scene = elastic_scene(tables, kind, frequency, amplitude)
    result = simulate(scene, comm=MPI.COMM_SELF)
    if result.status != "completed":
        raise RuntimeError(f"{result.status}: {result.summary['reason']}")
    name, history = scene.blocks[0].name, result.history
    block = result.summary["blocks"][name]
    if block["overturned_at_s"] is not None:
        return fate_of(overturns=True, impacts=len(block["impacts"]))
    upright = Upright.of(variant(tables, model="rigid", restitution=None))
    energy = history["energy.kinetic_J"][-1] + history["energy.gravity_J"][-1]
    if not upright.stays(energy, history[f"{name}.angle_rad"][-1]):
        raise RuntimeError(f"{scene.time.end:g} s decide nothing at {amplitude:g} g tan alpha")
    return STAYS
