"""Files of a run, and how often they are written: the table `[output]`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from solver.scene.checking import Checked, exactly_one
from solver.scene.quantities import Count, Duration, Positive

#: Snapshots of a run that does not say how many, and the least time between two of them, s.
SNAPSHOTS, LEAST_TIME = 300, 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckpointSpec(Checked):
    """Interval at which a run writes its state: `output.checkpoint`."""

    steps: Count | None = None
    """Steps between two checkpoints. Default: this or `minutes`."""
    minutes: Positive | None = None
    """Wall time between two checkpoints, min. Default: this or `steps`."""

    def check(self) -> None:
        """Refuse values that do not go together."""
        exactly_one(self, "steps", "minutes")


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputSpec(Checked):
    """Files of a run, and how often they are written: `[output]`."""

    every: Duration | None = None
    """Time between two snapshots of the fields, s. Default: 0.01, or a 300th of the run where that
    is longer."""
    fields: Literal["vtk", "none"] = "vtk"
    """For ParaView: a file for each body and time, which other programs read as well; or none."""
    history_every: Count = 1
    """Steps between two rows of the history, which peaks, impacts and spectra are read from."""
    checkpoint: CheckpointSpec | None = None
    """Interval of `checkpoint.npz`, from which `rockslip run --resume DIR` goes on, a table as
    `{ steps = 1000 }` or `{ minutes = 10.0 }`. Default: none is written."""
    pairs: bool = False
    """Writes `pairs.csv` beside the history: normal force, friction, gap and slip of each two
    bodies that have touched, at the times of its rows."""
    twin: bool = False
    """Run the scene once more with a motion that is stronger by a millionth, or without
    motion from such a start, and adaptive steps of a fourth of the tolerance: `summary.json` then
    says up to which time both are the same. It takes as long as the run, adaptive 1.6 times."""

    def snapshot_time(self, end: float) -> float:
        """Time between two snapshots, s, of a run to a time, s."""
        return max(LEAST_TIME, end / SNAPSHOTS) if self.every is None else self.every
