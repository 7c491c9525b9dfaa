"""Lambda, the portion of the live load that counts as inertia: its roots, intervals, and tables.

D(lambda) is the mean peak drift of the structure with the portion lambda of the live load fixed to
it, stiffness k and dashpot c kept; lambda solves D(lambda) = mean drift under the load that slides.
D is not monotone: roots can be several, or negative, or none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

import numpy as np

from solver.study.inertia.cells import Cell, Structure
from solver.study.tables import Column, in_markdown, in_words
from solver.types import Array

LEAST, MOST, SPACING = -0.5, 1.5, 0.01
"""Range of lambda, and the spacing of the points between which D(lambda) is taken as straight."""

ROUND_OFF = 1e-9
"""A target that is this near to a point of the curve is met there."""

INSENSITIVE = 0.01
"""Part of D; lambda is not reported if D changes by less between lambda = 0 and 1."""

RESAMPLES, SEED = 1000, 19
"""Number of suites that the bootstrap draws, and the seed that it draws them by."""

QUANTILES = (0.05, 0.95)
"""Quantiles that bound an interval of 90 %."""


def grid() -> Array:
    """The values of lambda at which drifts are computed."""
    count = round((MOST - LEAST) / SPACING)
    return np.round(LEAST + SPACING * np.arange(count + 1), 10)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Mean drift against lambda, straight between its points."""

    portions: Array
    """lambda, increasing."""
    drifts: Array
    """D(lambda)."""

    @property
    def insensitive(self) -> bool:
        """True if the live load hardly changes the drift, so that there is no lambda to report."""
        inside = self.drifts[(self.portions >= 0) & (self.portions <= 1)]
        return bool(np.ptp(inside) < INSENSITIVE * np.mean(np.abs(inside)))

    def roots(self, target: float) -> Array:
        """All lambda at which the curve has this value, increasing."""
        excess = self.drifts - target
        met = np.abs(excess) <= ROUND_OFF * abs(target)
        sign = np.where(met, 0.0, np.sign(excess))
        first = np.nonzero(sign[:-1] * sign[1:] < 0)[0]
        part = excess[first] / (excess[first] - excess[first + 1])
        low, high = self.portions[first], self.portions[first + 1]
        return np.sort(np.concatenate((low + part * (high - low), self.portions[met])))

    def turns(self) -> Array:
        """Values of lambda at which the curve has a local extreme."""
        rising = np.sign(np.diff(self.drifts))
        return self.portions[1:-1][rising[:-1] * rising[1:] < 0]

    def followed(self, targets: Array) -> list[float]:
        """The root that lambda = 1 leads to as the target goes from value to value; NaN: none.

        It stays on its branch, between two local extremes of the curve, as long as that has a root;
        then it goes on from the nearest one, and where there is none it waits.
        """
        turns, at, found = self.turns(), 1.0, []
        for target in targets:
            roots = self.roots(target)
            if not roots.size:
                found.append(np.nan)
                continue
            low, high = np.minimum(roots, at), np.maximum(roots, at)
            between = np.searchsorted(turns, high) - np.searchsorted(turns, low, side="right")
            same = roots[between <= 0]
            near = same if same.size else roots
            at = float(near[np.argmin(np.abs(near - at))])
            found.append(at)
        return found


class Portion(NamedTuple):
    """Lambda of a suite of motions, with its interval."""

    value: float | None = None
    """The one reported; None: there is none."""
    roots: tuple[float, ...] = ()
    """All of them."""
    low: float | None = None
    """Lower end of the interval of 90 %."""
    high: float | None = None
    """Upper end of that interval."""
    without: float = 1.0
    """Share of the resampled suites that have none."""
    insensitive: bool = False
    """True if the live load hardly changes the drift."""

    @property
    def half_width(self) -> float:
        """Half of the interval; infinite where there is none."""
        return np.inf if self.low is None or self.high is None else (self.high - self.low) / 2

    @property
    def words(self) -> tuple[str, str]:
        """The one reported, and the ends of its interval."""
        if self.value is None or self.low is None or self.high is None:
            return number(self.value), "-"
        return number(self.value), f"{number(self.low)} to {number(self.high)}"


def number(value: float | None) -> str:
    """A lambda as a word."""
    return "none" if value is None else f"{value:.3f}"


def resampled(count: int) -> Array:
    """Share of each motion in each resampled suite, (resamples, n)."""
    chosen = np.random.default_rng(SEED).integers(count, size=(RESAMPLES, count))
    weights = np.zeros((RESAMPLES, count))
    np.add.at(weights, (np.arange(RESAMPLES)[:, None], chosen), 1.0 / count)
    return weights


