"""Content of the pictures of the studies, from made-up numbers: marks, bars and areas."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from solver.study.damping.axes import AXES
from solver.study.damping.calibration import Search, Target, Trial
from solver.study.damping.numbers import Limit, Restitution
from solver.study.damping.numbers import Line as DampingLine
from solver.study.inertia.cells import Cell, Structure
from solver.study.inertia.numbers import SLIDING, Finding, Portion
from solver.study.overturning.boundaries import DIRECTLY, LATER, STAYS
from solver.study.suite.numbers import Sample
from solver.types import Array

pytest.importorskip("matplotlib")


def bars(axes: Any, number: int = 0) -> list[tuple[float, float]]:
    """Lower and upper end of each vertical bar of a set."""
    ((container),) = [axes.containers[number]]
    (lines,) = container.lines[2]
    return [(float(low[1]), float(high[1])) for low, high in lines.get_segments()]


def of_inertia(period: float, friction: float, found: tuple[float, float, float]) -> Finding:
    """A cell with lambda and the ends of its interval."""
    structure = Structure(
        mass_ratio=1.0, period=period, damping_ratio=0.05, gravity=9.81, dynamic=1.0,
        unit_pga=False,
    )  # fmt: skip
    value, low, high = found
    portion = Portion(value=value, roots=(value,), low=low, high=high, without=0.0)
    return Finding(
        cell=Cell(
            values=(("period", period), ("friction", friction)), structure=structure,
            friction=friction, aspect=None,
        ),
        by=SLIDING, motions=4, arithmetic=portion, geometric=portion,
        means={},
    )  # fmt: skip


LAMBDAS = [
    of_inertia(0.5, 0.1, (0.2, 0.15, 0.3)),
    of_inertia(0.5, 0.3, (0.6, 0.58, 0.7)),
    of_inertia(1.0, 0.1, (0.3, 0.1, 0.32)),
    of_inertia(1.0, 0.3, (0.9, 0.5, 0.95)),
]


def test_bars_of_lambda_end_where_its_interval_does() -> None:
    from solver.study.inertia.picture import lambda_picture

    (axes,) = lambda_picture(LAMBDAS).axes
    assert bars(axes, 0) == pytest.approx([(0.15, 0.3), (0.58, 0.7)])
    assert bars(axes, 1) == pytest.approx([(0.1, 0.32), (0.5, 0.95)])
    np.testing.assert_allclose(axes.containers[0].lines[0].get_ydata(), [0.2, 0.6])


def test_a_map_of_lambda_has_shade_and_number_of_each_cell_at_its_place() -> None:
    """Periods to the right, friction upwards."""
    from solver.study.inertia.picture import map_picture

    figure = map_picture(LAMBDAS)
    figure.canvas.draw()
    axes = figure.axes[0]
    (image,) = axes.images
    across = [label.get_text() for label in axes.get_xticklabels()]
    up = [label.get_text() for label in axes.get_yticklabels()]
    assert (across, up) == (["0.5", "1"], ["0.1", "0.3"])
    low, high = axes.get_ylim()
    assert low < high
    shade = np.asarray(image.get_array())
    if image.origin == "upper":
        shade = shade[::-1]
    assert image.get_extent() == pytest.approx([-0.5, 1.5, -0.5, 1.5])
    np.testing.assert_allclose(shade, [[0.2, 0.3], [0.6, 0.9]])
    told = {text.get_position(): text.get_text() for text in axes.texts}
    assert told == {
        (0, 0): "0.200 ±0.07", (0, 1): "0.600 ±0.06", (1, 0): "0.300 ±0.11", (1, 1): "0.900 ±0.22"
    }  # fmt: skip


def sample(level: float | None, angles: tuple[float, ...]) -> Sample:
    group = (("block", "block"),)
    return Sample(group=group, engine="rigid", level=level, angle=angles, slip=())


def test_bars_of_probabilities_are_intervals_of_confidence() -> None:
    """Of none and of all of ten (Clopper and Pearson 1934): 0.025^(1/10) is their other end."""
    from solver.study.suite.picture import fragility_picture

    own = [sample(0.5, (0.3,) * 10), sample(1.0, (math.inf,) * 10)]
    (axes,) = fragility_picture([(own, None)], "PGA").axes
    end = 0.025**0.1
    assert bars(axes) == [pytest.approx((0.0, 1 - end)), pytest.approx((end, 1.0))]
    np.testing.assert_allclose(axes.containers[0].lines[0].get_ydata(), [0, 1])


def test_a_distribution_of_peaks_ends_at_the_part_that_stood() -> None:
    """Two of five overturned: the curve ends at 0.6, and jumps by 0.2 at each of the others."""
    from solver.study.suite.picture import peaks_picture

    angles = peaks_picture([sample(None, (math.inf, 0.5, 0.2, math.inf, 0.3))], "PGA").axes[0]
    (line,) = angles.lines
    np.testing.assert_allclose(line.get_xdata(), [0, 0.2, 0.3, 0.5])
    np.testing.assert_allclose(line.get_ydata(), [0, 0.2, 0.4, 0.6])
    assert line.get_drawstyle() == "steps-post"


def vertical_reach(axes: Any, label: str) -> tuple[float, float]:
    """Lower and upper end of the patch of that label."""
    (patch,) = [patch for patch in axes.patches if patch.get_label() == label]
    box = patch.get_path().get_extents(patch.get_patch_transform())
    return float(box.y0), float(box.y1)


def test_the_band_of_a_limit_is_as_wide_as_its_uncertainty() -> None:
    from solver.study.damping.picture import restitution_picture

    line = DampingLine(
        axis=AXES["step"], values=(1e-3, 5e-4),
        found=(Restitution((0.90, 0.95), 2), Restitution((0.91, 0.93), 2)),
        limit=Limit(value=0.92, uncertainty=0.004, source="reached"),
    )  # fmt: skip
    (axes,) = restitution_picture([line], None).axes
    assert vertical_reach(axes, "limit") == pytest.approx((0.916, 0.924))
    assert bars(axes) == [pytest.approx((0.90, 0.95)), pytest.approx((0.91, 0.93))]


@pytest.mark.parametrize(("own", "measured"), [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)])
def test_a_measured_history_leans_to_the_side_of_the_calibrated_run(
    own: float, measured: float
) -> None:
    """Whatever side it was released to, and its clock starts with the run's."""
    from solver.study.damping.picture import calibration_picture

    time = np.linspace(0.0, 2.0, 101)
    swing: Array = 0.05 * np.exp(-time) * np.cos(4 * time)
    search = Search(low=1e-6, high=1e-4, wanted=(0.93,), restitution=0.93)
    for value, e in ((1e-6, 0.95), (1e-5, 0.93), (1e-4, 0.91)):
        search.tell(Trial(value=value, restitution=e, found=(e,)))
    target = Target(restitution=0.93, peaks=(), impacts=4, history=(time + 12.0, measured * swing))
    above, below = calibration_picture(search, target, "beta_R (s)", (time, own * swing)).axes
    assert vertical_reach(above, "reach") == pytest.approx((0.91, 0.95))
    curves = {line.get_label(): line for line in below.lines}
    for label in ("measured", "calibrated run"):
        np.testing.assert_allclose(curves[label].get_xdata(), time, atol=1e-12)
        np.testing.assert_allclose(curves[label].get_ydata(), own * np.degrees(swing))


