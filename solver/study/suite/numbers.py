"""Numbers of a suite: the most important ones as text, and means of ratios.

Of ensembles also distributions of peaks, probabilities of overturning, and lognormal curves through
them.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from solver.results.report import ROUND_OFF
from solver.study.tables import Column, Row, column_names, groups, in_columns, in_words
from solver.types import Array

SHOWN = tuple(
    Column(key, heading, form, factor, least=ROUND_OFF)
    for key, heading, form, factor in (
        ("pga_g", "PGA g", ".3f", 1.0),
        ("pga_second_g", "along y", ".3f", 1.0),
        ("pga_vertical_g", "vertical", ".3f", 1.0),
        ("platform.peak_drift_m", "drift mm", ".3f", 1e3),
        ("reference.platform.peak_drift_m", "reference", ".3f", 1e3),
        ("platform.peak_drift_ratio", "ratio", ".4f", 1.0),
        (".peak_angle_rad", "angle rad", ".3g", 1.0),
        (".peak_angle_ratio", "ratio", ".4f", 1.0),
        (".peak_slip_m", "slip mm", ".3f", 1e3),
        (".peak_slip_ratio", "ratio", ".4f", 1.0),
        (".residual_slip_m", "residual", ".3f", 1e3),
        (".mode", "mode", "", 1.0),
        (".overturned_at_s", "overturned s", ".3f", 1.0),
        (".fell_at_s", "fell s", ".3f", 1.0),
        ("wall_s", "wall s", ".1f", 1.0),
    )
)
"""Columns of the text; keys that begin with a dot are of each block."""

MOST_CAUTIONS = 10
"""Number of cases whose cautions are printed; those of all others stand in the table."""

CONFIDENCE = 0.95
"""Probability that an interval holds what it is for."""

LARGEST_LOGARITHM = 700.0
"""Magnitude of logarithms of numbers that floating point has, with something to spare."""

Group = tuple[tuple[str, str], ...]
"""Varied keys and their values, as text."""

QUANTILES = (0.16, 0.5, 0.84)
"""Quantiles of the peaks: the median, and one standard deviation to both sides."""


def as_text(rows: Sequence[Row], varied: Sequence[str], notes: Sequence[str] = ()) -> str:
    """The most important numbers, the means of the ratios, what went wrong, and what is noted."""
    there = [key for key in column_names(rows) if any(row.get(key) is not None for row in rows)]
    columns = [Column(key, key) for key in ("motion", *varied, "status")]
    several = len([key for key in there if is_of_block(key, ".mode")]) > 1
    for shown in SHOWN:
        for name in there:
            if name == shown.key or is_of_block(name, shown.key):
                owner = f"{name.split('.')[0]} " if several and shown.key.startswith(".") else ""
                columns.append(shown._replace(key=name, heading=owner + shown.heading))
    lines = in_columns(in_words(rows, columns))
    means = [_sentence(mean, varied) for mean in ratios(rows, varied)]
    for part in (means, remarks(rows, varied), cautions(rows, varied), notes):
        lines += ["", *part] if part else []
    return "\n".join(lines) + "\n"


def ratios(rows: Sequence[Row], varied: Sequence[str]) -> list[dict[str, Any]]:
    """Mean, standard deviation, least and largest of each ratio, for each of the varied values."""
    found = []
    for group, inside in groups(rows, lambda row: tuple(str(row[k]) for k in varied)).items():
        for name in (key for key in column_names(rows) if key.endswith("_ratio")):
            values = [row[name] for row in inside if row.get(name) is not None]
            if values:
                found.append(
                    {
                        "varied": dict(zip(varied, group, strict=True)),
                        "ratio": name,
                        "count": len(values),
                        "mean": statistics.fmean(values),
                        "deviation": statistics.pstdev(values),
                        "least": min(values),
                        "largest": max(values),
                    }
                )
    return found


def is_of_block(name: str, ending: str) -> bool:
    """True if a column is a block's own measure."""
    of_others = name.startswith(("reference.", "platform."))
    return ending.startswith(".") and name.endswith(ending) and not of_others


