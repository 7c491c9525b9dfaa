"""Lambda by the closed form of the sliding block: against other programs, limits, known numbers."""

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
from solver.reference.friction import Resistance, coulomb
from solver.reference.platform_sampled import sampled_sliding_on_platform
from solver.reference.sliding_peaks import Stretches, fixed_drifts, slider_peaks
from solver.scene import FrictionSpec
from solver.scene.foundation import Platform
from solver.study.inertia.cells import Cell, Structure, cells_of, chosen
from solver.study.inertia.findings import Finding, Line
from solver.study.inertia.portion import grid
from solver.study.inertia.runs import block_tasks, closed_tasks, content_of, ladder, run_task
from solver.study.suite.case import scene_of
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


def findings(
    frictions: Sequence[float], motions: Sequence[SuiteMotion], of: Structure | None = None
) -> list[Finding]:
    """What the closed form says for each friction."""
    own = of or structure()
    steps, scene = ladder(frictions), load_scene(SCENE).to_dict()
    tasks = closed_tasks({own: steps}, motions, scene, SCENE.parent, {})
    runs = {key: value for task in tasks for key, value in run_task(task)["runs"].items()}
    line = Line.of(own, steps, [content_of(motion) for motion in motions], runs)
    cells = (Cell(values=(), structure=own, friction=mu, aspect=None) for mu in frictions)
    return [line.finding(cell) for cell in cells]


def suite(count: int, scale: float = 1.0) -> list[SuiteMotion]:
    """The synthetic motions times a factor."""
    motions, _ = find_motions([], None, count=count, seed=1)
    return [replace(m, table=dict(m.table) | {"scale": scale}) for m in motions]


def rough(step: float = 0.02, count: int = 150) -> SampledMotion:
    """Rough samples that begin and end with a jump, none of them at time 0."""
    time = 0.013 + step * np.arange(count)
    noise = np.random.default_rng(4).uniform(-1.0, 1.0, count)
    return SampledMotion(time=time, value=4.0 * np.cos(11.0 * time) + noise)


