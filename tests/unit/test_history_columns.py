"""The table of columns: names, places in the rows of engines, what happens to one left out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rockslip import Scene, parse_scene
from solver.history.block_columns import lean_in_space
from solver.history.columns import Structure, check_filled, columns, positions, row_layout
from solver.history.table import TABLE
from solver.rigid.plane.system import PlaneSystem
from solver.rigid.space.system import SpaceSystem


def scene(dimension: int) -> Scene:
    blocks = [
        {"name": "a", "width": 1.0, "height": 0.5, "density": 2400.0, "model": "rigid"},
        {"name": "b", "width": 0.4, "height": 0.4, "density": 2400.0, "model": "rigid", "on": "a"},
    ]
    time = {"end": 0.1, "step": 1e-3}
    return parse_scene({"dimension": dimension, "block": blocks, "time": time})


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("platform", [False, True])
def test_parts_of_a_row_lie_where_the_names_are(dimension: int, platform: bool) -> None:
    """Every name of a row is reached by its part and its field, and no other."""
    blocks = ["a", "b", "c"]
    names = columns(
        blocks,
        dimension=dimension,
        platform=platform,
        vertical=True,
        second=dimension == 3,
        structure=Structure(storeys=2, columns=3) if platform else None,
    )
    layout = row_layout(3, dimension=dimension, platform=platform)
    storeys = layout.foundation + len(positions("foundation", dimension))
    feet = storeys + 2 * len(positions("storey", dimension))
    assert layout.stride == len(positions("block", dimension))
    starts = {"run": [0], "platform": [layout.platform] * platform, "energy": [layout.energy]}
    starts["foundation"] = [layout.foundation] * platform
    starts["storey"] = [
        storeys + len(positions("storey", dimension)) * k for k in range(2 * platform)
    ]
    starts["column"] = [feet + len(positions("column", dimension)) * k for k in range(3 * platform)]
    starts["block"] = [layout.block + layout.stride * b for b in range(3)]
    found = {}
    for column in TABLE:
        if column.dimension not in (None, dimension):
            continue
        place = getattr(positions(column.part, dimension), column.field)
        for number, start in enumerate(starts[column.part]):
            name = column.name.replace("NAME", blocks[number])
            name = name.replace("STOREY", f"foundation.storey_{number + 1}")
            found[start + place] = name.replace("COLUMN", f"foundation.column_{number + 1}")
    assert tuple(found[k] for k in sorted(found)) == names


def test_every_name_ends_with_its_unit() -> None:
    ends = {"m": "_m", "m/s": "_m_s", "m/s²": "_m_s2", "rad": "_rad", "rad/s": "_rad_s"}
    ends |= {"N": "_N", "J": "_J", "s": "_s", "-": "", "N m": "_Nm"}
    for column in TABLE:
        assert column.name.endswith(ends[column.unit])
        assert column.meaning.endswith(".")


def test_columns_that_are_nan_throughout_are_named() -> None:
    """A number that is none in some row is a result; no rows are no columns left out."""
    rows = np.array([[0.0, np.nan, np.nan], [1.0, np.nan, 2.0]])
    with pytest.raises(ValueError, match=r"no value for the columns slip$"):
        check_filled(["time", "slip", "gap"], rows)
    check_filled(["time", "slip", "gap"], rows[:0])


@pytest.mark.parametrize(
    ("dimension", "system", "engine"),
    [(2, PlaneSystem, "plane.system.advance"), (3, SpaceSystem, "space.system.run")],
)
def test_a_rigid_engine_that_leaves_a_column_out_is_noticed(
    dimension: int, system: Any, engine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By its name, in the first rows already."""
    given = system.from_scene(scene(dimension))

    def forgets(*arguments: Any) -> tuple[int, int]:
        rows = arguments[-1]
        rows[:] = 0.0
        rows[:, given.columns.index("b.slip_m")] = np.nan
        return len(rows), 0

    monkeypatch.setattr(f"solver.rigid.{engine}", forgets)
    with pytest.raises(ValueError, match=r"no value for the columns b\.slip_m$"):
        given.advance(3, 1e-3)


def test_so_is_a_meshed_engine_that_does() -> None:
    from solver.build.assembly import build, initial_state
    from solver.history.history import scene_columns
    from solver.run.observer import Observer
    from solver.stepping.state import Exchange

    tables = scene(2).to_dict()
    tables["block"][0] |= {"model": "elastic", "young": 1e9, "poisson": 0.2, "cells": [2, 1]}
    given = parse_scene(tables)
    assembly = build(given)
    state, _ = initial_state(given, assembly)
    observer = Observer(assembly, state, scene_columns(given))
    forgetful: Any = observer._blocks[1]
    write, at = forgetful.write, positions("block", 2)

    def forgets(state: Any, links: Any, row: Any) -> None:
        write(state, links, row)
        row[[at.angle_rad, at.angular_velocity_rad_s, at.centre_x_m, at.centre_y_m]] = np.nan

    forgetful.write = forgets
    names = r"b\.angle_rad, b\.angular_velocity_rad_s, b\.centre_x_m, b\.centre_y_m"
    with pytest.raises(ValueError, match=f"no value for the columns {names}$"):
        observer.row(state, Exchange(), 1e-3)


def test_a_lean_is_carried_on_beyond_half_a_turn() -> None:
    angles = np.linspace(0.0, 9.0, 30)
    leans = [0.0]
    for angle in angles[1:]:
        turn = np.eye(3)
        turn[::2, ::2] = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
        leans.append(lean_in_space(turn, leans[-1]))
    assert leans == pytest.approx(angles)


def test_the_lean_of_a_block_turned_about_the_vertical_is_that_of_its_upright_axis() -> None:
    """A quarter turn about z, then 0.2 rad about y: the axis leans to +x by 0.2 rad."""
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    c, s = np.cos(0.2), np.sin(0.2)
    lean = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    assert lean_in_space(lean @ quarter, 0.0) == pytest.approx(0.2)
    # About its own axis y, which points to -x then, it leans to +y: not about +y in space.
    assert lean_in_space(quarter @ lean, 0.0) == pytest.approx(0.0, abs=1e-15)