def _sentence(mean: Mapping[str, Any], varied: Sequence[str]) -> str:
    """The mean of a ratio in words."""
    group = "".join(f"{key} {mean['varied'][key]}, " for key in varied)
    return (
        f"{group}{mean['ratio']}: mean {mean['mean']:.4f}, deviation {mean['deviation']:.4f}, "
        f"{mean['least']:.4f} to {mean['largest']:.4f}, {mean['count']} motions"
    )


def remarks(rows: Sequence[Row], varied: Sequence[str]) -> list[str]:
    """A line for each case that has a reason."""
    reasons = [row for row in rows if row.get("reason")]
    return [f"{_name(row, varied)}: {row['status']}: {row['reason']}" for row in reasons]


def cautions(rows: Sequence[Row], varied: Sequence[str]) -> list[str]:
    """A line for each of the first cases that have cautions."""
    careful = [row for row in rows if row.get("cautions")]
    first = careful[:MOST_CAUTIONS]
    lines = [f"{_name(row, varied)}: caution: {row['cautions']}" for row in first]
    if len(careful) > MOST_CAUTIONS:
        lines.append(f"{len(careful) - MOST_CAUTIONS} more cases have cautions: see suite.csv")
    return lines


def _name(row: Row, varied: Sequence[str]) -> str:
    """Motion and varied values of a case."""
    return ", ".join([row["motion"], *(f"{key} {row[key]}" for key in varied)])


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
        """Number of motions that overturned the block."""
        return sum(math.isinf(angle) for angle in self.angle)

    @property
    def words(self) -> str:
        """The group in words."""
        return group_in_words(self.group)

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
    for values, inside in groups(done, lambda r: tuple((key, str(r[key])) for key in keys)).items():
        those = groups(inside, lambda row: (row.get("engine"), row.get("level")))
        for name in blocks:
            for (engine, level), own in those.items():
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


@dataclass(frozen=True, slots=True)
class Lognormal:
    """P(x) = Phi(ln(x/median)/beta): the probability of overturning at the intensity x.

    Attributes:
        median: Intensity at which half of all motions overturn the block.
        beta: Standard deviation of the logarithm of the intensity that overturns it.
        median_interval: Of confidence, for the median.
        beta_error: Standard error of beta.
    """

    median: float
    beta: float
    median_interval: tuple[float, float]
    beta_error: float

    def probability(self, intensity: Array) -> Array:
        """Probability of overturning at intensities > 0."""
        from scipy.stats import norm

        return np.asarray(norm.cdf(np.log(intensity / self.median) / self.beta))


def interval(count: int, trials: int) -> tuple[float, float]:
    """Interval of confidence of a probability (Clopper and Pearson 1934), which is never too short.

    Args:
        count: How often it happened.
        trials: Of how many times.
    """
    from scipy.stats import binomtest

    found = binomtest(count, trials).proportion_ci(CONFIDENCE, method="exact")
    return float(found.low), float(found.high)


def fitted(
    levels: Sequence[float], counts: Sequence[int], trials: Sequence[int]
) -> Lognormal | None:
    """The lognormal curve of largest likelihood of what happened at some levels.

    With P = Phi(b ln x - a) the logarithm of the likelihood is concave in a and b (a probit
    regression). It has a maximum where some motion overturns at a level below one at which another
    does not; None where there is none such, and where probabilities do not rise to speak of.

    Args:
        levels: Intensities > 0.
        counts: How many overturned at each level.
        trials: Of how many.
    """
    from scipy.optimize import minimize
    from scipy.stats import norm

    x, k, n = np.log(np.asarray(levels)), np.asarray(counts), np.asarray(trials)
    if not (k > 0).any() or not (k < n).any() or x[k > 0].min() >= x[k < n].max():
        return None
    middle, spread = float(x.mean()), float(np.ptp(x))
    z = (x - middle) / spread  # both parameters are then numbers near one

    def cost(parameters: Array) -> tuple[float, Array]:
        arguments = parameters[1] * z - parameters[0]
        above, below = norm.logcdf(arguments), norm.logsf(arguments)
        density = norm.logpdf(arguments)
        rate = k * np.exp(density - above) - (n - k) * np.exp(density - below)
        value = -float(k @ above + (n - k) @ below)
        return value, np.array([rate.sum(), -(rate @ z)])

    a, b = minimize(cost, np.array([0.0, 1.0]), jac=True, method="BFGS").x
    if b <= 0:
        return None
    arguments = b * z - a
    weight = n * np.exp(2 * norm.logpdf(arguments) - norm.logcdf(arguments) - norm.logsf(arguments))
    information = np.array([[weight.sum(), -(weight @ z)], [-(weight @ z), (weight * z) @ z]])
    covariance = np.linalg.inv(information)
    slope = spread * np.array([1 / b, -a / b**2])  # of ln(median) by a and b
    error = math.sqrt(float(slope @ covariance @ slope))
    centre, wide = middle + spread * a / b, float(norm.ppf(0.5 + CONFIDENCE / 2)) * error
    if not abs(centre) + wide < LARGEST_LOGARITHM:
        return None  # as many overturn at all levels
    return Lognormal(
        median=math.exp(centre),
        beta=float(spread / b),
        median_interval=(math.exp(centre - wide), math.exp(centre + wide)),
        beta_error=spread / b**2 * math.sqrt(float(covariance[1, 1])),
    )


