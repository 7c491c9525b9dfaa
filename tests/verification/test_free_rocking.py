"""The paper's block, released from three degrees: impacts, energy, forces, rest."""

from __future__ import annotations

import numpy as np
import pytest
from ledger import ledger_error

from benchmarks.damped_steps import reaction_noise, scatter
from geometry.tags import FacetTag
from rockslip import Result, Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.contact.interface import carry_over
from solver.reference.housner import housner

BLOCK = {
    "width": 0.25,
    "height": 1.0,
    "thickness": 0.75,
    "mass": 503.0,
    "young": 5.0e10,
    "poisson": 0.2,
    "tilt_deg": 3.0,
}


def scene(*overrides: str) -> Scene:
    """The scene of the demo, with changes."""
    tables = {
        "block": [BLOCK],
        "contact": {"friction": 0.7},
        "damping": {"stiffness": 0.0},
        "time": {"end": 3.0, "step": 1e-3, "rho_inf": 0.8},
    }
    return parse_scene(tables, overrides=overrides)


@pytest.fixture(scope="module")
def run() -> Result:
    """Three seconds with every default."""
    return simulate(scene())


@pytest.mark.slow
def test_it_completes_with_one_factorization_of_each_scheme(run: Result) -> None:
    """Of the steps of rho_inf 0.8, and of those after changes of contact; one without these."""
    assert run.status == "completed"
    assert run.summary["cost"]["steps"] == 3000
    assert run.summary["cost"]["rejected_steps"] == 0
    assert run.summary["cost"]["factorizations"] == 2
    for override in ("time.damped_steps=0", "time.rho_inf=0", "time.rho_inf=1"):
        short = simulate(scene("time.end=0.22", override))
        assert short.summary["cost"]["factorizations"] == 1
    assert len(run.history) == 3001


def test_impacts_follow_housner(run: Result) -> None:
    """The first has no restitution in it; the loss of the later ones is first order in dt."""
    spec = scene().blocks[0]
    reference = housner(spec.shape, gravity=9.81, tilt=spec.tilt, end=1.5, step=1e-3).impacts
    times = [impact["time_s"] for impact in run.summary["blocks"]["block"]["impacts"]]
    assert times[0] == pytest.approx(0.1916, rel=2e-3)
    assert times[1:5] == pytest.approx(list(reference[1:5]), rel=0.03)


def test_energy_never_rises_and_the_ledger_closes(run: Result) -> None:
    energy = run.summary["energy"]
    assert energy["largest_gain_fraction"] < 1e-6
    assert energy["ledger_error_fraction"] < 1e-8
    for name in ("friction", "contact", "numerical"):
        lost = run.history[f"energy.{name}_J"]
        assert lost[-1] > 0, f"{name} should have taken something"
    assert np.diff(run.history["energy.contact_J"]).min() > -1e-9 * energy["scale_J"]


def test_columns_agree_with_one_another(run: Result) -> None:
    """Total, forces and angle against what the other columns say."""
    history, shape = run.history, scene().blocks[0].shape
    stored = sum(history[f"energy.{n}_J"] for n in ("kinetic", "strain", "gravity", "interface"))
    assert stored == pytest.approx(history["energy.total_J"], abs=1e-9)
    assert history["energy.gravity_J"] == pytest.approx(
        shape.mass * 9.81 * history["block.centre_y_m"], rel=1e-12
    )
    # Vertical impulse and momentum over the whole run: the sum of dt (N - m g) is m v_y at the end.
    impulse = 1e-3 * np.sum(history["block.normal_force_N"][1:] - shape.weight(9.81))
    speed = np.gradient(history["block.centre_y_m"], 1e-3)[-1]
    assert impulse == pytest.approx(shape.mass * speed, abs=1e-3 * shape.weight(9.81))


@pytest.mark.parametrize(("rho_inf", "largest"), [(0.8, 0.05), (0.5, 0.01)])
def test_reaction_before_the_first_impact(rho_inf: float, largest: float) -> None:
    """Turning about one corner, its reaction is that of a rigid block, without a filter."""
    run = scene("time.end=0.19", f"time.rho_inf={rho_inf}")
    result = simulate(run)
    time, noise = result.history["time_s"], reaction_noise(run, result)
    window = (time > 0.6 * 0.1916) & (time < 0.95 * 0.1916)
    assert np.abs(np.mean(noise[window])) < 0.01
    assert np.std(noise[window]) < largest


@pytest.mark.slow
@pytest.mark.parametrize(
    ("largest", "overrides"),
    [
        (0.02, []),
        (0.05, ["time.damped_steps=0", "damping.stiffness=1e-5"]),
    ],
)
def test_reaction_between_impacts(largest: float, overrides: list[str]) -> None:
    """The vibration that an impact starts and the step does not resolve is over within it.

    Nothing is filtered. Without steps that are damped it dies within the swing.
    """
    run = scene("time.end=1.4", *overrides)
    found = scatter(run, simulate(run))
    assert len(found) == 5
    assert max(found) < largest


@pytest.mark.parametrize(
    "overrides",
    [
        ("time.rho_inf=0.0", "block.young=1e6", "contact.friction=0.3"),
        ("time.rho_inf=1.0", "block.young=1e6", "contact.friction=10.0"),
        ("time.rho_inf=1.0", "block.young=1e12", "contact.friction=10.0"),
        ("contact.points=gauss",),
        ("block.cell=triangle", "damping.stiffness=1e-4", "damping.mass=0.5"),
        ("block.degree=2", "plane=stress"),
        ("block.refinement=3.0", "damping.stiffness=1e-5"),
    ],
    ids=lambda overrides: " ".join(overrides),
)
def test_energy_over_the_grid_in_short(overrides: tuple[str, ...]) -> None:
    """Corners of what a scene can have."""
    result = simulate(scene("time.end=1.2", "time.step=2e-3", *overrides))
    energy = result.summary["energy"]
    assert result.status == "completed"
    assert energy["largest_gain_fraction"] < 1e-5
    assert energy["ledger_error_fraction"] < 1e-8


