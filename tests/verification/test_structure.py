"""Frames as structures: damping by ratio, base shear, drift of storeys, feet on springs."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np
import pytest
from ledger import completed
from swaying import decrement

from rockslip import Scene, parse_scene, simulate
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.modes import eigenvalues
from solver.build.assembly import build, initial_state
from solver.build.foundation import foundation as built
from solver.build.foundation import natural_period
from solver.errors import SceneError
from solver.results.floor_spectra import floor_spectra
from solver.run.describe import describe
from solver.run.structure_observer import StructureObserver
from solver.scene.foundation import FrameSpec

G = 9.81

FRAME: dict[str, Any] = {
    "kind": "frame",
    "deck": {"width": 4.0, "height": 0.6},
    "column": {"width": 0.1},
    "storey": 3.0,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2500.0,
    "cells": {"bay": 4, "column": 1, "deck": 1, "storey": 6},
}

PEBBLE: dict[str, Any] = {
    "width": 0.2,
    "height": 0.1,
    "mass": 1e-3,
    "model": "rigid",
}
"""A frame with this block on it is as good as empty."""

PULSE: dict[str, Any] = {"kind": "half_sine", "amplitude_g": 0.02, "duration": 0.2}


def scene(foundation: dict[str, Any], end: float, step: float, **more: Any) -> Scene:
    """The pebble, or another block, on a foundation."""
    tables = {
        "block": [PEBBLE | more.pop("block", {})],
        "plane": "stress",
        "foundation": foundation,
        "contact": {"friction": more.pop("friction", 1.0)},
        "time": {"end": end, "step": step},
    }
    return parse_scene(tables | more)


run = partial(completed, gain=math.inf, ledger=1e-8)


@pytest.mark.serial
@pytest.mark.parametrize(("young", "modes"), [(3e9, {}), (3e10, {"modes": 10})])
def test_stress_of_columns_is_that_of_their_own_material(
    tmp_path: Path, young: float, modes: dict[str, Any]
) -> None:
    """In the files: half of what they carry over the section, whatever the deck is made of."""
    pyvista = pytest.importorskip("pyvista")
    column = FRAME["column"] | {"young": young, "density": 1.0}
    time = {"end": 0.01, "step": 2e-3, "initial": "static"}
    block = {"width": 0.6, "mass": 200.0}
    standing = scene(FRAME | modes | {"column": column}, 0.01, 2e-3, time=time, block=block)
    simulate(standing, folder=tmp_path / "run")
    reader = pyvista.get_reader(str(tmp_path / "run" / "fields.pvd"))
    reader.set_active_time_value(0.0)
    (grid,) = [grid for grid in reader.read() if "stress" in grid.cell_data]
    level = grid.cell_centers().points[:, 1]
    middle = (level > -2.6) & (level < -1.6)  # the feet stand at -3.6 m
    stress = np.asarray(grid.cell_data["stress"]).reshape(-1, 9)[middle, 4]
    assert len(stress) == 4
    carried = 2500.0 * 4.0 * 0.6 + 200.0
    np.testing.assert_allclose(stress, -0.5 * carried * G / 0.1, rtol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "modes"), [(0.02, {}), (0.05, {"modes": "auto"})])
def test_free_vibration_of_a_frame_decays_by_its_damping_ratio(
    ratio: float, modes: dict[str, Any]
) -> None:
    """The logarithmic decrement of the empty frame after a pulse, within 1 %.

    A light one: under its own weight it sways 0.6 % slower, and loses as much more in a cycle.
    """
    time = {"end": 1.6, "step": 2e-3, "rho_inf": 1.0}
    tables = FRAME | {"damping_ratio": ratio} | modes
    damped = scene(tables, 1.6, 2e-3, motion=PULSE, gravity=1.0, time=time)
    assert natural_period(damped) > 100 * damped.time.step
    drift = run(damped).history["platform.drift_m"]
    exact = 2 * math.pi * ratio / math.sqrt(1 - ratio**2)
    assert decrement(drift, 150) == pytest.approx(exact, rel=0.01)
    assert f"{100 * ratio:g} % of critical at first sway" in describe(damped)


def test_damping_by_ratio_is_that_of_the_structure_alone() -> None:
    """`[damping]` goes on for blocks; a frame with both says so in one line."""
    table = {"stiffness": 1e-4}
    ratio = scene(FRAME | {"damping_ratio": 0.05}, 1.0, 1e-3, damping=table)
    assert ratio.foundation.sway_damping_ratio == 0.05
    with pytest.raises(SceneError, match=r"foundation\.damping_ratio: got both damping_ratio and"):
        scene(FRAME | {"damping_ratio": 0.05, "damping": table}, 1.0, 1e-3)
    with pytest.raises(SceneError, match=r"damping_ratio: got 1.0, allowed 0 <= damping_ratio < 1"):
        scene(FRAME | {"damping_ratio": 1.0}, 1.0, 1e-3)


@pytest.mark.parametrize(("mass_damping", "modes"), [(0.3, {}), (0.0, {"modes": 3})])
def test_base_shear_balances_all_masses_in_each_step(
    mass_damping: float, modes: dict[str, Any]
) -> None:
    """Less the sum of all masses times absolute accelerations, to 1e-10 of the largest.

    Steps of a reduced frame end after fewer corrections: to the 1e-9 of the loads these may leave.
    The elastic forces at the feet add up to it, too, but for what damping takes that is
    proportional to the mass; so do the upward ones to weight and inertia.
    """
    block = {"width": 0.5, "height": 1.5, "mass": 2000.0}
    motion = {"kind": "half_sine", "amplitude_g": 0.5, "duration": 0.3}
    tables = FRAME | {"damping": {"mass": mass_damping, "stiffness": 2e-4}, "bays": 2}
    tables |= modes
    case = scene(tables, 0.5, 2e-3, block=block, motion=motion, friction=0.5)
    found = steps(case, 250)
    shear, exact, feet, axial, lifted, moment, arms = found.T
    largest, weight = np.abs(exact).max(), lifted[0]
    assert largest > 0.05 * weight
    left = 1e-9 * weight if modes else 1e-10 * largest
    np.testing.assert_allclose(shear, exact, atol=left, rtol=0)
    through = 0.05 if mass_damping else 2e-9 * weight / largest if modes else 1e-9
    np.testing.assert_allclose(feet, exact, atol=through * largest, rtol=0)
    np.testing.assert_allclose(axial, lifted, atol=through * weight, rtol=0)
    np.testing.assert_allclose(moment, arms, atol=1e-9 * np.abs(moment).max(), rtol=0)


def steps(case: Scene, count: int) -> Any:
    """Rows of steps: base shear by forces on the ground, by masses, and at the feet, both upwards,
    overturning moment by the column and by those of the feet.
    """
    assembly = build(case)
    stepper = assembly.stepper
    system, span = stepper.system, case.time.step
    state, _ = initial_state(case, assembly)
    observer = StructureObserver(assembly)
    mass = sum(body.mass for body in system.bodies)
    assert isinstance(case.foundation, FrameSpec)
    feet = [f"foundation.column_{k + 1}" for k in range(case.foundation.bays + 1)]
    places = np.linspace(-1.95, 1.95, len(feet))
    found = []
    for _ in range(count):
        new, exchange = stepper.advance(state, span)
        inertia = system.directional_mass @ (new.v - state.v) / span
        inertia += mass * stepper.mean_base(state.time, span)
        forces = exchange.ground or stepper.ground_forces(new)
        row = observer.columns(new, forces)
        shear, axial, turn = (
            np.array([row[f"{foot}.{name}"] for foot in feet])
            for name in ("shear_N", "axial_force_N", "moment_Nm")
        )
        arms = places @ axial + turn.sum()
        ours = -forces.total[0], -inertia[0], shear.sum(), axial.sum()
        found.append((*ours, inertia[1] + mass * G, row["foundation.overturning_moment_Nm"], arms))
        state = new
    return np.array(found)


def test_statics_of_a_portal_on_an_incline() -> None:
    """Base shear and overturning moment at the start: all weight, at the height where it acts."""
    case = scene(FRAME, 4e-3, 2e-3, gravity_tilt_deg=2.0, block={"mass": 100.0})
    first = run(case).history
    deck, columns = 2500.0 * 4.0 * 0.6, 2500.0 * 2 * 0.1 * 3.0
    along, down = G * math.sin(math.radians(2)), G * math.cos(math.radians(2))
    push = (deck + columns + 100.0) * along
    assert first["foundation.base_shear_N"][0] == pytest.approx(push, rel=1e-6)
    shears = [first[f"foundation.column_{k}.shear_N"][0] for k in (1, 2)]
    assert sum(shears) == pytest.approx(push, rel=1e-6)
    axial = [first[f"foundation.column_{k}.axial_force_N"][0] for k in (1, 2)]
    assert sum(axial) == pytest.approx((deck + columns + 100.0) * down, rel=1e-6)
    drift = first["platform.drift_m"][0]
    assert first["foundation.storey_1.drift_m"][0] == pytest.approx(drift, rel=1e-9)
    moment = deck * (along * 3.3 + down * drift) + columns * (along * 1.5 + down * drift / 2)
    moment += 100.0 * (along * 3.65 + down * drift)
    assert first["foundation.overturning_moment_Nm"][0] == pytest.approx(moment, rel=1e-3)
    # Kleinlogel's portal with fixed feet, of the load on the deck; the columns' own is spread.
    stiff = (0.6 / 0.1) ** 3 * 3.0 / 3.9
    foot = (deck + 100.0) * along * 3.0 / 2 * (3 * stiff + 1) / (6 * stiff + 1)
    own = columns / 2 * along * 3.0 / 3
    both = 2 * (foot + own)
    moments = [first[f"foundation.column_{k}.moment_Nm"][0] for k in (1, 2)]
    assert sum(moments) == pytest.approx(both, rel=0.03)


def test_a_plate_on_rollers_pushes_with_its_spring_and_dashpot() -> None:
    """Base shear k u + c v, and the weight of what slides to the side turns it."""
    plate = {
        "kind": "elastic",
        "width": 2.0,
        "height": 0.2,
        "density": 2500.0,
        "young": 3e10,
        "poisson": 0.2,
        "cells": [8, 2],
        "support": "rollers",
        "period": 0.5,
        "damping_ratio": 0.05,
    }
    block = {"width": 0.4, "height": 0.4, "mass": 300.0}
    time = {"end": 0.5, "step": 1e-3, "rho_inf": 1.0, "damped_steps": 0}
    case = scene(plate, 0.5, 1e-3, block=block, motion=PULSE, time=time)
    found = run(case).history
    platform = case.platform()
    drift, speed = found["platform.drift_m"], found["platform.velocity_m_s"]
    exact = platform.stiffness * drift + platform.damping * speed
    shear = found["foundation.base_shear_N"]
    middle = (exact[1:] + exact[:-1]) / 2
    np.testing.assert_allclose(shear[1:], middle, atol=2e-3 * np.abs(exact).max())
    assert "foundation.storey_1.drift_m" not in found


STIFF_DECK: dict[str, Any] = FRAME | {
    "deck": {"width": 4.0, "height": 0.6, "young": 3e13},
    "column": {"width": 0.1, "density": 1.0},
    "cells": {"bay": 4, "column": 1, "deck": 1, "storey": 12},
}
"""Its columns bend between two ends that do not turn, and have no mass to speak of."""

SWAY = 2 * 12 * 3e10 * 0.1**3 / 12 / 3.0**3
"""Its stiffness 24 E I/h³ of Euler and Bernoulli, N/m; shear takes 0.3 % of it."""

DECK = 2500.0 * 4.0 * 0.6
"""Mass of its deck, kg."""


def frequencies(foundation: dict[str, Any], count: int = 1) -> Any:
    """Squares of the lowest natural frequencies, 1/s2."""
    body = built(scene(foundation, 1.0, 1e-3), 0, MPI.COMM_SELF).body
    assert isinstance(body, ElasticBody)
    return eigenvalues(body, count)


@pytest.mark.parametrize("cells", [(1, 1), (9, 3)])
def test_modes_of_few_unknowns_are_those_of_many(
    monkeypatch: pytest.MonkeyPatch, cells: tuple[int, int]
) -> None:
    """A coarse plate on its bottom: all modes at once, or, where there are enough, by iteration."""
    plate = {
        **{"kind": "elastic", "support": "bottom", "width": 2.0, "height": 0.3},
        **{"density": 2400.0, "young": 2e9, "poisson": 0.3, "cells": list(cells)},
    }
    squared = frequencies(plate, 4)
    assert len(squared) == 4
    # as a column sheared over its height: (pi/2 c/h)^2, on coarse meshes stiffer by mass at nodes
    shear = 2e9 / 2 / 1.3 / 2400.0
    assert 0.9 < squared[0] / ((math.pi / 2 / 0.3) ** 2 * shear) < 1.6
    if cells == (9, 3):
        monkeypatch.setattr("solver.bodies.modes.FEWEST", 0)
        np.testing.assert_allclose(frequencies(plate, 4), squared, rtol=1e-9)


def test_deck_and_columns_of_different_materials() -> None:
    """A stiff heavy deck on light columns: k/m, and with columns half as stiff k/2m."""
    assert frequencies(STIFF_DECK)[0] == pytest.approx(SWAY / DECK, rel=5e-3)
    soft = STIFF_DECK | {"column": {"width": 0.1, "density": 1.0, "young": 1.5e10}}
    assert frequencies(soft)[0] == pytest.approx(SWAY / 2 / DECK, rel=5e-3)


def test_extra_mass_of_a_storey_is_that_of_its_deck() -> None:
    """Three decks' more on the upper one: k/m (9 -+ sqrt 65)/8, from 4 x^2 - 9 x + 1 = 0."""
    storeys = STIFF_DECK | {"storey": [{"height": 3.0}, {"height": 3.0, "extra_mass": 3 * DECK}]}
    exact = SWAY / DECK * (9 + np.array([-1, 1]) * math.sqrt(65)) / 8
    np.testing.assert_allclose(frequencies(storeys, 2), exact, rtol=6e-3)


