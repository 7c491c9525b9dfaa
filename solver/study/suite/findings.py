"""What an ensemble says: distributions of peaks, probabilities of overturning, fitted curves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from solver.study.suite.ensemble import Ensemble
from solver.study.suite.folder import CURVES, DISTRIBUTIONS, FRAGILITY, FRAGILITY_TEXT
from solver.study.suite.fragility import Lognormal, distance, fitted, interval
from solver.study.tables import Row, as_csv, column_names, in_columns, write

Group = tuple[tuple[str, str], ...]
"""Varied keys and their values, as text."""

QUANTILES = (0.16, 0.5, 0.84)
"""Quantiles of the peaks: the median, and one standard deviation to both sides."""


@dataclass(frozen=True, slots=True)
class Sample:
    """The motions of one level on one block by one engine.

    Attributes:
        group: Varied keys and values, and the name of the block.
        engine: What answered; "" where the scene ran as it is.
        level: Intensity; None: the motions as they are.
        angle: Peaks of |theta|/alpha while the block stood; infinite where it overturned.
        slip: Peaks of slip while it stood, m; none by an equation without slip.
    """

    group: Group
    engine: str
    level: float | None
    angle: tuple[float, ...]
    slip: tuple[float, ...]

    @property
    def overturned(self) -> int:
        """How many motions overturned the block."""
        return sum(math.isinf(angle) for angle in self.angle)

    @property
    def words(self) -> str:
        """The group in words."""
        return ", ".join(f"{key} {value}" if key != "block" else value for key, value in self.group)

    def row(self) -> dict[str, Any]:
        """Its row of the table."""
        low, high = interval(self.overturned, len(self.angle))
        found: dict[str, Any] = {**dict(self.group), "engine": self.engine, "level": self.level}
        found |= {"motions": len(self.angle), "overturned": self.overturned}
        found |= {"probability": self.overturned / len(self.angle)}
        found |= {"probability_low": low, "probability_high": high}
        for name, values in (("angle_over_alpha", self.angle), ("slip_m", self.slip)):
            for part in QUANTILES:
                # The least value that so many motions do not exceed: there is nothing between one
                # that overturns and one that does not.
                known = math.nan
                if values:
                    known = float(np.quantile(values, part, method="inverted_cdf"))
                found[f"{name}_{100 * part:.0f}"] = known if math.isfinite(known) else None
        return found


def samples(rows: Sequence[Row], varied: Sequence[str], blocks: Sequence[str]) -> list[Sample]:
    """The samples of a suite's rows that were completed, of the blocks of these names."""
    keys = [key for key in varied if key not in ("engine", "level")]
    done = [row for row in rows if row["status"] == "completed"]
    found = []
    for values in dict.fromkeys(tuple((key, str(row[key])) for key in keys) for row in done):
        inside = [row for row in done if all(str(row[key]) == value for key, value in values)]
        for name in blocks:
            for engine, level in dict.fromkeys((r.get("engine"), r.get("level")) for r in inside):
                own = [r for r in inside if (r.get("engine"), r.get("level")) == (engine, level)]
                slips = (row.get(f"{name}.peak_slip_while_standing_m") for row in own)
                angles = tuple(_angle(row, name) for row in own)
                group = (*values, ("block", name))
                known = tuple(slip for slip in slips if slip is not None)
                found.append(Sample(group, engine or "", level, angles, known))
    return found


def _angle(row: Row, name: str) -> float:
    """Peak of |theta|/alpha; infinite where the block overturned."""
    if row[f"{name}.overturned_at_s"] is not None:
        return math.inf
    return float(row[f"{name}.peak_angle_over_alpha_while_standing"])


def fits(found: Sequence[Sample]) -> Iterator[tuple[list[Sample], Lognormal | None]]:
    """The samples of each block and engine over their levels, and the curve through them."""
    for group, engine in dict.fromkeys((sample.group, sample.engine) for sample in found):
        own = [s for s in found if (s.group, s.engine) == (group, engine) and s.level is not None]
        if own:
            levels = [sample.level or math.nan for sample in own]
            trials = [len(sample.angle) for sample in own]
            yield own, fitted(levels, [sample.overturned for sample in own], trials)


