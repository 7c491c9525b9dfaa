"""Foundations reduced to some nodes and modes: the same motion as that of their mesh."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np
import pytest
import pyvista
from ledger import completed

from rockslip import Scene, parse_scene, simulate
from solver.bodies.craig_bampton import MOST_LEFT_OUT, FixedInterface, linearised
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.reduced_body import ReducedBody
from solver.build.foundation import foundation as built
from solver.errors import SceneError
from solver.scheme.generalized_alpha import GeneralizedAlpha

FRAME: dict[str, Any] = {
    "kind": "frame",
    "deck": {"width": 4.0, "height": 0.4},
    "column": {"width": 0.2},
    "storey": 3.0,
    "young": 3e10,
    "poisson": 0.2,
    "density": 2500.0,
    "damping_ratio": 0.05,
    "cells": {"bay": 6, "column": 1, "deck": 1, "storey": 8},
}

SMALL: dict[str, Any] = FRAME | {"cells": {"bay": 3, "column": 1, "deck": 1, "storey": 2}}
"""So few cells that all its modes can be kept."""

SLIDER: dict[str, Any] = {
    "width": 0.8,
    "height": 0.75,
    "mass": 2000.0,
    "young": 3e10,
    "poisson": 0.2,
    "cells": [4, 4],
}

RECORD: dict[str, Any] = {"kind": "synthetic", "magnitude": 6.5, "distance_km": 10.0, "seed": 3}

ALL = 10_000
"""More modes than any mesh here has."""


def scene(foundation: dict[str, Any], modes: int | str | None, end: float, **more: Any) -> Scene:
    """A block on a foundation, reduced or not."""
    if modes is not None:
        foundation = foundation | {"modes": modes}
    tables = {
        "block": [SLIDER | more.pop("block", {})],
        "plane": "stress",
        "foundation": foundation,
        "contact": {"friction": more.pop("friction", 0.15)},
        "time": {"end": end, "step": 2e-3},
    }
    return parse_scene(tables | more)


run = partial(completed, gain=math.inf, ledger=1e-8)


def histories(made: dict[Any, Scene]) -> dict[Any, Any]:
    """Histories by their keys."""
    return {key: run(case).history for key, case in made.items()}


def reduced(case: Scene) -> tuple[ReducedBody, ElasticBody]:
    """The reduced body of a scene and that of its mesh, on this rank alone."""
    body = built(case, 0, MPI.COMM_SELF).body
    assert isinstance(body, ReducedBody) and body.parts is not None
    return body, body.parts.mesh


@pytest.mark.slow
def test_peaks_of_a_reduced_frame_under_a_record() -> None:
    """Peak drift and base shear within 0.2 % of those of the mesh, while the block slides."""
    made = {modes: scene(FRAME, modes, 3.0, motion=RECORD) for modes in (None, "auto")}
    found = histories(made)
    assert np.abs(found[None]["block.slip_m"]).max() > 5e-3
    for column in ("platform.drift_m", "foundation.base_shear_N"):
        full, small = (np.abs(found[modes][column]).max() for modes in made)
        assert small == pytest.approx(full, rel=2e-3), column


@pytest.mark.slow
def test_all_modes_are_the_mesh() -> None:
    """Drift and base shear to 1e-8 of their peaks, for loads that strain nothing.

    About the equilibrium the mesh is linear but for strains squared, so the difference falls with
    the loads: extrapolated from a hundredth and a thousandth of them, round-off is left.
    """
    parts = {}
    for load in (1e-2, 1e-3):
        motion = {"kind": "sine", "amplitude_g": 0.1 * load, "period": 0.3}
        more = {"gravity": 9.81 * load, "motion": motion, "friction": 0.5}
        found = histories({modes: scene(SMALL, modes, 0.3, **more) for modes in (None, ALL)})
        for column in ("platform.drift_m", "foundation.base_shear_N"):
            full, small = (found[modes][column] for modes in (None, ALL))
            parts[load, column] = (small - full) / np.abs(full).max()
            assert np.abs(parts[load, column]).max() < 2e-5 * load
    for column in ("platform.drift_m", "foundation.base_shear_N"):
        limit = (10 * parts[1e-3, column] - parts[1e-2, column]) / 9
        assert np.abs(limit).max() < 1e-8, column


def test_all_modes_have_the_compliance_of_the_mesh() -> None:
    """Of the tangent of a step, linearised about the weight, for forces on the deck: to 1e-9."""
    body, mesh = reduced(scene(FRAME | {"damping_ratio": 0.0}, ALL, 1.0))
    weights = GeneralizedAlpha(0.8).weights(2e-3)
    deck = np.flatnonzero(np.abs(mesh.nodes[:, 1]) < 1e-9)
    nodes = np.flatnonzero(np.abs(body.nodes[: body.kept, 1]) < 1e-9)
    place = {tuple(np.round(mesh.nodes[node], 9)): node for node in deck}
    for node in nodes[:2]:
        push, own = np.zeros(mesh.size), np.zeros(body.size)
        same = place[tuple(np.round(body.nodes[node], 9))]
        push[2 * same : 2 * same + 2] = own[2 * node : 2 * node + 2] = 3.0, -1.0
        moved = mesh.factorization(weights).solve(push)
        ours = body.expanded(body.factorization(weights).solve(own))
        np.testing.assert_allclose(ours, moved, rtol=0, atol=1e-9 * np.abs(moved).max())


def test_modes_left_out_take_no_more_than_the_bound() -> None:
    """From the force on kept nodes that move harmonically together, at any frequency up to W."""
    case = scene(FRAME, None, 1.0)
    mesh = built(case, 0, MPI.COMM_SELF).body
    assert isinstance(mesh, ElasticBody)
    about = linearised(mesh, np.array(case.gravity_vector) @ mesh.directional_mass)
    nodes = mesh.nodes[:, 1]
    deck, feet = (np.flatnonzero(np.abs(nodes - level) < 1e-9) for level in (0.0, nodes.min()))
    touched, kept = (
        (of[:, None] * 2 + np.arange(2)).ravel() for of in (deck[:4], np.append(deck[:4], feet))
    )
    interface, bounds = FixedInterface(about, kept, touched, 2), []
    inner = interface.inner
    K, M = (matrix[inner][:, inner].toarray() for matrix in (about.stiffness, about.mass))
    moving = np.tile([1.0, 0.0], len(nodes))
    q = (about.mass @ moving)[inner]
    for highest in (20.0, 60.0, 150.0):
        W = 2 * math.pi * highest
        basis = interface.basis(None, W)
        bounds.append(basis.modes)
        assert basis.bound.part <= MOST_LEFT_OUT
        own = basis.shapes.T @ q
        for frequency in np.linspace(0.1, 1.0, 10) * W:
            exact = frequency**2 * float(q @ np.linalg.solve(K - frequency**2 * M, q))
            ours = frequency**2 * float(own @ (own / (basis.squared - frequency**2)))
            assert abs(ours - exact) <= basis.bound.part * mesh.mass * (1 + 1e-6)
    assert bounds == sorted(bounds) and bounds[-1] > bounds[0]


@pytest.mark.slow
def test_a_plate_on_rollers_and_a_frame_in_space() -> None:
    """Drift and slip within 0.1 % of their peaks, with "auto"."""
    stone = {"young": 5e10, "poisson": 0.2}
    plate = {"kind": "elastic", "width": 2.4, "height": 0.3, "mass_ratio": 2.0, **stone}
    plate |= {"support": "rollers", "period": 0.2, "damping_ratio": 0.05, "cells": [12, 2]}
    frame = {"kind": "frame", "deck": {"width": 2.4, "height": 0.3, "thickness": 2.0}, **stone}
    frame |= {"column": {"width": 0.2}, "storey": 2.5, "density": 2500.0, "degree": 1}
    frame |= {"cells": {"bay": 4, "column": 1, "deck": 1, "storey": 3}, "damping_ratio": 0.02}
    frame |= {"feet": {"vertical": 1e9}}
    space = {"dimension": 3, "block": {"thickness": 0.8, "height": 0.5, "cells": [4, 3, 2]}}
    motion = {"kind": "sine", "amplitude_g": 0.5, "period": 0.3}
    for foundation, more in ((plate, {}), (frame, space)):
        made = {}
        for modes in (None, "auto"):
            tables = {"motion": motion, "plane": "stress"} | more
            if "dimension" in tables:
                del tables["plane"]
            made[modes] = scene_of(foundation, modes, tables)
        found = histories(made)
        for column in ("platform.drift_m", "block.slip_m", "foundation.base_shear_N"):
            full, small = (found[modes][column] for modes in made)
            atol = (5e-3 if column.endswith("_N") else 1e-3) * np.abs(full).max()
            np.testing.assert_allclose(small, full, rtol=0, atol=atol)


def scene_of(foundation: dict[str, Any], modes: Any, tables: dict[str, Any]) -> Scene:
    """A scene of any dimension, 0.4 s long."""
    given = foundation if modes is None else foundation | {"modes": modes}
    whole = {"contact": {"friction": 0.2}, "time": {"end": 0.4, "step": 2e-3}} | tables
    return parse_scene(whole | {"block": [SLIDER | tables.get("block", {})], "foundation": given})


def test_fields_are_those_of_the_mesh(tmp_path: Path) -> None:
    """Displacements on all nodes: none at the feet, at the deck the drift of the history."""
    import pyvista

    case = scene(SMALL, 4, 0.1, motion=RECORD, output={"every": 0.05})
    history = simulate(case, folder=tmp_path / "run").history
    data = pyvista.read(tmp_path / "run" / "fields" / "fields_frame000002.vtu")
    level, moved = data.points[:, 1], data["displacement"]
    deck, columns = 11 * 3, 2 * 3 * 4
    assert len(np.unique(np.round(data.points, 9), axis=0)) == deck + columns
    assert np.abs(moved[level == level.min()]).max() == 0.0
    _, first = np.unique(np.round(data.points[:, 0] + 100 * level, 9), return_index=True)
    top = first[np.isclose(level[first], 0.0)]
    drift = history["platform.drift_m"][-1]
    assert moved[top, 0].mean() == pytest.approx(drift, rel=1e-6)


@pytest.mark.parametrize(
    ("foundation", "modes", "words"),
    [
        (FRAME, 0, r"foundation\.modes: got 0, allowed a whole number, modes >= 1 or \"auto\""),
        (FRAME, 2.5, r"foundation\.modes: got 2\.5, allowed a whole number"),
        ({"kind": "rigid"}, "auto", r"foundation\.modes"),
        ({"kind": "oscillator", "mass_ratio": 1.0, "period": 0.5}, 4, r"foundation\.modes"),
        (
            {"kind": "elastic", "width": 2.0, "height": 0.2, "mass": 1e3, "young": 3e10}
            | {"poisson": 0.2},
            4,
            r"foundation\.modes applies to a plate that is not held everywhere",
        ),
    ],
)
def test_what_cannot_be_reduced_is_refused(
    foundation: dict[str, Any], modes: int | str, words: str
) -> None:
    """In one line."""
    with pytest.raises(SceneError, match=words) as refused:
        scene(foundation, modes, 1.0)
    assert "\n" not in str(refused.value)
    assert refused.value.exit_code == 2


@pytest.mark.slow
def test_stress_of_a_frame_that_sways(tmp_path: Path) -> None:
    """Feet of columns carry in the fields what those of the whole mesh do, however far it sways.

    The squares of rotations, which a linear body does not mean, would count as strains.
    """
    tall = FRAME | {"storey": 6.0, "young": 1.0e10}
    motion = {"kind": "half_sine", "amplitude_g": 0.25, "duration": 0.5}
    carried = {}
    for modes in (None, "auto"):
        case = scene(tall, modes, 0.5, motion=motion, output={"every": 0.25})
        result = simulate(case, folder=tmp_path / str(modes))
        assert np.abs(result.history["platform.drift_m"]).max() > 0.005 * 6.0
        reader = pyvista.get_reader(tmp_path / str(modes) / "fields.pvd")
        reader.set_active_time_value(0.5)
        (mesh,) = (
            part
            for part in reader.read()
            if "stress" in part.cell_data and np.ptp(part.points[:, 1]) > 3.0
        )
        middles = mesh.cell_centers().points
        feet = np.abs(middles[:, 1] - middles[:, 1].min()) < 1e-6
        areas = mesh.compute_cell_sizes(length=False, volume=False)["Area"][feet]
        upright = mesh.cell_data["stress"].reshape(-1, 3, 3)[feet, 1, 1]
        assert len(upright) == 2
        carried[modes] = upright * areas
    np.testing.assert_allclose(carried["auto"], carried[None], rtol=0.03)