def test_feet_on_horizontal_springs_are_in_series_with_the_columns() -> None:
    """1/k = 1/k_columns + 1/k_feet."""
    feet = {"horizontal": SWAY / 4}
    exact = 1 / (1 / SWAY + 2 / SWAY) / DECK
    assert frequencies(STIFF_DECK | {"feet": feet})[0] == pytest.approx(exact, rel=5e-3)


def test_feet_on_vertical_springs_let_a_stiff_frame_rock() -> None:
    """Two springs at a distance L: k L²/2 against the inertia about the middle of the base."""
    stiff = STIFF_DECK | {"young": 3e13, "feet": {"vertical": 1e6}}
    arm, height = 3.9, 3.3
    inertia = DECK * (height**2 + (4.0**2 + 0.6**2) / 12)
    spring = 1e6 * arm**2 / 2 + 2 * 1e6 * 0.1**2 / 12
    assert frequencies(stiff)[0] == pytest.approx(spring / inertia, rel=0.01)


def test_all_of_it_at_once_keeps_ledger_and_momentum() -> None:
    """Two storeys of two materials with extra mass, on springs, under a block that slides."""
    tables = FRAME | {
        "deck": {"width": 4.0, "height": 0.4, "density": 2000.0, "extra_mass": 500.0},
        "column": {"width": 0.1, "young": 2e11, "density": 7850.0},
        "storey": [{"height": 3.0, "extra_mass": 2000.0}, {"height": 2.5, "deck_height": 0.5}],
        "feet": {"horizontal": 1e8, "vertical": 1e9},
        "damping_ratio": 0.05,
        "cells": {"bay": 4, "column": 1, "deck": 1, "storey": 4},
    }
    block = {"width": 0.5, "height": 0.5, "mass": 800.0}
    motion = {"kind": "half_sine", "amplitude_g": 0.5, "duration": 0.2}
    case = scene(tables, 0.24, 2e-3, block=block, motion=motion, friction=0.1)
    assert parse_scene(case.to_dict()) == case
    found = run(case)
    history, energy = found.history, found.summary["energy"]
    assert np.abs(history["block.slip_m"]).max() > 1e-3
    assert history["energy.spring_J"].max() > 1.0
    assert energy["ledger_error_fraction"] < 1e-8
    both = sum(history[f"foundation.storey_{k}.drift_m"] for k in (1, 2))
    np.testing.assert_allclose(both, history["platform.drift_m"], atol=1e-12)
    top = history["foundation.storey_2.velocity_m_s"]
    np.testing.assert_allclose(top, history["platform.velocity_m_s"], atol=1e-12)
    assert set(floor_spectra(found.history)) == {"ground", "storey 1", "storey 2"}
    shear, exact, feet, axial, lifted, moment, arms = steps(case, 100).T
    largest, weight = np.abs(exact).max(), lifted[0]
    np.testing.assert_allclose(shear, exact, atol=1e-10 * largest, rtol=0)
    np.testing.assert_allclose(feet, exact, atol=1e-9 * largest, rtol=0)
    np.testing.assert_allclose(axial, lifted, atol=1e-9 * weight, rtol=0)
    np.testing.assert_allclose(moment, arms, atol=1e-3 * np.abs(moment).max(), rtol=0)
    assert "feet" in describe(case)


