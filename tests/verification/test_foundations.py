"""Foundations: edges of plates, many facets, equilibrium, flight, frames and their periods."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from ledger import completed
from scipy.integrate import solve_ivp

from rockslip import Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.build.foundation import natural_period
from solver.results.events import HOPS
from solver.run.describe import describe

G = 9.81

SQUAT = {
    "width": 0.6,
    "height": 0.4,
    "thickness": 1.0,
    "mass": 600.0,
    "young": 3e10,
    "poisson": 0.2,
    "cells": [4, 2],
}

PLATE = {
    "kind": "elastic",
    "width": 2.0,
    "height": 0.2,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2500.0,
    "support": "bottom",
    "cells": [20, 2],
}

FRAME = {
    "kind": "frame",
    "deck": {"width": 4.0, "height": 0.6},
    "column": {"width": 0.1},
    "storey": 3.0,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2500.0,
    "cells": {"bay": 8, "column": 1, "deck": 1, "storey": 8},
}


def scene(foundation: dict[str, Any], end: float, step: float, **more: Any) -> Scene:
    """The squat block, or another one, on a foundation."""
    tables = {
        "block": [SQUAT | more.pop("block", {})],
        "foundation": foundation,
        "contact": {"friction": more.pop("friction", 0.2)},
        "damping": {"stiffness": 0.0},
        "time": {"end": end, "step": step},
    }
    return parse_scene(tables | more)


run = partial(completed, gain=1e-5, ledger=1e-8)


@pytest.mark.slow
def test_a_block_slides_off_the_edge_and_falls(falls_on: None) -> None:
    """It tips over the edge, turning towards +x, and ends in free fall."""
    block: dict[str, Any] = {"offset": 0.5, "velocity": [2.0, 0.0]}
    result = run(scene(PLATE, 0.9, 2e-3, friction=0.1, block=block))
    history = result.history
    assert result.summary["blocks"]["block"]["mode"] == "fell"
    assert history["block.angle_rad"][-1] > 0.3
    assert history["block.centre_y_m"][-1] < -0.2
    assert history["block.normal_force_N"][-20:] == pytest.approx(0.0, abs=1e-9)
    fall = np.diff(history["block.centre_y_m"][-20:], 2) / 2e-3**2
    assert fall == pytest.approx(-G, rel=1e-3)
    stored = history["energy.total_J"][-20:]
    assert np.ptp(stored) < 5e-6 * abs(result.summary["energy"]["scale_J"])


@pytest.mark.slow
def test_a_floor_on_its_bottom_is_the_rigid_face_when_it_is_stiff() -> None:
    """The paper's block rocks on both: what is between them is the floor's own flexibility.

    A floor of ordinary concrete takes 0.8 % of the angular velocity at an impact. One a thousand
    times as stiff differs from the face by what adaptive steps leave (1e-3 of a restitution), and
    the mesh of a held floor by round-off.
    """
    block: dict[str, Any] = {"width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0}
    block |= {"young": 5e10, "tilt_deg": 3.0, "cells": [4, 10]}
    plate: dict[str, Any] = PLATE | {"width": 1.0, "height": 0.3, "cells": [16, 4]}

    def second_impact(**more: Any) -> float:
        tables = {
            "block": [SQUAT | block],
            "foundation": plate | more,
            "contact": {"friction": 0.7},
            "time": {"end": 0.6},
        }
        impacts = run(parse_scene(tables)).summary["blocks"]["block"]["impacts"]
        return float(impacts[1]["time_s"])

    face = second_impact(support="fixed")
    assert second_impact(support="fixed", meshed=True) == pytest.approx(face, abs=1e-9)
    soft, stiff = (abs(second_impact(support="bottom", young=E) - face) for E in (3e10, 3e13))
    assert 1e-3 < soft / face < 1e-2
    assert stiff / face < 2e-4


@pytest.mark.parametrize("degree", [1, 2])
def test_a_plate_under_a_block_rests(degree: int) -> None:
    """The static start is in equilibrium: nothing moves for 0.2 s."""
    result = run(scene(PLATE | {"degree": degree}, 0.2, 2e-3))
    history = result.history
    for column in ("slip_m", "angle_rad", "centre_x_m", "centre_y_m"):
        assert np.ptp(history[f"block.{column}"]) < 1e-9
    assert history["block.normal_force_N"] == pytest.approx(600 * G, rel=1e-6)
    sag = history["block.centre_y_m"][0] - 0.2
    # Of a column as wide as the block, between plane stress and plane strain, bulging or not.
    bulk = 600 * G / 0.6 * (0.2 + 0.4 / 2) / 3e10
    assert -1.1 * bulk < sag < -0.5 * bulk


@pytest.mark.parametrize("foundation", [{"kind": "rigid"}, PLATE], ids=["ground", "plate"])
def test_it_flies_and_lands(foundation: dict[str, Any]) -> None:
    """The ground falls away with up to 1.5 g: free flight against its equation, then rest.

    The nodes of the block stand on those of the plate, where facets meet.
    """
    vertical = {"kind": "half_sine", "amplitude_g": -1.5, "duration": 0.3}
    result = run(scene(foundation, 0.6, 1e-3, motion={"kind": "none", "vertical": vertical}))
    assert result.summary["cost"]["rejected_steps"] == 0
    history = result.history
    time, height = history["time_s"], history["block.centre_y_m"] - 0.2
    pulse = math.pi / 0.3
    begin = math.asin(1 / 1.5) / pulse

    def rate(when: float, y: Any) -> tuple[float, float]:
        pull = 1.5 * G * math.sin(pulse * when) if when < 0.3 else 0.0
        return y[1], pull - G

    def ground(when: float, y: Any) -> float:
        return float(y[0]) if when > begin + 0.05 else 1.0

    ground.terminal = True  # type: ignore[attr-defined]
    options = {"events": ground, "max_step": 1e-3, "rtol": 1e-9, "atol": 1e-12}
    flight = solve_ivp(rate, (begin, 0.6), (0.0, 0.0), dense_output=True, **options)
    landing = float(flight.t_events[0][0])
    flying = (time > begin + 5e-3) & (time < landing - 5e-3)
    assert flying.sum() > 200
    exact = flight.sol(time[flying])[0]
    np.testing.assert_allclose(height[flying], exact, atol=1e-2 * exact.max())
    assert np.all(history["block.normal_force_N"][flying] == 0.0)
    assert np.all(history["contact_points_closed"][flying] == 0)
    # It is elastic, and bounces, lower than it fell.
    assert height[time > landing + 5e-3].max() < 0.8 * exact.max()
    assert height.min() > -1e-3


def portal_period(spec: dict[str, Any]) -> float:
    """Of a portal with rigid joints: its columns bend, its deck moves along x; rho of Chopra.

    The beam theory's columns end at the underside of the deck. A third of their mass moves along
    (13/35, no rotation at the top).
    """
    E, width, height = spec["young"], spec["column"]["width"], spec["storey"]
    deck, bay = spec["deck"], spec["deck"]["width"] - width
    column, beam = width**3 / 12, deck["height"] ** 3 / 12
    rho = (beam / bay) / (2 * column / height)
    stiffness = 24 * E * column / height**3 * (12 * rho + 1) / (12 * rho + 4)
    mass = deck["width"] * deck["height"] + 2 * 13 / 35 * width * height
    return 2 * math.pi * math.sqrt(spec["density"] * mass / stiffness)


def test_natural_period_of_a_portal() -> None:
    """Slender columns against beam theory; `rockslip check` prints it."""
    run = scene(FRAME, 1.0, 1e-3, plane="stress")
    period = natural_period(run)
    assert period == pytest.approx(portal_period(FRAME), rel=0.02)
    assert f"{period:.4g} s (empty, of the mesh)" in describe(run)


def test_natural_period_of_a_plate_on_rollers() -> None:
    """That of its spring, as stiff as it is."""
    rollers = PLATE | {"support": "rollers", "period": 0.5}
    assert natural_period(scene(rollers, 1.0, 1e-3)) == pytest.approx(0.5, rel=1e-3)


def test_no_mesh_no_mode() -> None:
    with pytest.raises(ValueError, match="no mesh"):
        natural_period(scene({"kind": "rigid"}, 1.0, 1e-3))


def test_points_beyond_the_edge_touch_nothing_wherever_the_iteration_takes_them() -> None:
    """Their feet go to and fro with the face, the farther out the more: their gaps mean nothing."""
    overhanging = scene(PLATE, 0.1, 1e-3, block={"offset": 0.75})
    assembly = build(overhanging)
    state, _ = initial_state(overhanging, assembly)
    state, _ = assembly.stepper.advance(state, 1e-3)
    problem = assembly.stepper._solve._solver._problem
    pairs = zip(assembly.stepper.links, state.contacts, strict=True)
    off = np.concatenate(
        [link.interface.carrier.beyond_edge(memory.kinematics) for link, memory in pairs]
    )
    assert off.any() and not off.all()
    y = problem._positions()
    y[:, 0] = -1e-6
    operator, change = problem._settled(y)
    assert change is not None and problem.contact.force[:, 0].any()
    assert not off[operator.near.number].any() and not problem.contact.force[off].any()


@pytest.mark.slow
@pytest.mark.parametrize(("stiffness", "scatter"), [(0.0, (0.1, 3.0)), (1e-4, (0.0, 0.02))])
def test_what_impacts_on_a_plate_keep_scatters_unless_it_is_damped(
    stiffness: float, scatter: tuple[float, float]
) -> None:
    """A block of H/B 3 on a plate as stiff as itself, on which it hops: `docs/validation.md`."""
    stone = {"density": 2500.0, "young": 3e10, "poisson": 0.2}
    tables = {
        "block": [stone | {"width": 0.3, "height": 0.9, "thickness": 0.5, "cells": [4, 8],
                           "tilt_deg": 2.0}],
        "foundation": stone | {"kind": "elastic", "support": "bottom", "width": 1.5,
                               "height": 0.3, "cells": [20, 3],
                               "damping": {"stiffness": stiffness}},
        "time": {"end": 0.75},
    }  # fmt: skip
    impacts = simulate(parse_scene(tables)).summary["blocks"]["block"]["impacts"]
    kept = [impact.get("ratio") or impact["restitution"] for impact in impacts[:4]]
    assert scatter[0] < max(kept) - min(kept) < scatter[1]
    told = [impact.get("reason") for impact in impacts[1:4]]
    assert told == [None] * 3 if stiffness else HOPS in told
    assert stiffness == 0.0 or kept == pytest.approx([0.825] * 4, abs=0.01)
