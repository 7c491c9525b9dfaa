"""One scene of the stability study run and judged."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, fields
from itertools import product
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from benchmarks.stability.matrix import Place, StabilityCase
from solver.errors import SceneError
from solver.reference.answer import reference_history
from solver.scene import BlockSpec, Scene, parse_scene
from solver.stepping.ledger import BEYOND_LAW
from solver.study.scenes import Tables

if TYPE_CHECKING:
    from solver.run.simulate import Result

LARGEST_GAIN = 1e-5
"""Energy gained, over the scale of `solver.results.energy`."""

LARGEST_LEDGER_ERROR = 1e-8
"""Largest error of the ledger, over the same scale."""

LARGEST_SLIP_ERROR = 0.01
"""Difference of the peak slip from that of the reference, over the latter."""

ROUND_OFF = 1e-14
"""Or over the largest energy in motion: a needle that fell 400 m beside its plate has 1e7 times the
scale, and no more digits than others."""


Word = Literal["holds", "ended", "refused", "failed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict(Place):
    """Verdict on a scene.

    Attributes:
        verdict: It completed and kept its energy, or kept it until it ended where a block was
            compressed beyond its law, or was refused by name, or none of these.
        reason: Why it ended or was refused, or what failed.
        energy_gain: Largest gain over the scale of energy.
        ledger_error: Largest error of the ledger over the same.
        penetration_over_static: Deepest point of any elastic block over weight / (area gamma_h).
        penetration_over_height: Deepest point of any block over its height.
        steps: Steps done.
        rejected_steps: Steps halved.
        iterations_a_step: Iterations of the nonlinear solver.
        rescued: Local contact problems that Newton's method did not settle.
        seconds: Wall time with set-up.
    """

    verdict: Word
    reason: str = ""
    energy_gain: float = math.nan
    ledger_error: float = math.nan
    penetration_over_static: float = math.nan
    penetration_over_height: float = math.nan
    steps: int = 0
    rejected_steps: int = 0
    iterations_a_step: float = math.nan
    rescued: int = 0
    seconds: float = math.nan

    @classmethod
    def of(cls, case: StabilityCase, word: Word, reason: str, **numbers: Any) -> Verdict:
        """The verdict on a scene, with those of the other attributes that are known."""
        place = {field.name: getattr(case, field.name) for field in fields(Place)}
        return cls(**place, verdict=word, reason=reason, **numbers)


def warm_up() -> None:
    """Let the contact law and the steps of rigid blocks be compiled: no scene's time goes there."""
    from mpi4py import MPI

    from solver.run.simulate import simulate

    for dimension, rigid in product((2, 3), (True, False)):
        # It hits the ground: contact at velocity level is among what is compiled.
        velocity = [0.1, *[0.0] * (dimension - 2), -0.1]
        block: Tables = {"width": 1.0, "height": 1.0, "density": 1e3, "velocity": velocity}
        elastic = {"young": 1e9, "poisson": 0.2, "cells": [2] * dimension}
        block |= {"model": "rigid"} if rigid else elastic
        tables = {"dimension": dimension, "block": [block], "time": {"end": 3e-3, "step": 1e-3}}
        simulate(parse_scene(tables), comm=MPI.COMM_SELF)


def judge(case: StabilityCase, limit: float) -> Verdict:
    """Run a scene for no longer than `limit` (s of wall time) and judge it."""
    from mpi4py import MPI

    from solver.run.simulate import simulate

    began = time.perf_counter()
    try:
        scene = parse_scene(case.tables)
        result = simulate(scene, seconds=limit, comm=MPI.COMM_SELF)
    except SceneError as error:
        return Verdict.of(case, "refused", str(error), seconds=time.perf_counter() - began)
    word: Word = "holds"
    reason = trouble(result) or (far_from_reference(case.tables, result) if case.compared else "")
    if reason:
        word = "failed"
    elif ended_early(result):
        word, reason = "ended", result.summary["reason"]
    cost, energy = result.summary["cost"], result.summary["energy"]
    return Verdict.of(
        case,
        word,
        reason,
        energy_gain=energy["largest_gain_fraction"],
        ledger_error=energy["ledger_error_fraction"],
        penetration_over_static=_over_static(scene, result),
        penetration_over_height=_over_height(scene, result),
        steps=cost["steps"],
        rejected_steps=cost["rejected_steps"],
        iterations_a_step=cost["newton_iterations"] / max(1, cost["steps"]),
        rescued=sum(cost["local_problems_rescued"].values()),
        seconds=time.perf_counter() - began,
    )


def ended_early(result: Result) -> bool:
    """True if a run ended where the material model of a body ends, with what it had till then."""
    return BEYOND_LAW in result.summary["reason"]


def trouble(result: Result) -> str:
    """Conditions that a run violated, in words; empty where it held all of them to its end."""
    if result.status != "completed" and not ended_early(result):
        return f"{result.status}: {result.summary['reason']}"
    names = [name for name in result.history.columns if np.isnan(result.history[name]).any()]
    if names:
        return f"not a number: {', '.join(names)}"
    energy = result.summary["energy"]
    gain, error = energy["largest_gain_fraction"], energy["ledger_error_fraction"]
    if gain >= LARGEST_GAIN:
        return f"energy gain {gain:.1e}"
    moving, scale = float(result.history["energy.kinetic_J"].max()), energy["scale_J"]
    if error * scale >= max(LARGEST_LEDGER_ERROR * scale, ROUND_OFF * moving) > 0:
        return f"ledger error {error:.1e}"
    return ""


def far_from_reference(tables: Tables, result: Result) -> str:
    """Peak slip of a run and of the reference in words; empty where they agree."""
    plane = parse_scene({**tables, "dimension": 2})  # the reference knows no other
    exact, found = (
        float(np.max(np.abs(history[f"{plane.blocks[0].name}.slip_m"])))
        for history in (reference_history(plane), result.history)
    )
    if abs(found - exact) <= LARGEST_SLIP_ERROR * exact:
        return ""
    return f"slip {found:.4g} m for {exact:.4g} m"


def _over_height(scene: Scene, result: Result) -> float:
    """The deepest penetration of any block over its height."""
    return max(_deepest(block, result) / block.height for block in scene.blocks)


def _over_static(scene: Scene, result: Result) -> float:
    """The deepest penetration of any elastic block over that of a penalty method under its weight.

    The stiffness of the contact is gamma (lambda + 2 mu) degree^2 / h over the block's bottom.
    """
    ratios = [
        _deepest(block, result) / _static(block, scene)
        for block in scene.blocks
        if block.model == "elastic" and scene.gravity > 0
    ]
    return max(ratios, default=math.nan)


def _deepest(block: BlockSpec, result: Result) -> float:
    """The deepest penetration of a block, m."""
    return float(np.max(result.history[f"{block.name}.penetration_m"]))


def _static(block: BlockSpec, scene: Scene) -> float:
    """Weight of a block over the stiffness of the contact at its bottom, m."""
    young, poisson = block.elasticity
    modulus = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
    edge = block.height / block.cells[-1]
    stiffness = scene.contact.gamma * modulus * block.degree**2 / edge
    return block.shape.weight(scene.gravity) / (block.width * block.thickness * stiffness)
