"""Compliance, factorizations and memory of large bodies."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from mpi4py import MPI

from benchmarks import scaling
from rockslip import parse_scene, simulate
from solver.bodies import factorization, memory
from solver.bodies.elastic_body import ElasticBody
from solver.build.assembly import build
from solver.cli import main
from solver.scene import scene_to_toml
from solver.stepping import compliance as compliance_of_bodies
from solver.stepping import contact_solve
from solver.stepping.response import ElasticResponse
from solver.stepping.system import response_of

BLOCK = {"width": 1.0, "height": 1.0, "mass": 1000.0, "young": 5e8, "poisson": 0.2, "cells": [5, 4]}
SPACE = BLOCK | {"thickness": 0.8, "cells": [4, 3, 3]}
LYING = {"kind": "half_sine", "amplitude_g": 0.7, "duration": 0.1}


def scene_of(block: dict[str, object], **contact: object) -> dict[str, object]:
    """A block that is pushed."""
    return {
        "dimension": 3 if "thickness" in block else 2,
        "block": [block],
        "contact": {"friction": 0.4} | contact,
        "motion": LYING,
        "time": {"end": 0.03, "step": 1e-3},
    }


def response(scene: dict[str, object], *, mass: bool = False) -> ElasticResponse:
    """The response of the block of a scene in a step, or that of its mass."""
    stepper = build(parse_scene(scene), comm=MPI.COMM_SELF).stepper
    stepper.start(np.zeros(stepper.system.size), np.zeros(stepper.system.size))
    body = stepper.system.bodies[0]
    assert isinstance(body, ElasticBody)
    weights = body.weights(stepper.scheme, 1e-3)
    if mass:
        inverse = factorization.MassInverse(body.mass_matrix, body.fixed, body.dimension)
        made = response_of(stepper.system, 0, stepper.links, inverse)
    else:
        factor = body.factorization(weights)
        made = response_of(stepper.system, 0, stepper.links, factor, weights)
    assert isinstance(made, ElasticResponse)
    return made


def whole_rows(made: ElasticResponse, *, forces: bool) -> np.ndarray:
    """Rows of all ports on all unknowns, dense."""
    parts = []
    for port in made.compliance.ports:
        rows = (port.force_rows if forces else port.read_rows).toarray()
        d = made.body.dimension
        spread = np.zeros((len(rows), made.body.owned, d))
        spread[:, port.layer.index] = rows.reshape(len(rows), -1, d)
        parts.append(spread.reshape(len(rows), -1))
    return np.vstack(parts)


@pytest.mark.parametrize("kept", [True, False])
@pytest.mark.parametrize("mass", [False, True])
@pytest.mark.parametrize("block", [BLOCK, SPACE])
@pytest.mark.parametrize("contact", [{}, {"theta": -1, "gamma": 20000}, {"points": "gauss"}])
def test_the_compliance_is_that_of_dense_matrices(
    block: dict[str, object],
    contact: dict[str, object],
    mass: bool,
    kept: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """G K^-1 G^T, made in two portions, of ports in any order; and what forces do.

    The latter from columns that are kept, and by back substitutions.
    """
    made = response(scene_of(block, **contact), mass=mass)
    monkeypatch.setattr(compliance_of_bodies, "SMALL", 0.0)
    monkeypatch.setattr(made.compliance.factor, "nbytes", 1e9 if kept else 0.0)
    compliance, body, d = made.compliance, made.body, made.body.dimension
    if mass:
        K = body.mass_matrix.copy()
    else:
        K = compliance.factor.matrix.copy()
    dense = K.convert("dense").getDenseArray()
    count, rng = compliance.ports[0].count, np.random.default_rng(0)
    first = np.sort(rng.choice(count, count // 3, replace=False))
    both = np.sort(rng.choice(count, 2 * count // 3, replace=False))
    G, R = (whole_rows(made, forces=forces) for forces in (True, False))
    exact = R @ np.linalg.solve(dense, G.T)
    compliance.among(first)
    for chosen in (both, first):
        rows = (chosen[:, None] * d + np.arange(d)).ravel()
        matrix = compliance.among(chosen)
        np.testing.assert_allclose(
            matrix, exact[np.ix_(rows, rows)], rtol=0, atol=1e-11 * np.abs(exact).max()
        )
        if compliance.ports[0].symmetric:
            assert (matrix == matrix.T).all()
        force = rng.standard_normal((len(chosen), d))
        moved = np.linalg.solve(dense, G[rows].T @ force.ravel())
        found = compliance.displacement(chosen, force)
        np.testing.assert_allclose(found, moved, rtol=0, atol=1e-11 * np.abs(moved).max())
    assert compliance.kept == (len(np.union1d(first, both)) if kept else 0)


def test_columns_are_kept_while_they_take_no_more_than_the_factor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What forces on others do is a back substitution; a resumed run has the same digits."""
    monkeypatch.setattr(compliance_of_bodies, "SMALL", 0.0)
    made, again = response(scene_of(SPACE)).compliance, response(scene_of(SPACE)).compliance
    count, force = made.ports[0].count, np.ones((2, 3))
    for compliance in (made, again):
        monkeypatch.setattr(compliance.factor, "nbytes", 8.0 * 6 * 3 * made.body.unknowns)
    made.among(np.arange(2))
    made.among(np.array([1, 2, 5, 7]))
    again.repeat(made.batches)
    assert made.kept == 5
    kept = made.displacement(np.array([2, 5]), force)
    assert (again.displacement(np.array([2, 5]), force) == kept).all()
    known = np.array([1, 2, 5, 7])
    assert (again.among(known) == made.among(known)).all()
    made.among(np.arange(count))
    assert made.kept == 5
    further = np.array([2, 5, 6])
    force = np.vstack([force, np.zeros(3)])
    assert (made.displacement(further, force) == kept).all()
    monkeypatch.setattr(compliance_of_bodies.Compliance, "kept", 0)
    solved = made.displacement(further, force)
    np.testing.assert_allclose(solved, kept, rtol=1e-9, atol=1e-12 * np.abs(kept).max())


