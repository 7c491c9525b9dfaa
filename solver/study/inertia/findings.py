"""From the numbers of the runs to what is said of each cell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from solver.study.inertia.cells import Cell, Structure
from solver.study.inertia.portion import Curve, Portion, grid, portions, resampled
from solver.study.inertia.runs import BARE, CURVE, closed_key
from solver.types import Array

CLOSED = "closed form"
"""What the rows by the closed form of the sliding block are called."""

WANTED = 0.05
"""Half of the width that an interval of 90 % should not exceed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What one way of computing says of one cell."""

    cell: Cell
    by: str
    """CLOSED, or an engine of the program."""
    motions: int
    arithmetic: Portion
    """lambda by the mean of the peaks, as in the paper."""
    geometric: Portion
    """By the mean of their logarithms."""
    insensitive: bool
    """Whether the live load hardly changes the drift."""
    drift: float
    """Mean peak drift, m; for motions scaled to 1 g, per 1 g."""
    drift_over_fixed: float
    """Over that with the whole live load fixed."""
    drift_over_bare: float
    """Over that of the empty structure."""
    shear_over_fixed: float
    """Mean peak base shear over that with the whole live load fixed."""
    shear_over_bare: float
    """Over that of the empty structure."""
    overturned: int = 0
    """Runs in which a block overturned or fell."""

    @property
    def remark(self) -> str:
        """What has to be said besides the numbers; empty: nothing."""
        value, said = self.arithmetic.value, []
        if self.insensitive:
            said.append("not reported: the live load changes the drift by less than 1 %")
        elif value is None:
            said.append("none: no portion in the range gives this drift")
        elif value < 0:
            said.append("negative: the drift is below that of the empty structure")
        if len(self.arithmetic.roots) > 1:
            said.append(f"{len(self.arithmetic.roots)} roots")
        if value is not None and self.arithmetic.half_width > WANTED:
            said.append(f"interval wider than ±{WANTED:g}")
        if value is not None and self.arithmetic.without > 0:
            said.append(f"{self.arithmetic.without:.0%} of resampled suites without")
        if self.overturned:
            said.append(f"blocks overturned or fell in {self.overturned} motions")
        return "; ".join(said)


@dataclass(slots=True)
class Line:
    """One structure under a suite: its curve, and the ladder of friction with lambda along it."""

    structure: Structure
    frictions: Sequence[float]
    """From infinity down."""
    drifts: Array
    """Peak drifts with portions of the live load fixed, (n, points), m."""
    peaks: Array
    """Peak drift, base shear, slip for each friction, (n, frictions, 3)."""
    bare: Array
    """Peak drift, base shear, slip of the empty structure, (n, 3)."""
    weights: Array
    """Weights of the motions in the resampled suites."""
    found: dict[bool, list[Portion]] = field(default_factory=dict)
    """lambda along the ladder by arithmetic (False) and geometric (True) means."""

    @classmethod
    def of(
        cls,
        structure: Structure,
        frictions: Sequence[float],
        motions: Sequence[str],
        runs: Mapping[str, list[float]],
    ) -> Line:
        """A line from the numbers of its runs, by the hashes of its motions."""

        def taken(what: str | float) -> Array:
            return np.array([runs[closed_key(structure, what, motion)] for motion in motions])

        line = cls(
            structure=structure,
            frictions=frictions,
            drifts=np.nan_to_num(taken(CURVE).astype(float)),
            peaks=np.stack([taken(friction) for friction in frictions], axis=1),
            bare=taken(BARE),
            weights=resampled(len(motions)),
        )
        for mean in (False, True):
            line.found[mean] = portions(
                line.drifts, line.peaks[:, :, 0], line.weights, geometric=mean
            )
        return line

    @property
    def mean_curve(self) -> Curve:
        """Mean drift against lambda where the structure has a mass."""
        known = np.all(self.drifts > 0, axis=0)
        return Curve(grid()[known], self.drifts[:, known].mean(axis=0))

    def finding(self, cell: Cell) -> Finding:
        """What the closed form says of a cell."""
        place = self.frictions.index(cell.friction)
        pair = tuple(self.found[mean][place] for mean in (False, True))
        return self._finding(cell, CLOSED, self.peaks[:, place, :], pair, slice(None))

    def finding_by(self, cell: Cell, by: str, outcomes: Sequence[list[float] | None]) -> Finding:
        """What runs of blocks say of a cell; motions whose run failed (None) are left out.

        lambda goes on from where the sliding block is at this friction: from that root it is
        followed while the drift changes from that of the sliding block to that of the runs.
        """
        place = self.frictions.index(cell.friction)
        chosen = np.array([outcome is not None for outcome in outcomes])
        rows = np.array([outcome for outcome in outcomes if outcome is not None])
        count = int(chosen.sum())
        ladder = self.peaks[chosen, : place + 1, 0]
        targets = np.concatenate((ladder, rows[:, :1]), axis=1)
        weights = self.weights if count == len(chosen) else resampled(count)
        pair = tuple(
            portions(self.drifts[chosen], targets, weights, geometric=mean)[-1]
            for mean in (False, True)
        )
        overturned = int(rows[:, 4].sum())
        return self._finding(cell, by, rows[:, :3], pair, chosen, overturned)

    def _finding(
        self,
        cell: Cell,
        by: str,
        peaks: Array,
        pair: tuple[Portion, ...],
        chosen: Any,
        overturned: int = 0,
    ) -> Finding:
        drift, shear, _ = peaks.mean(axis=0)
        fixed, bare = self.peaks[chosen, 0].mean(axis=0), self.bare[chosen].mean(axis=0)
        return Finding(
            cell=cell,
            by=by,
            motions=len(peaks),
            arithmetic=pair[0],
            geometric=pair[1],
            insensitive=self.mean_curve.insensitive,
            drift=float(drift),
            drift_over_fixed=float(drift / fixed[0]),
            drift_over_bare=float(drift / bare[0]),
            shear_over_fixed=float(shear / fixed[1]),
            shear_over_bare=float(shear / bare[1]),
            overturned=overturned,
        )


def row_of(finding: Finding) -> dict[str, Any]:
    """A row of the table of all numbers."""
    arithmetic, geometric = finding.arithmetic, finding.geometric
    structure = finding.cell.structure
    friction = "friction_over_pga" if structure.unit_pga else "friction"
    row: dict[str, Any] = {
        "mass_ratio": structure.mass_ratio,
        "period_s": structure.period,
        "damping_ratio": structure.damping_ratio,
        friction: finding.cell.friction,
    }
    if finding.cell.aspect is not None:
        row["aspect"] = finding.cell.aspect
    return row | {
        "by": finding.by,
        "motions": finding.motions,
        "lambda": arithmetic.value,
        "lambda_low": arithmetic.low,
        "lambda_high": arithmetic.high,
        "roots": " ".join(f"{root:.6f}" for root in arithmetic.roots),
        "lambda_geometric": geometric.value,
        "lambda_geometric_low": geometric.low,
        "lambda_geometric_high": geometric.high,
        "mean_peak_drift_m": finding.drift,
        "drift_over_fixed": finding.drift_over_fixed,
        "drift_over_bare": finding.drift_over_bare,
        "base_shear_over_fixed": finding.shear_over_fixed,
        "base_shear_over_bare": finding.shear_over_bare,
        "remark": finding.remark,
    }


def widest(findings: Sequence[Finding]) -> float:
    """Largest half width of an interval among the cells that have a lambda."""
    known = [f.arithmetic.half_width for f in findings if f.arithmetic.value is not None]
    return max(known, default=math.nan)