def test_columns_in_space_are_counted_round_the_deck() -> None:
    """A heavy block over the second and the third, at +x, on an incline towards +x."""
    tables = FRAME | {
        "deck": {"width": 2.0, "height": 0.3, "thickness": 2.0},
        "column": {"width": 0.3, "density": 1.0},
        "storey": 1.0,
        "cells": {"bay": 2, "column": 1, "deck": 1, "storey": 3},
        "feet": {"vertical": 1e9},
    }
    block = {"width": 0.4, "height": 0.4, "thickness": 0.4, "mass": 4000.0, "offset": 0.7}
    asked = {"block": [PEBBLE | block], "dimension": 3, "foundation": tables}
    more = {"contact": {"friction": 1.0}, "time": {"end": 2e-3, "step": 1e-3}}
    case = parse_scene(asked | more | {"gravity_tilt_deg": 1.0})
    history = run(case).history
    axial = [history[f"foundation.column_{k}.axial_force_N"][0] for k in (1, 2, 3, 4)]
    weight = (2500.0 * 2.0 * 2.0 * 0.3 + 4000.0 + 4 * 0.3**2) * G
    assert sum(axial) == pytest.approx(weight * math.cos(math.radians(1)), rel=1e-5)
    assert axial[1] == pytest.approx(axial[2], rel=1e-6)
    assert axial[0] == pytest.approx(axial[3], rel=1e-6)
    assert axial[1] - axial[0] > 0.1 * weight
    shear = history["foundation.base_shear_N"][0]
    assert shear == pytest.approx(weight * math.sin(math.radians(1)), rel=1e-5)
    sideways = ("base_shear_second_N", "overturning_moment_second_Nm", "storey_1.drift_second_m")
    for name in sideways:
        assert abs(history[f"foundation.{name}"][0]) < 1e-6 * weight
    moment = history["foundation.overturning_moment_Nm"][0]
    pairs = [history[f"foundation.column_{k}.moment_Nm"][0] for k in (1, 2, 3, 4)]
    arms = 0.85 * (axial[1] + axial[2] - axial[0] - axial[3])
    assert moment == pytest.approx(arms + sum(pairs), rel=1e-3)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (
            {"storey": [{"height": -1.0}]},
            r"foundation\.storey\.height: got -1.0, allowed height > 0",
        ),
        (
            {"storey": {"height": 1.0}},
            r"foundation\.storey: got a table, allowed storey > 0 or an ar",
        ),
        ({"feet": {"vertical": 0.0}}, r"foundation\.feet\.vertical: got 0.0, allowed vertical > 0"),
        ({"column": {"width": 0.1, "young": 0.0}}, r"foundation\.column\.young: got 0.0, allowed"),
        ({"deck": {"width": 4.0, "height": 0.6, "extra_mass": -1.0}}, r"extra_mass >= 0"),
    ],
)
def test_what_is_no_structure_is_refused_in_one_line(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        scene(FRAME | changed, 1.0, 1e-3)


@pytest.mark.slow
def test_a_frame_drifts_as_the_oscillator_of_its_mass_stiffness_and_damping() -> None:
    """Under a block that slides: peaks within 2 %, and 3 % of the peak at all times."""
    frame = FRAME | {"column": {"width": 0.16, "density": 1.0}, "damping_ratio": 0.05}
    block = {"width": 0.8, "height": 0.4, "mass": 2000.0}
    motion = {"kind": "one_sine", "amplitude_g": 0.3, "duration": 0.4}
    more: dict[str, Any] = {"block": block, "motion": motion, "friction": 0.1}
    case = scene(frame, 0.8, 1e-3, **more)
    mass = 2500.0 * 4.0 * 0.6
    oscillator = {
        "kind": "oscillator",
        "mass": mass,
        "period": natural_period(case),
        "damping_ratio": 0.05,
    }
    meshed, single = run(case), run(scene(oscillator, 0.8, 1e-3, **more))
    drift, exact = (each.history["platform.drift_m"] for each in (meshed, single))
    assert np.abs(meshed.history["block.slip_m"]).max() > 5e-3
    peak = np.abs(exact).max()
    assert np.abs(drift).max() == pytest.approx(peak, rel=0.02)
    np.testing.assert_allclose(drift, exact, atol=0.03 * peak)