def histories(scene: dict[str, object]) -> dict[str, np.ndarray]:
    """Places and angles of a run, and the summary's costs."""
    result = simulate(parse_scene(scene))
    assert result.status == "completed", result.summary["reason"]
    names = [name for name in result.history.columns if name.endswith(("_m", "_rad"))]
    return {name: np.asarray(result.history[name]) for name in names} | {
        "cost": result.summary["cost"]
    }


def test_where_few_factors_are_kept_the_history_is_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = scene_of(SPACE | {"tilt_deg": 0.3}) | {"time": {"end": 0.06, "step": 2e-3}}
    plain = histories(scene)
    assert plain["cost"]["linear_solvers"] == ["CHOLMOD"]
    monkeypatch.setattr(contact_solve, "kept_limit", lambda comm: 0.0)
    dropped = histories(scene)
    assert dropped["cost"]["factorizations"] > plain["cost"]["factorizations"] == 2
    for name in plain.keys() - {"cost"}:
        np.testing.assert_allclose(dropped[name], plain[name], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("free", "what"),
    [
        (0.0, "the factor of 240 unknowns"),
        (2.6e5, "the compliance of 20 contact points"),
    ],
)
def test_what_does_not_fit_into_memory_is_refused_in_one_line(
    free: float,
    what: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(scene_to_toml(parse_scene(scene_of(SPACE))))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(memory, "SMALL", 0.0)
    monkeypatch.setattr(memory, "LEFT_PART", 0.0)
    monkeypatch.setattr(memory, "COPIES", 100)
    monkeypatch.setattr(memory, "free_memory", lambda: free)
    assert main(["run", "scene.toml"]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if "memory" in line]
    assert len(lines) == 1
    assert f"block: {what} takes" in lines[0]
    assert "use larger cells" in lines[0]
    for summary in tmp_path.glob("*/summary.json"):
        assert json.loads(summary.read_text())["status"] != "completed"


def test_check_says_the_solver_and_the_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(scene_to_toml(parse_scene(scene_of(SPACE | {"cells": [31, 31, 31]}))))
    monkeypatch.setattr(memory, "total_memory", lambda: 16e9)
    assert main(["check", str(file)]) == 0
    text = capsys.readouterr().out
    assert "CHOLMOD (MUMPS on ranks), 726 MB for each step size and rho_inf" in text
    assert "1.1 GB for 1024 points on its bottom" in text


def test_info_says_the_linear_solver(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info"]) == 0
    assert "million unknowns in 3-D" in capsys.readouterr().out


def test_the_benchmark_of_scaling_has_a_row_for_every_case() -> None:
    for cells, motion, _, _ in scaling.CASES:
        assert parse_scene(scaling.scene_of(cells, motion)).blocks[0].cells == cells
    row = scaling.run_case((4, 6), "rocks")
    assert row["unknowns"] == 70
    assert float(row["factorizations_s"]) > 0
