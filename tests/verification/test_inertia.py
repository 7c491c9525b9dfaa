"""Lambda by the block that slides: against the equations, limits, other programs, the engines."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rockslip import load_scene
from solver.excitation.sampled import SampledMotion
from solver.excitation.synthetic import synthetic_motion, table1_suite
from solver.reference.answer import reference_history
from solver.reference.sliding import Resistance, sliding
from solver.scene import FrictionSpec
from solver.scene.foundation import Platform
from solver.study.inertia.cases import SlidingCase, block_cases
from solver.study.inertia.cells import Cell, Structure, cells_of, chosen, ladder
from solver.study.inertia.numbers import Finding, Line
from solver.study.inertia.sliding import STEPS, fixed_drifts, jumps, peaks
from solver.study.suite.cases import scene_of
from solver.study.suite.motions import SuiteMotion, find_motions

pytestmark = pytest.mark.serial

SCENE = Path(__file__).parents[2] / "demos" / "suite" / "scene.toml"

NUMBERS = {
    0.25: (-0.010, 0.193, 0.421, 0.592, 0.836),
    0.5: (-0.013, 0.265, 0.683, 0.881, 0.997),
    0.75: (0.100, 0.485, 0.723, 0.947, 1.0),
    1.0: (0.142, 0.461, 0.859, None, None),
    1.5: (0.610, 0.818, 0.966, 1.0, 1.0),
    2.0: (0.595, 0.974, 1.0, 1.0, 1.0),
}
"""Lambda at mu 0.05, 0.1, 0.2, 0.3, 0.5 for T, s: by an implicit slider with steps of 0.5 ms.

