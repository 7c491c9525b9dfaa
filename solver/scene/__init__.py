"""A scene: all input of a simulation, checked; the one place with names and ranges of keys.

Units are SI; angles stand in degrees in keys that end in `_deg`, and nowhere else. The kinds of
foundations and motions stand in `solver.scene.foundation` and `solver.scene.motion`.
"""

from solver.scene.block import BlockSpec
from solver.scene.contact import Bed, ContactSpec, FrictionSpec, PairSpec
from solver.scene.damping import DampingSpec
from solver.scene.feet import EvenFeetSpec, FootSpec
from solver.scene.force import ForceSpec
from solver.scene.foundation import FoundationSpec, Platform
from solver.scene.link import LinkSpec
from solver.scene.mass import PartSpec
from solver.scene.motion import MotionSpec
from solver.scene.output import OutputSpec
from solver.scene.quantities import Dimension
from solver.scene.reader import load_scene, parse_scene, read_text, scene_to_toml, set_values
from solver.scene.scene import Scene
from solver.scene.shape import ShapeSpec
from solver.scene.time import TimeSpec

__all__ = [
    "Bed",
    "BlockSpec",
    "ContactSpec",
    "DampingSpec",
    "Dimension",
    "EvenFeetSpec",
    "FootSpec",
    "ForceSpec",
    "FoundationSpec",
    "FrictionSpec",
    "LinkSpec",
    "MotionSpec",
    "OutputSpec",
    "PairSpec",
    "PartSpec",
    "Platform",
    "Scene",
    "ShapeSpec",
    "TimeSpec",
    "load_scene",
    "parse_scene",
    "read_text",
    "scene_to_toml",
    "set_values",
]
