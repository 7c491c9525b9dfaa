"""Stacks of elastic and rigid blocks: energy, momentum of every block in every step, friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rockslip import Scene, parse_scene, simulate
from solver.build.assembly import Assembly, build, initial_state
from solver.contact.memory import Memory
from solver.reference.sliding import sliding
from solver.stepping.convergence import ResidualTolerance
from solver.stepping.nonlinear import NonlinearSolver
from solver.stepping.state import State

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


class Balance:
    """Momentum of each block against the forces that contact puts on it, from the scheme alone.

    The displacement of a block in a step obeys m (du - dt v_n) = dt^2/2 (f + c_{n+1}), with f its
    mean weight in the accelerated ground.
    """

    def __init__(self, assembly: Assembly):
        self.stepper = assembly.stepper
        self.system = self.stepper.system

    def momentum(self, vector: Array, body: int) -> Array:
        """Of a displacement or velocity, times mass."""
        own = self.system.slices[body]
        return self.system.directional_mass[:, own] @ vector[own]

    def needed(self, old: State, new: State, dt: float) -> list[Array]:
        """Contact force that each block needs to have moved as it did."""
        base = self.stepper.mean_base(old.time, dt)
        forces = []
        for k, body in enumerate(self.system.bodies):
            weight = body.mass * (self.stepper.gravity - base)
            moved = self.momentum(new.u - old.u - dt * old.v, k)
            forces.append(2 * moved / dt**2 - weight)
        return forces

    def given(self, started: Sequence[Memory], new: State) -> list[Array]:
        """What the interfaces put on each block."""
        forces = [np.zeros(2) for _ in self.system.bodies]
        for link, before, after in zip(self.stepper.links, started, new.contacts, strict=True):
            vectors, _ = link.interface.point_forces(
                before.kinematics, after.kinematics, after.force
            )
            total = vectors.sum(axis=0)
            if link.body is not None:
                forces[link.body] += total
            if link.carrier is not None:
                forces[link.carrier] -= total
        return forces


def imbalance(run: Scene) -> float:
    """Largest difference between the forces that blocks get and need, over their weight."""
    assembly = build(run)
    state, _ = initial_state(run, assembly)
    balance, dt, largest = Balance(assembly), run.time.step, 0.0
    for _ in range(100):
        started = assembly.stepper.prepare(state, dt).contacts
        new, _ = assembly.stepper.advance(state, dt)
        given, needed = balance.given(started, new), balance.needed(state, new, dt)
        for body, has, needs in zip(balance.system.bodies, given, needed, strict=True):
            largest = max(largest, float(np.abs(has - needs).max()) / (body.mass * G))
        state = new
    return largest


@pytest.mark.parametrize("models", [*PAIRS, TRIPLES[0]], ids="-".join)
@pytest.mark.parametrize("friction", [0.25, 0.7])
def test_contact_forces_balance_momentum(models: tuple[str, ...], friction: float) -> None:
    """Block by block and step by step, velocity solves between them, to 1e-9 of its weight.

    The difference is the resultant of the residual that SNES leaves, which is judged apart.
    """
    run = stack(models, f"contact.friction={friction}", slender=friction > 0.5)
    assert imbalance(run) < 1e-9


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
        """What is solved, and how well."""
        seen.append(tolerance)
        return solve(self, problem, unknowns, tolerance)

    monkeypatch.setattr(NonlinearSolver, "solve", watched)
    assembly.stepper.advance(state, run.time.step)
    (tolerance,) = seen
    assert 2e-10 < tolerance.acceleration / G < 1e-9


def test_each_pair_has_its_own_friction() -> None:
    """The lower block holds on; the upper slides on it as on the ground: mu 0.1 on 0.8."""
    run = stack(("elastic", "elastic"), "lower.friction=0.8", "upper.friction=0.1")
    result = simulate(run)
    history = result.history

    def ground(time: float) -> float:
        return 0.6 * G * math.sin(2 * math.pi * time / 0.5)

    exact = sliding(acceleration=ground, friction=0.1, gravity=G, end=0.4, step=2e-3)
    assert np.abs(history["lower.slip_m"]).max() < 1e-4
    np.testing.assert_allclose(
        history["upper.slip_m"], exact.slip, atol=1e-2 * np.abs(exact.slip).max()
    )
    weight = DENSITY * 0.83 * 0.83 * 0.7 * G
    assert np.abs(history["upper.friction_force_N"]).max() == pytest.approx(0.1 * weight, rel=0.05)


def test_a_glued_elastic_stack_stands_as_one() -> None:
    """mu 100 and a motion too weak to rock: the ground carries both, and accelerates both."""
    run = stack(("elastic", "elastic"), "contact.friction=100.0", "motion.amplitude_g=0.1")
    history = simulate(run).history
    for name in ("lower", "upper"):
        assert np.abs(history[f"{name}.slip_m"]).max() < 1e-6
        assert np.abs(history[f"{name}.angle_rad"]).max() < 1e-5
    mass = DENSITY * 0.7 * (1.0 + 0.83**2)
    acceleration = history["base.acceleration_m_s2"]
    push = history["lower.friction_force_N"][50:]
    assert np.abs(push - mass * acceleration[50:]).max() < 0.05 * mass * 0.1 * G
    assert history["lower.normal_force_N"][50:] == pytest.approx(mass * G, rel=1e-2)


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
