"""Pulses that overturn blocks: thresholds by engine, equation and closed form; similarity."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest
from overturning import housner_fate

from rockslip import parse_scene, simulate
from solver.cli import main
from solver.reference import pulses
from solver.study.overturning.blocks import PULSES, RigidUnderPulses
from solver.study.overturning.boundaries import (
    DIRECTLY,
    LATER,
    STAYS,
    Boundary,
    Response,
    boundaries,
    near,
)
from solver.study.overturning.cases import OverturningCase, scan
from solver.study.scenes import Tables, standing_block, variant

pytestmark = pytest.mark.serial

SCENE = Path(__file__).parents[2] / "demos" / "overturning" / "scene.toml"

#: omega/p, and thresholds of the paper's block without an impact, over g tan alpha (Housner's
#: equation, and of a slender block in closed form).
HALF_SINE = ((1, 1.3213, 1.3224), (2, 1.8015, 1.8007), (3, 2.2973, 2.2939), (4, 2.7973, 2.7908),
             (5, 3.2989, 3.2891), (6, 3.8013, 3.7882), (8, 4.8073, 4.7871))  # fmt: skip

AMPLITUDES = scan(1.0, 12.0, 48)


@pytest.fixture(scope="module")
def tables() -> Tables:
    return standing_block(argparse.Namespace(scene=SCENE, overrides=[]))


def found(
    tables: Tables, pulse: str, frequency: float, restitution: float | None = None
) -> list[tuple[float, str, str]]:
    case = OverturningCase(
        engine="rigid", pulse=pulse, frequency=frequency, restitution=restitution,
        tables=tables, amplitudes=AMPLITUDES,
    )  # fmt: skip
    row = case.run()
    return [(edge["amplitude"], edge["below"], edge["above"]) for edge in row["boundaries"]]


def test_closed_forms() -> None:
    """Thresholds of slender blocks, as the literature has them."""
    for s, _, linear in HALF_SINE:
        assert pulses.half_sine_threshold(s) == pytest.approx(linear, abs=6e-5)
    sines = [pulses.one_sine_threshold(s) for s in (1, 2, 3, 4, 5, 6)]
    assert sines == pytest.approx([1.418, 2.350, 3.631, 5.239, 7.168, 9.417], abs=6e-4)


@pytest.mark.parametrize(("frequency", "threshold", "linear"), HALF_SINE)
def test_half_sines_without_an_impact(
    tables: Tables, frequency: float, threshold: float, linear: float
) -> None:
    ((amplitude, below, above),) = found(tables, "half_sine", frequency)
    assert (below, above) == (STAYS, DIRECTLY)
    assert amplitude == pytest.approx(threshold, rel=5e-5)
    assert amplitude == pytest.approx(linear, rel=0.005)


@pytest.mark.slow
@pytest.mark.parametrize(("frequency", "restitution"), [(1, None), (3, None), (6, 0.936)])
def test_both_modes_of_one_sine_and_the_island(
    tables: Tables, frequency: float, restitution: float | None
) -> None:
    """After an impact, safe again, without one: the engine and Housner's equation within 0.02 %."""
    edges = found(tables, "one_sine", frequency, restitution)
    assert [edge[1:] for edge in edges[-3:]] == [(STAYS, LATER), (LATER, STAYS), (STAYS, DIRECTLY)]
    scene = variant(tables, model="rigid", restitution=restitution)
    fate = partial(housner_fate, scene, PULSES["one_sine"], frequency)
    for rigid, below, above in edges[-3:]:
        ends = near(fate, rigid, below, above, 5e-5)
        assert ends is not None
        assert rigid == pytest.approx(sum(ends) / 2, rel=2e-4)
    linear = pulses.one_sine_threshold(frequency)
    assert edges[-1][0] == pytest.approx(linear, rel=0.035)


def test_restitution_matters_after_an_impact_only(tables: Tables) -> None:
    """One sine, omega/p 6: 4.57 with Housner's e, 4.15 with 0.936; 9.699 with either."""
    housners, measured = (found(tables, "one_sine", 6.0, e) for e in (None, 0.936))
    assert housners[0][0] == pytest.approx(4.574, abs=2e-3)
    assert measured[0][0] == pytest.approx(4.153, abs=2e-3)
    assert housners[-1][0] == pytest.approx(measured[-1][0], rel=2e-5) == pytest.approx(9.699, 1e-4)


@pytest.mark.parametrize("pulse", PULSES)
def test_rigid_blocks_of_four_times_the_size_are_similar(tables: Tables, pulse: str) -> None:
    """Same alpha and e, H times 4: fates and thresholds are the same to 1e-9."""
    own = variant(tables, model="rigid", restitution=0.93)
    sizes = {"width": 1.0, "height": 4.0, "thickness": 3.0, "mass": None, "density": 2682.7}
    large = variant(tables, model="rigid", restitution=0.93, **sizes)
    one, other = (RigidUnderPulses(scene, PULSES[pulse], 3.0) for scene in (own, large))
    for amplitude in (1.3, 2.5, 3.4, 5.0):
        small, big = one(amplitude), other(amplitude)
        assert (small.overturns, small.impacts) == (big.overturns, big.impacts)
        assert small.margin == pytest.approx(big.margin, rel=1e-9, abs=1e-9)
    near_it = (2.0, 2.3, 2.6)
    edges = [boundaries(respond, near_it, 1e-11) for respond in (one, other)]
    assert [e.amplitude for e in edges[0]] == pytest.approx(
        [e.amplitude for e in edges[1]], rel=1e-9
    )