def portions(drifts: Array, targets: Array, *, geometric: bool) -> list[Portion]:
    """Lambda at each of the targets, followed from the first one, where lambda is 1.

    Args:
        drifts: Peak drifts of each motion with the portions of the grid fixed, (n, points).
        targets: Peak drifts of each motion with what slides or rocks, (n, targets).
        geometric: Take means of the logarithms.
    """
    if mean_curve(drifts).insensitive:
        return [Portion(insensitive=True)] * targets.shape[1]
    known = np.all(drifts > 0, axis=0)  # where the structure has a mass that is positive
    axis, curves, aims = grid()[known], drifts[:, known], targets
    if geometric:
        curves, aims = np.log(curves), np.log(targets)
    own, means, weights = Curve(axis, curves.mean(axis=0)), aims.mean(axis=0), resampled(len(aims))
    those, aimed = weights @ curves, weights @ aims
    spread = np.array([Curve(axis, those[k]).followed(aimed[k]) for k in range(len(weights))])
    return [
        _portion(value, own.roots(mean), spread[:, j])
        for j, (value, mean) in enumerate(zip(own.followed(means), means, strict=True))
    ]


def mean_curve(drifts: Array) -> Curve:
    """Mean of the drifts of each motion against lambda, where the structure has a mass."""
    known = np.all(drifts > 0, axis=0)
    return Curve(grid()[known], drifts[:, known].mean(axis=0))


def _portion(value: float, roots: Array, spread: Array) -> Portion:
    """A value with the interval of those of the resampled suites."""
    known, own = spread[np.isfinite(spread)], None if np.isnan(value) else float(value)
    without = 1 - known.size / spread.size
    if not known.size:
        return Portion(own, tuple(map(float, roots)), without=without)
    low, high = map(float, np.quantile(known, QUANTILES))
    return Portion(own, tuple(map(float, roots)), low, high, without)


# ---------------------------------------------------------------- cells

SLIDING = "sliding block"
"""Name of the rows of one block that slides."""

WANTED = 0.05
"""Half of the width that an interval of 90 % should not exceed."""


class Finding(NamedTuple):
    """Lambda, drift and base shear of one cell, by one way of computing."""

    cell: Cell
    by: str
    """SLIDING, or an engine of the program."""
    motions: int
    arithmetic: Portion
    """lambda by the mean of the peaks, as in the paper."""
    geometric: Portion
    """By the mean of their logarithms."""
    means: Mapping[str, float]
    """Mean peak drift, m (for motions scaled to 1 g, per 1 g), over that with the whole live load
    fixed and over that of the empty structure; the same ratios of the base shear. By columns."""
    overturned: int = 0
    """Runs in which a block overturned or fell."""

    @property
    def remark(self) -> str:
        """Remark beside the numbers; empty where there is none."""
        value, said = self.arithmetic.value, []
        if self.arithmetic.insensitive:
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


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """One structure under a suite: its curve, and the ladder of friction with lambda along it."""

    structure: Structure
    frictions: Sequence[float]
    """From infinity down."""
    drifts: Array
    """Peak drifts with portions of the live load fixed, (n, points), m; 0 without a mass."""
    peaks: Array
    """Peak drift (m), base shear over the platform's mass for each friction, (n, frictions, 2)."""
    bare: Array
    """Peak drift (m) and base shear over the platform's mass of the empty structure, (n, 2)."""
    found: tuple[list[Portion], ...] = field(init=False)
    """lambda along the ladder by arithmetic and by geometric means."""

    def __post_init__(self) -> None:
        """Follow lambda along the ladder."""
        ladder = self.peaks[:, :, 0]
        both = (portions(self.drifts, ladder, geometric=mean) for mean in (False, True))
        object.__setattr__(self, "found", tuple(both))

    @classmethod
    def of(
        cls, structure: Structure, frictions: Sequence[float], rows: Sequence[Mapping[str, Any]]
    ) -> Self:
        """A line from the rows of its cases, in the order of their motions."""
        curve, peaks, bare = (
            np.array([values for row in rows for values in row[what]], dtype=float)
            for what in ("curve", "peaks", "bare")
        )
        return cls(structure, frictions, np.nan_to_num(curve), peaks, bare)

    def finding(self, cell: Cell) -> Finding:
        """The finding of a cell by the sliding block."""
        place = self.frictions.index(cell.friction)
        pair = [several[place] for several in self.found]
        return self._finding(cell, SLIDING, self.peaks[:, place], pair, slice(None))

    def finding_by(self, cell: Cell, by: str, outcomes: Sequence[list[float] | None]) -> Finding:
        """The finding of a cell by runs of blocks; motions whose run failed (None) are left out.

        lambda goes on from where the sliding block is at this friction: from that root it is
        followed while the drift changes from that of the sliding block to that of the runs.
        """
        place = self.frictions.index(cell.friction)
        chosen = np.array([outcome is not None for outcome in outcomes])
        rows = np.array([outcome for outcome in outcomes if outcome is not None])
        ladder = self.peaks[chosen, : place + 1, 0]
        targets = np.concatenate((ladder, rows[:, :1]), axis=1)
        means = (False, True)
        pair = [portions(self.drifts[chosen], targets, geometric=mean)[-1] for mean in means]
        return self._finding(cell, by, rows[:, :2], pair, chosen, int(rows[:, 4].sum()))

    def _finding(
        self,
        cell: Cell,
        by: str,
        peaks: Array,
        pair: Sequence[Portion],
        chosen: Any,
        overturned: int = 0,
    ) -> Finding:
        mean, fixed = peaks.mean(axis=0), self.peaks[chosen, 0].mean(axis=0)
        over_fixed, over_bare = mean / fixed, mean / self.bare[chosen].mean(axis=0)
        means = {
            "mean_peak_drift_m": float(mean[0]),
            "drift_over_fixed": float(over_fixed[0]),
            "drift_over_bare": float(over_bare[0]),
            "base_shear_over_fixed": float(over_fixed[1]),
            "base_shear_over_bare": float(over_bare[1]),
        }
        arithmetic, geometric = pair
        return Finding(cell, by, len(peaks), arithmetic, geometric, means, overturned)


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
        **finding.means,
        "remark": finding.remark,
    }


