"""The picture of all runs of a suite shows every run where its numbers say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from solver.study.suite.numbers import as_text
from solver.study.suite.picture import panels_of

pytest.importorskip("matplotlib")

ROWS: list[dict[str, Any]] = [
    {"motion": "a", "contact.friction": "0.1", "status": "completed", "pga_g": 0.2,
     "block.peak_slip_m": 0.01, "block.peak_angle_rad": 0.0, "block.overturned_at_s": None,
     "reference.block.peak_slip_m": 0.011},
    {"motion": "b", "contact.friction": "0.1", "status": "completed", "pga_g": 0.5,
     "block.peak_slip_m": 0.05, "block.peak_angle_rad": 0.0, "block.overturned_at_s": None},
    {"motion": "b", "contact.friction": "0.4", "status": "completed", "pga_g": 0.5,
     "block.peak_slip_m": 0.002, "block.peak_angle_rad": 1.5, "block.overturned_at_s": 3.0},
    {"motion": "c", "contact.friction": "0.4", "status": "failed", "reason": "unreadable"},
]  # fmt: skip


def test_every_run_is_a_mark() -> None:
    from solver.study.suite.picture import suite_picture

    shown = [row for row in ROWS if "pga_g" in row]
    panels = panels_of(shown)
    assert [label for _, label, _ in panels] == ["block peak slip (mm)", "block peak angle (°)"]
    slips, angles = suite_picture(shown, ["contact.friction"], panels).axes
    curves = {line.get_label(): line for line in slips.lines}
    assert set(curves) == {
        "friction 0.1", "friction 0.4", "rigid-body answer", "overturned or fell"
    }  # fmt: skip
    np.testing.assert_allclose(curves["friction 0.1"].get_xdata(), [0.2, 0.5])
    np.testing.assert_allclose(curves["friction 0.1"].get_ydata(), [10, 50])
    np.testing.assert_allclose(curves["rigid-body answer"].get_ydata(), [11])
    lost = {line.get_label(): line for line in angles.lines}["overturned or fell"]
    np.testing.assert_allclose(lost.get_ydata(), np.degrees([1.5]))
    assert not panels_of(ROWS[-1:])


def test_round_off_is_neither_drawn_nor_told() -> None:
    rows = [{"motion": "m", "status": "completed", "reason": "", "pga_g": 0.1, "wall_s": 1.0,
             "block.peak_slip_m": 0.01, "block.residual_slip_m": -1e-12,
             "block.peak_angle_rad": 6.7e-17, "block.mode": "slide", "cautions": ""}]  # fmt: skip
    assert [name for name, _, _ in panels_of(rows)] == ["block.peak_slip_m"]
    line = as_text(rows, ()).splitlines()[1]
    assert "e-17" not in line and "-0.000" not in line and " 10.000 " in line
