"""The parts of a scene: the one place where keys are named and their ranges stand.

Units are SI; angles stand in degrees in keys that end in `_deg`, and nowhere else.
"""

from solver.specs.block import BlockSpec
from solver.specs.contact import ContactSpec, FrictionSpec, friction_law
from solver.specs.foundation import (
    ColumnSpec,
    DeckSpec,
    FoundationSpec,
    FrameCellsSpec,
    FrameSpec,
    OscillatorSpec,
    PlateSpec,
    Platform,
    RigidSpec,
)
from solver.specs.motion import (
    HalfSineSpec,
    MotionSpec,
    OneSineSpec,
    RecordSpec,
    RectangularSpec,
    RickerSpec,
    SineSpec,
    StillSpec,
    SyntheticSpec,
    TableSpec,
)
from solver.specs.ranges import Dimension, Finite, NotNegative, Positive, Tilt
from solver.specs.run import DampingSpec, OutputSpec, TimeSpec

__all__ = [
    "BlockSpec",
    "ColumnSpec",
    "ContactSpec",
    "DampingSpec",
    "DeckSpec",
    "Dimension",
    "Finite",
    "FoundationSpec",
    "FrameCellsSpec",
    "FrameSpec",
    "FrictionSpec",
    "HalfSineSpec",
    "MotionSpec",
    "NotNegative",
    "OneSineSpec",
    "OscillatorSpec",
    "OutputSpec",
    "PlateSpec",
    "Platform",
    "Positive",
    "RecordSpec",
    "RectangularSpec",
    "RickerSpec",
    "RigidSpec",
    "SineSpec",
    "StillSpec",
    "SyntheticSpec",
    "TableSpec",
    "Tilt",
    "TimeSpec",
    "friction_law",
]
