"""The summary of a made-up run: names of the interface, numbers known by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from rockslip import History, Scene, parse_scene
from solver.history.columns import columns
from solver.results.report import report
from solver.results.summary import summarise, write_json

SCENE = """
title = "made up"
[[block]]
name = "stone"
model = "rigid"
width = 0.25
height = 1.0
thickness = 0.75
mass = 503.0
[time]
end = 2.0
step = 0.01
"""


def made_up_run() -> tuple[Scene, History]:
    """A quarter swing to the right, a smaller one to the left, and 0.1 J that no formula knows."""
    scene = parse_scene(SCENE)
    upright = 503.0 * 9.81 * 0.5
    history = History(columns(["stone"]))
    for k in range(201):
        t = 0.01 * k
        angle = 0.05 * math.cos(math.pi * t) if t < 0.5 else -0.04 * math.sin(math.pi * (t - 0.5))
        values = dict.fromkeys(history.columns, 0.0) | {
            "time_s": t,
            "stone.angle_rad": angle,
            "stone.slip_m": -1e-4 * t,
            "stone.friction_force_N": 7.0 - 10.0 * t,
            "stone.centre_y_m": 0.5 + (10.0 - t) / (503.0 * 9.81),
            "stone.gap_left_m": 0.25 * math.sin(max(angle, 0)),
            "stone.gap_right_m": 0.25 * math.sin(max(-angle, 0)),
            "energy.gravity_J": upright + 10.0 - t,
            "energy.total_J": upright + 10.0 - t,
            "energy.contact_J": 0.9 * t,
            "energy.friction_J": 0.05 * t,
            "energy.ledger_error_J": -0.05 * t,
        }
        history.append([values[name] for name in history.columns])
    return scene, history


def test_names_and_numbers() -> None:
    scene, history = made_up_run()
    summary = summarise(
        scene, history, status="completed", cost={"wall_s": 1.5}, versions={"rockslip": "0"}
    )
    assert summary["schema"] == 1
    assert summary["title"] == "made up"
    assert summary["status"] == "completed"
    assert summary["cost"] == {"wall_s": 1.5}
    block = summary["blocks"]["stone"]
    assert block["mode"] == "rock"
    assert block["peak_angle_rad"] == pytest.approx(0.05)
    assert block["peak_slip_m"] == pytest.approx(2e-4)
    assert block["residual_slip_m"] == pytest.approx(-2e-4)
    assert block["peak_friction_force_N"] == pytest.approx(13.0)
    assert "platform" not in summary
    # a parabola through rows 0.01 s apart
    assert [i["time_s"] for i in block["impacts"]] == pytest.approx([0.5, 1.5], abs=2e-5)
    assert block["impacts"][0]["restitution"] == pytest.approx(0.8, rel=1e-4)
    energy = summary["energy"]
    scale = 10.0 + 1e-3 * 503.0 * 9.81
    assert energy["scale_J"] == pytest.approx(scale)
    assert energy["largest_gain_fraction"] == 0.0
    assert energy["ledger_error_fraction"] == pytest.approx(0.1 / scale)
    assert energy["loss"]["contact_J"] == pytest.approx(1.8)
    assert energy["loss_share"]["contact"] == pytest.approx(1.8 / 1.9)
    assert sum(energy["loss_share"].values()) == pytest.approx(1.0)


def test_what_is_not_known_is_null_in_the_file(tmp_path: Path) -> None:
    scene, history = made_up_run()
    cost = {"wall_s": math.nan, "steps": 3}
    summary = summarise(scene, history, status="interrupted", cost=cost, versions={})
    write_json(tmp_path / "summary.json", summary)
    again = json.loads((tmp_path / "summary.json").read_text())
    assert again["cost"] == {"wall_s": None, "steps": 3}
    assert again["blocks"] == summary["blocks"]


def test_a_run_without_a_row_has_a_summary(tmp_path: Path) -> None:
    scene, _ = made_up_run()
    summary = summarise(
        scene, History(columns(["stone"])), status="not converged", cost={}, versions={}, reason="x"
    )
    write_json(tmp_path / "summary.json", summary)
    assert summary["blocks"] == {}
    assert summary["reason"] == "x"


def in_words(slip: dict[str, float], platform: dict[str, float]) -> str:
    """Report of a run with these slips and drifts."""
    block = {"mode": "slide", "peak_angle_rad": 0.0, "peak_slip_m": 0.02, "impacts": []}
    summary = {
        "status": "completed", "end_s": 2.0, "reason": "", "blocks": {"stone": block | slip},
        "platform": platform, "energy": {}, "cost": {},
    }  # fmt: skip
    return report(summary)


def test_slips_and_drifts_are_told_in_millimetres_with_their_sides() -> None:
    """In space, where a slip has a direction and no side, how far it is."""
    drifts = {"peak_drift_m": 0.0234, "residual_drift_m": -0.00456}
    told = in_words({"residual_slip_m": -0.0123}, drifts)
    assert "peak slip 20 mm, residual slip -12.3 mm" in told
    assert "platform: peak drift 23.4 mm, residual drift -4.56 mm\n" in told
    drifts |= {"peak_drift_second_m": 0.0567, "residual_drift_second_m": 0.00789}
    told = in_words({"residual_slip_m": -0.003, "residual_slip_second_m": 0.004}, drifts)
    assert "peak slip 20 mm, residual slip 5 mm" in told
    assert "peak drift along y 56.7 mm, residual drift along y 7.89 mm\n" in told


def test_forces_of_a_platform_on_the_ground_are_told_in_kilonewtons() -> None:
    drifts = {"peak_drift_m": 0.0123, "residual_drift_m": -0.0045}
    forces = {"peak_base_shear_N": 12500.0, "peak_overturning_moment_Nm": 880.0}
    told = in_words({"residual_slip_m": 0.0}, drifts | forces)
    words = "residual drift -4.5 mm, peak base shear 12.5 kN, peak overturning moment 0.88 kN m\n"
    assert words in told
