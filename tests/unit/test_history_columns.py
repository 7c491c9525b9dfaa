"""The table of columns: names, places in the rows of engines, what happens to one left out."""

from __future__ import annotations

import numpy as np
import pytest

from solver.history.block_columns import lean_in_space
from solver.history.columns import Structure, check_filled, columns, positions, row_layout
from solver.history.table import TABLE


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
        links={"wire": True, "wax": True},
        feet={"b": 2},
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
    ends = feet + 3 * len(positions("column", dimension))
    ends = ends if platform else layout.foundation
    starts["link"] = [ends + len(positions("link", dimension)) * k for k in range(2)]
    legs = starts["link"][-1] + len(positions("link", dimension))
    starts["foot"] = [legs + len(positions("foot", dimension)) * k for k in range(2)]
    found = {}
    for column in TABLE:
        if column.dimension not in (None, dimension):
            continue
        place = getattr(positions(column.part, dimension), column.field)
        for number, start in enumerate(starts[column.part]):
            name = column.name.replace("NAME", blocks[number])
            name = name.replace("STOREY", f"foundation.storey_{number + 1}")
            name = name.replace("LINK", ["wire", "wax"][number % 2])
            name = name.replace("FOOT", f"b.foot_{number + 1}")
            found[start + place] = name.replace("COLUMN", f"foundation.column_{number + 1}")
    assert tuple(found[k] for k in sorted(found)) == names


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


def test_columns_that_are_nan_throughout_are_named() -> None:
    """A number that is none in some row is a result; no rows are no columns left out."""
    rows = np.array([[0.0, np.nan, np.nan], [1.0, np.nan, 2.0]])
    with pytest.raises(ValueError, match=r"no value for the columns slip$"):
        check_filled(["time", "slip", "gap"], rows)
    check_filled(["time", "slip", "gap"], rows[:0])


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