@pytest.mark.slow
def test_elastic_blocks_of_four_times_the_size_are_similar(tables: Tables) -> None:
    """H and E times 4, steps and beta_R times 2: the angle over p t is the same to 1e-6 of alpha.

    Steps are fixed: those chosen from an error differ by a factor that is none of two.
    """
    angles = []
    for size, slow in ((1, 1), (4, 2)):
        block = {"width": 0.25 * size, "height": 1.0 * size, "thickness": 0.75 * size}
        block |= {"density": 2670.0, "young": 5e9 * size, "poisson": 0.2, "cells": [4, 8]}
        motion = {"kind": "one_sine", "duration": 0.5 * slow, "amplitude_g": 0.5}
        scene = parse_scene({
            "block": [block], "contact": {"friction": 3.0}, "motion": motion,
            "damping": {"stiffness": 3e-5 * slow},
            "time": {"step": 5e-4 * slow, "end": 0.75 * slow},
        })  # fmt: skip
        history = simulate(scene, comm=MPI.COMM_SELF).history
        angles.append(history["block.angle_rad"] / scene.blocks[0].shape.slenderness())
    assert np.abs(angles[0]).max() > 0.2
    assert np.abs(angles[0] - angles[1]).max() < 1e-6


@pytest.mark.slow
def test_the_elastic_block_overturns_where_the_rigid_one_does(tables: Tables) -> None:
    """Half a sine, omega/p 4, without an impact: 1 % below and above the rigid threshold."""
    case = OverturningCase(
        engine="elastic", pulse="half_sine", frequency=4.0, restitution=None,
        tables=tables, rigid=((2.7973, STAYS, DIRECTLY),),
    )  # fmt: skip
    (edge,) = case.run()["boundaries"]
    assert edge["amplitude"] == pytest.approx(2.7973, rel=0.01)


def fates(*edges: tuple[float, int]) -> Callable[[float], Response]:
    """A block whose fate changes at some amplitudes; each with impacts above, -1: it stays."""

    def respond(amplitude: float) -> Response:
        passed = [impacts for edge, impacts in edges if amplitude > edge]
        impacts = passed[-1] if passed else -1
        distance = min((abs(amplitude - edge) for edge, _ in edges), default=1.0)
        overturns = impacts >= 0
        return Response(overturns, max(impacts, 0), distance if overturns else -distance)

    return respond


def test_all_intervals_are_found() -> None:
    """Also an interval between two samples, and a narrow one between two numbers of impacts."""
    grid = scan(1.0, 12.0, 48)
    edges = boundaries(fates((1.5, 1), (1.53, -1), (4.0, 3), (5.0, -1), (5.02, 1)), grid, 1e-6)
    assert [edge.amplitude for edge in edges] == pytest.approx(
        [1.5, 1.53, 4.0, 5.0, 5.02], rel=1e-6
    )
    assert edges[0] == Boundary(edges[0].amplitude, STAYS, LATER)
    assert boundaries(fates(), grid, 1e-6) == []


def test_boundaries_near_a_rigid_one() -> None:
    def up(at: float) -> Callable[[float], str]:
        return lambda a: DIRECTLY if a > at else STAYS

    low, high = near(up(2.03), 2.0, STAYS, DIRECTLY, 2e-3) or (0, 0)
    assert low < 2.03 < high and high - low <= 4e-3
    low, high = near(lambda a: LATER if a < 1.9 else STAYS, 2.0, LATER, STAYS, 2e-3) or (0, 0)
    assert low < 1.9 < high
    assert near(lambda a: STAYS, 2.0, STAYS, DIRECTLY, 2e-3) is None
    assert near(up(2.03), 2.0, STAYS, LATER, 2e-3) is None  # what another boundary leads to


@pytest.mark.slow
def test_the_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables and pictures; frequencies are added; a second call runs what is new only."""
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    words = ["study", "overturning", str(SCENE), "--pulses", "one_sine", "--amplitudes", "1:6:20"]
    words += ["-o", "out", "-j", "2", "-q", "--rounds", "1"]
    assert main([*words, "--frequencies", "2,3,4,5"]) == 0
    folder = tmp_path / "out"
    cases = {file.name: file.stat().st_mtime_ns for file in (folder / "cases").iterdir()}
    assert "rigid,one_sine,frequency=4.5.json" in cases  # above it, no overturning without impact
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["completed"] == summary["cases"] == len(cases)
    assert (folder / "overturning.png").stat().st_size > 20_000
    again = ["--resume", "--frequencies", "4", "--restitution", "0.9,0.94"]
    assert main([*words, *again]) == 0
    assert (folder / "restitution.png").stat().st_size > 10_000
    later = {file.name: file.stat().st_mtime_ns for file in (folder / "cases").iterdir()}
    assert {name: later[name] for name in cases} == cases
    assert len(later) == len(cases) + 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--pulses", "sine"], '--pulses: got "sine"'),
        (["--amplitudes", "1,2"], "--amplitudes: got 1,2, allowed LOW:HIGH:COUNT"),
        (["--restitution", "1.2"], "--restitution: got 1.2, allowed 0 < e <= 1"),
        (["--rounds", "-1"], "--rounds: got -1"),
        (["--set", "block.tilt_deg=1"], "block: got a block that is tilted or moves"),
    ],
)
def test_what_is_refused(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", "overturning", str(SCENE), "-o", str(tmp_path / "out"), *words]) == 2
    assert said in capsys.readouterr().err