Of 30 motions, mass ratio 2 and xi 0.05; None where roots are several.
"""

FRICTIONS = (0.05, 0.1, 0.2, 0.3, 0.5)


def structure(period: float = 0.5, mass_ratio: float = 2.0, *, unit_pga: bool = False) -> Structure:
    return Structure(
        mass_ratio=mass_ratio,
        period=period,
        damping_ratio=0.05,
        gravity=9.81,
        dynamic=1.0,
        unit_pga=unit_pga,
    )


def line_of(frictions: Sequence[float], motions: Sequence[SuiteMotion], of: Structure) -> Line:
    """A structure with its ladder of friction under some motions."""
    steps = tuple(ladder(frictions))
    case = SlidingCase(
        structure=of,
        frictions=steps,
        motions=tuple(motions),
        tables=load_scene(SCENE).to_dict(),
        folder=SCENE.parent,
    )
    return Line.of(of, steps, [case.run()])


def findings(
    frictions: Sequence[float], motions: Sequence[SuiteMotion], of: Structure | None = None
) -> list[Finding]:
    """Findings of the sliding block for each friction."""
    own = of or structure()
    line = line_of(frictions, motions, own)
    cells = (Cell(values=(), structure=own, friction=mu, aspect=None) for mu in frictions)
    return [line.finding(cell) for cell in cells]


def suite(count: int, scale: float = 1.0) -> list[SuiteMotion]:
    """The synthetic motions times a factor."""
    motions, _ = find_motions([], None, count=count, seed=1)
    return [replace(m, table=dict(m.table) | {"scale": scale}) for m in motions]


@pytest.mark.parametrize("period", [0.1, 0.5, 2.0])
def test_peaks_are_those_of_the_equations(period: float) -> None:
    """Against matrix exponentials; of first order where friction falls as sliding begins."""
    time = 0.02 * np.arange(150)
    waves = np.sin(11.0 * time) + 0.6 * np.sin(29.0 * time)
    motion = SampledMotion(time=time, value=4.0 * np.sin(time) ** 2 * waves)
    platform = Platform.on_spring(500.0, period=period, stiffness=None, damping_ratio=0.05)
    laws = [(0.05, 0.05), (0.15, 0.08), (0.2, 0.2), (1e6, 1e6)]
    holds, slides = 9.81 * np.array(laws).T
    step = period / STEPS
    change = jumps(motion, 1.0, step)
    found = peaks([change], step, platform, np.full(len(laws), 1e3), holds, slides)
    (fixed,) = fixed_drifts(change, step, platform, np.array([1e3]))
    assert fixed == pytest.approx(found[0][0, -1], rel=1e-9)  # which never slides
    for (static, dynamic), drift, shear in zip(laws, *(row[0] for row in found), strict=True):
        exact = sliding(
            platform=platform,
            mass=1e3,
            friction=Resistance(law=FrictionSpec(static=static, dynamic=dynamic)),
            gravity=9.81,
            acceleration=motion,
            end=motion.stop,
            step=period / 200,
        )
        force = platform.stiffness * exact.drift + platform.damping * exact.drift_velocity
        near = 1e-3 if static == dynamic else 5e-3
        assert drift == pytest.approx(np.abs(exact.drift).max(), rel=near)
        assert shear == pytest.approx(np.abs(force).max(), rel=near)


def test_resonance_of_a_harmonic_load() -> None:
    """The steady drift under a sine at the natural frequency is a / (2 xi w^2), w^2 = k/(m + M)."""
    mass, w, time = 3.0, 4 * math.pi, np.arange(0, 40, 1e-3)
    motion = SampledMotion(time=time, value=np.sin(w * time), step=1e-3)
    platform = Platform.on_spring(1.0 + mass, period=0.5, stiffness=None, damping_ratio=0.05)
    platform = Platform(1.0, platform.stiffness, platform.damping)
    step = 0.5 / STEPS
    drifts = fixed_drifts(jumps(motion, 1.0, step), step, platform, np.array([mass, -2.0]))
    assert drifts[0] == pytest.approx(1 / (2 * 0.05 * w**2), rel=5e-4)
    assert math.isnan(drifts[1])


@pytest.mark.parametrize(
    "period", [0.5, *(pytest.param(t, marks=pytest.mark.slow) for t in NUMBERS if t != 0.5)]
)
def test_known_numbers(period: float) -> None:
    found = findings(FRICTIONS, suite(30), structure(period))
    for finding, value in zip(found, NUMBERS[period], strict=True):
        if value is not None:
            assert finding.arithmetic.value == pytest.approx(value, abs=0.01)
    if period == 0.5:
        assert found[1].geometric.value == pytest.approx(0.472, abs=0.01)
    if period == 1.0:  # hardly anything slides; 1.000 is the root that leads on from there
        assert found[3].arithmetic.roots == pytest.approx((0.948, 1.001, 1.026), abs=0.005)
        assert found[3].arithmetic.value == pytest.approx(1.0, abs=0.002)


@pytest.mark.slow
def test_without_slip_everything_counts_and_without_friction_nothing() -> None:
    stuck, free = findings([1e3, 1e-5], suite(6))
    assert stuck.arithmetic.value == pytest.approx(1.0, abs=0.002)
    assert stuck.means["drift_over_fixed"] == pytest.approx(1.0, abs=1e-12)
    assert stuck.means["base_shear_over_fixed"] == pytest.approx(1.0, abs=1e-12)
    assert free.arithmetic.value == pytest.approx(0.0, abs=0.005)
    assert free.means["drift_over_bare"] == pytest.approx(1.0, abs=1e-3)


def test_a_light_load_says_nothing() -> None:
    for finding in findings([0.05, 0.2], suite(6), structure(mass_ratio=1e-3)):
        assert finding.means["drift_over_bare"] == pytest.approx(1.0, abs=2e-3)
        assert finding.arithmetic.value is None
        assert finding.remark.startswith("not reported")


@pytest.mark.slow
def test_sliding_is_homogeneous() -> None:
    """Friction and motion times a factor: lambda stays, drift grows by it."""
    factor = 1.7
    (one,) = findings([0.1], suite(5))
    (other,) = findings([factor * 0.1], suite(5, factor))
    # The ladders differ between infinity and mu, but not the roots nor where they lead.
    assert other.arithmetic.roots == pytest.approx(one.arithmetic.roots, rel=1e-9)
    assert other.arithmetic.value == pytest.approx(one.arithmetic.value, rel=1e-9)
    drifts = [found.means["mean_peak_drift_m"] for found in (one, other)]
    assert drifts[1] == pytest.approx(factor * drifts[0], rel=1e-9)


@pytest.mark.slow
def test_pga_is_no_axis_of_its_own() -> None:
    """Motions scaled to 1 g with mu are motions of any size with mu g/PGA."""
    (motion,) = suite(1)
    peak = synthetic_motion(table1_suite(1)[0]).peak
    (own,) = findings([0.4 * peak / 9.81], [motion])
    (scaled,) = findings([0.4], [motion], structure(unit_pga=True))
    drifts = [found.means["mean_peak_drift_m"] for found in (own, scaled)]
    assert drifts[1] == pytest.approx(drifts[0] * 9.81 / peak, rel=1e-9)
    assert scaled.arithmetic.roots == pytest.approx(own.arithmetic.roots, rel=1e-9)


@pytest.mark.parametrize(
    ("count", "period", "frictions"),
    [(3, 0.5, "0.1"), pytest.param(10, 0.25, "0.1,0.3", marks=pytest.mark.slow)],
)
def test_rigid_blocks_agree(count: int, period: float, frictions: str) -> None:
    """The engine of rigid blocks in the steps of the map, under the same motions, within 0.003."""
    tables, motions = tomllib.loads(SCENE.read_text()), suite(count)
    assert "step" not in tables["time"]
    cells = cells_of(load_scene(SCENE), chosen([f"period={period}", f"friction={frictions}"]))
    line = line_of([cell.friction for cell in cells], motions, cells[0].structure)
    for cell in cells:
        runs = block_cases(cell, motions, tables, SCENE.parent, "rigid")
        rigid = line.finding_by(cell, "rigid blocks", [case.run()["numbers"] for case in runs])
        slides = line.finding(cell)
        assert rigid.arithmetic.value == pytest.approx(slides.arithmetic.value, abs=0.003)
        assert rigid.means["base_shear_over_fixed"] == pytest.approx(
            slides.means["base_shear_over_fixed"], abs=2e-3
        )


LOCKED = SCENE.parents[1] / "inertia" / "locked_stack.toml"


@pytest.mark.slow
def test_a_locked_stack_rocks_as_its_equations_say() -> None:
    """Four containers in the steps of the map, against the Runge-Kutta integration."""
    tables, scene = tomllib.loads(LOCKED.read_text()), load_scene(LOCKED)
    (cell,) = cells_of(scene, chosen(["period=0.5"]))
    *_, motion = suite(12)
    (run,) = block_cases(cell, [motion], tables, LOCKED.parent, "rigid")
    drift, _, slip, angle, fell = run.run()["numbers"]
    (block,) = scene.blocks
    assert block.width / block.height < cell.friction  # it rocks before it slides
    # A pivot is held to 1e-10 of the size a step.
    assert (slip, fell) == (pytest.approx(0.0, abs=1e-8), 0.0)
    resolved, ground = scene_of(run.case)
    exact = reference_history(resolved, ground=ground)
    assert angle > math.radians(0.5)
    assert angle == pytest.approx(np.abs(exact["block.angle_rad"]).max(), rel=2e-3)
    assert drift == pytest.approx(np.abs(exact["platform.drift_m"]).max(), rel=1e-3)