def fits(found: Sequence[Sample]) -> Iterator[tuple[list[Sample], Lognormal | None]]:
    """The samples of each block and engine over their levels, and the curve through them."""
    scaled = [sample for sample in found if sample.level is not None]
    for own in groups(scaled, lambda sample: (sample.group, sample.engine)).values():
        levels = [sample.level or math.nan for sample in own]
        trials = [len(sample.angle) for sample in own]
        yield own, fitted(levels, [sample.overturned for sample in own], trials)


def distances(found: Sequence[Sample]) -> list[dict[str, Any]]:
    """Pair by pair of engines: Kolmogorov-Smirnov distances, and parts that overturned."""
    from scipy.stats import ks_2samp

    def distance(one: Sequence[float], other: Sequence[float]) -> float:
        """The largest difference of two distributions; blocks that overturned are infinite."""
        return float(ks_2samp(one, other, method="asymp").statistic)

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


def fragility_text(
    found: Sequence[Sample],
    curves: Sequence[tuple[list[Sample], Lognormal | None]],
    apart: Sequence[Mapping[str, Any]],
    axis: str,
) -> str:
    """Probabilities, quantiles, curves and distances for reading."""
    angles = ((16, "|theta|/alpha 16 %"), (50, "50 %"), (84, "84 %"))
    slips = ((50, "slip mm 50 %"), (84, "84 %"))
    columns = [
        *(Column("words", "block"), Column("engine", "engine")),
        *(Column("level", axis or "level", "g"), Column("motions", "motions")),
        *(Column("overturned", "overturned"), Column("probability", "P", ".3f")),
        Column("between", "95 %"),
        *(Column(f"angle_over_alpha_{q}", name, ".3f", unknown="over") for q, name in angles),
        *(Column(f"slip_m_{q}", name, ".3f", 1e3) for q, name in slips),
    ]
    rows = [sample.row() | {"words": sample.words} for sample in found]
    for row in rows:
        row["engine"] = row["engine"] or "-"
        row["between"] = f"{row['probability_low']:.3f}-{row['probability_high']:.3f}"
    lines = in_columns(in_words(rows, columns), left=2)
    lines += [_curve_in_words(own[0], curve, axis) for own, curve in curves]
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
    return group_in_words([(key, row[key]) for key in keys])


def group_in_words(group: Sequence[tuple[str, str]]) -> str:
    """Varied keys with their values, and the name of the block."""
    return ", ".join(value if key == "block" else f"{key} {value}" for key, value in group)


def _curve_in_words(first: Sample, curve: Lognormal | None, axis: str) -> str:
    """A fitted curve in words."""
    name = f"{first.words} {first.engine}".strip()
    if curve is None:
        return f"{name}: no lognormal curve goes through these levels"
    low, high = curve.median_interval
    return (
        f"{name}: median {curve.median:.4g} ({low:.4g} to {high:.4g}), beta {curve.beta:.3f} "
        f"+- {curve.beta_error:.3f}, of {axis}"
    )
