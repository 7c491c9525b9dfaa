"""Floor response spectra against closed forms, on made-up histories."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene, simulate
from solver.excitation.motion import read_ground
from solver.excitation.spectrum import PERIODS, response_spectrum
from solver.history.columns import columns
from solver.history.history import History
from solver.pictures.ground import draw_floors, write_floors
from solver.results.floor_spectra import floor_spectra

OMEGA = 2 * math.pi / 0.5


def history(time: np.ndarray, *, storeys: int = 0) -> History:
    """Ground and floors that move by sines of 1 m/s2: floors as much more again, each."""
    structure = (storeys, 0) if storeys else None
    names = columns(["block"], platform=True, structure=structure)
    found = History(names)
    rows = np.zeros((len(time), len(names)))
    rows[:, names.index("time_s")] = time
    rows[:, names.index("base.acceleration_m_s2")] = np.sin(OMEGA * time)
    velocity = (1 - np.cos(OMEGA * time)) / OMEGA
    rows[:, names.index("platform.velocity_m_s")] = velocity
    for k in range(storeys):
        rows[:, names.index(f"foundation.storey_{k + 1}.velocity_m_s")] = (k + 1) * velocity
    found.extend(rows)
    return found


@pytest.mark.parametrize("kind", ["even", "uneven"])
def test_a_floor_that_shakes_by_a_sine_amplifies_as_the_closed_form_says(kind: str) -> None:
    """After many cycles, 1/sqrt((1 - r²)² + (2 xi r)²); a stiff oscillator moves with the floor."""
    near = int(np.abs(PERIODS - 0.5).argmin())
    r = PERIODS[near] / 0.5
    amplified = 1 / math.hypot(1 - r**2, 2 * 0.05 * r)
    assert amplified > 9.0
    time = np.arange(0.0, 15.0, 1e-3)
    if kind == "uneven":
        time = np.sort(np.concatenate([time, time[::7] + 3e-4]))
    spectra = floor_spectra(history(time, storeys=2))
    assert list(spectra) == ["ground", "storey 1", "storey 2"]
    for times, spectrum in enumerate(spectra.values(), start=1):
        assert spectrum[near] == pytest.approx(times * amplified, rel=0.01)
        assert spectrum[0] == pytest.approx(times, rel=0.01)


def test_without_storeys_the_platform_is_the_floor(tmp_path: Path) -> None:
    spectra = floor_spectra(history(np.arange(0.0, 2.0, 1e-3)))
    np.testing.assert_allclose(spectra["platform"], 2 * spectra["ground"], rtol=1e-4)
    table = np.genfromtxt(write_floors(spectra, tmp_path), delimiter=",", names=True)
    assert table.dtype.names == ("period_s", "ground_m_s2", "platform_m_s2")
    np.testing.assert_allclose(table["platform_m_s2"], spectra["platform"], rtol=1e-8)
    assert len(draw_floors(spectra).axes[0].lines) == 2


@pytest.mark.parametrize("second", [False, True])
def test_the_ground_is_that_of_the_scene_where_rows_are_far_apart(second: bool) -> None:
    """At a twentieth of its period a sine between rows is 1 to 4 % off."""
    sine = {"kind": "sine", "amplitude_g": 0.3, "period": 0.2, "cycles": 20}
    tables: dict[str, Any] = {
        "dimension": 3,
        "block": [{"model": "rigid", "width": 1.0, "thickness": 1.0, "height": 0.4, "mass": 500.0}],
        "foundation": {"kind": "oscillator", "mass_ratio": 1.0, "period": 0.4},
        "motion": {"kind": "none", "second": sine} if second else sine,
        "time": {"end": 4.0, "step": 1e-2},
    }
    scene = parse_scene(tables)
    history = simulate(scene).history
    time = np.arange(0.0, 4.0, 2e-4)
    exact = response_spectrum(0.3 * 9.81 * np.sin(10 * math.pi * time), 2e-4, PERIODS)
    name = "ground along y" if second else "ground"
    np.testing.assert_allclose(floor_spectra(history, read_ground(scene))[name], exact, rtol=4e-3)
    assert np.abs(floor_spectra(history)[name] / exact - 1).max() > 0.02


def test_where_nothing_moves_there_are_no_floors() -> None:
    assert floor_spectra(History(columns(["block"]))) == {}
    assert floor_spectra(history(np.array([0.0]))) == {}
