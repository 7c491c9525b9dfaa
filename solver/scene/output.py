"""What is written, and how often: the table `[output]`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from solver.scene.checking import Checked
from solver.scene.ranges import Count, Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputSpec(Checked):
    """What is written, and how often: `[output]`."""

    every: Positive = 0.01
    """Time between two snapshots of the fields, s."""
    fields: Literal["vtk", "none"] = "vtk"
    """For ParaView, or none."""
    history_every: Count = 1
    """Steps between two rows of the history."""