def boundaries(*found: tuple[float, str, str]) -> list[dict[str, Any]]:
    names = ("amplitude", "below", "above")
    return [dict(zip(names, each, strict=True)) for each in found]


def test_areas_of_other_kinds_meet_in_the_middle_of_their_frequencies() -> None:
    """Areas of one kind are joined, so that their edges go straight from row to row."""
    from solver.pictures.style import new_figure
    from solver.study.overturning.picture import _areas

    direct = [
        {"frequency": 1.0, "boundaries": boundaries((2.0, STAYS, DIRECTLY))},
        {"frequency": 2.0, "boundaries": boundaries((3.0, STAYS, DIRECTLY))},
    ]
    both = boundaries((2.5, STAYS, LATER), (4.0, LATER, STAYS), (5.0, STAYS, DIRECTLY))
    axes = new_figure(3.0).subplots()
    _areas(axes, [*direct, {"frequency": 5.0, "boundaries": both}], 8.0)
    found = [
        (patch.get_label().removeprefix("rigid block "), patch.get_xy()[:4].tolist())
        for patch in axes.patches
    ]
    assert found == [
        (DIRECTLY, [[1.0, 2.0], [1.0, 8.0], [2.0, 8.0], [2.0, 3.0]]),
        (DIRECTLY, [[2.0, 3.0], [2.0, 8.0], [3.5, 8.0], [3.5, 3.0]]),
        (LATER, [[3.5, 2.5], [3.5, 4.0], [5.0, 4.0], [5.0, 2.5]]),
        (DIRECTLY, [[3.5, 5.0], [3.5, 8.0], [5.0, 8.0], [5.0, 5.0]]),
    ]
