"""Numbers that the studies tell, from made-up runs whose answers are known by hand."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scenes import BLOCK

from rockslip import parse_scene
from solver.study.damping.axes import AXES, Axis, DampingCase, SweptValue
from solver.study.damping.calibration import measured_peaks
from solver.study.damping.numbers import limit, lines
from solver.study.horizon.numbers import as_text as horizons_as_text
from solver.study.horizon.numbers import growth
from solver.study.inertia import cases as inertia
from solver.study.inertia.cases import BlockCase, SlidingCase
from solver.study.inertia.cells import Cell, Structure
from solver.study.inertia.numbers import SLIDING, Curve, Finding, Line, Portion, grid
from solver.study.inertia.numbers import differences as inertia_differences
from solver.study.modes.numbers import maps_of
from solver.study.overturning.boundaries import DIRECTLY, STAYS
from solver.study.overturning.numbers import boundary_rows, differences
from solver.study.suite.cases import SuiteCase
from solver.study.suite.motions import SuiteMotion
from solver.types import Array

STRUCTURE = Structure(
    mass_ratio=1.0, period=0.5, damping_ratio=0.05, gravity=9.81, dynamic=1.0, unit_pga=False
)


def cell(friction: float) -> Cell:
    return Cell(
        values=(("friction", friction),), structure=STRUCTURE, friction=friction, aspect=None
    )


def portion(value: float | None) -> Portion:
    return Portion(
        value=value, roots=() if value is None else (value,), low=value, high=value, without=0.0
    )


def finding(friction: float, by: str, value: float | None, drift: float = 0.01) -> Finding:
    return Finding(
        cell=cell(friction), by=by, motions=4, arithmetic=portion(value), geometric=portion(value),
        means={"mean_peak_drift_m": drift},
    )  # fmt: skip


# --- inertia


def test_an_engine_that_differs_from_the_sliding_block_has_its_own_portion() -> None:
    """D = c (1 + lambda) of four motions; the run of the third failed, so that it does not count.

    Sliding blocks have lambda 0.5 and the engine's runs 0.25, with the base shears of the others.
    """
    size = np.array([1.0, 2.0, 7.0, 3.0])
    fixed = np.stack([2 * size, [1.0, 2.0, 30.0, 6.0]], axis=1)
    slides = np.stack([1.5 * size, [1.0, 1.0, 9.0, 1.0]], axis=1)
    line = Line(
        structure=STRUCTURE,
        frictions=[math.inf, 0.1],
        drifts=size[:, None] * (1 + grid()),
        peaks=np.stack([fixed, slides], axis=1),
        bare=np.stack([size, [0.5, 1.0, 9.0, 0.0]], axis=1),
    )
    fell = (0.0, 1.0, 0.0, 0.0)
    outcomes = [None if k == 2 else [1.25 * c, 2.0, 0.2, 0.1, fell[k]] for k, c in enumerate(size)]
    found = line.finding_by(cell(0.1), "rigid blocks", outcomes)
    assert (found.motions, found.overturned) == (3, 1)
    assert found.arithmetic.value == pytest.approx(0.25, abs=1e-6)
    assert found.geometric.value == pytest.approx(0.25, abs=1e-4)
    assert found.means["mean_peak_drift_m"] == pytest.approx(1.25 * (1 + 2 + 3) / 3)
    assert found.means["drift_over_fixed"] == pytest.approx(1.25 / 2)
    assert found.means["drift_over_bare"] == pytest.approx(1.25)
    assert found.means["base_shear_over_fixed"] == pytest.approx(2.0 / ((1 + 2 + 6) / 3))
    assert found.means["base_shear_over_bare"] == pytest.approx(2.0 / ((0.5 + 1 + 0) / 3))


@pytest.mark.parametrize("dynamic", [1.0, 0.5])
def test_a_block_that_slides_drags_by_dynamic_friction(tmp_path: Path, dynamic: float) -> None:
    """On a stiff structure under slowly growing ground: k u = m_P (a + r mu_d g)."""
    structure = Structure(
        mass_ratio=1.0, period=0.05, damping_ratio=0.5, gravity=10.0, dynamic=dynamic,
        unit_pga=False,
    )  # fmt: skip
    file = tmp_path / "motion.csv"
    file.write_text("0 0\n1 4.5\n2 9.0\n3 9.0\n")
    table = {"kind": "record", "file": str(file), "units": "m/s2"}
    tables = {
        "block": [{"width": 0.4, "height": 0.3, "thickness": 1.0, "mass": 1.0, "model": "rigid"}],
        "time": {"end": 3.0, "step": 1e-3},
    }
    case = SlidingCase(
        structure=structure, frictions=(0.4,), motions=(SuiteMotion(name="ramp", table=table),),
        tables=tables, folder=tmp_path,
    )  # fmt: skip
    ((found,),) = case.run()["peaks"]
    shear = 9.0 + 0.4 * dynamic * 10.0
    assert found[0] == pytest.approx(shear / (2 * math.pi / 0.05) ** 2, rel=0.01)
    assert found[1] == pytest.approx(shear, rel=0.01)


@pytest.mark.parametrize(
    ("overturned", "fell", "lost"), [(None, None, 0.0), (1.0, None, 1.0), (None, 2.0, 1.0)]
)
def test_a_block_that_falls_counts_as_one_that_overturns(
    monkeypatch: pytest.MonkeyPatch, overturned: float | None, fell: float | None, lost: float
) -> None:
    stays = {"overturned_at_s": None, "fell_at_s": None, "peak_slip_m": 0.1, "peak_angle_rad": 0.3}
    goes = stays | {"overturned_at_s": overturned, "fell_at_s": fell, "peak_slip_m": 0.2}
    scene = SimpleNamespace(platform=lambda: (2.0, 100.0, 3.0))
    result = SimpleNamespace(
        status="completed",
        history={
            "platform.drift_m": np.array([0.0, 0.1]),
            "platform.velocity_m_s": np.array([0.0, -2.0]),
        },
        summary={"platform": {"peak_drift_m": 0.1}, "blocks": {"a": stays, "b": goes}},
    )
    monkeypatch.setattr(inertia, "scene_of", lambda case: (scene, None))
    monkeypatch.setattr(inertia, "simulate", lambda scene, **rest: result)
    case = BlockCase(name="", key="key", case=cast(SuiteCase, None), unit_pga=False)
    assert case.run()["numbers"] == pytest.approx(
        [0.1, (100 * 0.1 - 3 * 2.0) / 2.0, 0.2, 0.3, lost]
    )


def test_a_root_is_followed_from_where_the_last_one_was() -> None:
    """Past the end of its branch the root nearest to the last one counts, not that nearest to 1."""
    axis = np.array([-0.5, 0.0, 0.2, 0.5, 0.8, 1.5])
    curve = Curve(axis, np.array([0.0, 0.5, 0.3, 0.8, 0.6, 1.3]))
    found = curve.followed(np.array([0.9, 0.55, 0.25, 0.7]))
    assert found == pytest.approx([1.1, 0.35, -0.25, 0.44])


def test_the_largest_difference_from_the_sliding_block_is_told() -> None:
    found = [
        *(finding(mu, SLIDING, value) for mu, value in ((0.1, 0.5), (0.2, 0.6), (0.3, None))),
        *(finding(mu, "rigid blocks", v) for mu, v in ((0.1, 0.51), (0.2, 0.57), (0.3, 0.9))),
    ]
    told = ["λ by rigid blocks is within 0.0300 of the sliding block."]
    assert inertia_differences(found) == told
    assert inertia_differences(found[:3]) == []


# --- horizon, modes, overturning, suite


def test_differences_that_grow_exponentially_have_their_rate() -> None:
    """Twins whose horizons are t0 - ln(delta)/lambda; one that has none does not count."""
    rate = 4.0
    twins: list[dict[str, Any]] = [
        {"perturbation": d, "horizon_s": 0.3 - math.log(d) / rate, "largest_difference": 1.0}
        for d in (1e-10, 1e-8, 1e-5)
    ]
    twins.append({"perturbation": 1e-14, "horizon_s": None, "largest_difference": 1e-9})
    row = {
        "engine": "rigid", "scale": 1.0, "end_s": 9.0, "peak_angle_over_alpha": 0.5,
        "overturned": False,
        "twins": twins,
    }  # fmt: skip
    assert growth(row) == pytest.approx(4.0)
    assert "rigid, scale 1: differences grow by e in 0.25 s" in horizons_as_text([row])


def onset(mode: str, turn: float, slip: float, **other: Any) -> dict[str, Any]:
    """A point whose block should turn with 4 rad/s2 and slip with 2 m/s2."""
    point = {
        "engine": "rigid", "ratio": 4.0, "mode": mode, "judged": True, "agrees": True,
        "turn_rad_s2": turn, "slip_m_s2": slip, "expected_turn_rad_s2": 4.0,
        "expected_slip_m_s2": 2.0, "rigid_turn_rad_s2": 2.0, "rigid_slip_m_s2": 1.0,
    }  # fmt: skip
    return point | other


def test_a_map_of_modes_tells_the_largest_errors_of_what_is_judged() -> None:
    """Too small is as wrong as too large; points near a boundary or in another mode do not count.

    Errors are relative, but for slips while the block rocks.
    """
    points = []
    for mode in ("slide", "rock", "slide-rock"):
        points += [
            onset(mode, 4.08, 2.04),
            onset(mode, 3.8, 1.9),
            onset(mode, 8.0, 8.0, judged=False),
            onset(mode, 9.0, 9.0, agrees=False),
        ]
    (found,) = maps_of(points)
    assert (found["points"], found["judged"], found["agree"]) == (12, 9, 6)
    assert found["expected_slide_slip"] == pytest.approx(0.05)
    assert found["expected_rock_turn"] == pytest.approx(0.05)
    assert found["expected_slide_rock_turn"] == pytest.approx(0.05)
    assert found["expected_slide_rock_slip_m_s2"] == pytest.approx(0.1)
    assert found["rigid_slide_slip"] == pytest.approx(1.04)
    assert found["rigid_rock_turn"] == pytest.approx(1.04)
    assert found["rigid_slide_rock_slip_m_s2"] == pytest.approx(1.04)


@pytest.mark.parametrize(("amplitude", "difference"), [(1.1, 0.1), (0.8, -0.2)])
def test_a_boundary_of_overturning_is_compared_with_the_rigid_one(
    amplitude: float, difference: float
) -> None:
    """Over that of the rigid block, and with the nearest one of its kind."""
    edge = {"below": STAYS, "above": DIRECTLY}
    other = {"below": DIRECTLY, "above": STAYS}
    row = {"pulse": "one_sine", "frequency": 4.0, "restitution": 0.9}
    rows = [
        row | {"engine": "rigid", "boundaries": [
            edge | {"amplitude": 1.0}, other | {"amplitude": amplitude}, edge | {"amplitude": 3.0}
        ]},
        row | {"engine": "elastic", "restitution": None, "boundaries": [
            edge | {"amplitude": amplitude}
        ]},
    ]  # fmt: skip
    edges = boundary_rows(rows, 0.9)
    assert edges[-1]["rigid_amplitude"] == 1.0
    assert edges[-1]["difference"] == pytest.approx(difference)
    assert differences(edges) == {"elastic": pytest.approx(abs(difference))}


# --- damping


def rows_of(axis: Axis, found: dict[float, float]) -> tuple[list[SweptValue], dict[str, Any]]:
    """The values of an axis and their rows: two impacts of one restitution at each value."""
    scene = parse_scene(BLOCK + "\n[time]\nend = 1.0\n")
    cases = {v: DampingCase(key=f"{v:g}", name="", scene=scene, block="block") for v in found}
    rows = {
        f"{value:g}": {
            "status": "completed",
            "reason": "",
            "impacts": [{"time_s": k, "restitution": e} for k in (0.1, 0.2)],
        }
        for value, e in found.items()
    }
    return [SweptValue(axis, value, case) for value, case in cases.items()], rows


@pytest.mark.parametrize("name", ["mesh", "step"])
def test_restitution_goes_to_its_limit_with_finer_meshes_and_shorter_steps(name: str) -> None:
    """Values that are off by 0.02 at the coarsest and by half as much at each finer one."""
    finer = (1.0, 2.0, 4.0) if name == "mesh" else (4e-3, 2e-3, 1e-3)
    off = dict(zip(finer, (0.9 + 0.02 / n for n in (1, 2, 4)), strict=True))
    (line,) = lines(*rows_of(AXES[name], off), 2)
    assert line.limit is not None and line.limit.source == "extrapolated"
    assert line.limit.value == pytest.approx(0.9, abs=1e-6)
    assert line.limit.order == pytest.approx(1.0, abs=1e-6)


def test_an_extrapolated_limit_is_as_uncertain_as_its_last_value_at_least() -> None:
    """Of first order the correction is the last difference, 0.01; the value's own error is 1e-3."""
    found = limit([1.0, 0.5, 0.25], [0.94, 0.92, 0.91], [2e-3, 2e-3, 1e-3])
    assert found is not None and found.source == "extrapolated"
    assert found.value == pytest.approx(0.9, abs=1e-6)
    assert found.uncertainty == pytest.approx(0.011, abs=1e-6)


def test_a_peak_between_measured_rows_is_that_of_its_parabola() -> None:
    """Rows that are dense on one side: their mean time is not that of the peak."""
    top, at = 0.04, 0.537
    time = np.concatenate([np.linspace(0.3, 0.5, 21), np.linspace(0.51, 0.8, 200)])
    swing = top - 0.4 * (time - at) ** 2
    first = np.linspace(0.0, 0.29, 30)
    angle: Array = np.concatenate([-0.05 * np.cos(math.pi / 0.6 * first), swing])
    found = measured_peaks(np.concatenate([first, time]), angle)
    assert found == pytest.approx([0.05, top], abs=1e-12)
