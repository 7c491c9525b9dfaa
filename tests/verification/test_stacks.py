"""Stacks of elastic and rigid blocks: energy, momentum of every block in every step, friction."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rockslip import Scene, parse_scene, simulate
from solver.build.assembly import build, initial_state
from solver.stepping.convergence import ResidualTolerance
from solver.stepping.nonlinear import NonlinearSolver
from tests.momentum import imbalance

Array = NDArray[np.float64]

G = 9.81
DENSITY = 2400.0


def block(name: str, model: str, on: str, width: float, height: float) -> dict[str, Any]:
    """A block of a stack."""
    made = {
        "name": name,
        "on": on,
        "width": width,
        "height": height,
        "thickness": 1.0,
        "density": DENSITY,
        "model": model,
    }
    return made if model == "rigid" else made | {"young": 3e10, "poisson": 0.2, "cells": [4, 3]}


NAMES = ("lower", "middle", "upper")


def stack(models: tuple[str, ...], *overrides: str, slender: bool = False, **more: Any) -> Scene:
    """Blocks on one another, each a little narrower, under a harmonic motion of the ground."""
    names = NAMES[: len(models)] if len(models) == 3 else ("lower", "upper")
    blocks = []
    for k, (name, model) in enumerate(zip(names, models, strict=True)):
        width = 1.0 - 0.17 * k
        height = (2.2 if slender else 0.7) * width
        on = "foundation" if k == 0 else names[k - 1]
        blocks.append(block(name, model, on, width, height))
    tables = {
        "block": blocks,
        "contact": {"friction": 0.25},
        "motion": {"kind": "sine", "amplitude_g": 0.6, "period": 0.5},
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.4, "step": 2e-3},
    }
    return parse_scene(tables | more, overrides=overrides)


PAIRS = [("elastic", "elastic"), ("rigid", "elastic"), ("elastic", "rigid")]
TRIPLES = [("elastic", "elastic", "elastic"), ("elastic", "rigid", "elastic")]


@pytest.mark.parametrize("models", [*PAIRS, *TRIPLES], ids="-".join)
@pytest.mark.parametrize("slender", [False, True], ids=["sliding", "rocking"])
def test_stacks_make_no_energy(models: tuple[str, ...], slender: bool) -> None:
    """Under harmonic motion; slender ones rock on one another."""
    run = stack(models, "contact.friction=0.7", slender=True) if slender else stack(models)
    result = simulate(run)
    energy = result.summary["energy"]
    assert result.status == "completed"
    assert energy["largest_gain_fraction"] < 1e-5
    assert energy["ledger_error_fraction"] < 1e-8
    if slender:
        assert np.abs(result.history["lower.angle_rad"]).max() > 2e-3
    else:
        assert np.abs(result.history["lower.slip_m"]).max() > 0.01


@pytest.mark.parametrize("models", [*PAIRS, TRIPLES[0]], ids="-".join)
@pytest.mark.parametrize("friction", [0.25, 0.7])
def test_contact_forces_balance_momentum(models: tuple[str, ...], friction: float) -> None:
    """Block by block and step by step, velocity solves between them, to 1e-9 of its weight.

    The difference is the resultant of the residual that SNES leaves, which is judged apart.
    """
    run = stack(models, f"contact.friction={friction}", slender=friction > 0.5)
    assert imbalance(run, 100) < 1e-9


@pytest.mark.parametrize("models", PAIRS, ids="-".join)
def test_momentum_is_judged_alike_beside_a_fine_mesh(
    models: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By an acceleration of some 5e-10 of gravity, on however many unknowns loads are spread."""
    fine = NAMES[0] if models[0] == "elastic" else NAMES[2]
    run = stack(models, f"{fine}.cells=[40, 30]")
    assembly = build(run)
    state, _ = initial_state(run, assembly)
    seen: list[ResidualTolerance] = []
    solve = NonlinearSolver.solve

    def watched(self: Any, problem: Any, unknowns: Array, tolerance: ResidualTolerance) -> Any:
        """Solve, and record the tolerance."""
        seen.append(tolerance)
        return solve(self, problem, unknowns, tolerance)

    monkeypatch.setattr(NonlinearSolver, "solve", watched)
    assembly.stepper.advance(state, run.time.step)
    (tolerance,) = seen
    assert 2e-10 < tolerance.acceleration / G < 1e-9


def test_a_heavy_rigid_block_on_a_light_stiff_one() -> None:
    """The light one moves by millions of times what it yields: corrections do not creep."""
    light = block("light", "elastic", "foundation", 0.5, 2.5)
    light |= {"density": 1.0, "young": 2e12, "poisson": 0.0, "cells": [2, 1]}
    heavy = block("heavy", "rigid", "light", 0.4, 1.0) | {"density": 2e4}
    tables = {
        "block": [light, heavy],
        "contact": {"friction": 1.5},
        "motion": {"kind": "sine", "amplitude_g": 0.1, "period": 0.5},
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.32, "step": 0.016},
    }
    result = simulate(parse_scene(tables))
    assert result.status == "completed"
    cost = result.summary["cost"]
    assert cost["newton_iterations"] < 4 * cost["steps"]
    assert result.summary["energy"]["largest_gain_fraction"] < 1e-9


def test_rigid_blocks_that_stick_to_each_other_on_a_plate() -> None:
    """Large ones in short steps: round-off of where their corners are tells of no force."""

    def rigid(name: str, on: str, width: float, density: float) -> dict[str, Any]:
        return block(name, "rigid", on, width, 3.0) | {"density": density}

    tables = {
        "block": [
            rigid("lower", "foundation", 30.0, 2500.0),
            rigid("upper", "lower", 25.0, 3700.0),
        ],
        "contact": {"friction": 1000.0},
        "foundation": {
            **{"kind": "elastic", "width": 100.0, "height": 17.0, "density": 700.0},
            **{"young": 1.4e8, "poisson": 0.2, "cells": [3, 2], "support": "rollers"},
            **{"period": 1.2, "damping_ratio": 0.05},
        },
        "motion": {
            **{"kind": "ricker", "amplitude_g": 6.0, "duration": 0.18},
            "vertical": {"kind": "half_sine", "amplitude_g": 2.0, "duration": 0.14},
        },
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.1, "step": 6e-4},
    }
    result = simulate(parse_scene(tables))
    assert result.status == "completed"
    cost, energy = result.summary["cost"], result.summary["energy"]
    assert cost["rejected_steps"] == 0 and cost["newton_iterations"] < 4 * cost["steps"]
    assert energy["largest_gain_fraction"] < 1e-8 and energy["ledger_error_fraction"] < 1e-11


@pytest.mark.parametrize("model", ["elastic", "rigid"])
def test_edges_of_what_carries_a_block_count_among_its_forces(model: str) -> None:
    """A wide block on a narrow one, whose edges press on its bottom: its weight is carried."""
    lower, upper = (
        block("lower", "elastic", "foundation", 0.4, 0.4),
        block("upper", model, "lower", 1.0, 0.3),
    )
    if model == "elastic":
        upper["cells"] = [1, 2]  # no node of its bottom stands on the lower one
    scene = parse_scene({
        "block": [lower, upper],
        "time": {"end": 0.01, "step": 1e-3, "initial": "static"},
    })  # fmt: skip
    history = simulate(scene).history
    weight = DENSITY * 1.0 * 0.3 * G
    np.testing.assert_allclose(history["upper.normal_force_N"], weight, rtol=1e-3)