LAWS = {
    "little": coulomb(0.05),
    "some": coulomb(0.2),
    "falling": Resistance(law=FrictionSpec(static=0.15, dynamic=0.08)),
    "cohesion": Resistance(law=FrictionSpec(static=0.1, cohesion=1.0), cohesion=0.5),
    "nothing": coulomb(0.0),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("period", [0.1, 0.5, 2.0])
def test_peaks_are_those_of_the_history(law: str, period: float) -> None:
    """Against the closed forms that keep the history, at its output times."""
    platform = Platform.on_spring(500.0, period=period, stiffness=None, damping_ratio=0.05)
    motion = rough()
    found = slider_peaks(Stretches.of(motion), platform, 1000.0, LAWS[law], 9.81)
    other = sampled_sliding_on_platform(
        platform=platform,
        mass=1000.0,
        friction=LAWS[law],
        gravity=9.81,
        motion=motion,
        end=motion.stop,
        step=2e-4,
    )
    shear = platform.stiffness * other.drift + platform.damping * other.drift_velocity
    near = pytest.approx
    assert found.drift == near(np.abs(other.drift).max(), rel=2e-5)
    assert found.drift >= np.abs(other.drift).max() * (1 - 1e-12)
    assert found.shear == near(np.abs(shear).max(), rel=2e-5)
    if not LAWS[law].none:  # slips end where they turn round, but for those without friction
        assert found.slip == near(np.abs(other.slip).max(), rel=2e-5)


def test_a_fixed_mass_is_a_block_that_never_slides() -> None:
    platform = Platform.on_spring(500.0, period=0.5, stiffness=None, damping_ratio=0.05)
    stretches = Stretches.of(rough())
    drifts = fixed_drifts(stretches, platform, np.array([-500.0, -100.0, 0.0, 1000.0]))
    assert math.isnan(drifts[0])
    for mass, drift in ((0.0, drifts[2]), (1000.0, drifts[3])):
        peaks = slider_peaks(stretches, platform, mass, coulomb(1e6), 9.81)
        assert peaks.drift == pytest.approx(drift, rel=1e-12)
    lighter = Platform(400.0, platform.stiffness, platform.damping)
    assert fixed_drifts(stretches, lighter, np.zeros(1))[0] == pytest.approx(drifts[1], rel=1e-12)


def test_resonance_of_a_harmonic_load() -> None:
    """The steady drift under a sine at the natural frequency is a / (2 xi w^2)."""
    w, time = 4 * math.pi, np.arange(0, 40, 1e-3)
    motion = SampledMotion(time=time, value=np.sin(w * time), step=1e-3)
    platform = Platform.on_spring(1.0, period=0.5, stiffness=None, damping_ratio=0.05)
    drift = fixed_drifts(Stretches.of(motion), platform, np.zeros(1))[0]
    assert drift == pytest.approx(1 / (2 * 0.05 * w**2), rel=1e-4)


@pytest.mark.parametrize(
    "period", [0.5, *(pytest.param(t, marks=pytest.mark.slow) for t in NUMBERS if t != 0.5)]
)
def test_known_numbers(period: float) -> None:
    found = findings(FRICTIONS, suite(30), structure(period))
    for finding, value in zip(found, NUMBERS[period], strict=True):
        if value is not None:
            assert finding.arithmetic.value == pytest.approx(value, abs=0.01)


@pytest.mark.slow
def test_several_roots_are_all_listed() -> None:
    """At T 1 s and mu 0.3 hardly anything slides; 1.000 is the root that leads on from there."""
    (finding,) = findings([0.3], suite(30), structure(1.0))
    assert finding.arithmetic.roots == pytest.approx((0.948, 1.001, 1.026), abs=0.005)
    assert finding.arithmetic.value == pytest.approx(1.0, abs=0.002)


@pytest.mark.slow
def test_it_scatters_from_suite_to_suite() -> None:
    values = []
    for seed in (1, 2, 3):
        (finding,) = findings([0.1], find_motions([], None, count=30, seed=seed)[0])
        values.append(finding.arithmetic.value)
        if seed == 1:
            assert finding.geometric.value == pytest.approx(0.472, abs=0.01)
    assert sorted(v for v in values if v is not None) == pytest.approx(
        (0.137, 0.238, 0.265), abs=0.01
    )


def test_without_slip_everything_counts() -> None:
    (finding,) = findings([1e3], suite(6))
    assert finding.arithmetic.value == pytest.approx(1.0, abs=0.002)
    assert finding.drift_over_fixed == pytest.approx(1.0, abs=1e-12)
    assert finding.shear_over_fixed == pytest.approx(1.0, abs=1e-12)


def test_without_friction_nothing_counts() -> None:
    (finding,) = findings([1e-5], suite(6))
    assert finding.arithmetic.value == pytest.approx(0.0, abs=0.005)
    assert finding.drift_over_bare == pytest.approx(1.0, abs=1e-3)


def test_a_light_load_says_nothing() -> None:
    for finding in findings([0.05, 0.2], suite(6), structure(mass_ratio=1e-3)):
        assert finding.drift_over_bare == pytest.approx(1.0, abs=2e-3)
        assert finding.arithmetic.value is None
        assert finding.remark.startswith("not reported")


def test_sliding_is_homogeneous() -> None:
    """Friction and motion times a factor: lambda stays, drift grows by it."""
    factor = 1.7
    (one,) = findings([0.1], suite(5))
    (other,) = findings([factor * 0.1], suite(5, factor))
    # The ladders differ between infinity and mu, but not the roots nor where they lead.
    assert other.arithmetic.roots == pytest.approx(one.arithmetic.roots, rel=1e-9)
    assert other.arithmetic.value == pytest.approx(one.arithmetic.value, rel=1e-9)
    assert other.drift == pytest.approx(factor * one.drift, rel=1e-9)


def test_pga_is_no_axis_of_its_own() -> None:
    """Motions scaled to 1 g with mu are motions of any size with mu g/PGA."""
    (motion,) = suite(1)
    peak = synthetic_motion(table1_suite(1)[0]).peak
    (own,) = findings([0.4 * peak / 9.81], [motion])
    (scaled,) = findings([0.4], [motion], structure(unit_pga=True))
    assert scaled.drift == pytest.approx(own.drift * 9.81 / peak, rel=1e-9)
    assert scaled.arithmetic.roots == pytest.approx(own.arithmetic.roots, rel=1e-9)


def test_points_of_the_grid_are_near_enough() -> None:
    """What drifts straight between the points of the grid make of lambda in their middle."""
    stretches = [Stretches.of(synthetic_motion(spec)) for spec in table1_suite(10)]
    platform, points = structure().platform(), grid()[60:]
    middles = (points[1:] + points[:-1]) / 2
    found = np.mean([fixed_drifts(s, platform, 2 * points) for s in stretches], axis=0)
    exact = np.mean([fixed_drifts(s, platform, 2 * middles) for s in stretches], axis=0)
    error = np.interp(middles, points, found) - exact
    assert np.abs(error).max() < 1e-3 * np.ptp(found) / np.ptp(points) * 3
    assert np.sqrt(np.mean(error**2)) < 1e-3 * np.ptp(found) / np.ptp(points)


@pytest.mark.parametrize(
    ("count", "period", "frictions"),
    [
        (3, 0.5, "0.1"),
        pytest.param(10, 0.5, "0.1,0.2,0.3", marks=pytest.mark.slow),
        pytest.param(10, 0.25, "0.1,0.3", marks=pytest.mark.slow),
    ],
)
def test_rigid_blocks_agree(count: int, period: float, frictions: str) -> None:
    """The engine of rigid blocks in the steps of the map, under the same motions, within 0.003."""
    tables = tomllib.loads(SCENE.read_text())
    assert "step" not in tables["time"]
    scene = load_scene(SCENE)
    cells = cells_of(scene, chosen([f"period={period}", f"friction={frictions}"])).cells
    motions = suite(count)
    own, steps = cells[0].structure, ladder([cell.friction for cell in cells])
    tasks = closed_tasks({own: steps}, motions, tables, SCENE.parent, {})
    runs = {key: value for task in tasks for key, value in run_task(task)["runs"].items()}
    line = Line.of(own, steps, [content_of(motion) for motion in motions], runs)
    for cell in cells:
        several = block_tasks(cell, motions, tables, SCENE.parent, "rigid")
        outcomes = [next(iter(run_task(task)["runs"].values())) for task in several]
        rigid = line.finding_by(cell, "rigid blocks", outcomes)
        closed = line.finding(cell)
        assert rigid.arithmetic.value == pytest.approx(closed.arithmetic.value, abs=0.003)
        assert rigid.shear_over_fixed == pytest.approx(closed.shear_over_fixed, abs=2e-3)


LOCKED = SCENE.parents[1] / "inertia" / "locked_stack.toml"


@pytest.mark.slow
def test_a_locked_stack_rocks_as_its_equations_say() -> None:
    """Four containers in the steps of the map, against the Runge-Kutta integration."""
    tables, scene = tomllib.loads(LOCKED.read_text()), load_scene(LOCKED)
    (cell,) = cells_of(scene, chosen(["period=0.5"])).cells
    *_, motion = suite(12)
    (task,) = block_tasks(cell, [motion], tables, LOCKED.parent, "rigid")
    drift, _, slip, angle, fell = next(iter(run_task(task)["runs"].values()))
    (block,) = scene.blocks
    assert block.width / block.height < cell.friction  # it rocks before it slides
    assert (slip, fell) == (pytest.approx(0.0, abs=1e-9), 0.0)
    resolved, ground = scene_of(task.case)
    exact = reference_history(resolved, ground=ground)
    assert angle > math.radians(0.5)
    assert angle == pytest.approx(np.abs(exact["block.angle_rad"]).max(), rel=2e-3)
    assert drift == pytest.approx(np.abs(exact["platform.drift_m"]).max(), rel=1e-3)
