"""The table of columns: names, their order, rows of engines, what happens to one left out."""

from __future__ import annotations

import numpy as np
import pytest

from solver.history.block_columns import lean_in_space
from solver.history.columns import columns
from solver.history.engine_rows import rows_of
from solver.history.table import TABLE


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("platform", [False, True])
def test_each_owner_has_the_columns_of_its_part(dimension: int, platform: bool) -> None:
    """Part by part, and in it owner by owner, each in the order of the table."""
    owners = {"block": ["a", "b", "c"], "link": ["wire", "wax"], "foot": ["b.foot_1", "b.foot_2"]}
    owners["storey"] = [f"foundation.storey_{k}" for k in (1, 2)] * platform
    owners["column"] = [f"foundation.column_{k}" for k in (1, 2, 3)] * platform
    names = columns(
        owners["block"],
        dimension=dimension,
        platform=platform,
        vertical=True,
        second=dimension == 3,
        structure=(2, 3) if platform else None,
        links={"wire": True, "wax": True},
        feet={"b": 2},
    )
    parts = ("run", "block", "platform", "energy", "foundation", "storey", "column")
    expected = []
    for part in (*parts, "link", "foot"):
        if part in ("platform", "foundation") and not platform:
            continue
        own = [c.name for c in TABLE if c.part == part and c.dimension in (None, dimension)]
        for owner in owners.get(part, [""]):
            first = [name.partition(".")[0] if owner else "" for name in own]
            expected += [
                name.replace(word, owner, 1) for name, word in zip(own, first, strict=True)
            ]
    assert names == tuple(expected)


def test_an_axial_link_has_no_columns_of_shear() -> None:
    names = columns(["a"], dimension=3, links={"wire": False, "wax": True})
    axial = ["force_N", "extension_m", "state"]
    shear = ["shear_force_N", "shear_force_second_N"]
    assert names[-8:] == (
        *(f"wire.{name}" for name in axial),
        *(f"wax.{name}" for name in (axial[0], *shear, *axial[1:])),
    )


def test_every_name_ends_with_its_unit() -> None:
    ends = {"m": "_m", "m/s": "_m_s", "m/s²": "_m_s2", "rad": "_rad", "rad/s": "_rad_s"}
    ends |= {"N": "_N", "J": "_J", "s": "_s", "-": "", "N m": "_Nm"}
    for column in TABLE:
        assert column.name.endswith(ends[column.unit])
        assert column.meaning.endswith(".")


def test_rows_have_the_columns_of_a_scene_and_no_others() -> None:
    """A column that the engine has no value for is named; one value stands for all steps."""
    known = {"time": np.array([1.0, 2.0]), "step": 0.5, "slip": np.array([0.0, np.nan])}
    np.testing.assert_array_equal(
        rows_of(["slip", "time", "step"], known, 2), [[0.0, 1.0, 0.5], [np.nan, 2.0, 0.5]]
    )
    with pytest.raises(KeyError, match="gap"):
        rows_of(["time", "gap"], known, 2)


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
