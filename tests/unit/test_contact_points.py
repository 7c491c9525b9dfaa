"""Forces between bodies in the files of the fields: a point for each pair that presses."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rockslip import parse_scene, read_run, simulate
from solver.errors import SceneError
from solver.history.pairs import force_on_first
from solver.pictures.meshes import FieldFiles
from solver.scene import Scene

pyvista = pytest.importorskip("pyvista")

GRAVITY = 9.81


def scene(dimension: int, low: dict[str, Any], up: dict[str, Any], **tables: Any) -> Scene:
    """A block on another one."""
    sides = {"thickness": 0.4, "model": "rigid"}
    blocks = [
        {"name": "low", "width": 0.5, "height": 1.0, "mass": 100.0} | sides | low,
        {"name": "up", "width": 0.3, "height": 0.4, "mass": 50.0} | sides | up,
    ]
    if "position" not in up:
        blocks[1]["on"] = "low"
    time = {"end": 0.1, "step": 1e-3} | tables.pop("time", {})
    output = {"every": 0.02} | tables.pop("output", {})
    return parse_scene(
        {"dimension": dimension, "block": blocks, "time": time, "output": output} | tables
    )


def points_in(folder: Path) -> Iterator[tuple[float, Any]]:
    """The points, which are the last part of scenes without links, and their times."""
    reader = pyvista.get_reader(str(folder / "fields.pvd"))
    assert "fields_contacts" in reader.datasets[-1].path
    for time in reader.time_values:
        reader.set_active_time_value(time)
        yield time, reader.read()[-1]


def force_on(body: int, points: Any) -> Any:
    """The force of all others on a body, N."""
    force, data = np.zeros(3), points.point_data
    for vector, own, other in zip(data["force"], data["body"], data["other"], strict=True):
        force += vector * ((own == body) - float(other == body))
    return force


@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_on_blocks_at_rest_are_their_weights(dimension: int, tmp_path: Path) -> None:
    """At all times, the first one included; each on the upper body, where that stands."""
    simulate(scene(dimension, {}, {}), folder=tmp_path)
    up = np.eye(3)[dimension - 1]
    found = list(points_in(tmp_path))
    assert len(found) == 6
    for _, points in found:
        assert sorted(zip(points["body"], points["other"], strict=True)) == [(0, 2), (1, 0)]
        for body, mass in ((0, 100.0), (1, 50.0)):
            np.testing.assert_allclose(
                force_on(body, points), mass * GRAVITY * up, atol=1e-9 * mass * GRAVITY
            )
        heights = dict(zip(points["body"], points.points[:, dimension - 1], strict=True))
        assert heights == pytest.approx({0: 0.0, 1: 1.0}, abs=1e-9)
        assert points["normal_force"] == pytest.approx(np.linalg.norm(points["force"], axis=1))
        assert points["friction_force"] == pytest.approx(0.0, abs=1e-6)
        assert not np.any(points["displacement"])
    assert FieldFiles(tmp_path / "fields.pvd").names == ["low", "up"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_nothing_presses_in_flight(dimension: int, tmp_path: Path) -> None:
    """A block that falls by 5 cm: no point before it lands, after some 0.1 s."""
    aloft = {"position": [0.0] * (dimension - 1) + [0.55]}
    beside = {"position": [3.0] + [0.0] * (dimension - 2) + [0.2]}
    simulate(scene(dimension, aloft, beside, time={"end": 0.3}), folder=tmp_path)
    for time, points in points_in(tmp_path):
        assert (0 in points["body"]) is bool(time > 0.101)
        assert 1 in points["body"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_are_those_of_the_pairs_also_where_a_run_goes_on(
    dimension: int, tmp_path: Path
) -> None:
    """A stack that slides and rocks, stopped and resumed."""
    motion = {"kind": "sine", "amplitude_g": 0.6, "period": 0.4, "cycles": 2}
    output = {"pairs": True, "checkpoint": {"steps": 100}}
    for end in (0.3, 0.6):
        given = scene(dimension, {}, {}, motion=motion, output=output, time={"end": end})
        simulate(given, folder=tmp_path, resume=end > 0.3)
    known = read_run(tmp_path).pairs()
    numbers = {"low": 0, "up": 1, "foundation": 2}
    found = list(points_in(tmp_path))
    assert len(found) == 31 and list((tmp_path / "fields").glob("fields_contacts-2*"))
    seen = 0
    for time, points in found:
        for names, columns in known.items():
            row = int(np.argmin(np.abs(columns["time_s"] - time)))
            force = force_on_first({name: values[[row]] for name, values in columns.items()})[0]
            if names == ("low", "up"):
                names, force = names[::-1], -force
            own = points["body"] == numbers[names[0]]
            assert np.count_nonzero(own) == np.any(force)
            for vector, normal in zip(
                points["force"][own], points["normal_force"][own], strict=True
            ):
                np.testing.assert_allclose(vector[:dimension], force, rtol=1e-9, atol=1e-9)
                assert normal == pytest.approx(columns["normal_N"][row], rel=1e-9)
                seen += 1
    assert seen > 40


def test_runs_tell_the_same_forces_without_a_file_of_pairs(tmp_path: Path) -> None:
    """They follow pairs in the last step before each snapshot alone."""
    motion = {"kind": "sine", "amplitude_g": 0.6, "period": 0.4, "cycles": 2}
    both = []
    for pairs in (True, False):
        given = scene(3, {}, {}, motion=motion, output={"pairs": pairs}, time={"end": 0.5})
        simulate(given, folder=tmp_path / str(pairs))
        both.append([(time, p["force"].tolist()) for time, p in points_in(tmp_path / str(pairs))])
    assert both[0] == both[1]


@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_between_meshed_and_rigid_blocks(dimension: int, tmp_path: Path) -> None:
    """At rest, once a step was taken."""
    pytest.importorskip("dolfinx")
    cells = {"young": 1e9, "poisson": 0.2, "cells": [2] * dimension, "model": "elastic"}
    simulate(scene(dimension, cells, {}, time={"end": 0.04}), folder=tmp_path)
    (_, first), *later = points_in(tmp_path)
    assert not first.n_points and len(later) == 2
    for _, points in later:
        for body, mass in ((0, 100.0), (1, 50.0)):
            force = mass * GRAVITY * np.eye(3)[dimension - 1]
            np.testing.assert_allclose(force_on(body, points), force, atol=1e-6 * mass * GRAVITY)


def test_no_block_is_called_as_the_points_are() -> None:
    with pytest.raises(SceneError, match="contacts"):
        scene(2, {}, {"name": "contacts"})
