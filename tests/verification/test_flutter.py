"""Steady sliding of elastic blocks: the linearisation by modes, and the damping that holds it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la

from geometry.mesh import block_mesh
from rockslip import Scene, parse_scene, simulate
from solver.bodies.flutter import SlidingModes
from solver.bodies.modes import compressed_rows
from solver.build.meshed_body import meshed_body, modes_of_sliding
from solver.results.flutter import flutter
from solver.scene.damping import DampingSpec

pytestmark = pytest.mark.serial

SQUAT = {"width": 1.0, "height": 0.5, "mass": 1000.0, "young": 5e10, "poisson": 0.2}


def scene(friction: Any, *, cells: tuple[int, ...] = (6, 4), **tables: Any) -> Scene:
    """A squat block on the ground."""
    block = {**SQUAT, "cells": list(cells), "friction": friction, **tables.pop("block", {})}
    more = {"time": {"end": 1.0}, "output": {"fields": "none"}, **tables}
    return parse_scene({"block": [block], **more})


def modes(asked: Scene) -> SlidingModes:
    return modes_of_sliding(asked, asked.blocks[0])


def rates(asked: Scene, friction: float, damping: DampingSpec) -> np.ndarray[Any, Any]:
    """Rates of the whole mesh, by M, C and K with the friction of the base in their rows."""
    block = asked.blocks[0]
    made = block_mesh(block.shape, cells=block.cells)
    body = meshed_body(
        asked,
        "block",
        made,
        material=block.material(asked.material_plane),
        thickness=block.thickness,
        degree=1,
        damping=None,
    )
    K, M = (compressed_rows(m).toarray() for m in (body.stiffness_matrix, body.mass_matrix))
    base = np.flatnonzero(np.isclose(body.nodes[:, 1], 0.0))
    free = np.setdiff1d(np.arange(body.size), 2 * base + 1)
    coupled = []
    for matrix in (K, M):
        part = matrix[:, free].copy()
        part[2 * base] += friction * part[2 * base + 1]
        coupled.append(part[free])
    K, M = coupled
    C = damping.mass * M + damping.stiffness * K
    zero, one = np.zeros_like(K), np.eye(len(K))
    return la.eigvals(np.block([[zero, one], [-la.solve(M, K), -la.solve(M, C)]]))


@pytest.mark.parametrize(
    ("friction", "damping"), [(0.3, {"stiffness": 2e-6}), (0.6, {"stiffness": 1e-5, "mass": 20.0})]
)
def test_the_modes_have_the_rates_of_the_mesh(friction: float, damping: dict[str, float]) -> None:
    own = DampingSpec(**damping)
    asked = scene(friction)
    found = modes(asked).flutter(friction, own)
    exact = rates(asked, friction, own)
    most = exact[np.abs(exact.imag) > 1.0].real.max()
    assert found.growth == pytest.approx(most, rel=0.01, abs=5.0)  # 40 of the 65 modes
    nearest = exact[np.abs(exact.real - most) < 1e-6]
    assert found.frequency == pytest.approx(abs(nearest.imag).max(), rel=2e-3)


def test_the_block_of_the_issue_flutters_as_an_independent_model_says() -> None:
    """1030 and 570 1/s at 2.2 kHz with beta_R 2.0e-6; 770 and 260 with 4.7e-6 and 1e-5."""
    known = modes(scene(0.3))
    expected = {(0.3, 2e-6): 1032.6, (0.2, 2e-6): 573.5, (0.3, 4.7e-6): 771.4, (0.3, 1e-5): 260.5}
    for (friction, beta), growth in expected.items():
        found = known.flutter(friction, DampingSpec(stiffness=beta))
        assert found.growth == pytest.approx(growth, abs=6.0)
        assert found.frequency / (2 * math.pi) == pytest.approx(2215, rel=0.01)
    assert known.flutter(0.1, DampingSpec(stiffness=2e-6)).growth < 0


def test_the_damping_that_holds_it_and_the_onset_are_where_growth_changes_sign() -> None:
    known = modes(scene(0.3))
    least = known.flutter(0.3, DampingSpec()).damping
    assert least == pytest.approx(1.27e-5, rel=0.02)
    assert known.flutter(0.3, DampingSpec(stiffness=0.999 * least)).growth > 0
    assert known.flutter(0.3, DampingSpec(stiffness=1.001 * least)).growth < 0
    onset = known.onset(1.0, DampingSpec(stiffness=least))
    assert onset == pytest.approx(0.3, abs=1e-4)
    assert known.onset(0.29, DampingSpec(stiffness=least)) is None


@pytest.mark.parametrize("slenderness", [0.25, 0.5, 1.0, 2.0])
@pytest.mark.parametrize(("plane", "poisson"), [("strain", 0.4), ("stress", 0.0)])
def test_default_damping_holds_steady_sliding(
    slenderness: float, poisson: float, plane: str
) -> None:
    """Up to the friction that lets a block rock first, and to 1."""
    block = {"height": slenderness, "poisson": poisson}
    cells = (8, max(3, round(8 * slenderness)))
    for friction in (0.2, 0.4, 0.6, 0.8, 1.0):
        if friction * slenderness < 1:
            asked = scene(friction, cells=cells, block=block, plane=plane)
            damping = asked.damping_of(asked.blocks[0])
            assert damping is not None
            assert modes(asked).flutter(friction, damping).growth < 0, friction


@pytest.mark.parametrize(("thickness", "cells"), [(0.4, (6, 3, 3)), (3.0, (3, 8, 3))])
def test_it_does_in_space(thickness: float, cells: tuple[int, ...]) -> None:
    for friction in (0.3, 0.9):
        asked = scene(friction, cells=cells, block={"thickness": thickness}, dimension=3)
        damping = asked.damping_of(asked.blocks[0])
        assert damping is not None
        assert modes(asked).flutter(friction, damping).growth < 0


@pytest.mark.slow
def test_a_run_tells_of_flutter_at_a_mode() -> None:
    """A squat block on a platform, with falling friction; by default it does not."""
    falling = {"static": 0.6, "dynamic": 0.3, "decay": 20.0}
    tables = {
        "foundation": {
            "kind": "oscillator",
            "mass_ratio": 2.0,
            "period": 0.5,
            "damping_ratio": 0.05,
        },
        "motion": {"kind": "sine", "amplitude_g": 0.45, "period": 0.6, "cycles": 6},
        "time": {"end": 1.15},
    }
    light = scene(falling, damping={"stiffness": 2e-6}, **tables)
    run = simulate(light)
    found = flutter(light, run.history, light.blocks[0])
    assert found is not None
    began, frequency = found
    assert 0.9 < began < 1.1, "the block slides back"
    assert 1400 < frequency < 2250, "the mode that grows, at less while the block lifts off"
    assert any("flutters as it slides" in text for text in run.summary["cautions"])
    quiet = simulate(scene(falling, **tables))
    assert not any("flutter" in text for text in quiet.summary["cautions"])
