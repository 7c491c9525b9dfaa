"""Rigid ground: kind = "rigid"."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from solver.scene.foundation.base import Foundation


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidSpec(Foundation):
    """The rigid ground: `[foundation]` with kind = "rigid", the default."""

    kind: Literal["rigid"] = "rigid"
    """The ground."""
