"""A scene at another scale: the model of a prototype, or the other way round.

Accelerations stay what they are, gravity included, so that times go with the square root of
lengths. Either the material keeps its density, and moduli go with lengths; or it keeps its moduli,
and the density goes with the inverse of lengths (masses are added to a model). In both cases
strains, friction and damping ratios are the same, and histories of angles over p t.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Literal

from solver.scene.checking import key_of
from solver.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Dimensions:
    """How a quantity goes with the density and with lengths: powers of their scales."""

    density: float = 0.0
    length: float = 0.0


NUMBER = Dimensions()
LENGTH = Dimensions(length=1)
TIME, RATE, SPEED = Dimensions(length=0.5), Dimensions(length=-0.5), Dimensions(length=0.5)
SLOWNESS = Dimensions(length=-0.5)
MASS, DENSITY = Dimensions(1, 3), Dimensions(1, 0)
STRESS, SPRING, BED = Dimensions(1, 1), Dimensions(1, 2), Dimensions(1, 0)

_SIZES = {"width": LENGTH, "height": LENGTH, "thickness": LENGTH}
_MATERIAL = {"young": STRESS, "poisson": NUMBER, "density": DENSITY}
_PULSE = {"amplitude_g": NUMBER, "duration": TIME, "start": TIME}

DIMENSIONS: dict[str, dict[str, Dimensions]] = {
    "Scene": {"gravity": NUMBER, "gravity_tilt_deg": NUMBER},
    "BlockSpec": {
        **_SIZES,
        **dict.fromkeys(("offset", "offset_second"), LENGTH),
        **{"mass": MASS, "density": DENSITY, "young": STRESS, "poisson": NUMBER},
        **{"tilt_deg": NUMBER, "tilt_direction_deg": NUMBER},
        **{"velocity": SPEED, "angular_velocity": RATE},
        **dict.fromkeys(("friction", "refinement", "restitution"), NUMBER),
    },
    "FrictionSpec": {"static": NUMBER, "dynamic": NUMBER, "decay": SLOWNESS, "cohesion": STRESS},
    "ContactSpec": {"gamma": NUMBER, "friction": NUMBER, "stiffness": BED, "damping": NUMBER},
    "DampingSpec": {"mass": RATE, "stiffness": TIME},
    "OscillatorSpec": {
        **{"mass": MASS, "mass_ratio": NUMBER, "period": TIME, "stiffness": SPRING},
        "damping_ratio": NUMBER,
    },
    "PlateSpec": {
        **_SIZES,
        **{"mass": MASS, "mass_ratio": NUMBER, "density": DENSITY},
        **{"young": STRESS, "poisson": NUMBER},
        **{"period": TIME, "stiffness": SPRING, "damping_ratio": NUMBER},
    },
    "FrameSpec": {
        **{"storey": LENGTH, "damping_ratio": NUMBER},
        **_MATERIAL,
    },
    "DeckSpec": _SIZES | _MATERIAL | {"extra_mass": MASS},
    "ColumnSpec": {"width": LENGTH, "thickness": LENGTH} | _MATERIAL,
    "StoreySpec": {"height": LENGTH, "deck_height": LENGTH, "extra_mass": MASS},
    "FeetSpec": {"horizontal": SPRING, "vertical": SPRING},
    "SineSpec": {"amplitude_g": NUMBER, "period": TIME, "cycles": NUMBER, "start": TIME},
    "HalfSineSpec": _PULSE,
    "OneSineSpec": _PULSE,
    "RectangularSpec": _PULSE,
    "RickerSpec": _PULSE | {"frequency": RATE},
    "TimeSpec": {
        **dict.fromkeys(("end", "step", "smallest", "largest"), TIME),
        **{"rho_inf": NUMBER, "tolerance": NUMBER},
    },
    "OutputSpec": {"every": TIME},
    "CheckpointSpec": {"minutes": NUMBER},
}
"""What each key with a number is, by the table; motions from samples are written as files."""


@dataclass(frozen=True, slots=True)
class Scale:
    """The scale of a model: its lengths over those of the prototype, and what its material keeps.

    Raises:
        ValueError: The scale is no positive number.
    """

    lengths: float
    keeps: Literal["density", "young"] = "density"

    def __post_init__(self) -> None:
        """Check the scale."""
        if not 0 < self.lengths < math.inf:
            raise ValueError(f"lengths times {self.lengths}")

    def of(self, dimensions: Dimensions) -> float:
        """The factor on a quantity."""
        density = 1.0 if self.keeps == "density" else 1 / self.lengths
        return float(density**dimensions.density * self.lengths**dimensions.length)

    @property
    def times(self) -> float:
        """The factor on times."""
        return self.of(TIME)


def scaled_tables(scene: Scene, scale: Scale, motions: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """The tables of a scene at another scale, every default written out.

    Args:
        scene: The prototype.
        scale: Of the model.
        motions: Tables that stand for motions from samples at the new scale, by their paths
            ("motion", "motion.vertical").
    """
    tables = _scaled(dataclasses.replace(scene, motion=None), scale)
    found = {
        path: motions.get(path) or _scaled(_alone(motion), scale) for path, motion in scene.motions
    }
    if found:
        tables["motion"] = found.pop("motion")
        tables["motion"] |= {path.removeprefix("motion."): table for path, table in found.items()}
    return tables


def _alone(motion: Any) -> Any:
    """A motion without those in other directions."""
    return dataclasses.replace(motion, vertical=None, second=None)


def _scaled(spec: Any, scale: Scale) -> dict[str, Any]:
    """A table of a scene at another scale."""
    known, tables = DIMENSIONS.get(type(spec).__name__, {}), {}
    for field in dataclasses.fields(spec):
        value = getattr(spec, field.name)
        if value is not None:
            tables[key_of(field)] = _value(value, scale, known.get(field.name))
    return tables


def _value(value: Any, scale: Scale, dimensions: Dimensions | None) -> Any:
    """A value of a table at another scale."""
    if dataclasses.is_dataclass(value):
        return _scaled(value, scale)
    if isinstance(value, tuple):
        return [_value(item, scale, dimensions) for item in value]
    if not isinstance(value, float):
        return value
    if dimensions is None:
        raise KeyError(f"a number without dimensions: {value}")
    return value * scale.of(dimensions)
