"""What carries the blocks: one file per kind; a new kind is one more file and a line below."""

from __future__ import annotations

from typing import TypeAlias

from solver.scene.foundation.base import Foundation, Platform
from solver.scene.foundation.frame import (
    ColumnSpec,
    DeckSpec,
    FeetSpec,
    FrameCellsSpec,
    FrameSpec,
    StoreySpec,
)
from solver.scene.foundation.ground import RigidSpec
from solver.scene.foundation.oscillator import OscillatorSpec
from solver.scene.foundation.plate import PlateSpec

FoundationSpec: TypeAlias = RigidSpec | OscillatorSpec | PlateSpec | FrameSpec
"""All kinds, told apart by `kind`; the first is the default."""

__all__ = [
    "ColumnSpec",
    "DeckSpec",
    "FeetSpec",
    "Foundation",
    "FoundationSpec",
    "FrameCellsSpec",
    "FrameSpec",
    "OscillatorSpec",
    "PlateSpec",
    "Platform",
    "RigidSpec",
    "StoreySpec",
]