def test_theta_of_minus_one_closes_its_ledger() -> None:
    """It has no energy that cannot rise, but what it does is accounted for."""
    energy = simulate(scene("time.end=0.6", "contact.theta=-1")).summary["energy"]
    assert energy["ledger_error_fraction"] < 1e-8
    assert energy["largest_gain_fraction"] < 1e-3


@pytest.mark.slow
def test_restitution_beside_damping_by_mass_on_an_incline() -> None:
    """Impacts lose what they lose without it: from peaks it was 0.90.

    Vibration that the next rows still hold scatters the momentum by 0.003; in steps of 1 ms, which
    do not resolve the impact, by 0.005.
    """
    swings = "gravity_tilt_deg=0.2", "time.end=0.4", "damping.stiffness=1e-4", "time.step=2.5e-4"
    plain, damped = (
        simulate(scene(*swings, f"damping.mass={mass}")).summary["blocks"]["block"]["impacts"][0]
        for mass in (0.0, 0.5)
    )
    assert damped["restitution"] == pytest.approx(plain["restitution"], abs=3e-3)


@pytest.mark.slow
def test_a_block_that_tips_over_lies_on_its_side() -> None:
    """From 16 degrees, beyond alpha: over its corner, onto its side, to rest."""
    result = simulate(scene("block.tilt_deg=16.0", "time.end=3.0"))
    angle = np.rad2deg(result.history["block.angle_rad"])
    block = result.summary["blocks"]["block"]
    assert angle[-1] == pytest.approx(90.0, abs=0.5)
    assert np.ptp(angle[-200:]) < 0.01
    assert block["mode"] == "overturned"
    assert result.history["block.centre_y_m"][-1] == pytest.approx(0.125, rel=1e-4)
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-5
    assert result.summary["energy"]["ledger_error_fraction"] < 1e-8
    assert result.history["block.normal_force_N"][-200:].mean() == pytest.approx(
        scene().blocks[0].shape.weight(9.81), rel=1e-3
    )


@pytest.mark.slow
def test_a_side_that_joins_under_the_floor_throws_nothing_up() -> None:
    """With a Gauss point at a fifth of one cell the corner sinks in: its side joins deep down.

    Its lowest points, in cells far smaller, are let alone until they are out again.
    """
    changes = ["contact.points='gauss'", "block.cells=[1, 6]", "block.refinement=20"]
    result = simulate(scene("block.tilt_deg=20.0", "time.end=1.5", *changes))
    assert result.history["block.angle_rad"][-1] == pytest.approx(np.pi / 2, abs=1e-6)
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9


def test_memory_survives_when_a_face_joins() -> None:
    """The bottom's points keep force and anchor once the side is there."""
    assembly = build(scene())
    stepper = assembly.stepper
    state, _ = initial_state(scene(), assembly)
    state, _ = stepper.advance(state, 1e-3)
    before, alone = state.contacts[0], stepper.links[0].interface
    keys = alone.keys
    assert int(FacetTag.RIGHT) not in state.active[0].faces
    faces = frozenset({FacetTag.BOTTOM, FacetTag.RIGHT})
    pair, active = stepper._interfaces._pairs[0], state.active[0]._replace(faces=faces)
    together = pair.links(active, frozenset())[0].interface
    fresh = together.start(state.u, None, np.eye(2), np.eye(2))
    after = carry_over(before, alone, together, fresh)
    place = {key: k for k, key in enumerate(together.keys)}
    assert len(place) > len(keys)
    for k, key in enumerate(keys):
        assert after.force[place[key]] == pytest.approx(before.force[k])
        assert after.anchor[place[key]] == before.anchor[k]


def test_a_block_released_from_its_side_shows_its_bottom_corners() -> None:
    """The bottom no longer faces the floor; the gaps are still those of its corners."""
    result = simulate(scene("block.tilt_deg=70.0", "time.end=0.002"))
    assert result.history["block.gap_left_m"][0] == pytest.approx(0.25 * np.sin(np.deg2rad(70)))
    assert result.history["block.gap_right_m"][0] == pytest.approx(0.0, abs=1e-12)


def test_slip_is_continuous_from_pivot_to_pivot(run: Result) -> None:
    """The foreshortened base of a tilted block, 0.34 mm here, is no slip when it comes down.

    Steps in contact only: where it hops it really moves, by 0.02 mm in a step.
    """
    closed = run.history["contact_points_closed"] > 0
    late = (run.history["time_s"][1:] > 2.5) & closed[1:] & closed[:-1]
    assert late.sum() > 300
    assert np.abs(np.diff(run.history["block.slip_m"])[late]).max() < 2e-5


def test_digits_last_far_from_the_origin() -> None:
    """Turning in free flight, 50 m away: inertia is not a difference of large displacements."""
    block = {"width": 0.2, "height": 0.2, "density": 1000.0, "young": 1e7, "poisson": 0.2}
    block |= {"velocity": [0.0, 100.0], "angular_velocity": 2.0, "cells": [2, 2]}
    timing = {"end": 0.5, "step": 1e-3}
    contact = {"friction": 0.5}
    tables = {"block": [block], "contact": contact, "time": timing, "gravity": 0.0}
    tables["damping"] = {"stiffness": 0.0}
    history = simulate(parse_scene(tables)).history
    moving = history["energy.kinetic_J"][0]
    assert np.abs(ledger_error(history)).max() < 1e-13 * moving