def entry_of(finding: Finding) -> dict[str, Any]:
    """A cell for programs."""
    return row_of(finding) | {
        "roots": list(finding.arithmetic.roots),
        "roots_geometric": list(finding.geometric.roots),
        "resampled_without": finding.arithmetic.without,
    }


def widest(findings: Sequence[Finding]) -> float:
    """Largest half width of an interval among the cells that have a lambda."""
    known = [f.arithmetic.half_width for f in findings if f.arithmetic.value is not None]
    return max(known, default=math.nan)


# ---------------------------------------------------------------- tables

COLUMNS = (
    *(Column("by", "by"), Column("λ", "λ"), Column("λ 90 %", "90 %")),
    *(Column("geometric", "λ geometric"), Column("geometric 90 %", "90 %")),
    Column("mean_peak_drift_m", "drift mm", ".2f", 1e3),
    Column("drift_over_fixed", "drift / fixed", ".3f"),
    Column("base_shear_over_fixed", "base shear / fixed", ".3f"),
    Column("base_shear_over_bare", "base shear / empty", ".3f"),
    Column("said", "all roots, remark"),
)
"""Columns of the text that follow those of the axes."""


def words(findings: Sequence[Finding]) -> list[list[str]]:
    """The most important numbers as words, row by row; the first row is the heading."""
    axes = [Column(name, name, "g") for name, _ in findings[0].cell.values]
    return in_words(map(_told, findings), [*axes, *COLUMNS])


def _told(finding: Finding) -> dict[str, Any]:
    """What the text tells of a finding, besides its row."""
    roots = finding.arithmetic.roots
    several = ", ".join(map(number, roots)) if len(roots) > 1 else ""
    row = row_of(finding) | dict(finding.cell.values)
    row["λ"], row["λ 90 %"] = finding.arithmetic.words
    row["geometric"], row["geometric 90 %"] = finding.geometric.words
    return row | {"said": "; ".join(part for part in (several, finding.remark) if part)}


def differences(findings: Sequence[Finding]) -> list[str]:
    """Largest distance of each engine from the sliding block, in words."""
    closed = {f.cell: f.arithmetic.value for f in findings if f.by == SLIDING}
    largest: dict[str, float] = {}
    for finding in (finding for finding in findings if finding.by != SLIDING):
        value, other = finding.arithmetic.value, closed[finding.cell]
        if value is not None and other is not None:
            largest[finding.by] = max(largest.get(finding.by, 0.0), abs(value - other))
    return [f"λ by {by} is within {d:.4f} of the sliding block." for by, d in largest.items()]


def markdown(
    title: str, findings: Sequence[Finding], failed: Sequence[str], notes: Sequence[str]
) -> str:
    """The table in Markdown, with what failed and what is noted of the motions."""
    count = f"Motions: {findings[0].motions}. λ is by the mean of peaks unless it says geometric."
    lines = [f"# {title}", "", count, "", *in_markdown(words(findings))]
    lines += ["", *(f"- failed: {name}" for name in failed)] if failed else []
    lines += ["", *(f"- {note}" for note in notes)]
    return "\n".join(lines) + "\n"
