"""A scene: what is asked, checked; the one place where keys are named and their ranges stand.

Units are SI; angles stand in degrees in keys that end in `_deg`, and nowhere else.
"""

from solver.scene.block import BlockSpec
from solver.scene.contact import ContactSpec, FrictionSpec, friction_law
from solver.scene.damping import DampingSpec
from solver.scene.foundation import (
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
from solver.scene.motion import (
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
from solver.scene.output import OutputSpec
from solver.scene.ranges import Dimension, Finite, NotNegative, Positive, Tilt
from solver.scene.reader import load_scene, parse_scene, read_text, scene_to_toml, set_values
from solver.scene.scene import Scene
from solver.scene.time import TimeSpec

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
    "Scene",
    "SineSpec",
    "StillSpec",
    "SyntheticSpec",
    "TableSpec",
    "Tilt",
    "TimeSpec",
    "friction_law",
    "load_scene",
    "parse_scene",
    "read_text",
    "scene_to_toml",
    "set_values",
]