def distances(found: Sequence[Sample]) -> list[dict[str, Any]]:
    """Pair by pair of engines: Kolmogorov-Smirnov distances, and parts that overturned."""
    rows = []
    for one, other in combinations(found, 2):
        if (one.group, one.level) == (other.group, other.level):
            parts = [sample.overturned / len(sample.angle) for sample in (one, other)]
            slip = distance(one.slip, other.slip) if one.slip and other.slip else None
            rows.append({
                **dict(one.group), "level": one.level, "engines": [one.engine, other.engine],
                "angle": distance(one.angle, other.angle), "slip": slip,
                "overturned": parts[1] - parts[0],
            })  # fmt: skip
    return rows


def write_findings(
    folder: Path,
    rows: Sequence[Row],
    varied: Sequence[str],
    blocks: Sequence[str],
    ensemble: Ensemble,
) -> dict[str, Any]:
    """Write tables and pictures of an ensemble; returns what the summary says of it."""
    found = samples(rows, varied, blocks)
    measure = {"intensity": ensemble.axis} if ensemble.intensity else {}
    table = [sample.row() | measure for sample in found]
    curves = list(fits(found))
    apart = distances(found)
    write(folder / FRAGILITY, as_csv(table, column_names(table)))
    write(folder / FRAGILITY_TEXT, as_text(found, curves, apart, ensemble))
    if found:
        from solver.study.suite.fragility_picture import draw_curves, draw_distributions

        if curves:
            draw_curves(curves, ensemble.axis, folder / CURVES)
        draw_distributions(found, ensemble.axis, folder / DISTRIBUTIONS)
    return {
        "levels": table,
        "fits": [
            {**dict(own[0].group), "engine": own[0].engine, **(asdict(curve) if curve else {})}
            for own, curve in curves
        ],
        "distances": apart,
    }


def as_text(
    found: Sequence[Sample],
    curves: Sequence[tuple[list[Sample], Lognormal | None]],
    apart: Sequence[Mapping[str, Any]],
    ensemble: Ensemble,
) -> str:
    """Probabilities, quantiles, curves and distances for reading."""
    heading = ["block", "engine", ensemble.axis or "level", "motions", "overturned", "P", "95 %"]
    heading += ["|theta|/alpha 16 %", "50 %", "84 %", "slip mm 50 %", "84 %"]
    table = [heading]
    for sample in found:
        row = sample.row()
        between = f"{row['probability_low']:.3f}-{row['probability_high']:.3f}"
        angles = [_shown(row[f"angle_over_alpha_{q}"], 1.0, "over") for q in (16, 50, 84)]
        slips = [_shown(row[f"slip_m_{q}"], 1e3, "-") for q in (50, 84)]
        level = "-" if sample.level is None else f"{sample.level:g}"
        counts = [f"{row['motions']}", f"{row['overturned']}", f"{row['probability']:.3f}"]
        table.append([sample.words, sample.engine or "-", level, *counts, between, *angles, *slips])
    lines = in_columns(table, left=2)
    lines += [_sentence(own[0], curve, ensemble) for own, curve in curves]
    for pair in apart:
        level = "" if pair["level"] is None else f" at {pair['level']:g}"
        slip = "" if pair["slip"] is None else f", of slip {pair['slip']:.3f}"
        lines.append(
            f"{_words(pair)}, {' and '.join(pair['engines'])}{level}: distance of angles "
            f"{pair['angle']:.3f}{slip}, overturned {100 * pair['overturned']:+.0f} points"
        )
    return "\n".join(lines) + "\n"


def _words(row: Mapping[str, Any]) -> str:
    """The group of a comparison in words: all that stands before its level."""
    keys = list(row)[: list(row).index("level")]
    return ", ".join(row[key] if key == "block" else f"{key} {row[key]}" for key in keys)


def _shown(value: float | None, factor: float, otherwise: str) -> str:
    return otherwise if value is None else f"{factor * value:.3f}"


def _sentence(first: Sample, curve: Lognormal | None, ensemble: Ensemble) -> str:
    """A fitted curve in words."""
    name = f"{first.words} {first.engine}".strip()
    if curve is None:
        return f"{name}: no lognormal curve goes through these levels"
    low, high = curve.median_interval
    return (
        f"{name}: median {curve.median:.4g} ({low:.4g} to {high:.4g}), beta {curve.beta:.3f} "
        f"+- {curve.beta_error:.3f}, of {ensemble.axis}"
    )
